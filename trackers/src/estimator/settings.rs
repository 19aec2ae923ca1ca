//! How the estimator is tuned.

use crate::classify::ClassifierSettings;
use crate::filter::{FilterChain, OneEuro, SaccadeAware};
use crate::predict::{MAX_HORIZON_NS, PredictorKind};

/// The filters between samples and estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilterKind {
    /// None: estimates start from the raw gaze.
    None,
    /// [`OneEuro`].
    OneEuro,
    /// [`SaccadeAware`].
    #[default]
    SaccadeAware,
}

impl FilterKind {
    /// The chain, with default settings.
    #[must_use]
    pub fn make(self) -> FilterChain {
        match self {
            Self::None => FilterChain::default(),
            Self::OneEuro => FilterChain::new(vec![Box::<OneEuro>::default()]),
            Self::SaccadeAware => FilterChain::new(vec![Box::<SaccadeAware>::default()]),
        }
    }
}

/// What a renderer wants during a saccade.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aim {
    /// The landing point at once: the eye sees next to nothing in flight, and the picture is already right
    /// when it arrives (Arabadzhiyska et al. 2017).
    #[default]
    Landing,
    /// Where the eye is at the display time.
    Trajectory,
}

/// How long what is kept when the eye is not seen, all counted from the last valid sample, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LossPolicy {
    /// A loss of up to this goes unnoticed: the prediction goes on.
    pub bridge_ns: i64,
    /// For so long both eyes are awaited when only one is seen; then that one stands in for them, with a
    /// larger error radius. 0 takes it at once: the gaze then jumps by the difference of the eyes (up
    /// to degrees) whenever one of them flickers. Longer loses a saccade that begins meanwhile.
    pub one_eye_after_ns: i64,
    /// For so long the gaze is held at its usual error radius and the growth of a gaze at rest; a blink
    /// takes 100 to 400 ms, and the eye mostly comes back to where it was.
    pub hold_ns: i64,
    /// Without a sample, valid or not, for so long, the source counts as stale.
    pub stale_after_ns: i64,
    /// After so long there is no estimate: the renderer goes to its fallback.
    pub none_after_ns: i64,
}

impl Default for LossPolicy {
    fn default() -> Self {
        Self {
            bridge_ns: 20_000_000,
            one_eye_after_ns: 20_000_000,
            hold_ns: 400_000_000,
            stale_after_ns: 200_000_000,
            none_after_ns: 2_000_000_000,
        }
    }
}

/// What the error radius is made of. All at one standard deviation: about two thirds of the time the true
/// gaze lies within. The tail is longer than a Gaussian's, by the saccades that begin after the newest
/// sample: 60 ms ahead the gaze has by then jumped in one case of ten, and in those vision is suppressed.
/// It does not fall with the time ahead, but for a landing point, which the eye comes nearer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiusSettings {
    /// Accuracy of the tracker, deg: how far its fixations lie from the target. 1.1 deg is the mean of a
    /// Vive Pro Eye over the field.
    pub accuracy_deg: f64,
    /// Factor on the accuracy with only one eye (1 or more; less counts as 1): the mean of two eyes with
    /// independent errors is better by the square root of 2.
    pub one_eye_factor: f64,
    /// Growth with age in a fixation, deg/s: for drift, and for a part of the saccades that may begin. To
    /// cover all of them (three a second of 5 deg) by the root of the mean square, it would be 40.
    pub rest_deg_s: f64,
    /// In a pursuit: the target may turn or stop.
    pub pursuit_deg_s: f64,
    /// In a saccade, a blink, a loss, or an unknown state: the eye may go anywhere.
    pub moving_deg_s: f64,
    /// Times the speed over the window, deg/s, in a saccade: what a few milliseconds of doubt about when the
    /// sample was taken mean. Around a loss, where no movement is predicted, the age (up to 100 ms) is
    /// added to it.
    pub timing_s: f64,
    /// Growth after the loss policy's hold, deg/s.
    pub widen_deg_s: f64,
    /// The largest radius, deg: half of a display. Everything is bounded by it.
    pub cap_deg: f64,
}

impl Default for RadiusSettings {
    fn default() -> Self {
        Self {
            accuracy_deg: 1.0,
            one_eye_factor: std::f64::consts::SQRT_2,
            rest_deg_s: 10.0,
            pursuit_deg_s: 20.0,
            moving_deg_s: 40.0,
            timing_s: 0.004,
            widen_deg_s: 30.0,
            cap_deg: 30.0,
        }
    }
}

/// All settings of an [`super::Estimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Samples kept: 1024 are a second at 1 kHz. 1 to 65 536.
    pub capacity: usize,
    /// Samples whose told confidence is below this (0 to 1) count as invalid. 0.6 is what Pupil's
    /// documentation calls useful.
    pub min_confidence: f64,
    /// The online classifier.
    pub classifier: ClassifierSettings,
    /// The filters.
    pub filter: FilterKind,
    /// The predictor.
    pub predictor: PredictorKind,
    /// What is told during a saccade.
    pub aim: Aim,
    /// Between samples further apart than this, ns, nothing is interpolated.
    pub max_gap_ns: i64,
    /// Further ahead than this, ns, nothing is predicted but the last gaze held.
    pub max_horizon_ns: i64,
    /// What happens when the eye is not seen.
    pub loss: LossPolicy,
    /// The error radius.
    pub radius: RadiusSettings,
}

impl Default for EstimatorSettings {
    fn default() -> Self {
        Self {
            capacity: 1024,
            min_confidence: 0.6,
            classifier: ClassifierSettings::default(),
            filter: FilterKind::default(),
            predictor: PredictorKind::default(),
            aim: Aim::default(),
            max_gap_ns: 50_000_000,
            max_horizon_ns: MAX_HORIZON_NS,
            loss: LossPolicy::default(),
            radius: RadiusSettings::default(),
        }
    }
}
