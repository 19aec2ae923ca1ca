//! The frame graph: passes declare what they read and write; barriers, order and what is left out
//! follow from that when the graph is baked. Recording a baked plan allocates nothing. The graph
//! knows no pass.

mod access;
mod plan;

pub use access::{Access, Dependency, History, dependency};
pub(crate) use plan::record_barrier;
pub use plan::{Plan, PlanStep};

use std::fmt;

/// A resource of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResourceId(usize);

/// A pass: records its commands. `F` is what the renderer hands to every pass.
pub trait Pass<F> {
    /// Whether there is anything to record in this frame. The pass' barrier is recorded in any case,
    /// since later ones build on it.
    fn wanted(&self, _frame: &F) -> bool {
        true
    }

    /// Records. Barriers, labels and timestamps are around it already.
    fn record(&self, commands: ash::vk::CommandBuffer, frame: &F);
}

/// What a pass declares.
pub(crate) struct PassDecl<F> {
    pub(crate) name: &'static str,
    pub(crate) accesses: Vec<(ResourceId, Access)>,
    pub(crate) diagnostic: bool,
    pub(crate) pass: Box<dyn Pass<F>>,
}

/// A graph while it is being declared.
pub struct Graph<F> {
    resources: Vec<Resource>,
    passes: Vec<PassDecl<F>>,
}

pub(crate) struct Resource {
    pub(crate) name: String,
    /// Written before the frame, by the CPU or at load.
    pub(crate) input: bool,
    /// Wanted after the frame.
    pub(crate) output: bool,
}

/// A mistake in a graph's declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GraphError {
    /// A pass reads what no earlier pass has written and is not an input.
    ReadBeforeWrite {
        /// The pass.
        pass: &'static str,
        /// The resource.
        resource: String,
    },
    /// A pass declares a resource twice.
    DeclaredTwice {
        /// The pass.
        pass: &'static str,
        /// The resource.
        resource: String,
    },
    /// Nothing writes an output.
    OutputNotWritten {
        /// The resource.
        resource: String,
    },
}

impl fmt::Display for GraphError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReadBeforeWrite { pass, resource } => {
                write!(f, "pass {pass} reads {resource}, which nothing has written before it")
            }
            Self::DeclaredTwice { pass, resource } => write!(f, "pass {pass} declares {resource} twice"),
            Self::OutputNotWritten { resource } => write!(f, "no pass writes the output {resource}"),
        }
    }
}

impl<F> Default for Graph<F> {
    fn default() -> Self {
        Self { resources: Vec::new(), passes: Vec::new() }
    }
}

impl<F> Graph<F> {
    fn add(&mut self, name: &str, input: bool) -> ResourceId {
        self.resources.push(Resource { name: name.to_owned(), input, output: false });
        ResourceId(self.resources.len() - 1)
    }

    /// A resource that only passes write.
    pub fn resource(&mut self, name: &str) -> ResourceId {
        self.add(name, false)
    }

    /// A resource that holds something before the frame begins.
    pub fn input(&mut self, name: &str) -> ResourceId {
        self.add(name, true)
    }

    /// Says that a resource is wanted after the frame: passes that it needs are recorded.
    pub fn output(&mut self, id: ResourceId) {
        self.resources[id.0].output = true;
    }

    /// Declares a pass. Passes run in the order of declaration.
    pub fn pass(
        &mut self,
        name: &'static str,
        accesses: &[(ResourceId, Access)],
        pass: impl Pass<F> + 'static,
    ) {
        let accesses = accesses.to_vec();
        self.passes.push(PassDecl { name, accesses, diagnostic: false, pass: Box::new(pass) });
    }

    /// Declares a pass that only looks: its time is not part of the frame's.
    pub fn diagnostic_pass(
        &mut self,
        name: &'static str,
        accesses: &[(ResourceId, Access)],
        pass: impl Pass<F> + 'static,
    ) {
        let accesses = accesses.to_vec();
        self.passes.push(PassDecl { name, accesses, diagnostic: true, pass: Box::new(pass) });
    }

    /// Checks the declarations, leaves out what nothing reads, and derives the barriers.
    ///
    /// # Errors
    /// [`GraphError`].
    pub fn bake(self) -> Result<Plan<F>, GraphError> {
        self.validate()?;
        Ok(Plan::bake(self.resources, self.passes))
    }

    fn validate(&self) -> Result<(), GraphError> {
        let mut written: Vec<bool> = self.resources.iter().map(|resource| resource.input).collect();
        for pass in &self.passes {
            for (index, (id, access)) in pass.accesses.iter().enumerate() {
                let resource = || self.resources[id.0].name.clone();
                if pass.accesses[..index].iter().any(|(other, _)| other == id) {
                    return Err(GraphError::DeclaredTwice { pass: pass.name, resource: resource() });
                }
                if access.reads() && !written[id.0] {
                    return Err(GraphError::ReadBeforeWrite { pass: pass.name, resource: resource() });
                }
            }
            for (id, access) in &pass.accesses {
                written[id.0] |= access.writes();
            }
        }
        let missing =
            self.resources.iter().zip(&written).find(|(resource, written)| resource.output && !**written);
        match missing {
            Some((resource, _)) => Err(GraphError::OutputNotWritten { resource: resource.name.clone() }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
