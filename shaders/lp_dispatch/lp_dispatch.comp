// Turns the number of samples into the size of the indirect dispatch, hands the counts to the CPU,
// and zeroes them for the next frame.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std430) buffer Counts { SampleCounts counts; };
layout(set = 0, binding = 1, std430) writeonly buffer Indirect { uint groups_x; uint groups_y; uint groups_z; uint sample_count; };
layout(set = 0, binding = 2, std430) writeonly buffer Stats { SampleCounts stats; };

const uint GROUP = 64u;
const uint MAX_GROUPS_X = 65535u; // what every Vulkan device allows

void main() {
    uint groups = (counts.listed + GROUP - 1u) / GROUP;
    groups_x = min(groups, MAX_GROUPS_X);
    groups_y = (groups + MAX_GROUPS_X - 1u) / MAX_GROUPS_X;
    groups_z = 1u;
    sample_count = counts.listed;
    stats = counts;
    counts.listed = 0u;
    counts.on_display = 0u;
    counts.shaded_texels = 0u;
    counts.native_pixels = 0u;
    counts.shaded_on_display = 0u;
    counts.reused = 0u;
}
