//! When samples arrive and pictures are made and shown.

use super::model::LatencyModel;
use super::random::Random;
use super::run::{ArrivalTimes, RunSettings};
use super::session::SessionGaze;
use super::stage::Stage;
use crate::error::{Error, Result};

/// The most refreshes in one run: 12 h at 90 Hz, about 500 MB of rows.
pub const MOST_REFRESHES: usize = 4_000_000;
/// In a hole of the recording that is longer, ns, no frames are run after this time.
const LONGEST_HOLE_NS: i64 = 1_000_000_000;
/// A tracker rate within this share of the recording's takes every sample.
const SAME_RATE: f64 = 0.75;
/// Streams of random numbers besides the stages'.
const TRACKER_PHASE: u64 = 100;
const DISPLAY_PHASE: u64 = 101;

/// A sample that the host got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrival {
    pub available_ns: i64,
    /// Mid-exposure, ns.
    pub time_ns: i64,
    /// In the session.
    pub row: u32,
    pub usable: bool,
}

/// All samples that the tracker made, in the order of arrival, which is that of their times.
pub(super) fn arrivals(
    session: &SessionGaze,
    model: &LatencyModel,
    settings: &RunSettings,
    seed: u64,
) -> Result<Vec<Arrival>> {
    let rows = tracker_rows(session, model, seed);
    let mut made = Vec::with_capacity(rows.as_ref().map_or(session.len(), Vec::len));
    let mut last_ns = i64::MIN;
    let mut push = |row: u32| -> Result<()> {
        let at = row as usize;
        let Some(&time_ns) = session.times_ns().get(at) else { return Ok(()) };
        let own_ns = match settings.arrival {
            ArrivalTimes::Model => time_ns.saturating_add(tracker_ns(model, seed, row).iter().sum()),
            ArrivalTimes::Recorded => session.received_ns(at).ok_or_else(no_arrivals)?.max(time_ns),
        };
        // A sample does not overtake another.
        last_ns = last_ns.max(own_ns);
        made.push(Arrival { available_ns: last_ns, time_ns, row, usable: session.direction(at).is_some() });
        Ok(())
    };
    match rows {
        Some(rows) => rows.into_iter().try_for_each(&mut push)?,
        None => (0..session.len() as u32).try_for_each(&mut push)?,
    }
    Ok(made)
}

fn no_arrivals() -> Error {
    Error::Setting("the recording has no arrival times of its own; use those of the model".into())
}

/// What the stages before the host take for a sample: from mid-exposure on, ns.
pub(super) fn tracker_ns(model: &LatencyModel, seed: u64, row: u32) -> [i64; 5] {
    let stages = [Stage::Exposure, Stage::Readout, Stage::TrackerProcessing, Stage::Polling, Stage::Wakeup];
    let mut times = stages.map(|stage| model.stage(stage).delay.draw_ns(seed, stage, u64::from(row)));
    times[0] /= 2;
    times
}

/// The samples nearest to the tracker's own times; `None` for all of them.
fn tracker_rows(session: &SessionGaze, model: &LatencyModel, seed: u64) -> Option<Vec<u32>> {
    let rate_hz = model.tracker_rate_hz.as_ref()?.value;
    if rate_hz >= session.rate_hz() * SAME_RATE {
        return None;
    }
    let step_ns = 1e9 / rate_hz;
    let times = session.times_ns();
    let phase = model.tracker_phase.unwrap_or_else(|| Random::new(seed, TRACKER_PHASE, 0).unit());
    let first_ns = *times.first()?;
    let mut rows = Vec::new();
    let mut tick = 0_u64;
    let tick_ns = |tick: u64| ((tick as f64 + phase) * step_ns) as i128;
    for (row, pair) in times.windows(2).enumerate() {
        let since = |time: i64| i128::from(time) - i128::from(first_ns);
        let middle = (since(pair[0]) + since(pair[1])) / 2;
        if tick_ns(tick) <= middle {
            rows.push(row as u32);
            // All ticks that are nearest to this sample: in a hole there are many.
            tick = tick.max(((middle as f64 / step_ns - phase).max(0.0)) as u64 + 1);
        }
    }
    if tick_ns(tick) <= i128::from(*times.last()?) - i128::from(first_ns) {
        rows.push(times.len() as u32 - 1);
    }
    Some(rows)
}

/// One picture that the renderer made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Picture {
    pub number: u64,
    /// When its gaze was taken, ns.
    pub latch_ns: i64,
    /// When it would be taken at the start of the CPU's work, and at that of the GPU's, ns.
    pub early_latch_ns: i64,
    pub late_latch_ns: i64,
    pub gpu_start_ns: i64,
    pub cpu_ns: i64,
    pub gpu_ns: i64,
    pub compositor_ns: i64,
    /// The refresh that first shows it.
    pub refresh: u64,
    /// The middle of its light as far as the renderer can foresee it, ns.
    pub expected_ns: i64,
}

/// Refreshes of the display and the pictures for them, step by step.
#[derive(Debug)]
pub(super) struct Clockwork<'a> {
    model: &'a LatencyModel,
    seed: u64,
    first_ns: i64,
    frame_ns: f64,
    number: u64,
    /// The slot whose work began last, counted as the refresh that it aims at.
    slot: Option<i64>,
    gpu_start_ns: i64,
    gpu_end_ns: i64,
    shown: Option<i64>,
}

impl<'a> Clockwork<'a> {
    pub(super) fn new(session: &SessionGaze, model: &'a LatencyModel, seed: u64) -> Self {
        let frame_ns = model.frame_ns();
        let phase = model.display_phase.unwrap_or_else(|| Random::new(seed, DISPLAY_PHASE, 0).unit());
        let start_ns = session.times_ns().first().copied().unwrap_or(0);
        Self {
            model,
            seed,
            first_ns: start_ns.saturating_add((phase * frame_ns) as i64),
            frame_ns,
            number: 0,
            slot: None,
            gpu_start_ns: i64::MIN,
            gpu_end_ns: i64::MIN,
            shown: None,
        }
    }

    fn refresh_ns(&self, refresh: i64) -> i64 {
        // Wider than a time: two times can lie further apart than the largest of them.
        let since_ns = (refresh as f64 * self.frame_ns).round() as i128;
        let at_ns = i128::from(self.first_ns).saturating_add(since_ns);
        at_ns.clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }

    /// The first refresh at or after a time.
    fn refresh_after(&self, time_ns: i64) -> i64 {
        let since_ns = i128::from(time_ns) - i128::from(self.first_ns);
        let about = (since_ns as f64 / self.frame_ns).floor() as i64;
        (about - 1..=about + 2).find(|refresh| self.refresh_ns(*refresh) >= time_ns).unwrap_or(about + 1)
    }

    /// The middle of the light of a refresh, and how long scan-out and panel take, ns.
    pub(super) fn display_ns(&self, refresh: u64) -> (i64, [i64; 2]) {
        let stages = [Stage::Scanout, Stage::Panel];
        let times = stages.map(|stage| self.model.stage(stage).delay.draw_ns(self.seed, stage, refresh));
        (self.refresh_ns(refresh as i64).saturating_add(times[0] + times[1]), times)
    }

    /// Jumps so that the next picture aims at the first refresh at or after `time_ns`.
    pub(super) fn skip_to(&mut self, time_ns: i64) {
        let next = self.refresh_after(time_ns) - 1;
        self.slot = Some(self.slot.map_or(next, |slot| slot.max(next)));
        self.shown = Some(self.shown.map_or(next, |shown| shown.max(next)));
    }

    /// Makes the next picture. Its work begins at the first slot at which the GPU has begun the one
    /// before: no more than one picture waits for the GPU.
    pub(super) fn next_picture(&mut self) -> Picture {
        let ahead_ns = (self.model.frames_ahead * self.frame_ns).round() as i64;
        let first_slot = self.refresh_after(self.gpu_start_ns.saturating_add(ahead_ns));
        let slot = self.slot.map_or(0, |slot| slot + 1).max(first_slot);
        let draw = |stage: Stage| self.model.stage(stage).delay.draw_ns(self.seed, stage, self.number);
        let (cpu_ns, gpu_ns, compositor_ns) = (draw(Stage::Cpu), draw(Stage::Gpu), draw(Stage::Compositor));
        let cpu_start_ns = self.refresh_ns(slot).saturating_sub(ahead_ns);
        let gpu_start_ns = cpu_start_ns.saturating_add(cpu_ns).max(self.gpu_end_ns);
        let gpu_end_ns = gpu_start_ns.saturating_add(gpu_ns);
        let ready_ns = gpu_end_ns.saturating_add(compositor_ns);
        let refresh = self.refresh_after(ready_ns).max(self.shown.map_or(0, |shown| shown + 1)).max(0);
        let before_ns = (self.model.latch_before_gpu_ms * 1e6).round() as i64;
        let late_latch_ns = gpu_start_ns.saturating_sub(before_ns).max(cpu_start_ns);
        let mean_ns = |stage: Stage| (self.model.stage(stage).delay.mean_ms() * 1e6).round() as i64;
        let picture = Picture {
            number: self.number,
            latch_ns: if self.model.late_latch { late_latch_ns } else { cpu_start_ns },
            early_latch_ns: cpu_start_ns,
            late_latch_ns,
            gpu_start_ns,
            cpu_ns,
            gpu_ns,
            compositor_ns,
            refresh: refresh as u64,
            expected_ns: self
                .refresh_ns(slot)
                .saturating_add(mean_ns(Stage::Scanout) + mean_ns(Stage::Panel)),
        };
        self.number += 1;
        self.slot = Some(slot);
        self.shown = Some(refresh);
        (self.gpu_start_ns, self.gpu_end_ns) = (gpu_start_ns, gpu_end_ns);
        picture
    }
}

/// Stretches of the session without a long hole: first and last time, ns.
pub(super) fn stretches(session: &SessionGaze) -> Vec<(i64, i64)> {
    let times = session.times_ns();
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Vec::new() };
    let mut found = Vec::new();
    let mut start = first;
    for pair in times.windows(2) {
        if pair[1].saturating_sub(pair[0]) > LONGEST_HOLE_NS {
            found.push((start, pair[0].saturating_add(LONGEST_HOLE_NS)));
            start = pair[1];
        }
    }
    found.push((start, last));
    found
}

/// # Errors
/// [`Error::Setting`] where the run would have more refreshes than [`MOST_REFRESHES`].
pub(super) fn check_length(stretches: &[(i64, i64)], frame_ns: f64) -> Result<()> {
    let length_ns: f64 =
        stretches.iter().map(|(start, end)| (i128::from(*end) - i128::from(*start)) as f64).sum();
    let refreshes = length_ns / frame_ns + stretches.len() as f64;
    if refreshes > MOST_REFRESHES as f64 {
        return Err(Error::Setting(format!(
            "the session of {:.1} h has {refreshes:.0} refreshes, more than {MOST_REFRESHES}; cut it",
            length_ns / 3.6e12
        )));
    }
    Ok(())
}
