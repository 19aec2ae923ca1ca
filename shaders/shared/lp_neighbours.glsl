// A texel of the LP-buffer and those around it, for the filters over the LP-buffer. Bindings 0 to 5; needs
// MAPPING_KIND and defines the images.
//
// Neighbouring columns may differ in height. What lies beside a texel in another column has the same share
// of the height, which is the same direction from the gaze, and not the same row.
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
#define LP_TABLES_BINDING 1
#include "shared/lp_tables.glsl"
layout(set = 0, binding = 2) uniform texture2D lp;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D lp_filtered;
layout(set = 0, binding = 4, std430) readonly buffer SampleList { uint samples[]; };
layout(set = 0, binding = 5, std430) readonly buffer Indirect { uint groups_x; uint groups_y; uint groups_z; uint sample_count; };
#include "shared/mapping.glsl"

struct Centre {
    ivec2 texel;
    float height;  // of its column, texels
    ivec2 columns; // first and last one that it has neighbours in
    vec3 color;
};

// The invocation's texel, of those that were shaded. False for a native pixel and beyond the list's end.
bool find_centre(out Centre centre) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint index = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    uint entry = index < sample_count ? samples[index] : NATIVE_SAMPLE;
    centre.texel = ivec2(entry % fovea.size.z, entry / fovea.size.z);
    if ((entry & NATIVE_SAMPLE) != 0u || centre.texel.x < first_filtered_column(fovea)) {
        return false;
    }
    centre.height = column_height(uint(centre.texel.x));
    centre.columns = ivec2(0, int(fovea.size.z) - 1);
    if (MAPPING_KIND == MAPPING_AXES) {
        // Two layers side by side: they are no neighbours.
        int finer = int(fovea.axes.z);
        centre.columns = centre.texel.x < finer ? ivec2(0, finer - 1) : ivec2(finer, centre.columns.y);
    }
    centre.color = texelFetch(lp, centre.texel, 0).rgb;
    return true;
}

// A row within a column: around a circle it goes on at the other end, however often.
int row_within(int row, float height) {
    if (MAPPING_KIND == MAPPING_AXES) {
        return clamp(row, 0, int(height) - 1);
    }
    return row - int(height * floor((float(row) + 0.5) / height));
}

// Radiance `along` rows from the centre, at the same place in its own column or `across` columns away.
// Linear between rows. What was not shaded counts as the centre, so that no filter darkens a border.
// A weighted sum of differences, so that equal texels give exactly their value.
vec3 neighbour(Centre centre, int across, int along) {
    int column = centre.texel.x + across;
    if (column < centre.columns.x || column > centre.columns.y) {
        return centre.color;
    }
    if (MAPPING_KIND != MAPPING_RADIAL || across == 0) {
        vec4 texel = texelFetch(lp, ivec2(column, row_within(centre.texel.y + along, centre.height)), 0);
        return texel.a > 0.0 ? texel.rgb : centre.color;
    }
    float height = column_height(uint(column));
    float ratio = height == centre.height ? 1.0 : height / centre.height;
    float at = (float(centre.texel.y + along) + 0.5) * ratio - 0.5;
    float base = floor(at);
    float f = at - base;
    vec4 a = texelFetch(lp, ivec2(column, row_within(int(base), height)), 0);
    vec4 b = texelFetch(lp, ivec2(column, row_within(int(base) + 1, height)), 0);
    vec2 weights = vec2(1.0 - f, f) * vec2(a.a, b.a);
    float sum = weights.x + weights.y;
    return sum > 0.0 ? a.rgb + (weights.y / sum) * (b.rgb - a.rgb) : centre.color;
}

void store(Centre centre, vec3 radiance) {
    imageStore(lp_filtered, centre.texel, vec4(radiance, 1.0));
}
