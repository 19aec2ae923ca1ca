//! A recorded session as the latency model needs it: directions in order of time, and where the eye
//! truly looked.

use crate::error::{Error, Result};
use crate::estimate::EyeState;
use crate::recording::Recording;
use crate::sample::GazeSample;
use glam::DVec3;

/// Columns of [`Recording::extra`] that hold the true direction, where a synthetic eye wrote them.
const TRUTH_COLUMNS: [&str; 3] = ["true_direction_x", "true_direction_y", "true_direction_z"];
/// A hole in the samples that is longer than this many of their median steps, and than
/// [`LEAST_HOLE_NS`], is not interpolated over: the eye may have jumped there and back.
const HOLE_STEPS: f64 = 3.5;
/// Shorter holes are always interpolated over, ns: two samples of 100 Hz.
const LEAST_HOLE_NS: f64 = 20e6;

/// What the eye did for a while, as a classifier or the truth says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EyeInterval {
    /// What it did.
    pub state: EyeState,
    /// On the recording's host clock, ns.
    pub start_ns: i64,
    /// Just after it, ns.
    pub end_ns: i64,
}

/// A session in order of time.
#[derive(Clone, Debug, Default)]
pub struct SessionGaze {
    times_ns: Vec<i64>,
    /// Of length 1; NaN where the sample cannot be used.
    directions: Vec<DVec3>,
    /// Empty where the samples are all that is known of the truth.
    truth: Vec<DVec3>,
    /// Empty where no arrival times of their own were recorded.
    received_ns: Vec<i64>,
    /// Index in the recording; empty where it is the same.
    order: Vec<u32>,
    intervals: Vec<EyeInterval>,
    hole_ns: i64,
    step_ns: i64,
    duplicates: u64,
}

impl SessionGaze {
    /// Takes the directions of a recording. Samples are sorted by time; of several at one time the last
    /// in the file stays. Points on a display become directions where the display is known.
    ///
    /// # Errors
    /// [`Error::Setting`] where fewer than two samples have a gaze that can be used, or where there are
    /// only points and no display.
    pub fn new(recording: &Recording) -> Result<Self> {
        let count = recording.len();
        if u32::try_from(count).is_err() {
            return Err(Error::Setting(format!("{count} samples are too many; cut the recording")));
        }
        let times = recording.times_ns();
        let sorted = times.windows(2).all(|pair| pair[0] < pair[1]);
        let mut order: Vec<u32> = Vec::new();
        if !sorted {
            order = (0..count as u32).collect();
            order.sort_by_key(|index| times.get(*index as usize).copied());
            // Reversed, the last of equal times comes first and stays.
            order.reverse();
            order.dedup_by_key(|index| times.get(*index as usize).copied());
            order.reverse();
        }
        let kept = if sorted { count } else { order.len() };
        let mut session = Self {
            times_ns: Vec::with_capacity(kept),
            directions: Vec::with_capacity(kept),
            duplicates: (count - kept) as u64,
            order,
            ..Self::default()
        };
        let mut only_points = 0_u64;
        for row in 0..kept {
            let Some(sample) = recording.get(session.recorded(row)) else { continue };
            let direction = direction_of(recording, &sample);
            only_points += u64::from(direction.is_none() && sample.gaze_point().is_some());
            session.times_ns.push(sample.time_ns);
            session.directions.push(direction.unwrap_or(DVec3::NAN));
            session.take_received(row, &sample);
        }
        session.take_truth(recording);
        session.check(only_points)?;
        session.measure_steps();
        Ok(session)
    }

    fn check(&self, only_points: u64) -> Result<()> {
        let usable = self.directions.iter().filter(|direction| direction.is_finite()).count();
        if usable >= 2 {
            return Ok(());
        }
        Err(Error::Setting(if only_points >= 2 {
            "the recording has points on a display and no directions; give the display's size and distance"
                .into()
        } else {
            format!("the recording has {usable} samples with a gaze; the latency model needs 2 or more")
        }))
    }

    fn take_received(&mut self, row: usize, sample: &GazeSample) {
        if self.received_ns.is_empty() && sample.received_ns != sample.time_ns {
            self.received_ns.extend_from_slice(self.times_ns.get(..row).unwrap_or_default());
        }
        if !self.received_ns.is_empty() || sample.received_ns != sample.time_ns {
            self.received_ns.push(sample.received_ns);
        }
    }

    fn take_truth(&mut self, recording: &Recording) {
        let column = |name| recording.extra.iter().find(|column| column.name == name);
        let [Some(x), Some(y), Some(z)] = TRUTH_COLUMNS.map(column) else { return };
        let value = |values: &[f64], index| values.get(index).copied().unwrap_or(f64::NAN);
        self.truth = (0..self.len())
            .map(|row| {
                let at = self.recorded(row);
                let told = DVec3::new(value(&x.values, at), value(&y.values, at), value(&z.values, at));
                told.try_normalize().unwrap_or(DVec3::NAN)
            })
            .collect();
    }

    fn measure_steps(&mut self) {
        let mut steps: Vec<i64> =
            self.times_ns.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
        let middle = steps.len() / 2;
        if steps.is_empty() {
            return;
        }
        self.step_ns = (*steps.select_nth_unstable(middle).1).max(1);
        self.hole_ns = (self.step_ns as f64 * HOLE_STEPS).max(LEAST_HOLE_NS) as i64;
    }

    /// Adds what the eye did. Without it every frame counts, and nothing is suppressed. Intervals that
    /// do not end after they start are left out; one that starts before another has ended cuts it short.
    #[must_use]
    pub fn with_intervals(mut self, intervals: &[EyeInterval]) -> Self {
        self.intervals = intervals.iter().copied().filter(|one| one.end_ns > one.start_ns).collect();
        self.intervals.sort_by_key(|one| (one.start_ns, one.end_ns));
        let mut next_ns = i64::MAX;
        for one in self.intervals.iter_mut().rev() {
            one.end_ns = one.end_ns.min(next_ns);
            next_ns = one.start_ns;
        }
        self.intervals.retain(|one| one.end_ns > one.start_ns);
        self
    }

    /// What the eye did, in order of time.
    #[must_use]
    pub fn intervals(&self) -> &[EyeInterval] {
        &self.intervals
    }

    /// The number of samples at different times.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times_ns.len()
    }

    /// There is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times_ns.is_empty()
    }

    /// How many samples were left out because another had the same time.
    #[must_use]
    pub fn duplicates(&self) -> u64 {
        self.duplicates
    }

    /// Samples per second, by the median step.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        1e9 / self.step_ns.max(1) as f64
    }

    /// The truth is known apart from the samples, as that of a synthetic eye.
    #[must_use]
    pub fn has_truth(&self) -> bool {
        !self.truth.is_empty()
    }

    /// Times of the samples, ascending, ns.
    #[must_use]
    pub fn times_ns(&self) -> &[i64] {
        &self.times_ns
    }

    /// The index in the recording of a sample of this session.
    #[must_use]
    pub fn recorded(&self, row: usize) -> usize {
        self.order.get(row).map_or(row, |index| *index as usize)
    }

    /// The direction of a sample as its source told it, of length 1.
    #[must_use]
    pub fn direction(&self, row: usize) -> Option<DVec3> {
        self.directions.get(row).copied().filter(|direction| direction.is_finite())
    }

    /// The recorded arrival of a sample on the host, ns; `None` where none was recorded.
    pub(super) fn received_ns(&self, row: usize) -> Option<i64> {
        self.received_ns.get(row).copied()
    }

    /// Where the samples say that the eye looked at a time, between them.
    #[must_use]
    pub fn measured_at(&self, time_ns: i64) -> Option<DVec3> {
        self.between(&self.directions, self.row_after(time_ns), time_ns)
    }

    /// Where the eye truly looked at a time, as far as that is known.
    #[must_use]
    pub fn true_at(&self, time_ns: i64) -> Option<DVec3> {
        self.true_from(self.row_after(time_ns), time_ns)
    }

    /// As [`Self::true_at`], with the first row after that time known.
    pub(super) fn true_from(&self, row_after: usize, time_ns: i64) -> Option<DVec3> {
        let directions = if self.truth.is_empty() { &self.directions } else { &self.truth };
        self.between(directions, row_after, time_ns)
    }

    fn row_after(&self, time_ns: i64) -> usize {
        self.times_ns.partition_point(|time| *time <= time_ns)
    }

    fn between(&self, directions: &[DVec3], row_after: usize, time_ns: i64) -> Option<DVec3> {
        let before = row_after.checked_sub(1)?;
        let (from_ns, from) = (*self.times_ns.get(before)?, *directions.get(before)?);
        if from_ns == time_ns {
            return Some(from).filter(|direction| direction.is_finite());
        }
        let (to_ns, to) = (*self.times_ns.get(row_after)?, *directions.get(row_after)?);
        let step_ns = to_ns.checked_sub(from_ns)?;
        if step_ns <= 0 || step_ns > self.hole_ns || !from.is_finite() || !to.is_finite() {
            return None;
        }
        let share = time_ns.saturating_sub(from_ns) as f64 / step_ns as f64;
        // Below a quarter of a degree the chord is as good as the arc: 1e-9 rad.
        let between =
            if from.dot(to) > 0.999_99 { from.lerp(to, share).normalize() } else { from.slerp(to, share) };
        Some(between).filter(|direction| direction.is_finite())
    }
}

fn direction_of(recording: &Recording, sample: &GazeSample) -> Option<DVec3> {
    let told = sample.gaze_direction().map(|(direction, _)| direction);
    told.or_else(|| {
        let direction = recording.info.screen?.direction_of(sample.gaze_point()?);
        direction.is_finite().then_some(direction)
    })
}

/// The angle between two directions of length 1, degrees; exact for small angles too.
pub(super) fn angle_deg(one: DVec3, other: DVec3) -> f64 {
    if one.dot(other) > 0.0 {
        (2.0 * (one.distance(other) * 0.5).min(1.0).asin()).to_degrees()
    } else {
        (std::f64::consts::PI - 2.0 * ((one + other).length() * 0.5).min(1.0).asin()).to_degrees()
    }
}

/// Azimuth (to the right) and elevation (upwards) of a direction of length 1, degrees.
pub(super) fn azimuth_elevation_deg(direction: DVec3) -> [f64; 2] {
    let azimuth = direction.x.atan2(-direction.z);
    [azimuth.to_degrees(), direction.y.clamp(-1.0, 1.0).asin().to_degrees()]
}
