//! The mapping's coordinates of single points, from the functions that the passes use.

use crate::error::Result;
use crate::fovea::{ColumnRow, ForwardKnot, FoveaParams, LpCoord};
use crate::gpu::pipeline::{Bind, Spec};
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
    let output =
        Buffer::new(context, "mapped points", 16 * points.len() as u64, storage, Location::Readback)?;
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

/// Which way points are mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Display positions (px) to the column coordinate (texels), the share of the column's height, and how
    /// far past the native region (0 or less: native; 1 or more: from the LP-buffer alone).
    ToLp = 0,
    /// Column coordinate (texels) and share of the column's height to display positions (px).
    ToDisplay = 1,
}

/// The mapping for one gaze as the shaders have it.
pub struct PointTables<'a> {
    /// The block.
    pub params: FoveaParams,
    /// Table by columns and rows; `None` where the GPU computes it.
    pub lp_tables: Option<&'a [ColumnRow]>,
    /// Forward table.
    pub forward: &'a [ForwardKnot],
}

/// What a [`PointMapper`] has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointRoom {
    /// Bytes of the table by columns and rows.
    pub table_bytes: u64,
    /// The GPU computes that table.
    pub computed: bool,
    /// Knots of the forward table.
    pub knots: u64,
}

/// Points that are mapped at a time, 1 MiB of them.
const POINTS_AT_A_TIME: usize = 1 << 16;

/// Maps points on the GPU by the functions that the passes use. Made once for a method and a display, and
/// then used for any gaze.
pub struct PointMapper {
    fovea: Buffer,
    lp_tables: Buffer,
    forward: Buffer,
    points: Buffer,
    mapped: Buffer,
    pipeline: ComputePipeline,
    /// Computes the table by columns and rows.
    fill: Option<ComputePipeline>,
    context: Arc<Context>,
}

impl PointMapper {
    /// `spec`: kind of mapping and kernel.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, spec: Spec<'_>, room: PointRoom) -> Result<Self> {
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let make = |name: &str, size, usage, location| Buffer::new(context, name, size, usage, location);
        let points_size = (size_of::<[f32; 4]>() * POINTS_AT_A_TIME) as u64;
        let knots_size = size_of::<ForwardKnot>() as u64 * room.knots;
        let fovea = make("fovea of points", size_of::<FoveaParams>() as u64, uniform, Location::Upload)?;
        let table_location = if room.computed { Location::Gpu } else { Location::Upload };
        let lp_tables = make("lp tables of points", room.table_bytes, storage, table_location)?;
        let forward = make("forward table of points", knots_size, storage, Location::Upload)?;
        let points = make("points", points_size, storage, Location::Upload)?;
        let mapped = make("mapped points", points_size, storage, Location::Readback)?;
        let binds = [
            ("Fovea", Bind::Buffer(&fovea)),
            ("Points", Bind::Buffer(&points)),
            ("Mapped", Bind::Buffer(&mapped)),
            ("ForwardTable", Bind::Buffer(&forward)),
            ("LpTables", Bind::Buffer(&lp_tables)),
        ];
        let pipeline = ComputePipeline::new(context, &shaders::MAP_POINTS_ANY_COMP, spec, &binds)?;
        let fill_binds = [("Fovea", Bind::Buffer(&fovea)), ("LpTables", Bind::Buffer(&lp_tables))];
        let fill = || ComputePipeline::new(context, &shaders::LP_TABLES_COMP, &[], &fill_binds);
        let fill = room.computed.then(fill).transpose()?;
        let context = context.clone();
        Ok(Self { fovea, lp_tables, forward, points, mapped, pipeline, fill, context })
    }

    /// Inputs and results are read as the way says; what the way does not name is 0.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn map(&mut self, tables: &PointTables<'_>, way: Way, points: &[[f32; 4]]) -> Result<Vec<[f32; 4]>> {
        self.fovea.write(0, &[tables.params]);
        self.forward.write(0, tables.forward);
        if let Some(rows) = tables.lp_tables {
            self.lp_tables.write(0, rows);
        }
        let [_, _, columns, rows] = tables.params.size;
        let mut all = Vec::with_capacity(points.len());
        for part in points.chunks(POINTS_AT_A_TIME) {
            self.points.write(0, part);
            let count = part.len() as u32;
            submit::submit_and_wait(&self.context, "mapping points", |commands| {
                let device = &self.context.device;
                // SAFETY: `commands` is being recorded with the pipelines bound before each dispatch.
                unsafe {
                    if let Some(fill) = &self.fill {
                        fill.bind(commands, 0, &());
                        device.cmd_dispatch(commands, (columns + rows).div_ceil(64), 1, 1);
                        submit::full_barrier(&self.context, commands);
                    }
                    self.pipeline.bind(commands, 0, &[count, way as u32]);
                    device.cmd_dispatch(commands, count.div_ceil(64), 1, 1);
                }
                submit::full_barrier(&self.context, commands);
                Ok(())
            })?;
            let mapped: &[[f32; 4]] = bytemuck::cast_slice(self.mapped.bytes());
            all.extend_from_slice(&mapped[..part.len()]);
        }
        Ok(all)
    }
}
