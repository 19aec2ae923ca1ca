//! An acuity model's TOML file.

use super::{AcuityModel, setting};
use crate::error::Result;
use toml::{Table, Value};

const KEYS: [&str; 6] = ["degrees", "cpd", "smooth", "scale", "delta_degrees", "delta"];

/// How much of a value an error message shows, characters.
const SHOWN_CHARS: usize = 40;

impl AcuityModel {
    /// Reads a model from TOML text:
    ///
    /// ```toml
    /// degrees = [0, 10, 20, 30, 60]       # pivots, the first at 0
    /// cpd = [40, 10, 6, 5, 4]             # acuity there
    /// smooth = true                       # no kinks at the pivots; false by default
    /// scale = 0.8                         # factor on the acuity; 1 by default
    /// delta_degrees = [0, 30]             # tangential to radial ratio; 1 everywhere by default
    /// delta = [1, 0.5]
    /// ```
    ///
    /// # Errors
    /// [`crate::Error::Setting`] with the key and its value: text that is no TOML, an unknown key, a
    /// value of the wrong kind, lists of different length, and all that [`Self::new`],
    /// [`Self::scaled`] and [`Self::with_delta`] refuse.
    pub fn from_toml(text: &str) -> Result<Self> {
        let table: Table = text.parse().map_err(|error: toml::de::Error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = 1 + before.matches('\n').count();
            setting(format!("the acuity model's line {line}: {}", error.message().replace('\n', " ")))
        })?;
        if let Some((key, value)) = table.iter().find(|(key, _)| !KEYS.contains(&key.as_str())) {
            let known = KEYS.join(", ");
            return Err(setting(format!(
                "the acuity model has an unknown key, {key} = {}; known are {known}",
                shown(value)
            )));
        }
        let Some(pivots) = pairs(&table, "degrees", "cpd")? else {
            return Err(setting("the acuity model has no degrees and no cpd; add both lists".into()));
        };
        let mut model = Self::new(&pivots)?;
        if let Some(value) = table.get("smooth") {
            let smooth = value.as_bool().ok_or_else(|| wrong("smooth", value, "true or false"))?;
            model = if smooth { model.smooth() } else { model };
        }
        if let Some(value) = table.get("scale") {
            model = model.scaled(number(value).ok_or_else(|| wrong("scale", value, "a number"))?)?;
        }
        match pairs(&table, "delta_degrees", "delta")? {
            Some(delta) => model.with_delta(&delta),
            None => Ok(model),
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(number) => Some(*number),
        // Beyond 2^53 it is out of every range, rounded or not.
        Value::Integer(number) => Some(*number as f64),
        _ => None,
    }
}

fn numbers(table: &Table, key: &str) -> Result<Option<Vec<f64>>> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let Value::Array(entries) = value else { return Err(wrong(key, value, "a list of numbers")) };
    let read = |entry| number(entry).ok_or_else(|| wrong(key, entry, "numbers only"));
    entries.iter().map(read).collect::<Result<_>>().map(Some)
}

/// Two lists of the same length, or neither.
fn pairs(table: &Table, first: &str, second: &str) -> Result<Option<Vec<(f64, f64)>>> {
    match (numbers(table, first)?, numbers(table, second)?) {
        (None, None) => Ok(None),
        (Some(left), Some(right)) if left.len() == right.len() => {
            Ok(Some(left.into_iter().zip(right).collect()))
        }
        (Some(left), Some(right)) => Err(setting(format!(
            "the acuity model has {} values in {first} and {} in {second}; both lists must be equally long",
            left.len(),
            right.len()
        ))),
        (Some(_), None) => Err(missing(first, second)),
        (None, Some(_)) => Err(missing(second, first)),
    }
}

fn missing(present: &str, absent: &str) -> crate::Error {
    setting(format!("the acuity model has {present} but no {absent}; add that list"))
}

fn wrong(key: &str, value: &Value, expected: &str) -> crate::Error {
    setting(format!("the acuity model's {key} holds {}; it takes {expected}", shown(value)))
}

/// A value on one line, cut where it is long.
fn shown(value: &Value) -> String {
    let text = value.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    if text.chars().count() <= SHOWN_CHARS {
        return text;
    }
    text.chars().take(SHOWN_CHARS).chain("...".chars()).collect()
}
