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

// Lights without shadows that may reach any sample of the workgroup, for up to this many at a time.
const uint LIGHTS_AT_A_TIME = 1024u;
const uint LIGHT_WORDS = LIGHTS_AT_A_TIME / 32u;
shared uint reachable[LIGHT_WORDS];     // a bit a light
shared uint light_list[LIGHTS_AT_A_TIME]; // the same as a list, in order
shared uint light_list_length;
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

// Lists the lights from `first` on whose range touches the group's box. A light that is left out adds
// exactly zero to every sample, and the others are summed in their order: the picture does not depend
// on which samples share a workgroup.
void list_reachable(uint first) {
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
        if (dot(outside, outside) <= range2 * 1.0001) {
            atomicOr(reachable[(i - first) / 32u], 1u << ((i - first) & 31u));
        }
    }
    barrier();
    if (gl_LocalInvocationIndex < LIGHT_WORDS) {
        uint place = 0u;
        for (uint word = 0u; word < gl_LocalInvocationIndex; ++word) {
            place += uint(bitCount(reachable[word]));
        }
        uint bits = reachable[gl_LocalInvocationIndex];
        while (bits != 0u) {
            light_list[place++] = first + 32u * gl_LocalInvocationIndex + uint(findLSB(bits));
            bits &= bits - 1u;
        }
        if (gl_LocalInvocationIndex == LIGHT_WORDS - 1u) {
            light_list_length = place;
        }
    }
    barrier();
}

// Light of all punctual lights. Every invocation of the workgroup takes part, also those without a
// lit sample.
vec3 punctual_lights(bool lit, Shading s, vec3 position) {
    vec3 sum = first_lights(s, position);
    if (frame.shadowed_end >= frame.light_count) {
        return sum;
    }
    find_group_box(lit, position);
    for (uint first = frame.shadowed_end; first < frame.light_count; first += LIGHTS_AT_A_TIME) {
        list_reachable(first);
        for (uint place = 0u; place < light_list_length; ++place) {
            vec3 to_light;
            float distance_m;
            sum += positional_light(s, position, light_list[place], to_light, distance_m);
        }
    }
    return sum;
}

// What is seen through a display pixel.
struct PixelSurface {
    vec3 ray;      // of depth 1 along the view axis
    float depth;   // as in the depth buffer; 0: the sky
    vec3 position; // rel
    Surface surface;
};

// Of a pixel of the display; the sky where it is not `wanted`.
PixelSurface surface_of_px(bool wanted, ivec2 px) {
    PixelSurface s;
    vec2 centre = vec2(px) + 0.5;
    s.ray = frame.ray_base.xyz + centre.x * frame.ray_dx.xyz + centre.y * frame.ray_dy.xyz;
    s.depth = wanted ? texelFetch(depth_buffer, px, 0).r : 0.0;
    s.surface = gbuffer_decode(s.depth > 0.0 ? texelFetch(gbuffer, px, 0) : uvec4(0u));
    s.position = s.ray * (frame.near / max(s.depth, 1e-30));
    return s;
}

// Its radiance. Must be called by every invocation of the workgroup, with the sky where there is nothing
// to shade.
vec3 shade(PixelSurface p) {
    bool lit = p.depth > 0.0 && !p.surface.unlit;
    Shading s = shading_at(p.surface, p.position);
    vec3 radiance = punctual_lights(lit, s, p.position);
    if (p.depth <= 0.0) {
        return storable(sky_radiance(normalize(p.ray)));
    }
    return storable(p.surface.unlit ? p.surface.emissive : radiance + other_light(s, p.surface));
}
