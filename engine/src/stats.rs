//! What a frame cost and did.

use serde::Serialize;

/// One pass of the last finished frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// The pass's name, as in the frame graph and the debug labels.
    pub name: &'static str,
    /// GPU time between the timestamps around the pass, milliseconds.
    pub gpu_ms: f64,
    /// A pass that only looks (counting NaN, say): not part of the frame's time.
    pub diagnostic: bool,
}

/// An effect and why it runs or does not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EffectNote {
    /// The effect's name.
    pub name: &'static str,
    /// One clause.
    pub why: String,
}

/// What the effect plan decided.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Effects {
    /// Effects that run.
    pub run: Vec<EffectNote>,
    /// Effects that are left out; they cost nothing.
    pub skipped: Vec<EffectNote>,
}

/// The LP-buffer's size and use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LpStats {
    /// Columns in use at this gaze, from the gaze outwards.
    pub width: u32,
    /// Texels of the highest column.
    pub height: u32,
    /// Texels of the columns in use.
    pub texels: u64,
    /// Texels whose centre lies on the display.
    pub on_display: u64,
    /// Texels that were shaded: on the display or needed to interpolate at its border, and outside
    /// the native disc.
    pub shaded: u64,
    /// Shaded texels whose centre lies on the display.
    pub shaded_on_display: u64,
    /// Display pixels around the gaze that were shaded directly.
    pub native_pixels: u64,
    /// Texels and native pixels that were taken from the other eye instead of being shaded.
    pub reused: u64,
}

/// Figures of one finished frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// Passes in the order in which they ran.
    pub passes: Vec<PassTime>,
    /// Sum over the passes that are not diagnostic, milliseconds.
    pub gpu_ms: f64,
    /// Shading samples: LP texels and native pixels, or display pixels, times samples per pixel.
    pub samples_shaded: u64,
    /// Of a foveated frame.
    pub lp: Option<LpStats>,
    /// NaN and infinite values found, where the check ran.
    pub non_finite: Option<u64>,
    /// Display pixels that no sample reached, where the check ran; 0 unless something is wrong.
    pub holes: Option<u64>,
    /// The gaze was not finite, and the last valid one was used.
    pub gaze_held: bool,
}
