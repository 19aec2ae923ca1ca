//! Options that several commands share, and how their values are read.

use crate::failure::Failure;
use crate::library;
use clap::{Args, ValueEnum};
use glam::{DVec2, DVec3};
use macula::fovea::{DisplayGeometry, DisplayPreset, Kernel};

/// `WxH`.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(width, height)| [width, height].map(str::parse::<u32>));
    match sides {
        Some([Ok(0), Ok(_)] | [Ok(_), Ok(0)]) => Err("both sides must be at least 1 px".into()),
        Some([Ok(width), Ok(height)]) => Ok([width, height]),
        _ => Err("expected WxH in pixels, as in 1920x1080".into()),
    }
}

fn parse_numbers<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f64>()).collect::<Result<Vec<_>, _>>();
    let numbers = numbers.ok().filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    let numbers = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("expected {N} finite numbers, as in {form}"))
}

/// `X,Y`.
pub fn parse_pair(text: &str) -> Result<DVec2, String> {
    parse_numbers::<2>(text, "0.5,0.5").map(DVec2::from_array)
}

/// `x,y,z`.
pub fn parse_point(text: &str) -> Result<DVec3, String> {
    parse_numbers::<3>(text, "0,1.6,4").map(DVec3::from_array)
}

/// A horizontal field of view in degrees.
pub fn parse_hfov(text: &str) -> Result<f64, String> {
    let degrees = text.parse::<f64>().ok().filter(|degrees| *degrees > 0.0 && *degrees < 179.0);
    degrees.ok_or_else(|| "expected degrees, above 0 and below 179".into())
}

/// A number within bounds.
pub fn parse_within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("expected a number from {low} to {high}"))
}

/// A display's preset.
pub fn parse_display(text: &str) -> Result<&'static DisplayPreset, String> {
    DisplayPreset::by_name(text).ok_or_else(|| {
        let names = DisplayPreset::all().iter().map(|preset| preset.name).collect::<Vec<_>>();
        format!("known are {}; `macula displays` shows them", names.join(", "))
    })
}

/// One of the two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EyeName {
    Left,
    Right,
}

/// Without a preset.
const DEFAULT_SIZE_PX: [u32; 2] = [1920, 1080];
const DEFAULT_HFOV_DEG: f64 = 100.0;

/// The display that one renders for.
#[derive(Args, Clone, Debug, Default)]
pub struct DisplayArgs {
    /// Display size in pixels [default: 1920x1080, or the size of --display]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Horizontal field of view of the display in degrees, above 0 and below 179 [default: 100]
    #[arg(long, value_name = "D", value_parser = parse_hfov, conflicts_with = "preset")]
    pub hfov_deg: Option<f64>,
    /// A headset or a monitor by name, as in `macula displays`: its size and its field of view
    #[arg(long = "display", id = "preset", value_name = "PRESET", value_parser = parse_display)]
    pub preset: Option<&'static DisplayPreset>,
    /// Which eye's field of view of --display [default: left]
    #[arg(long, value_enum, value_name = "EYE", requires = "preset")]
    pub display_eye: Option<EyeName>,
}

impl DisplayArgs {
    /// The display's geometry.
    pub fn geometry(&self) -> DisplayGeometry {
        let Some(preset) = self.preset else {
            let hfov_deg = self.hfov_deg.unwrap_or(DEFAULT_HFOV_DEG);
            return DisplayGeometry::symmetric(self.size.unwrap_or(DEFAULT_SIZE_PX), hfov_deg);
        };
        let preset = preset.scaled(self.size.unwrap_or(preset.render_px));
        match self.display_eye {
            Some(EyeName::Right) => preset.right(),
            Some(EyeName::Left) | None => preset.left(),
        }
    }

    /// Width and height, px.
    pub fn size_px(&self) -> [u32; 2] {
        self.geometry().size_px
    }

    /// The horizontal field of view, degrees.
    pub fn hfov_deg(&self) -> f64 {
        match self.preset {
            None => self.hfov_deg.unwrap_or(DEFAULT_HFOV_DEG),
            Some(_) => {
                let display = self.geometry();
                (display.tan_right.atan() - display.tan_left.atan()).to_degrees()
            }
        }
    }
}

/// A fraction of the display as display pixels.
pub fn gaze_px(gaze: DVec2, size: [u32; 2]) -> DVec2 {
    gaze * DVec2::from_array(size.map(f64::from))
}

/// The kernel functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KernelName {
    /// x^alpha
    Pow,
    /// Sum of beta_i x^i
    Poly,
    /// sin(pi x / 2)
    Sin,
    /// (e^x - 1)/(e - 1)
    Exp,
}

/// What the thesis' user study chose.
const DEFAULT_ALPHA: f64 = 4.0;

/// Which kernel, with its parameters.
#[derive(Args, Clone, Debug)]
pub struct KernelArgs {
    /// Kernel function, which spreads the LP-buffer's columns over the radius [default: pow]
    #[arg(long, value_enum, value_name = "NAME")]
    pub kernel: Option<KernelName>,
    /// Exponent of the kernel pow, 1 to 6: more samples at the edge, fewer at the fovea [default: 4]
    #[arg(long, value_name = "A", allow_hyphen_values = true)]
    pub alpha: Option<f64>,
    /// Coefficients of the kernel poly from beta_0 (0) on, with sum 1, as in 0,0.25,0.25,0.5
    #[arg(long, value_name = "B0,B1,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub beta: Option<Vec<f64>>,
}

impl KernelArgs {
    /// The first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            (self.kernel.is_some(), "--kernel"),
            (self.alpha.is_some(), "--alpha"),
            (self.beta.is_some(), "--beta"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }

    /// The kernel in words.
    pub fn label(&self) -> String {
        match (self.kernel.unwrap_or(KernelName::Pow), &self.beta) {
            (KernelName::Pow, _) => format!("pow, alpha {}", self.alpha.unwrap_or(DEFAULT_ALPHA)),
            (KernelName::Poly, beta) => format!("poly, beta {:?}", beta.as_deref().unwrap_or_default()),
            (KernelName::Sin, _) => "sin".into(),
            (KernelName::Exp, _) => "exp".into(),
        }
    }

    /// The kernel, checked.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a parameter that belongs to another kernel or is out of range.
    pub fn kernel(&self) -> Result<Kernel, Failure> {
        let name = self.kernel.unwrap_or(KernelName::Pow);
        if self.alpha.is_some() && name != KernelName::Pow {
            return Err(Failure::usage("--alpha belongs to --kernel pow; leave one of the two out"));
        }
        if self.beta.is_some() && name != KernelName::Poly {
            return Err(Failure::usage("--beta belongs to --kernel poly; add that or leave --beta out"));
        }
        let kernel = match (name, &self.beta) {
            (KernelName::Pow, _) => Kernel::Power { alpha: self.alpha.unwrap_or(DEFAULT_ALPHA) },
            (KernelName::Sin, _) => Kernel::Sine,
            (KernelName::Exp, _) => Kernel::Exponential,
            (KernelName::Poly, Some(beta)) => library::polynomial(beta)?,
            (KernelName::Poly, None) => {
                return Err(Failure::usage(
                    "--kernel poly needs its coefficients; add --beta, as in --beta 0,0.25,0.25,0.5",
                ));
            }
        };
        kernel.check()?;
        Ok(kernel)
    }
}

/// The generated scene's size.
#[derive(Args, Clone, Debug, Default)]
pub struct HallArgs {
    /// Triangles of the generated hall, about, 10000 to 5000000 [default: 250000]
    #[arg(long, value_name = "N")]
    pub triangles: Option<u32>,
    /// Lights of the generated hall, 1 to 1000 [default: 256]
    #[arg(long, value_name = "N")]
    pub lights: Option<u32>,
    /// Seed of the generated hall: the same seed gives the same bytes [default: 1]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Lamps of the generated hall end at 8 to 14 m; otherwise each reaches every surface
    #[arg(long)]
    pub ranged_lights: bool,
}

impl HallArgs {
    /// The first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            (self.triangles.is_some(), "--triangles"),
            (self.lights.is_some(), "--lights"),
            (self.seed.is_some(), "--seed"),
            (self.ranged_lights, "--ranged-lights"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_or_refused() {
        assert_eq!(parse_size("1920x1080"), Ok([1920, 1080]));
        for bad in ["", "1920", "0x5", "5x0", "-3x4", "1x2x3", "4294967296x1", "axb"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn points_are_read_or_refused() {
        assert_eq!(parse_pair("-0.25, 1e-1"), Ok(DVec2::new(-0.25, 0.1)));
        assert_eq!(parse_point("1,2,-3"), Ok(DVec3::new(1.0, 2.0, -3.0)));
        for bad in ["", "1", "1,2,3", "nan,1", "inf,0", "1;2"] {
            assert!(parse_pair(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn fields_of_view_are_read_or_refused() {
        assert_eq!(parse_hfov("100"), Ok(100.0));
        for bad in ["0", "-10", "179", "400", "nan", "wide"] {
            assert!(parse_hfov(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_size_changes_the_pixels_of_a_preset_and_not_its_frustum() {
        assert_eq!(DisplayArgs::default().geometry(), DisplayGeometry::symmetric([1920, 1080], 100.0));
        let crystal = parse_display("pimax-crystal").expect("a preset");
        let full = DisplayArgs { preset: Some(crystal), ..DisplayArgs::default() };
        assert_eq!(full.geometry(), crystal.left());
        let right = DisplayArgs { display_eye: Some(EyeName::Right), size: Some([64, 80]), ..full.clone() };
        assert_eq!(right.geometry(), DisplayGeometry { size_px: [64, 80], ..crystal.right() });
        assert_eq!(right.size_px(), [64, 80]);
        // 51.65 + 41.65 degrees by the database that the frustum is from.
        assert!((full.hfov_deg() - 93.31).abs() < 0.01 && (right.hfov_deg() - 93.31).abs() < 0.01);
        assert!(parse_display("vive").is_err_and(|message| message.contains("vive-pro-eye")));
    }

    fn kernel_args(kernel: Option<KernelName>, alpha: Option<f64>, beta: Option<Vec<f64>>) -> KernelArgs {
        KernelArgs { kernel, alpha, beta }
    }

    #[test]
    fn kernels_take_only_their_own_parameters() {
        let default = kernel_args(None, None, None);
        assert_eq!(default.given(), None);
        assert!(matches!(default.kernel(), Ok(Kernel::Power { alpha: 4.0 })));
        let sine = kernel_args(Some(KernelName::Sin), None, None);
        assert!(matches!(sine.kernel(), Ok(Kernel::Sine)));
        for wrong in [
            kernel_args(Some(KernelName::Sin), Some(2.0), None),
            kernel_args(None, None, Some(vec![0.0, 1.0])),
            kernel_args(Some(KernelName::Poly), None, None),
            kernel_args(Some(KernelName::Exp), None, Some(vec![0.0, 1.0])),
        ] {
            assert!(matches!(wrong.kernel(), Err(Failure::Usage(_))), "{wrong:?}");
            assert!(wrong.given().is_some());
        }
    }
}
