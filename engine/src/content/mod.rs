//! What is rendered, in GPU memory. Several renderers can share it.

mod environment;
mod features;
mod materials;
mod scene;
mod textures;

pub use environment::GpuEnvironment;
pub use features::{MaterialVariant, SceneFeatures};
pub use scene::{DrawInstance, GpuScene, MeshRange};

use crate::error::Result;
use crate::gpu::Context;
use crate::scene::Scene;
use crate::scene::environment::Environment;
use std::sync::Arc;

/// What is rendered.
pub enum Content<'a> {
    /// A triangle scene and what surrounds it.
    Scene {
        /// The scene.
        scene: &'a Scene,
        /// Sky and ambient light.
        environment: Option<&'a Environment>,
    },
    /// The ray-marched scene of signed-distance primitives.
    SdfPrimitives,
}

/// [`Content`] in GPU memory.
pub enum GpuContent {
    /// A triangle scene.
    Scene(Arc<GpuScene>),
    /// The ray-marched scene: its geometry is in the shader.
    SdfPrimitives,
}

impl GpuContent {
    /// Uploads to a context's device.
    ///
    /// # Errors
    /// [`crate::Error::Memory`], [`crate::Error::Vulkan`], and [`crate::Error::Setting`] where a
    /// texture is beyond the device's limits.
    pub fn upload(context: &Arc<Context>, content: &Content<'_>) -> Result<Self> {
        match content {
            Content::Scene { scene, environment } => {
                Ok(Self::Scene(Arc::new(GpuScene::upload(context, scene, *environment)?)))
            }
            Content::SdfPrimitives => Ok(Self::SdfPrimitives),
        }
    }
}
