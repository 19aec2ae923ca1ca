// Surfaces from the eye.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/vertex_stage.glsl"
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_tangent;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;

void main() {
    vec3 position = rel_position();
    out_position = position;
    out_normal = rel_normal();
    out_tangent = vec4(rel_direction(in_tangent.xyz), in_tangent.w * draw.handedness);
    out_uv = vec4(in_uv0, in_uv1);
    out_color = in_color;
    gl_Position = frame.clip_from_rel * vec4(position, 1.0);
}
