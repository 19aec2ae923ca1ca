// Blended surfaces over the finished picture, lit as the others. glTF blends straight alpha; what
// leaves here is premultiplied.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/frame.glsl"
#include "shared/gbuffer.glsl"
#include "shared/scene.glsl"
#include "shared/brdf.glsl"
#include "shared/lighting_bindings.glsl"
#include "shared/lighting.glsl"
#include "shared/store.glsl"
#include "shared/material.glsl"
layout(location = 0) out vec4 out_color;

void main() {
    vec4 base = base_color_at();
    Surface surface = surface_at(base);
    float alpha = clamp(base.a, 0.0, 1.0);
    out_color = vec4(storable(lit_surface(surface, in_position)) * alpha, alpha);
}
