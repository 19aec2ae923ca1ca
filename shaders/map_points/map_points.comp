// The mapping at given display positions, by the function that the passes are tested against.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "shared/fovea.glsl"

layout(local_size_x = 64) in;

layout(std140, set = 0, binding = 0) uniform Fovea {
    FoveaParams fovea;
};

// x hi, y hi, x lo, y lo in px.
layout(std430, set = 0, binding = 1) readonly buffer Points {
    vec4 points[];
};

// u hi, u lo, v hi, v lo, normalised.
layout(std430, set = 0, binding = 2) writeonly buffer Mapped {
    vec4 mapped[];
};

layout(push_constant) uniform Push {
    uint count;
};

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= count) {
        return;
    }
    vec4 point = points[index];
    LpPoint lp = fovea_forward(fovea, point.xy, point.zw);
    mapped[index] = vec4(lp.u, lp.v);
}
