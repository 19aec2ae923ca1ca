// Evaluates the material and packs it.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/gbuffer.glsl"
#include "shared/scene.glsl"
#include "shared/material.glsl"
#include "shared/footprint.glsl"
#include "shared/surface.glsl"
layout(set = 0, binding = 1) uniform texture2D footprint;
layout(location = 0) out uvec4 out_surface;

void main() {
    if (HAS_FOOTPRINT) {
        map_levels = texelFetch(footprint, ivec2(gl_FragCoord.xy) / FOOTPRINT_TILE_PX, 0).r;
    }
    vec4 base = base_color_at();
    // Derivatives are taken before any fragment is dropped.
    Surface surface = surface_at(base);
    if (masked_out(base)) {
        discard;
    }
    out_surface = gbuffer_encode(surface);
}
