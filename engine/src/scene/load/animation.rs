//! Animations: what they make of the nodes at one time.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DQuat, DVec3};

use gltf::json::Index;
use gltf::json::animation::{Channel, Interpolation, Property, Sampler};
use gltf::json::validation::Checked;

use super::accessor::Accessor;
use super::context::{Context, Outcome, get, label};
use super::nodes::{Pose, quaternion};
use super::parse;

/// Keys around the wanted time: the index of the one before, and if there is one after, how far
/// the time has come towards it (0 to 1) and how many seconds lie between the two.
#[derive(Clone, Copy)]
struct Place {
    key: usize,
    towards_next: Option<(f64, f64)>,
}

/// Applies the file's first animation at `time_s` to the `poses` of all nodes. Files with many
/// animations mean them as alternatives, such as a walk and a run, so playing all would be wrong.
pub fn apply(context: &Context, time_s: f64, poses: &mut [Pose]) -> Outcome<()> {
    let root = &context.document.root;
    let Some(animation) = root.animations.first() else {
        return Ok(());
    };
    let name = label("animation", 0, animation.name.as_deref());
    if root.animations.len() > 1 {
        context.warn(format!("{name} plays; the other {} ignored", root.animations.len() - 1));
    }
    let mut inputs: HashMap<Index<gltf::json::Accessor>, Vec<f64>> = HashMap::new();
    let mut length_s = 0.0f64;
    for sampler in &animation.samplers {
        if let Entry::Vacant(unread) = inputs.entry(sampler.input) {
            let keys = unread.insert(read_keys(context, sampler.input, &name)?);
            length_s = keys.last().copied().unwrap_or(0.0).max(length_s);
        }
    }
    let within = (0.0..=length_s).contains(&time_s);
    let time_s = if within || length_s <= 0.0 { time_s } else { time_s.rem_euclid(length_s) };
    for (index, channel) in animation.channels.iter().enumerate() {
        let user = format!("{name}, channel {index}");
        let Some(node) = parse::optional(channel.target.node) else {
            context.warn(format!("{user} ignored: it moves no node"));
            continue;
        };
        let pose = poses
            .get_mut(node)
            .ok_or_else(|| format!("{user} names node {node}, but the file has {}", root.nodes.len()))?;
        let sampler = get(&animation.samplers, "sampler", channel.sampler.value(), &user)?;
        // Every sampler's input was read above.
        let keys = inputs.get(&sampler.input).map_or(&[][..], Vec::as_slice);
        apply_channel(context, channel, sampler, keys, time_s, pose, &user)?;
    }
    Ok(())
}

/// The times of a sampler, checked to rise.
fn read_keys(context: &Context, input: Index<gltf::json::Accessor>, name: &str) -> Outcome<Vec<f64>> {
    let user = format!("{name}, times");
    let accessor = Accessor::open(context, input, &user, &[1])?;
    context.charge(accessor.count, size_of::<f64>(), &user)?;
    let keys: Vec<f64> = (0..accessor.count).map(|i| f64::from(accessor.number(i, 0))).collect();
    // Equal times are against the specification and yet common; they do no harm.
    if keys.iter().any(|key| !key.is_finite()) || !keys.is_sorted() {
        return Err(format!("{user}: not all of them are finite and rising"));
    }
    Ok(keys)
}

fn apply_channel(
    context: &Context,
    channel: &Channel,
    sampler: &Sampler,
    keys: &[f64],
    time_s: f64,
    pose: &mut Pose,
    user: &str,
) -> Outcome<()> {
    let Checked::Valid(property) = channel.target.path else {
        context.warn(format!("{user} ignored: what it moves is unknown"));
        return Ok(());
    };
    let lanes: &[usize] = match property {
        Property::Translation | Property::Scale => &[3],
        Property::Rotation => &[4],
        Property::MorphTargetWeights => &[1],
    };
    if pose.matrix.is_some() && lanes != [1] {
        context.warn(format!("{user} ignored: its node has a matrix"));
        return Ok(());
    }
    let Some(place) = place(keys, time_s) else {
        context.warn(format!("{user} ignored: it has no keys"));
        return Ok(());
    };
    let output = Accessor::open(context, sampler.output, user, lanes)?;
    let curve = Curve::new(sampler, &output, keys.len(), lanes == [1], user)?;
    match property {
        Property::Translation => pose.translation = DVec3::from_array(curve.value(place, 0)),
        Property::Scale => pose.scale = DVec3::from_array(curve.value(place, 0)),
        Property::Rotation => pose.rotation = curve.rotation(place),
        // The mesh's targets are not known here; what is too much is never read.
        Property::MorphTargetWeights => {
            context.charge(curve.width, size_of::<f32>(), user)?;
            pose.weights = Some((0..curve.width).map(|i| curve.value::<1>(place, i)[0] as f32).collect());
        }
    }
    if pose.is_finite() { Ok(()) } else { Err(format!("{user} leads to numbers that are not finite")) }
}

fn place(keys: &[f64], time_s: f64) -> Option<Place> {
    let last = keys.len().checked_sub(1)?;
    let key = keys.partition_point(|&key| key <= time_s).saturating_sub(1);
    let seconds = match keys.get(key + 1) {
        Some(next) if key < last && time_s > keys[key] => next - keys[key],
        _ => return Some(Place { key, towards_next: None }),
    };
    // Positive: the time lies between the two keys.
    Some(Place { key, towards_next: Some(((time_s - keys[key]) / seconds, seconds)) })
}

/// A sampler's values.
struct Curve<'a> {
    values: &'a Accessor<'a>,
    interpolation: Interpolation,
    /// Elements for each key: the number of morph targets, else 1.
    width: usize,
}

impl<'a> Curve<'a> {
    fn new(
        sampler: &Sampler,
        values: &'a Accessor<'a>,
        keys: usize,
        many: bool,
        user: &str,
    ) -> Outcome<Self> {
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err(format!("{user} has an unknown interpolation"));
        };
        let for_each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let groups = keys.saturating_mul(for_each);
        let width = if many { values.count / groups.max(1) } else { 1 };
        if width.saturating_mul(groups) > values.count {
            return Err(format!("{user} has {keys} keys but only {} values", values.count));
        }
        Ok(Self { values, interpolation, width })
    }

    /// Element `item` of key `key`; `part` of a cubic key is 0, 1 or 2: tangent in, value, tangent out.
    fn at<const N: usize>(&self, key: usize, part: usize, item: usize) -> [f64; N] {
        let group = if self.interpolation == Interpolation::CubicSpline { key * 3 + part } else { key };
        std::array::from_fn(|lane| f64::from(self.values.number(group * self.width + item, lane)))
    }

    fn value<const N: usize>(&self, place: Place, item: usize) -> [f64; N] {
        let before: [f64; N] = self.at(place.key, 1, item);
        let Some((t, seconds)) = place.towards_next else {
            return before;
        };
        let after: [f64; N] = self.at(place.key + 1, 1, item);
        match self.interpolation {
            Interpolation::Step => before,
            Interpolation::Linear => std::array::from_fn(|i| before[i] + (after[i] - before[i]) * t),
            Interpolation::CubicSpline => {
                let leave: [f64; N] = self.at(place.key, 2, item);
                let arrive: [f64; N] = self.at(place.key + 1, 0, item);
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|i| {
                    before[i] * (2.0 * t3 - 3.0 * t2 + 1.0)
                        + leave[i] * (t3 - 2.0 * t2 + t) * seconds
                        + after[i] * (3.0 * t2 - 2.0 * t3)
                        + arrive[i] * (t3 - t2) * seconds
                })
            }
        }
    }

    fn rotation(&self, place: Place) -> DQuat {
        match (self.interpolation, place.towards_next) {
            (Interpolation::Linear, Some((t, _))) => {
                let before = quaternion(self.at(place.key, 1, 0));
                let after = quaternion(self.at(place.key + 1, 1, 0));
                // Takes the shorter way round.
                before.slerp(after, t)
            }
            _ => quaternion(self.value(place, 0)),
        }
    }
}
