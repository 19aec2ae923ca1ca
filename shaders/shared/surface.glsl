// A fragment's surface from its material.
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;

vec3 normal_at() {
    vec3 normal = unit_or(in_normal, unit_or(-in_position, vec3(0.0, 1.0, 0.0)));
    if (!gl_FrontFacing) {
        normal = -normal;
    }
    if (HAS_NORMAL_MAP && material.normal_use.row_v.w > 0.5) {
        vec3 tangent = in_tangent.xyz - normal * dot(normal, in_tangent.xyz);
        float length2 = dot(tangent, tangent);
        if (length2 > 1e-20) {
            tangent *= inversesqrt(length2);
            vec3 bitangent = cross(normal, tangent) * in_tangent.w;
            // A back face keeps its texture's handedness: both axes turn with the normal.
            bitangent = gl_FrontFacing ? bitangent : -bitangent;
            vec3 mapped = texture(normal_map, map_uv(material.normal_use)).xyz * 2.0 - 1.0;
            mapped.xy *= material.factors.z;
            normal = unit_or(tangent * mapped.x + bitangent * mapped.y + normal * mapped.z, normal);
        }
    }
    return normal;
}

Surface surface_at(vec4 base) {
    Surface s;
    s.normal = normal_at();
    s.unlit = material.flags.x != 0u;
    s.albedo = clamp(base.rgb, 0.0, 1.0);
    s.metallic = material.factors.x;
    s.roughness = material.factors.y;
    if (HAS_METALLIC_ROUGHNESS_MAP && material.metallic_roughness_use.row_v.w > 0.5) {
        vec4 map = texture(metallic_roughness_map, map_uv(material.metallic_roughness_use));
        s.roughness *= map.g;
        s.metallic *= map.b;
    }
    s.roughness = clamp(s.roughness, 0.0, 1.0);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    s.occlusion = 1.0;
    if (HAS_OCCLUSION_MAP && material.occlusion_use.row_v.w > 0.5) {
        float map = texture(occlusion_map, map_uv(material.occlusion_use)).r;
        s.occlusion = 1.0 + material.factors.w * (map - 1.0);
    }
    s.emissive = vec3(0.0);
    if (HAS_MATERIAL_EMISSIVE) {
        s.emissive = material.emissive.rgb;
        if (material.emissive_use.row_v.w > 0.5 && HAS_EMISSIVE_MAP) {
            s.emissive *= texture(emissive_map, map_uv(material.emissive_use)).rgb;
        }
    }
    if (s.unlit) {
        s.emissive = base.rgb;
        s.albedo = vec3(0.0);
    }
    return s;
}
