//! Displays by name: headsets with eye tracking, monitors at their distance, the paper's retinal
//! display.

mod table;
#[cfg(test)]
mod tests;

use super::display::DisplayGeometry;
use table::PRESETS;

/// A display that is known by name, with what foveation needs to know of it.
///
/// A headset's lenses spread the panel's pixels unevenly, dense in the middle. What is rendered is the
/// flat picture before the lenses' distortion is undone, with more pixels than the panel, so that one
/// of its pixels in the middle is about one of the panel's; geometry and density are that picture's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayPreset {
    /// Lower case with hyphens; the name in `macula gaze latency --preset` too, where both know the
    /// headset.
    pub name: &'static str,
    /// One line: what it is, and what is special about its figures.
    pub about: &'static str,
    /// The panel's pixels for one eye, width and height.
    pub panel_px: [u32; 2],
    /// The rendered picture's pixels for one eye, width and height.
    pub render_px: [u32; 2],
    /// Tangents of the left eye's frustum, as in [`DisplayGeometry`]: left, right, up, down.
    pub left_eye_tangents: [f64; 4],
    /// Pixels per degree in the middle as the vendor publishes them, or the paper; `None` where neither
    /// does.
    pub published_ppd: Option<f64>,
    /// Pictures in a second.
    pub refresh_hz: f64,
    /// Distance between the eyes, mm: of the headset, or of most people (63 mm) where it adapts.
    pub ipd_mm: f64,
    /// Mean time from the eye until its sample is with the renderer, ms: exposure to wake-up in the
    /// latency model [`Self::latency_preset`].
    pub tracker_latency_ms: f64,
    /// The model of `macula gaze latency --preset` for this display and its tracker.
    pub latency_preset: &'static str,
    /// Where the figures come from.
    pub source: &'static str,
    /// The fields above that are guesses, by their names: no source confirms them.
    pub guesses: &'static [&'static str],
}

impl DisplayPreset {
    /// All presets, headsets first.
    #[must_use]
    pub fn all() -> &'static [Self] {
        &PRESETS
    }

    /// The preset of that name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// The left eye's display.
    #[must_use]
    pub fn left(&self) -> DisplayGeometry {
        let [tan_left, tan_right, tan_up, tan_down] = self.left_eye_tangents;
        DisplayGeometry { size_px: self.render_px, tan_left, tan_right, tan_up, tan_down }
    }

    /// The right eye's display: the left eye's mirror image.
    #[must_use]
    pub fn right(&self) -> DisplayGeometry {
        let left = self.left();
        DisplayGeometry { tan_left: -left.tan_right, tan_right: -left.tan_left, ..left }
    }

    /// The same display rendered at another size, px; the frusta stay.
    #[must_use]
    pub fn scaled(&self, render_px: [u32; 2]) -> Self {
        Self { render_px, ..*self }
    }

    /// Rendered pixels per degree on the view axis: the geometric mean of across and down.
    #[must_use]
    pub fn ppd(&self) -> f64 {
        let [left, right, up, down] = self.left_eye_tangents;
        let [width, height] = self.render_px.map(f64::from);
        (width / (right - left) * (height / (up - down))).sqrt().to_radians()
    }

    /// Whether a field's value is a guess.
    #[must_use]
    pub fn is_guess(&self, field: &str) -> bool {
        self.guesses.contains(&field)
    }
}
