// The ray-marched scene at the samples of the list: rays start from LP texels, there is no G-buffer.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/sdf_sample.glsl"
#include "shared/lp_targets.glsl"

void main() {
    uint entry;
    if (!sample_entry(entry)) {
        return;
    }
    bool native_sample = (entry & NATIVE_SAMPLE) != 0u;
    ivec2 px = native_px(entry);
    ivec2 texel = lp_texel(entry);
    float footprint = 1.0;
    TexelPlace place;
    if (!native_sample) {
        place = texel_place(uvec2(texel));
        footprint = max(1.0, place.width_px);
    }
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < samples_per_pixel; ++i) {
        vec4 offset = sample_offsets[i];
        vec2 at = native_sample ? vec2(px) + 0.5 + offset.xy : place_px(place, offset);
        sum += march_px(at, footprint);
    }
    vec4 radiance = vec4(storable(sum / float(samples_per_pixel)), 1.0);
    if (native_sample) {
        imageStore(hdr, px, radiance);
    } else {
        imageStore(lp, texel, radiance);
    }
}
