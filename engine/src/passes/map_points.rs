//! The mapping's coordinates of single points, from the functions that the passes use.

use crate::error::Result;
use crate::fovea::{FoveaParams, LpCoord};
use crate::gpu::pipeline::Bind;
use crate::gpu::resource::Location;
use crate::gpu::{Buffer, ComputePipeline, Context, shaders, submit};
use ash::vk;
use glam::DVec2;
use std::sync::Arc;

/// Maps display positions (px) to LP coordinates on the GPU.
///
/// # Errors
/// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
pub fn map_points(context: &Arc<Context>, params: &FoveaParams, points_px: &[DVec2]) -> Result<Vec<LpCoord>> {
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
    let fovea = submit::upload_buffer(context, "fovea of points", &[*params], uniform)?;
    let hi_lo = |value: f64| (value as f32, (value - f64::from(value as f32)) as f32);
    let points: Vec<[f32; 4]> = points_px
        .iter()
        .map(|point| {
            let ((x, x_lo), (y, y_lo)) = (hi_lo(point.x), hi_lo(point.y));
            [x, y, x_lo, y_lo]
        })
        .collect();
    let input = submit::upload_buffer(context, "points", &points, storage)?;
    let output = Buffer::new(context, "mapped points", 16 * points.len() as u64, storage, Location::Readback)?;
    let shader = &shaders::MAP_POINTS_COMP;
    let binds: Vec<_> = shader
        .bindings
        .iter()
        .zip([Bind::Buffer(&fovea), Bind::Buffer(&input), Bind::Buffer(&output)])
        .map(|(binding, bind)| (binding.name, bind))
        .collect();
    let pipeline = ComputePipeline::new(context, shader, &[], &binds)?;
    let count = u32::try_from(points.len()).unwrap_or(u32::MAX);
    submit::submit_and_wait(context, "mapping points", |commands| {
        pipeline.bind(commands, 0, &count);
        // SAFETY: `commands` is being recorded with the pipeline bound.
        unsafe { context.device.cmd_dispatch(commands, count.div_ceil(64), 1, 1) };
        submit::full_barrier(context, commands);
        Ok(())
    })?;
    let mapped: &[[f32; 4]] = bytemuck::cast_slice(output.bytes());
    let coordinate = |of: &[f32; 4]| LpCoord {
        u_norm: f64::from(of[0]) + f64::from(of[1]),
        v_norm: f64::from(of[2]) + f64::from(of[3]),
    };
    Ok(mapped.iter().take(points.len()).map(coordinate).collect())
}
