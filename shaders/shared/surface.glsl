// A fragment's surface from its material.
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;

// Half an 8-bit step of a normal's component: so much shorter a mip level's normals may be by rounding.
const float NORMAL_MAP_ROUNDING = 1.0 / 255.0;

// What the squared alpha grows by for the normals that the footprint averages beyond those that a pixel
// averages: full shading leaves the variance within a pixel out.
float minified_normals(vec2 uv, vec3 mapped) {
    float of_pixel = min(length(texture(normal_map, uv).xyz * 2.0 - 1.0), 1.0);
    float shorter = clamp(of_pixel - length(mapped) - NORMAL_MAP_ROUNDING, 0.0, 1.0);
    float slope_scale = material.factors.z;
    return alpha2_of_normals(shorter * (2.0 - shorter)) * (slope_scale * slope_scale);
}

vec3 normal_at(out float normals_alpha2) {
    normals_alpha2 = 0.0;
    vec3 normal = unit_or(in_normal, unit_or(-in_position, vec3(0.0, 1.0, 0.0)));
    if (!gl_FrontFacing) {
        normal = -normal;
    }
    if (HAS_NORMAL_MAP) {
        vec2 uv = map_uv(material.normal_use);
        vec3 mapped = map_at(normal_map, uv).xyz * 2.0 - 1.0;
        float minified = 0.0;
        if (HAS_FOOTPRINT) {
            minified = minified_normals(uv, mapped);
        }
        vec3 tangent = in_tangent.xyz - normal * dot(normal, in_tangent.xyz);
        float length2 = dot(tangent, tangent);
        bool is_mapped = has_map(material.normal_use) && length2 > 1e-20;
        tangent *= inversesqrt(max(length2, 1e-20));
        vec3 bitangent = cross(normal, tangent) * in_tangent.w;
        // A back face keeps its texture's handedness: both axes turn with the normal.
        bitangent = gl_FrontFacing ? bitangent : -bitangent;
        mapped.xy *= material.factors.z;
        vec3 turned = unit_or(tangent * mapped.x + bitangent * mapped.y + normal * mapped.z, normal);
        normals_alpha2 = mix(0.0, minified, is_mapped);
        normal = mix(normal, turned, bvec3(is_mapped));
    }
    return normal;
}

Surface surface_at(vec4 base) {
    Surface s;
    float normals_alpha2;
    s.normal = normal_at(normals_alpha2);
    s.unlit = material.flags.x != 0u;
    s.albedo = clamp(base.rgb, 0.0, 1.0);
    s.metallic = material.factors.x;
    s.roughness = material.factors.y;
    if (HAS_METALLIC_ROUGHNESS_MAP) {
        vec4 map = map_or_one(metallic_roughness_map, material.metallic_roughness_use);
        s.roughness *= map.g;
        s.metallic *= map.b;
    }
    s.roughness = widened(clamp(s.roughness, 0.0, 1.0), normals_alpha2);
    s.metallic = clamp(s.metallic, 0.0, 1.0);
    s.occlusion = 1.0;
    if (HAS_OCCLUSION_MAP) {
        float map = map_or_one(occlusion_map, material.occlusion_use).r;
        s.occlusion = 1.0 + material.factors.w * (map - 1.0);
    }
    s.emissive = vec3(0.0);
    if (HAS_MATERIAL_EMISSIVE) {
        s.emissive = material.emissive.rgb;
        if (HAS_EMISSIVE_MAP) {
            s.emissive *= map_or_one(emissive_map, material.emissive_use).rgb;
        }
    }
    s.emissive = mix(s.emissive, base.rgb, bvec3(s.unlit));
    s.albedo = mix(s.albedo, vec3(0.0), bvec3(s.unlit));
    return s;
}
