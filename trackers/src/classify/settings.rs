//! The tuning of the classifier.

/// How [`super::Classifier`] decides. Speeds are angular, over the window; `noise` is the running median of
/// the speed outside saccades, which scales with the tracker's jitter and its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassifierSettings {
    /// Length of the velocity window, ns. Longer: less noise, but a saccade is seen later and small ones
    /// are flattened. 8 to 12 ms are about half of the shortest saccades (18 ms); at least two samples
    /// are used at low rates.
    pub window_ns: i64,
    /// A saccade begins at this many times the noise. The speed of jitter in two dimensions follows a
    /// Rayleigh distribution, of which one in 10^10 exceeds 6 medians. Lower finds smaller saccades and
    /// more false ones.
    pub onset_noise: f64,
    /// A saccade reaches as far as the speed exceeds this many times the noise (one in 500 of jitter).
    /// Lower makes saccades longer at both ends.
    pub offset_noise: f64,
    /// The least threshold of onset, deg/s, for trackers with next to no noise. The drift of a fixating
    /// eye stays below a few deg/s.
    pub onset_floor_deg_s: f64,
    /// The least threshold of offset, deg/s.
    pub offset_floor_deg_s: f64,
    /// A saccade ends below this share of its peak speed at the latest: what follows is the
    /// post-saccadic oscillation. Higher cuts saccades off.
    pub offset_peak_share: f64,
    /// Memory of the noise, s. Longer: steadier; shorter: quicker where a tracker becomes noisy.
    pub noise_memory_s: f64,
    /// Time constant of the slow velocity that is taken off before a saccade is looked for: pursuit, and
    /// the counter-rotation of the eye where the head's pose is not known. Longer is slower to follow.
    pub drift_tau_s: f64,
    /// For so long after a saccade the eye may oscillate, ns (15 to 45 ms were labelled); the threshold of
    /// the next onset is raised and decays.
    pub settle_ns: i64,
    /// The raised threshold right after a saccade, as a share of its peak speed.
    pub settle_peak_share: f64,
    /// Time constant of its decay, s: that of the oscillation.
    pub settle_tau_s: f64,
    /// Less than this, deg, is no saccade but noise or a microsaccade. Scales up with the noise.
    pub min_amplitude_deg: f64,
    /// A shorter movement, ns, is no saccade but a glitch.
    pub min_saccade_ns: i64,
    /// A longer one, ns, is none either, but a pursuit: 80 degrees take 200 ms.
    pub max_saccade_ns: i64,
    /// A loss of up to this, ns, is bridged: the eye goes on with what it did.
    pub min_loss_ns: i64,
    /// For so long after a longer loss, ns, the gaze is not trusted: the lids still uncover the pupil and
    /// drag its centre along. 100 ms is the usual margin around blinks.
    pub reopen_ns: i64,
    /// A loss that lasts longer, ns, is no blink (100 to 400 ms).
    pub max_blink_ns: i64,
    /// Openness below which the lids count as closed, 0 to 1.
    pub closed_openness: f64,
    /// The least speed of a pursuit, deg/s. Lower takes the drift of a fixation for pursuit.
    pub pursuit_deg_s: f64,
    /// A pursuit is also at least this many times the noise of the slow velocity.
    pub pursuit_noise: f64,
    /// The slow velocity must stay above the threshold for this long, ns, to be a pursuit, and below it
    /// to be none.
    pub min_pursuit_ns: i64,
    /// Samples further apart, ns, say nothing of speed.
    pub max_step_ns: i64,
}

impl Default for ClassifierSettings {
    fn default() -> Self {
        Self {
            window_ns: 10_000_000,
            onset_noise: 6.0,
            offset_noise: 3.0,
            onset_floor_deg_s: 15.0,
            offset_floor_deg_s: 8.0,
            offset_peak_share: 0.1,
            noise_memory_s: 0.5,
            drift_tau_s: 0.06,
            settle_ns: 60_000_000,
            settle_peak_share: 0.5,
            settle_tau_s: 0.02,
            min_amplitude_deg: 0.3,
            min_saccade_ns: 5_000_000,
            max_saccade_ns: 200_000_000,
            min_loss_ns: 20_000_000,
            reopen_ns: 100_000_000,
            max_blink_ns: 500_000_000,
            closed_openness: 0.2,
            pursuit_deg_s: 5.0,
            pursuit_noise: 4.0,
            min_pursuit_ns: 100_000_000,
            max_step_ns: 100_000_000,
        }
    }
}
