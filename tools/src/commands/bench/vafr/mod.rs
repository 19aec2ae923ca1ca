//! `macula bench vafr`: samples and speed-ups of the acuity-consistent mapping and of the methods that it
//! is compared with, from 2560x1440 to the resolution of the retina.

mod paper;
mod report;
mod run;

use crate::content::{Source, parse_source};
use crate::failure::Failure;
use crate::measure::PairCount;
use crate::options::{parse_hfov, parse_pair, parse_size};
use crate::output;
use crate::shading::{AcuityArgs, MethodName};
use clap::Args;
use glam::DVec2;
use std::time::Duration;

/// Acuity-consistent foveated rendering beside full shading and other methods
///
/// All methods are rendered in turn in one run, each round in the reverse order of the one before, after a
/// warm-up; a speed-up is the median of the rounds' ratios of GPU time to full shading. With the default
/// sizes it takes an hour or more on a software driver: choose sizes, scenes and methods.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula bench vafr --sizes 3840x2160 --methods vafr --rounds 3\n  \
                        macula bench vafr --scenes sdf --sizes 7680x4320 --rounds 1 --json > bench.json")]
pub struct VafrBenchArgs {
    /// Display sizes
    #[arg(long, value_name = "WxH,..", value_delimiter = ',', value_parser = parse_size,
          default_value = "2560x1440,3840x2160,5760x3240,7680x4320,11520x6480")]
    sizes: Vec<[u32; 2]>,
    /// Scenes: hall, sdf, or .gltf and .glb files
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = parse_source, default_value = "hall,sdf")]
    scenes: Vec<Source>,
    /// Methods beside full shading
    #[arg(
        long,
        value_enum,
        value_name = "NAME,..",
        value_delimiter = ',',
        default_value = "vafr,vafr-planar,lafr,kfr"
    )]
    methods: Vec<MethodName>,
    /// Rounds for each row [default: as many as fit 60 seconds, 1 to 7]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rounds: Option<u32>,
    /// Lights of the generated hall
    #[arg(long, value_name = "N", default_value_t = 256)]
    hall_lights: u32,
    /// Triangles of the generated hall
    #[arg(long, value_name = "N", default_value_t = 250_000)]
    triangles: u32,
    /// Samples for each pixel or LP texel of the ray-marched scene, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 16)]
    spp: u32,
    /// Horizontal field of view of the display in degrees, above 0 and below 179 [default: 100; at 11520x6480
    /// and above 120]
    #[arg(long, value_name = "D", value_parser = parse_hfov)]
    hfov_deg: Option<f64>,
    /// Gaze as fractions of the display
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = parse_pair, allow_hyphen_values = true)]
    gaze: DVec2,
    #[command(flatten)]
    acuity: AcuityArgs,
}

impl VafrBenchArgs {
    fn rounds(&self) -> PairCount {
        let within = PairCount::Within { budget: Duration::from_secs(60), least: 1, most: 7 };
        self.rounds.map_or(within, PairCount::Fixed)
    }

    /// The retinal display of the paper is 120 degrees wide, the others 100.
    fn hfov_deg(&self, size: [u32; 2]) -> f64 {
        self.hfov_deg.unwrap_or(if size[0] >= 11520 { 120.0 } else { 100.0 })
    }
}

/// Runs the command.
///
/// # Errors
/// Options out of range, and what loading and rendering report.
pub fn run(args: &VafrBenchArgs, json: bool) -> Result<(), Failure> {
    let results = run::run(args)?;
    for warning in &results.warnings {
        output::note(&format!("warning: {warning}"));
    }
    if json { output::print_json(&results) } else { output::print(&report::text(&results)) }
}
