//! The renderer: configure, bake, record. It records into a command buffer of the host and owns
//! nothing of the host's; recording a frame allocates nothing and makes no Vulkan object.

mod camera;
mod frame_data;
mod graph_of;

pub use camera::{CameraFrame, NEAR_M};

use crate::content::{GpuContent, GpuScene};
use crate::error::{Error, Result};
use crate::fovea::{DisplayGeometry, FoveaParams, GazeKeeper, Kernel, KfrMapping};
use crate::gpu::Context;
use crate::gpu::pipeline::FRAME_SLOTS;
use crate::gpu::structs::{FrameParams, SampleCounts};
use crate::gpu::timing::Timestamps;
use crate::graph::Plan;
use crate::host::TargetImage;
use crate::passes::{FrameArgs, FrameBuffers, Targets};
use crate::plan::EffectPlan;
use crate::settings::{Method, RenderSettings};
use crate::stats::{EffectNote, Effects, FrameStats, LpStats, PassTime};
use ash::vk;
use glam::{DMat4, DVec2, DVec3};
use macula_trackers::GazeEstimate;
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
    /// The native disc of any gaze on the display is at most as wide, radius in px.
    widest_disc_px: f32,
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
    /// The native disc that the recorded dispatches have room for, radius in px.
    widest_disc_px: f32,
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
        settings.check()?;
        check_device_limits(context, settings)?;
        let effects = match content {
            GpuContent::Scene(scene) => EffectPlan::of_scene(&scene.features, &scene.lights, settings),
            GpuContent::SdfPrimitives => EffectPlan::of_sdf(settings),
        };
        let targets = Arc::new(graph_of::make_targets(context, content, settings, &effects)?);
        let buffers = FrameBuffers::new(context, content, effects.shadow_views)?;
        let plan = graph_of::bake(context, content, settings, &effects, &targets, &buffers, format)?;
        let passes = u32::try_from(plan.steps().len()).unwrap_or(u32::MAX);
        let times = Timestamps::new(context, passes, FRAME_SLOTS as u32)?;
        let instances = match content {
            GpuContent::Scene(scene) => scene.instances.len(),
            GpuContent::SdfPrimitives => 0,
        };
        let mut made = Self {
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
                native_box_px: 0,
            },
            order: Vec::with_capacity(instances),
            slots: [SlotState::default(); FRAME_SLOTS],
            frame_index: 0,
            widest_disc_px: 0.0,
            effects,
            context: context.clone(),
        };
        made.widest_disc_px = made.widest_disc_px();
        Ok(made)
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
        let fovea = self.fovea_params(gaze_px);
        let widest_disc_px = self.widest_disc_px.max(fovea.ring[0]);
        self.args.native_box_px = (2.0 * widest_disc_px).ceil() as u32 + 2;
        self.buffers.fovea[slot].write(0, &[fovea]);
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
        self.slots[slot] =
            SlotState { gaze_held: !valid, blended: self.args.blended.len(), recorded: true, widest_disc_px };
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
        let mut fovea = self.fovea_params(gaze_px);
        fovea.ring[0] = fovea.ring[0].min(self.slots[slot].widest_disc_px);
        self.buffers.fovea[slot].write(0, &[fovea]);
        let gaze = [gaze_px.x as f32, gaze_px.y as f32];
        self.buffers.frame[slot].write(offset_of!(FrameParams, gaze), &[gaze]);
    }

    /// Of gazes on a grid over the display: the radius changes slowly with the gaze, and is greatest for
    /// the centre, the edges' middles or the corners.
    fn widest_disc_px(&self) -> f32 {
        let size = DVec2::from_array(self.settings.display.size_px.map(f64::from));
        let gazes = (0..25).map(|index| DVec2::new(f64::from(index % 5), f64::from(index / 5)) / 4.0 * size);
        gazes.map(|gaze_px| self.fovea_params(gaze_px).ring[0]).fold(0.0, f32::max)
    }

    /// The mapping for a gaze, with its native disc.
    fn fovea_params(&self, gaze_px: DVec2) -> FoveaParams {
        let display = self.settings.display.size_px;
        let (kernel, sigma, lp_filter) = match &self.settings.method {
            Method::Kfr(kfr) => (kfr.kernel, kfr.sigma, kfr.lp_filter),
            Method::Full => (Kernel::Sine, 1.0, false),
        };
        let mapping = KfrMapping::new(display, gaze_px, kernel, sigma);
        let mut params = FoveaParams::new(&mapping);
        let disc_px = native_radius_px(&self.settings.display, gaze_px, f64::from(params.ring[0]));
        // The sample list's room for native pixels bounds the disc.
        let most_px = (f64::from(self.targets.native_capacity) / std::f64::consts::PI).sqrt() - 1.0;
        params.ring[0] = (disc_px as f32).min(most_px.max(0.0) as f32);
        if !lp_filter {
            params.ring[2] = 1.0;
        }
        params
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
        let lp = matches!(self.settings.method, Method::Kfr(_)).then(|| self.lp_stats(slot));
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
        let [width, height] = self.targets.lp_size;
        LpStats {
            width,
            height,
            texels: u64::from(width) * u64::from(height),
            on_display: u64::from(counts.on_display),
            shaded: u64::from(counts.shaded_texels),
            native_pixels: u64::from(counts.native_pixels),
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

    pub(crate) fn targets(&self) -> &Targets {
        &self.targets
    }
}

/// Eccentricity that the native disc should cover, degrees: the fovea and the parafovea.
const NATIVE_DEG: f64 = 5.0;

/// How much the disc may grow beyond the radius inside which texels are smaller than pixels. Farther
/// out the mapping was asked to be coarse.
const NATIVE_GROWTH: f64 = 1.5;

/// Radius of the native disc, px: the mapping's own, or a little more where the gaze is off the view
/// axis and a degree holds more pixels than at the display's centre.
fn native_radius_px(display: &DisplayGeometry, gaze_px: DVec2, mapping_px: f64) -> f64 {
    let gaze = display.ray_of_px(gaze_px).normalize();
    // Pixels to a degree grow away from the view axis, so the farthest point of the cone around the
    // gaze lies on the side that is away from it.
    let outwards = (gaze.truncate().extend(0.0)).reject_from_normalized(gaze).normalize_or(DVec3::X);
    let edge = gaze + outwards * NATIVE_DEG.to_radians().tan();
    let wanted_px = display.px_of_ray(edge).map_or(f64::INFINITY, |px| px.distance(gaze_px));
    mapping_px.max(wanted_px.min(NATIVE_GROWTH * mapping_px))
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
