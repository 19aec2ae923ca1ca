//! Defaults, and sets of settings by name.

use super::settings::{
    BlinkSettings, EyesSettings, FixationSettings, HeadSettings, Plan, SaccadeSettings, SceneSettings,
    SyntheticSettings, TrackerSettings,
};
use crate::error::{Error, Result};

/// Names of the sets of settings that [`SyntheticSettings::preset`] knows.
pub const PRESETS: [&str; 5] = ["target-task", "free-viewing", "reading", "pursuit", "vr-exploration"];

/// Names of the trackers that [`TrackerSettings::preset`] knows.
pub const TRACKERS: [&str; 3] = ["eyelink", "vive-pro-eye", "perfect"];

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            plan: Plan::Explore,
            half_width_deg: 20.0,
            half_height_deg: 12.0,
            step_deg: 4.0,
            step_sigma: 0.8,
            max_amplitude_deg: 45.0,
            depth_m: 0.7,
            depth_sigma: 0.0,
            pursuit_probability: 0.0,
            pursuit_deg_s: 10.0,
            pursuit_ms: 1500.0,
            pursuit_gain: 0.95,
        }
    }
}

impl Default for FixationSettings {
    fn default() -> Self {
        Self {
            median_ms: 280.0,
            sigma: 0.45,
            microsaccades_per_s: 1.5,
            microsaccade_deg: 0.35,
            drift_deg_per_root_s: 0.15,
            tremor_deg: 0.0014,
        }
    }
}

impl Default for SaccadeSettings {
    fn default() -> Self {
        Self {
            duration_at_zero_ms: 14.6,
            duration_ms_per_deg: 2.28,
            peak_factor: 1.5,
            duration_sigma: 0.08,
            mode_at_zero: 0.49,
            mode_per_ms: 0.0027,
            curvature: 0.02,
            corrective_probability: 0.3,
            undershoot: 0.08,
            corrective_ms: 150.0,
            oscillation_fraction: 0.05,
            oscillation_max_deg: 0.4,
            oscillation_ms: 18.0,
        }
    }
}

impl Default for BlinkSettings {
    fn default() -> Self {
        Self { per_min: 12.0, median_ms: 280.0, dip_deg: 1.5 }
    }
}

impl Default for HeadSettings {
    fn default() -> Self {
        Self {
            follow_gain: 0.0,
            dead_zone_deg: 12.0,
            sway_deg: 0.0,
            sway_mm: 0.0,
            shake_deg: 0.0,
            shake_hz: 0.0,
            vor_gain: 1.0,
        }
    }
}

impl Default for EyesSettings {
    fn default() -> Self {
        Self { ipd_mm: 63.0, pupil_mm: 3.5, pupil_sigma_mm: 0.3 }
    }
}

impl Default for TrackerSettings {
    fn default() -> Self {
        Self {
            rate_hz: 120.0,
            accuracy_deg: vec![[0.0, 0.58], [5.0, 0.70], [10.0, 0.80], [15.0, 0.92], [20.0, 0.94]],
            noise_deg: 0.105,
            noise_growth_per_deg: 0.01,
            wander_deg: 0.1,
            pupil_based: true,
            tells_eyes: true,
            tells_head: true,
            latency_ms: 30.0,
            jitter_ms: 0.5,
            burst: 1,
            burst_probability: 0.0,
            drop_probability: 0.0,
            clock_tick_ns: 1_000_000,
            clock_offset_ns: 0,
            clock_drift_ppm: 0.0,
            clock_bits: 0,
            losses_per_min: 1.0,
            one_eye_losses_per_min: 1.0,
            loss_ms: 150.0,
        }
    }
}

impl TrackerSettings {
    /// A tracker by its name, one of [`TRACKERS`].
    ///
    /// # Errors
    /// [`Error::Setting`] for a name that is none.
    pub fn preset(name: &str) -> Result<Self> {
        match name {
            "vive-pro-eye" => Ok(Self::default()),
            "eyelink" => Ok(Self {
                rate_hz: 1000.0,
                accuracy_deg: vec![[0.0, 0.3], [20.0, 0.5]],
                noise_deg: 0.045,
                noise_growth_per_deg: 0.002,
                wander_deg: 0.02,
                tells_eyes: false,
                tells_head: false,
                latency_ms: 3.0,
                jitter_ms: 0.1,
                losses_per_min: 0.2,
                one_eye_losses_per_min: 0.0,
                ..Self::default()
            }),
            "perfect" => Ok(Self {
                rate_hz: 1000.0,
                accuracy_deg: vec![[0.0, 0.0]],
                noise_deg: 0.0,
                wander_deg: 0.0,
                pupil_based: false,
                latency_ms: 0.0,
                jitter_ms: 0.0,
                clock_tick_ns: 1,
                losses_per_min: 0.0,
                one_eye_losses_per_min: 0.0,
                ..Self::default()
            }),
            _ => Err(unknown("tracker", name, &TRACKERS)),
        }
    }
}

fn unknown(what: &str, name: &str, known: &[&str]) -> Error {
    Error::Setting(format!("there is no {what} {name}; known are {}", known.join(", ")))
}

impl SyntheticSettings {
    /// Settings by name, one of [`PRESETS`]: a person at a task, with a tracker that suits it.
    ///
    /// # Errors
    /// [`Error::Setting`] for a name that is none.
    pub fn preset(name: &str) -> Result<Self> {
        let eyelink = TrackerSettings::preset("eyelink")?;
        match name {
            "target-task" => Ok(Self::target_task(eyelink)),
            "free-viewing" => Ok(Self { tracker: eyelink, ..Self::default() }),
            "reading" => Ok(Self {
                scene: SceneSettings {
                    plan: Plan::Reading,
                    half_width_deg: 12.0,
                    half_height_deg: 8.0,
                    // Seven to nine letters at a reading distance (Rayner 1998).
                    step_deg: 2.0,
                    step_sigma: 0.35,
                    ..SceneSettings::default()
                },
                fixation: FixationSettings { median_ms: 215.0, sigma: 0.3, ..FixationSettings::default() },
                tracker: eyelink,
                ..Self::default()
            }),
            "pursuit" => Ok(Self {
                scene: SceneSettings { pursuit_probability: 0.6, ..SceneSettings::default() },
                tracker: eyelink,
                ..Self::default()
            }),
            "vr-exploration" => Ok(Self::vr_exploration()),
            _ => Err(unknown("synthetic preset", name, &PRESETS)),
        }
    }

    /// Jumping targets on a screen, the head held: times between saccades like those of the
    /// hand-labelled recordings (median 344 to 474 ms, a tenth below 115, a tenth above 1250).
    fn target_task(tracker: TrackerSettings) -> Self {
        Self {
            scene: SceneSettings { plan: Plan::Targets, half_height_deg: 12.0, ..SceneSettings::default() },
            fixation: FixationSettings {
                median_ms: 1500.0,
                sigma: 0.35,
                microsaccades_per_s: 1.15,
                drift_deg_per_root_s: 0.2,
                ..FixationSettings::default()
            },
            saccade: SaccadeSettings {
                corrective_probability: 0.7,
                corrective_ms: 140.0,
                ..SaccadeSettings::default()
            },
            blink: BlinkSettings { per_min: 15.0, median_ms: 300.0, ..BlinkSettings::default() },
            tracker,
            ..Self::default()
        }
    }

    /// Looking about in a headset: wide steps, and a head that follows them.
    fn vr_exploration() -> Self {
        Self {
            scene: SceneSettings {
                half_width_deg: 70.0,
                half_height_deg: 30.0,
                step_deg: 7.0,
                // The eyes turn less than 60 degrees in the head.
                max_amplitude_deg: 35.0,
                depth_m: 2.0,
                depth_sigma: 0.7,
                pursuit_probability: 0.06,
                ..SceneSettings::default()
            },
            head: HeadSettings {
                follow_gain: 0.9,
                // Wide enough that the eye in the head is rarely still, as in headset recordings.
                sway_deg: 9.0,
                sway_mm: 20.0,
                vor_gain: 0.98,
                ..HeadSettings::default()
            },
            ..Self::default()
        }
    }
}
