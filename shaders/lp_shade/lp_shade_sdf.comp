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
    vec4 radii = vec4(0.0);
    vec2 direction = vec2(0.0);
    if (!native_sample) {
        radii = column_radii_px(uint(texel.x));
        direction = row_direction(uint(texel.y));
        footprint = max(1.0, max(radii.z - radii.y, row_height_px(radii.x)));
    }
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < samples_per_pixel; ++i) {
        vec4 offset = sample_offsets[i];
        vec2 at = vec2(px) + 0.5 + offset.xy;
        if (!native_sample) {
            // Within the texel the radius is close to linear in u.
            float radius_px = mix(radii.y, radii.z, offset.x + 0.5);
            vec2 turn = offset.zw;
            vec2 turned = vec2(direction.x * turn.x - direction.y * turn.y, direction.x * turn.y + direction.y * turn.x);
            at = turned * radius_px + fovea.gaze_px.xy;
        }
        sum += march_px(at, footprint);
    }
    vec4 radiance = vec4(storable(sum / float(samples_per_pixel)), 1.0);
    if (native_sample) {
        imageStore(hdr, px, radiance);
    } else {
        imageStore(lp, texel, radiance);
    }
}
