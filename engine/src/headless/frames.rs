//! Command buffers and the fence of frames that are rendered one after the other.

use crate::error::Result;
use crate::gpu::Context;
use crate::gpu::pipeline::FRAME_SLOTS;
use ash::vk;
use std::sync::Arc;

/// At most one frame is on its way, since frames share their images; the next can be recorded meanwhile.
pub(super) struct Frames {
    pool: vk::CommandPool,
    /// In turn, so that a frame can be recorded while the one before is rendered.
    commands: [vk::CommandBuffer; FRAME_SLOTS],
    current: usize,
    /// The current frame is recorded and not yet submitted.
    recorded: bool,
    /// Of the frame on its way.
    fence: vk::Fence,
    on_its_way: bool,
    context: Arc<Context>,
}

impl Frames {
    pub(super) fn new(context: &Arc<Context>) -> Result<Self> {
        let mut made = Self {
            pool: vk::CommandPool::null(),
            commands: [vk::CommandBuffer::null(); FRAME_SLOTS],
            current: 0,
            recorded: false,
            fence: vk::Fence::null(),
            on_its_way: false,
            context: context.clone(),
        };
        made.make_commands()?;
        Ok(made)
    }

    fn make_commands(&mut self) -> Result<()> {
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(self.context.queue_family);
        let what = || "preparing to record frames".to_owned();
        let device = &self.context.device;
        // SAFETY: the device is alive; the objects are destroyed with `self`.
        unsafe {
            self.pool = Context::check(device.create_command_pool(&pool, None), what)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(FRAME_SLOTS as u32);
            let commands = Context::check(device.allocate_command_buffers(&info), what)?;
            self.commands.copy_from_slice(&commands);
            self.fence = Context::check(device.create_fence(&vk::FenceCreateInfo::default(), None), what)?;
        }
        Ok(())
    }

    /// Records the next frame. One that was recorded and not launched is dropped.
    pub(super) fn record<T>(&mut self, record: impl FnOnce(vk::CommandBuffer) -> T) -> Result<T> {
        if self.recorded {
            // The buffers of the frame that is still on its way are next in turn.
            self.wait()?;
        }
        self.current = (self.current + 1) % FRAME_SLOTS;
        let commands = self.commands[self.current];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let device = &self.context.device;
        // SAFETY: at most one frame is on its way, in the other command buffer: this one is free.
        unsafe {
            Context::check(device.begin_command_buffer(commands, &begin), rendering)?;
            let result = record(commands);
            Context::check(device.end_command_buffer(commands), rendering)?;
            self.recorded = true;
            Ok(result)
        }
    }

    /// Submits the recorded frame, if there is one. Waits for the one before, if that is still on its way.
    pub(super) fn launch(&mut self) -> Result<()> {
        self.wait()?;
        if !std::mem::take(&mut self.recorded) {
            return Ok(());
        }
        let list = [self.commands[self.current]];
        let submits = [vk::SubmitInfo::default().command_buffers(&list)];
        let device = &self.context.device;
        // SAFETY: the command buffer is recorded, and the fence is free.
        let done = unsafe { device.queue_submit(self.context.queue, &submits, self.fence) };
        self.on_its_way = done.is_ok();
        Context::check(done, rendering)
    }

    /// Waits for the submitted frame, if there is one.
    pub(super) fn wait(&mut self) -> Result<()> {
        if !self.on_its_way {
            return Ok(());
        }
        self.on_its_way = false;
        let fence = [self.fence];
        let device = &self.context.device;
        // SAFETY: the fence is alive.
        let done = unsafe {
            device.wait_for_fences(&fence, true, u64::MAX).and_then(|()| device.reset_fences(&fence))
        };
        Context::check(done, rendering)
    }
}

fn rendering() -> String {
    "rendering a frame".to_owned()
}

impl Drop for Frames {
    fn drop(&mut self) {
        // SAFETY: every frame was waited for; after a lost device nothing runs any more.
        unsafe {
            let _ = self.context.device.device_wait_idle();
            self.context.device.destroy_fence(self.fence, None);
            self.context.device.destroy_command_pool(self.pool, None);
        }
    }
}
