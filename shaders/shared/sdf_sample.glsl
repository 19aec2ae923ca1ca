// Rays of the ray-marched scene.
#include "shared/frame.glsl"
#include "shared/store.glsl"
#include "shared/sdf.glsl"
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 1) uniform SdfCamera { vec4 sdf_eye; uint samples_per_pixel; uint pad0; uint pad1; uint pad2; };

// The eye's radiance from a display position; `footprint_px` is the sample's width.
vec3 march_px(vec2 at_px, float footprint_px) {
    vec3 ray = frame.ray_base.xyz + at_px.x * frame.ray_dx.xyz + at_px.y * frame.ray_dy.xyz;
    return sdf_radiance(sdf_eye.xyz, normalize(ray), frame.pixel_angle_rad * footprint_px);
}

// Offset in -0.5..0.5 of sample `index`: the additive recurrence on the plastic number (R2), which
// fills the square evenly for any count. A single sample sits in the centre.
vec2 sample_offset(uint index) {
    vec2 step_ = vec2(0.7548776662466927, 0.5698402909980532);
    return fract(0.5 + float(index) * step_) - 0.5;
}
