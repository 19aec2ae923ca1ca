// The KFR mapping taken apart: a texel's radius depends on its column only, its direction on its row only.
// So the passes that go through all texels look both up instead of computing them millions of times.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/fovea.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1, std430) writeonly buffer LpTables { vec4 lp_tables[]; };

// Distance from the gaze at a column position; clamped to the LP-buffer's edges.
float radius_px(float u) {
    return length(fovea_inverse_offset(fovea, vec2(clamp(u, 0.0, fovea.size_f.x), 0.0)));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    uvec2 size = fovea.size.zw;
    if (index < size.x) {
        float u = float(index);
        // Inner edge, centre, outer edge, half a texel beyond.
        lp_tables[2u * index] = vec4(radius_px(u), radius_px(u + 0.5), radius_px(u + 1.0), radius_px(u + 1.5));
        lp_tables[2u * index + 1u] = vec4(0.0, 0.0, fovea.size_f.y, 0.0);
    } else if (index < size.x + size.y) {
        float v = float(index - size.x) + 0.5;
        vec2 offset = fovea_inverse_offset(fovea, vec2(fovea.size_f.x, v));
        lp_tables[size.x + index] = vec4(offset / max(length(offset), 1e-6), 0.0, 0.0);
    }
}
