// 3x3 Gaussian in the periphery of the LP-buffer (thesis, section 2.2.3). Wraps in v, not in u. Texels
// that were not shaded have no weight.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/fovea.glsl"
#include "shared/samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1) uniform texture2D lp;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D lp_filtered;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy) + ivec2(first_filtered_column(fovea), 0);
    ivec2 size = ivec2(fovea.size.zw);
    if (any(greaterThanEqual(texel, size))) {
        return;
    }
    vec4 centre = texelFetch(lp, texel, 0);
    if (centre.a == 0.0) {
        imageStore(lp_filtered, texel, vec4(0.0));
        return;
    }
    vec4 sum = 4.0 * centre;
    for (int dv = -1; dv <= 1; ++dv) {
        int v = texel.y + dv;
        v = v < 0 ? v + size.y : (v >= size.y ? v - size.y : v);
        for (int du = -1; du <= 1; ++du) {
            int u = texel.x + du;
            if ((du == 0 && dv == 0) || u < 0 || u >= size.x) {
                continue;
            }
            float weight = (du == 0 || dv == 0) ? 2.0 : 1.0;
            sum += weight * texelFetch(lp, ivec2(u, v), 0);
        }
    }
    // Colours of texels that were not shaded are 0, like their alpha: dividing by the sum of the
    // alphas leaves them out.
    imageStore(lp_filtered, texel, vec4(sum.rgb / sum.a, 1.0));
}
