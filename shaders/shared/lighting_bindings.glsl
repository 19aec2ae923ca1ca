// What lighting.glsl reads.
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
// Four texels a light, as the Rust struct `Light` has them: texel fetches are what software rasterisers vectorise best, and
// a GPU's texture cache holds them all.
layout(set = 0, binding = 1) uniform textureBuffer lights;
layout(set = 0, binding = 2, std430) readonly buffer ShadowViews { ShadowView shadow_views[]; };
layout(set = 0, binding = 3) uniform texture2DArray shadow_maps;
layout(set = 0, binding = 4) uniform sampler2D sky;
layout(set = 0, binding = 5) uniform sampler2D specular_env;
layout(set = 0, binding = 6) uniform sampler2D dfg;

const uint LIGHT_POSITION = 0u;  // xyz in rel; w: 1 / range^2, 0 for no range
const uint LIGHT_INTENSITY = 1u; // rgb; w: range^2, or a huge value for no range
const uint LIGHT_DIRECTION = 2u; // xyz unit, the way the light shines; w: spot scale
const uint LIGHT_KINDS = 3u;     // kind, first shadow view or -1, spot offset, 0

vec4 light_row(uint light, uint row) {
    return texelFetch(lights, int(4u * light + row));
}
