// Depth from a light.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/vertex_stage.glsl"
layout(set = 0, binding = 2) uniform textureBuffer shadow_views;

layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;

void main() {
    vec4 position = vec4(rel_position(), 1.0);
    out_uv = vec4(in_uv0, in_uv1);
    out_color = in_color;
    int row = int(5u * draw.view);
    gl_Position = vec4(
        dot(texelFetch(shadow_views, row), position), dot(texelFetch(shadow_views, row + 1), position),
        dot(texelFetch(shadow_views, row + 2), position), dot(texelFetch(shadow_views, row + 3), position));
}
