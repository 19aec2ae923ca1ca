//! Structs that shaders read, field by field as in `shaders/shared`.

use crate::gpu_layout;
use bytemuck::{Pod, Zeroable};

/// `FrameParams`: one frame's camera. Space rel has world axes and its origin at the eye.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FrameParams {
    /// Columns.
    pub clip_from_rel: [[f32; 4]; 4],
    /// Ray through display position (0, 0), of depth 1.
    pub ray_base: [f32; 4],
    /// Its change per pixel to the right.
    pub ray_dx: [f32; 4],
    /// Its change per pixel down.
    pub ray_dy: [f32; 4],
    /// Gaze (px), pixels per radian at the centre.
    pub gaze: [f32; 4],
    /// Display, px.
    pub size: [u32; 2],
    /// Number of lights.
    pub light_count: u32,
    /// Lights that are directional; they come first.
    pub directional_count: u32,
    /// Near plane, m.
    pub near: f32,
    /// Factor on radiance.
    pub exposure: f32,
    /// Mip levels of the prefiltered environment less one.
    pub env_levels: f32,
    /// Angle of a pixel at the display's centre.
    pub pixel_angle_rad: f32,
    /// Irradiance over pi.
    pub env_sh: [[f32; 4]; 9],
    /// Lights below it are directional or cast shadows.
    pub shadowed_end: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
    /// Unused.
    pub pad2: u32,
}

gpu_layout!(FrameParams, "FrameParams" {
    clip_from_rel, ray_base, ray_dx, ray_dy, gaze, size, light_count, directional_count, near, exposure,
    env_levels, pixel_angle_rad, env_sh, shadowed_end, pad0, pad1, pad2,
});

/// `Draw`: the push constants of one draw; they fit the 128 bytes that every device has.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Draw {
    /// Rows; the last column is the translation.
    pub rel_from_mesh: [[f32; 4]; 3],
    /// Rows of the cofactor matrix.
    pub rel_from_normal: [[f32; 4]; 3],
    /// -1 where the transform turns right into left, else 1.
    pub handedness: f32,
    /// Shadow view.
    pub view: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
}

gpu_layout!(Draw, "Draw" { rel_from_mesh, rel_from_normal, handedness, view, pad0, pad1 });

/// `TextureUse`
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct TextureUse {
    /// Row for u, and the UV set.
    pub row_u: [f32; 4],
    /// Row for v, and 1 where there is a texture.
    pub row_v: [f32; 4],
}

gpu_layout!(TextureUse, "TextureUse" { row_u, row_v });

/// `Material`
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Material {
    /// Linear, with alpha.
    pub base_color: [f32; 4],
    /// Linear; w: alpha cutoff or -1.
    pub emissive: [f32; 4],
    /// Metallic, roughness, normal scale, occlusion strength.
    pub factors: [f32; 4],
    /// Unlit, blended, double-sided, unused.
    pub flags: [u32; 4],
    /// Base colour.
    pub base_color_use: TextureUse,
    /// Metallic and roughness.
    pub metallic_roughness_use: TextureUse,
    /// Normals.
    pub normal_use: TextureUse,
    /// Occlusion.
    pub occlusion_use: TextureUse,
    /// Emission.
    pub emissive_use: TextureUse,
}

gpu_layout!(Material, "Material" {
    base_color, emissive, factors, flags, base_color_use, metallic_roughness_use, normal_use,
    occlusion_use, emissive_use,
});

/// A light as four texels of a buffer; `lighting_bindings.glsl` names the rows. All of it floats:
/// texel fetches need not keep the bits of integers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Light {
    /// rel; w: 1 / range^2, or 0.
    pub position: [f32; 4],
    /// Linear; w: range^2, or huge.
    pub intensity: [f32; 4],
    /// Unit; w: spot scale.
    pub direction: [f32; 4],
    /// 0 directional, 1 point, 2 spot.
    pub kind: f32,
    /// First shadow view, or -1.
    pub shadow: f32,
    /// Spot offset.
    pub spot_offset: f32,
    /// Unused.
    pub pad0: f32,
}

const _: () = assert!(size_of::<Light>() == 64, "four texels of 16 bytes");

/// A shadow view as five texels of a buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadowView {
    /// Rows.
    pub clip_from_rel: [[f32; 4]; 4],
    /// x: size of a texel at distance 1 m, or anywhere for directional lights.
    pub bias: [f32; 4],
}

const _: () = assert!(size_of::<ShadowView>() == 80, "five texels of 16 bytes");

/// `SampleCounts`
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SampleCounts {
    /// Entries of the sample list.
    pub listed: u32,
    /// LP texels on the display.
    pub on_display: u32,
    /// LP texels in the list.
    pub shaded_texels: u32,
    /// Display pixels in the list.
    pub native_pixels: u32,
    /// LP texels in the list whose centre lies on the display.
    pub shaded_on_display: u32,
    /// Texels and pixels that were taken from the other eye; not in the list.
    pub reused: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
}

gpu_layout!(SampleCounts, "SampleCounts" {
    listed, on_display, shaded_texels, native_pixels, shaded_on_display, reused, pad0, pad1,
});

/// `ReuseParams`: what the right eye may take from the left one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ReuseParams {
    /// From the left eye to the right one, world axes, m; w unused.
    pub left_from_right: [f32; 4],
    /// See [`crate::stereo::ReuseSettings`].
    pub least_roughness: f32,
    /// See there.
    pub greatest_metallic: f32,
    /// See there.
    pub depth_tolerance: f32,
    /// See there.
    pub least_normal_cosine: f32,
}

gpu_layout!(ReuseParams, "ReuseParams" {
    left_from_right, least_roughness, greatest_metallic, depth_tolerance, least_normal_cosine,
});

/// The block `SdfCamera`
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SdfCamera {
    /// Eye, world.
    pub sdf_eye: [f32; 4],
    /// 1 to 16.
    pub samples_per_pixel: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
    /// Unused.
    pub pad2: u32,
    /// For each sample its offset in the pixel or texel, -0.5 to 0.5 across and down, and cosine and
    /// sine of the angle by which the second turns it in the LP-buffer.
    pub sample_offsets: [[f32; 4]; 16],
}

gpu_layout!(SdfCamera, "SdfCamera" { sdf_eye, samples_per_pixel, pad0, pad1, pad2, sample_offsets });

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::reflect::{GpuLayout, check_layout};
    use crate::gpu::shaders::ALL;

    fn check<T: GpuLayout>() {
        match check_layout::<T>(ALL) {
            Ok(compared) => assert!(compared > 0, "no shader has a struct {}", T::NAME),
            Err(difference) => panic!("{difference}"),
        }
    }

    #[test]
    fn every_struct_matches_its_twin_in_glsl() {
        check::<FrameParams>();
        check::<Draw>();
        check::<TextureUse>();
        check::<Material>();
        check::<SampleCounts>();
        check::<ReuseParams>();
        check::<SdfCamera>();
    }

    #[test]
    fn a_moved_field_is_found() {
        #[repr(C)]
        #[derive(Clone, Copy, Pod, Zeroable)]
        struct Moved {
            on_display: u32,
            listed: u32,
            shaded_texels: u32,
            native_pixels: u32,
            shaded_on_display: u32,
            pad0: u32,
            pad1: u32,
            pad2: u32,
        }
        gpu_layout!(Moved, "SampleCounts" {
            on_display, listed, shaded_texels, native_pixels, shaded_on_display, pad0, pad1, pad2,
        });
        let error = check_layout::<Moved>(ALL).expect_err("two fields have changed places");
        assert!(error.contains("SampleCounts.listed: offset 0 in GLSL, 4 in Rust"), "{error}");
    }
}
