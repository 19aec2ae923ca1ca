//! `macula scene`: generated scenes.

use crate::failure::Failure;
use crate::library;
use crate::options::HallArgs;
use crate::output;
use crate::progress::Steps;
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;

/// Scenes that can be generated.
#[derive(Subcommand, Debug)]
pub enum SceneCommand {
    Hall(HallCommand),
}

/// Write the default scene: a hall with columns, arches, many materials and lights
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula scene hall -o hall.glb\n  \
                        macula scene hall -o large.glb --triangles 2000000 --lights 1000 --seed 7")]
pub struct HallCommand {
    /// The .glb file to write
    #[arg(short, long, value_name = "FILE.glb")]
    output: PathBuf,
    #[command(flatten)]
    hall: HallArgs,
}

/// Runs the command.
///
/// # Errors
/// Options out of range, or a file that cannot be written.
pub fn run(command: &SceneCommand, json: bool) -> Result<(), Failure> {
    let SceneCommand::Hall(args) = command;
    let path = &args.output;
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        return Err(Failure::usage(format!("{}: the hall is written as .glb; name it so", path.display())));
    }
    let options = library::hall_options(&args.hall)?;
    let mut steps = Steps::short(2);
    steps.next("generating the hall");
    let bytes = library::hall_glb(&options)?;
    steps.next("writing");
    library::write_file(path, &bytes)?;
    drop(steps);
    if json {
        return output::print_json(&json!({
            "file": path.display().to_string(),
            "bytes": bytes.len(),
            "triangles": options.triangles,
            "lights": options.lights,
            "seed": options.seed,
            "ranged_lights": options.ranged_lights,
        }));
    }
    output::print(&format!(
        "{}: {} bytes, about {} triangles, {} lights, seed {}\n",
        path.display(),
        output::grouped(bytes.len() as u64),
        output::grouped(options.triangles.into()),
        options.lights,
        options.seed
    ))
}
