//! `macula gaze`: trackers, recordings, synthetic eyes and what latency makes of them.

mod info;
mod input;
mod model;

use crate::failure::Failure;
use clap::Subcommand;
pub use input::{GazeFileArgs, ReadArgs};
pub use model::LatencyArgs;

/// The commands about gaze.
#[derive(Subcommand, Debug)]
pub enum GazeCommand {
    Info(info::InfoArgs),
}

/// Runs one.
///
/// # Errors
/// As the command.
pub fn run(command: &GazeCommand, json: bool) -> Result<(), Failure> {
    match command {
        GazeCommand::Info(args) => info::run(args, json),
    }
}
