// From the LP-buffer to the display: linear within each of the two nearest columns, then across them, as
// neighbouring columns may differ in height. Where pixels are shaded themselves the display image already
// holds them; over a narrow band the two are blended.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The mapping runs for every pixel: only the kernel in use is compiled in.
layout(constant_id = 0) const uint KERNEL_KIND = 0u;
layout(constant_id = 1) const uint INTEGER_ALPHA = 0u;
#define FOVEA_KERNEL_KIND KERNEL_KIND
#define FOVEA_INTEGER_ALPHA INTEGER_ALPHA
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1) uniform texture2D lp;
layout(set = 0, binding = 2) uniform texture2D lp_filtered;
layout(set = 0, binding = 3, rgba16f) uniform image2D hdr;
layout(set = 0, binding = 4, std430) readonly buffer ForwardTable { vec2 forward_table[]; };
#define LP_TABLES_BINDING 5
#include "shared/lp_tables.glsl"
#define MAPPING_FORWARD
#include "shared/mapping.glsl"

vec4 fetch(ivec2 texel) {
    return texel.x >= first_filtered_column(fovea)
        ? texelFetch(lp_filtered, texel, 0)
        : texelFetch(lp, texel, 0);
}

// A column's value at a share of its height.
vec4 in_column(int u, float v_share) {
    float height = column_height(uint(u));
    int last = int(height) - 1;
    float at = v_share * height - 0.5;
    float base = floor(at);
    float f = at - base;
    int v0 = int(base);
    int v1 = v0 + 1;
    if (MAPPING_KIND == MAPPING_AXES) {
        v0 = clamp(v0, 0, last);
        v1 = clamp(v1, 0, last);
    } else {
        // The share lies in 0..=1: neighbours wrap at most once.
        v0 = v0 < 0 ? v0 + last + 1 : v0;
        v1 = v1 > last ? 0 : v1;
    }
    // Colours of texels that were not shaded are 0, like their alpha.
    return (1.0 - f) * fetch(ivec2(u, v0)) + f * fetch(ivec2(u, v1));
}

vec4 reconstruct(LpLookup lookup) {
    float at = lookup.u - 0.5;
    float base = floor(at);
    float f = at - base;
    int u0 = int(clamp(base, lookup.columns.x, lookup.columns.y));
    int u1 = int(clamp(base + 1.0, lookup.columns.x, lookup.columns.y));
    vec4 sum = (1.0 - f) * in_column(u0, lookup.v_share) + f * in_column(u1, lookup.v_share);
    // Alpha 0 marks texels that were not shaded: dividing leaves them out. Where all four are, alpha
    // stays 0: a hole, which the check of finite values counts.
    return sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}

void main() {
    ivec2 px = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(px), fovea.size.xy))) {
        return;
    }
    LpLookup lookup;
    float past_native = mapping_forward(vec2(px) + 0.5, lookup);
    if (past_native <= 0.0) {
        return;
    }
    vec4 color = reconstruct(lookup);
    if (MAPPING_KIND == MAPPING_AXES) {
        // The finer layer passes over into the coarser one inside its edge.
        float past_layer = outside_rect_px(fovea.layer_rect, vec2(px) + 0.5) / fovea.axes.y + 1.0;
        if (past_layer > 0.0 && past_layer < 1.0) {
            vec4 coarser = reconstruct(axes_lookup(vec2(px) + 0.5, false));
            color = mix(color, coarser, smoothstep(0.0, 1.0, past_layer));
        }
    }
    if (past_native < 1.0) {
        color = mix(imageLoad(hdr, px), color, smoothstep(0.0, 1.0, past_native));
    }
    imageStore(hdr, px, color);
}
