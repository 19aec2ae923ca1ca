//! Measures recordings as `trackers.md` describes, knowing nothing of how they were made: labels, places
//! in degrees, a velocity from a 19 ms Savitzky-Golay filter.

use crate::recording::Recording;
use crate::testing::shared;
use glam::DVec2;

/// A labelled recording at 1 kHz.
pub struct Trace {
    pub place_deg: Vec<DVec2>,
    pub label: Vec<u8>,
}

pub const FIXATION: u8 = 1;
pub const SACCADE: u8 = 2;
pub const OSCILLATION: u8 = 3;
pub const MICROSACCADE: u8 = 7;

/// A run of one label: from a sample to the one behind its last.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    pub label: u8,
    pub from: usize,
    pub to: usize,
}

/// A saccade as measured.
#[derive(Clone, Copy, Debug)]
pub struct Saccade {
    pub amplitude_deg: f64,
    pub duration_ms: f64,
    pub peak_deg_s: f64,
    /// Of the speed, as a fraction of the duration.
    pub peak_at: f64,
}

impl Trace {
    /// Of the combined gaze as the tracker told it.
    pub fn measured(recording: &Recording) -> Self {
        let place = |sample: crate::sample::GazeSample| {
            sample.combined.usable_direction().map_or(DVec2::NAN, |gaze| {
                DVec2::new(gaze.x.atan2(-gaze.z), gaze.y.asin()) * 1.0_f64.to_degrees()
            })
        };
        let labels = recording.extra.iter().find(|column| column.name == "evt_truth").expect("labels");
        Self {
            place_deg: recording.samples().map(place).collect(),
            label: labels.values.iter().map(|label| *label as u8).collect(),
        }
    }

    /// The hand-labelled recording: records of `<f8 <f4 <f4 bool u1` behind a numpy header.
    pub fn hand_labelled() -> Option<Self> {
        let path = shared("data/gaze/irf_lookAtPoint_EL/lookAtPoint_EL_S1.npy")?;
        let bytes = std::fs::read(path).expect("readable");
        let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let (mut place_deg, mut label) = (Vec::new(), Vec::new());
        for record in bytes[10 + header..].chunks_exact(18) {
            let float = |at: usize| f32::from_le_bytes(record[at..at + 4].try_into().expect("4 bytes"));
            place_deg.push(DVec2::new(float(8).into(), float(12).into()));
            label.push(record[17]);
        }
        Some(Self { place_deg, label })
    }

    pub fn runs(&self) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (at, label) in self.label.iter().enumerate() {
            // A microsaccade that an expert sees is labelled a saccade.
            let label = if *label == MICROSACCADE { SACCADE } else { *label };
            match runs.last_mut() {
                Some(run) if run.label == label => run.to = at + 1,
                _ => runs.push(Run { label, from: at, to: at + 1 }),
            }
        }
        runs
    }

    /// Speed at each sample, deg/s: the slope of a parabola fitted to 19 samples.
    pub fn speed_deg_s(&self) -> Vec<f64> {
        const HALF: usize = 9;
        let weight: f64 = 2.0 * (1..=HALF).map(|k| (k * k) as f64).sum::<f64>();
        let slope = |at: usize| {
            let ahead = (1..=HALF).map(|k| (self.place_deg[at + k] - self.place_deg[at - k]) * k as f64);
            ahead.sum::<DVec2>().length() / weight * 1000.0
        };
        let count = self.place_deg.len();
        let inside = |at: usize| at >= HALF && at + HALF < count;
        (0..count).map(|at| if inside(at) { slope(at) } else { f64::NAN }).collect()
    }

    /// All that was seen from end to end.
    pub fn saccades(&self) -> Vec<Saccade> {
        let speed = self.speed_deg_s();
        let mut found = Vec::new();
        for run in self.runs().iter().filter(|run| run.label == SACCADE) {
            let within = &speed[run.from..run.to];
            let (peak_index, peak_deg_s) = within
                .iter()
                .copied()
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .expect("a run is not empty");
            let amplitude_deg = self.place_deg[run.to - 1].distance(self.place_deg[run.from]);
            if amplitude_deg.is_finite() && within.iter().all(|speed| speed.is_finite()) {
                found.push(Saccade {
                    amplitude_deg,
                    duration_ms: (run.to - run.from) as f64,
                    peak_deg_s,
                    peak_at: peak_index as f64 / (run.to - run.from) as f64,
                });
            }
        }
        found
    }

    /// From the end of each saccade to the start of the next, ms.
    pub fn intervals_ms(&self) -> Vec<f64> {
        let runs = self.runs();
        let saccades: Vec<&Run> = runs.iter().filter(|run| run.label == SACCADE).collect();
        saccades.windows(2).map(|pair| (pair[1].from - pair[0].to) as f64).collect()
    }

    /// Lengths of the runs with a label, samples.
    pub fn lengths(&self, label: u8) -> Vec<f64> {
        let runs = self.runs();
        runs.iter().filter(|run| run.label == label).map(|run| (run.to - run.from) as f64).collect()
    }

    /// RMS from sample to sample over all fixations.
    pub fn rms_s2s_deg(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for run in self.runs().iter().filter(|run| run.label == FIXATION) {
            for pair in self.place_deg[run.from..run.to].windows(2) {
                let step = pair[0].distance_squared(pair[1]);
                if step.is_finite() {
                    sum += step;
                    count += 1;
                }
            }
        }
        (sum / f64::from(count)).sqrt()
    }
}

/// The value below which a fraction of all lies.
pub fn percentile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(fraction * (sorted.len() - 1) as f64).round() as usize]
}

/// Slope and intercept of the least-squares line.
pub fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let count = points.clone().count() as f64;
    let mean_x = points.clone().map(|point| point.0).sum::<f64>() / count;
    let mean_y = points.clone().map(|point| point.1).sum::<f64>() / count;
    let (mut xy, mut xx) = (0.0, 0.0);
    for (x, y) in points {
        xy += (x - mean_x) * (y - mean_y);
        xx += (x - mean_x).powi(2);
    }
    (xy / xx, mean_y - xy / xx * mean_x)
}
