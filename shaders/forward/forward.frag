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
#include "shared/footprint.glsl"
#include "shared/surface.glsl"
layout(location = 0) out vec4 out_color;

void main() {
    vec4 base = base_color_at();
    Surface surface = surface_at(base);
    float alpha = clamp(base.a, 0.0, 1.0);
    vec3 radiance = surface.emissive;
    if (!surface.unlit) {
        Shading s = shading_at(surface, in_position);
        radiance = other_light(s, surface) + first_lights(s, in_position);
        for (uint i = frame.shadowed_end; i < frame.light_count; ++i) {
            vec3 to_light;
            float distance_m;
            radiance += positional_light(s, in_position, i, to_light, distance_m);
        }
    }
    out_color = vec4(storable(radiance) * alpha, alpha);
}
