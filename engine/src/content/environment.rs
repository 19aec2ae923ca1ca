//! Sky and ambient light in GPU memory.

use crate::error::Result;
use crate::gpu::resource::{ImageDesc, Sampler};
use crate::gpu::{Context, Image, submit};
use crate::scene::environment::{Environment, dfg_lut};
use ash::vk;
use half::f16;
use std::sync::{Arc, LazyLock};

/// Texels along each side of the table of the split sum. It is smooth: 64 leave errors below those
/// of the half floats that hold it.
const DFG_SIZE: u32 = 64;
/// Sample directions for each of its texels.
const DFG_SAMPLES: usize = 256;

/// The table does not depend on the scene.
static DFG: LazyLock<Vec<[f32; 2]>> = LazyLock::new(|| dfg_lut(DFG_SIZE as usize, DFG_SAMPLES));

/// An environment's images, or black ones of one texel where there is none (the shaders that do not
/// use them still name them).
pub struct GpuEnvironment {
    pub(crate) sky: Image,
    pub(crate) specular: Image,
    pub(crate) dfg: Image,
    pub(crate) around: Sampler,
    pub(crate) clamped: Sampler,
    /// Irradiance over pi, spherical harmonics to order 2.
    pub sh: [[f32; 4]; 9],
    /// Levels of the prefiltered map.
    pub levels: u32,
}

fn image(context: &Arc<Context>, name: &str, size: [u32; 2], levels: &[Vec<u8>]) -> Result<Image> {
    let desc = ImageDesc {
        name,
        size,
        layers: 1,
        levels: u32::try_from(levels.len()).unwrap_or(1),
        format: vk::Format::R16G16B16A16_SFLOAT,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        array_view: false,
    };
    let image = Image::new(context, &desc)?;
    let levels: Vec<_> = levels.iter().map(Vec::as_slice).collect();
    submit::upload_image(context, name, &image, &levels)?;
    Ok(image)
}

fn halves<'a>(texels: impl Iterator<Item = &'a [f32; 4]>) -> Vec<u8> {
    texels.flat_map(|texel| texel.map(f16::from_f32)).flat_map(f16::to_ne_bytes).collect()
}

impl GpuEnvironment {
    pub(super) fn upload(context: &Arc<Context>, environment: Option<&Environment>) -> Result<Self> {
        let black = [[0.0, 0.0, 0.0, 1.0]];
        let (sky_size, sky) = environment
            .map_or(([1, 1], halves(black.iter())), |of| (of.size, halves(of.pixels.iter())));
        let (specular_size, specular) = environment.map_or(([1, 1], vec![halves(black.iter())]), |of| {
            (of.specular[0].size, of.specular.iter().map(|level| halves(level.pixels.iter())).collect())
        });
        let (dfg_size, dfg) = if environment.is_some() {
            let texels: Vec<_> = DFG.iter().map(|[scale, bias]| [*scale, *bias, 0.0, 1.0]).collect();
            ([DFG_SIZE; 2], halves(texels.iter()))
        } else {
            ([1, 1], halves(black.iter()))
        };
        let linear = |wrap_u| {
            vk::SamplerCreateInfo::default()
                .mag_filter(vk::Filter::LINEAR)
                .min_filter(vk::Filter::LINEAR)
                .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
                .address_mode_u(wrap_u)
                .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                .max_lod(vk::LOD_CLAMP_NONE)
        };
        Ok(Self {
            sky: image(context, "sky", sky_size, &[sky])?,
            levels: u32::try_from(specular.len()).unwrap_or(1),
            specular: image(context, "specular environment", specular_size, &specular)?,
            dfg: image(context, "split-sum table", dfg_size, &[dfg])?,
            around: Sampler::new(context, "environment", &linear(vk::SamplerAddressMode::REPEAT))?,
            clamped: Sampler::new(context, "table", &linear(vk::SamplerAddressMode::CLAMP_TO_EDGE))?,
            sh: environment.map_or([[0.0; 4]; 9], |of| of.diffuse_sh),
        })
    }
}
