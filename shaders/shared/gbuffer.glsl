// The G-buffer: 16 bytes of surface and 4 of depth a pixel.
//   x: unit normal, octahedral, 2 x snorm16
//   y: albedo (square roots, unorm8 x 3) and occlusion
//   z: perceptual roughness, metallic, flags, unused
//   w: emitted radiance with a shared exponent (9 bits a channel, 5 bits of exponent)

const float FLAG_UNLIT = 1.0;

struct Surface {
    vec3 normal;
    vec3 albedo;
    float occlusion;
    float roughness;
    float metallic;
    bool unlit;
    vec3 emissive;
};

// Both halves of the octahedron unfolded onto the square.
vec2 oct_encode(vec3 n) {
    vec2 p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-20);
    vec2 sign_of = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : (1.0 - abs(p.yx)) * sign_of;
}

vec3 oct_decode(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return normalize(n);
}

const int RGB9E5_BIAS = 15;
const int RGB9E5_BITS = 9;
const float RGB9E5_MAX = 65408.0; // 511/512 * 2^16

uint rgb9e5_encode(vec3 color) {
    vec3 c = clamp(color, vec3(0.0), vec3(RGB9E5_MAX));
    float most = max(max(c.x, c.y), max(c.z, 1e-9));
    int exponent = max(-RGB9E5_BIAS - 1, int(floor(log2(most)))) + 1 + RGB9E5_BIAS;
    float scale = exp2(float(RGB9E5_BITS + RGB9E5_BIAS - exponent));
    // Rounding up to 512 needs the next exponent.
    if (floor(most * scale + 0.5) > 511.0) {
        exponent += 1;
        scale *= 0.5;
    }
    uvec3 m = uvec3(floor(c * scale + 0.5));
    return m.x | (m.y << 9) | (m.z << 18) | (uint(clamp(exponent, 0, 31)) << 27);
}

vec3 rgb9e5_decode(uint packed) {
    float scale = exp2(float(int(packed >> 27) - RGB9E5_BIAS - RGB9E5_BITS));
    return vec3(packed & 511u, (packed >> 9) & 511u, (packed >> 18) & 511u) * scale;
}

uvec4 gbuffer_encode(Surface s) {
    return uvec4(
        packSnorm2x16(oct_encode(s.normal)),
        packUnorm4x8(vec4(sqrt(clamp(s.albedo, 0.0, 1.0)), s.occlusion)),
        packUnorm4x8(vec4(s.roughness, s.metallic, s.unlit ? FLAG_UNLIT : 0.0, 0.0)),
        rgb9e5_encode(s.emissive));
}

Surface gbuffer_decode(uvec4 g) {
    Surface s;
    s.normal = oct_decode(unpackSnorm2x16(g.x));
    vec4 a = unpackUnorm4x8(g.y);
    s.albedo = a.rgb * a.rgb;
    s.occlusion = a.a;
    vec4 b = unpackUnorm4x8(g.z);
    s.roughness = b.x;
    s.metallic = b.y;
    s.unlit = b.z > 0.5;
    s.emissive = rgb9e5_decode(g.w);
    return s;
}
