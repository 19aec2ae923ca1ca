//! How well events and predictions agree with the truth: for reports, and to hold the tuning against.

mod events;
mod predictions;

pub use events::{EventRow, MatchSettings, Score, events_of, labelled_events, naive_saccades, score_events};
pub use predictions::{
    LandingRow, PredictionReport, PredictionRow, landing_errors, predict_report, predict_report_of,
};

/// The value that a share of the others lie below; NaN of none. Sorts them.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = share.clamp(0.0, 1.0) * values.len().saturating_sub(1) as f64;
    let from = values.get(at.floor() as usize).copied().unwrap_or(f64::NAN);
    let to = values.get(at.ceil() as usize).copied().unwrap_or(f64::NAN);
    from + (to - from) * at.fract()
}

#[cfg(test)]
mod tests;
