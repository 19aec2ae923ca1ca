//! From declared accesses to barriers, by one pure function.

use ash::vk;
use std::fmt;
use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};

/// How a pass uses a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Written as colour attachment, all of it.
    ColorWrite,
    /// Blended or partly written as colour attachment.
    ColorReadWrite,
    /// Cleared, tested and written as depth attachment.
    DepthWrite,
    /// Tested only, as depth attachment.
    DepthTest,
    /// Read by a compute shader.
    ComputeRead,
    /// Written by a compute shader, all that later passes read.
    ComputeWrite,
    /// Read or partly written by a compute shader.
    ComputeReadWrite,
    /// Read by a vertex shader.
    VertexRead,
    /// Read by a fragment shader.
    FragmentRead,
    /// Read as arguments of an indirect dispatch, and by a compute shader.
    IndirectRead,
    /// Read by a copy.
    CopyRead,
    /// Written by a copy, all that later passes read.
    CopyWrite,
}

impl Access {
    /// The pipeline stages that touch the resource.
    #[must_use]
    pub fn stages(self) -> S {
        match self {
            Self::ColorWrite | Self::ColorReadWrite => S::COLOR_ATTACHMENT_OUTPUT,
            Self::DepthWrite | Self::DepthTest => S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
            Self::ComputeRead | Self::ComputeWrite | Self::ComputeReadWrite => S::COMPUTE_SHADER,
            Self::VertexRead => S::VERTEX_SHADER,
            Self::FragmentRead => S::FRAGMENT_SHADER,
            Self::IndirectRead => S::DRAW_INDIRECT | S::COMPUTE_SHADER,
            Self::CopyRead | Self::CopyWrite => S::COPY,
        }
    }

    /// The kinds of memory access.
    #[must_use]
    pub fn flags(self) -> A {
        match self {
            Self::ColorWrite => A::COLOR_ATTACHMENT_WRITE,
            Self::ColorReadWrite => A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE,
            Self::DepthWrite => A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
            Self::DepthTest => A::DEPTH_STENCIL_ATTACHMENT_READ,
            Self::ComputeRead | Self::VertexRead | Self::FragmentRead => A::SHADER_READ,
            Self::ComputeWrite => A::SHADER_WRITE,
            Self::ComputeReadWrite => A::SHADER_READ | A::SHADER_WRITE,
            Self::IndirectRead => A::INDIRECT_COMMAND_READ | A::SHADER_READ,
            Self::CopyRead => A::TRANSFER_READ,
            Self::CopyWrite => A::TRANSFER_WRITE,
        }
    }

    /// Needs what was written before.
    #[must_use]
    pub fn reads(self) -> bool {
        !matches!(self, Self::ColorWrite | Self::DepthWrite | Self::ComputeWrite | Self::CopyWrite)
    }

    /// Leaves something for later passes.
    #[must_use]
    pub fn writes(self) -> bool {
        matches!(
            self,
            Self::ColorWrite
                | Self::ColorReadWrite
                | Self::DepthWrite
                | Self::ComputeWrite
                | Self::ComputeReadWrite
                | Self::CopyWrite
        )
    }
}

/// What has happened to a resource so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct History {
    /// Stages and access of the last write.
    write: (S, A),
    /// Stages that have read since.
    readers: S,
    /// Where the last write has been made visible.
    visible: (S, A),
}

/// A memory dependency: what must be over, and for whom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dependency {
    /// Stages to wait for.
    pub src_stages: S,
    /// Writes to make available.
    pub src_access: A,
    /// Stages that wait.
    pub dst_stages: S,
    /// Accesses for which the writes become visible.
    pub dst_access: A,
}

impl Dependency {
    /// Both in one barrier.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            src_stages: self.src_stages | other.src_stages,
            src_access: self.src_access | other.src_access,
            dst_stages: self.dst_stages | other.dst_stages,
            dst_access: self.dst_access | other.dst_access,
        }
    }
}

impl fmt::Display for Dependency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_none = |text: String| if text.is_empty() { "-".to_owned() } else { text };
        let src = or_none(format!("{:?}", self.src_access));
        let dst = or_none(format!("{:?}", self.dst_access));
        write!(f, "{:?} ({src}) -> {:?} ({dst})", self.src_stages, self.dst_stages)
    }
}

/// The dependency that an access needs after a history, and the history after it.
///
/// A read waits for the last write unless that has been made visible to it already; a write waits
/// for the last write and for every read since.
#[must_use]
pub fn dependency(history: History, next: Access) -> (Option<Dependency>, History) {
    let (stages, flags) = (next.stages(), next.flags());
    let mut after = history;
    let written_before = !history.write.0.is_empty();
    let seen = history.visible.0.contains(stages) && history.visible.1.contains(flags);
    let needed = if next.writes() {
        let src_stages = history.write.0 | history.readers;
        // Reads need only an execution dependency.
        (!src_stages.is_empty()).then_some(Dependency {
            src_stages,
            src_access: history.write.1,
            dst_stages: stages,
            dst_access: flags,
        })
    } else if written_before && !seen {
        Some(Dependency {
            src_stages: history.write.0,
            src_access: history.write.1,
            dst_stages: stages,
            dst_access: flags,
        })
    } else {
        None
    };
    if next.writes() {
        after =
            History { write: (stages, write_flags(flags)), readers: S::NONE, visible: (S::NONE, A::NONE) };
    } else {
        after.readers |= stages;
        if needed.is_some() {
            // The barrier is for these stages together with these accesses; keeping both unions could
            // claim a pair that no barrier named, so the newest pair replaces the old one.
            after.visible = (stages, flags);
        }
    }
    (needed, after)
}

/// The writing part of an access: only writes can be made available.
fn write_flags(flags: A) -> A {
    flags
        & (A::COLOR_ATTACHMENT_WRITE
            | A::DEPTH_STENCIL_ATTACHMENT_WRITE
            | A::SHADER_WRITE
            | A::TRANSFER_WRITE)
}
