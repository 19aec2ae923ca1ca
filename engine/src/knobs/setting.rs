//! A choice of knobs' values, by name; as a file it is a TOML table.

use super::{KNOBS, Knob, Value};
use crate::error::{Error, Result};
use crate::settings::{Method, RenderSettings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Values of knobs; what is not named stays as it is.
///
/// The file holds one table, `[setting]`, with a key for each knob:
///
/// ```
/// use macula::fovea::DisplayGeometry;
/// use macula::knobs::Setting;
/// use macula::settings::{Method, RenderSettings};
///
/// let setting = Setting::from_toml("[setting]\nmethod = \"kfr\"\nsigma = 2.4\n")?;
/// let mut settings = RenderSettings::new(DisplayGeometry::symmetric([1280, 720], 100.0), Method::Full);
/// setting.apply(&mut settings)?;
/// assert!(matches!(settings.method, Method::Kfr(kfr) if kfr.sigma == 2.4));
/// # Ok::<(), macula::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Setting(BTreeMap<String, Value>);

/// The file.
#[derive(Serialize, Deserialize)]
struct File {
    setting: Setting,
}

impl Setting {
    /// Every knob at its most accurate value, as far as it has a meaning with full shading.
    #[must_use]
    pub fn most_accurate() -> Self {
        let mut setting = Self::default();
        for knob in KNOBS {
            setting.0.insert(knob.name.to_owned(), knob.reference.into());
        }
        setting.without_the_meaningless(&Method::Full)
    }

    /// With one more value, or another value.
    ///
    /// # Errors
    /// [`Error::Setting`] for a name that is no knob's and for a value out of range.
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Result<Self> {
        let value = value.into();
        Knob::named(name)?.check(&value)?;
        self.0.insert(name.to_owned(), value);
        Ok(self)
    }

    /// A knob's value, where it is named.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// Names and values, in the table's order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        KNOBS.iter().filter_map(|knob| Some((knob.name, self.0.get(knob.name)?)))
    }

    /// No knob is named.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// This setting's values over those of `base`.
    #[must_use]
    pub fn over(&self, base: &Self) -> Self {
        let mut values = base.0.clone();
        values.extend(self.0.clone());
        Self(values)
    }

    /// Without knobs that have no meaning with the setting's method and kernel; `method` is the one of a
    /// setting that names none.
    #[must_use]
    pub fn without_the_meaningless(mut self, method: &Method) -> Self {
        let display = crate::fovea::DisplayGeometry::symmetric([64, 64], 90.0);
        let mut settings = RenderSettings::new(display, method.clone());
        // The table's order: a knob's meaning depends on those before it only.
        for knob in KNOBS {
            let Some(value) = self.0.get(knob.name) else { continue };
            if knob.set(&mut settings, value).is_err() {
                self.0.remove(knob.name);
            }
        }
        self
    }

    /// Sets the knobs that are named. The acuity's factor and ratio apply to the acuity model that is there:
    /// apply a setting once.
    ///
    /// # Errors
    /// [`Error::Setting`] for a name that is no knob's, a value out of range, and a knob that has no
    /// meaning with the method.
    pub fn apply(&self, settings: &mut RenderSettings) -> Result<()> {
        for name in self.0.keys() {
            Knob::named(name)?;
        }
        for (name, value) in self.iter() {
            Knob::named(name)?.set(settings, value)?;
        }
        settings.check()
    }

    /// From a file's text.
    ///
    /// # Errors
    /// [`Error::Setting`] for what is no such file, and as [`Self::apply`] for unknown knobs and values out
    /// of range.
    pub fn from_toml(text: &str) -> Result<Self> {
        let told = |error: toml::de::Error| {
            let line = error.span().map_or(1, |span| text[..span.start].lines().count().max(1));
            Error::Setting(format!("line {line}: {}", error.message().replace('\n', " ")))
        };
        let file: File = toml::from_str(text).map_err(told)?;
        let mut setting = Self::default();
        for (name, value) in file.setting.0 {
            setting = setting.with(&name, value)?;
        }
        Ok(setting)
    }

    /// As a file's text, without comments.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = "[setting]\n".to_owned();
        for (name, value) in self.iter() {
            let value = match value {
                Value::Switch(on) => on.to_string(),
                // With its point or exponent: TOML tells floats from integers.
                Value::Number(number) => format!("{number:?}"),
                Value::Name(name) => format!("{name:?}"),
            };
            text += &format!("{name} = {value}\n");
        }
        text
    }
}

/// `method kfr, sigma 1.8`; the method without its knob's name.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut words = Vec::new();
        for (name, value) in self.iter() {
            words.push(if name == "method" { value.to_string() } else { format!("{name} {value}") });
        }
        f.write_str(&if words.is_empty() { "as by default".to_owned() } else { words.join(", ") })
    }
}
