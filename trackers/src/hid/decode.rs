//! From the bytes of a report to numbers, and from these to a sample.

use super::bytes::Bytes;
use super::descriptor::{Field, Known, Layout, ReportKind, ReportLayout};
use super::role::{COUNT, Kind, Role};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::{DQuat, DVec2, DVec3, EulerRot};

/// Why a report is no report of this device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reject {
    /// It has no bytes.
    #[error("the report is empty")]
    Empty,
    /// The descriptor knows no such report.
    #[error("report id {0:#04x} is not in the report descriptor")]
    UnknownId(u8),
    /// It is cut short, or longer than it may be.
    #[error("the report has {got} bytes, not {expected}")]
    Length {
        /// What came.
        got: usize,
        /// What the descriptor or layout says.
        expected: usize,
    },
    /// It contradicts itself.
    #[error("the report's checksum is wrong")]
    Checksum,
}

/// One field of a report as a number, whatever its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawField {
    /// Where it lies, and what it is called.
    pub field: Field,
    /// The number; the bits of a field of 64 bits without sign are those of the `i64`.
    pub value: i64,
}

/// The values of one report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decoded {
    /// The report's id, 0 where there are none.
    pub id: u8,
    present: u64,
    raw: [i64; COUNT],
    /// SI units; NaN where absent.
    value: [f64; COUNT],
    time_ns: Option<i64>,
}

impl Layout {
    /// Takes an input report apart. Allocates nothing.
    ///
    /// # Errors
    /// [`Reject`] where it is none of the descriptor's.
    pub fn decode(&self, report: &[u8]) -> Result<Decoded, Reject> {
        self.decode_kind(ReportKind::Input, report)
    }

    /// As [`Self::decode`], of a feature report, the id in front where there are ids.
    ///
    /// # Errors
    /// [`Reject`] where it is none of the descriptor's.
    pub fn decode_feature(&self, report: &[u8]) -> Result<Decoded, Reject> {
        self.decode_kind(ReportKind::Feature, report)
    }

    fn decode_kind(&self, kind: ReportKind, report: &[u8]) -> Result<Decoded, Reject> {
        let layout = self.report_of(kind, report)?;
        let bytes = Bytes(report);
        let mut decoded =
            Decoded { id: layout.id, present: 0, raw: [0; COUNT], value: [f64::NAN; COUNT], time_ns: None };
        for known in &layout.known {
            // The length has been checked, so every field lies within.
            let Some(raw) = raw_value(bytes, &known.field) else { continue };
            decoded.set(known, raw);
        }
        Ok(decoded)
    }

    /// Every field of an input report, also those of other usage pages, so that nothing is lost.
    ///
    /// # Errors
    /// [`Reject`] where it is none of the descriptor's.
    pub fn raw_fields<'a>(
        &'a self,
        report: &'a [u8],
    ) -> Result<impl Iterator<Item = RawField> + use<'a>, Reject> {
        let layout = self.report_of(ReportKind::Input, report)?;
        let bytes = Bytes(report);
        let fields = layout.fields.iter();
        Ok(fields.filter_map(move |&field| Some(RawField { field, value: raw_value(bytes, &field)? })))
    }

    fn report_of(&self, kind: ReportKind, report: &[u8]) -> Result<&ReportLayout, Reject> {
        let first = *report.first().ok_or(Reject::Empty)?;
        let id = if self.has_ids { first } else { 0 };
        let mut reports = self.reports.iter();
        let layout = reports.find(|layout| layout.kind == kind && layout.id == id);
        let layout = layout.ok_or(Reject::UnknownId(id))?;
        if report.len() != layout.bytes {
            return Err(Reject::Length { got: report.len(), expected: layout.bytes });
        }
        Ok(layout)
    }
}

fn raw_value(bytes: Bytes<'_>, field: &Field) -> Option<i64> {
    if field.signed {
        bytes.signed_bits(field.first_bit, field.width)
    } else {
        bytes.bits(field.first_bit, field.width).map(|value| value as i64)
    }
}

impl Decoded {
    fn set(&mut self, known: &Known, raw: i64) {
        let index = known.role.index();
        self.present |= 1 << index;
        let kind = known.role.kind();
        let scaled = raw as f64 * known.scale + known.offset;
        let (Some(slot), Some(value)) = (self.raw.get_mut(index), self.value.get_mut(index)) else { return };
        *slot = raw;
        match kind {
            Kind::Time => {
                self.time_ns = tick_ns(raw as u64, known.scale * 1e9);
                *value = raw as u64 as f64 * known.scale;
            }
            // These are what a person declared them to be: a range that is too narrow hides nothing.
            Kind::Plain | Kind::Frequency => *value = scaled,
            Kind::Length | Kind::Angle => {
                let within = (known.field.minimum..=known.field.maximum).contains(&raw);
                // The largest number stands for "none" also where the declared range allows it.
                if within && raw != i64::from(i32::MAX) {
                    *value = scaled;
                }
            }
        }
    }

    /// The number in the report, also where it is outside of its range; `None` where the report has no
    /// such field. Of a timestamp of 64 bits the bits are those of the `i64`.
    #[must_use]
    pub fn raw(&self, role: Role) -> Option<i64> {
        let told = self.present >> role.index() & 1 == 1;
        self.raw.get(role.index()).copied().filter(|_| told)
    }

    /// The value in SI units (m, s, rad, Hz); `None` where the report has none or says that there is
    /// none: by a number outside of its range, or by the largest of 32 bits.
    #[must_use]
    pub fn value(&self, role: Role) -> Option<f64> {
        self.value.get(role.index()).copied().filter(|value| !value.is_nan())
    }

    /// The tracker's time in ns, not unwrapped. `None` without a timestamp, or one that `i64` ns cannot
    /// hold.
    #[must_use]
    pub fn device_time_ns(&self) -> Option<i64> {
        self.time_ns
    }

    /// Whether the report tells of the eyes or the head at all, seen or not.
    #[must_use]
    pub fn is_tracking(&self) -> bool {
        Role::ALL.iter().any(|role| role.is_tracking() && self.raw(*role).is_some())
    }

    fn vector(&self, [x, y, z]: [Role; 3]) -> Option<DVec3> {
        Some(DVec3::new(self.value(x)?, self.value(y)?, self.value(z)?))
    }

    /// The gaze point in metres from the display's top left corner, x right, y down.
    #[must_use]
    pub fn gaze_m(&self) -> Option<DVec2> {
        Some(DVec2::new(self.value(Role::GazeX)?, self.value(Role::GazeY)?))
    }

    /// The left eye in the display frame (see [`Self::to_sample`]).
    #[must_use]
    pub fn left_eye_m(&self) -> Option<DVec3> {
        self.vector([Role::LeftX, Role::LeftY, Role::LeftZ]).and_then(eye_in_display_frame)
    }

    /// The right eye in the display frame.
    #[must_use]
    pub fn right_eye_m(&self) -> Option<DVec3> {
        self.vector([Role::RightX, Role::RightY, Role::RightZ]).and_then(eye_in_display_frame)
    }

    /// The head in the display frame.
    #[must_use]
    pub fn head_m(&self) -> Option<DVec3> {
        self.vector([Role::HeadX, Role::HeadY, Role::HeadZ]).map(flip_y)
    }

    /// The sample that the report tells.
    ///
    /// Positions are in the display frame: metres from the display's top left corner, x right, y up, z
    /// out of the display towards the wearer, so that its axes are those of the view space of a head that
    /// faces the display. (Reports count y downwards, which is turned here.) The display is the plane
    /// z = 0, so the gaze direction is the gaze point less the eye; of both eyes together it starts half
    /// way between them, or at the only one that is seen. An eye at or behind the plane is none: drivers
    /// send zeros where they know nothing.
    ///
    /// `screen_m` is the display's width and height, from [`super::Configuration`]; without it the gaze
    /// is told as a direction only. The head's rotation is taken as turning about these axes by the right
    /// hand, about y first, then x, then z; the usage tables say neither sense nor order. `time_ns` is
    /// `received_ns` until a clock mapping sets it.
    #[must_use]
    pub fn to_sample(&self, screen_m: Option<DVec2>, received_ns: i64) -> GazeSample {
        let gaze_m = self.gaze_m();
        let point =
            gaze_m.zip(screen_m).map(|(gaze, screen)| gaze / screen).filter(|point| point.is_finite());
        let eye = |origin_m: Option<DVec3>, point: Option<DVec2>| {
            let on_display = gaze_m.map(|gaze| flip_y(gaze.extend(0.0)));
            let direction =
                on_display.zip(origin_m).and_then(|(gaze, origin)| (gaze - origin).try_normalize());
            let valid = point.is_some() || direction.is_some();
            EyeSample { valid, origin_m, direction, point, ..EyeSample::default() }
        };
        let (left_m, right_m) = (self.left_eye_m(), self.right_eye_m());
        let between_m = match (left_m, right_m) {
            (Some(left), Some(right)) => Some((left + right) * 0.5),
            (only, None) | (None, only) => only,
        };
        GazeSample {
            device_time_ns: self.time_ns,
            received_ns,
            time_ns: received_ns,
            combined: eye(between_m, point),
            left: eye(left_m, None),
            right: eye(right_m, None),
            head: self.head(),
        }
    }

    fn head(&self) -> Option<HeadPose> {
        let turn = self.vector([Role::HeadRotationX, Role::HeadRotationY, Role::HeadRotationZ])?;
        let world_from_view = DQuat::from_euler(EulerRot::YXZ, turn.y, turn.x, turn.z);
        Some(HeadPose { position_m: self.head_m()?, world_from_view })
    }
}

fn flip_y(point: DVec3) -> DVec3 {
    DVec3::new(point.x, -point.y, point.z)
}

fn eye_in_display_frame(told: DVec3) -> Option<DVec3> {
    (told.z > 0.0).then(|| flip_y(told))
}

/// Ticks as ns: exact where a tick is a whole number of ns or a ns a whole number of ticks.
fn tick_ns(ticks: u64, ns_per_tick: f64) -> Option<i64> {
    let ns = if ns_per_tick >= 1.0 && (ns_per_tick - ns_per_tick.round()).abs() < 1e-6 * ns_per_tick {
        i128::from(ticks).checked_mul(ns_per_tick.round() as i128)?
    } else {
        let ns = ticks as f64 * ns_per_tick;
        if !ns.is_finite() {
            return None;
        }
        ns.round() as i128
    };
    i64::try_from(ns).ok()
}
