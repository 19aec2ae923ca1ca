//! `macula sweep`: what accuracy costs in time.

mod finish;
pub mod folder;
pub mod front;
mod grid;
mod machine;
mod measure;
mod merge;
pub mod record;
mod report;
mod run;
mod table;
mod thumbnail;
mod views;

use crate::content::{CameraArgs, Source, load_environment, neutral_light, parse_source};
use crate::failure::Failure;
use crate::library;
use crate::options::{HallArgs, parse_hfov, parse_size};
use crate::output;
use crate::shading::{AcuityArgs, read_setting};
use clap::{Args, Subcommand};
use folder::Folder;
use grid::{KnobValues, parse_knob};
use macula::fovea::DisplayGeometry;
use macula::headless::GpuContent;
use macula::knobs::Setting;
use record::{Manifest, VERSION};
use run::{Shard, Sweep, parse_shard};
use std::path::PathBuf;
use views::ViewArgs;

/// Render every combination of knobs beside the reference: times, errors, a table and a report
///
/// Setting and reference are rendered alternately in one process, so that a ratio of times holds where clocks
/// and other load drift. Errors are to full shading of the same views with every swept knob at its most
/// accurate value. The folder then holds results.csv with its schema, front.toml, and report.html, one file
/// that needs nothing else. What a killed sweep has finished stays; --resume goes on.
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  macula sweep hall -o sweep\n  \
    macula sweep hall --knob method=kfr,vafr --knob sigma=1:4:0.2 --sizes 1280x720,1920x1080 -o sweep\n  \
    macula sweep scene.glb --gaze-file session.csv --runs 3 -o sweep --resume\n  \
    parallel -j1 macula sweep hall -o part{} --shard {}/4 ::: 1 2 3 4; macula sweep merge part? -o sweep"
)]
pub struct SweepArgs {
    #[command(subcommand)]
    command: Option<SweepCommand>,
    /// A .gltf or .glb file, `hall` (generated) or `sdf:primitives` (ray-marched)
    #[arg(value_name = "SCENE", value_parser = parse_source, required = true)]
    scene: Option<Source>,
    /// Folder for everything that the sweep finds; made if it is missing
    #[arg(short, long, value_name = "FOLDER", required = true)]
    output: Option<PathBuf>,
    /// A knob's values, as in method=kfr,vafr or sigma=1:4:0.5 (from, to, step); several knobs are combined.
    /// [default: 24 settings of all methods]
    #[arg(long = "knob", value_name = "NAME=VALUES", value_parser = parse_knob, help_heading = "Settings")]
    knobs: Vec<KnobValues>,
    /// Values of knobs that stay the same: a TOML file as `macula choose` writes it
    #[arg(long, value_name = "FILE.toml", requires = "knobs", help_heading = "Settings")]
    base: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Settings")]
    acuity: AcuityArgs,
    /// Display sizes
    #[arg(long, value_name = "WxH,..", value_delimiter = ',', value_parser = parse_size, default_value = "1280x720",
          help_heading = "Views")]
    sizes: Vec<[u32; 2]>,
    /// Horizontal field of view of the display in degrees, above 0 and below 179
    #[arg(long, value_name = "D", default_value = "100", value_parser = parse_hfov, help_heading = "Views")]
    hfov_deg: f64,
    #[command(flatten, next_help_heading = "Views")]
    views: ViewArgs,
    /// How often each view is rendered with each setting, beside the reference
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000),
          help_heading = "Measuring")]
    runs: u32,
    /// Go on with the sweep that the folder holds
    #[arg(long, help_heading = "Measuring")]
    resume: bool,
    /// Measure one of N parts only, on a cluster's nodes say; `macula sweep merge` puts them together
    #[arg(long, value_name = "K/N", value_parser = parse_shard, help_heading = "Measuring")]
    shard: Option<Shard>,
    #[command(flatten, next_help_heading = "Scene and camera")]
    camera: CameraArgs,
    /// Environment map: an equirectangular .exr or .hdr file, for sky and ambient light
    #[arg(long, value_name = "FILE", help_heading = "Scene and camera")]
    env: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Scene and camera")]
    hall: HallArgs,
}

/// What else can be done with sweeps.
#[derive(Subcommand, Debug)]
enum SweepCommand {
    Merge(merge::MergeArgs),
}

/// Runs the command.
///
/// # Errors
/// Options that make no sense, and what loading, rendering and writing report.
pub fn run(args: &SweepArgs, json: bool) -> Result<(), Failure> {
    if let Some(SweepCommand::Merge(args)) = &args.command {
        return merge::run(args, json);
    }
    let (Some(scene), Some(output)) = (&args.scene, &args.output) else {
        return Err(Failure::usage("a scene and --output are missing; --help shows the options"));
    };
    let manifest = args.manifest(scene)?;
    let acuity = args.acuity.model()?;
    let folder = Folder::begin(output, &manifest, args.resume || args.shard.is_some())?;
    let mut warnings = Vec::new();
    let subject = scene.open(&args.hall, 0.0)?;
    warnings.extend(subject.scene().map(|scene| scene.warnings.clone()).unwrap_or_default());
    let environment = match &args.env {
        Some(path) => Some(load_environment(path, &mut warnings)?),
        None => neutral_light(&subject, &mut warnings),
    };
    for warning in &warnings {
        output::note(&format!("warning: {warning}"));
    }
    // The validation layer takes time of its own.
    let device = library::device(true)?;
    let content = GpuContent::upload(&device, &subject.content(environment.as_ref()))?;
    let world_from_view = |display: &DisplayGeometry| args.camera.world_from_view(&subject, display);
    let sweep = Sweep {
        folder: &folder,
        manifest: &manifest,
        device: &device,
        content: &content,
        machine: machine::this_machine(&device),
        acuity: &acuity,
        shard: args.shard,
        world_from_view: &world_from_view,
    };
    sweep.run()?;
    finish::finish(&folder, &manifest, json)
}

impl SweepArgs {
    fn manifest(&self, scene: &Source) -> Result<Manifest, Failure> {
        if let (false, Some(name)) = (*scene == Source::Hall, self.hall.given()) {
            return Err(Failure::usage(format!("{name} is for the generated `hall` only; leave it out")));
        }
        for (index, size) in self.sizes.iter().enumerate() {
            DisplayGeometry::symmetric(*size, self.hfov_deg).check()?;
            if self.sizes[..index].contains(size) {
                return Err(Failure::usage("--sizes names a size twice; name it once"));
            }
        }
        let base = self.base.as_ref().map(|path| read_setting(path)).transpose()?.unwrap_or_default();
        let ray_marched = *scene == Source::Sdf;
        let settings = if self.knobs.is_empty() {
            grid::usual_settings(ray_marched)?
        } else {
            grid::settings(&self.knobs, &self.with_method(base.clone())?, ray_marched)?
        };
        Ok(Manifest {
            version: VERSION,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            command: std::env::args().skip(1).collect(),
            scene: self.scene_words(scene),
            sizes: self.sizes.clone(),
            hfov_deg: self.hfov_deg,
            acuity: self.acuity.label(),
            reference: grid::reference(&settings, &base)?,
            base,
            settings,
            views: self.views.views(&DisplayGeometry::symmetric(self.sizes[0], self.hfov_deg))?,
            runs: self.runs,
            fvvdp: false,
        })
    }

    /// As elsewhere, the method is kfr where nothing else is said.
    fn with_method(&self, base: Setting) -> Result<Setting, Failure> {
        let named = base.get("method").is_some() || self.knobs.iter().any(|knob| knob.name == "method");
        if named { Ok(base) } else { Ok(base.with("method", "kfr")?) }
    }

    /// The scene with what makes it another one.
    fn scene_words(&self, scene: &Source) -> String {
        let mut words = scene.name();
        let hall = &self.hall;
        let numbers = [
            ("triangles", hall.triangles.map(u64::from)),
            ("lights", hall.lights.map(u64::from)),
            ("seed", hall.seed),
        ];
        for (name, number) in numbers {
            if let Some(number) = number {
                words += &format!(", {number} {name}");
            }
        }
        if hall.ranged_lights {
            words += ", ranged lights";
        }
        if let Some(camera) = &self.camera.camera {
            words += &format!(", camera {camera}");
        }
        if let (Some(eye), Some(look_at)) = (self.camera.eye, self.camera.look_at) {
            words += &format!(", from {eye} towards {look_at}");
        }
        if let Some(env) = &self.env {
            words += &format!(", lit by {}", env.display());
        }
        words
    }
}
