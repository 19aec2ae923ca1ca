//! Everything that can be set, with where each default comes from.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Where the eye goes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plan {
    /// To targets anywhere in a field, as in a task with jumping targets.
    Targets,
    /// By steps of a drawn length within a field.
    Explore,
    /// Along lines of text within a field, from the left to the right.
    Reading,
}

/// The scene that the eye looks at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneSettings {
    /// Where the eye goes next.
    pub plan: Plan,
    /// Half the width of the field, degrees of yaw.
    pub half_width_deg: f64,
    /// Half the height of the field, degrees of pitch.
    pub half_height_deg: f64,
    /// Median amplitude of steps ([`Plan::Explore`], [`Plan::Reading`]), degrees.
    pub step_deg: f64,
    /// Standard deviation of the logarithm of the step.
    pub step_sigma: f64,
    /// Largest amplitude of a saccade, degrees.
    pub max_amplitude_deg: f64,
    /// Median distance of what is looked at, m. Both eyes converge there.
    pub depth_m: f64,
    /// Standard deviation of the logarithm of that distance; 0 is a screen.
    pub depth_sigma: f64,
    /// Probability that what is looked at moves and is followed.
    pub pursuit_probability: f64,
    /// Median speed of what moves, deg/s.
    pub pursuit_deg_s: f64,
    /// Median time for which it is followed, ms.
    pub pursuit_ms: f64,
    /// Speed of the following eye over that of what it follows; catch-up saccades make up the rest.
    pub pursuit_gain: f64,
}

/// Fixations and what the eye does in them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FixationSettings {
    /// Median time on one place, ms.
    pub median_ms: f64,
    /// Standard deviation of the logarithm of that time.
    pub sigma: f64,
    /// Microsaccades per second of fixation; 1 to 2 (PMC6032122).
    pub microsaccades_per_s: f64,
    /// Median amplitude of a microsaccade, degrees.
    pub microsaccade_deg: f64,
    /// Drift: root mean square displacement over the root of the time, each axis, degrees. It holds from
    /// 20 ms to half a second, is 0.8 of that after 1 s, and grows no further.
    pub drift_deg_per_root_s: f64,
    /// Standard deviation of tremor, each axis, degrees; 5 seconds of arc (Bowers et al. 2019).
    pub tremor_deg: f64,
}

/// Saccades. Defaults are those that, labelled and measured like the hand-labelled recordings, come out
/// at a duration of `2.28 A + 14.6` ms and a peak of `564 (1 - exp(-A / 8.9))` deg/s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SaccadeSettings {
    /// Duration of a saccade of no amplitude, ms.
    pub duration_at_zero_ms: f64,
    /// What each degree of amplitude adds to the duration, ms.
    pub duration_ms_per_deg: f64,
    /// Peak speed over mean speed. With the two above it makes the main sequence.
    pub peak_factor: f64,
    /// Standard deviation of the logarithm of the duration at one amplitude.
    pub duration_sigma: f64,
    /// Where the speed peaks in a very short saccade, as a fraction of its duration.
    pub mode_at_zero: f64,
    /// By how much that fraction falls with each ms of duration.
    pub mode_per_ms: f64,
    /// Standard deviation of the sideways bend at the middle of the way, as a fraction of the amplitude.
    pub curvature: f64,
    /// Probability that a saccade of 3 degrees or more falls short and is corrected.
    pub corrective_probability: f64,
    /// How much of the way such a saccade falls short.
    pub undershoot: f64,
    /// Median time from its end to the corrective saccade, ms.
    pub corrective_ms: f64,
    /// Displacement of the pupil at the end of a saccade, as a fraction of the amplitude.
    pub oscillation_fraction: f64,
    /// Largest such displacement, degrees.
    pub oscillation_max_deg: f64,
    /// Median length of the oscillation after a saccade, ms; 17 in the hand labels.
    pub oscillation_ms: f64,
}

/// Blinks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BlinkSettings {
    /// How many in a minute.
    pub per_min: f64,
    /// Median time from the first movement of the lids to the last, ms. The pupil is covered for 0.6
    /// of it.
    pub median_ms: f64,
    /// By how much the eyes turn down behind closed lids, degrees.
    pub dip_deg: f64,
}

/// The head.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeadSettings {
    /// How much of what lies beyond the dead zone the head turns for; 0 keeps it still.
    pub follow_gain: f64,
    /// Eccentricity up to which the eyes turn alone, degrees.
    pub dead_zone_deg: f64,
    /// Standard deviation of slow sway in yaw and pitch, degrees.
    pub sway_deg: f64,
    /// Standard deviation of slow sway in position, mm. Gaze directions do not answer to it.
    pub sway_mm: f64,
    /// Amplitude of a steady shake in yaw, degrees.
    pub shake_deg: f64,
    /// Frequency of the shake, Hz.
    pub shake_hz: f64,
    /// The vestibulo-ocular reflex: how much of the head's turn the eyes turn back while they fixate.
    pub vor_gain: f64,
}

/// The two eyes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EyesSettings {
    /// Distance between the eyes, mm.
    pub ipd_mm: f64,
    /// Mean diameter of the pupil, mm.
    pub pupil_mm: f64,
    /// Standard deviation of the diameter, mm.
    pub pupil_sigma_mm: f64,
}

/// What a tracker makes of the eye. The defaults are those of the Vive Pro Eye.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackerSettings {
    /// Samples per second when polled.
    pub rate_hz: f64,
    /// Systematic error by eccentricity: pairs of degrees, ascending; straight lines between them, and
    /// the last slope beyond. Vive Pro Eye: 0.58 at 0 to 0.94 at 20 (Schuetz and Fiehler 2022).
    pub accuracy_deg: Vec<[f64; 2]>,
    /// Noise of each sample by itself: RMS from sample to sample, degrees, at the centre.
    pub noise_deg: f64,
    /// By how much noise grows with each degree of eccentricity, as a fraction of that at the centre.
    pub noise_growth_per_deg: f64,
    /// Slow wander of the error: standard deviation of each axis, degrees.
    pub wander_deg: f64,
    /// It tracks the pupil, so that post-saccadic oscillation shows.
    pub pupil_based: bool,
    /// It tells each eye by itself, with openness and confidence.
    pub tells_eyes: bool,
    /// It tells the pose of the head.
    pub tells_head: bool,
    /// Time from the eye's movement to the arrival of the sample, ms.
    pub latency_ms: f64,
    /// Mean of the exponential delay on top of it, ms; cut at 20 times that.
    pub jitter_ms: f64,
    /// Size of a group of samples that may arrive together.
    pub burst: u32,
    /// Probability that a group does.
    pub burst_probability: f64,
    /// Probability that a sample never arrives.
    pub drop_probability: f64,
    /// Tick of the device clock, ns. Times are rounded down to it.
    pub clock_tick_ns: i64,
    /// Device time at time zero of the eye, ns.
    pub clock_offset_ns: i64,
    /// How much faster the device clock runs, parts per million.
    pub clock_drift_ppm: f64,
    /// Bits of the device's tick counter, after which it wraps as a device does whose driver does not
    /// unwrap it; 0 for no wrap.
    pub clock_bits: u32,
    /// How often in a minute the tracker loses both eyes.
    pub losses_per_min: f64,
    /// How often in a minute it loses one eye.
    pub one_eye_losses_per_min: f64,
    /// Median length of a loss, ms.
    pub loss_ms: f64,
}

/// Everything that can be set of a synthetic eye and its tracker.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SyntheticSettings {
    /// What is looked at.
    pub scene: SceneSettings,
    /// Fixations.
    pub fixation: FixationSettings,
    /// Saccades.
    pub saccade: SaccadeSettings,
    /// Blinks.
    pub blink: BlinkSettings,
    /// The head.
    pub head: HeadSettings,
    /// The eyes.
    pub eyes: EyesSettings,
    /// The tracker.
    pub tracker: TrackerSettings,
}

impl SyntheticSettings {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`Error::Setting`] with the first that is out of it.
    pub fn check(&self) -> Result<()> {
        for (name, value, low, high) in self.ranges() {
            if !(low..=high).contains(&value) {
                return Err(Error::Setting(format!("{name} is {value}; give {low} to {high}")));
            }
        }
        let table = &self.tracker.accuracy_deg;
        let ascending = table.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let sane = table.iter().flatten().all(|value| (0.0..=90.0).contains(value));
        if table.is_empty() || table.len() > 64 || !ascending || !sane {
            return Err(Error::Setting(
                "tracker.accuracy_deg is no table of error by eccentricity; give 1 to 64 pairs of degrees, \
                 0 to 90, by ascending eccentricity"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Every number that has a range.
    pub(super) fn ranges(&self) -> Vec<Range> {
        let parts = [
            self.scene.ranges(),
            self.fixation.ranges(),
            self.saccade.ranges(),
            self.blink.ranges(),
            self.head.ranges(),
            self.eyes.ranges(),
            self.tracker.ranges(),
        ];
        parts.into_iter().flatten().collect()
    }
}

/// Name, value, least and largest.
type Range = (&'static str, f64, f64, f64);

impl SceneSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("scene.half_width_deg", self.half_width_deg, 1.0, 80.0),
            ("scene.half_height_deg", self.half_height_deg, 1.0, 60.0),
            ("scene.step_deg", self.step_deg, 0.2, 60.0),
            ("scene.step_sigma", self.step_sigma, 0.0, 2.0),
            ("scene.max_amplitude_deg", self.max_amplitude_deg, 5.0, 60.0),
            ("scene.depth_m", self.depth_m, 0.2, 1e4),
            ("scene.depth_sigma", self.depth_sigma, 0.0, 2.0),
            ("scene.pursuit_probability", self.pursuit_probability, 0.0, 1.0),
            ("scene.pursuit_deg_s", self.pursuit_deg_s, 0.0, 60.0),
            ("scene.pursuit_ms", self.pursuit_ms, 100.0, 1e4),
            ("scene.pursuit_gain", self.pursuit_gain, 0.0, 1.2),
        ]
    }
}

impl FixationSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("fixation.median_ms", self.median_ms, 60.0, 1e4),
            ("fixation.sigma", self.sigma, 0.0, 2.0),
            ("fixation.microsaccades_per_s", self.microsaccades_per_s, 0.0, 5.0),
            ("fixation.microsaccade_deg", self.microsaccade_deg, 0.05, 1.0),
            ("fixation.drift_deg_per_root_s", self.drift_deg_per_root_s, 0.0, 2.0),
            ("fixation.tremor_deg", self.tremor_deg, 0.0, 0.1),
        ]
    }
}

impl SaccadeSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("saccade.duration_at_zero_ms", self.duration_at_zero_ms, 5.0, 100.0),
            ("saccade.duration_ms_per_deg", self.duration_ms_per_deg, 0.0, 10.0),
            ("saccade.peak_factor", self.peak_factor, 1.2, 2.5),
            ("saccade.duration_sigma", self.duration_sigma, 0.0, 0.5),
            ("saccade.mode_at_zero", self.mode_at_zero, 0.2, 0.5),
            ("saccade.mode_per_ms", self.mode_per_ms, 0.0, 0.05),
            ("saccade.curvature", self.curvature, 0.0, 0.2),
            ("saccade.corrective_probability", self.corrective_probability, 0.0, 1.0),
            ("saccade.undershoot", self.undershoot, 0.0, 0.3),
            ("saccade.corrective_ms", self.corrective_ms, 60.0, 500.0),
            ("saccade.oscillation_fraction", self.oscillation_fraction, 0.0, 0.3),
            ("saccade.oscillation_max_deg", self.oscillation_max_deg, 0.0, 2.0),
            ("saccade.oscillation_ms", self.oscillation_ms, 4.0, 50.0),
        ]
    }
}

impl BlinkSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("blink.per_min", self.per_min, 0.0, 60.0),
            ("blink.median_ms", self.median_ms, 50.0, 1000.0),
            ("blink.dip_deg", self.dip_deg, 0.0, 10.0),
        ]
    }
}

impl HeadSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("head.follow_gain", self.follow_gain, 0.0, 1.0),
            ("head.dead_zone_deg", self.dead_zone_deg, 0.0, 45.0),
            ("head.sway_deg", self.sway_deg, 0.0, 20.0),
            ("head.sway_mm", self.sway_mm, 0.0, 1000.0),
            ("head.shake_deg", self.shake_deg, 0.0, 45.0),
            ("head.shake_hz", self.shake_hz, 0.0, 5.0),
            ("head.vor_gain", self.vor_gain, 0.0, 1.2),
        ]
    }
}

impl EyesSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("eyes.ipd_mm", self.ipd_mm, 40.0, 80.0),
            ("eyes.pupil_mm", self.pupil_mm, 1.5, 9.0),
            ("eyes.pupil_sigma_mm", self.pupil_sigma_mm, 0.0, 1.0),
        ]
    }
}

impl TrackerSettings {
    fn ranges(&self) -> Vec<Range> {
        vec![
            ("tracker.rate_hz", self.rate_hz, 1.0, 1e4),
            ("tracker.noise_deg", self.noise_deg, 0.0, 5.0),
            ("tracker.noise_growth_per_deg", self.noise_growth_per_deg, 0.0, 0.2),
            ("tracker.wander_deg", self.wander_deg, 0.0, 5.0),
            ("tracker.latency_ms", self.latency_ms, 0.0, 1000.0),
            ("tracker.jitter_ms", self.jitter_ms, 0.0, 100.0),
            ("tracker.burst", f64::from(self.burst), 1.0, 1000.0),
            ("tracker.burst_probability", self.burst_probability, 0.0, 1.0),
            ("tracker.drop_probability", self.drop_probability, 0.0, 1.0),
            ("tracker.clock_tick_ns", self.clock_tick_ns as f64, 1.0, 1e9),
            ("tracker.clock_offset_ns", self.clock_offset_ns as f64, -9e18, 9e18),
            ("tracker.clock_drift_ppm", self.clock_drift_ppm, -1000.0, 1000.0),
            ("tracker.clock_bits", f64::from(self.clock_bits), 0.0, 63.0),
            ("tracker.losses_per_min", self.losses_per_min, 0.0, 60.0),
            ("tracker.one_eye_losses_per_min", self.one_eye_losses_per_min, 0.0, 60.0),
            ("tracker.loss_ms", self.loss_ms, 10.0, 5000.0),
        ]
    }
}
