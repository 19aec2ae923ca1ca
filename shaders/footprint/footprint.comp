// By how many mip levels the samples at each tile of the display are coarser than its pixels. Over a tile
// the levels change by a few hundredths at most, so that the G-buffer reads one number a tile.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint KERNEL_KIND = 0u;
layout(constant_id = 1) const uint INTEGER_ALPHA = 0u;
#define FOVEA_KERNEL_KIND KERNEL_KIND
#define FOVEA_INTEGER_ALPHA INTEGER_ALPHA
#include "shared/fovea.glsl"
#include "shared/footprint.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1, r32f) uniform writeonly image2D footprint;
layout(set = 0, binding = 2, std430) readonly buffer ForwardTable { vec2 forward_table[]; };
#define LP_TABLES_BINDING 3
#include "shared/lp_tables.glsl"
#define MAPPING_FORWARD
#include "shared/mapping.glsl"

// Whether a pixel of the tile is shaded itself.
bool holds_native(ivec2 first, ivec2 end) {
    bool any_native = false;
    for (int y = first.y; y < end.y && !any_native; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            LpLookup unused;
            any_native = any_native || mapping_forward(vec2(x, y) + 0.5, unused) <= 0.0;
        }
    }
    return any_native;
}

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, imageSize(footprint)))) {
        return;
    }
    ivec2 first = tile * FOOTPRINT_TILE_PX;
    ivec2 end = min(first + FOOTPRINT_TILE_PX, ivec2(fovea.size.xy));
    bool near_native = all(lessThan(first, fovea.native_box.zw)) && all(greaterThan(end, fovea.native_box.xy));
    // A pixel that is shaded itself must not be blurred.
    bool sharp = near_native && holds_native(first, end);
    float levels = sharp ? 0.0 : footprint_levels(0.5 * vec2(first + end));
    imageStore(footprint, tile, vec4(levels));
}
