// Light that a surface sends to the eye. Needs the bindings that lighting_bindings.glsl declares.
// The specialization constants leave out what the scene does not have.

layout(constant_id = 0) const bool HAS_DIRECTIONAL = true;
layout(constant_id = 1) const bool HAS_POINT = true;
layout(constant_id = 2) const bool HAS_SPOT = true;
layout(constant_id = 3) const bool HAS_SHADOWS = true;
layout(constant_id = 4) const bool HAS_ENVIRONMENT = true;
layout(constant_id = 5) const bool HAS_EMISSIVE = true;

// Direction to the environment map: u from atan(x, -z), v from the polar angle; top row is +Y.
vec2 equirect(vec3 d) {
    float u = (d.x == 0.0 && d.z == 0.0) ? 0.5 : 0.5 + atan(d.x, -d.z) / (2.0 * PI);
    return vec2(u, acos(clamp(d.y, -1.0, 1.0)) / PI);
}

vec3 sky_radiance(vec3 direction) {
    return HAS_ENVIRONMENT ? textureLod(sky, equirect(direction), 0.0).rgb : vec3(0.0);
}

// 2x2 percentage-closer filter: share of the light that reaches the point.
float shadow_lookup(uint view, vec3 position, vec3 normal, float distance_m) {
    ShadowView of = shadow_views[view];
    // Along the normal by a texel and a half: the map's own staircase does not shade the surface.
    vec3 moved = position + normal * (1.5 * of.bias.x * distance_m);
    vec4 clip = of.clip_from_rel * vec4(moved, 1.0);
    if (clip.w <= 0.0) {
        return 1.0;
    }
    vec3 ndc = clip.xyz / clip.w;
    vec2 size = vec2(textureSize(shadow_maps, 0).xy);
    vec2 at = (ndc.xy * 0.5 + 0.5) * size - 0.5;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, size - 1.0))) {
        return 1.0;
    }
    ivec2 corner = ivec2(floor(at));
    vec2 f = at - vec2(corner);
    ivec3 c = ivec3(corner, int(view));
    vec4 stored = vec4(
        texelFetch(shadow_maps, c, 0).r, texelFetch(shadow_maps, c + ivec3(1, 0, 0), 0).r,
        texelFetch(shadow_maps, c + ivec3(0, 1, 0), 0).r, texelFetch(shadow_maps, c + ivec3(1, 1, 0), 0).r);
    // Reversed depth: the point is lit where nothing lies nearer, that is greater.
    vec4 lit = vec4(lessThanEqual(stored, vec4(ndc.z)));
    return mix(mix(lit.x, lit.y, f.x), mix(lit.z, lit.w, f.x), f.y);
}

// Which of a point light's six views a direction falls into: +X, -X, +Y, -Y, +Z, -Z.
uint cube_face(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= a.y && a.x >= a.z) {
        return d.x >= 0.0 ? 0u : 1u;
    }
    if (a.y >= a.z) {
        return d.y >= 0.0 ? 2u : 3u;
    }
    return d.z >= 0.0 ? 4u : 5u;
}

// What light `i` adds at a point.
vec3 one_light(Shading s, vec3 position, uint i) {
    vec4 intensity = light_row(i, LIGHT_INTENSITY);
    vec4 at = light_row(i, LIGHT_POSITION);
    vec4 kinds = light_row(i, LIGHT_KINDS);
    float kind = kinds.x;
    vec3 to_light;
    float share = 1.0;
    float distance_m = 1.0;
    if (HAS_DIRECTIONAL && kind == LIGHT_DIRECTIONAL) {
        to_light = -light_row(i, LIGHT_DIRECTION).xyz;
    } else {
        vec3 offset = at.xyz - position;
        float distance2 = dot(offset, offset);
        if (distance2 >= intensity.w) {
            return vec3(0.0);
        }
        // A light on the surface: as if a tenth of a millimetre away.
        distance2 = max(distance2, 1e-8);
        to_light = offset * inversesqrt(distance2);
        // Range window of KHR_lights_punctual.
        float window = distance2 * at.w;
        window = clamp(1.0 - window * window, 0.0, 1.0);
        share = window / distance2;
        distance_m = sqrt(distance2);
        if (HAS_SPOT && kind == LIGHT_SPOT) {
            vec4 direction = light_row(i, LIGHT_DIRECTION);
            float cone = clamp(dot(direction.xyz, -to_light) * direction.w + kinds.z, 0.0, 1.0);
            share *= cone * cone;
        }
    }
    share = dot(s.normal, to_light) > 0.0 ? share : 0.0;
    if (HAS_SHADOWS && kinds.y >= 0.0 && share > 0.0) {
        uint shadow = uint(kinds.y);
        if (HAS_POINT && kind == LIGHT_POINT) {
            shadow += cube_face(-to_light);
        }
        share *= shadow_lookup(shadow, position, s.normal, distance_m);
    }
    return share > 0.0 ? reflected(s, to_light) * (intensity.rgb * share) : vec3(0.0);
}

// Ambient light of the environment: irradiance by spherical harmonics (Ramamoorthi and Hanrahan
// 2001), reflection by the split sum over the prefiltered map.
vec3 ambient(Shading s, vec3 albedo, float metallic, float roughness, float occlusion) {
    vec3 n = s.normal;
    // The basis' constants are in the coefficients.
    vec3 irradiance = frame.env_sh[0].rgb
        + frame.env_sh[1].rgb * n.y + frame.env_sh[2].rgb * n.z + frame.env_sh[3].rgb * n.x
        + frame.env_sh[4].rgb * (n.x * n.y) + frame.env_sh[5].rgb * (n.y * n.z)
        + frame.env_sh[6].rgb * (3.0 * n.z * n.z - 1.0)
        + frame.env_sh[7].rgb * (n.x * n.z) + frame.env_sh[8].rgb * (n.x * n.x - n.y * n.y);
    vec3 diffuse = albedo * (1.0 - metallic) * max(irradiance, vec3(0.0));
    vec2 scale_bias = textureLod(dfg, vec2(s.n_dot_v, roughness), 0.0).rg;
    vec3 specular = s.f0 * scale_bias.x + scale_bias.y;
    vec3 mirrored = reflect(-s.view, n);
    vec3 radiance = textureLod(specular_env, equirect(mirrored), roughness * frame.env_levels).rgb;
    return (diffuse * (1.0 - specular) + radiance * specular) * occlusion;
}

// The part of a surface's radiance that does not come from punctual lights.
vec3 other_light(Shading s, Surface surface) {
    vec3 radiance = vec3(0.0);
    if (HAS_ENVIRONMENT) {
        radiance += ambient(s, surface.albedo, surface.metallic, surface.roughness, surface.occlusion);
    }
    if (HAS_EMISSIVE) {
        radiance += surface.emissive;
    }
    return radiance;
}

// How a surface at `position` (rel) looks from the eye.
Shading shading_at(Surface surface, vec3 position) {
    float distance2 = dot(position, position);
    vec3 view = distance2 > 0.0 ? -position * inversesqrt(distance2) : surface.normal;
    return shading_of(surface.normal, view, surface.albedo, surface.metallic, surface.roughness);
}
