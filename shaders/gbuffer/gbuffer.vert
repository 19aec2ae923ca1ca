// Surfaces from the eye.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/scene.glsl"
#include "shared/vertex_stage.glsl"
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 9, std430) readonly buffer Instances { Instance instances[]; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_tangent;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;
layout(location = 5) flat out uint out_material;

void main() {
    vec3 position = transform_rows(instances[gl_InstanceIndex].rel_from_mesh, vec4(in_position, 1.0));
    out_position = position;
    out_normal = transform_rows(instances[gl_InstanceIndex].rel_from_normal, vec4(in_normal, 0.0));
    vec3 tangent = transform_rows(instances[gl_InstanceIndex].rel_from_mesh, vec4(in_tangent.xyz, 0.0));
    float mirror = instances[gl_InstanceIndex].mirrored != 0u ? -1.0 : 1.0;
    out_tangent = vec4(tangent, in_tangent.w * mirror);
    out_uv = vec4(in_uv0, in_uv1);
    out_color = in_color;
    out_material = instances[gl_InstanceIndex].material;
    gl_Position = frame.clip_from_rel * vec4(position, 1.0);
}
