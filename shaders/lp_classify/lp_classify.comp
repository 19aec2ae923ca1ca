// Which samples the frame needs: LP texels that the inverse pass will read, and the display pixels of
// the native disc. One dispatch for each kind (`mode`), both append to the same list.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1, std430) writeonly buffer SampleList { uint samples[]; };
layout(set = 0, binding = 2, std430) buffer Counts { SampleCounts counts; };
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D lp;
layout(push_constant) uniform Push { uint mode; }; // 0: LP texels, 1: native pixels

const uint MODE_TEXELS = 0u;

shared uint group_count;
shared uint group_on_display;
shared uint group_first;

// Distance of a point to the display, px; 0 inside.
float outside_px(vec2 px) {
    vec2 size = fovea.size_f.zw;
    return length(max(max(-px, px - size), vec2(0.0)));
}

// A texel is read if its own or a neighbouring texel's area touches the display outside the disc.
bool texel_needed(uvec2 texel, out bool on_display) {
    vec2 centre = vec2(texel) + 0.5;
    vec2 offset = fovea_inverse_offset(fovea, centre);
    vec2 px = offset + fovea.gaze_px.xy;
    on_display = all(greaterThanEqual(px, vec2(0.0))) && all(lessThan(px, fovea.size_f.zw));
    float r = length(offset);
    float r_out = length(fovea_inverse_offset(fovea, vec2(min(centre.x + 1.0, fovea.size_f.x), centre.y)));
    // The display's farthest corner lies on the last column's outer edge.
    vec2 step_px = vec2(max(r_out - r, 0.0), r_out * (6.2831853 / fovea.size_f.y));
    float disc = fovea.ring.x - fovea.ring.y;
    return r_out + 1.0 >= disc && outside_px(px) <= length(step_px) + 1.0;
}

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        group_count = 0u;
        group_on_display = 0u;
    }
    barrier();
    bool needed = false;
    bool on_display = false;
    uint entry = 0u;
    if (mode == MODE_TEXELS) {
        uvec2 texel = gl_GlobalInvocationID.xy;
        if (all(lessThan(texel, fovea.size.zw))) {
            needed = texel_needed(texel, on_display);
            entry = texel.y * fovea.size.z + texel.x;
            if (!needed) {
                // Alpha 0 says "not shaded" to the filter and to the inverse pass.
                imageStore(lp, ivec2(texel), vec4(0.0));
            }
        }
    } else {
        // The disc's box, at least as large as the dispatch.
        ivec2 px = ivec2(floor(fovea.gaze_px.xy - fovea.ring.x)) + ivec2(gl_GlobalInvocationID.xy);
        if (all(greaterThanEqual(px, ivec2(0))) && all(lessThan(px, ivec2(fovea.size.xy)))) {
            needed = distance(vec2(px) + 0.5, fovea.gaze_px.xy) < fovea.ring.x;
            entry = NATIVE_SAMPLE | (uint(px.y) * fovea.size.x + uint(px.x));
        }
    }
    uint place = needed ? atomicAdd(group_count, 1u) : 0u;
    if (on_display) {
        atomicAdd(group_on_display, 1u);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        group_first = group_count > 0u ? atomicAdd(counts.listed, group_count) : 0u;
        if (mode == MODE_TEXELS) {
            atomicAdd(counts.shaded_texels, group_count);
            atomicAdd(counts.on_display, group_on_display);
        } else {
            atomicAdd(counts.native_pixels, group_count);
        }
    }
    barrier();
    if (needed) {
        samples[group_first + place] = entry;
    }
}
