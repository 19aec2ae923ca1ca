//! Where the eye goes next.

use super::random::Random;
use super::settings::{Plan, SceneSettings};
use glam::DVec2;

/// Targets nearer than this are no change of place, degrees.
const NEAR_DEG: f64 = 2.0;
/// Tries to find a place within the field before one towards its middle is taken.
const TRIES: usize = 8;
/// Lines of text in the field.
const LINES: f64 = 8.0;
/// Probability that a reader goes back (Rayner 1998: 10 to 15 %).
const REGRESSION: f64 = 0.12;

/// Any place where a block of time may begin: not far from the middle, so that the way there is short.
pub(super) fn anchor_deg(scene: &SceneSettings, random: &mut Random) -> DVec2 {
    let (width, height) = (scene.half_width_deg, scene.half_height_deg);
    match scene.plan {
        Plan::Targets => DVec2::new(random.between(-width, width), random.between(-height, height)),
        Plan::Explore => DVec2::new(random.between(-width, width), random.between(-height, height)) * 0.5,
        Plan::Reading => DVec2::new(-width, line_deg(scene, (random.unit() * LINES).floor())),
    }
}

fn line_deg(scene: &SceneSettings, line: f64) -> f64 {
    scene.half_height_deg * (1.0 - 2.0 * line / (LINES - 1.0))
}

/// The next place after `from_deg`; yaw and pitch, degrees.
pub(super) fn next_deg(scene: &SceneSettings, random: &mut Random, from_deg: DVec2) -> DVec2 {
    let field = DVec2::new(scene.half_width_deg, scene.half_height_deg);
    match scene.plan {
        Plan::Targets => {
            let mut place = from_deg;
            for _ in 0..TRIES {
                place = DVec2::new(random.between(-field.x, field.x), random.between(-field.y, field.y));
                if (NEAR_DEG..scene.max_amplitude_deg).contains(&place.distance(from_deg)) {
                    return place;
                }
            }
            from_deg + (place - from_deg).clamp_length_max(scene.max_amplitude_deg)
        }
        Plan::Explore => {
            let step = random.log_normal(scene.step_deg, scene.step_sigma);
            let step = step.clamp(0.5, scene.max_amplitude_deg);
            for _ in 0..TRIES {
                let angle = std::f64::consts::TAU * random.unit();
                // People look about sideways more than up and down.
                let towards = DVec2::new(angle.cos(), 0.6 * angle.sin()).normalize_or(DVec2::X);
                let place = from_deg + towards * step;
                if place.abs().cmple(field).all() {
                    return place;
                }
            }
            from_deg - from_deg.clamp_length_max(step)
        }
        Plan::Reading => next_word_deg(scene, random, from_deg),
    }
}

fn next_word_deg(scene: &SceneSettings, random: &mut Random, from_deg: DVec2) -> DVec2 {
    let step = random.log_normal(scene.step_deg, scene.step_sigma).min(scene.max_amplitude_deg);
    if random.chance(REGRESSION) && from_deg.x - step > -scene.half_width_deg {
        return from_deg - DVec2::X * step;
    }
    if from_deg.x + step < scene.half_width_deg {
        return from_deg + DVec2::X * step;
    }
    let spacing = 2.0 * scene.half_height_deg / (LINES - 1.0);
    let line = ((scene.half_height_deg - from_deg.y) / spacing).round() + 1.0;
    DVec2::new(-scene.half_width_deg, line_deg(scene, if line < LINES { line } else { 0.0 }))
}
