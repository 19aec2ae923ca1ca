//! Work that is submitted and waited for: uploads, layout changes, read-backs. Never in a frame.

use super::context::Context;
use super::resource::{Buffer, Image, Location};
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// Records commands, submits them and waits.
///
/// # Errors
/// [`crate::Error::Vulkan`] and [`crate::Error::DeviceLost`].
pub fn submit_and_wait(
    context: &Context,
    what: &str,
    record: impl FnOnce(vk::CommandBuffer) -> Result<()>,
) -> Result<()> {
    let device = &context.device;
    let pool_info = vk::CommandPoolCreateInfo::default()
        .flags(vk::CommandPoolCreateFlags::TRANSIENT)
        .queue_family_index(context.queue_family);
    // SAFETY: the device is alive; the pool and the fence are destroyed below, after the wait.
    unsafe {
        let pool = Context::check(device.create_command_pool(&pool_info, None), || what.to_owned())?;
        let result = record_and_submit(context, pool, what, record);
        device.destroy_command_pool(pool, None);
        result
    }
}

/// # Safety
/// `pool` must be a live pool of the context's device and queue family.
unsafe fn record_and_submit(
    context: &Context,
    pool: vk::CommandPool,
    what: &str,
    record: impl FnOnce(vk::CommandBuffer) -> Result<()>,
) -> Result<()> {
    let device = &context.device;
    let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
    let begin =
        vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    // SAFETY: the command buffer lives until the caller destroys the pool, and the queue is idle
    // again by then.
    unsafe {
        let commands = Context::check(device.allocate_command_buffers(&info), || what.to_owned())?[0];
        Context::check(device.begin_command_buffer(commands, &begin), || what.to_owned())?;
        record(commands)?;
        Context::check(device.end_command_buffer(commands), || what.to_owned())?;
        let fence = device.create_fence(&vk::FenceCreateInfo::default(), None);
        let fence = Context::check(fence, || what.to_owned())?;
        let list = [commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&list)];
        let result = device
            .queue_submit(context.queue, &submit, fence)
            .and_then(|()| device.wait_for_fences(&[fence], true, u64::MAX));
        device.destroy_fence(fence, None);
        Context::check(result, || what.to_owned())
    }
}

/// Everything before, visible to everything after.
pub fn full_barrier(context: &Context, commands: vk::CommandBuffer) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    // SAFETY: `commands` is being recorded.
    unsafe {
        context.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&barrier));
    }
}

/// Moves images from UNDEFINED to GENERAL, where images of the engine stay.
pub fn to_general(context: &Context, commands: vk::CommandBuffer, images: &[&Image]) {
    let barriers: Vec<_> = images
        .iter()
        .map(|image| {
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(vk::PipelineStageFlags2::NONE)
                .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
                .old_layout(vk::ImageLayout::UNDEFINED)
                .new_layout(vk::ImageLayout::GENERAL)
                .image(image.image)
                .subresource_range(image.whole())
        })
        .collect();
    // SAFETY: `commands` is being recorded.
    unsafe {
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        context.device.cmd_pipeline_barrier2(commands, &info);
    }
}

/// Makes a device buffer that holds `data`.
///
/// # Errors
/// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
pub fn upload_buffer<T: bytemuck::Pod>(
    context: &Arc<Context>,
    name: &str,
    data: &[T],
    usage: vk::BufferUsageFlags,
) -> Result<Buffer> {
    let bytes = size_of_val(data) as u64;
    let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
    let target = Buffer::new(context, name, bytes, usage, Location::Gpu)?;
    if bytes == 0 {
        return Ok(target);
    }
    let source_usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let mut source = Buffer::new(context, "staging", bytes, source_usage, Location::Upload)?;
    source.write(0, data);
    submit_and_wait(context, &format!("uploading {name}"), |commands| {
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: bytes }];
        // SAFETY: both buffers are alive and large enough.
        unsafe { context.device.cmd_copy_buffer(commands, source.buffer, target.buffer, &region) };
        full_barrier(context, commands);
        Ok(())
    })?;
    Ok(target)
}

/// Fills level `level` of an image in GENERAL layout with tightly packed texels, for each of its
/// levels in turn: `levels[i]` holds level `i`.
///
/// # Errors
/// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
pub fn upload_image(context: &Arc<Context>, name: &str, image: &Image, levels: &[&[u8]]) -> Result<()> {
    let bytes: usize = levels.iter().map(|level| level.len().next_multiple_of(16)).sum();
    let usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let mut source = Buffer::new(context, "staging", bytes as u64, usage, Location::Upload)?;
    let mut regions = Vec::with_capacity(levels.len());
    let mut offset = 0;
    for (index, data) in (0u32..).zip(levels) {
        source.write(offset, data);
        regions.push(
            vk::BufferImageCopy::default()
                .buffer_offset(offset as u64)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: image.aspect(),
                    mip_level: index,
                    base_array_layer: 0,
                    layer_count: 1,
                })
                .image_extent(vk::Extent3D {
                    width: (image.size[0] >> index).max(1),
                    height: (image.size[1] >> index).max(1),
                    depth: 1,
                }),
        );
        offset += data.len().next_multiple_of(16);
    }
    submit_and_wait(context, &format!("uploading {name}"), |commands| {
        to_general(context, commands, &[image]);
        // SAFETY: the buffer holds every region, and the image has every level.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            context.device.cmd_copy_buffer_to_image(commands, source.buffer, image.image, layout, &regions);
        }
        full_barrier(context, commands);
        Ok(())
    })
}

/// Reads level 0, layer 0 of an image in GENERAL layout: `bytes_per_texel * width * height` bytes.
///
/// # Errors
/// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
pub fn read_image(context: &Arc<Context>, name: &str, image: &Image, bytes_per_texel: u64) -> Result<Vec<u8>> {
    let bytes = u64::from(image.size[0]) * u64::from(image.size[1]) * bytes_per_texel;
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let target = Buffer::new(context, "read-back", bytes, usage, Location::Readback)?;
    submit_and_wait(context, &format!("reading {name}"), |commands| {
        full_barrier(context, commands);
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: image.aspect(),
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width: image.size[0], height: image.size[1], depth: 1 })];
        // SAFETY: the buffer holds the whole level.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            context.device.cmd_copy_image_to_buffer(commands, image.image, layout, target.buffer, &region);
        }
        full_barrier(context, commands);
        Ok(())
    })?;
    let wanted = usize::try_from(bytes).unwrap_or(usize::MAX);
    Ok(target.bytes()[..wanted].to_vec())
}
