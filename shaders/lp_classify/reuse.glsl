// What the left eye has shaded, for a pixel of the right eye (VaFR, 2025, "reprojection"). Both G-buffers
// are rasterised, so what is hidden from the left eye is known exactly.
#include "shared/frame.glsl"
#include "shared/gbuffer.glsl"
layout(set = 0, binding = 6) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 7) uniform LeftFrame { FrameParams left_frame; };
layout(set = 0, binding = 8) uniform LeftFovea { FoveaParams left_fovea; };
struct ReuseParams {
    vec4 left_from_right; // xyz: from the left eye to the right one, world axes, metres
    float least_roughness;
    float greatest_metallic;
    float depth_tolerance; // relative
    float least_normal_cosine;
};
layout(set = 0, binding = 9) uniform Reuse { ReuseParams reuse; };
layout(set = 0, binding = 10) uniform utexture2D gbuffer;
layout(set = 0, binding = 11) uniform texture2D depth_buffer;
layout(set = 0, binding = 12) uniform utexture2D left_gbuffer;
layout(set = 0, binding = 13) uniform texture2D left_depth;
layout(set = 0, binding = 14) uniform texture2D left_radiance;
layout(set = 0, binding = 15, rgba16f) uniform writeonly image2D hdr;

// As `reach_px`: only what the left eye has shaded at full resolution will do.
const float NATIVE_ONLY = 0.0;

float left_depth_at(ivec2 px) {
    return texelFetch(left_depth, clamp(px, ivec2(0), ivec2(left_frame.size) - 1), 0).r;
}

// The left eye's picture is its pixels themselves here, and not interpolated from its LP-buffer: in all
// four pixels from `px` on, if in the one farthest from the gaze. The forward table is the same for both
// eyes: one method, and displays that are mirror images.
bool native_in_left_eye(ivec2 px) {
    fovea = left_fovea;
    vec2 first = vec2(px) + 0.5;
    vec2 farthest = first + vec2(greaterThan(first + 0.5, fovea.gaze_px.xy));
    LpLookup unused;
    bool result = mapping_forward(farthest, unused) <= 0.0;
    fovea = own_fovea;
    return result;
}

// No other surface begins as near as a texel: the picture, interpolated from texels, holds this surface
// only. Reversed depth is linear across the display on a plane, so that its values to both sides of the
// centre average to the centre's at any slope; they do not across an edge. Two rings of places: the outer
// one finds what begins before the farthest texel, the inner one what is thinner than a texel.
bool plane_around(ivec2 px, float reach_px, float depth) {
    for (float radius_px = reach_px; radius_px > 0.4 * reach_px; radius_px *= 0.5) {
        int along = int(ceil(radius_px));
        int diagonal = int(ceil(0.7071 * radius_px));
        ivec2 offsets[4] = ivec2[](
            ivec2(along, 0), ivec2(0, along), ivec2(diagonal, diagonal), ivec2(diagonal, -diagonal));
        for (int i = 0; i < 4; ++i) {
            float sum = left_depth_at(px + offsets[i]) + left_depth_at(px - offsets[i]);
            if (abs(sum - 2.0 * depth) > 2.0 * reuse.depth_tolerance * depth) {
                return false;
            }
        }
    }
    return true;
}

vec4 mix4(vec4 a, vec4 b, vec4 c, vec4 d, vec2 f) {
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// The radiance of a pixel, where the left eye sees the same point of a surface that looks the same from
// both eyes. `reach_px`: a texel's reach, or NATIVE_ONLY.
bool radiance_of_left_eye(ivec2 px, float reach_px, out vec3 radiance) {
    radiance = vec3(0.0);
    float depth = texelFetch(depth_buffer, px, 0).r;
    if (depth <= 0.0) {
        return false; // the sky: cheaper to shade than to find
    }
    Surface surface = gbuffer_decode(texelFetch(gbuffer, px, 0));
    bool glossy = surface.roughness < reuse.least_roughness || surface.metallic > reuse.greatest_metallic;
    if (glossy && !surface.unlit) {
        return false;
    }
    vec2 centre = vec2(px) + 0.5;
    vec3 ray = frame.ray_base.xyz + centre.x * frame.ray_dx.xyz + centre.y * frame.ray_dy.xyz;
    vec3 position = ray * (frame.near / depth) + reuse.left_from_right.xyz;
    vec4 clip = left_frame.clip_from_rel * vec4(position, 1.0);
    if (clip.w <= left_frame.near) {
        return false;
    }
    vec2 at = (clip.xy / clip.w * 0.5 + 0.5) * vec2(left_frame.size);
    ivec2 last = ivec2(left_frame.size) - 1;
    if (any(lessThan(at, vec2(0.5))) || any(greaterThanEqual(at, vec2(last) + 0.5))) {
        return false;
    }
    ivec2 p = min(ivec2(floor(at - 0.5)), last - 1);
    vec2 f = at - 0.5 - vec2(p);
    // Interpolated, the depth is exact on a plane, and a neighbour that belongs to something else moves
    // it by its weight times its distance: within the tolerance its share of the colour is small too.
    vec4 depths = vec4(
        left_depth_at(p), left_depth_at(p + ivec2(1, 0)), left_depth_at(p + ivec2(0, 1)), left_depth_at(p + 1));
    float found = mix(mix(depths.x, depths.y, f.x), mix(depths.z, depths.w, f.x), f.y);
    float expected = left_frame.near / clip.w;
    if (abs(found - expected) > reuse.depth_tolerance * expected) {
        return false;
    }
    ivec2 nearest = ivec2(floor(at));
    vec3 normal = gbuffer_decode(texelFetch(left_gbuffer, nearest, 0)).normal;
    if (dot(normal, surface.normal) < reuse.least_normal_cosine) {
        return false;
    }
    bool reads_texels = !native_in_left_eye(p);
    if (reads_texels && (reach_px == NATIVE_ONLY || !plane_around(nearest, reach_px, left_depth_at(nearest)))) {
        return false;
    }
    radiance = mix4(
        texelFetch(left_radiance, p, 0),
        texelFetch(left_radiance, p + ivec2(1, 0), 0),
        texelFetch(left_radiance, p + ivec2(0, 1), 0),
        texelFetch(left_radiance, p + 1, 0),
        f).rgb;
    return true;
}
