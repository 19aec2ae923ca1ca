// Gaussian on the display whose size grows from the gaze (thesis, Eq. 2.14):
// eta = 3 + 2 ceil((r / e^L - 0.10) / 0.05). Where eta is below 3, and inside the native disc, which
// is exact already, nothing is filtered. One axis at a time: the size varies so slowly that the two
// passes together stay close to the Gaussian of eta^2 taps.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/fovea.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform Fovea { FoveaParams fovea; };
layout(set = 0, binding = 1) uniform texture2D source;
layout(set = 0, binding = 2, rgba16f) uniform writeonly image2D filtered;
layout(push_constant) uniform Push { ivec2 axis; };

void main() {
    ivec2 px = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(fovea.size.xy);
    if (any(greaterThanEqual(px, size))) {
        return;
    }
    float r = distance(vec2(px) + 0.5, fovea.gaze_px.xy);
    int eta = 3 + 2 * int(ceil((r / fovea.ring.w - 0.10) / 0.05));
    int reach = r < fovea.ring.x ? 0 : max((eta - 1) / 2, 0);
    if (reach == 0) {
        imageStore(filtered, px, texelFetch(source, px, 0));
        return;
    }
    // The kernel's edge lies at two standard deviations.
    float falloff = -2.0 / float(reach * reach);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int tap = -reach; tap <= reach; ++tap) {
        ivec2 at = px + tap * axis;
        if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size))) {
            float weight = exp(falloff * float(tap * tap));
            sum += weight * texelFetch(source, at, 0).rgb;
            weights += weight;
        }
    }
    imageStore(filtered, px, vec4(sum / weights, 1.0));
}
