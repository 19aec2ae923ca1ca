//! No setting without a knob, and no knob without an effect.

use super::*;
use crate::fovea::{DisplayGeometry, GuenterParams, LafrParams, RmfrParams, VafrForm, VisualPolarParams};
use crate::settings::{KfrSettings, VafrSettings};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn with_method(name: &str) -> RenderSettings {
    let display = DisplayGeometry::symmetric([640, 360], 100.0);
    RenderSettings::new(display, method_named(name).unwrap())
}

const METHODS: [&str; 8] = ["full", "kfr", "vafr", "vafr-planar", "lafr", "visual-polar", "rmfr", "guenter3"];

/// The knobs of every field of the settings; empty for fields that trade nothing. Without `..`: a new field
/// does not compile until it has its place here.
fn knobs_of_fields(settings: &RenderSettings) -> Vec<(&'static str, &'static [&'static str])> {
    let RenderSettings {
        display: _,
        method,
        tone_map: _,
        view: _,
        exposure: _,
        shadowed_lights: _,
        shadow_map_size: _,
        samples_per_pixel: _,
        footprint: _,
        force_effects: _,
        check_finite: _,
    } = settings;
    let of_method: Vec<(&str, &[&str])> = match method {
        Method::Full => Vec::new(),
        Method::Kfr(KfrSettings { sigma: _, kernel: _, lp_filter: _, post_filter: _ }) => vec![
            ("sigma", &["sigma"]),
            ("kernel", &["kernel", "alpha"]),
            ("lp_filter", &["lp-filter"]),
            ("post_filter", &["post-filter"]),
        ],
        Method::Vafr(VafrSettings { form: VafrForm::Sphere | VafrForm::Planar, acuity: _, lp_filter: _ }) => {
            vec![
                ("form", &["method"]),
                ("acuity", &["acuity-scale", "acuity-delta", "smooth-acuity"]),
                ("lp_filter", &["lp-filter"]),
            ]
        }
        // The shapes of the comparators' mappings stay as published.
        Method::Lafr(LafrParams { delta: _, alpha: _, beta: _ }) => vec![("delta", &["lafr-delta"])],
        Method::VisualPolar(VisualPolarParams { columns: _ }) => vec![("columns", &["visual-polar-columns"])],
        Method::Rmfr(RmfrParams { focal_x_share: _, focal_y_share: _, delta: _ }) => {
            vec![("delta", &["rmfr-delta"])]
        }
        Method::Guenter(GuenterParams { slope_arcmin_per_deg: _, foveal_cpd: _ }) => {
            vec![("slope_arcmin_per_deg", &["guenter-slope"])]
        }
    };
    let mut fields: Vec<(&str, &[&str])> = vec![
        ("method", &["method"]),
        ("shadowed_lights", &["shadowed-lights"]),
        ("shadow_map_size", &["shadow-map-size"]),
        ("samples_per_pixel", &["spp"]),
        ("footprint", &["footprint"]),
        // What is shown and checked, and not how exactly.
        ("display, tone_map, view, exposure, force_effects, check_finite", &[]),
    ];
    fields.extend(of_method);
    fields
}

#[test]
fn every_setting_has_its_knob_and_every_knob_a_setting() {
    let mut named = BTreeSet::new();
    for method in METHODS {
        for (field, knobs) in knobs_of_fields(&with_method(method)) {
            for name in knobs {
                Knob::named(name).unwrap_or_else(|error| panic!("{field}: {error}"));
                named.insert(*name);
            }
        }
    }
    let declared: BTreeSet<_> = KNOBS.iter().map(|knob| knob.name).collect();
    assert_eq!(named, declared);
    assert_eq!(declared.len(), KNOBS.len(), "a name is there twice");
}

/// Two values of a knob that differ from each other.
fn two_values(knob: &Knob) -> [Value; 2] {
    match knob.range {
        Range::Switch => [false.into(), true.into()],
        Range::Numbers { least, most, .. } => [least.into(), most.into()],
        Range::Names(names) => [names[0].into(), names[names.len() - 1].into()],
    }
}

#[test]
fn every_knob_changes_the_settings_where_it_has_a_meaning() {
    for knob in KNOBS {
        let mut meanings = 0;
        for method in METHODS {
            let base = with_method(method);
            let set = two_values(knob).map(|value| {
                let mut settings = base.clone();
                knob.set(&mut settings, &value).map(|()| settings)
            });
            if knob.has_meaning(&base) {
                meanings += 1;
                let [first, second] = set.map(Result::unwrap);
                assert_ne!(first, second, "{} does nothing to {method}", knob.name);
                second.check().unwrap();
            } else {
                let error = set[0].as_ref().unwrap_err().to_string();
                assert!(error.contains(knob.name) && error.contains(method), "{error}");
            }
        }
        assert!(meanings > 0, "{} never has a meaning", knob.name);
        knob.check(&knob.reference.into()).unwrap();
    }
}

#[test]
fn the_most_accurate_setting_shades_every_pixel() {
    let setting = Setting::most_accurate();
    let mut settings = with_method("kfr");
    setting.apply(&mut settings).unwrap();
    assert_eq!(settings.method, Method::Full);
    assert_eq!((settings.samples_per_pixel, settings.shadow_map_size), (16, 8192));
    assert!(setting.get("sigma").is_none() && setting.get("footprint").is_none());
}

#[test]
fn settings_are_applied_in_the_tables_order() {
    let setting = Setting::default().with("sigma", 3.0).unwrap().with("alpha", 2.0).unwrap();
    let setting = setting.with("method", "kfr").unwrap();
    let mut settings = with_method("vafr");
    setting.apply(&mut settings).unwrap();
    let Method::Kfr(kfr) = settings.method else { panic!() };
    assert_eq!((kfr.sigma, kfr.kernel), (3.0, crate::fovea::Kernel::Power { alpha: 2.0 }));
    assert!(!settings.footprint, "as by default with kfr");
    assert_eq!(setting.to_string(), "kfr, sigma 3, alpha 2");
}

#[test]
fn an_acuity_model_outlives_a_change_of_form() {
    let acuity = crate::fovea::AcuityModel::new(&[(0.0, 12.0), (30.0, 3.0)]).unwrap();
    let mut settings = with_method("vafr");
    settings.method = Method::Vafr(VafrSettings { acuity: acuity.clone(), ..VafrSettings::default() });
    Setting::default().with("method", "vafr-planar").unwrap().apply(&mut settings).unwrap();
    assert!(matches!(settings.method, Method::Vafr(vafr) if vafr.acuity == acuity));
}

#[test]
fn what_has_no_meaning_is_left_out_or_refused() {
    let setting = Setting::default().with("method", "kfr").unwrap();
    let setting = setting.with("kernel", "sin").unwrap().with("alpha", 2.0).unwrap();
    let error = setting.apply(&mut with_method("full")).unwrap_err().to_string();
    assert!(error.contains("alpha") && error.contains("kernel"), "{error}");
    let kept = setting.without_the_meaningless(&Method::Full);
    assert!(kept.get("alpha").is_none() && kept.get("kernel").is_some());
}

#[test]
fn files_say_what_is_wrong_and_where() {
    for (text, told) in [
        ("", "setting"),
        ("[setting]\nsigma = \"x\"\n", "sigma is x; it must be a number from 1 to 64"),
        ("[setting]\nsigma = 0.5\n", "sigma is 0.5"),
        ("[setting]\nsigma = nan\n", "sigma is NaN"),
        ("[setting]\nspp = 1.5\n", "a whole number"),
        ("[setting]\nsigmoid = 1.0\n", "no knob `sigmoid`"),
        ("[setting]\nmethod = \"fast\"\n", "one of full, kfr"),
        ("[setting]\n\nsigma = = 2\n", "line 3"),
    ] {
        let error = Setting::from_toml(text).unwrap_err().to_string();
        assert!(error.contains(told) && !error.contains('\n'), "{text:?}: {error}");
    }
    // Integers are numbers, too.
    assert_eq!(Setting::from_toml("[setting]\nsigma = 2\n").unwrap().get("sigma"), Some(&2.0.into()));
}

#[test]
fn text_is_parsed_or_refused() {
    let knob = |name| Knob::named(name).unwrap();
    assert_eq!(knob("post-filter").parse("on").unwrap(), true.into());
    assert_eq!(knob("sigma").parse("1.5").unwrap(), 1.5.into());
    assert_eq!(knob("method").parse("vafr").unwrap(), "vafr".into());
    for (name, text) in [("post-filter", "yes"), ("sigma", "wide"), ("spp", "2.5"), ("lp-filter", "box")] {
        let error = knob(name).parse(text).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(text), "{error}");
    }
}

proptest! {
    #[test]
    fn a_file_gives_back_the_setting(sigma in 1.0..64.0_f64, spp in 1..=16_u32, post in any::<bool>()) {
        let setting = Setting::default().with("sigma", sigma)?.with("spp", f64::from(spp))?;
        let setting = setting.with("post-filter", post)?.with("lp-filter", "fxaa")?;
        prop_assert_eq!(&Setting::from_toml(&setting.to_toml())?, &setting);
        let json = serde_json::to_string(&setting).unwrap();
        prop_assert_eq!(serde_json::from_str::<Setting>(&json).unwrap(), setting);
    }
}
