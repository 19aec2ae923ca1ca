// The BRDF of glTF 2.0, appendix B: Lambert below a GGX coat with Smith's masking and Schlick's
// Fresnel term.

const float PI = 3.14159265358979;

// Below this the highlight of a punctual light would be narrower than any pixel, and its peak would
// leave the range of half floats. alpha = roughness^2.
const float MIN_ALPHA = 0.002;

struct Shading {
    vec3 normal;
    vec3 view;          // unit, towards the eye
    float n_dot_v;      // in (0, 1]
    float alpha2;
    vec3 diffuse;       // albedo less metal, over pi
    vec3 f0;
};

Shading shading_of(vec3 normal, vec3 view, vec3 albedo, float metallic, float roughness) {
    Shading s;
    s.normal = normal;
    s.view = view;
    // A normal that faces away (interpolation, normal map) counts as grazing.
    s.n_dot_v = clamp(dot(normal, view), 1e-4, 1.0);
    float alpha = max(roughness * roughness, MIN_ALPHA);
    s.alpha2 = alpha * alpha;
    s.diffuse = albedo * ((1.0 - metallic) / PI);
    s.f0 = mix(vec3(0.04), albedo, metallic);
    return s;
}

// Reflected radiance for unit irradiance across the light's direction: BRDF times n.l.
vec3 reflected(Shading s, vec3 light) {
    float n_dot_l = dot(s.normal, light);
    if (n_dot_l <= 0.0) {
        return vec3(0.0);
    }
    n_dot_l = min(n_dot_l, 1.0);
    vec3 sum = light + s.view;
    float length2 = max(dot(sum, sum), 1e-8);
    float inverse_length = inversesqrt(length2);
    float n_dot_h = clamp(dot(s.normal, sum) * inverse_length, 0.0, 1.0);
    float v_dot_h = clamp(dot(s.view, sum) * inverse_length, 0.0, 1.0);
    // GGX: (1 - nh^2) + nh^2 alpha^2 without cancellation for small alpha.
    float d = (1.0 - n_dot_h) * (1.0 + n_dot_h) + n_dot_h * n_dot_h * s.alpha2;
    float distribution = s.alpha2 / (PI * d * d);
    // Smith's masking and shadowing in the separable form that the appendix prints, over 4 nl nv.
    float smith_l = n_dot_l + sqrt(s.alpha2 + (1.0 - s.alpha2) * n_dot_l * n_dot_l);
    float smith_v = s.n_dot_v + sqrt(s.alpha2 + (1.0 - s.alpha2) * s.n_dot_v * s.n_dot_v);
    float visibility = 1.0 / max(smith_l * smith_v, 1e-7);
    float m = 1.0 - v_dot_h;
    float m2 = m * m;
    vec3 fresnel = s.f0 + (1.0 - s.f0) * (m2 * m2 * m);
    return (s.diffuse * (1.0 - fresnel) + fresnel * (distribution * visibility)) * n_dot_l;
}
