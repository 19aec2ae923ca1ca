//! The report descriptor of a tracker: which value lies where in which report.

use super::guard::{Guarded, guard};
use super::role::{Kind, Role, USAGE_PAGE};
use hidparser::report_data_types::{PhysicalMaximum, PhysicalMinimum, ReportId, Unit, UnitExponent};
use hidparser::{Report, ReportField, VariableField};

/// A report descriptor that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the report descriptor, byte {at}: {what}")]
pub struct DescriptorError {
    /// The byte at which the trouble begins.
    pub at: usize,
    /// What is wrong.
    pub what: String,
}

impl DescriptorError {
    pub(super) fn at(at: usize, what: impl Into<String>) -> Self {
        Self { at, what: what.into() }
    }
}

/// What a report is for. One id may stand for one report of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportKind {
    /// Sent by the device on its own.
    Input,
    /// Read and written on demand.
    Feature,
}

/// Where a number lies in a report, and its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Usage page (upper half) and usage.
    pub usage: u32,
    /// The same of the nearest collection around it that has a usage; 0 for none.
    pub collection: u32,
    /// First bit, counted from the lowest of the report's first byte, which is the id where there are
    /// ids.
    pub first_bit: usize,
    /// Number of bits.
    pub width: u32,
    /// In two's complement.
    pub signed: bool,
    /// Smallest value that is one; anything below means that there is none.
    pub minimum: i64,
    /// Largest value that is one.
    pub maximum: i64,
}

/// A field whose meaning is known. `value = raw * scale + offset`, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub role: Role,
    pub field: Field,
    pub scale: f64,
    pub offset: f64,
}

/// One report of the device.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportLayout {
    /// What it is for.
    pub kind: ReportKind,
    /// Its id; 0 where the device has but one report of a kind and no ids.
    pub id: u8,
    /// Its length in bytes with the id, if it has one.
    pub bytes: usize,
    /// Every field of 1 to 64 bits that has a usage, also those of other pages.
    pub fields: Vec<Field>,
    pub(super) known: Vec<Known>,
}

/// All that a descriptor tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Input and feature reports.
    pub reports: Vec<ReportLayout>,
    /// Reports begin with an id.
    pub has_ids: bool,
    /// What had to be assumed or left out, a sentence each.
    pub notes: Vec<String>,
}

impl Layout {
    /// Reads a report descriptor.
    ///
    /// # Errors
    /// Where it is broken, asks for more than the stated limits, or has no input report with gaze, eyes
    /// or head of usage page 0x12.
    pub fn parse(descriptor: &[u8]) -> Result<Self, DescriptorError> {
        let guarded = guard(descriptor)?;
        let parsed = hidparser::parse_report_descriptor(&guarded.bytes)
            .map_err(|error| DescriptorError::at(0, format!("cannot be parsed: {error:?}")))?;
        let inputs = parsed.input_reports.iter().map(|report| (ReportKind::Input, report));
        let features = parsed.features.iter().map(|report| (ReportKind::Feature, report));
        let all = || inputs.clone().chain(features.clone());
        let has_ids = all().any(|(_, report)| report.report_id.is_some());
        let mut layout = Self { reports: Vec::new(), has_ids, notes: Vec::new() };
        for (kind, broken) in
            [(ReportKind::Input, &parsed.bad_input_reports), (ReportKind::Feature, &parsed.bad_features)]
        {
            for (id, error) in broken {
                let id = id.map_or(0, u32::from);
                layout.notes.push(format!("{kind:?} report {id:#04x} is left out: {error:?}"));
            }
        }
        for (kind, report) in all() {
            let broken = match kind {
                ReportKind::Input => &parsed.bad_input_reports,
                ReportKind::Feature => &parsed.bad_features,
            };
            if !broken.iter().any(|(id, _)| *id == report.report_id) {
                layout.add(kind, report, &guarded);
            }
        }
        layout.notes.dedup();
        let mut inputs = layout.reports.iter().filter(|report| report.kind == ReportKind::Input);
        if inputs.any(|report| report.known.iter().any(|known| known.role.is_tracking())) {
            return Ok(layout);
        }
        let notes = layout.notes.join("; ");
        let what = "no input report tells gaze, eyes or head of usage page 0x12; this is no eye tracker";
        Err(DescriptorError::at(descriptor.len(), format!("{what}. {notes}").trim_end_matches(". ")))
    }

    /// Whether an input report has this value.
    #[must_use]
    pub fn has(&self, role: Role) -> bool {
        self.find(ReportKind::Input, role).is_some()
    }

    /// The first report of a kind that has a value.
    #[must_use]
    pub fn find(&self, kind: ReportKind, role: Role) -> Option<&ReportLayout> {
        self.reports.iter().find(|report| report.kind == kind && report.knows(role).is_some())
    }

    /// Bits of the timestamp and its tick in ns.
    #[must_use]
    pub fn timestamp(&self) -> Option<(u32, f64)> {
        let report = self.find(ReportKind::Input, Role::Timestamp)?;
        report.knows(Role::Timestamp).map(|known| (known.field.width, known.scale * 1e9))
    }

    fn add(&mut self, kind: ReportKind, report: &Report, guarded: &Guarded) {
        let id = report.report_id.map_or(0, id_of);
        if self.has_ids && report.report_id.is_none() {
            self.notes.push(format!("{kind:?} fields without a report id are left out"));
            return;
        }
        let id_bits = if self.has_ids { 8 } else { 0 };
        let bytes = (report.size_in_bits + id_bits).div_ceil(8);
        let mut layout = ReportLayout { kind, id, bytes, fields: Vec::new(), known: Vec::new() };
        for field in &report.fields {
            let ReportField::Variable(variable) = field else { continue };
            let first_bit = variable.bits.start as usize + id_bits;
            let Some(field) = field_of(variable, first_bit) else { continue };
            layout.fields.push(field);
            let Some(role) = role_of(variable) else { continue };
            let note = layout.learn(role, field, variable, guarded);
            self.notes.extend(note);
        }
        self.reports.push(layout);
    }
}

impl ReportLayout {
    pub(super) fn knows(&self, role: Role) -> Option<&Known> {
        self.known.iter().find(|known| known.role == role)
    }

    /// Adds a field whose meaning is known. Returns what had to be assumed.
    fn learn(
        &mut self,
        role: Role,
        field: Field,
        variable: &VariableField,
        guarded: &Guarded,
    ) -> Option<String> {
        if let Some(before) = self.known.iter_mut().find(|known| known.role == role) {
            let end = before.field.first_bit + before.field.width as usize;
            let width = before.field.width + field.width;
            // A clock of 64 bits is declared as eight bytes, since ranges have 32 bits at most.
            if role == Role::Timestamp && end == field.first_bit && width <= 64 {
                before.field.width = width;
                before.field.minimum = 0;
                before.field.maximum = i64::MAX;
            }
            return None;
        }
        let unit = unit_scale(role.kind(), variable);
        let note = match role.kind() {
            Kind::Plain | Kind::Frequency => None,
            _ if unit.is_some() => None,
            Kind::Time => Some("the timestamp has no unit of time; microseconds are assumed".to_owned()),
            Kind::Length => Some(format!("{role:?} has no unit of length; micrometres are assumed")),
            Kind::Angle => Some(format!("{role:?} has no unit of angle; it is kept as a number only")),
        };
        let unit = unit.unwrap_or(match role.kind() {
            Kind::Time | Kind::Length => 1e-6,
            Kind::Angle => f64::NAN,
            Kind::Frequency | Kind::Plain => 1.0,
        });
        // A clock counts ticks from 0 whatever range its bytes are given.
        let (field, (scale, offset)) = match role.kind() {
            Kind::Time => (Field { signed: false, ..field }, (1.0, 0.0)),
            _ => (field, physical(&field, variable, guarded)),
        };
        self.known.push(Known { role, field, scale: scale * unit, offset: offset * unit });
        note
    }
}

/// Ids are within 1..=255 once guarded.
fn id_of(id: ReportId) -> u8 {
    u32::from(id) as u8
}

fn field_of(variable: &VariableField, first_bit: usize) -> Option<Field> {
    let width =
        variable.bits.end.checked_sub(variable.bits.start).filter(|width| (1..=64).contains(width))?;
    let minimum = i64::from(i32::from(variable.logical_minimum));
    let signed = minimum < 0;
    // A range that begins at or above 0 is unsigned, so 0xffffffff is its end and not -1.
    let maximum = if signed {
        i64::from(i32::from(variable.logical_maximum))
    } else {
        i64::from(u32::from(variable.logical_maximum))
    };
    let named = |collection: &&hidparser::ReportCollection| collection.usage.id() != 0;
    let collection = variable.member_of.iter().rev().find(named);
    Some(Field {
        usage: variable.usage.into(),
        collection: collection.map_or(0, |collection| collection.usage.into()),
        first_bit,
        width,
        signed,
        minimum,
        maximum,
    })
}

fn role_of(variable: &VariableField) -> Option<Role> {
    if variable.usage.page() != USAGE_PAGE {
        return None;
    }
    let mut around = variable.member_of.iter().rev().map(|collection| collection.usage);
    let collection = around.find(|usage| usage.page() == USAGE_PAGE && usage.id() != 0)?;
    Role::of(collection.id(), variable.usage.id())
}

/// How many SI units the field's unit is; `None` where it is not of this kind.
///
/// The unit's nibbles are powers of, from the lowest: system, length, mass, time (HID 1.11, 6.2.2.7).
fn unit_scale(kind: Kind, variable: &VariableField) -> Option<f64> {
    // Unit, factor, power of ten.
    let table: &[(u32, f64, i32)] = match kind {
        Kind::Length => &[(0x11, 1.0, -2), (0x13, 2.54, -2)],
        Kind::Angle => &[(0x12, 1.0, 0), (0x14, std::f64::consts::PI / 180.0, 0)],
        Kind::Time => &[(0x1001, 1.0, 0), (0x1003, 1.0, 0)],
        Kind::Frequency => &[(0xf001, 1.0, 0), (0xf003, 1.0, 0)],
        Kind::Plain => &[],
    };
    let unit = variable.unit?;
    let (_, factor, power) = table.iter().find(|(code, ..)| unit == Unit::from(*code))?;
    let power = power + exponent(variable.unit_exponent);
    // Powers of ten are exact, their inverses are rounded once.
    let ten = 10f64.powi(power.abs());
    Some(if power < 0 { factor / ten } else { factor * ten })
}

/// The exponent is a signed nibble. What does not fit into one is a signed number, as the Linux kernel
/// takes it too: there is no other way to say 10^-9.
fn exponent(told: Option<UnitExponent>) -> i32 {
    let is = |code: i32| {
        told == Some(UnitExponent::from(code as u32)) || told == Some(UnitExponent::from(code as u8 as u32))
    };
    match (-128..128).find(|code| is(*code)) {
        Some(nibble @ 8..16) => nibble - 16,
        Some(number) => number,
        None => 0,
    }
}

/// Scale and offset from raw to physical values. Where no physical range is given, or both of its ends
/// are 0, it is the logical range (HID 1.11, 6.2.2.7).
fn physical(field: &Field, variable: &VariableField, guarded: &Guarded) -> (f64, f64) {
    let minimum = variable
        .physical_minimum
        .and_then(|told| guarded.physical.iter().find(|value| told == PhysicalMinimum::from(**value)));
    let maximum = variable
        .physical_maximum
        .and_then(|told| guarded.physical.iter().find(|value| told == PhysicalMaximum::from(**value)));
    let (Some(&minimum), Some(&maximum)) = (minimum, maximum) else { return (1.0, 0.0) };
    if minimum >= maximum {
        return (1.0, 0.0);
    }
    let (low, high) = (f64::from(minimum), f64::from(maximum));
    let scale = (high - low) / (field.maximum - field.minimum) as f64;
    (scale, low - field.minimum as f64 * scale)
}
