// Evaluates the material and packs it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/gbuffer.glsl"
#include "shared/scene.glsl"
#include "shared/material.glsl"
#include "shared/surface.glsl"
layout(location = 0) out uvec4 out_surface;

void main() {
    vec4 base = base_color_at();
    // Derivatives are taken before any fragment is dropped.
    Surface surface = surface_at(base);
    if (masked_out(base)) {
        discard;
    }
    out_surface = gbuffer_encode(surface);
}
