//! What one eye's renderer has to do with the other's.

use super::Renderer;
use super::graph_of::Eyes;
use crate::error::Result;
use crate::gpu::pipeline::FRAME_SLOTS;
use crate::gpu::resource::Location;
use crate::gpu::structs::ReuseParams;
use crate::gpu::{Buffer, Context};
use crate::passes::{LeftEye, Targets};
use crate::plan::EffectPlan;
use crate::stats::EffectNote;
use crate::stereo::ReuseSettings;
use ash::vk;
use glam::DVec3;
use std::sync::Arc;

/// Which of two eyes.
pub(crate) enum Role<'a> {
    /// It is rendered by itself.
    Alone,
    /// Another eye takes from it.
    Left,
    /// It takes from this one what looks the same from both.
    Right(&'a Renderer, ReuseSettings),
}

impl Role<'_> {
    /// Tells the plan's readers.
    pub(super) fn note(&self, effects: &mut EffectPlan) {
        let Self::Right(_, settings) = self else { return };
        let why = format!(
            "surfaces that the left eye sees too, of roughness {} or more and metallic {} or less",
            settings.least_roughness, settings.greatest_metallic
        );
        effects.effects.run.push(EffectNote { name: "reprojection", why });
    }
}

/// The right eye's part.
pub(super) struct Reuse {
    settings: ReuseSettings,
    params: Vec<Buffer>,
    /// Keeps the images alive that this eye's passes read.
    _left_targets: Arc<Targets>,
    /// In the frame that is recorded next, world.
    pub(super) left_eye: DVec3,
}

impl Reuse {
    pub(super) fn of(context: &Arc<Context>, role: &Role<'_>) -> Result<Option<Self>> {
        let Role::Right(left, settings) = role else { return Ok(None) };
        let size = size_of::<ReuseParams>() as u64;
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let buffer = |slot| Buffer::new(context, &format!("reuse {slot}"), size, usage, Location::Upload);
        Ok(Some(Self {
            settings: *settings,
            params: (0..FRAME_SLOTS).map(buffer).collect::<Result<_>>()?,
            _left_targets: left.targets.clone(),
            left_eye: DVec3::ZERO,
        }))
    }

    /// Writes a slot's block for a frame seen from `eye`, world.
    pub(super) fn write(&mut self, slot: usize, eye: DVec3) {
        let record = ReuseParams {
            left_from_right: (eye - self.left_eye).as_vec3().extend(0.0).to_array(),
            least_roughness: self.settings.least_roughness,
            greatest_metallic: self.settings.greatest_metallic,
            depth_tolerance: self.settings.depth_tolerance,
            least_normal_cosine: self.settings.least_normal_cosine,
        };
        self.params[slot].write(0, &[record]);
    }
}

/// What the graph is told.
pub(super) fn eyes<'a>(role: &Role<'a>, reuse: Option<&'a Reuse>, effects: &EffectPlan) -> Eyes<'a> {
    match (role, reuse) {
        (Role::Left, _) => Eyes { keeps: effects.forward || effects.post_filter, left: None },
        (Role::Right(left, _), Some(reuse)) => Eyes {
            keeps: false,
            left: Some(LeftEye { targets: &left.targets, buffers: &left.buffers, params: &reuse.params }),
        },
        _ => Eyes::default(),
    }
}
