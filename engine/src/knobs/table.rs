//! The table of knobs.

use super::{Knob, Needs, Order, Range, Reference, Value};
use crate::error::{Error, Result};
use crate::fovea::{GuenterParams, Kernel, LafrParams, RmfrParams, VafrForm, VisualPolarParams};
use crate::settings::{KfrSettings, LpFilter, Method, RenderSettings, VafrSettings};

const METHODS: &[&str] = &["full", "kfr", "vafr", "vafr-planar", "lafr", "visual-polar", "rmfr", "guenter3"];
const KERNELS: &[&str] = &["pow", "sin", "exp"];
const LP_FILTERS: &[&str] = &["none", "gaussian", "fxaa"];
const OF_KFR: Needs = Needs::Methods(&["kfr"]);
const OF_VAFR: Needs = Needs::Methods(&["vafr", "vafr-planar"]);

/// All knobs. One that decides whether another has a meaning comes before it.
pub static KNOBS: &[Knob] = &[
    Knob {
        name: "method",
        affects: "where samples are shaded",
        range: Range::Names(METHODS),
        reference: Reference::Name("full"),
        order: Order::None,
        needs: Needs::Nothing,
        ray_marched: None,
        set: set_method,
    },
    Knob {
        name: "sigma",
        affects: "size of the LP-buffer: samples fall with its square",
        range: numbers(1.0, 64.0),
        reference: Reference::Number(1.0),
        order: Order::LessIsMoreAccurate,
        needs: OF_KFR,
        ray_marched: None,
        set: |settings, value| with_kfr(settings, |kfr| kfr.sigma = number(value)),
    },
    Knob {
        name: "kernel",
        affects: "how the LP-buffer's columns are spread over the radius",
        range: Range::Names(KERNELS),
        reference: Reference::Name("pow"),
        order: Order::None,
        needs: OF_KFR,
        ray_marched: None,
        set: set_kernel,
    },
    Knob {
        name: "alpha",
        affects: "samples at the edge (greater) against samples near the gaze (less)",
        range: numbers(1.0, 6.0),
        reference: Reference::Number(4.0),
        order: Order::None,
        needs: Needs::PowerKernel,
        ray_marched: None,
        set: |settings, value| with_kfr(settings, |kfr| kfr.kernel = Kernel::Power { alpha: number(value) }),
    },
    Knob {
        name: "acuity-scale",
        affects: "factor on the acuity that samples follow: samples grow with its square",
        range: numbers(0.05, 20.0),
        reference: Reference::Number(20.0),
        order: Order::MoreIsMoreAccurate,
        needs: OF_VAFR,
        ray_marched: None,
        set: |settings, value| {
            with_vafr(settings, |vafr| {
                vafr.acuity = vafr.acuity.clone().scaled(number(value))?;
                Ok(())
            })
        },
    },
    Knob {
        name: "acuity-delta",
        affects: "samples around the gaze over samples away from it",
        range: numbers(0.05, 20.0),
        reference: Reference::Number(20.0),
        order: Order::MoreIsMoreAccurate,
        needs: OF_VAFR,
        ray_marched: None,
        set: |settings, value| {
            with_vafr(settings, |vafr| {
                vafr.acuity = vafr.acuity.clone().with_delta(&[(0.0, number(value))])?;
                Ok(())
            })
        },
    },
    Knob {
        name: "smooth-acuity",
        affects: "samples where the acuity model has kinks",
        range: Range::Switch,
        reference: Reference::Switch(false),
        order: Order::None,
        needs: OF_VAFR,
        ray_marched: None,
        set: |settings, value| {
            with_vafr(settings, |vafr| {
                if is_on(value) {
                    vafr.acuity = vafr.acuity.clone().smooth();
                }
                Ok(())
            })
        },
    },
    Knob {
        name: "lafr-delta",
        affects: "size of LaFR's LP-buffer: samples fall with its square",
        range: numbers(1.0, 64.0),
        reference: Reference::Number(1.0),
        order: Order::LessIsMoreAccurate,
        needs: Needs::Methods(&["lafr"]),
        ray_marched: None,
        set: |settings, value| {
            if let Method::Lafr(params) = &mut settings.method {
                params.delta = number(value);
            }
            Ok(())
        },
    },
    Knob {
        name: "visual-polar-columns",
        affects: "width of Visual-Polar's LP-buffer: samples grow with its square",
        range: Range::Numbers { least: 16.0, most: 8192.0, whole: true },
        reference: Reference::Number(8192.0),
        order: Order::MoreIsMoreAccurate,
        needs: Needs::Methods(&["visual-polar"]),
        ray_marched: None,
        set: |settings, value| {
            if let Method::VisualPolar(params) = &mut settings.method {
                params.columns = number(value) as u32;
            }
            Ok(())
        },
    },
    Knob {
        name: "rmfr-delta",
        affects: "size of RMFR's buffer: samples fall with its square",
        range: numbers(1.0, 64.0),
        reference: Reference::Number(1.0),
        order: Order::LessIsMoreAccurate,
        needs: Needs::Methods(&["rmfr"]),
        ray_marched: None,
        set: |settings, value| {
            if let Method::Rmfr(params) = &mut settings.method {
                params.delta = number(value);
            }
            Ok(())
        },
    },
    Knob {
        name: "guenter-slope",
        affects: "how fast the three layers coarsen, arc minutes per degree",
        range: numbers(0.1, 10.0),
        reference: Reference::Number(0.1),
        order: Order::LessIsMoreAccurate,
        needs: Needs::Methods(&["guenter3"]),
        ray_marched: None,
        set: |settings, value| {
            if let Method::Guenter(params) = &mut settings.method {
                params.slope_arcmin_per_deg = number(value);
            }
            Ok(())
        },
    },
    Knob {
        name: "lp-filter",
        affects: "anti-aliasing of the LP-buffer",
        range: Range::Names(LP_FILTERS),
        reference: Reference::Name("none"),
        order: Order::None,
        needs: Needs::Methods(&["kfr", "vafr", "vafr-planar"]),
        ray_marched: None,
        set: set_lp_filter,
    },
    Knob {
        name: "post-filter",
        affects: "a Gaussian on the display that grows with eccentricity",
        range: Range::Switch,
        reference: Reference::Switch(false),
        order: Order::None,
        needs: OF_KFR,
        ray_marched: None,
        set: |settings, value| with_kfr(settings, |kfr| kfr.post_filter = is_on(value)),
    },
    Knob {
        name: "footprint",
        affects: "maps and highlights of texels larger than a pixel",
        range: Range::Switch,
        reference: Reference::Switch(true),
        order: Order::None,
        needs: Needs::Foveation,
        ray_marched: Some(false),
        set: |settings, value| {
            settings.footprint = is_on(value);
            Ok(())
        },
    },
    Knob {
        name: "spp",
        affects: "rays for each pixel or LP texel",
        range: Range::Numbers { least: 1.0, most: 16.0, whole: true },
        reference: Reference::Number(16.0),
        order: Order::MoreIsMoreAccurate,
        needs: Needs::Nothing,
        ray_marched: Some(true),
        set: |settings, value| {
            settings.samples_per_pixel = number(value) as u32;
            Ok(())
        },
    },
    Knob {
        name: "shadowed-lights",
        affects: "lights that cast shadows",
        range: Range::Numbers { least: 0.0, most: 16.0, whole: true },
        reference: Reference::Number(16.0),
        order: Order::MoreIsMoreAccurate,
        needs: Needs::Nothing,
        ray_marched: Some(false),
        set: |settings, value| {
            settings.shadowed_lights = number(value) as u32;
            Ok(())
        },
    },
    Knob {
        name: "shadow-map-size",
        affects: "how sharp the edges of shadows are",
        range: Range::Numbers { least: 64.0, most: 8192.0, whole: true },
        reference: Reference::Number(8192.0),
        order: Order::MoreIsMoreAccurate,
        needs: Needs::Nothing,
        ray_marched: Some(false),
        set: |settings, value| {
            settings.shadow_map_size = number(value) as u32;
            Ok(())
        },
    },
];

const fn numbers(least: f64, most: f64) -> Range {
    Range::Numbers { least, most, whole: false }
}

// The values below were checked against the knob's range: of another kind they would not come here.

fn number(value: &Value) -> f64 {
    match value {
        Value::Number(number) => *number,
        _ => 0.0,
    }
}

fn is_on(value: &Value) -> bool {
    *value == Value::Switch(true)
}

fn name(value: &Value) -> &str {
    match value {
        Value::Name(name) => name,
        _ => "",
    }
}

fn with_kfr(settings: &mut RenderSettings, change: impl FnOnce(&mut KfrSettings)) -> Result<()> {
    if let Method::Kfr(kfr) = &mut settings.method {
        change(kfr);
    }
    Ok(())
}

fn with_vafr(
    settings: &mut RenderSettings,
    change: impl FnOnce(&mut VafrSettings) -> Result<()>,
) -> Result<()> {
    match &mut settings.method {
        Method::Vafr(vafr) => change(vafr),
        _ => Ok(()),
    }
}

/// The parameters of the method that is there already stay, and so does an acuity model.
fn set_method(settings: &mut RenderSettings, value: &Value) -> Result<()> {
    let wanted = name(value);
    if method_name(&settings.method) == wanted {
        return Ok(());
    }
    let mut method = method_named(wanted)?;
    if let (Method::Vafr(vafr), Method::Vafr(before)) = (&mut method, &settings.method) {
        vafr.acuity = before.acuity.clone();
    }
    settings.footprint = method.footprint_by_default();
    settings.method = method;
    Ok(())
}

fn set_kernel(settings: &mut RenderSettings, value: &Value) -> Result<()> {
    let wanted = match name(value) {
        "sin" => Kernel::Sine,
        "exp" => Kernel::Exponential,
        _ => Kernel::Power { alpha: 4.0 },
    };
    with_kfr(settings, |kfr| {
        // The exponent of a power that is there already stays.
        if !matches!((kfr.kernel, wanted), (Kernel::Power { .. }, Kernel::Power { .. })) {
            kfr.kernel = wanted;
        }
    })
}

fn set_lp_filter(settings: &mut RenderSettings, value: &Value) -> Result<()> {
    let filter = match name(value) {
        "gaussian" => LpFilter::Gaussian,
        "fxaa" => LpFilter::Fxaa,
        _ => LpFilter::None,
    };
    match &mut settings.method {
        Method::Kfr(kfr) => kfr.lp_filter = filter,
        Method::Vafr(vafr) => vafr.lp_filter = filter,
        _ => {}
    }
    Ok(())
}

pub(super) fn method_name(method: &Method) -> &'static str {
    match method {
        Method::Full => "full",
        Method::Kfr(_) => "kfr",
        Method::Vafr(VafrSettings { form: VafrForm::Sphere, .. }) => "vafr",
        Method::Vafr(_) => "vafr-planar",
        Method::Lafr(_) => "lafr",
        Method::VisualPolar(_) => "visual-polar",
        Method::Rmfr(_) => "rmfr",
        Method::Guenter(_) => "guenter3",
    }
}

pub(super) fn method_named(name: &str) -> Result<Method> {
    let vafr = |form| Method::Vafr(VafrSettings { form, ..VafrSettings::default() });
    Ok(match name {
        "full" => Method::Full,
        "kfr" => Method::Kfr(KfrSettings::default()),
        "vafr" => vafr(VafrForm::Sphere),
        "vafr-planar" => vafr(VafrForm::Planar),
        "lafr" => Method::Lafr(LafrParams::default()),
        "visual-polar" => Method::VisualPolar(VisualPolarParams::default()),
        "rmfr" => Method::Rmfr(RmfrParams::default()),
        "guenter3" => Method::Guenter(GuenterParams::default()),
        _ => {
            let known = METHODS.join(", ");
            return Err(Error::Setting(format!("there is no method `{name}`; there are {known}")));
        }
    })
}

pub(super) fn has_power_kernel(method: &Method) -> bool {
    matches!(method, Method::Kfr(KfrSettings { kernel: Kernel::Power { .. }, .. }))
}
