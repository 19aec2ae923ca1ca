//! A thin layer over ash that knows no foveation: a device, named resources, pipelines whose
//! descriptors are bound by name, timestamps. Every object is destroyed when its owner is dropped.

pub mod context;
pub mod owned;
pub mod pipeline;
pub mod reflect;
pub mod resource;
pub mod structs;
pub mod submit;
pub mod timing;

/// The compiled shaders and what they bind, written by the build script.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

pub use context::Context;
pub use pipeline::{Bind, ComputePipeline, GraphicsPipeline};
pub use resource::{Buffer, Image};
