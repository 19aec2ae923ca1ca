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

// Lights that may reach any sample of the workgroup, a bit each, for up to this many at a time.
const uint LIGHTS_AT_A_TIME = 1024u;
const uint LIGHT_WORDS = LIGHTS_AT_A_TIME / 32u;
shared uint reachable[LIGHT_WORDS];
shared ivec3 group_low;
shared ivec3 group_high;

// Floats as integers of the same order, for atomic minima and maxima.
ivec3 ordered(vec3 v) {
    ivec3 bits = floatBitsToInt(v);
    return bits ^ ((bits >> 31) & 0x7fffffff);
}

vec3 unordered(ivec3 v) {
    return intBitsToFloat(v ^ ((v >> 31) & 0x7fffffff));
}

const uint GROUP_SIZE = 64u;

// The box around all lit samples of the workgroup. Every invocation takes part.
void find_group_box(bool lit, vec3 position) {
    if (gl_LocalInvocationIndex == 0u) {
        group_low = ivec3(0x7fffffff);
        group_high = ivec3(-0x7fffffff - 1);
    }
    barrier();
    if (lit) {
        ivec3 place = ordered(position);
        atomicMin(group_low.x, place.x);
        atomicMin(group_low.y, place.y);
        atomicMin(group_low.z, place.z);
        atomicMax(group_high.x, place.x);
        atomicMax(group_high.y, place.y);
        atomicMax(group_high.z, place.z);
    }
    barrier();
}

// Marks the lights from `first` on whose range touches the group's box. A light that is left out adds
// exactly zero to every sample, and the others are summed in their order: the picture does not depend
// on which samples share a workgroup.
void mark_reachable(uint first) {
    barrier();
    for (uint word = gl_LocalInvocationIndex; word < LIGHT_WORDS; word += GROUP_SIZE) {
        reachable[word] = 0u;
    }
    barrier();
    vec3 low = unordered(group_low);
    vec3 high = unordered(group_high);
    uint last = min(frame.light_count, first + LIGHTS_AT_A_TIME);
    for (uint i = first + gl_LocalInvocationIndex; i < last; i += GROUP_SIZE) {
        vec3 at = light_row(i, LIGHT_POSITION).xyz;
        float range2 = light_row(i, LIGHT_INTENSITY).w;
        vec3 outside = max(max(low - at, at - high), vec3(0.0));
        // A little more than the range: the two distances round differently.
        bool directional = light_row(i, LIGHT_KINDS).x == LIGHT_DIRECTIONAL;
        if (directional || dot(outside, outside) <= range2 * 1.0001) {
            atomicOr(reachable[(i - first) / 32u], 1u << ((i - first) & 31u));
        }
    }
    barrier();
}

// Light of all punctual lights. Every invocation of the workgroup takes part, also those without a
// lit sample.
vec3 punctual_lights(bool lit, Shading s, vec3 position) {
    vec3 sum = vec3(0.0);
    find_group_box(lit, position);
    for (uint first = 0u; first < frame.light_count; first += LIGHTS_AT_A_TIME) {
        mark_reachable(first);
        if (!lit) {
            continue;
        }
        uint words = (min(frame.light_count - first, LIGHTS_AT_A_TIME) + 31u) / 32u;
        for (uint word = 0u; word < words; ++word) {
            uint bits = reachable[word];
            while (bits != 0u) {
                int bit = findLSB(bits);
                bits &= bits - 1u;
                sum += one_light(s, position, first + 32u * word + uint(bit));
            }
        }
    }
    return sum;
}

// The radiance of a display pixel. Must be called by every invocation of the workgroup, with `wanted`
// false where there is nothing to shade.
vec3 shade_px(bool wanted, ivec2 px) {
    vec2 centre = vec2(px) + 0.5;
    vec3 ray = frame.ray_base.xyz + centre.x * frame.ray_dx.xyz + centre.y * frame.ray_dy.xyz;
    float depth = wanted ? texelFetch(depth_buffer, px, 0).r : 0.0;
    Surface surface = gbuffer_decode(depth > 0.0 ? texelFetch(gbuffer, px, 0) : uvec4(0u));
    vec3 position = ray * (frame.near / max(depth, 1e-30));
    bool lit = depth > 0.0 && !surface.unlit;
    Shading s = shading_at(surface, position);
    vec3 radiance = punctual_lights(lit, s, position);
    if (depth <= 0.0) {
        return storable(sky_radiance(normalize(ray)));
    }
    return storable(surface.unlit ? surface.emissive : radiance + other_light(s, surface));
}
