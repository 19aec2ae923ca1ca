//! How a picture is shaded: options that every command has which renders.

use crate::failure::Failure;
use crate::options::KernelArgs;
use clap::{Args, ValueEnum};
use macula::fovea::VafrForm;
use macula::settings::{KfrSettings, LpFilter, Method, VafrSettings};

/// The methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// Shade every pixel: the reference
    Full,
    /// Kernel foveated rendering
    Kfr,
    /// As dense as the eye's acuity on the sphere around the gaze, and native pixels around it
    Vafr,
    /// As published: planar distances from the gaze
    VafrPlanar,
}

/// The filters over the LP-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LpFilterName {
    /// The texels as they were shaded
    None,
    /// 3x3 in the periphery: blurs evenly
    Gaussian,
    /// Fast approximate anti-aliasing: smooths edges only
    Fxaa,
}

impl LpFilterName {
    fn filter(self) -> LpFilter {
        match self {
            Self::None => LpFilter::None,
            Self::Gaussian => LpFilter::Gaussian,
            Self::Fxaa => LpFilter::Fxaa,
        }
    }
}

/// The method with its parameters.
#[derive(Args, Clone, Debug)]
pub struct ShadingArgs {
    /// How the picture is shaded
    #[arg(long, value_enum, default_value = "kfr", help_heading = "Foveation")]
    pub method: MethodName,
    /// Display width over LP-buffer width, 1 to 64; 1 to 4 is useful [default: 1.8]
    #[arg(long, value_name = "S", allow_hyphen_values = true, help_heading = "Foveation")]
    sigma: Option<f64>,
    #[command(flatten, next_help_heading = "Foveation")]
    kernel: KernelArgs,
    /// Anti-aliasing of the LP-buffer [default: gaussian with kfr, fxaa with vafr and vafr-planar]
    #[arg(long, value_enum, value_name = "FILTER", help_heading = "Foveation")]
    lp_filter: Option<LpFilterName>,
    /// Gaussian on the display that grows with the distance from the gaze
    #[arg(long, help_heading = "Foveation")]
    post_filter: bool,
}

impl ShadingArgs {
    /// The method's name in reports.
    pub fn name(&self) -> &'static str {
        match self.method {
            MethodName::Full => "full",
            MethodName::Kfr => "kfr",
            MethodName::Vafr => "vafr",
            MethodName::VafrPlanar => "vafr-planar",
        }
    }

    /// The method, its parameters checked as far as they do not need a display.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a parameter that belongs to another method or is out of range.
    pub fn method(&self) -> Result<Method, Failure> {
        let lp_filter = self.lp_filter.map(LpFilterName::filter);
        if let MethodName::Vafr | MethodName::VafrPlanar = self.method {
            let defaults = VafrSettings::default();
            return Ok(Method::Vafr(VafrSettings {
                form: if self.method == MethodName::Vafr { VafrForm::Sphere } else { VafrForm::Planar },
                lp_filter: lp_filter.unwrap_or(defaults.lp_filter),
                ..defaults
            }));
        }
        if self.method == MethodName::Full {
            let of_kfr = [
                (self.sigma.is_some(), "--sigma"),
                (self.kernel.given().is_some(), self.kernel.given().unwrap_or_default()),
                (self.lp_filter.is_some(), "--lp-filter"),
                (self.post_filter, "--post-filter"),
            ];
            return match of_kfr.iter().find(|(given, _)| *given) {
                Some((_, name)) => Err(without_meaning(name)),
                None => Ok(Method::Full),
            };
        }
        let defaults = KfrSettings::default();
        Ok(Method::Kfr(KfrSettings {
            sigma: self.sigma.unwrap_or(defaults.sigma),
            kernel: self.kernel.kernel()?,
            lp_filter: lp_filter.unwrap_or(defaults.lp_filter),
            post_filter: self.post_filter,
        }))
    }
}

/// An option that only foveation has, given with full shading.
pub fn without_meaning(name: &str) -> Failure {
    Failure::usage(format!("{name} has no meaning with --method full; leave it out or use --method kfr"))
}
