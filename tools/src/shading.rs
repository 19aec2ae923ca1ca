//! How a picture is shaded: options that every command has which renders.

use crate::failure::Failure;
use crate::options::KernelArgs;
use clap::{Args, ValueEnum};
use macula::fovea::{
    AcuityModel, DisplayGeometry, GuenterParams, LafrParams, RmfrParams, VafrForm, VisualPolarParams,
};
use macula::knobs::Setting;
use macula::settings::{KfrSettings, LpFilter, Method, RenderSettings, VafrSettings};
use std::path::{Path, PathBuf};

/// The methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// Shade every pixel: the reference
    Full,
    /// Kernel foveated rendering
    Kfr,
    /// As dense as the eye's acuity on the sphere around the gaze, native pixels where the display is coarser
    Vafr,
    /// The same as published: by planar distance from the gaze, without native pixels
    VafrPlanar,
    /// Locomotion-aware foveated rendering, for comparison
    Lafr,
    /// Visual-Polar space, for comparison
    VisualPolar,
    /// Rectangular mapping, for comparison
    Rmfr,
    /// Three nested layers of falling resolution, for comparison
    Guenter3,
}

impl MethodName {
    /// As on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Kfr => "kfr",
            Self::Vafr => "vafr",
            Self::VafrPlanar => "vafr-planar",
            Self::Lafr => "lafr",
            Self::VisualPolar => "visual-polar",
            Self::Rmfr => "rmfr",
            Self::Guenter3 => "guenter3",
        }
    }

    /// The method with its default parameters and an acuity model, which only VaFR reads.
    pub fn with_acuity(self, acuity: &AcuityModel) -> Method {
        let vafr =
            |form| Method::Vafr(VafrSettings { form, acuity: acuity.clone(), ..VafrSettings::default() });
        match self {
            Self::Full => Method::Full,
            Self::Kfr => Method::Kfr(KfrSettings::default()),
            Self::Vafr => vafr(VafrForm::Sphere),
            Self::VafrPlanar => vafr(VafrForm::Planar),
            Self::Lafr => Method::Lafr(LafrParams::default()),
            Self::VisualPolar => Method::VisualPolar(VisualPolarParams::default()),
            Self::Rmfr => Method::Rmfr(RmfrParams::default()),
            Self::Guenter3 => Method::Guenter(GuenterParams::default()),
        }
    }
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

/// The acuity model.
#[derive(Args, Clone, Debug, Default)]
pub struct AcuityArgs {
    /// Acuity model of the eye: a TOML file with `degrees` and `cpd` [default: 40, 10, 6, 5 and 4 cpd at 0,
    /// 10, 20, 30 and 60 degrees]
    #[arg(long, value_name = "FILE.toml")]
    acuity: Option<PathBuf>,
    /// Factor on the acuity: above 1 samples more, below 1 fewer, 0.05 to 20
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    acuity_scale: Option<f64>,
    /// Round off the acuity model's kinks
    #[arg(long)]
    smooth_acuity: bool,
}

impl AcuityArgs {
    /// The first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            (self.acuity.is_some(), "--acuity"),
            (self.acuity_scale.is_some(), "--acuity-scale"),
            (self.smooth_acuity, "--smooth-acuity"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }

    /// The model in words.
    pub fn label(&self) -> String {
        let mut label = self.acuity.as_ref().map_or("vafr-2025".into(), |path| path.display().to_string());
        if self.smooth_acuity {
            label += ", smooth";
        }
        if let Some(scale) = self.acuity_scale {
            label += &format!(", times {scale}");
        }
        label
    }

    /// The model.
    ///
    /// # Errors
    /// A file that cannot be read or is no acuity model, a scale out of range.
    pub fn model(&self) -> Result<AcuityModel, Failure> {
        let mut model = match &self.acuity {
            Some(path) => read_acuity(path)?,
            None => AcuityModel::vafr_2025(),
        };
        if self.smooth_acuity {
            model = model.smooth();
        }
        match self.acuity_scale {
            Some(scale) => Ok(model.scaled(scale)?),
            None => Ok(model),
        }
    }
}

fn read_acuity(path: &Path) -> Result<AcuityModel, Failure> {
    read_toml(path, AcuityModel::from_toml)
}

/// Knobs' values from a file, as `macula choose` writes it.
///
/// # Errors
/// A file that cannot be read or holds something else.
pub fn read_setting(path: &Path) -> Result<Setting, Failure> {
    read_toml(path, Setting::from_toml)
}

fn read_toml<T>(path: &Path, from: impl FnOnce(&str) -> macula::Result<T>) -> Result<T, Failure> {
    let told = |error: String| Failure::environment(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| told(error.to_string()))?;
    from(&text).map_err(|error| told(error.to_string()))
}

/// The method with its parameters.
#[derive(Args, Clone, Debug)]
pub struct ShadingArgs {
    /// How the picture is shaded
    #[arg(long, value_enum, value_name = "NAME", default_value = "kfr", help_heading = "Foveation")]
    pub method: MethodName,
    /// Display width over LP-buffer width of kfr, 1 to 64; 1 to 4 is useful [default: 1.8]
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
    #[command(flatten, next_help_heading = "Foveation")]
    acuity: AcuityArgs,
    /// No more samples of vafr-planar than the display resolves at its centre
    #[arg(long, help_heading = "Foveation")]
    display_limit: bool,
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
        self.method.name()
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
        let mut settings = RenderSettings::new(display, self.method(&display)?);
        settings.footprint = (settings.footprint || self.footprint) && !self.no_footprint;
        Ok(settings)
    }

    /// The method, its parameters checked as far as they do not need a display.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a parameter that belongs to another method or is out of range; what reading an
    /// acuity model reports.
    fn method(&self, display: &DisplayGeometry) -> Result<Method, Failure> {
        self.check_belonging()?;
        let lp_filter = self.lp_filter.map(LpFilterName::filter);
        if self.method == MethodName::Kfr {
            return Ok(Method::Kfr(KfrSettings {
                sigma: self.sigma.unwrap_or(KfrSettings::default().sigma),
                kernel: self.kernel.kernel()?,
                lp_filter: lp_filter.unwrap_or(LpFilter::Gaussian),
                post_filter: self.post_filter,
            }));
        }
        let mut acuity = self.acuity.model()?;
        if self.display_limit {
            let centre_per_rad = display.tangents_per_px().max_element().recip();
            acuity = acuity.limited_to(centre_per_rad * 1f64.to_radians() / 2.0)?;
        }
        let mut method = self.method.with_acuity(&acuity);
        if let (Method::Vafr(vafr), Some(lp_filter)) = (&mut method, lp_filter) {
            vafr.lp_filter = lp_filter;
        }
        Ok(method)
    }

    /// Refuses options of other methods.
    fn check_belonging(&self) -> Result<(), Failure> {
        let of_kfr = [
            (self.sigma.is_some(), "--sigma"),
            (self.kernel.given().is_some(), self.kernel.given().unwrap_or_default()),
            (self.post_filter, "--post-filter"),
        ];
        let given_of_kfr = of_kfr.iter().find_map(|(given, name)| given.then_some(*name));
        let given_filter = self.lp_filter.map(|_| "--lp-filter");
        let given_of_vafr = self.acuity.given();
        let given_of_planar = self.display_limit.then_some("--display-limit");
        let foreign = match self.method {
            MethodName::Full => {
                return match given_of_kfr.or(given_filter).or(given_of_vafr).or(given_of_planar) {
                    Some(name) => Err(without_meaning(name)),
                    None => Ok(()),
                };
            }
            MethodName::Kfr => given_of_vafr.or(given_of_planar),
            MethodName::Vafr => given_of_kfr.or(given_of_planar),
            MethodName::VafrPlanar => given_of_kfr,
            _ => given_of_kfr.or(given_filter).or(given_of_vafr).or(given_of_planar),
        };
        foreign.map_or(Ok(()), |name| {
            let method = self.method.name();
            Err(Failure::usage(format!("{name} has no meaning with --method {method}; leave it out")))
        })
    }
}

/// An option that only foveation has, given with full shading.
pub fn without_meaning(name: &str) -> Failure {
    Failure::usage(format!("{name} has no meaning with --method full; leave it out or use --method kfr"))
}
