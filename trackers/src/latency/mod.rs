//! From the eye to the photons: how old the gaze is for which a picture was rendered, how far off it is
//! by then, and what that asks of the foveation.
//!
//! A [`LatencyModel`] is a list of [`Stage`]s with how long each takes ([`preset`], or a TOML file).
//! [`run`] takes a recorded or synthetic session through it, refresh by refresh of the display. Two
//! waits are simulated instead of drawn: the sample's until the renderer takes it, and the picture's
//! until the refresh.

mod answer;
mod budget;
mod figures;
mod file;
mod ledger;
mod model;
mod page;
mod plot;
mod preset;
mod random;
mod report;
mod run;
mod session;
mod stage;
mod summary;
mod suppression;
#[cfg(test)]
mod tests;
mod timeline;
mod verdict;

pub use answer::EstimatorAnswer;
pub use budget::{Budget, BudgetPoint, REFERENCES, Reference, StageShare};
pub use figures::Figures;
pub use ledger::{FrameRow, Ledger, SampleRow, SampleRows};
pub use model::{Known, LatencyModel, measured_ms};
pub use page::page;
pub use preset::{PRESETS, preset};
pub use report::{Bin, ClosePoint, Histogram, ReportData, Span, report_data};
pub use run::{ArrivalTimes, Arrived, Frame, GazeAnswer, LatencyRun, Question, RunSettings, run, run_with};
pub use session::{EyeInterval, SessionGaze};
pub use stage::{Delay, MOST_MEASURED, MOST_STAGE_MS, Stage, StageTime};
pub use summary::{LateLatch, LatencySummary};
pub use suppression::Suppression;
pub use timeline::MOST_REFRESHES;
pub use verdict::{Verdict, verdict};
