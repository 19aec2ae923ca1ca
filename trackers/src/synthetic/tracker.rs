//! What a tracker makes of the true eye.

use super::eye::{EyeModel, TrueEye};
use super::geometry::{angle, deflect, place_deg};
use super::random::{Lattice, Random, stream};
use super::settings::{SyntheticSettings, TrackerSettings};
use crate::error::Result;
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};

/// Lattice step of slow wander, ns: slower than drift within a fixation, faster than a slipping headset.
const WANDER_NS: i64 = 250_000_000;
/// By how much the systematic errors of the eyes differ from what both have in common, as a fraction of
/// it: each eye errs more than both together (Schuetz and Fiehler 2022).
const EYE_SPLIT: f64 = 0.6;
/// How far a half-covered pupil seems to turn down, degrees.
const LID_PULL_DEG: f64 = 1.0;
/// Jitter is cut at this many times its mean.
const JITTER_CUT: f64 = 20.0;

/// A systematic error whose size depends on the eccentricity and whose direction changes slowly over the
/// field of view.
#[derive(Clone, Debug)]
struct Field {
    table: Vec<[f64; 2]>,
    angle_rad: f64,
    change_rad_per_deg: DVec2,
}

impl Field {
    fn new(table: &[[f64; 2]], key: u64, item: i64) -> Self {
        let mut random = Random::new(key, stream::FIELD, item);
        let angle_rad = std::f64::consts::TAU * random.unit();
        // Up to about half a turn across 40 degrees.
        let change = DVec2::new(random.between(-0.04, 0.04), random.between(-0.04, 0.04));
        Self { table: table.to_vec(), angle_rad, change_rad_per_deg: change }
    }

    /// Size of the error, degrees: straight lines between the table's entries, never below zero.
    fn size_deg(&self, eccentricity_deg: f64) -> f64 {
        let Some(first) = self.table.first() else { return 0.0 };
        if eccentricity_deg <= first[0] || self.table.len() < 2 {
            return first[1];
        }
        let above = self.table.partition_point(|entry| entry[0] < eccentricity_deg);
        let above = above.clamp(1, self.table.len() - 1);
        let ([x0, y0], [x1, y1]) = (self.table[above - 1], self.table[above]);
        (y0 + (y1 - y0) * (eccentricity_deg - x0) / (x1 - x0)).max(0.0)
    }

    fn at_deg(&self, place_deg: DVec2, eccentricity_deg: f64) -> DVec2 {
        let angle = self.angle_rad + self.change_rad_per_deg.dot(place_deg);
        DVec2::from_angle(angle) * self.size_deg(eccentricity_deg)
    }
}

/// A tracker that watches a synthetic eye. Every sample is a function of its number and its time alone.
#[derive(Clone, Debug)]
pub struct SyntheticTracker {
    model: EyeModel,
    settings: TrackerSettings,
    key: u64,
    shared: Field,
    split: Field,
    wander: Lattice,
}

impl SyntheticTracker {
    /// A tracker and its eye.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for a setting out of its range.
    pub fn new(settings: &SyntheticSettings, seed: u64) -> Result<Self> {
        let tracker = &settings.tracker;
        let model = EyeModel::new(settings, seed)?;
        Ok(Self {
            model,
            key: seed,
            shared: Field::new(&tracker.accuracy_deg, seed, 0),
            split: Field::new(&tracker.accuracy_deg, seed, 1),
            wander: Lattice::new(seed, stream::WANDER, WANDER_NS),
            settings: tracker.clone(),
        })
    }

    /// The true eye.
    pub fn eye(&mut self) -> &mut EyeModel {
        &mut self.model
    }

    /// The true state at a time of the eye.
    #[must_use]
    pub fn truth_at(&mut self, time_ns: i64) -> TrueEye {
        self.model.state_at(time_ns)
    }

    /// The sample with a number, of the eye at a time, and the truth at that time. Times of the sample
    /// are the eye's; `received_ns` leaves out that one sample waits for another.
    #[must_use]
    pub fn sample(&mut self, number: i64, time_ns: i64) -> (GazeSample, TrueEye) {
        let truth = self.model.state_at(time_ns);
        let unseen = self.model.unseen_at(time_ns);
        let eccentricity_deg = angle(DVec3::NEG_Z, truth.direction).to_degrees();
        let place = place_deg(truth.direction);
        let mut random = Random::new(self.key, stream::SAMPLE, number);
        // Two equal coordinates, two samples: RMS from sample to sample is twice the deviation of one.
        // Each eye has the root of two of it, so that both together have what is set.
        let growth = 1.0 + self.settings.noise_growth_per_deg * eccentricity_deg;
        let sigma_deg = self.settings.noise_deg * 0.5 * growth * std::f64::consts::SQRT_2;
        let noise_deg = [random.normal_pair() * sigma_deg, random.normal_pair() * sigma_deg];
        let pull_deg = DVec2::new(0.0, -2.0 * LID_PULL_DEG * (1.0 - truth.openness));
        let shared_deg = self.shared.at_deg(place, eccentricity_deg)
            + self.wander.at(time_ns) * self.settings.wander_deg
            + pull_deg;
        let split_deg = self.split.at_deg(place, eccentricity_deg) * EYE_SPLIT;
        let error_deg = [shared_deg + split_deg + noise_deg[0], shared_deg - split_deg + noise_deg[1]];
        let seen = |direction: DVec3, by_deg: DVec2| {
            let swing = if self.settings.pupil_based { truth.pupil_swing } else { DVec3::ZERO };
            deflect((direction + swing).normalize_or(direction), by_deg)
        };
        let combined_deg = match unseen {
            [true, false] => error_deg[1],
            [false, true] => error_deg[0],
            _ => (error_deg[0] + error_deg[1]) * 0.5,
        };
        let origin_m = truth.left_origin_m;
        let mut sample = GazeSample {
            device_time_ns: Some(self.device_time_ns(time_ns)),
            received_ns: time_ns.saturating_add(self.delay_ns(number)),
            time_ns,
            combined: EyeSample {
                valid: unseen != [true, true],
                direction: (unseen != [true, true]).then(|| seen(truth.direction, combined_deg)),
                pupil_mm: (unseen != [true, true]).then_some(truth.pupil_mm),
                ..EyeSample::default()
            },
            head: self.settings.tells_head.then_some(truth.head),
            ..GazeSample::default()
        };
        if self.settings.tells_eyes {
            let eye = |unseen: bool, direction, origin_m, by_deg| EyeSample {
                valid: !unseen,
                origin_m: (!unseen).then_some(origin_m),
                direction: (!unseen).then(|| seen(direction, by_deg)),
                point: None,
                confidence: Some(if unseen { 0.0 } else { truth.openness }),
                pupil_mm: (!unseen).then_some(truth.pupil_mm),
                openness: Some(truth.openness),
            };
            sample.left = eye(unseen[0], truth.left, origin_m, error_deg[0]);
            sample.right = eye(unseen[1], truth.right, -origin_m, error_deg[1]);
            sample.combined.origin_m = sample.combined.valid.then_some(DVec3::ZERO);
        }
        (sample, truth)
    }

    /// The sample never arrives.
    pub(super) fn dropped(&self, number: i64) -> bool {
        let probability = self.settings.drop_probability;
        probability > 0.0 && Random::new(self.key, stream::BURST + 1000, number).chance(probability)
    }

    /// The last of the group that arrives together with a sample; itself where it arrives alone.
    pub(super) fn arrives_with(&self, number: i64) -> i64 {
        let size = i64::from(self.settings.burst.max(1));
        let group = number.div_euclid(size);
        let mut random = Random::new(self.key, stream::BURST, group);
        if random.chance(self.settings.burst_probability) {
            group.saturating_mul(size).saturating_add(size - 1)
        } else {
            number
        }
    }

    /// From the eye's movement to the sample's arrival, ns.
    pub(super) fn delay_ns(&self, number: i64) -> i64 {
        let mean_ms = self.settings.jitter_ms;
        let jitter_ms = Random::new(self.key, stream::SAMPLE + 1000, number)
            .exponential(mean_ms)
            .min(JITTER_CUT * mean_ms);
        ((self.settings.latency_ms + jitter_ms) * 1e6) as i64
    }

    /// The device clock at a time of the eye.
    fn device_time_ns(&self, time_ns: i64) -> i64 {
        let fast_ns = (time_ns as f64 * self.settings.clock_drift_ppm * 1e-6) as i128;
        let clock_ns = i128::from(time_ns) + fast_ns + i128::from(self.settings.clock_offset_ns);
        let tick_ns = i128::from(self.settings.clock_tick_ns.max(1));
        let mut ticks = clock_ns.div_euclid(tick_ns);
        if self.settings.clock_bits > 0 {
            ticks = ticks.rem_euclid(1_i128 << self.settings.clock_bits.min(63));
        }
        (ticks * tick_ns).clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }
}
