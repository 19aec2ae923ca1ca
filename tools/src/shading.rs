//! How a picture is shaded: options that every command has which renders.

use crate::failure::Failure;
use crate::options::KernelArgs;
use clap::{Args, ValueEnum};
use macula::fovea::{DisplayGeometry, VafrForm};
use macula::settings::{KfrSettings, Method, RenderSettings, VafrSettings};

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
    /// Leave out the LP-buffer's Gaussian in the periphery
    #[arg(long, help_heading = "Foveation")]
    no_lp_filter: bool,
    /// Gaussian on the display that grows with the distance from the gaze
    #[arg(long, help_heading = "Foveation")]
    post_filter: bool,
    /// Shade over each sample's footprint: maps by its size, roughness by its normals' variance
    /// [default: with vafr only; the others are as published]
    #[arg(long, help_heading = "Foveation", overrides_with = "no_footprint")]
    footprint: bool,
    /// Shade every sample as if it were a pixel
    #[arg(long, help_heading = "Foveation")]
    no_footprint: bool,
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

    /// Settings for a display; all that is not of the method as it is by default.
    ///
    /// # Errors
    /// As [`Self::method`].
    pub fn settings(&self, display: DisplayGeometry) -> Result<RenderSettings, Failure> {
        let given = [(self.footprint, "--footprint"), (self.no_footprint, "--no-footprint")];
        let given = given.into_iter().find_map(|(is_given, name)| is_given.then_some(name));
        if let (MethodName::Full, Some(name)) = (self.method, given) {
            return Err(without_meaning(name));
        }
        let mut settings = RenderSettings::new(display, self.method()?);
        settings.footprint = (settings.footprint || self.footprint) && !self.no_footprint;
        Ok(settings)
    }

    /// The method, its parameters checked as far as they do not need a display.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a parameter that belongs to another method or is out of range.
    fn method(&self) -> Result<Method, Failure> {
        if self.method == MethodName::Vafr {
            return Ok(Method::Vafr(VafrSettings::default()));
        }
        if self.method == MethodName::VafrPlanar {
            return Ok(Method::Vafr(VafrSettings { form: VafrForm::Planar, ..VafrSettings::default() }));
        }
        if self.method == MethodName::Full {
            let of_kfr = [
                (self.sigma.is_some(), "--sigma"),
                (self.kernel.given().is_some(), self.kernel.given().unwrap_or_default()),
                (self.no_lp_filter, "--no-lp-filter"),
                (self.post_filter, "--post-filter"),
            ];
            return match of_kfr.iter().find(|(given, _)| *given) {
                Some((_, name)) => Err(without_meaning(name)),
                None => Ok(Method::Full),
            };
        }
        Ok(Method::Kfr(KfrSettings {
            sigma: self.sigma.unwrap_or(KfrSettings::default().sigma),
            kernel: self.kernel.kernel()?,
            lp_filter: !self.no_lp_filter,
            post_filter: self.post_filter,
        }))
    }
}

/// An option that only foveation has, given with full shading.
pub fn without_meaning(name: &str) -> Failure {
    Failure::usage(format!("{name} has no meaning with --method full; leave it out or use --method kfr"))
}
