//! `macula rates`: how finely a method shades at each eccentricity, beside how finely the eye and the
//! display resolve.

mod analytic;
mod count;
mod edges;
mod gpu;
mod methods;
mod plot;
mod report;
mod sphere;
mod summary;
#[cfg(test)]
mod synthetic;
mod target;
mod totals;

use crate::commands::render::check_folder;
use crate::failure::Failure;
use crate::library;
use crate::options::{EyeName, gaze_px, parse_display, parse_hfov, parse_pair, parse_size, parse_within};
use crate::output;
use crate::shading::{AcuityArgs, MethodName};
use clap::Args;
use glam::{DVec2, DVec3};
use gpu::Gpu;
use macula::fovea::{AcuityModel, DisplayGeometry, DisplayPreset, GazeKeeper, Mapping};
use macula::settings::Method;
use plot::Scale;
use report::{Curve, DisplayNote, GazeNote, Results};
use sphere::Surroundings;
use std::path::PathBuf;
use summary::Summary;
use target::Target;
use totals::Totals;

/// The most gazes of one run, each with a panel of its own.
const MOST_GAZES: usize = 16;

/// Larger displays are not taken, px: pixels are counted one by one.
const MOST_SIDE_PX: u32 = 32_768;

/// Show shading rates over eccentricity, and how many samples they take
///
/// Rates are cycles per degree (a cycle is two samples) away from the gaze (radial) and around it
/// (tangential), over the angle from the gaze ray. They come from the mapping's derivatives, and, to check
/// these, from counting into which texels close points fall. Beside them: the acuity model, the display's
/// own limit, and the number of samples that both together call for.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  macula rates --size 1920x1080,7680x4320 --method kfr,vafr -o rates.svg\n  \
                  macula rates --gaze-deg 0,20,30,40 --method vafr,vafr-planar --json > rates.json\n  \
                  macula rates --display pimax-crystal --gaze 0.3,0.5 --acuity mine.toml"
)]
pub struct RatesArgs {
    /// The methods, with their default parameters
    #[arg(
        long = "method",
        value_enum,
        value_name = "NAME,..",
        value_delimiter = ',',
        default_value = "vafr,vafr-planar,kfr"
    )]
    methods: Vec<MethodName>,
    /// Display sizes in pixels [default: 1920x1080, or the size of --display]
    #[arg(long = "size", value_name = "WxH,..", value_delimiter = ',', value_parser = parse_size)]
    sizes: Vec<[u32; 2]>,
    /// Horizontal field of view of the display in degrees, above 0 and below 179
    #[arg(long, value_name = "D", value_parser = parse_hfov, default_value = "100", conflicts_with = "presets")]
    hfov_deg: f64,
    /// Headsets or monitors by name, as in `macula displays`: their size and their field of view
    #[arg(long = "display", id = "presets", value_name = "PRESET,..", value_delimiter = ',',
          value_parser = parse_display)]
    presets: Vec<&'static DisplayPreset>,
    /// Which eye's field of view of --display [default: left]
    #[arg(long, value_enum, value_name = "EYE", requires = "presets")]
    display_eye: Option<EyeName>,
    /// Gazes to the right of the view axis, degrees, -89 to 89 [default: 0]
    #[arg(long, value_name = "D,..", value_delimiter = ',', value_parser = parse_gaze_deg,
          allow_hyphen_values = true)]
    gaze_deg: Vec<f64>,
    /// Gaze as a fraction of the display; off the display is allowed
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true,
          conflicts_with = "gaze_deg")]
    gaze: Option<DVec2>,
    #[command(flatten)]
    acuity: AcuityArgs,
    /// Distance of the eccentricities, degrees, 0.05 to 10; below the first one they are halved
    #[arg(long, value_name = "D", value_parser = parse_step_deg, default_value = "0.5")]
    step_deg: f64,
    /// Count on the GPU (single precision), by the functions that the renderer's passes use, and count the
    /// samples of a rendered frame. rmfr and guenter3 map whole pixels there, so that their counts are coarse
    #[arg(long)]
    gpu: bool,
    /// Writes the plot
    #[arg(short, long, value_name = "PLOT.svg")]
    output: Option<PathBuf>,
    /// How the rates lie along the plot's y axis
    #[arg(long, value_enum, value_name = "SCALE", default_value = "log")]
    y_scale: Scale,
}

fn parse_gaze_deg(text: &str) -> Result<f64, String> {
    parse_within(text, -89.0, 89.0)
}

fn parse_step_deg(text: &str) -> Result<f64, String> {
    parse_within(text, 0.05, 10.0)
}

/// Runs the command.
///
/// # Errors
/// Options out of range, a broken acuity model, a plot that cannot be written.
pub fn run(args: &RatesArgs, json: bool) -> Result<(), Failure> {
    let displays = args.displays()?;
    if displays.len() * args.methods.len() > plot::MOST_CURVES || args.gaze_deg.len() > MOST_GAZES {
        return Err(Failure::usage(format!(
            "{} methods on {} displays at {} gazes are too many; at most {} methods times displays and \
             {MOST_GAZES} gazes are shown together",
            args.methods.len(),
            displays.len(),
            args.gaze_deg.len().max(1),
            plot::MOST_CURVES
        )));
    }
    if let Some(path) = &args.output {
        check_folder(path)?;
    }
    let acuity = args.acuity.model()?;
    let gpu = if args.gpu { Some(Gpu::new()?) } else { None };
    let results = Results {
        acuity: args.acuity.label(),
        step_deg: args.step_deg,
        deviation_from_deg: summary::DEVIATION_FROM_DEG,
        counted_on: if args.gpu { "GPU" } else { "CPU" },
        curves: args.curves(&displays, &acuity, gpu.as_ref())?,
    };
    if let Some(path) = &args.output {
        library::write_file(path, plot::svg(&results, args.y_scale).as_bytes())?;
    }
    if json { output::print_json(&results) } else { output::print(&report::text(&results)) }
}

/// A display and what it is called.
type Named = (String, DisplayGeometry);

impl RatesArgs {
    /// Every display at every size, checked.
    fn displays(&self) -> Result<Vec<Named>, Failure> {
        let mut displays = vec![];
        for preset in &self.presets {
            let own = [preset.render_px];
            let sizes = if self.sizes.is_empty() { &own[..] } else { &self.sizes };
            for &size in sizes {
                let preset = preset.scaled(size);
                let (eye, display) = match self.display_eye {
                    Some(EyeName::Right) => (", right eye", preset.right()),
                    Some(EyeName::Left) | None => ("", preset.left()),
                };
                displays.push((format!("{} {}x{}{eye}", preset.name, size[0], size[1]), display));
            }
        }
        if self.presets.is_empty() {
            let sizes = if self.sizes.is_empty() { &[[1920, 1080]][..] } else { &self.sizes };
            displays.extend(sizes.iter().map(|size| {
                let label = format!("{}x{} at {} deg", size[0], size[1], self.hfov_deg);
                (label, DisplayGeometry::symmetric(*size, self.hfov_deg))
            }));
        }
        for (label, display) in &displays {
            display.check()?;
            if display.size_px.iter().any(|side| *side > MOST_SIDE_PX) {
                return Err(Failure::usage(format!(
                    "{label} is too large; at most {MOST_SIDE_PX} px a side"
                )));
            }
        }
        Ok(displays)
    }

    /// What the gazes are called; those of one place in the list are one gaze, on whatever display.
    fn gazes(&self) -> Vec<(String, Gaze)> {
        if let Some(fraction) = self.gaze {
            let label = format!("gaze at {},{} of the display", fraction.x, fraction.y);
            return vec![(label, Gaze::Fraction(fraction))];
        }
        let degrees = if self.gaze_deg.is_empty() { &[0.0][..] } else { &self.gaze_deg };
        let label = |deg: f64| match deg {
            0.0 => "gaze along the view axis".to_owned(),
            deg if deg > 0.0 => format!("gaze {deg} degrees to the right"),
            deg => format!("gaze {} degrees to the left", -deg),
        };
        degrees.iter().map(|&deg| (label(deg), Gaze::Degrees(deg))).collect()
    }

    fn curves(
        &self,
        displays: &[Named],
        acuity: &AcuityModel,
        gpu: Option<&Gpu>,
    ) -> Result<Vec<Curve>, Failure> {
        let mut curves = vec![];
        for (gaze_label, gaze) in self.gazes() {
            for (display_label, display) in displays {
                let gaze_px = gaze.px(display)?;
                for &name in &self.methods {
                    let method = name.with_acuity(acuity);
                    let mapping = methods::mapping_of(&method, display, gaze_px);
                    let mapping = mapping.as_ref();
                    let (analytic, counted) = self.rates(mapping, &method, acuity, gpu)?;
                    let frame = gpu.map(|gpu| gpu.frame(mapping, &method)).transpose()?;
                    curves.push(Curve {
                        method: name.name(),
                        display: DisplayNote::new(display_label, display),
                        gaze: GazeNote::new(&gaze_label, display, mapping.gaze_px()),
                        analytic,
                        counted,
                        totals: Totals::of(mapping, acuity, frame),
                    });
                }
            }
        }
        Ok(curves)
    }

    /// Rates from the derivatives, and counted.
    fn rates(
        &self,
        mapping: &dyn Mapping,
        method: &Method,
        acuity: &AcuityModel,
        gpu: Option<&Gpu>,
    ) -> Result<(Summary, Summary), Failure> {
        let target = Target::new(mapping, acuity);
        let around = Surroundings::new(*mapping.display(), mapping.gaze_px());
        let eccs_deg = around.eccentricities_deg(self.step_deg);
        let mut on_cpu = |points: &[DVec2]| Ok(points.iter().map(|&px| mapping.forward(px)).collect());
        let mut on_gpu = gpu.map_or(Ok(None), |gpu| gpu.forward(mapping, method))?;
        let forward = on_gpu.as_deref_mut().unwrap_or(&mut on_cpu);
        let counted = count::rates(mapping, &target, &eccs_deg, forward)?;
        Ok((analytic::rates(mapping, &target, &eccs_deg), counted))
    }
}

/// Where the eye looks, before a display.
#[derive(Clone, Copy, Debug)]
enum Gaze {
    /// Of the display.
    Fraction(DVec2),
    /// To the right of the view axis.
    Degrees(f64),
}

impl Gaze {
    /// On a display, at most [`macula::fovea::MAX_GAZE_PX`] away.
    fn px(self, display: &DisplayGeometry) -> Result<DVec2, Failure> {
        let px = match self {
            Self::Fraction(fraction) => gaze_px(fraction, display.size_px),
            Self::Degrees(deg) => {
                let (sine, cosine) = deg.to_radians().sin_cos();
                display.px_of_ray(DVec3::new(sine, 0.0, -cosine)).unwrap_or(DVec2::NAN)
            }
        };
        match GazeKeeper::new(display.center_px()).accept(px) {
            (px, true) => Ok(px),
            _ => Err(Failure::usage("the gaze does not meet the display's plane; choose one nearer to it")),
        }
    }
}
