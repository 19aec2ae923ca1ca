//! What the page shows of a run, thinned to what can be seen.

use super::run::{Frame, LatencyRun};
use super::session::{SessionGaze, azimuth_elevation_deg};
use super::summary::LatencySummary;
use crate::estimate::EyeState;
use serde::Serialize;

/// Length of the closer look, s: some saccades, and each refresh still visible.
const CLOSE_S: f64 = 4.0;
/// Bins over the whole session: two pixels each on a wide page.
const BINS: usize = 480;
/// Bars of a histogram.
const BARS: usize = 40;
/// A closer look holds at most this many refreshes: its length at 1000 Hz.
const MOST_CLOSE: usize = 4000;

/// One refresh of the closer look.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosePoint {
    /// Since the first sample, s.
    pub time_s: f64,
    /// Azimuth and elevation that the renderer used, degrees.
    pub used_deg: Option<[f64; 2]>,
    /// The true ones, degrees.
    pub true_deg: Option<[f64; 2]>,
    /// Between both, degrees.
    pub error_deg: Option<f64>,
    /// Counted, and outside the radius.
    pub missed: bool,
    /// Vision is suppressed.
    pub suppressed: bool,
}

/// Something that the eye did, in seconds since the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Span {
    /// What: fixation, saccade, pursuit, blink or lost.
    pub state: &'static str,
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
}

/// A part of the session in one figure each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Its middle, since the first sample, s.
    pub time_s: f64,
    /// Least and greatest true azimuth, degrees.
    pub azimuth_deg: Option<[f64; 2]>,
    /// Least and greatest true elevation, degrees.
    pub elevation_deg: Option<[f64; 2]>,
    /// The largest error of all, degrees.
    pub error_deg: Option<f64>,
    /// The largest error of what counts, degrees.
    pub counted_error_deg: Option<f64>,
}

/// How often values fall where; beyond the last bar counts in it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Histogram {
    /// Where the first bar begins.
    pub from: f64,
    /// How wide a bar is.
    pub width: f64,
    /// Share of all values in each bar, 0 to 1.
    pub shares: Vec<f64>,
}

/// Everything on the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportData {
    /// What was run: the recording's name.
    pub title: String,
    /// What the model is.
    pub about: String,
    /// All figures.
    pub summary: LatencySummary,
    /// The stretch of the session with most misses, refresh by refresh.
    pub close: Vec<ClosePoint>,
    /// What the eye did in that stretch.
    pub spans: Vec<Span>,
    /// The whole session.
    pub overview: Vec<Bin>,
    /// Ages of all frames, ms.
    pub age_ms: Histogram,
    /// Errors of the counted frames, degrees.
    pub error_deg: Histogram,
}

/// Gathers what the page shows. `session` and `summary` must be those of the run.
#[must_use]
pub fn report_data(
    run: &LatencyRun,
    session: &SessionGaze,
    summary: LatencySummary,
    title: impl Into<String>,
) -> ReportData {
    let first_ns = session.times_ns().first().copied().unwrap_or(0);
    let seconds = |time_ns: i64| time_ns.saturating_sub(first_ns) as f64 * 1e-9;
    let close = close_look(&run.frames);
    let bounds = close.first().zip(close.last()).map(|(first, last)| (first.display_ns, last.display_ns));
    let spans = session
        .intervals()
        .iter()
        .filter(|one| bounds.is_some_and(|(from, to)| one.end_ns > from && one.start_ns < to))
        .map(|one| Span {
            state: one.state.name(),
            start_s: seconds(one.start_ns),
            end_s: seconds(one.end_ns),
        })
        .collect();
    let close = close.iter().map(|frame| close_point(frame, seconds(frame.display_ns))).collect();
    let counted = run.frames.iter().filter(|frame| frame.counted).filter_map(|frame| frame.error_deg);
    let errors: Vec<f64> = counted.collect();
    let ages: Vec<f64> =
        run.frames.iter().filter_map(|frame| frame.age_ns).map(|ns| ns as f64 * 1e-6).collect();
    // A few held over a blink would squeeze everything else.
    let age_to = summary.age_ms.p95 * 1.5;
    let error_to = (summary.counted_error_deg.p95 * 2.0).max(run.settings.radius_deg * 1.25);
    ReportData {
        title: title.into(),
        about: run.model.about.clone(),
        overview: bins(&run.frames, seconds),
        age_ms: histogram(&ages, age_to.min(summary.age_ms.max)),
        error_deg: histogram(
            &errors,
            error_to.min(summary.counted_error_deg.max.max(run.settings.radius_deg)),
        ),
        summary,
        close,
        spans,
    }
}

fn close_point(frame: &Frame, time_s: f64) -> ClosePoint {
    ClosePoint {
        time_s,
        used_deg: frame.direction.map(azimuth_elevation_deg),
        true_deg: frame.truth.map(azimuth_elevation_deg),
        error_deg: frame.error_deg,
        missed: frame.counted && frame.outside,
        suppressed: frame.suppressed,
    }
}

/// The frames of the stretch with most misses; where none misses, with most saccade.
fn close_look(frames: &[Frame]) -> &[Frame] {
    let weight = |frame: &Frame| {
        let moves = u64::from(frame.state == EyeState::Saccade);
        moves + 1000 * u64::from(frame.counted && frame.outside)
    };
    let (mut best, mut best_sum, mut sum, mut start) = (0..0, 0, 0, 0);
    for (end, frame) in frames.iter().enumerate() {
        sum += weight(frame);
        while let Some(first) = frames.get(start)
            && (frame.display_ns.saturating_sub(first.display_ns) as f64 > CLOSE_S * 1e9
                || end - start >= MOST_CLOSE)
        {
            sum -= weight(first);
            start += 1;
        }
        let longer = end + 1 - start > best.len() && sum == best_sum;
        if sum > best_sum || longer {
            (best, best_sum) = (start..end + 1, sum);
        }
    }
    frames.get(best).unwrap_or_default()
}

fn bins(frames: &[Frame], seconds: impl Fn(i64) -> f64) -> Vec<Bin> {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return Vec::new() };
    let (from_s, to_s) = (seconds(first.display_ns), seconds(last.display_ns));
    let width_s = ((to_s - from_s) / BINS as f64).max(1e-9);
    let mut bins: Vec<Bin> = (0..BINS)
        .map(|number| Bin {
            time_s: from_s + (number as f64 + 0.5) * width_s,
            azimuth_deg: None,
            elevation_deg: None,
            error_deg: None,
            counted_error_deg: None,
        })
        .collect();
    let widen = |range: &mut Option<[f64; 2]>, value: f64| {
        let [low, high] = range.unwrap_or([value; 2]);
        *range = Some([low.min(value), high.max(value)]);
    };
    let raise = |most: &mut Option<f64>, value: f64| *most = Some(most.map_or(value, |most| most.max(value)));
    let mut before: Option<[f64; 2]> = None;
    for frame in frames {
        let number = ((seconds(frame.display_ns) - from_s) / width_s) as usize;
        let Some(bin) = bins.get_mut(number.min(BINS - 1)) else { continue };
        let now = frame.truth.map(azimuth_elevation_deg);
        // From where the eye was before, so that a jump between two bins has no gap.
        let from = before.filter(|_| now.is_some());
        for [azimuth, elevation] in from.into_iter().chain(now) {
            widen(&mut bin.azimuth_deg, azimuth);
            widen(&mut bin.elevation_deg, elevation);
        }
        before = now;
        if let Some(error) = frame.error_deg {
            raise(&mut bin.error_deg, error);
            if frame.counted {
                raise(&mut bin.counted_error_deg, error);
            }
        }
    }
    bins
}

fn histogram(values: &[f64], to: f64) -> Histogram {
    let width = (to / BARS as f64).max(1e-3);
    let mut counts = vec![0_u64; BARS];
    for value in values {
        let bar = ((value / width) as usize).min(BARS - 1);
        if let Some(count) = counts.get_mut(bar) {
            *count += 1;
        }
    }
    let all = values.len().max(1) as f64;
    Histogram { from: 0.0, width, shares: counts.into_iter().map(|count| count as f64 / all).collect() }
}
