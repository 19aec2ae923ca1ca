//! What the cases are about: methods, displays and gazes. Families go through all of them.

use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{
    AcuityModel, DisplayGeometry, GuenterParams, Kernel, LafrParams, Mapping, RmfrParams, VafrForm,
    VisualPolarParams,
};
use macula::settings::{KfrSettings, Method, VafrSettings};

/// What the LP-buffer's columns and rows are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Circles about the gaze: v is periodic.
    Polar,
    /// Lines of the display, in one piece.
    Axes,
    /// Lines of the display, in layers one above the other.
    Layers,
}

/// A foveated method with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// In ids.
    pub name: &'static str,
    /// As the renderer takes it.
    pub method: Method,
    /// Part of the subset.
    pub quick: bool,
}

impl Subject {
    fn new(name: &'static str, method: Method) -> Self {
        Self { name, method, quick: true }
    }

    /// For the whole catalogue only.
    fn thorough(self) -> Self {
        Self { quick: false, ..self }
    }

    /// What its columns and rows are.
    pub fn layout(&self) -> Layout {
        match self.method {
            Method::Rmfr(_) => Layout::Axes,
            Method::Guenter(_) => Layout::Layers,
            _ => Layout::Polar,
        }
    }

    /// Its mapping for a display and a gaze.
    ///
    /// # Errors
    /// For full shading, which has none.
    pub fn mapping(&self, display: &DisplayGeometry, gaze_px: DVec2) -> Result<Box<dyn Mapping>, Failure> {
        let none = || Failure::environment(format!("{} has no mapping", self.name));
        self.method.mapping(display, gaze_px).ok_or_else(none)
    }
}

fn kfr(name: &'static str, sigma: f64, kernel: Kernel) -> Subject {
    Subject::new(name, Method::Kfr(KfrSettings { sigma, kernel, ..KfrSettings::default() }))
}

fn vafr(name: &'static str, form: VafrForm, acuity: AcuityModel) -> Subject {
    Subject::new(name, Method::Vafr(VafrSettings { form, acuity, ..VafrSettings::default() }))
}

/// A polynomial that rises in two waves, with coefficients of both signs; its slope at 1/2 is 0.
const WAVE: Kernel = Kernel::Polynomial { beta: [0.0, 3.0, -6.0, 4.0, 0.0, 0.0, 0.0, 0.0] };

/// A sum of four powers.
const POWERS: Kernel = Kernel::Polynomial { beta: [0.0, 0.25, 0.25, 0.0, 0.0, 0.3, 0.0, 0.2] };

/// Every method, each once with its defaults and then with the parameters that are hardest on it. A method
/// is added here and nowhere else.
pub fn methods() -> Vec<Subject> {
    let paper = AcuityModel::vafr_2025;
    vec![
        kfr("kfr", 1.8, Kernel::Power { alpha: 4.0 }),
        kfr("kfr-alpha1", 1.0, Kernel::Power { alpha: 1.0 }).thorough(),
        kfr("kfr-alpha6", 4.0, Kernel::Power { alpha: 6.0 }),
        kfr("kfr-alpha2.5", 1.8, Kernel::Power { alpha: 2.5 }).thorough(),
        kfr("kfr-sine", 1.8, Kernel::Sine),
        kfr("kfr-exp", 1.8, Kernel::Exponential).thorough(),
        kfr("kfr-powers", 1.8, POWERS).thorough(),
        kfr("kfr-wave", 1.8, WAVE).thorough(),
        kfr("kfr-sigma64", 64.0, Kernel::Power { alpha: 4.0 }).thorough(),
        vafr("vafr", VafrForm::Sphere, paper()),
        vafr("vafr-smooth", VafrForm::Sphere, paper().smooth()).thorough(),
        vafr("vafr-planar", VafrForm::Planar, paper()),
        Subject::new("lafr", Method::Lafr(LafrParams::default())),
        Subject::new("lafr-retinal", Method::Lafr(LafrParams::RETINAL)).thorough(),
        Subject::new("visual-polar", Method::VisualPolar(VisualPolarParams::default())),
        Subject::new("rmfr", Method::Rmfr(RmfrParams::default())),
        Subject::new("guenter3", Method::Guenter(GuenterParams::default())),
    ]
}

/// A display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// In ids.
    pub name: &'static str,
    /// Pixels and frustum.
    pub display: DisplayGeometry,
    /// Part of the subset.
    pub quick: bool,
}

fn screen(name: &'static str, size_px: [u32; 2], hfov_deg: f64, quick: bool) -> Screen {
    Screen { name, display: DisplayGeometry::symmetric(size_px, hfov_deg), quick }
}

/// Displays for which points are mapped: from one pixel to the largest that is published, odd and prime
/// sides, one row, a frustum of nearly half a turn, frusta without an axis of symmetry or without the view
/// axis in them (as of a canted panel), pixels three times as wide as high.
pub fn screens() -> Vec<Screen> {
    let frustum = |name, size_px, tangents: [f64; 4], quick| {
        let [tan_left, tan_right, tan_up, tan_down] = tangents;
        Screen { name, display: DisplayGeometry { size_px, tan_left, tan_right, tan_up, tan_down }, quick }
    };
    vec![
        screen("1x1", [1, 1], 60.0, true),
        screen("2x1", [2, 1], 60.0, false),
        screen("1x7", [1, 7], 20.0, false),
        screen("13x17", [13, 17], 80.0, true),
        screen("64x64", [64, 64], 90.0, false),
        screen("101x103", [101, 103], 90.0, false),
        screen("1280x720", [1280, 720], 90.0, true),
        screen("1920x1080", [1920, 1080], 100.0, false),
        screen("2560x1440", [2560, 1440], 40.0, false),
        screen("3840x2160", [3840, 2160], 100.0, false),
        screen("7680x4320", [7680, 4320], 100.0, false),
        screen("11520x6480", [11520, 6480], 120.0, true),
        screen("11520x16", [11520, 16], 120.0, false),
        screen("wide-178deg", [1920, 1080], 178.0, false),
        frustum("asymmetric", [1440, 1600], [-1.42, 1.07, 1.19, -1.43], true),
        frustum("canted", [1440, 1600], [0.2, 1.9, 0.9, -1.3], false),
        frustum("anisotropic", [1000, 1000], [-1.5, 1.5, 0.5, -0.5], false),
    ]
}

/// Where the eye looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaze {
    /// In ids.
    pub name: &'static str,
    /// Display position, px; may be anything.
    pub px: DVec2,
    /// Part of the subset.
    pub quick: bool,
}

/// Gazes on a display: in a pixel's centre, between pixels, on a corner and on edges, off the display by a
/// pixel, by a display and by far more, and none at all.
pub fn gazes(display: &DisplayGeometry) -> Vec<Gaze> {
    let [width, height] = display.size_px.map(f64::from);
    let (column, row) = ((0.37 * width).floor(), (0.61 * height).floor());
    let gaze = |name, x: f64, y: f64, quick| Gaze { name, px: DVec2::new(x, y), quick };
    vec![
        gaze("centre", width / 2.0, height / 2.0, true),
        gaze("pixel-centre", column + 0.5, row + 0.5, true),
        gaze("between-pixels", column, row + 0.5, false),
        gaze("oblique", 0.21 * width, 0.77 * height, false),
        gaze("corner", 0.0, 0.0, true),
        gaze("last-corner", width, height, false),
        gaze("corner-pixel", 0.5, 0.5, false),
        gaze("edge", width, height / 3.0, false),
        gaze("top-edge", width / 2.0, 0.0, false),
        gaze("beside-corner", 5e-324, -5e-324, false),
        gaze("1px-off", -1.0, height / 3.0, true),
        gaze("1px-below", width / 2.0, height + 1.0, false),
        gaze("1display-off", 2.0 * width, -height, false),
        gaze("1e6px-off", 1e6, -1e6, true),
        gaze("1e12px-off", -1e12, 3.0, false),
        gaze("extreme", f64::MAX, f64::MIN, false),
        gaze("nan", f64::NAN, 1.0, true),
        gaze("infinite", f64::INFINITY, f64::NEG_INFINITY, false),
    ]
}

/// Whether a position lies on the display, its edges included.
pub fn on_display(display: &DisplayGeometry, px: DVec2) -> bool {
    let [width, height] = display.size_px.map(f64::from);
    (0.0..=width).contains(&px.x) && (0.0..=height).contains(&px.y)
}

/// The centre of the pixel that holds a position on the display; the last pixel's at its far edges.
pub fn pixel_of(display: &DisplayGeometry, px: DVec2) -> DVec2 {
    let last = DVec2::from_array(display.size_px.map(|side| f64::from(side) - 1.0));
    px.floor().clamp(DVec2::ZERO, last) + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_unique_and_settings_valid() {
        let unique = |names: Vec<&'static str>| {
            let count = names.len();
            assert_eq!(names.into_iter().collect::<HashSet<_>>().len(), count);
        };
        unique(methods().iter().map(|subject| subject.name).collect());
        unique(screens().iter().map(|screen| screen.name).collect());
        for screen in screens() {
            screen.display.check().expect("a display");
            unique(gazes(&screen.display).iter().map(|gaze| gaze.name).collect());
            for subject in methods() {
                let settings = macula::settings::RenderSettings::new(screen.display, subject.method.clone());
                settings.check().expect("settings");
                subject.mapping(&screen.display, DVec2::ZERO).expect("a mapping");
            }
        }
    }

    #[test]
    fn the_gazed_pixel_holds_the_gaze() {
        let display = DisplayGeometry::symmetric([4, 3], 60.0);
        let pixel = |x, y| pixel_of(&display, DVec2::new(x, y)).to_array();
        assert_eq!(pixel(0.0, 0.0), [0.5, 0.5]);
        assert_eq!(pixel(4.0, 3.0), [3.5, 2.5]);
        assert_eq!(pixel(1.99, 1.0), [1.5, 1.5]);
        assert!(on_display(&display, DVec2::new(4.0, 0.0)) && !on_display(&display, DVec2::new(4.1, 0.0)));
        assert!(!on_display(&display, DVec2::NAN));
    }
}
