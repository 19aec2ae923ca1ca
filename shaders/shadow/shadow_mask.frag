// Alpha-masked casters: drops what the mask drops.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/scene.glsl"
#include "shared/material.glsl"

void main() {
    if (masked_out(base_color_at())) {
        discard;
    }
}
