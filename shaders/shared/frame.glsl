// What a frame's passes share. Space "rel": world axes, origin at the eye, metres; so that a scene
// far from the world's origin keeps its precision.

struct FrameParams {
    mat4 clip_from_rel;      // reversed depth: near plane at 1, infinity at 0
    vec4 ray_base;           // ray through display position (0, 0) in rel; its depth along the view axis is 1
    vec4 ray_dx;             // change of the ray per pixel to the right
    vec4 ray_dy;             // change of the ray per pixel down
    vec4 gaze;               // xy: gaze in px; zw: pixels per radian at the display's centre
    uvec2 size;              // display, px
    uint light_count;
    uint directional_count;  // lights from 0 on
    float near;              // metres
    float exposure;
    float env_levels;        // mip levels of the prefiltered environment less one
    float pixel_angle_rad;   // of a pixel at the display's centre
    vec4 env_sh[9];          // irradiance over pi, spherical harmonics to order 2
    uint shadowed_end;       // lights below it are directional or cast shadows
    uint pad0;
    uint pad1;
    uint pad2;
};
