// Rays of the ray-marched scene.
#include "shared/frame.glsl"
#include "shared/store.glsl"
#include "shared/sdf.glsl"
layout(set = 0, binding = 0) uniform Frame { FrameParams frame; };
layout(set = 0, binding = 1) uniform SdfCamera { vec4 sdf_eye; uint samples_per_pixel; uint pad0; uint pad1; uint pad2; vec4 sample_offsets[16]; };

// The eye's radiance from a display position; `footprint_px` is the sample's width.
vec3 march_px(vec2 at_px, float footprint_px) {
    vec3 ray = frame.ray_base.xyz + at_px.x * frame.ray_dx.xyz + at_px.y * frame.ray_dy.xyz;
    return sdf_radiance(sdf_eye.xyz, normalize(ray), frame.pixel_angle_rad * footprint_px);
}
