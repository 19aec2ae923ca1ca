//! The images and buffers that passes share.

use super::FINDINGS_PER_IMAGE;
use super::footprint::TILE_PX;
use crate::content::{GpuContent, GpuScene};
use crate::error::{Error, Result};
use crate::fovea::FoveaParams;
use crate::gpu::pipeline::FRAME_SLOTS;
use crate::gpu::resource::{ImageDesc, Location};
use crate::gpu::{Buffer, Context, Image, structs, submit};
use crate::settings::RenderSettings;
use ash::vk;
use std::sync::Arc;

/// Images and GPU-only buffers. Images that a configuration does not need have one texel.
pub struct Targets {
    pub(crate) gbuffer: Image,
    pub(crate) depth: Image,
    pub(crate) hdr: Image,
    pub(crate) post_scratch: Image,
    /// The shaded picture, for the other eye.
    pub(crate) kept: Image,
    keeps: bool,
    pub(crate) lp: Image,
    pub(crate) lp_filtered: Image,
    pub(crate) footprint: Image,
    pub(crate) shadow_maps: Image,
    pub(crate) samples: Buffer,
    pub(crate) counts: Buffer,
    pub(crate) indirect: Buffer,
    pub(crate) tables: Buffer,
    pub(crate) forward_table: Buffer,
    /// Texels of the LP-buffer's image; 1x1 for full shading.
    pub lp_size: [u32; 2],
}

/// What the LP-buffer and its lists need to have room for, at any gaze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LpRoom {
    /// Width and height of the image that holds the columns, texels.
    pub size: [u32; 2],
    /// Texels of all columns.
    pub texels: u64,
    /// Native pixels.
    pub native: u64,
    /// Rows of 16 bytes of the tables by columns and rows.
    pub table_rows: u64,
    /// Knots of the forward table.
    pub knots: u64,
}

/// How large the images are.
pub struct TargetSizes {
    /// What the LP-buffer has room for.
    pub lp: LpRoom,
    /// The scene is rasterised.
    pub gbuffer: bool,
    /// Layers of shadow maps; at least 1.
    pub shadow_views: u32,
    /// The shadow maps are drawn.
    pub shadows: bool,
    /// The post filter runs.
    pub post_filter: bool,
    /// The LP filter runs.
    pub lp_filter: bool,
    /// The shaded picture is kept for the other eye.
    pub kept: bool,
    /// Maps are sampled by footprints.
    pub footprint: bool,
}

impl Targets {
    /// Makes them, in GENERAL layout and zeroed where that matters.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] beyond the device's limits, [`crate::Error::Memory`],
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, settings: &RenderSettings, sizes: &TargetSizes) -> Result<Self> {
        use vk::ImageUsageFlags as Usage;
        let display = settings.display.size_px;
        let when = |wanted: bool, size: [u32; 2]| if wanted { size } else { [1, 1] };
        let image =
            |name: &str, size: [u32; 2], format: vk::Format, usage: Usage, layers: u32, array: bool| {
                Image::new(
                    context,
                    &ImageDesc { name, size, layers, levels: 1, format, usage, array_view: array },
                )
            };
        let half = vk::Format::R16G16B16A16_SFLOAT;
        let color = Usage::STORAGE | Usage::SAMPLED | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let LpRoom { size: lp_size, texels, native, .. } = sizes.lp;
        let limit = u64::from(context.limits.max_storage_buffer_range);
        if 4 * (texels + native) > limit {
            let [width, height] = lp_size;
            return Err(Error::Setting(format!(
                "an LP-buffer of {width}x{height} texels needs a list larger than the {limit} bytes of {}; raise sigma or choose a smaller display",
                context.name()
            )));
        }
        let shadow_side = if sizes.shadows { settings.shadow_map_size } else { 1 };
        let depth_usage = Usage::DEPTH_STENCIL_ATTACHMENT | Usage::SAMPLED | Usage::TRANSFER_DST;
        let made = Self {
            gbuffer: image(
                "gbuffer",
                when(sizes.gbuffer, display),
                vk::Format::R32G32B32A32_UINT,
                Usage::COLOR_ATTACHMENT | Usage::SAMPLED,
                1,
                false,
            )?,
            depth: image(
                "depth",
                when(sizes.gbuffer, display),
                vk::Format::D32_SFLOAT,
                depth_usage,
                1,
                false,
            )?,
            hdr: image("hdr", display, half, color | Usage::COLOR_ATTACHMENT, 1, false)?,
            post_scratch: image(
                "post filter scratch",
                when(sizes.post_filter, display),
                half,
                color | Usage::COLOR_ATTACHMENT,
                1,
                false,
            )?,
            kept: image("kept", when(sizes.kept, display), half, color, 1, false)?,
            keeps: sizes.kept,
            lp: image("lp", lp_size, half, color, 1, false)?,
            lp_filtered: image("lp filtered", when(sizes.lp_filter, lp_size), half, color, 1, false)?,
            footprint: image(
                "footprint",
                when(sizes.footprint, display.map(|side| side.div_ceil(TILE_PX))),
                vk::Format::R32_SFLOAT,
                Usage::STORAGE | Usage::SAMPLED | Usage::TRANSFER_SRC,
                1,
                false,
            )?,
            shadow_maps: image(
                "shadow maps",
                [shadow_side; 2],
                vk::Format::D32_SFLOAT,
                depth_usage,
                sizes.shadow_views.max(1),
                true,
            )?,
            samples: storage(context, "sample list", 4 * (texels + native))?,
            counts: storage(context, "sample counts", size_of::<structs::SampleCounts>() as u64)?,
            indirect: storage(context, "indirect", 16)?,
            tables: storage(context, "lp tables", 16 * sizes.lp.table_rows)?,
            forward_table: storage(context, "forward table", 8 * sizes.lp.knots)?,
            lp_size,
        };
        made.initialise(context)?;
        Ok(made)
    }

    /// The picture as it was shaded: without blended surfaces and without the post filter. Only where
    /// [`TargetSizes::kept`] says so, or where neither runs.
    #[must_use]
    pub fn shaded(&self) -> &Image {
        if self.keeps { &self.kept } else { &self.hdr }
    }

    fn initialise(&self, context: &Arc<Context>) -> Result<()> {
        submit::submit_and_wait(context, "preparing the frame's images", |commands| {
            let images = [
                &self.gbuffer,
                &self.depth,
                &self.hdr,
                &self.post_scratch,
                &self.kept,
                &self.lp,
                &self.lp_filtered,
                &self.footprint,
                &self.shadow_maps,
            ];
            submit::to_general(context, commands, &images);
            // SAFETY: `commands` is being recorded, and the images and buffers are alive.
            unsafe {
                let device = &context.device;
                for image in [&self.hdr, &self.post_scratch, &self.lp, &self.lp_filtered] {
                    let black = vk::ClearColorValue { float32: [0.0; 4] };
                    let layout = vk::ImageLayout::GENERAL;
                    device.cmd_clear_color_image(commands, image.image, layout, &black, &[image.whole()]);
                }
                device.cmd_fill_buffer(commands, self.counts.buffer, 0, vk::WHOLE_SIZE, 0);
                device.cmd_fill_buffer(commands, self.indirect.buffer, 0, vk::WHOLE_SIZE, 0);
            }
            submit::full_barrier(context, commands);
            Ok(())
        })
    }
}

fn storage(context: &Arc<Context>, name: &str, size: u64) -> Result<Buffer> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::INDIRECT_BUFFER
        | vk::BufferUsageFlags::TRANSFER_DST;
    Buffer::new(context, name, size, usage, Location::Gpu)
}

/// What the CPU writes and reads each frame, once for each frame slot.
pub struct FrameBuffers {
    pub(crate) frame: Vec<Buffer>,
    pub(crate) fovea: Vec<Buffer>,
    /// What the pass that fills the tables copies, where the CPU computes them.
    pub(crate) lp_tables: Vec<Buffer>,
    pub(crate) forward_tables: Vec<Buffer>,
    pub(crate) lights: Vec<Buffer>,
    pub(crate) shadow_views: Vec<Buffer>,
    pub(crate) sdf_camera: Vec<Buffer>,
    /// Read back: [`structs::SampleCounts`].
    pub(crate) stats: Vec<Buffer>,
    /// Read back: what the check of finite values found.
    pub(crate) findings: Vec<Buffer>,
}

impl FrameBuffers {
    /// Makes them.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, content: &GpuContent, shadow_views: u32, lp: &LpRoom) -> Result<Self> {
        let scene = match content {
            GpuContent::Scene(scene) => Some(scene.as_ref()),
            GpuContent::SdfPrimitives => None,
        };
        let count = |of: fn(&GpuScene) -> usize| scene.map_or(0, of) as u64;
        let slots = |name: &str, size: u64, usage: vk::BufferUsageFlags, location: Location| {
            (0..FRAME_SLOTS)
                .map(|slot| Buffer::new(context, &format!("{name} {slot}"), size, usage, location))
                .collect::<Result<Vec<_>>>()
        };
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let copied = vk::BufferUsageFlags::TRANSFER_SRC;
        let up = Location::Upload;
        let size = |of: usize, count: u64| of as u64 * count.max(1);
        Ok(Self {
            frame: slots("frame", size(size_of::<structs::FrameParams>(), 1), uniform, up)?,
            fovea: slots("fovea", size(size_of::<FoveaParams>(), 1), uniform, up)?,
            lp_tables: slots("lp tables of the CPU", 16 * lp.table_rows, copied, up)?,
            forward_tables: slots("forward table of the CPU", 8 * lp.knots, copied, up)?,
            lights: slots(
                "lights",
                size(size_of::<structs::Light>(), count(|s| s.lights.len())),
                vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER,
                up,
            )?,
            shadow_views: slots(
                "shadow views",
                size(size_of::<structs::ShadowView>(), u64::from(shadow_views)),
                vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER,
                up,
            )?,
            sdf_camera: slots("sdf camera", size(size_of::<structs::SdfCamera>(), 1), uniform, up)?,
            stats: slots(
                "sample statistics",
                size(size_of::<structs::SampleCounts>(), 1),
                storage,
                Location::Readback,
            )?,
            findings: slots("findings", 2 * FINDINGS_PER_IMAGE, storage, Location::Upload)?,
        })
    }
}
