// Depth from a light.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/scene.glsl"
#include "shared/vertex_stage.glsl"
layout(set = 0, binding = 2, std430) readonly buffer ShadowViews { ShadowView shadow_views[]; };
layout(set = 0, binding = 9, std430) readonly buffer Instances { Instance instances[]; };
layout(push_constant) uniform Push { uint view; };

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_tangent;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;
layout(location = 5) flat out uint out_material;

void main() {
    vec3 position = transform_rows(instances[gl_InstanceIndex].rel_from_mesh, vec4(in_position, 1.0));
    out_position = position;
    out_normal = in_normal;
    out_tangent = in_tangent;
    out_uv = vec4(in_uv0, in_uv1);
    out_color = in_color;
    out_material = instances[gl_InstanceIndex].material;
    gl_Position = shadow_views[view].clip_from_rel * vec4(position, 1.0);
}
