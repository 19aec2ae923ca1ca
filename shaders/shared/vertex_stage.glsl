// Vertex inputs, as `macula::scene::Vertex` has them, and the way to space rel. A draw's transform
// comes in push constants: read once for all vertices, not once for each.
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv0;
layout(location = 4) in vec2 in_uv1;
layout(location = 5) in vec4 in_color;

layout(push_constant) uniform Draw {
    vec4 rel_from_mesh[3];      // rows; the last column is the translation
    vec4 rel_from_normal[3];    // rows of the cofactor matrix (xyz); right for any scale and mirroring
    float handedness;           // -1 where the transform turns right into left, else 1
    uint view;                  // shadow view
    uint pad0;
    uint pad1;
} draw;

vec3 rel_position() {
    vec4 p = vec4(in_position, 1.0);
    return vec3(dot(draw.rel_from_mesh[0], p), dot(draw.rel_from_mesh[1], p), dot(draw.rel_from_mesh[2], p));
}

vec3 rel_direction(vec3 v) {
    return vec3(
        dot(draw.rel_from_mesh[0].xyz, v), dot(draw.rel_from_mesh[1].xyz, v), dot(draw.rel_from_mesh[2].xyz, v));
}

vec3 rel_normal() {
    vec3 n = in_normal;
    return vec3(
        dot(draw.rel_from_normal[0].xyz, n), dot(draw.rel_from_normal[1].xyz, n), dot(draw.rel_from_normal[2].xyz, n));
}
