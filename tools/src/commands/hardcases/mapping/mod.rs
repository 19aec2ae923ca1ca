//! The mapping's hard cases, on the CPU in double precision and on the GPU in single precision.

mod acuity;
mod gpu;
mod kernel;
mod layout;
mod points;
mod rate;
mod rays;
mod round_trip;
mod shape;
#[cfg(test)]
mod tests;

use super::family::{Case, Family, Finding};
use super::random::Random;
use super::subject::{Gaze, Layout, Subject, gazes, methods, screens};
use glam::DVec2;
use macula::fovea::{DisplayGeometry, Mapping};

pub use gpu::LEFT_OUT;

/// The families of this part.
pub fn families() -> Vec<Family> {
    let parts = [
        rays::families(),
        kernel::families(),
        acuity::families(),
        shape::families(),
        layout::families(),
        round_trip::families(),
        rate::families(),
        gpu::families(),
    ];
    parts.into_iter().flatten().collect()
}

/// A method on a display with a gaze.
struct Situation {
    subject: Subject,
    display: DisplayGeometry,
    gaze_px: DVec2,
    id: String,
}

impl Situation {
    /// v wraps around.
    fn periodic(&self) -> bool {
        self.subject.layout() == Layout::Polar
    }

    /// Random numbers of this case.
    fn random(&self) -> Random {
        Random::of(&self.id)
    }

    /// Pixels to look at.
    fn pixel_centres(&self, mapping: &dyn Mapping) -> Vec<DVec2> {
        points::pixel_centres(&self.display, mapping.gaze_px(), &mut self.random())
    }
}

/// A case for each method, display and gaze that `wanted` takes.
fn situations(
    wanted: fn(&DisplayGeometry, &Gaze) -> bool,
    check: fn(&Situation, &dyn Mapping, &mut Finding),
) -> Vec<Case> {
    let mut cases = Vec::new();
    for subject in methods() {
        for screen in screens() {
            let taken = gazes(&screen.display).into_iter().filter(|gaze| wanted(&screen.display, gaze));
            for gaze in taken {
                let id = format!("{}/{}/{}", subject.name, screen.name, gaze.name);
                let situation = Situation {
                    subject: subject.clone(),
                    display: screen.display,
                    gaze_px: gaze.px,
                    id: id.clone(),
                };
                let quick = subject.quick && screen.quick && gaze.quick;
                cases.push(Case::new(id, quick, move |_| {
                    let mapping = situation.subject.mapping(&situation.display, situation.gaze_px)?;
                    let mut finding = Finding::default();
                    check(&situation, &*mapping, &mut finding);
                    Ok(finding)
                }));
            }
        }
    }
    cases
}

/// Every gaze.
fn any_gaze(_: &DisplayGeometry, _: &Gaze) -> bool {
    true
}

/// A display position in messages.
fn at_px(px: DVec2) -> String {
    format!("px {}, {}", px.x, px.y)
}

/// How far two shares of a period are apart, -0.5 to 0.5; not wrapped where `periodic` is false.
fn share_between(from: f64, to: f64, periodic: bool) -> f64 {
    let step = to - from;
    if periodic { step - step.round() } else { step }
}
