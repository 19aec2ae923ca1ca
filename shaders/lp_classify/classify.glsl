// Which samples the frame needs: LP texels that the inverse pass will read, and the display pixels that
// are shaded themselves. One dispatch for each kind (`mode`), both append to the same list. With
// LP_REUSE, a sample that the left eye has shaded already is stored and not listed.
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef LP_REUSE
// A copy, so that the mapping's functions can be asked about the left eye as well.
layout(set = 0, binding = 0) uniform Fovea { FoveaParams own_fovea; };
FoveaParams fovea;
#else
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
#endif
layout(set = 0, binding = 1, std430) writeonly buffer SampleList { uint samples[]; };
layout(set = 0, binding = 2, std430) buffer Counts { SampleCounts counts; };
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D lp;
#define LP_TABLES_BINDING 4
#include "shared/lp_tables.glsl"
layout(set = 0, binding = 5, std430) readonly buffer ForwardTable { vec2 forward_table[]; };
// The filter goes through the list only: what it leaves out is stored here.
layout(set = 0, binding = 16, rgba16f) uniform writeonly image2D lp_filtered;
layout(constant_id = 10) const bool LP_FILTERED = false;
#define MAPPING_FORWARD
#include "shared/mapping.glsl"
#ifdef LP_REUSE
#include "lp_classify/reuse.glsl"
#endif
layout(push_constant) uniform Push { uint mode; }; // 0: LP texels, 1: native pixels

const uint MODE_TEXELS = 0u;

shared uint group_count;
shared uint group_on_display;
shared uint group_shaded_on_display;
shared uint group_first;
shared uint group_reused;

// A texel is read if a pixel of the display that is not wholly native interpolates with it.
bool texel_needed(TexelReach reach, out bool on_display) {
    on_display = all(greaterThanEqual(reach.px, vec2(0.0))) && all(lessThan(reach.px, fovea.size_f.zw));
    return reach.seen && reach.into >= 0.0;
}

// A pixel is shaded itself where the picture does not come from the LP-buffer alone.
bool pixel_needed(ivec2 px) {
    if (any(lessThan(px, ivec2(0))) || any(greaterThanEqual(px, ivec2(fovea.size.xy)))) {
        return false;
    }
    LpLookup unused;
    return mapping_forward(vec2(px) + 0.5, unused) < 1.0;
}

void store_unlisted(uvec2 texel, vec4 value) {
    imageStore(lp, ivec2(texel), value);
    if (LP_FILTERED) {
        imageStore(lp_filtered, ivec2(texel), value);
    }
}

#ifdef LP_REUSE
// Stores a needed sample where the left eye has it.
bool texel_reused(uvec2 texel, TexelReach reach) {
    // The pixel that the texel would be shaded from.
    ivec2 px = clamp(ivec2(floor(reach.px)), ivec2(0), ivec2(fovea.size.xy) - 1);
    vec3 radiance;
    bool found = radiance_of_left_eye(px, reach.reach_px, radiance);
    if (found) {
        store_unlisted(texel, vec4(radiance, 1.0));
    }
    return found;
}

bool pixel_reused(ivec2 px) {
    vec3 radiance;
    bool found = radiance_of_left_eye(px, NATIVE_ONLY, radiance);
    if (found) {
        imageStore(hdr, px, vec4(radiance, 1.0));
    }
    return found;
}
#endif

void main() {
#ifdef LP_REUSE
    fovea = own_fovea;
#endif
    if (gl_LocalInvocationIndex == 0u) {
        group_count = 0u;
        group_on_display = 0u;
        group_shaded_on_display = 0u;
        group_reused = 0u;
    }
    barrier();
    bool needed = false;
    bool reused = false;
    bool on_display = false;
    uint entry = 0u;
    if (mode == MODE_TEXELS) {
        uvec2 texel = gl_GlobalInvocationID.xy;
        if (texel.x < fovea.size.z && float(texel.y) < column_height(texel.x)) {
            TexelReach reach = texel_reach(texel);
            needed = texel_needed(reach, on_display);
            entry = texel.y * fovea.size.z + texel.x;
            if (!needed) {
                // Alpha 0 says "not shaded" to the filter and to the inverse pass.
                store_unlisted(texel, vec4(0.0));
            }
#ifdef LP_REUSE
            // Texels beyond the display's edge have no pixel of their own to look up.
            reused = needed && on_display && texel_reused(texel, reach);
#endif
        }
    } else {
        ivec2 px = fovea.native_box.xy + ivec2(gl_GlobalInvocationID.xy);
        if (all(lessThan(px, fovea.native_box.zw))) {
            needed = pixel_needed(px);
#ifdef LP_REUSE
            reused = needed && pixel_reused(px);
#endif
            entry = NATIVE_SAMPLE | (uint(px.y) * fovea.size.x + uint(px.x));
        }
    }
    if (reused) {
        needed = false;
        atomicAdd(group_reused, 1u);
    }
    uint place = needed ? atomicAdd(group_count, 1u) : 0u;
    if (on_display) {
        atomicAdd(group_on_display, 1u);
        if (needed) {
            atomicAdd(group_shaded_on_display, 1u);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        group_first = group_count > 0u ? atomicAdd(counts.listed, group_count) : 0u;
        if (mode == MODE_TEXELS) {
            atomicAdd(counts.shaded_texels, group_count);
            atomicAdd(counts.on_display, group_on_display);
            atomicAdd(counts.shaded_on_display, group_shaded_on_display);
        } else {
            atomicAdd(counts.native_pixels, group_count);
        }
        if (group_reused > 0u) {
            atomicAdd(counts.reused, group_reused);
        }
    }
    barrier();
    if (needed) {
        samples[group_first + place] = entry;
    }
}
