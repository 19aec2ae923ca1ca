//! `macula bench`: what foveation saves, measured in one run beside full shading.

mod flicker;
mod loaded;
mod paper;
mod report;
mod run;
mod vafr;

use crate::content::{Source, parse_source};
use crate::failure::Failure;
use crate::measure::PairCount;
use crate::options::{KernelArgs, parse_hfov, parse_pair, parse_size};
use crate::output;
use clap::{Args, Subcommand};
use glam::DVec2;
use std::time::Duration;

/// Benchmarks.
#[derive(Subcommand, Debug)]
pub enum BenchCommand {
    Kfr(Box<KfrBenchArgs>),
    Vafr(Box<vafr::VafrBenchArgs>),
    Flicker(Box<flicker::FlickerArgs>),
}

/// Kernel foveated rendering beside full shading, as in the published tables 4.1 and 4.2
///
/// Both are rendered alternately (A B, B A, ...) after a warm-up; a speed-up is the median of the
/// pairs' ratios of GPU time, its spread the least and the greatest ratio. Absolute times mean
/// something on a GPU only; ratios do on a software driver too.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula bench kfr --sizes 1280x720 --runs 5 --no-light-sweep\n  \
                        macula bench kfr --scenes hall --lights 1,64,1000 --json > bench.json")]
pub struct KfrBenchArgs {
    /// Display sizes
    #[arg(long, value_name = "WxH,..", value_delimiter = ',', value_parser = parse_size,
          default_value = "1920x1080,2560x1440,3840x2160")]
    sizes: Vec<[u32; 2]>,
    /// Scenes: hall, sdf, or .gltf and .glb files
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = parse_source, default_value = "hall,sdf")]
    scenes: Vec<Source>,
    /// Pairs for each row [default: as many as fit 45 seconds, 3 to 9]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: Option<u32>,
    /// Lights of the hall in the sweep, which is measured at the first size
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "1,4,16,64,256,1000")]
    lights: Vec<u32>,
    /// Leave the light sweep out
    #[arg(long)]
    no_light_sweep: bool,
    /// Lights of the hall in the other rows
    #[arg(long, value_name = "N", default_value_t = 256)]
    hall_lights: u32,
    /// Triangles of the hall
    #[arg(long, value_name = "N", default_value_t = 250_000)]
    triangles: u32,
    /// Samples for each pixel or LP texel of the ray-marched scene, 1 to 16; the published table has 16
    #[arg(long, value_name = "N", default_value_t = 16)]
    spp: u32,
    /// Horizontal field of view of the display in degrees, above 0 and below 179
    #[arg(long, value_name = "D", default_value = "100", value_parser = parse_hfov)]
    hfov_deg: f64,
    /// Gaze as fractions of the display
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = parse_pair, allow_hyphen_values = true)]
    gaze: DVec2,
    /// Display width over LP-buffer width
    #[arg(long, value_name = "S", default_value_t = 1.8, allow_hyphen_values = true)]
    sigma: f64,
    #[command(flatten)]
    kernel: KernelArgs,
}

impl KfrBenchArgs {
    fn pairs(&self) -> PairCount {
        let within = PairCount::Within { budget: Duration::from_secs(45), least: 3, most: 9 };
        self.runs.map_or(within, PairCount::Fixed)
    }
}

/// Runs the command.
///
/// # Errors
/// Options out of range, and what loading and rendering report.
pub fn run(command: &BenchCommand, json: bool) -> Result<(), Failure> {
    let args = match command {
        BenchCommand::Kfr(args) => args,
        BenchCommand::Vafr(args) => return vafr::run(args, json),
        BenchCommand::Flicker(args) => return flicker::run(args, json),
    };
    let results = run::run(args)?;
    for warning in &results.warnings {
        output::note(&format!("warning: {warning}"));
    }
    if json { output::print_json(&results) } else { output::print(&report::text(&results)) }
}
