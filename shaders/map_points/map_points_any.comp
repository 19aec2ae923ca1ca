// Any method's mapping at given points, by the functions that the passes use: display positions to the
// LP-buffer (`mode` 0), or the LP-buffer to display positions (1).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/fovea.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
// Mode 0: x, y in px. Mode 1: u in texels, v as a share of the column's height.
layout(set = 0, binding = 1, std430) readonly buffer Points { vec4 points[]; };
// Mode 0: u, v share, how far past the native region. Mode 1: x, y in px.
layout(set = 0, binding = 2, std430) writeonly buffer Mapped { vec4 mapped[]; };
layout(set = 0, binding = 3, std430) readonly buffer ForwardTable { vec2 forward_table[]; };
#define LP_TABLES_BINDING 4
#include "shared/lp_tables.glsl"
#define MAPPING_FORWARD
#define MAPPING_OF_NATIVE true
#include "shared/mapping.glsl"
layout(push_constant) uniform Push { uint count; uint mode; };

vec4 forward(vec2 px) {
    LpLookup lookup;
    float past_native = mapping_forward(px, lookup);
    return vec4(lookup.u, lookup.v_share, past_native, 0.0);
}

vec4 backward(float u, float v_share) {
    float column = clamp(floor(u), 0.0, fovea.size_f.x - 1.0);
    float height = column_height(uint(column));
    float row = clamp(floor(v_share * height), 0.0, height - 1.0);
    TexelPlace place = texel_place(uvec2(column, row));
    vec2 offset = vec2(u - column, v_share * height - row) - 0.5;
    if (MAPPING_KIND != MAPPING_AXES) {
        // Any azimuth, not only a row's centre and a small turn.
        place.around = fovea_direction(v_share);
        offset.y = 0.0;
    }
    return vec4(place_px(place, vec4(offset, 1.0, 0.0)), 0.0, 0.0);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < count) {
        vec4 point = points[index];
        mapped[index] = mode == 0u ? forward(point.xy) : backward(point.x, point.y);
    }
}
