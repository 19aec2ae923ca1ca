//! Textures and samplers of a scene.

use crate::error::Result;
use crate::gpu::resource::{ImageDesc, Sampler};
use crate::gpu::{Context, Image, submit};
use crate::scene::{self, Texture, Wrap};
use ash::vk;
use std::collections::HashMap;
use std::sync::Arc;

/// Uploads a texture and makes its mip levels where its sampler asks for them.
pub(super) fn upload(context: &Arc<Context>, texture: &Texture) -> Result<Image> {
    let mipmapped = texture.sampler.mip_linear.is_some();
    let [width, height] = texture.size;
    let levels = if mipmapped { 32 - width.max(height).leading_zeros() } else { 1 };
    let format = if texture.srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM };
    let image = Image::new(
        context,
        &ImageDesc {
            name: &texture.name,
            size: texture.size,
            layers: 1,
            levels,
            format,
            usage: vk::ImageUsageFlags::SAMPLED
                | vk::ImageUsageFlags::TRANSFER_DST
                | vk::ImageUsageFlags::TRANSFER_SRC,
            array_view: false,
        },
    )?;
    submit::upload_image(context, &texture.name, &image, &[&texture.rgba8])?;
    if levels > 1 {
        submit::submit_and_wait(context, "making mip levels", |commands| {
            for level in 1..levels {
                halve(context, commands, &image, level);
            }
            Ok(())
        })?;
    }
    Ok(image)
}

/// Fills a level from the one above it. The filter works on linear values: the format is sRGB where
/// the texels are.
fn halve(context: &Context, commands: vk::CommandBuffer, image: &Image, level: u32) {
    let corner = |level: u32| {
        let side = |of: u32| i32::try_from((of >> level).max(1)).unwrap_or(i32::MAX);
        [vk::Offset3D::default(), vk::Offset3D { x: side(image.size[0]), y: side(image.size[1]), z: 1 }]
    };
    let layers = |level: u32| vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: level,
        base_array_layer: 0,
        layer_count: 1,
    };
    let blit = [vk::ImageBlit {
        src_subresource: layers(level - 1),
        src_offsets: corner(level - 1),
        dst_subresource: layers(level),
        dst_offsets: corner(level),
    }];
    let layout = vk::ImageLayout::GENERAL;
    // SAFETY: `commands` is being recorded, and both levels exist.
    unsafe {
        let device = &context.device;
        device.cmd_blit_image(commands, image.image, layout, image.image, layout, &blit, vk::Filter::LINEAR);
    }
    submit::full_barrier(context, commands);
}

/// One Vulkan sampler for each kind that a scene uses.
#[derive(Default)]
pub(super) struct Samplers(HashMap<scene::Sampler, Sampler>);

impl Samplers {
    pub(super) fn add(&mut self, context: &Arc<Context>, of: &scene::Sampler) -> Result<()> {
        if !self.0.contains_key(of) {
            self.0.insert(*of, Sampler::new(context, "texture sampler", &sampler_info(of))?);
        }
        Ok(())
    }

    pub(super) fn get(&self, of: &scene::Sampler) -> Option<&Sampler> {
        self.0.get(of)
    }
}

fn sampler_info(of: &scene::Sampler) -> vk::SamplerCreateInfo<'static> {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    let filter = |linear: bool| if linear { vk::Filter::LINEAR } else { vk::Filter::NEAREST };
    let mip_mode = if of.mip_linear == Some(true) {
        vk::SamplerMipmapMode::LINEAR
    } else {
        vk::SamplerMipmapMode::NEAREST
    };
    vk::SamplerCreateInfo::default()
        .mag_filter(filter(of.mag_linear))
        .min_filter(filter(of.min_linear))
        .mipmap_mode(mip_mode)
        .address_mode_u(wrap(of.wrap_u))
        .address_mode_v(wrap(of.wrap_v))
        .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .max_lod(if of.mip_linear.is_some() { vk::LOD_CLAMP_NONE } else { 0.25 })
}
