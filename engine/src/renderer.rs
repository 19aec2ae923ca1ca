//! The renderer: configure, bake, record. It records into a command buffer of the host and owns
//! nothing of the host's; recording a frame allocates nothing and makes no Vulkan object.

mod camera;
mod foveation;
mod frame_data;
mod graph_of;
mod points;
mod reuse;

pub use camera::{CameraFrame, NEAR_M};
pub use points::{GpuMapping, MappedPoint};

use crate::content::{GpuContent, GpuScene};
use crate::error::{Error, Result};
use crate::fovea::{DisplayGeometry, GazeKeeper};
use crate::gpu::Context;
use crate::gpu::pipeline::FRAME_SLOTS;
use crate::gpu::structs::{FrameParams, SampleCounts};
use crate::gpu::timing::Timestamps;
use crate::graph::Plan;
use crate::host::TargetImage;
use crate::passes::{FrameArgs, FrameBuffers, Targets};
use crate::plan::EffectPlan;
use crate::settings::RenderSettings;
use crate::stats::{EffectNote, Effects, FrameStats, LpStats, PassTime};
use ash::vk;
use foveation::Foveation;
use glam::{DMat4, DVec2, DVec3};
use macula_trackers::GazeEstimate;
use reuse::Reuse;
pub(crate) use reuse::Role;
use std::mem::offset_of;
use std::sync::Arc;

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInput {
    /// Where the eye stands: right-handed view space, `-Z` forward, no scale.
    pub world_from_view: DMat4,
    /// Gaze in display pixels, x right and y down; off the display is allowed. Not finite: the last
    /// finite one is used (the display's centre before the first), and
    /// [`FrameStats::gaze_held`] says so.
    pub gaze_px: DVec2,
}

impl FrameInput {
    /// The frame for a gaze estimate. One that has no point on the display's plane becomes a NaN
    /// gaze, for which the last valid one is held.
    #[must_use]
    pub fn from_estimate(world_from_view: DMat4, display: &DisplayGeometry, gaze: &GazeEstimate) -> Self {
        let gaze_px = gaze.unit_direction().and_then(|direction| display.px_of_ray(direction));
        Self { world_from_view, gaze_px: gaze_px.unwrap_or(DVec2::NAN) }
    }
}

/// A recorded frame: which of the frame slots it uses. Its statistics can be read, and the slot used
/// again, once the GPU has finished it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSlot(usize);

/// Records frames of one content with one set of settings.
pub struct Renderer {
    settings: RenderSettings,
    content: Content,
    effects: EffectPlan,
    /// What the plan says of the last recorded frame.
    frame_effects: Effects,
    plan: Plan<FrameArgs>,
    times: Timestamps,
    targets: Arc<Targets>,
    buffers: FrameBuffers,
    keeper: GazeKeeper,
    args: FrameArgs,
    /// Sort keys of the visible instances, kept to allocate nothing.
    order: Vec<(f64, u32)>,
    slots: [SlotState; FRAME_SLOTS],
    frame_index: u32,
    foveation: Foveation,
    /// What it takes from the other eye.
    reuse: Option<Reuse>,
    context: Arc<Context>,
}

enum Content {
    Scene(Arc<GpuScene>),
    Sdf,
}

/// What was true of the frame that a slot holds.
#[derive(Clone, Copy, Debug, Default)]
struct SlotState {
    gaze_held: bool,
    blended: usize,
    recorded: bool,
    /// The native box that the recorded dispatches have room for, px.
    box_px: [u32; 2],
    /// Columns in use, and their texels.
    columns: u32,
    texels: u64,
}

impl Renderer {
    /// Checks the settings, decides which effects run, and builds everything for targets of `format`.
    /// Uses the context's queue while it does.
    ///
    /// # Errors
    /// [`Error::Setting`] for a value out of range or beyond the device's limits,
    /// [`Error::Memory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn new(
        context: &Arc<Context>,
        content: &GpuContent,
        settings: &RenderSettings,
        format: vk::Format,
    ) -> Result<Self> {
        Self::for_eye(context, content, settings, format, &Role::Alone)
    }

    /// As [`Self::new`], for one eye of two.
    pub(crate) fn for_eye(
        context: &Arc<Context>,
        content: &GpuContent,
        settings: &RenderSettings,
        format: vk::Format,
        role: &Role<'_>,
    ) -> Result<Self> {
        settings.check()?;
        check_device_limits(context, settings)?;
        let mut effects = match content {
            GpuContent::Scene(scene) => EffectPlan::of_scene(&scene.features, &scene.lights, settings),
            GpuContent::SdfPrimitives => EffectPlan::of_sdf(settings),
        };
        let mut foveation = Foveation::new(settings);
        let room = foveation.room();
        role.note(&mut effects);
        let reuse = Reuse::of(context, role)?;
        let eyes = reuse::eyes(role, reuse.as_ref(), &effects);
        let targets = graph_of::make_targets(context, content, settings, &effects, room, eyes.keeps)?;
        let targets = Arc::new(targets);
        let mut buffers = FrameBuffers::new(context, content, effects.shadow_views, &room)?;
        foveation.write_fixed_tables(&mut buffers);
        let plan = graph_of::bake(
            context,
            content,
            settings,
            &effects,
            &targets,
            &buffers,
            format,
            foveation.kind(),
            &eyes,
        )?;
        let passes = u32::try_from(plan.steps().len()).unwrap_or(u32::MAX);
        let times = Timestamps::new(context, passes, FRAME_SLOTS as u32)?;
        let instances = match content {
            GpuContent::Scene(scene) => scene.instances.len(),
            GpuContent::SdfPrimitives => 0,
        };
        Ok(Self {
            settings: settings.clone(),
            content: match content {
                GpuContent::Scene(scene) => Content::Scene(scene.clone()),
                GpuContent::SdfPrimitives => Content::Sdf,
            },
            frame_effects: effects.effects.clone(),
            plan,
            times,
            targets,
            buffers,
            keeper: GazeKeeper::new(settings.display.center_px()),
            args: FrameArgs {
                slot: 0,
                eye: DVec3::ZERO,
                target: NO_TARGET,
                opaque: Vec::with_capacity(instances),
                blended: Vec::with_capacity(instances),
                shadow_views: if effects.shadows { effects.shadow_views } else { 0 },
                native_box_px: [0, 0],
            },
            order: Vec::with_capacity(instances),
            slots: [SlotState::default(); FRAME_SLOTS],
            frame_index: 0,
            foveation,
            reuse,
            effects,
            context: context.clone(),
        })
    }

    /// Records a frame. The host submits, and waits for the slot's earlier frame before it records
    /// into the slot again: with [`FRAME_SLOTS`] frames in flight that is the frame before the last.
    pub fn record_frame(
        &mut self,
        commands: vk::CommandBuffer,
        input: &FrameInput,
        target: &TargetImage,
    ) -> FrameSlot {
        let slot = self.frame_index as usize % FRAME_SLOTS;
        let (gaze_px, valid) = self.keeper.accept(input.gaze_px);
        self.args.slot = slot;
        self.args.target = *target;
        let camera = CameraFrame::new(&self.settings.display, &input.world_from_view);
        self.args.eye = camera.eye;
        let fovea = self.foveation.params(gaze_px);
        let [x0, y0, x1, y1] = fovea.native_box;
        let widest_px = self.foveation.widest_box_px();
        self.args.native_box_px =
            [widest_px[0].max((x1 - x0).unsigned_abs()), widest_px[1].max((y1 - y0).unsigned_abs())];
        self.buffers.fovea[slot].write(0, &[fovea]);
        self.foveation.write_gaze_tables(&mut self.buffers, slot);
        match &self.content {
            Content::Scene(scene) => {
                frame_data::choose_visible(scene, &camera, &mut self.args, &mut self.order);
                frame_data::write_scene(
                    scene,
                    &self.effects,
                    &self.settings,
                    &camera,
                    &mut self.buffers,
                    slot,
                );
            }
            Content::Sdf => {
                let [_, lp_height] = self.targets.lp_size;
                frame_data::write_sdf(&self.settings, &camera, lp_height, &mut self.buffers, slot);
            }
        }
        let environment = match &self.content {
            Content::Scene(scene) => Some(&scene.environment),
            Content::Sdf => None,
        };
        let frame = camera.params(&self.settings, gaze_px, &self.effects, environment);
        self.buffers.frame[slot].write(0, &[frame]);
        self.buffers.findings[slot].write(0, &[0u32; 4]);
        if let Some(reuse) = &mut self.reuse {
            reuse.write(slot, camera.eye);
        }
        self.slots[slot] = SlotState {
            gaze_held: !valid,
            blended: self.args.blended.len(),
            recorded: true,
            box_px: self.args.native_box_px,
            columns: fovea.size[2],
            texels: self.foveation.texels_in_use(&fovea),
        };
        self.plan.record(&self.context, commands, &self.times, slot as u32, &self.args);
        self.frame_index = self.frame_index.wrapping_add(1);
        FrameSlot(slot)
    }

    /// Replaces the gaze of a frame that is recorded but not yet submitted: late latching. The gaze lies
    /// in mapped memory that the GPU reads when it executes the frame, so nothing is recorded again.
    ///
    /// The host calls it as late as it can, but before it submits: Vulkan promises that the GPU sees
    /// what the host wrote before the submission. A gaze that is not finite changes nothing.
    pub fn late_latch(&mut self, frame: FrameSlot, gaze_px: DVec2) {
        let FrameSlot(slot) = frame;
        if !gaze_px.is_finite() || !self.slots[slot].recorded {
            return;
        }
        let (gaze_px, _) = self.keeper.accept(gaze_px);
        self.slots[slot].gaze_held = false;
        let fovea = self.foveation.params(gaze_px).within_box(self.slots[slot].box_px);
        self.slots[slot].columns = fovea.size[2];
        self.slots[slot].texels = self.foveation.texels_in_use(&fovea);
        self.buffers.fovea[slot].write(0, &[fovea]);
        self.foveation.write_gaze_tables(&mut self.buffers, slot);
        let gaze = [gaze_px.x as f32, gaze_px.y as f32];
        self.buffers.frame[slot].write(offset_of!(FrameParams, gaze), &[gaze]);
    }

    /// Figures of a frame that the GPU has finished.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn read_stats(&mut self, frame: FrameSlot) -> Result<FrameStats> {
        let FrameSlot(slot) = frame;
        let state = self.slots[slot];
        if !state.recorded {
            return Err(Error::Setting("no frame has been recorded".into()));
        }
        let mut times_ms = Vec::new();
        self.times.read(slot as u32, self.plan.steps().len(), &mut times_ms)?;
        let passes: Vec<_> = self
            .plan
            .steps()
            .iter()
            .zip(times_ms)
            .filter(|(step, _)| step.name() != "forward" || state.blended > 0 || self.settings.force_effects)
            .map(|(step, gpu_ms)| PassTime { name: step.name(), gpu_ms, diagnostic: step.diagnostic() })
            .collect();
        let gpu_ms = passes.iter().filter(|pass| !pass.diagnostic).map(|pass| pass.gpu_ms).sum();
        let [width, height] = self.settings.display.size_px;
        let spp = match self.content {
            Content::Scene(_) => 1,
            Content::Sdf => u64::from(self.settings.samples_per_pixel),
        };
        let lp = self.settings.foveated().then(|| self.lp_stats(slot));
        let samples = match &lp {
            Some(lp) => lp.shaded + lp.native_pixels,
            None => u64::from(width) * u64::from(height),
        };
        let findings: &[u32] = bytemuck::cast_slice(&self.buffers.findings[slot].bytes()[..8]);
        let found = self.settings.check_finite.then(|| (u64::from(findings[0]), u64::from(findings[1])));
        self.note_transparency(state);
        Ok(FrameStats {
            passes,
            gpu_ms,
            samples_shaded: samples * spp,
            lp,
            non_finite: found.map(|(non_finite, _)| non_finite),
            holes: found.map(|(_, holes)| holes),
            gaze_held: state.gaze_held,
        })
    }

    fn lp_stats(&self, slot: usize) -> LpStats {
        let bytes = &self.buffers.stats[slot].bytes()[..size_of::<SampleCounts>()];
        let counts: SampleCounts = bytemuck::pod_read_unaligned(bytes);
        let [_, height] = self.targets.lp_size;
        LpStats {
            width: self.slots[slot].columns,
            height,
            texels: self.slots[slot].texels,
            on_display: u64::from(counts.on_display),
            shaded: u64::from(counts.shaded_texels),
            shaded_on_display: u64::from(counts.shaded_on_display),
            native_pixels: u64::from(counts.native_pixels),
            reused: u64::from(counts.reused),
        }
    }

    /// A scene with blended surfaces needs no forward pass in a view that holds none.
    fn note_transparency(&mut self, state: SlotState) {
        let left_out = self.effects.forward && state.blended == 0 && !self.settings.force_effects;
        let listed = self.frame_effects.skipped.iter().any(|note| note.name == "transparency");
        if left_out && !listed {
            self.frame_effects.run.retain(|note| note.name != "transparency");
            let why = "the view holds no blended surface".to_owned();
            self.frame_effects.skipped.push(EffectNote { name: "transparency", why });
        } else if !left_out && listed && self.effects.forward {
            self.frame_effects = self.effects.effects.clone();
        }
    }

    /// What the effect plan decided for the last frame whose statistics were read.
    #[must_use]
    pub fn effects(&self) -> &Effects {
        &self.frame_effects
    }

    /// The frame graph in words: resources, passes in order, every barrier.
    #[must_use]
    pub fn plan_text(&self) -> String {
        self.plan.to_string()
    }

    /// The settings it was built for.
    #[must_use]
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Where the other eye stands in the frame that is recorded next.
    pub(crate) fn set_left_eye(&mut self, eye: DVec3) {
        if let Some(reuse) = &mut self.reuse {
            reuse.left_eye = eye;
        }
    }

    pub(crate) fn maps_by_footprint(&self) -> bool {
        self.effects.footprint_maps
    }

    pub(crate) fn targets(&self) -> &Targets {
        &self.targets
    }
}

/// Stands in before the first frame.
const NO_TARGET: TargetImage = TargetImage {
    image: vk::Image::null(),
    view: vk::ImageView::null(),
    entry_layout: vk::ImageLayout::UNDEFINED,
    exit_layout: vk::ImageLayout::UNDEFINED,
};

fn check_device_limits(context: &Context, settings: &RenderSettings) -> Result<()> {
    let [width, height] = settings.display.size_px;
    let limit = context.limits.max_image_dimension2_d;
    let most = limit.min(context.limits.max_framebuffer_width).min(context.limits.max_framebuffer_height);
    if width > most || height > most {
        return Err(Error::Setting(format!(
            "the display is {width}x{height} px; {} renders at most {most} px a side",
            context.name()
        )));
    }
    if settings.shadow_map_size > limit {
        return Err(Error::Setting(format!(
            "the shadow map's size is {}; {} has at most {limit}",
            settings.shadow_map_size,
            context.name()
        )));
    }
    Ok(())
}
