//! Which settings a sweep goes through.

use crate::failure::Failure;
use macula::knobs::{Knob, Range, Setting, Value};
use macula::settings::Method;

/// More settings than anyone waits for.
const MOST_SETTINGS: usize = 10_000;

/// A knob's values, as given.
#[derive(Clone, Debug, PartialEq)]
pub struct KnobValues {
    /// The knob's name.
    pub name: &'static str,
    /// At least one, each in the knob's range.
    pub values: Vec<Value>,
}

/// `NAME=VALUE,..` or, for numbers, `NAME=FROM:TO:STEP`.
pub fn parse_knob(text: &str) -> Result<KnobValues, String> {
    let form = "expected NAME=VALUE,.. or NAME=FROM:TO:STEP, as in sigma=1:4:0.5";
    let (name, values) = text.split_once('=').ok_or(form)?;
    let knob = Knob::named(name).map_err(|error| error.to_string())?;
    let is_number = matches!(knob.range, Range::Numbers { .. });
    let values = match values.split(':').collect::<Vec<_>>()[..] {
        [from, to, step] if is_number => steps(from, to, step)?,
        [_] => values.split(',').map(|value| knob.parse(value)).collect::<Result<_, _>>().map_err(told)?,
        _ => return Err(form.into()),
    };
    for value in &values {
        knob.check(value).map_err(told)?;
    }
    Ok(KnobValues { name: knob.name, values })
}

fn told(error: macula::Error) -> String {
    error.to_string()
}

/// From one number to another, both included where a whole number of steps leads there.
fn steps(from: &str, to: &str, step: &str) -> Result<Vec<Value>, String> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    let (Some(from), Some(to), Some(step)) = (number(from), number(to), number(step)) else {
        return Err("FROM:TO:STEP are three numbers, as in 1:4:0.5".into());
    };
    let count = ((to - from) / step + 1e-9).floor();
    if !(0.0..MOST_SETTINGS as f64).contains(&count) {
        return Err(format!("{from}:{to}:{step} makes no list; STEP must lead from FROM to TO"));
    }
    // Decimal steps are not exact in binary: 1.2 and not 1.2000000000000002.
    let tidy = |value: f64| (value * 1e9).round() / 1e9;
    Ok((0..=count as u32).map(|index| tidy(from + f64::from(index) * step).into()).collect())
}

/// Every combination of the knobs' values over `base`, each once; a knob that has no meaning in a
/// combination is left out of it.
///
/// # Errors
/// [`Failure::Usage`] for a knob given twice, one that has a meaning in no combination or not for this kind
/// of scene, and too many combinations.
pub fn settings(knobs: &[KnobValues], base: &Setting, ray_marched: bool) -> Result<Vec<Setting>, Failure> {
    check(knobs, ray_marched)?;
    let count = knobs.iter().map(|knob| knob.values.len()).try_fold(1_usize, usize::checked_mul);
    if count.is_none_or(|count| count > MOST_SETTINGS) {
        return Err(Failure::usage(format!(
            "the knobs make more than {MOST_SETTINGS} settings; give fewer values"
        )));
    }
    let mut settings = vec![Setting::default()];
    for knob in knobs {
        let with = |setting: &Setting| {
            let each = knob.values.iter().map(|value| setting.clone().with(knob.name, value.clone()));
            each.collect::<Result<Vec<_>, _>>()
        };
        settings = settings.iter().map(with).collect::<Result<Vec<_>, _>>()?.concat();
    }
    let mut each = Vec::new();
    for setting in settings {
        let meant = setting.over(base).without_the_meaningless(&Method::Full);
        if !each.contains(&meant) {
            each.push(meant);
        }
    }
    for knob in knobs {
        if each.iter().all(|setting| setting.get(knob.name).is_none()) {
            return Err(Failure::usage(format!(
                "{} has a meaning in none of the settings; add the method that it belongs to, as in --knob \
                 method=kfr,vafr",
                knob.name
            )));
        }
    }
    Ok(each)
}

fn check(knobs: &[KnobValues], ray_marched: bool) -> Result<(), Failure> {
    for (index, knob) in knobs.iter().enumerate() {
        if knobs[..index].iter().any(|before| before.name == knob.name) {
            return Err(Failure::usage(format!(
                "--knob {} was given twice; give its values once",
                knob.name
            )));
        }
        let of = Knob::named(knob.name)?.ray_marched;
        if of.is_some_and(|of| of != ray_marched) {
            let kind = if ray_marched { "the ray-marched scene" } else { "scenes of triangles" };
            return Err(Failure::usage(format!("{} has no meaning for {kind}; leave it out", knob.name)));
        }
    }
    Ok(())
}

/// What is swept where nothing is said: every method, and each knob of the two main ones through its useful
/// range. 24 settings.
pub fn usual_settings(ray_marched: bool) -> Result<Vec<Setting>, Failure> {
    let mut lines = vec![
        "method=kfr sigma=1:3.2:0.55",
        "method=kfr alpha=1,2,6",
        "method=kfr kernel=sin,exp",
        "method=kfr lp-filter=none",
        "method=kfr post-filter=on",
        "method=vafr acuity-scale=0.4,0.55,0.75,1,1.4",
        "method=vafr lp-filter=none",
    ];
    lines.push(if ray_marched { "method=vafr spp=4" } else { "method=vafr footprint=off" });
    lines.extend([
        "method=vafr-planar",
        "method=lafr",
        "method=visual-polar",
        "method=rmfr",
        "method=guenter3",
    ]);
    let mut all = Vec::new();
    for line in lines {
        let knobs = line.split(' ').map(parse_knob).collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
        all.extend(settings(&knobs, &Setting::default(), ray_marched)?);
    }
    Ok(all)
}

/// What a sweep is relative to: full shading, and each knob that is swept at its most accurate value.
pub fn reference(settings: &[Setting], base: &Setting) -> Result<Setting, Failure> {
    let mut reference = Setting::default();
    let swept = settings.iter().flat_map(Setting::iter).map(|(name, _)| name);
    for name in swept.filter(|name| base.get(name).is_none()).chain(["method"]) {
        reference = reference.with(name, Knob::named(name)?.reference)?;
    }
    Ok(reference.over(base).without_the_meaningless(&Method::Full))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knobs(texts: &[&str]) -> Vec<KnobValues> {
        texts.iter().map(|text| parse_knob(text).unwrap()).collect()
    }

    fn labels(settings: &[Setting]) -> Vec<String> {
        settings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn values_are_listed_or_stepped() {
        let values = |text: &str| parse_knob(text).unwrap().values;
        assert_eq!(values("sigma=1:2:0.2"), [1.0, 1.2, 1.4, 1.6, 1.8, 2.0].map(Value::Number));
        assert_eq!(values("sigma=1:2:0.6"), [1.0, 1.6].map(Value::Number));
        assert_eq!(values("acuity-scale=1:0.5:-0.25"), [1.0, 0.75, 0.5].map(Value::Number));
        assert_eq!(values("post-filter=on,off"), [true, false].map(Value::Switch));
        for bad in [
            "sigma",
            "sigma=",
            "sigma=1:4",
            "sigma=4:1:1",
            "sigma=1:2:0",
            "sigma=0.5",
            "speed=1",
            "method=1:2:1",
            "sigma=1:99:1",
            "sigma=nan",
        ] {
            let error = parse_knob(bad).unwrap_err();
            assert!(!error.is_empty() && !error.contains('\n'), "{bad}: {error}");
        }
    }

    #[test]
    fn combinations_drop_what_has_no_meaning() {
        let each =
            settings(&knobs(&["method=full,kfr,vafr", "sigma=1,2"]), &Setting::default(), false).unwrap();
        assert_eq!(labels(&each), ["full", "kfr, sigma 1", "kfr, sigma 2", "vafr"]);
    }

    #[test]
    fn the_base_is_kept_where_no_knob_changes_it() {
        let base = Setting::from_toml("[setting]\nmethod = \"kfr\"\nalpha = 2.0\n").unwrap();
        let each = settings(&knobs(&["sigma=1,2"]), &base, false).unwrap();
        assert_eq!(labels(&each), ["kfr, sigma 1, alpha 2", "kfr, sigma 2, alpha 2"]);
    }

    #[test]
    fn what_would_do_nothing_is_refused() {
        let refused = |texts: &[&str], ray_marched| {
            let result = settings(&knobs(texts), &Setting::default(), ray_marched);
            let Err(Failure::Usage(line)) = result else { panic!("{texts:?} was taken") };
            line
        };
        assert!(refused(&["method=vafr", "sigma=1,2"], false).contains("sigma"));
        assert!(refused(&["method=kfr", "sigma=1", "sigma=2"], false).contains("twice"));
        assert!(refused(&["spp=1,4"], false).contains("scenes of triangles"));
        assert!(refused(&["shadow-map-size=64"], true).contains("ray-marched"));
        assert!(refused(&["method=kfr", "sigma=1:64:0.01", "alpha=1:6:0.1"], false).contains("10000"));
    }

    #[test]
    fn the_usual_settings_are_24_and_all_different() {
        for ray_marched in [false, true] {
            let settings = usual_settings(ray_marched).unwrap();
            assert_eq!(settings.len(), 24);
            for (index, setting) in settings.iter().enumerate() {
                assert!(!settings[..index].contains(setting), "{setting} is there twice");
            }
        }
    }

    #[test]
    fn the_reference_has_every_swept_knob_at_its_most_accurate() {
        let base = Setting::default();
        let each = settings(&knobs(&["method=kfr,vafr", "sigma=1,2", "spp=1,4"]), &base, true).unwrap();
        assert_eq!(reference(&each, &base).unwrap().to_string(), "full, spp 16");
        let base = Setting::from_toml("[setting]\nspp = 4.0\n").unwrap();
        let each = settings(&knobs(&["method=kfr"]), &base, true).unwrap();
        assert_eq!(reference(&each, &base).unwrap().to_string(), "full, spp 4");
    }
}
