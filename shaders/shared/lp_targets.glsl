// Where the samples of the list come from and go to. Bindings 9 to 14.
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 9) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 10, std430) readonly buffer SampleList { uint samples[]; };
layout(set = 0, binding = 11, std430) readonly buffer Indirect { uint groups_x; uint groups_y; uint groups_z; uint sample_count; };
#define LP_TABLES_BINDING 14
#include "shared/lp_tables.glsl"
#include "shared/mapping.glsl"
layout(set = 0, binding = 12, rgba16f) uniform writeonly image2D lp;
layout(set = 0, binding = 13, rgba16f) uniform writeonly image2D hdr;

// This invocation's entry of the list; false beyond its end.
bool sample_entry(out uint entry) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint index = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    if (index >= sample_count) {
        return false;
    }
    entry = samples[index];
    return true;
}

ivec2 native_px(uint entry) {
    uint index = entry & ~NATIVE_SAMPLE;
    return ivec2(index % fovea.size.x, index / fovea.size.x);
}

ivec2 lp_texel(uint entry) {
    return ivec2(entry % fovea.size.z, entry / fovea.size.z);
}
