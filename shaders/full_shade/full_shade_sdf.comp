// The ray-marched scene at every pixel of the display.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/sdf_sample.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 9, rgba16f) uniform writeonly image2D hdr;

void main() {
    ivec2 px = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(px), frame.size))) {
        return;
    }
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < samples_per_pixel; ++i) {
        sum += march_px(vec2(px) + 0.5 + sample_offsets[i].xy, 1.0);
    }
    imageStore(hdr, px, vec4(storable(sum / float(samples_per_pixel)), 1.0));
}
