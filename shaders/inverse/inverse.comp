// From the LP-buffer to the display: bilinear among the four nearest texels, wrapping in v. Inside the
// native disc the display image already holds the pixel; over a narrow band the two are blended.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1) uniform texture2D lp;
layout(set = 0, binding = 2) uniform texture2D lp_filtered;
layout(set = 0, binding = 3, rgba16f) uniform image2D hdr;

vec4 fetch(ivec2 texel) {
    return texel.x >= first_filtered_column(fovea)
        ? texelFetch(lp_filtered, texel, 0)
        : texelFetch(lp, texel, 0);
}

vec4 reconstruct(vec2 uv) {
    ivec2 size = ivec2(fovea.size.zw);
    vec2 at = uv - 0.5;
    vec2 base = floor(at);
    vec2 f = at - base;
    int u0 = clamp(int(base.x), 0, size.x - 1);
    int u1 = clamp(int(base.x) + 1, 0, size.x - 1);
    // v lies in [0, height): its neighbours wrap at most once.
    int v0 = int(base.y);
    v0 = v0 < 0 ? v0 + size.y : (v0 >= size.y ? v0 - size.y : v0);
    int v1 = v0 + 1 >= size.y ? 0 : v0 + 1;
    vec4 sum = (1.0 - f.x) * (1.0 - f.y) * fetch(ivec2(u0, v0));
    sum += f.x * (1.0 - f.y) * fetch(ivec2(u1, v0));
    sum += (1.0 - f.x) * f.y * fetch(ivec2(u0, v1));
    sum += f.x * f.y * fetch(ivec2(u1, v1));
    // Alpha 0 marks texels that were not shaded. Where all four are, alpha stays 0: a hole, which
    // the check of finite values counts.
    return sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}

void main() {
    ivec2 px = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(px), fovea.size.xy))) {
        return;
    }
    vec2 centre = vec2(px) + 0.5;
    float r = distance(centre, fovea.gaze_px.xy);
    float into_band = (r - (fovea.ring.x - fovea.ring.y)) / fovea.ring.y;
    if (into_band <= 0.0) {
        return;
    }
    vec4 color = reconstruct(fovea_forward_texels(fovea, centre));
    if (r < fovea.ring.x) {
        color = mix(imageLoad(hdr, px), color, smoothstep(0.0, 1.0, into_band));
    }
    imageStore(hdr, px, color);
}
