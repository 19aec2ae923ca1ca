//! Every setting that trades accuracy for time, declared once: range, most accurate value, what it affects.
//!
//! [`KNOBS`] is what sweeps, [`Setting`] files and the frame-time budget go by. The tests of this module do
//! not build while a field of [`RenderSettings`] is neither a knob's nor listed as none.

mod setting;
mod table;
#[cfg(test)]
mod tests;

pub use setting::Setting;
pub use table::KNOBS;

use crate::error::{Error, Result};
use crate::settings::{Method, RenderSettings};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The value of a knob.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// On or off.
    Switch(bool),
    /// A number.
    Number(f64),
    /// One of several names.
    Name(String),
}

impl From<bool> for Value {
    fn from(on: bool) -> Self {
        Self::Switch(on)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Value {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Switch(on) => f.write_str(if *on { "on" } else { "off" }),
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// The values that a knob takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// `on` or `off`.
    Switch,
    /// A number between two, both included.
    Numbers {
        /// The least.
        least: f64,
        /// The greatest.
        most: f64,
        /// Whole numbers only.
        whole: bool,
    },
    /// One of these.
    Names(&'static [&'static str]),
}

/// Which way a knob trades.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// Greater numbers (or `on`) are nearer to the reference and cost more.
    MoreIsMoreAccurate,
    /// Lesser numbers (or `off`) are nearer to the reference and cost more.
    LessIsMoreAccurate,
    /// Values spend the same effort in different places, or are different ways of doing something.
    None,
}

/// What must be so for a knob to have a meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// One of these methods.
    Methods(&'static [&'static str]),
    /// Any method but full shading.
    Foveation,
    /// The kernel `pow`.
    PowerKernel,
}

/// One setting that trades accuracy for time.
#[derive(Debug)]
pub struct Knob {
    /// Its name: the command line's option, and the key in a [`Setting`]'s file.
    pub name: &'static str,
    /// What it affects, in a clause.
    pub affects: &'static str,
    /// The values that it takes.
    pub range: Range,
    /// Its most accurate value; where [`Order::None`], what the published study or the engine takes.
    pub reference: Reference,
    /// Which way it trades.
    pub order: Order,
    /// When it has a meaning.
    pub needs: Needs,
    /// Applies to ray-marched scenes (`Some(true)`), to those of triangles (`Some(false)`), or to both.
    pub ray_marched: Option<bool>,
    set: fn(&mut RenderSettings, &Value) -> Result<()>,
}

/// As [`Value`], in a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// On or off.
    Switch(bool),
    /// A number.
    Number(f64),
    /// A name.
    Name(&'static str),
}

impl From<Reference> for Value {
    fn from(reference: Reference) -> Self {
        match reference {
            Reference::Switch(on) => Self::Switch(on),
            Reference::Number(number) => Self::Number(number),
            Reference::Name(name) => Self::Name(name.to_owned()),
        }
    }
}

impl Knob {
    /// The knob of that name.
    ///
    /// # Errors
    /// [`Error::Setting`], listing those that there are.
    pub fn named(name: &str) -> Result<&'static Self> {
        KNOBS.iter().find(|knob| knob.name == name).ok_or_else(|| {
            let names = KNOBS.iter().map(|knob| knob.name).collect::<Vec<_>>().join(", ");
            Error::Setting(format!("there is no knob `{name}`; there are {names}"))
        })
    }

    /// A value from text, checked.
    ///
    /// # Errors
    /// [`Error::Setting`] for what is not in the range.
    pub fn parse(&self, text: &str) -> Result<Value> {
        let value = match self.range {
            Range::Switch => match text {
                "on" => Value::Switch(true),
                "off" => Value::Switch(false),
                _ => return Err(self.refused(&text)),
            },
            Range::Numbers { .. } => match text.parse() {
                Ok(number) => Value::Number(number),
                Err(_) => return Err(self.refused(&text)),
            },
            Range::Names(_) => Value::Name(text.to_owned()),
        };
        self.check(&value)?;
        Ok(value)
    }

    /// Checks a value's kind and range.
    ///
    /// # Errors
    /// [`Error::Setting`], naming knob, value and range.
    pub fn check(&self, value: &Value) -> Result<()> {
        let fits = match (self.range, value) {
            (Range::Switch, Value::Switch(_)) => true,
            (Range::Numbers { least, most, whole }, Value::Number(number)) => {
                (least..=most).contains(number) && (!whole || number.fract() == 0.0)
            }
            (Range::Names(names), Value::Name(name)) => names.contains(&name.as_str()),
            _ => false,
        };
        if fits { Ok(()) } else { Err(self.refused(value)) }
    }

    fn refused(&self, value: &dyn fmt::Display) -> Error {
        Error::Setting(format!("{} is {value}; it must be {}", self.name, self.range))
    }

    /// Whether it changes anything with these settings.
    #[must_use]
    pub fn has_meaning(&self, settings: &RenderSettings) -> bool {
        let method = table::method_name(&settings.method);
        match self.needs {
            Needs::Nothing => true,
            Needs::Foveation => settings.foveated(),
            Needs::Methods(methods) => methods.contains(&method),
            Needs::PowerKernel => table::has_power_kernel(&settings.method),
        }
    }

    /// Sets it.
    ///
    /// # Errors
    /// [`Error::Setting`] for a value out of range, and where it has no meaning.
    pub fn set(&self, settings: &mut RenderSettings, value: &Value) -> Result<()> {
        self.check(value)?;
        if !self.has_meaning(settings) {
            let method = table::method_name(&settings.method);
            return Err(Error::Setting(format!(
                "{} has no meaning with method {method}{}; leave it out",
                self.name,
                if self.needs == Needs::PowerKernel { " and its kernel" } else { "" }
            )));
        }
        (self.set)(settings, value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Switch => f.write_str("on or off"),
            Self::Names(names) => write!(f, "one of {}", names.join(", ")),
            Self::Numbers { least, most, whole: true } => write!(f, "a whole number from {least} to {most}"),
            Self::Numbers { least, most, whole: false } => write!(f, "a number from {least} to {most}"),
        }
    }
}

/// The method with its default parameters.
///
/// # Errors
/// [`Error::Setting`] for a name that is none.
pub fn method_named(name: &str) -> Result<Method> {
    table::method_named(name)
}
