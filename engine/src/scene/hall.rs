//! The generated default scene.
