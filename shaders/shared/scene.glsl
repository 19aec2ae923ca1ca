// Scene data in buffers: instances, materials, lights, shadow views.

struct Instance {
    vec4 rel_from_mesh[3];      // rows; the last column is the translation
    vec4 rel_from_normal[3];    // rows of the cofactor matrix (xyz); right for any scale and mirroring
    uint material;
    uint mirrored;              // 1: the transform turns right into left
    uint pad0;
    uint pad1;
};

struct TextureUse {
    vec4 row_u;                 // xyz: u' = row . (u, v, 1); w: UV set
    vec4 row_v;                 // xyz: v' = row . (u, v, 1); w: 1 where there is a texture
};

struct Material {
    vec4 base_color;
    vec4 emissive;              // rgb; w: alpha cutoff, or -1 where alpha is not masked
    vec4 factors;               // metallic, roughness, normal scale, occlusion strength
    uvec4 flags;                // x: unlit; y: alpha blend; z: double-sided
    TextureUse base_color_use;
    TextureUse metallic_roughness_use;
    TextureUse normal_use;
    TextureUse occlusion_use;
    TextureUse emissive_use;
};

const float LIGHT_DIRECTIONAL = 0.0;
const float LIGHT_POINT = 1.0;
const float LIGHT_SPOT = 2.0;

struct ShadowView {
    mat4 clip_from_rel;         // reversed depth
    vec4 bias;                  // x: world size of a texel at distance 1 (spot, point) or anywhere (directional)
};
