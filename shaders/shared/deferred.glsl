// One shading sample: the display pixel's radiance from the G-buffer. The full-resolution and the
// LP pass call the same function, so a sample is the same number in both.
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/frame.glsl"
#include "shared/gbuffer.glsl"
#include "shared/scene.glsl"
#include "shared/brdf.glsl"
#include "shared/lighting_bindings.glsl"
layout(set = 0, binding = 7) uniform utexture2D gbuffer;
layout(set = 0, binding = 8) uniform texture2D depth_buffer;
#include "shared/lighting.glsl"
#include "shared/store.glsl"

vec3 shade_px(ivec2 px) {
    vec2 centre = vec2(px) + 0.5;
    vec3 ray = frame.ray_base.xyz + centre.x * frame.ray_dx.xyz + centre.y * frame.ray_dy.xyz;
    float depth = texelFetch(depth_buffer, px, 0).r;
    if (depth <= 0.0) {
        return storable(sky_radiance(normalize(ray)));
    }
    Surface surface = gbuffer_decode(texelFetch(gbuffer, px, 0));
    return storable(lit_surface(surface, ray * (frame.near / depth)));
}
