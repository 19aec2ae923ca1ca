//! A baked graph: passes in order, each with its barrier.

use super::access::{Access, Dependency, History, dependency};
use super::{Pass, PassDecl, Resource};
use crate::gpu::Context;
use crate::gpu::timing::Timestamps;
use ash::vk;
use std::ffi::CString;
use std::fmt::{self, Write as _};

/// One recorded pass.
pub struct PlanStep<F> {
    name: &'static str,
    label: CString,
    diagnostic: bool,
    barrier: Option<Dependency>,
    accesses: Vec<(usize, Access)>,
    pass: Box<dyn Pass<F>>,
}

impl<F> PlanStep<F> {
    /// The pass's name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Not part of the frame's time.
    #[must_use]
    pub fn diagnostic(&self) -> bool {
        self.diagnostic
    }

    /// Whether it records anything in this frame.
    #[must_use]
    pub fn wanted(&self, frame: &F) -> bool {
        self.pass.wanted(frame)
    }

    /// What must be over before it.
    #[must_use]
    pub fn barrier(&self) -> Option<Dependency> {
        self.barrier
    }
}

/// A baked graph.
pub struct Plan<F> {
    resources: Vec<Resource>,
    steps: Vec<PlanStep<F>>,
    left_out: Vec<&'static str>,
}

impl<F> Plan<F> {
    pub(super) fn bake(resources: Vec<Resource>, passes: Vec<PassDecl<F>>) -> Self {
        let live = live_passes(&resources, &passes);
        let mut left_out = Vec::new();
        let mut steps = Vec::new();
        for (pass, live) in passes.into_iter().zip(live) {
            if !live {
                left_out.push(pass.name);
                continue;
            }
            steps.push(PlanStep {
                name: pass.name,
                label: CString::new(pass.name).unwrap_or_default(),
                diagnostic: pass.diagnostic,
                barrier: None,
                accesses: pass.accesses.iter().map(|(id, access)| (id.0, *access)).collect(),
                pass: pass.pass,
            });
        }
        let mut plan = Self { resources, steps, left_out };
        plan.derive_barriers();
        plan
    }

    /// Runs through the frame twice: the second time every resource has the history that the frame
    /// before has left, and the barriers found then hold for the first frame too.
    fn derive_barriers(&mut self) {
        let mut histories = vec![History::default(); self.resources.len()];
        for _ in 0..2 {
            for step in &mut self.steps {
                let mut barrier: Option<Dependency> = None;
                for (resource, access) in &step.accesses {
                    let (needed, after) = dependency(histories[*resource], *access);
                    histories[*resource] = after;
                    if let Some(needed) = needed {
                        barrier = Some(barrier.unwrap_or_default().and(needed));
                    }
                }
                step.barrier = barrier;
            }
        }
    }

    /// The passes that are recorded, in order.
    #[must_use]
    pub fn steps(&self) -> &[PlanStep<F>] {
        &self.steps
    }

    /// Records every pass with its barrier, its debug label and its timestamps. Allocates nothing.
    pub fn record(
        &self,
        context: &Context,
        commands: vk::CommandBuffer,
        times: &Timestamps,
        slot: u32,
        frame: &F,
    ) {
        times.reset(commands, slot);
        times.write(commands, slot, 0);
        for (boundary, step) in (1u32..).zip(&self.steps) {
            if let Some(barrier) = step.barrier {
                record_barrier(context, commands, barrier);
            }
            if step.pass.wanted(frame) {
                context.begin_label(commands, &step.label);
                step.pass.record(commands, frame);
                context.end_label(commands);
            }
            times.write(commands, slot, boundary);
        }
        record_barrier(context, commands, HOST_READ);
    }
}

/// What the passes leave for the CPU.
const HOST_READ: Dependency = Dependency {
    src_stages: vk::PipelineStageFlags2::COMPUTE_SHADER,
    src_access: vk::AccessFlags2::SHADER_WRITE,
    dst_stages: vk::PipelineStageFlags2::HOST,
    dst_access: vk::AccessFlags2::HOST_READ,
};

pub(crate) fn record_barrier(context: &Context, commands: vk::CommandBuffer, of: Dependency) {
    // One global barrier: images of the engine stay in GENERAL layout, so none needs its own.
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(of.src_stages)
        .src_access_mask(of.src_access)
        .dst_stage_mask(of.dst_stages)
        .dst_access_mask(of.dst_access)];
    let info = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: `commands` is being recorded, outside of rendering.
    unsafe { context.device.cmd_pipeline_barrier2(commands, &info) };
}

/// Walks from the outputs back to what they need.
fn live_passes<F>(resources: &[Resource], passes: &[PassDecl<F>]) -> Vec<bool> {
    let mut needed: Vec<bool> = resources.iter().map(|resource| resource.output).collect();
    let mut live = vec![false; passes.len()];
    for (index, pass) in passes.iter().enumerate().rev() {
        live[index] = pass.accesses.iter().any(|(id, access)| access.writes() && needed[id.0]);
        if live[index] {
            for (id, access) in &pass.accesses {
                needed[id.0] |= access.reads();
            }
        }
    }
    live
}

impl<F> fmt::Display for Plan<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |of: &dyn Fn(&Resource) -> bool| {
            let names: Vec<_> = self.resources.iter().filter(|r| of(r)).map(|r| r.name.as_str()).collect();
            if names.is_empty() { "none".to_owned() } else { names.join(", ") }
        };
        writeln!(f, "inputs: {}", list(&|resource| resource.input))?;
        writeln!(f, "outputs: {}", list(&|resource| resource.output))?;
        for (index, step) in self.steps.iter().enumerate() {
            if let Some(barrier) = step.barrier {
                writeln!(f, "   barrier {barrier}")?;
            }
            let (mut reads, mut writes) = (String::new(), String::new());
            for (resource, access) in &step.accesses {
                let name = &self.resources[*resource].name;
                if access.reads() {
                    write!(reads, " {name}")?;
                }
                if access.writes() {
                    write!(writes, " {name}")?;
                }
            }
            let diagnostic = if step.diagnostic { " (diagnostic)" } else { "" };
            writeln!(f, "{:2} {}{diagnostic}: reads{reads}; writes{writes}", index + 1, step.name)?;
        }
        if !self.left_out.is_empty() {
            writeln!(f, "not recorded, since nothing reads what they write: {}", self.left_out.join(", "))?;
        }
        Ok(())
    }
}
