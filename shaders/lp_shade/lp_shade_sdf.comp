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
    vec2 centre = vec2(texel) + 0.5;
    float footprint = 1.0;
    if (!native_sample) {
        vec2 at = fovea_inverse_offset(fovea, centre);
        float r_out = length(fovea_inverse_offset(fovea, centre + vec2(1.0, 0.0)));
        float r = length(at);
        footprint = max(1.0, max(r_out - r, r * (6.2831853 / fovea.size_f.y)));
    }
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < samples_per_pixel; ++i) {
        vec2 offset = sample_offset(i);
        vec2 at = native_sample
            ? vec2(px) + 0.5 + offset
            : fovea_inverse_offset(fovea, centre + offset) + fovea.gaze_px.xy;
        sum += march_px(at, footprint);
    }
    vec4 radiance = vec4(storable(sum / float(samples_per_pixel)), 1.0);
    if (native_sample) {
        imageStore(hdr, px, radiance);
    } else {
        imageStore(lp, texel, radiance);
    }
}
