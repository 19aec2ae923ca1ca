//! What a caller asks of the renderer, checked before anything is built.

use crate::error::{Error, Result};
use crate::fovea::{
    AcuityModel, DisplayGeometry, GuenterMapping, GuenterParams, Kernel, KfrColumns, LafrMapping, LafrParams,
    Mapping, RmfrMapping, RmfrParams, VafrForm, VafrMapping, VisualPolarMapping, VisualPolarParams,
};
use glam::DVec2;
use serde::Serialize;
use std::sync::Arc;

/// How the picture is shaded.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Every pixel of the display: the reference.
    Full,
    /// Kernel foveated rendering.
    Kfr(KfrSettings),
    /// Visual-acuity-consistent foveated rendering.
    Vafr(VafrSettings),
    /// Locomotion-aware foveated rendering (2023), for comparison.
    Lafr(LafrParams),
    /// Visual-Polar space (2019), for comparison.
    VisualPolar(VisualPolarParams),
    /// Rectangular mapping (2022), for comparison.
    Rmfr(RmfrParams),
    /// Three nested layers (2012), for comparison.
    Guenter(GuenterParams),
}

impl Method {
    /// The mapping for a checked display and parameters, and a gaze; `None` for full shading. Allocates:
    /// for tools and tests, not for every frame.
    #[must_use]
    pub fn mapping(&self, display: &DisplayGeometry, gaze_px: DVec2) -> Option<Box<dyn Mapping>> {
        Some(match self {
            Self::Full => return None,
            Self::Kfr(kfr) => Box::new(KfrColumns::new(*display, gaze_px, kfr.kernel, kfr.sigma)),
            Self::Vafr(vafr) => {
                Box::new(VafrMapping::new(vafr.form, display, gaze_px, &Arc::new(vafr.acuity.clone())))
            }
            Self::Lafr(params) => Box::new(LafrMapping::new(*display, gaze_px, *params)),
            Self::VisualPolar(params) => Box::new(VisualPolarMapping::new(*display, gaze_px, *params)),
            Self::Rmfr(params) => Box::new(RmfrMapping::new(*display, gaze_px, *params)),
            Self::Guenter(params) => Box::new(GuenterMapping::new(*display, gaze_px, *params)),
        })
    }
}

impl Method {
    /// The filter over the LP-buffer; none with full shading.
    #[must_use]
    pub fn lp_filter(&self) -> LpFilter {
        match self {
            Self::Full => LpFilter::None,
            Self::Kfr(kfr) => kfr.lp_filter,
            Self::Vafr(vafr) => vafr.lp_filter,
            // As VaFR's authors have it beside their own: that of KFR.
            Self::Lafr(_) => LpFilter::Gaussian,
            Self::VisualPolar(_) | Self::Rmfr(_) | Self::Guenter(_) => LpFilter::None,
        }
    }
}

/// Anti-aliasing of the LP-buffer, before it is mapped back to the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LpFilter {
    /// The texels as they were shaded.
    #[default]
    None,
    /// KFR's 3x3 Gaussian (thesis of 2018, section 2.2.3): it blurs evenly. With KFR it begins where a
    /// texel covers more than 4 px^2.
    Gaussian,
    /// Fast approximate anti-aliasing (Lottes, 2009), as VaFR has it: it smooths edges along their
    /// direction and leaves the rest.
    Fxaa,
}

impl Method {
    /// Whether [`RenderSettings::footprint`] is on by default: not for methods that are rendered as they
    /// were published.
    #[must_use]
    pub fn footprint_by_default(&self) -> bool {
        matches!(self, Self::Vafr(VafrSettings { form: VafrForm::Sphere, .. }))
    }
}

/// Kernel foveated rendering (thesis of 2018, section 2).
#[derive(Clone, Debug, PartialEq)]
pub struct KfrSettings {
    /// Display width over LP-buffer width, 1 to 4 in the published studies; at most 64 here.
    pub sigma: f64,
    /// Where along the radius the LP-buffer spends its columns.
    pub kernel: Kernel,
    /// Anti-aliasing of the LP-buffer; the thesis has the Gaussian.
    pub lp_filter: LpFilter,
    /// Gaussian on the display outside the native disc (Eq. 2.14).
    pub post_filter: bool,
}

impl Default for KfrSettings {
    /// The values that the thesis' user study chose: sigma 1.8, alpha 4.
    fn default() -> Self {
        Self {
            sigma: 1.8,
            kernel: Kernel::Power { alpha: 4.0 },
            lp_filter: LpFilter::Gaussian,
            post_filter: false,
        }
    }
}

/// Visual-acuity-consistent foveated rendering (VaFR, 2025).
#[derive(Clone, Debug, PartialEq)]
pub struct VafrSettings {
    /// On the sphere around the gaze ray with a native disc, or the paper's planar form.
    pub form: VafrForm,
    /// The acuity whose samples are shaded.
    pub acuity: AcuityModel,
    /// Anti-aliasing of the LP-buffer; the paper has FXAA.
    pub lp_filter: LpFilter,
}

impl Default for VafrSettings {
    /// On the sphere, with the paper's acuity model and filter.
    fn default() -> Self {
        Self { form: VafrForm::Sphere, acuity: AcuityModel::vafr_2025(), lp_filter: LpFilter::Fxaa }
    }
}

/// From linear radiance to the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneMap {
    /// Clamped to 0..=1 only.
    None,
    /// ACES filmic curve (fit of the reference rendering transform).
    #[default]
    Aces,
}

/// What the target shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum View {
    /// The picture.
    #[default]
    Picture,
    /// Samples per pixel, as a colour: blue few, green one, red many.
    Density,
    /// The LP-buffer's texel borders over the picture.
    Grid,
    /// A cross at the gaze over the picture.
    Gaze,
    /// Rings of eccentricity at 2, 5, 10, 20 and 40 degrees over the picture.
    Rings,
}

/// Everything that decides what is built. Changing any of it needs a new bake.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels and field of view.
    pub display: DisplayGeometry,
    /// How the picture is shaded.
    pub method: Method,
    /// Tone mapping of the 8-bit target.
    pub tone_map: ToneMap,
    /// What the target shows.
    pub view: View,
    /// Linear factor on radiance before tone mapping, above 0.
    pub exposure: f32,
    /// Lights that cast shadows, the directional ones first and then by intensity; at most 16.
    pub shadowed_lights: u32,
    /// Texels along the side of a shadow map, 64 to 8192.
    pub shadow_map_size: u32,
    /// Samples per pixel or LP texel of a ray-marched scene, 1 to 16.
    pub samples_per_pixel: u32,
    /// Shade over a sample's whole footprint where that is larger than a pixel: maps by its size,
    /// surfaces from several pixels, roughness widened by the variance of its normals. Averages are of
    /// light: a highlight so bright that the display clips it even when it is spread shows larger, and so
    /// changes more, than in full shading. A texel across a silhouette shows one side of it. Of no meaning for
    /// full shading, whose samples are pixels, and for the ray-marched scene, which does it always.
    pub footprint: bool,
    /// Run every effect, also those that the scene does not call for.
    pub force_effects: bool,
    /// Count NaN and infinite values in every buffer (in a pass that the frame's time leaves out).
    pub check_finite: bool,
}

impl RenderSettings {
    /// The defaults for a display.
    #[must_use]
    pub fn new(display: DisplayGeometry, method: Method) -> Self {
        Self {
            display,
            footprint: method.footprint_by_default(),
            method,
            tone_map: ToneMap::default(),
            view: View::default(),
            exposure: 1.0,
            shadowed_lights: 1,
            shadow_map_size: 1024,
            samples_per_pixel: 1,
            force_effects: false,
            check_finite: false,
        }
    }

    /// Shading is foveated.
    #[must_use]
    pub fn foveated(&self) -> bool {
        !matches!(self.method, Method::Full)
    }

    /// Checks the ranges that do not depend on a device.
    ///
    /// # Errors
    /// [`Error::Setting`], naming the value and the range.
    pub fn check(&self) -> Result<()> {
        let within = |name: &str, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                return Ok(());
            }
            Err(Error::Setting(format!("{name} is {value}; it must lie between {low} and {high}")))
        };
        self.display.check()?;
        match &self.method {
            Method::Full | Method::Vafr(_) => {}
            Method::Kfr(kfr) => {
                within("sigma", kfr.sigma, 1.0, 64.0)?;
                kfr.kernel.check()?;
            }
            Method::Lafr(params) => params.check()?,
            Method::VisualPolar(params) => params.check()?,
            Method::Rmfr(params) => params.check()?,
            Method::Guenter(params) => params.check()?,
        }
        within("exposure", f64::from(self.exposure), 1e-6, 1e6)?;
        within("the number of shadowed lights", f64::from(self.shadowed_lights), 0.0, 16.0)?;
        within("the shadow map's size", f64::from(self.shadow_map_size), 64.0, 8192.0)?;
        within("samples per pixel", f64::from(self.samples_per_pixel), 1.0, 16.0)
    }
}
