// A material at a fragment. The specialization constants leave out what no material of the scene has.
layout(constant_id = 10) const bool HAS_NORMAL_MAPS = true;
layout(constant_id = 11) const bool HAS_ALPHA_MASK = true;
layout(constant_id = 12) const bool HAS_MATERIAL_EMISSIVE = true;
layout(constant_id = 13) const bool HAS_VERTEX_COLORS = true;
layout(constant_id = 14) const bool HAS_OCCLUSION = true;

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec4 in_uv;
layout(location = 4) in vec4 in_color;
layout(location = 5) flat in uint in_material;

layout(set = 0, binding = 10, std430) readonly buffer Materials { Material materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_map;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 2) uniform sampler2D normal_map;
layout(set = 1, binding = 3) uniform sampler2D occlusion_map;
layout(set = 1, binding = 4) uniform sampler2D emissive_map;

vec2 map_uv(TextureUse use_) {
    vec3 uv = vec3(use_.row_u.w > 0.5 ? in_uv.zw : in_uv.xy, 1.0);
    return vec2(dot(use_.row_u.xyz, uv), dot(use_.row_v.xyz, uv));
}

vec3 unit_or(vec3 v, vec3 otherwise) {
    float length2 = dot(v, v);
    // Also false for NaN.
    return length2 > 1e-30 ? v * inversesqrt(length2) : otherwise;
}

vec4 base_color_at() {
    vec4 color = materials[in_material].base_color;
    if (materials[in_material].base_color_use.row_v.w > 0.5) {
        color *= texture(base_color_map, map_uv(materials[in_material].base_color_use));
    }
    return HAS_VERTEX_COLORS ? color * in_color : color;
}

// Whether an alpha-masked fragment is dropped.
bool masked_out(vec4 base) {
    return HAS_ALPHA_MASK && base.a < materials[in_material].emissive.w;
}

vec3 normal_at() {
    vec3 towards_eye = unit_or(-in_position, vec3(0.0, 1.0, 0.0));
    vec3 normal = unit_or(in_normal, towards_eye);
    if (!gl_FrontFacing) {
        normal = -normal;
    }
    if (HAS_NORMAL_MAPS && materials[in_material].normal_use.row_v.w > 0.5) {
        vec3 tangent = in_tangent.xyz - normal * dot(normal, in_tangent.xyz);
        float length2 = dot(tangent, tangent);
        if (length2 > 1e-20) {
            tangent *= inversesqrt(length2);
            vec3 bitangent = cross(normal, tangent) * in_tangent.w;
            // A back face keeps its texture's handedness: both axes turn with the normal.
            bitangent = gl_FrontFacing ? bitangent : -bitangent;
            vec3 mapped = texture(normal_map, map_uv(materials[in_material].normal_use)).xyz * 2.0 - 1.0;
            mapped.xy *= materials[in_material].factors.z;
            normal = unit_or(tangent * mapped.x + bitangent * mapped.y + normal * mapped.z, normal);
        }
    }
    return normal;
}

Surface surface_at(vec4 base) {
    Surface s;
    s.normal = normal_at();
    s.unlit = materials[in_material].flags.x != 0u;
    s.albedo = clamp(base.rgb, 0.0, 1.0);
    s.metallic = materials[in_material].factors.x;
    s.roughness = materials[in_material].factors.y;
    if (materials[in_material].metallic_roughness_use.row_v.w > 0.5) {
        vec4 map = texture(metallic_roughness_map, map_uv(materials[in_material].metallic_roughness_use));
        s.roughness *= map.g;
        s.metallic *= map.b;
    }
    s.roughness = clamp(s.roughness, 0.0, 1.0);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    s.occlusion = 1.0;
    if (HAS_OCCLUSION && materials[in_material].occlusion_use.row_v.w > 0.5) {
        float map = texture(occlusion_map, map_uv(materials[in_material].occlusion_use)).r;
        s.occlusion = 1.0 + materials[in_material].factors.w * (map - 1.0);
    }
    s.emissive = vec3(0.0);
    if (HAS_MATERIAL_EMISSIVE) {
        s.emissive = materials[in_material].emissive.rgb;
        if (materials[in_material].emissive_use.row_v.w > 0.5) {
            s.emissive *= texture(emissive_map, map_uv(materials[in_material].emissive_use)).rgb;
        }
    }
    if (s.unlit) {
        s.emissive = base.rgb;
        s.albedo = vec3(0.0);
    }
    return s;
}
