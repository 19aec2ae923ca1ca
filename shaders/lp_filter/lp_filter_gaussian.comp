// 3x3 Gaussian in the periphery of the LP-buffer (thesis, section 2.2.3): weights 1 2 1 along and across.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/lp_neighbours.glsl"

void main() {
    Centre centre;
    if (!find_centre(centre)) {
        return;
    }
    vec3 own = centre.color;
    vec3 sum = vec3(0.0);
    for (int across = -1; across <= 1; ++across) {
        for (int along = -1; along <= 1; ++along) {
            float weight = float((2 - abs(across)) * (2 - abs(along)));
            sum += weight * (neighbour(centre, across, along) - own);
        }
    }
    store(centre, own + sum / 16.0);
}
