//! A recorded session in memory, by columns: a column exists only where some sample has a value in it,
//! so that an hour at 1 kHz stays within a few hundred megabytes.

use crate::EyeState;
use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::{DQuat, DVec2, DVec3};

/// Columns of one eye: validity, confidence, pupil, openness, origin, direction, point.
const EYE_COLUMNS: usize = 12;
/// Of the head: position, rotation.
const HEAD_COLUMNS: usize = 7;
const COLUMNS: usize = 3 * EYE_COLUMNS + HEAD_COLUMNS;

/// What the gaze directions and points of a recording refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// Directions in view space (eye in head).
    View,
    /// Points on a display; directions only where its size and distance are known.
    Display,
    /// Directions or points of a scene camera that moves with the head.
    SceneCamera,
    /// The file does not say.
    #[default]
    Unknown,
}

impl Space {
    /// The name in reports and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Display => "display",
            Self::SceneCamera => "scene-camera",
            Self::Unknown => "unknown",
        }
    }
}

/// A flat display in front of the eyes, centred on the view axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Width and height, px.
    pub size_px: DVec2,
    /// Width and height, m.
    pub size_m: DVec2,
    /// From the eyes, m.
    pub distance_m: f64,
}

impl Screen {
    /// The direction to a point given in fractions of the display; view space, of length 1.
    #[must_use]
    pub fn direction_of(&self, point: DVec2) -> DVec3 {
        let at_m = (point - 0.5) * self.size_m;
        DVec3::new(at_m.x, -at_m.y, -self.distance_m).normalize()
    }

    /// The point that a direction meets, in fractions of the display; `None` where it meets none.
    #[must_use]
    pub fn point_of(&self, direction: DVec3) -> Option<DVec2> {
        let at_m = direction.truncate() * (self.distance_m / -direction.z);
        let point = DVec2::new(at_m.x, -at_m.y) / self.size_m + 0.5;
        (direction.z < 0.0 && point.is_finite()).then_some(point)
    }
}

/// Rows of a file that became no sample, or lost a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// How many.
    pub rows: u64,
    /// Why, with an example where that helps.
    pub why: String,
}

/// A numeric column of the file that has no place in a [`GazeSample`], kept as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtraColumn {
    /// Its name in the file.
    pub name: String,
    /// One value for each sample; NaN where missing.
    pub values: Vec<f64>,
}

/// Which eye an event of a recording is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventEye {
    /// Both together, or the file does not say.
    Both,
    /// The left eye.
    Left,
    /// The right eye.
    Right,
}

/// What the recording's own software found the eye to do; never computed here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedEvent {
    /// What it is.
    pub kind: EyeState,
    /// Time of its first sample on the clock of the samples, ns.
    pub start_ns: i64,
    /// Time of its last sample, ns.
    pub end_ns: i64,
    /// Whose it is.
    pub eye: EventEye,
}

/// What is known of a recording besides its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingInfo {
    /// The format's name, as in `sranipal-csv`.
    pub format: &'static str,
    /// Who or what made it, where the file says.
    pub device: String,
    /// What directions and points refer to.
    pub space: Space,
    /// Samples per second as the file says.
    pub nominal_rate_hz: Option<f64>,
    /// The display that points lie on.
    pub screen: Option<Screen>,
    /// The clock of the device times, in words.
    pub device_clock: String,
    /// Rows that became no sample, and why.
    pub skipped: Vec<Skipped>,
    /// What a reader had to assume, a sentence each.
    pub notes: Vec<String>,
}

/// A recorded session: samples in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// What is known of it.
    pub info: RecordingInfo,
    /// Values that have no place in a sample.
    pub extra: Vec<ExtraColumn>,
    /// Events that the file tells, in its order.
    pub events: Vec<RecordedEvent>,
    time_ns: Vec<i64>,
    /// Empty while equal to `time_ns`.
    received_ns: Vec<i64>,
    /// Empty while equal to `time_ns`.
    device_ns: Vec<Option<i64>>,
    columns: Vec<Option<Vec<f64>>>,
}

impl Recording {
    /// An empty recording.
    #[must_use]
    pub fn new(info: RecordingInfo) -> Self {
        Self { info, columns: vec![None; COLUMNS], ..Self::default() }
    }

    /// The number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_ns.len()
    }

    /// There is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_ns.is_empty()
    }

    /// Times of the samples on the host clock, ns, in the order of the file: neither uniform nor
    /// always ascending.
    #[must_use]
    pub fn times_ns(&self) -> &[i64] {
        &self.time_ns
    }

    /// Appends a sample.
    pub fn push(&mut self, sample: &GazeSample) {
        self.columns.resize(COLUMNS, None);
        let index = self.time_ns.len();
        self.time_ns.push(sample.time_ns);
        if !self.received_ns.is_empty() || sample.received_ns != sample.time_ns {
            if self.received_ns.is_empty() {
                self.received_ns.extend_from_slice(&self.time_ns[..index]);
            }
            self.received_ns.push(sample.received_ns);
        }
        if !self.device_ns.is_empty() || sample.device_time_ns != Some(sample.time_ns) {
            if self.device_ns.is_empty() {
                self.device_ns.extend(self.time_ns[..index].iter().copied().map(Some));
            }
            self.device_ns.push(sample.device_time_ns);
        }
        for (eye, first) in [&sample.combined, &sample.left, &sample.right].into_iter().zip(0..) {
            let values = eye_values(eye);
            self.set(index, first * EYE_COLUMNS, &values);
        }
        self.set(index, 3 * EYE_COLUMNS, &head_values(sample.head));
    }

    fn set(&mut self, index: usize, first: usize, values: &[f64]) {
        for (column, &value) in self.columns[first..].iter_mut().zip(values) {
            match column {
                Some(column) => column.push(value),
                None if value.is_nan() => {}
                None => {
                    let mut made = vec![f64::NAN; index];
                    made.push(value);
                    *column = Some(made);
                }
            }
        }
    }

    /// A sample; `None` beyond the end.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<GazeSample> {
        let time_ns = *self.time_ns.get(index)?;
        let mut values = [f64::NAN; COLUMNS];
        for (value, column) in values.iter_mut().zip(&self.columns) {
            if let Some(told) = column.as_ref().and_then(|column| column.get(index)) {
                *value = *told;
            }
        }
        let eye = |number: usize| eye_of(&values[number * EYE_COLUMNS..(number + 1) * EYE_COLUMNS]);
        Some(GazeSample {
            device_time_ns: self.device_ns.get(index).copied().unwrap_or(Some(time_ns)),
            received_ns: self.received_ns.get(index).copied().unwrap_or(time_ns),
            time_ns,
            combined: eye(0),
            left: eye(1),
            right: eye(2),
            head: head_of(&values[3 * EYE_COLUMNS..]),
        })
    }

    /// All samples in the order of the file.
    pub fn samples(&self) -> impl ExactSizeIterator<Item = GazeSample> + '_ {
        (0..self.len()).map(|index| self.get(index).unwrap_or_default())
    }

    /// The values of an extra column, one for each sample, NaN where missing; `None` if there is none of
    /// that name.
    #[must_use]
    pub fn extra_column(&self, name: &str) -> Option<&[f64]> {
        let column = self.extra.iter().find(|column| column.name == name)?;
        Some(&column.values)
    }

    /// Notes rows that became no sample. Rows with the same reason are counted together.
    pub fn skip(&mut self, rows: u64, why: impl Into<String>) {
        let why = why.into();
        match self.info.skipped.iter_mut().find(|skipped| skipped.why == why) {
            Some(skipped) => skipped.rows += rows,
            None => self.info.skipped.push(Skipped { rows, why }),
        }
    }

    /// As [`Self::skip`], where there may have been none.
    pub fn skip_any(&mut self, rows: u64, why: &str) {
        if rows > 0 {
            self.skip(rows, why);
        }
    }

    /// Samples per second: from the median step between ascending times; `None` below two samples.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let mut steps_ns: Vec<i64> = self
            .time_ns
            .windows(2)
            .map(|pair| pair[1].saturating_sub(pair[0]))
            .filter(|step| *step > 0)
            .collect();
        if steps_ns.is_empty() {
            return None;
        }
        let middle = steps_ns.len() / 2;
        let (_, median_ns, _) = steps_ns.select_nth_unstable(middle);
        Some(1e9 / *median_ns as f64)
    }

    /// From the earliest to the latest sample, s; 0 for an empty recording.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let ends = self.time_ns.iter().min().zip(self.time_ns.iter().max());
        ends.map_or(0.0, |(first, last)| (i128::from(*last) - i128::from(*first)) as f64 * 1e-9)
    }
}

/// NaN stands for `None` in a column.
fn eye_values(eye: &EyeSample) -> [f64; EYE_COLUMNS] {
    let origin = eye.origin_m.unwrap_or(DVec3::NAN);
    let direction = eye.direction.unwrap_or(DVec3::NAN);
    let point = eye.point.unwrap_or(DVec2::NAN);
    let told = eye.origin_m.is_some() || eye.direction.is_some() || eye.point.is_some();
    // An eye that was never heard of leaves no column of zeros.
    let valid = if eye.valid {
        1.0
    } else if told {
        0.0
    } else {
        f64::NAN
    };
    [
        valid,
        eye.confidence.unwrap_or(f64::NAN),
        eye.pupil_mm.unwrap_or(f64::NAN),
        eye.openness.unwrap_or(f64::NAN),
        origin.x,
        origin.y,
        origin.z,
        direction.x,
        direction.y,
        direction.z,
        point.x,
        point.y,
    ]
}

fn some(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

fn some_vector(values: &[f64]) -> Option<DVec3> {
    let vector = DVec3::from_slice(values);
    (!vector.is_nan()).then_some(vector)
}

fn eye_of(values: &[f64]) -> EyeSample {
    let point = DVec2::from_slice(&values[10..]);
    EyeSample {
        valid: values[0] > 0.0,
        confidence: some(values[1]),
        pupil_mm: some(values[2]),
        openness: some(values[3]),
        origin_m: some_vector(&values[4..]),
        direction: some_vector(&values[7..]),
        point: (!point.is_nan()).then_some(point),
    }
}

fn head_values(head: Option<HeadPose>) -> [f64; HEAD_COLUMNS] {
    let Some(HeadPose { position_m, world_from_view: turn }) = head else { return [f64::NAN; HEAD_COLUMNS] };
    [position_m.x, position_m.y, position_m.z, turn.x, turn.y, turn.z, turn.w]
}

fn head_of(values: &[f64]) -> Option<HeadPose> {
    let world_from_view = DQuat::from_slice(&values[3..]);
    let position_m = DVec3::from_slice(values);
    (!world_from_view.is_nan() && !position_m.is_nan()).then_some(HeadPose { position_m, world_from_view })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking(x: f64) -> EyeSample {
        EyeSample { valid: true, direction: Some(DVec3::new(x, 0.0, -1.0)), ..EyeSample::default() }
    }

    #[test]
    fn samples_come_back_as_they_went_in() {
        let head =
            HeadPose { position_m: DVec3::new(0.0, 1.6, 0.0), world_from_view: DQuat::from_rotation_y(0.5) };
        let full = EyeSample {
            valid: false,
            origin_m: Some(DVec3::new(0.03, 0.0, 0.0)),
            point: Some(DVec2::new(-0.5, 1.5)),
            confidence: Some(0.25),
            pupil_mm: Some(3.5),
            openness: Some(0.0),
            ..looking(0.1)
        };
        let samples = [
            GazeSample { combined: looking(0.0), ..GazeSample::at(1) },
            GazeSample { left: full, right: looking(0.2), head: Some(head), ..GazeSample::at(2) },
            GazeSample { device_time_ns: None, received_ns: 7, ..GazeSample::at(3) },
            GazeSample { device_time_ns: Some(-9), combined: looking(0.3), ..GazeSample::at(-4) },
        ];
        let mut recording = Recording::new(RecordingInfo::default());
        for sample in &samples {
            recording.push(sample);
        }
        assert_eq!(recording.samples().collect::<Vec<_>>(), samples);
        assert_eq!(recording.get(4), None);
    }

    #[test]
    fn only_columns_with_values_take_memory() {
        let mut recording = Recording::new(RecordingInfo::default());
        for time_ns in 0..10 {
            recording.push(&GazeSample { combined: looking(0.0), ..GazeSample::at(time_ns) });
        }
        assert_eq!(recording.columns.iter().flatten().count(), 4);
        assert!(recording.received_ns.is_empty() && recording.device_ns.is_empty());
    }

    #[test]
    fn rate_and_duration_survive_disorder() {
        let mut recording = Recording::new(RecordingInfo::default());
        assert_eq!((recording.rate_hz(), recording.duration_s()), (None, 0.0));
        for time_ms in [0, 8, 16, 12, 24, 32, 1000] {
            recording.push(&GazeSample::at(time_ms * 1_000_000));
        }
        assert_eq!((recording.rate_hz(), recording.duration_s()), (Some(125.0), 1.0));
    }

    #[test]
    fn a_screen_maps_there_and_back() {
        let screen =
            Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::new(0.5, 0.3), distance_m: 0.6 };
        assert_eq!(screen.direction_of(DVec2::splat(0.5)), DVec3::NEG_Z);
        let point = DVec2::new(0.9, 0.1);
        let direction = screen.direction_of(point);
        assert!(direction.x > 0.0 && direction.y > 0.0);
        assert!(screen.point_of(direction).is_some_and(|back| back.abs_diff_eq(point, 1e-14)));
        assert_eq!(screen.point_of(DVec3::Z), None);
    }
}
