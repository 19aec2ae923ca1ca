//! `macula gaze`: trackers, recordings, synthetic eyes and what latency makes of them.

mod events;
mod info;
mod input;
mod latency;
mod predict;
mod prepare;

use crate::failure::Failure;
use clap::Subcommand;
pub use input::GazeFileArgs;

/// The commands about gaze.
#[derive(Subcommand, Debug)]
pub enum GazeCommand {
    Info(info::InfoArgs),
    Events(events::EventsArgs),
    Predict(predict::PredictArgs),
    Latency(Box<latency::LatencyArgs>),
}

/// Runs one.
///
/// # Errors
/// As the command.
pub fn run(command: &GazeCommand, json: bool) -> Result<(), Failure> {
    match command {
        GazeCommand::Info(args) => info::run(args, json),
        GazeCommand::Events(args) => events::run(args, json),
        GazeCommand::Predict(args) => predict::run(args, json),
        GazeCommand::Latency(args) => latency::run(args, json),
    }
}
