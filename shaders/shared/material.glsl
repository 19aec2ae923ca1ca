// A material at a fragment. The specialization constants leave out what no material of the scene has.
layout(constant_id = 10) const bool HAS_NORMAL_MAP = true;
layout(constant_id = 11) const bool HAS_ALPHA_MASK = true;
layout(constant_id = 12) const bool HAS_MATERIAL_EMISSIVE = true;
layout(constant_id = 13) const bool HAS_VERTEX_COLORS = true;
layout(constant_id = 14) const bool HAS_OCCLUSION_MAP = true;
layout(constant_id = 15) const bool HAS_BASE_COLOR_MAP = true;
layout(constant_id = 16) const bool HAS_METALLIC_ROUGHNESS_MAP = true;
layout(constant_id = 17) const bool HAS_EMISSIVE_MAP = true;
// Samples are coarser than pixels; a pass that is not foveated leaves it off.
layout(constant_id = 18) const bool HAS_FOOTPRINT = false;

// By how many mip levels this fragment's sample is coarser than its pixel.
float map_levels = 0.0;

layout(location = 3) in vec4 in_uv;
layout(location = 4) in vec4 in_color;

layout(set = 1, binding = 0) uniform sampler2D base_color_map;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 2) uniform sampler2D normal_map;
layout(set = 1, binding = 3) uniform sampler2D occlusion_map;
layout(set = 1, binding = 4) uniform sampler2D emissive_map;
layout(set = 1, binding = 5) uniform MaterialBlock { Material material; };

// Nothing here branches on `material`, it selects: some software drivers compile a shader anew, at every
// draw of every frame, for the values of a uniform block that it branches on.

// Whether the material has this map; a pipeline with a map is also used for materials without it where
// effects are forced.
bool has_map(TextureUse use_) {
    return use_.row_v.w > 0.5;
}

vec2 map_uv(TextureUse use_) {
    vec3 uv = vec3(mix(in_uv.xy, in_uv.zw, bvec2(use_.row_u.w > 0.5)), 1.0);
    return vec2(dot(use_.row_u.xyz, uv), dot(use_.row_v.xyz, uv));
}

// A map over the sample's footprint; a sample of one pixel gets what it would get without.
vec4 map_at(sampler2D map, vec2 uv) {
    return HAS_FOOTPRINT ? texture(map, uv, map_levels) : texture(map, uv);
}

vec4 map_or_one(sampler2D map, TextureUse use_) {
    return mix(vec4(1.0), map_at(map, map_uv(use_)), bvec4(has_map(use_)));
}

vec3 unit_or(vec3 v, vec3 otherwise) {
    float length2 = dot(v, v);
    // Also false for NaN.
    return length2 > 1e-30 ? v * inversesqrt(length2) : otherwise;
}

vec4 base_color_at() {
    vec4 color = material.base_color;
    if (HAS_BASE_COLOR_MAP) {
        vec4 map = map_or_one(base_color_map, material.base_color_use);
        if (HAS_FOOTPRINT) {
            if (HAS_ALPHA_MASK) {
                // The mask decides on what is there at all, and that stays as in full shading.
                float unbiased = texture(base_color_map, map_uv(material.base_color_use)).a;
                map.a = mix(map.a, unbiased, has_map(material.base_color_use));
            }
        }
        color *= map;
    }
    return HAS_VERTEX_COLORS ? color * in_color : color;
}

// Whether an alpha-masked fragment is dropped.
bool masked_out(vec4 base) {
    return HAS_ALPHA_MASK && base.a < material.emissive.w;
}

