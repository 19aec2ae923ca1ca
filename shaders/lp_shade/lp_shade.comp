// Shades the samples of the list: native pixels into the display image, LP texels into the LP-buffer.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/deferred.glsl"
#include "shared/lp_targets.glsl"
#include "shared/footprint.glsl"
#include "lp_shade/taps.glsl"

void main() {
    uint entry = 0u;
    bool wanted = sample_entry(entry);
    bool native_sample = (entry & NATIVE_SAMPLE) != 0u;
    ivec2 px;
    if (native_sample) {
        px = native_px(entry);
    } else {
        // The texel's centre may lie just outside the display: the inverse pass interpolates with it.
        vec2 at = texel_px(uvec2(lp_texel(entry)));
        px = clamp(ivec2(floor(at)), ivec2(0), ivec2(fovea.size.xy) - 1);
    }
    PixelSurface surface = surface_of_px(wanted, px);
    if (HAS_TAPS && !native_sample && surface.depth > 0.0) {
        gather_taps(uvec2(lp_texel(entry)), surface);
    }
    vec4 radiance = vec4(shade(surface), 1.0);
    if (!wanted) {
        return;
    }
    if (native_sample) {
        imageStore(hdr, px, radiance);
    } else {
        imageStore(lp, lp_texel(entry), radiance);
    }
}
