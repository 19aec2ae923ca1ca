//! What a tracker says of itself in feature reports, and what is asked of it.

use super::decode::Decoded;
use super::descriptor::{Layout, ReportKind};
use super::role::Role;
use glam::DVec2;
use serde::Serialize;

/// What it can do. The reference's sample drivers state distances ten times too small: to be shown, not
/// relied on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Capabilities {
    /// 1: fine gaze.
    pub quality: Option<i64>,
    /// Nearest distance of the eyes, m.
    pub minimum_distance_m: Option<f64>,
    /// Best distance of the eyes, m.
    pub optimum_distance_m: Option<f64>,
    /// Farthest distance of the eyes, m.
    pub maximum_distance_m: Option<f64>,
    /// Widest display, m.
    pub maximum_screen_width_m: Option<f64>,
    /// Highest display, m.
    pub maximum_screen_height_m: Option<f64>,
}

/// The display that it is calibrated to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Configuration {
    /// Manufacturer as in the display's EDID.
    pub display_manufacturer: Option<i64>,
    /// Product id as in the display's EDID.
    pub display_product: Option<i64>,
    /// Serial number as in the display's EDID.
    pub display_serial: Option<i64>,
    /// Date of manufacture as in the display's EDID.
    pub display_date: Option<i64>,
    /// Width, m.
    pub screen_width_m: Option<f64>,
    /// Height, m.
    pub screen_height_m: Option<f64>,
}

impl Configuration {
    /// Width and height of the display, m, if both are told and positive.
    #[must_use]
    pub fn screen_m(&self) -> Option<DVec2> {
        let size_m = DVec2::new(self.screen_width_m?, self.screen_height_m?);
        (size_m.min_element() > 0.0).then_some(size_m)
    }
}

/// Whether it is ready to track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ConfigurationStatus {
    /// Tracks.
    Ready,
    /// Is being set up.
    Configuring,
    /// Needs to be told the display.
    ScreenSetupNeeded,
    /// Needs its wearer's calibration.
    UserCalibrationNeeded,
    /// A code that the usage tables do not name.
    Other(i64),
}

impl ConfigurationStatus {
    fn of(code: i64) -> Self {
        match code {
            1 => Self::Ready,
            2 => Self::Configuring,
            3 => Self::ScreenSetupNeeded,
            4 => Self::UserCalibrationNeeded,
            other => Self::Other(other),
        }
    }
}

/// The state it is in. Comes as a feature report and, on change, as an input report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// Whether it is ready.
    pub configuration: Option<ConfigurationStatus>,
    /// Samples per second.
    pub sampling_hz: Option<f64>,
}

impl Decoded {
    /// What a capabilities report says.
    #[must_use]
    pub fn capabilities(&self) -> Capabilities {
        Capabilities {
            quality: self.raw(Role::TrackerQuality),
            minimum_distance_m: self.value(Role::MinimumDistance),
            optimum_distance_m: self.value(Role::OptimumDistance),
            maximum_distance_m: self.value(Role::MaximumDistance),
            maximum_screen_width_m: self.value(Role::MaximumScreenWidth),
            maximum_screen_height_m: self.value(Role::MaximumScreenHeight),
        }
    }

    /// What a configuration report says.
    #[must_use]
    pub fn configuration(&self) -> Configuration {
        Configuration {
            display_manufacturer: self.raw(Role::DisplayManufacturer),
            display_product: self.raw(Role::DisplayProduct),
            display_serial: self.raw(Role::DisplaySerial),
            display_date: self.raw(Role::DisplayDate),
            screen_width_m: self.value(Role::ScreenWidth),
            screen_height_m: self.value(Role::ScreenHeight),
        }
    }

    /// What a status report says, or `None` if this is none.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        let status = Status {
            configuration: self.raw(Role::ConfigurationStatus).map(ConfigurationStatus::of),
            sampling_hz: self.value(Role::SamplingFrequency).filter(|rate| *rate > 0.0),
        };
        (status != Status::default()).then_some(status)
    }
}

/// What a tracker is asked to send; a set of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeRequest(pub u8);

impl ModeRequest {
    /// The gaze point.
    pub const GAZE: Self = Self(1);
    /// Where the eyes are.
    pub const EYES: Self = Self(2);
    /// Where the head is.
    pub const HEAD: Self = Self(4);
    /// All of it.
    pub const ALL: Self = Self(7);

    /// Both sets.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Layout {
    /// An empty feature report that has a value, the id in front: what a transport needs to ask for it.
    #[must_use]
    pub fn feature_with(&self, role: Role) -> Option<Vec<u8>> {
        let layout = self.find(ReportKind::Feature, role)?;
        // hidraw wants a first byte in any case, 0 where there are no ids.
        let mut report = vec![0; layout.bytes + usize::from(!self.has_ids)];
        if let Some(first) = report.first_mut() {
            *first = layout.id;
        }
        Some(report)
    }

    /// The feature report that asks for a mode; `None` where the tracker cannot be asked. Everything
    /// else in the report is 0.
    #[must_use]
    pub fn mode_report(&self, mode: ModeRequest) -> Option<Vec<u8>> {
        let mut report = self.feature_with(Role::ModeRequest)?;
        let known = self.find(ReportKind::Feature, Role::ModeRequest)?.knows(Role::ModeRequest)?;
        let first_bit = known.field.first_bit + if self.has_ids { 0 } else { 8 };
        for bit in (0..known.field.width.min(8) as usize).filter(|bit| mode.0 >> bit & 1 == 1) {
            let at = first_bit + bit;
            *report.get_mut(at / 8)? |= 1 << (at % 8);
        }
        Some(report)
    }
}
