//! The passes, one file and one folder of shaders each. A pass knows the frame graph, the Vulkan
//! layer and what it renders; it does not know the renderer.

mod finite_check;
mod footprint;
mod forward;
mod full_shade;
mod gbuffer;
mod inverse;
mod keep;
mod lp_classify;
mod lp_dispatch;
mod lp_filter;
mod lp_shade;
mod lp_tables;
mod map_points;
mod output;
mod post_filter;
mod shadow;
mod targets;

pub use finite_check::{FINDINGS_PER_IMAGE, FiniteCheck};
pub use footprint::Footprint;
pub use forward::Forward;
pub use full_shade::FullShade;
pub use gbuffer::GBuffer;
pub use inverse::Inverse;
pub use keep::Keep;
pub use lp_classify::{LeftEye, LpClassify};
pub use lp_dispatch::LpDispatch;
pub use lp_filter::LpFilter;
pub use lp_shade::LpShade;
pub use lp_tables::LpTables;
pub use map_points::{PointMapper, PointRoom, PointTables, Way, map_points};
pub use output::Output;
pub use post_filter::PostFilter;
pub use shadow::{MAX_SHADOW_VIEWS, Shadow};
pub use targets::{FrameBuffers, LpRoom, TargetSizes, Targets};

use crate::content::{DrawInstance, GpuContent, GpuScene};
use crate::gpu::pipeline::Bind;
use crate::gpu::{Context, GraphicsPipeline};
use crate::host::TargetImage;
use ash::vk;
use glam::DVec3;

/// What the renderer hands to every pass, each frame.
#[derive(Clone, Debug)]
pub struct FrameArgs {
    /// Frame slot.
    pub slot: usize,
    /// Eye, world.
    pub eye: DVec3,
    /// Where the picture goes.
    pub target: TargetImage,
    /// Instances of the view that the G-buffer holds, nearest first.
    pub opaque: Vec<u32>,
    /// Blended instances of the view, farthest first.
    pub blended: Vec<u32>,
    /// Shadow views of this frame.
    pub shadow_views: u32,
    /// A box, px, that has room for the native pixels, of a late-latched gaze too.
    pub native_box_px: [u32; 2],
}

/// Workgroups for one invocation per texel with groups of 8x8.
fn dispatch_8x8(context: &Context, commands: vk::CommandBuffer, size: [u32; 2]) {
    // SAFETY: `commands` is being recorded with a compute pipeline bound. Image sides are at most
    // 2^14..2^17 texels, so the group counts stay below the 65535 that every device allows.
    unsafe { context.device.cmd_dispatch(commands, size[0].div_ceil(8), size[1].div_ceil(8), 1) };
}

/// Names that `lighting_bindings.glsl` declares.
fn lighting_binds<'a>(
    scene: &'a GpuScene,
    targets: &'a Targets,
    buffers: &'a FrameBuffers,
) -> Vec<(&'static str, Bind<'a>)> {
    let environment = &scene.environment;
    vec![
        ("Frame", Bind::PerSlot(&buffers.frame)),
        ("lights", Bind::PerSlot(&buffers.lights)),
        ("shadow_views", Bind::PerSlot(&buffers.shadow_views)),
        ("shadow_maps", Bind::Image(&targets.shadow_maps)),
        ("sky", Bind::Sampled(&environment.sky, &environment.around)),
        ("specular_env", Bind::Sampled(&environment.specular, &environment.around)),
        ("dfg", Bind::Sampled(&environment.dfg, &environment.clamped)),
    ]
}

/// Names that `deferred.glsl`, or for the ray-marched scene `sdf_sample.glsl`, declares.
fn shading_binds<'a>(
    content: &'a GpuContent,
    targets: &'a Targets,
    buffers: &'a FrameBuffers,
) -> Vec<(&'static str, Bind<'a>)> {
    match content {
        GpuContent::Scene(scene) => {
            let mut binds = lighting_binds(scene, targets, buffers);
            binds.push(("gbuffer", Bind::Image(&targets.gbuffer)));
            binds.push(("depth_buffer", Bind::Image(&targets.depth)));
            binds
        }
        GpuContent::SdfPrimitives => {
            vec![("Frame", Bind::PerSlot(&buffers.frame)), ("SdfCamera", Bind::PerSlot(&buffers.sdf_camera))]
        }
    }
}

/// Sets viewport and scissor to all of an image.
fn set_viewport(context: &Context, commands: vk::CommandBuffer, [width, height]: [u32; 2]) {
    let viewport = [vk::Viewport {
        x: 0.0,
        y: 0.0,
        width: width as f32,
        height: height as f32,
        min_depth: 0.0,
        max_depth: 1.0,
    }];
    let scissor = [vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } }];
    // SAFETY: `commands` is being recorded.
    unsafe {
        context.device.cmd_set_viewport(commands, 0, &viewport);
        context.device.cmd_set_scissor(commands, 0, &scissor);
    }
}

/// Binds the scene's vertices and indices.
fn bind_geometry(scene: &GpuScene, commands: vk::CommandBuffer) {
    let device = &scene.context.device;
    // SAFETY: `commands` is being recorded; the buffers live as long as the scene.
    unsafe {
        device.cmd_bind_vertex_buffers(commands, 0, &[scene.vertices.buffer], &[0]);
        device.cmd_bind_index_buffer(commands, scene.indices.buffer, 0, vk::IndexType::UINT32);
    }
}

/// What was set for the draw before, so that nothing is set twice.
#[derive(Default)]
struct DrawState {
    material: Option<usize>,
    culling: Option<(bool, bool)>,
}

impl DrawState {
    /// Draws one instance relative to the eye, for the eye itself or for a shadow view. Back faces of
    /// single-sided materials are left out for the eye only: light stops at both sides.
    fn draw(
        &mut self,
        scene: &GpuScene,
        commands: vk::CommandBuffer,
        pipeline: &GraphicsPipeline,
        instance: &DrawInstance,
        eye: DVec3,
        shadow_view: Option<u32>,
    ) {
        let mesh = scene.meshes[instance.mesh];
        let device = &scene.context.device;
        let culling = (shadow_view.is_none() && !instance.double_sided, instance.mirrored);
        let mut push = instance.record;
        for (row, value) in push.rel_from_mesh.iter_mut().zip((instance.origin - eye).as_vec3().to_array()) {
            row[3] = value;
        }
        push.view = shadow_view.unwrap_or(0);
        pipeline.push(commands, &push);
        // SAFETY: `commands` is being recorded inside of rendering with `pipeline` bound; the mesh is in
        // range of the bound buffers.
        unsafe {
            if self.culling != Some(culling) {
                let mode = if culling.0 { vk::CullModeFlags::BACK } else { vk::CullModeFlags::NONE };
                let face =
                    if culling.1 { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
                device.cmd_set_cull_mode(commands, mode);
                device.cmd_set_front_face(commands, face);
                self.culling = Some(culling);
            }
            if self.material != Some(instance.material) {
                if pipeline.set1_layout().is_some() {
                    pipeline.bind_set1(commands, scene.material_set(instance.material));
                }
                self.material = Some(instance.material);
            }
            device.cmd_draw_indexed(commands, mesh.index_count, 1, mesh.first_index, mesh.vertex_offset, 0);
        }
    }
}
