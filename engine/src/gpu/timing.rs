//! GPU timestamps around passes.

use super::context::Context;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// A timestamp before the first pass and after every pass, for each frame slot.
pub struct Timestamps {
    pool: vk::QueryPool,
    per_slot: u32,
    slots: u32,
    context: Arc<Context>,
}

impl Timestamps {
    /// Room for `passes` passes in each of `slots` frames in flight.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, passes: u32, slots: u32) -> Result<Self> {
        let per_slot = passes + 1;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(per_slot * slots);
        // SAFETY: the device is alive.
        let pool = unsafe { context.device.create_query_pool(&info, None) };
        let pool = Context::check(pool, || "making the timestamp pool".into())?;
        context.set_name(pool, "timestamps");
        Ok(Self { pool, per_slot, slots, context: context.clone() })
    }

    /// Makes a slot's timestamps writable again. Outside of rendering.
    pub fn reset(&self, commands: vk::CommandBuffer, slot: u32) {
        debug_assert!(slot < self.slots);
        // SAFETY: `commands` is being recorded; the caller has waited for the slot's last frame.
        unsafe {
            self.context.device.cmd_reset_query_pool(commands, self.pool, slot * self.per_slot, self.per_slot)
        };
    }

    /// Writes the timestamp before the first pass (`boundary` 0) or after the pass before `boundary`,
    /// once everything before is done. Nothing after begins before it is written: a driver may
    /// otherwise write it late (lavapipe does so up to its next flush), and the time would be
    /// another pass's.
    pub fn write(&self, commands: vk::CommandBuffer, slot: u32, boundary: u32) {
        let query = slot * self.per_slot + boundary;
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let barrier = [vk::MemoryBarrier2::default().src_stage_mask(all).dst_stage_mask(all)];
        let info = vk::DependencyInfo::default().memory_barriers(&barrier);
        // SAFETY: `commands` is being recorded, and the query was reset in it.
        unsafe {
            self.context.device.cmd_write_timestamp2(commands, all, self.pool, query);
            self.context.device.cmd_pipeline_barrier2(commands, &info);
        }
    }

    /// Milliseconds of each of the first `passes` passes of a finished frame, into `out`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read(&self, slot: u32, passes: usize, out: &mut Vec<f64>) -> Result<()> {
        let mut ticks = vec![0u64; passes + 1];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the queries were written by a submitted frame.
        let result = unsafe {
            self.context.device.get_query_pool_results(self.pool, slot * self.per_slot, &mut ticks, flags)
        };
        Context::check(result, || "reading timestamps".into())?;
        let period_ns = f64::from(self.context.limits.timestamp_period);
        out.clear();
        out.extend(ticks.windows(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * period_ns * 1e-6));
        Ok(())
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        // SAFETY: the owner has waited for the frames that wrote to the pool.
        unsafe { self.context.device.destroy_query_pool(self.pool, None) };
    }
}
