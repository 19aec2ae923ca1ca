// Full-resolution shading, the reference: every pixel of the display.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/deferred.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 9, rgba16f) uniform writeonly image2D hdr;

void main() {
    ivec2 px = ivec2(gl_GlobalInvocationID.xy);
    bool inside = all(lessThan(uvec2(px), frame.size));
    vec3 radiance = shade(surface_of_px(inside, px));
    if (inside) {
        imageStore(hdr, px, vec4(radiance, 1.0));
    }
}
