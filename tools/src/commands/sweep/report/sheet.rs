//! Records as the report's sections take them: one sheet for each size, one row for each setting.

use crate::commands::sweep::record::{Figures, Manifest, Outcome, Record};
use crate::measure::median;
use macula::knobs::{KNOBS, Range, Setting, Value};
use macula::settings::Method;

/// All settings at one size.
pub struct Sheet<'a> {
    /// Its place: of the size in [`Manifest::sizes`], or after those.
    pub at: usize,
    /// Display size, px.
    pub size: [u32; 2],
    /// In the order of the settings.
    pub rows: Vec<Row<'a>>,
    /// Knobs that do not have the same value in all settings.
    pub differing: Vec<&'static str>,
}

/// One setting at one size.
pub struct Row<'a> {
    /// What was written down.
    pub record: &'a Record,
    /// Unique on the page.
    pub key: String,
    /// The method and what the setting sets by itself, without what is so in all settings.
    pub label: String,
    /// With what it takes from the base, without knobs that have no meaning with its method.
    pub setting: Setting,
    /// Place of the method in its knob's list, for its colour and shape.
    pub method: usize,
}

impl<'a> Row<'a> {
    /// `None` for a failed setting.
    pub fn figures(&self) -> Option<&'a Figures> {
        match &self.record.outcome {
            Outcome::Failed(_) => None,
            Outcome::Measured(figures) => Some(figures),
        }
    }

    /// Why it failed.
    pub fn failure(&self) -> Option<&'a str> {
        match &self.record.outcome {
            Outcome::Failed(why) => Some(why),
            Outcome::Measured(_) => None,
        }
    }
}

impl<'a> Sheet<'a> {
    /// Rows with figures.
    pub fn measured(&self) -> impl Iterator<Item = (&Row<'a>, &'a Figures)> {
        self.rows.iter().filter_map(|row| Some((row, row.figures()?)))
    }

    /// The reference's time, milliseconds: the median over the settings that it was measured beside.
    pub fn reference_ms(&self) -> Option<f64> {
        let times = self.measured().map(|(_, figures)| figures.times.reference_ms.median);
        median(&times.filter(|ms| ms.is_finite()).collect::<Vec<_>>())
    }

    /// `1280×720`.
    pub fn size_text(&self) -> String {
        size_text(self.size)
    }
}

/// `1280×720`.
pub fn size_text([width, height]: [u32; 2]) -> String {
    format!("{width}×{height}")
}

/// One for each size, also for a size that only records name.
pub fn sheets<'a>(manifest: &Manifest, records: &'a [Record]) -> Vec<Sheet<'a>> {
    let whole = |record: &Record| whole(record.setting.over(&manifest.base));
    let settings: Vec<Setting> = records.iter().map(whole).collect();
    let differing = differing(&settings);
    let mut sizes = manifest.sizes.clone();
    for record in records {
        if !sizes.contains(&record.size) {
            sizes.push(record.size);
        }
    }
    let sheet = |(at, size): (usize, [u32; 2])| {
        let mut own: Vec<_> =
            records.iter().zip(&settings).filter(|(record, _)| record.size == size).collect();
        own.sort_by_key(|(record, _)| record.index);
        let row = |(place, (record, setting)): (usize, (&'a Record, &Setting))| Row {
            record,
            key: format!("s{at}-{place}"),
            label: label(record, setting, &differing),
            setting: setting.clone(),
            method: method_place(setting),
        };
        let rows = own.into_iter().enumerate().map(row).collect();
        Sheet { at, size, rows, differing: differing.clone() }
    };
    sizes.into_iter().enumerate().map(sheet).collect()
}

/// Without what has no meaning, where the setting says with which method.
fn whole(setting: Setting) -> Setting {
    if setting.get("method").is_some() { setting.without_the_meaningless(&Method::Full) } else { setting }
}

/// Knobs that do not have the same value everywhere.
fn differing(settings: &[Setting]) -> Vec<&'static str> {
    let names = KNOBS.iter().map(|knob| knob.name);
    names.filter(|name| settings.windows(2).any(|pair| pair[0].get(name) != pair[1].get(name))).collect()
}

/// The method, and those of `differing` that the record's own setting names.
fn label(record: &Record, setting: &Setting, differing: &[&str]) -> String {
    let own = |name: &str| differing.contains(&name) && record.setting.get(name).is_some();
    let words = words(setting, |name| name == "method" || own(name));
    if words.is_empty() { setting.to_string() } else { words }
}

/// The values of some knobs; the method without its knob's name.
pub fn words(setting: &Setting, told: impl Fn(&str) -> bool) -> String {
    let told = setting.iter().filter(|(name, _)| told(name));
    let words = told.map(|(name, value)| match value {
        value if name == "method" => value.to_string(),
        value => format!("{name} {value}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

/// The names of all methods.
pub fn method_names() -> &'static [&'static str] {
    let range = KNOBS.iter().find(|knob| knob.name == "method").map(|knob| knob.range);
    if let Some(Range::Names(names)) = range { names } else { &[] }
}

fn method_place(setting: &Setting) -> usize {
    let Some(Value::Name(method)) = setting.get("method") else { return method_names().len() };
    method_names().iter().position(|name| name == method).unwrap_or(method_names().len())
}
