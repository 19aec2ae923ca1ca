//! What a sweep writes down: one manifest for the whole, one record for each setting at each size.
//!
//! The manifest is written when the sweep begins and each record when its setting is done, whole or not at
//! all; tables, `choose` and the report are made from them alone.

use macula::knobs::Setting;
use serde::{Deserialize, Serialize};

/// Of manifest and records; files of another version are refused.
pub const VERSION: u32 = 1;

/// What a sweep measures and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`VERSION`].
    pub version: u32,
    /// The program's version.
    pub program: String,
    /// The command line's words after `macula`.
    pub command: Vec<String>,
    /// The scene in words.
    pub scene: String,
    /// Display sizes, px.
    pub sizes: Vec<[u32; 2]>,
    /// The display's horizontal field of view, degrees.
    pub hfov_deg: f64,
    /// The acuity model in words.
    pub acuity: String,
    /// What every setting starts from; a setting overrides it.
    pub base: Setting,
    /// What times and errors are relative to: every knob at its most accurate value.
    pub reference: Setting,
    /// The settings, in the order of the command line.
    pub settings: Vec<Setting>,
    /// The views that are rendered.
    pub views: Vec<View>,
    /// How often each view is rendered with each setting.
    pub runs: u32,
    /// Whether FovVideoVDP was asked for.
    pub fvvdp: bool,
}

/// What a view is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Path {
    /// A gaze by itself.
    Gaze,
    /// A step of the slow move of the camera.
    Camera,
    /// A step of the slow move of the gaze.
    GazeMove,
}

/// Where the eye is and looks in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// What it is for.
    pub path: Path,
    /// Gaze, as fractions of the display.
    pub gaze: [f64; 2],
    /// The camera's turn about the vertical axis, degrees.
    pub yaw_deg: f64,
    /// The camera's move to the right, millimetres.
    pub step_mm: f64,
}

/// Where a record was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The Vulkan device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// The processor.
    pub cpu: String,
    /// Threads that it runs at a time.
    pub threads: u32,
    /// The operating system.
    pub system: String,
}

/// One setting at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`VERSION`].
    pub version: u32,
    /// Place of the setting in [`Manifest::settings`], from 0.
    pub index: usize,
    /// Display size, px.
    pub size: [u32; 2],
    /// The setting.
    pub setting: Setting,
    /// Where it was measured.
    pub machine: Machine,
    /// What was found.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// How a setting ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// One line that says why there are no figures.
    Failed(String),
    /// The figures.
    Measured(Box<Figures>),
}

/// Figures of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Times of the setting and of the reference.
    pub times: Times,
    /// Against the reference; mean squares over the views.
    pub errors: Errors,
    /// Along the moves of camera and gaze.
    pub temporal: Temporal,
    /// Samples shaded, mean over the views.
    pub samples_shaded: u64,
    /// GPU memory that the setting needs beside the scene, bytes.
    pub memory_bytes: u64,
    /// NaN and infinite values in the setting's buffers.
    pub non_finite: u64,
    /// FovVideoVDP's JOD, 10 for no difference; where it was asked for.
    pub jod: Option<f64>,
}

/// GPU times. Pairs of a frame of the reference and one of the setting were measured next to each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Pairs.
    pub pairs: u32,
    /// The setting's frames, milliseconds.
    pub setting_ms: Spread,
    /// The reference's frames, milliseconds.
    pub reference_ms: Spread,
    /// The setting's time over the reference's, within pairs; below 1 is faster.
    pub ratio: Spread,
    /// Ends of a confidence interval of the ratio's median (order statistics, no assumption about the
    /// distribution).
    pub ratio_interval: [f64; 2],
    /// The probability that this interval holds the median: at least 0.95 from 6 pairs on.
    pub ratio_confidence: f64,
    /// The setting's passes, medians.
    pub passes: Vec<Pass>,
    /// The reference's passes, medians.
    pub reference_passes: Vec<Pass>,
}

/// Of several values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

/// A pass's time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// The pass.
    pub name: String,
    /// Milliseconds.
    pub gpu_ms: f64,
}

/// Differences to the reference, of sRGB-encoded values from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root of the mean square difference.
    pub rmse: f64,
    /// FLIP, 0 to 1.
    pub flip: f64,
    /// Root of the mean square difference that survives the acuity: the front's own error.
    pub acuity_rmse: f64,
    /// Step across the LP-buffer's seam beyond the steps beside it; none where nothing is foveated.
    pub seam_residual: Option<f64>,
    /// The rings of eccentricity, from the gaze outwards.
    pub rings: Vec<Ring>,
}

/// One ring of eccentricity. `None` where it has no pixel on the display.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ring {
    /// Where it begins, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees; none for the last one.
    pub to_deg: Option<f64>,
    /// As [`Errors::rmse`].
    pub rmse: Option<f64>,
    /// As [`Errors::flip`].
    pub flip: Option<f64>,
    /// As [`Errors::acuity_rmse`].
    pub acuity_rmse: Option<f64>,
}

/// Change from frame to frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Temporal {
    /// While the camera moves.
    pub camera: Vec<TemporalRing>,
    /// While the gaze moves over a still picture.
    pub gaze: Vec<TemporalRing>,
}

/// One ring of eccentricity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TemporalRing {
    /// Where it begins, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees; none for the last one.
    pub to_deg: Option<f64>,
    /// Mean over the pixels of the luminance's variance over time (encoded, 0 to 1); none without pixels.
    pub variance: Option<f64>,
    /// The same over the reference's; none where the reference's is 0.
    pub ratio: Option<f64>,
}

/// What one effect costs in the scene, or what leaving it out saves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectCost {
    /// The effect.
    pub name: String,
    /// Why it runs or does not.
    pub why: String,
    /// Whether the plan runs it.
    pub runs: bool,
    /// The frame's time with it less the time without it, milliseconds; medians within pairs.
    pub gpu_ms: Spread,
    /// Pairs.
    pub pairs: u32,
    /// The greatest difference of any 8-bit value that switching it makes; 0 for an effect that the scene
    /// does not call for.
    pub most_changed: u8,
}

/// `effects.json`: of the base setting at the first size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effects {
    /// Those that run, then those left out.
    pub effects: Vec<EffectCost>,
    /// The frame as planned, milliseconds, median.
    pub planned_ms: f64,
    /// The frame with every effect forced, milliseconds, median.
    pub forced_ms: f64,
}
