//! The frame: which passes there are, in order, and what each reads and writes.

use super::foveation::MappingKind;
use crate::content::{GpuContent, GpuScene};
use crate::error::{Error, Result};
use crate::fovea::Kernel;
use crate::gpu::Context;
use crate::gpu::pipeline::Spec;
use crate::graph::{Access, Graph, Plan, ResourceId};
use crate::passes::{
    FiniteCheck, Footprint, Forward, FrameArgs, FrameBuffers, FullShade, GBuffer, Inverse, Keep, LeftEye,
    LpClassify, LpDispatch, LpFilter, LpRoom, LpShade, LpTables, Output, PostFilter, Shadow, TargetSizes,
    Targets,
};
use crate::plan::EffectPlan;
use crate::settings::{self, Method, RenderSettings};
use ash::vk;
use std::sync::Arc;

/// Makes the images and buffers that the passes of a configuration need.
pub(super) fn make_targets(
    context: &Arc<Context>,
    content: &GpuContent,
    settings: &RenderSettings,
    effects: &EffectPlan,
    lp: LpRoom,
    kept: bool,
) -> Result<Targets> {
    Targets::new(
        context,
        settings,
        &TargetSizes {
            lp,
            gbuffer: matches!(content, GpuContent::Scene(_)),
            shadow_views: effects.shadow_views,
            shadows: effects.shadows,
            post_filter: effects.post_filter,
            lp_filter: effects.lp_filter != settings::LpFilter::None,
            kept,
            footprint: effects.footprint_maps,
        },
    )
}

/// The frame's resources.
struct Ids {
    scene: ResourceId,
    fovea: ResourceId,
    shadow_maps: ResourceId,
    gbuffer: ResourceId,
    depth: ResourceId,
    tables: ResourceId,
    samples: ResourceId,
    counts: ResourceId,
    indirect: ResourceId,
    stats: ResourceId,
    lp: ResourceId,
    lp_filtered: ResourceId,
    footprint: ResourceId,
    hdr: ResourceId,
    post_scratch: ResourceId,
    kept: ResourceId,
    /// What the right eye reads of the left one.
    left: Option<ResourceId>,
    target: ResourceId,
    findings: ResourceId,
}

impl Ids {
    fn declare(graph: &mut Graph<FrameArgs>, eyes: &Eyes<'_>) -> Self {
        Self {
            scene: graph.input("scene"),
            fovea: graph.input("fovea"),
            shadow_maps: graph.input("shadow maps"),
            gbuffer: graph.resource("gbuffer"),
            depth: graph.resource("depth"),
            tables: graph.resource("lp tables"),
            samples: graph.resource("sample list"),
            counts: graph.input("sample counts"),
            indirect: graph.resource("indirect"),
            stats: graph.resource("sample statistics"),
            lp: graph.resource("lp"),
            lp_filtered: graph.resource("lp filtered"),
            footprint: graph.resource("footprint"),
            hdr: graph.resource("hdr"),
            post_scratch: graph.resource("post filter scratch"),
            kept: graph.resource("kept picture"),
            left: eyes.left.as_ref().map(|_| graph.input("left eye")),
            target: graph.resource("target"),
            findings: graph.input("findings"),
        }
    }
}

/// What every part of the frame is built from.
struct Builder<'a> {
    context: &'a Arc<Context>,
    content: &'a GpuContent,
    settings: &'a RenderSettings,
    effects: &'a EffectPlan,
    targets: &'a Arc<Targets>,
    buffers: &'a FrameBuffers,
    kind: MappingKind,
    eyes: &'a Eyes<'a>,
    ids: Ids,
    graph: Graph<FrameArgs>,
}

/// What an eye has to do with the other one.
#[derive(Default)]
pub(super) struct Eyes<'a> {
    /// Its shaded picture is kept for the other eye before anything is drawn over it.
    pub(super) keeps: bool,
    /// It takes from this one.
    pub(super) left: Option<LeftEye<'a>>,
}

/// Builds the passes and bakes the graph.
// What the graph is made of; one struct for them would be `Builder` again.
#[allow(clippy::too_many_arguments)]
pub(super) fn bake(
    context: &Arc<Context>,
    content: &GpuContent,
    settings: &RenderSettings,
    effects: &EffectPlan,
    targets: &Arc<Targets>,
    buffers: &FrameBuffers,
    format: vk::Format,
    kind: MappingKind,
    eyes: &Eyes<'_>,
) -> Result<Plan<FrameArgs>> {
    let mut graph = Graph::default();
    let ids = Ids::declare(&mut graph, eyes);
    let mut builder =
        Builder { context, content, settings, effects, targets, buffers, kind, eyes, ids, graph };
    if settings.foveated() {
        builder.mapping_tables()?;
    }
    if let GpuContent::Scene(scene) = content {
        builder.geometry(scene)?;
    }
    if settings.foveated() {
        builder.foveated()?;
    } else {
        builder.full()?;
    }
    if let GpuContent::Scene(scene) = content {
        builder.transparency(scene)?;
    }
    builder.finish(format)
}

impl Builder<'_> {
    /// The mapping taken apart, and how coarse it makes the maps.
    fn mapping_tables(&mut self) -> Result<()> {
        let (context, targets, buffers) = (self.context, self.targets, self.buffers);
        let ids = &self.ids;
        let graph = &mut self.graph;
        // The mapping taken apart into columns and rows, once for all texels.
        if self.kind == MappingKind::Kernel {
            let accesses = [(ids.fovea, Access::ComputeRead), (ids.tables, Access::ComputeWrite)];
            graph.pass("lp_tables", &accesses, LpTables::computed(context, targets, buffers)?);
        } else {
            let accesses = [(ids.fovea, Access::CopyRead), (ids.tables, Access::CopyWrite)];
            graph.pass("lp_tables", &accesses, LpTables::copied(context, targets, buffers));
        }
        if self.effects.footprint_maps {
            let accesses = [
                (ids.fovea, Access::ComputeRead),
                (ids.tables, Access::ComputeRead),
                (ids.footprint, Access::ComputeWrite),
            ];
            let spec = mapping_spec(self.kind, &self.settings.method);
            graph.pass("footprint", &accesses, Footprint::new(context, targets, buffers, &spec)?);
        }
        Ok(())
    }

    /// Shadow maps and the G-buffer, both of them at full resolution.
    fn geometry(&mut self, scene: &Arc<GpuScene>) -> Result<()> {
        let ids = &self.ids;
        if self.effects.shadows {
            let pass = Shadow::new(self.context, scene, self.targets, self.buffers, self.effects.alpha_mask)?;
            let accesses = [(ids.scene, Access::VertexRead), (ids.shadow_maps, Access::DepthWrite)];
            self.graph.pass("shadow", &accesses, pass);
        }
        let mut spec = self.effects.material_spec.clone();
        spec.push(("HAS_FOOTPRINT", u32::from(self.effects.footprint_maps)));
        let forced = self.settings.force_effects;
        let pass = GBuffer::new(self.context, scene, self.targets, self.buffers, &spec, forced)?;
        let mut accesses = vec![
            (ids.scene, Access::VertexRead),
            (ids.gbuffer, Access::ColorWrite),
            (ids.depth, Access::DepthWrite),
        ];
        if self.effects.footprint_maps {
            accesses.push((ids.footprint, Access::FragmentRead));
        }
        self.graph.pass("gbuffer", &accesses, pass);
        Ok(())
    }

    /// What a shading pass reads besides its samples.
    fn surface_reads(&self) -> Vec<(ResourceId, Access)> {
        let ids = &self.ids;
        match self.content {
            GpuContent::Scene(_) => vec![
                (ids.gbuffer, Access::ComputeRead),
                (ids.depth, Access::ComputeRead),
                (ids.shadow_maps, Access::ComputeRead),
            ],
            GpuContent::SdfPrimitives => Vec::new(),
        }
    }

    /// The reference: every pixel.
    fn full(&mut self) -> Result<()> {
        let spec = &self.effects.shading_spec;
        let pass = FullShade::new(self.context, self.content, self.targets, self.buffers, spec)?;
        let mut accesses = self.surface_reads();
        accesses.push((self.ids.hdr, Access::ComputeWrite));
        self.graph.pass("full_shade", &accesses, pass);
        Ok(())
    }

    /// Which samples there are, and how many workgroups shade them.
    fn samples(&mut self, mapping_spec: Spec<'_>) -> Result<()> {
        let (context, targets, buffers) = (self.context, self.targets, self.buffers);
        let ids = &self.ids;
        let graph = &mut self.graph;
        // Only texels that land on the display, and the native pixels around the gaze.
        let filtered = self.effects.lp_filter != settings::LpFilter::None;
        let mut accesses = vec![
            (ids.fovea, Access::ComputeRead),
            (ids.tables, Access::ComputeRead),
            (ids.samples, Access::ComputeWrite),
            (ids.counts, Access::ComputeReadWrite),
            (ids.lp, Access::ComputeWrite),
        ];
        if filtered {
            accesses.push((ids.lp_filtered, Access::ComputeWrite));
        }
        if let Some(left) = ids.left {
            // What the other eye has shaded already is stored at once and not listed.
            accesses.extend([
                (left, Access::ComputeRead),
                (ids.gbuffer, Access::ComputeRead),
                (ids.depth, Access::ComputeRead),
                (ids.hdr, Access::ComputeWrite),
            ]);
        }
        let mut spec = mapping_spec.to_vec();
        spec.push(("LP_FILTERED", u32::from(filtered)));
        let left = self.eyes.left.as_ref();
        let pass = LpClassify::new(context, targets, buffers, &spec, left)?;
        graph.pass("lp_classify", &accesses, pass);
        // As many workgroups as there are samples.
        let accesses = [
            (ids.counts, Access::ComputeReadWrite),
            (ids.indirect, Access::ComputeWrite),
            (ids.stats, Access::ComputeWrite),
        ];
        graph.pass("lp_dispatch", &accesses, LpDispatch::new(context, targets, buffers)?);
        Ok(())
    }

    /// Which samples, shade them, filter the periphery, back to the display.
    fn foveated(&mut self) -> Result<()> {
        let (context, targets, buffers) = (self.context, self.targets, self.buffers);
        let mapping_spec = mapping_spec(self.kind, &self.settings.method);
        self.samples(&mapping_spec)?;
        let reads = self.surface_reads();
        let ids = &self.ids;
        let graph = &mut self.graph;
        let mut accesses = reads;
        accesses.extend([
            (ids.fovea, Access::ComputeRead),
            (ids.tables, Access::ComputeRead),
            (ids.samples, Access::ComputeRead),
            (ids.indirect, Access::IndirectRead),
            (ids.lp, Access::ComputeReadWrite),
            (ids.hdr, Access::ComputeWrite),
        ]);
        let mut spec = self.effects.shading_spec.clone();
        spec.extend_from_slice(&mapping_spec);
        let pass = LpShade::new(context, self.content, targets, buffers, &spec)?;
        graph.pass("lp_shade", &accesses, pass);
        if self.effects.lp_filter != settings::LpFilter::None {
            let accesses = [
                (ids.fovea, Access::ComputeRead),
                (ids.tables, Access::ComputeRead),
                (ids.samples, Access::ComputeRead),
                (ids.indirect, Access::IndirectRead),
                (ids.lp, Access::ComputeRead),
                (ids.lp_filtered, Access::ComputeReadWrite),
            ];
            let filter = self.effects.lp_filter;
            let pass = LpFilter::new(context, targets, buffers, filter, &mapping_spec)?;
            graph.pass("lp_filter", &accesses, pass);
        }
        let mut accesses = vec![
            (ids.fovea, Access::ComputeRead),
            (ids.tables, Access::ComputeRead),
            (ids.lp, Access::ComputeRead),
            (ids.hdr, Access::ComputeReadWrite),
        ];
        if self.effects.lp_filter != settings::LpFilter::None {
            accesses.push((ids.lp_filtered, Access::ComputeRead));
        }
        graph.pass("inverse", &accesses, Inverse::new(context, targets, buffers, &mapping_spec)?);
        if self.eyes.keeps {
            let accesses = [(ids.hdr, Access::CopyRead), (ids.kept, Access::CopyWrite)];
            graph.pass("keep", &accesses, Keep::new(context, targets));
            graph.output(ids.kept);
        }
        if self.effects.post_filter {
            let accesses = [
                (ids.fovea, Access::ComputeRead),
                (ids.hdr, Access::ComputeReadWrite),
                (ids.post_scratch, Access::ComputeWrite),
            ];
            graph.pass("post_filter", &accesses, PostFilter::new(context, targets, buffers)?);
        }
        graph.output(ids.stats);
        Ok(())
    }

    /// Blended surfaces, at full resolution over the finished picture: the post filter must not blur
    /// them.
    fn transparency(&mut self, scene: &Arc<GpuScene>) -> Result<()> {
        if !self.effects.forward {
            return Ok(());
        }
        let mut spec = self.effects.shading_spec.clone();
        spec.extend_from_slice(&self.effects.material_spec);
        let forced = self.settings.force_effects;
        let pass = Forward::new(self.context, scene, self.targets, self.buffers, &spec, forced)?;
        let accesses = [
            (self.ids.scene, Access::VertexRead),
            (self.ids.shadow_maps, Access::FragmentRead),
            (self.ids.depth, Access::DepthTest),
            (self.ids.hdr, Access::ColorReadWrite),
        ];
        self.graph.pass("forward", &accesses, pass);
        Ok(())
    }

    fn finish(mut self, format: vk::Format) -> Result<Plan<FrameArgs>> {
        let pass = Output::new(self.context, self.targets, self.buffers, self.settings, format)?;
        let accesses = [(self.ids.hdr, Access::FragmentRead), (self.ids.target, Access::ColorWrite)];
        self.graph.pass("output", &accesses, pass);
        self.graph.output(self.ids.target);
        if self.settings.check_finite {
            let foveated = self.settings.foveated();
            let pass = FiniteCheck::new(self.context, self.targets, self.buffers, foveated)?;
            let mut accesses =
                vec![(self.ids.hdr, Access::ComputeRead), (self.ids.findings, Access::ComputeReadWrite)];
            if foveated {
                accesses.push((self.ids.lp, Access::ComputeRead));
            }
            self.graph.diagnostic_pass("finite_check", &accesses, pass);
            self.graph.output(self.ids.findings);
        }
        // A mistake in the declarations above, not something that a caller can cause.
        self.graph.bake().map_err(|error| Error::Setting(format!("frame graph: {error}")))
    }
}

/// Specialises the passes that map to the mapping's kind and KFR's kernel.
pub(super) fn mapping_spec(kind: MappingKind, method: &Method) -> [(&'static str, u32); 3] {
    let (kernel, alpha) = match method {
        Method::Kfr(kfr) => match kfr.kernel {
            Kernel::Power { alpha } if alpha.fract() == 0.0 => (0, alpha as u32),
            Kernel::Power { .. } => (0, 0),
            Kernel::Polynomial { .. } => (1, 0),
            Kernel::Sine => (2, 0),
            Kernel::Exponential => (3, 0),
        },
        _ => (0, 0),
    };
    [("MAPPING_KIND", kind as u32), ("KERNEL_KIND", kernel), ("INTEGER_ALPHA", alpha)]
}
