//! `macula gaze`: trackers, recordings, synthetic eyes and what latency makes of them.

mod convert;
mod devices;
mod events;
mod info;
mod input;
mod latency;
mod model;
mod monitor;
mod predict;
mod prepare;
mod record;
mod session;
mod source;
mod synth;
mod target;

use crate::failure::Failure;
use clap::Subcommand;
pub use input::{GazeFileArgs, ReadArgs};
pub use model::RunArgs;
pub use prepare::{eye_intervals, with_directions};

/// The commands about gaze.
#[derive(Subcommand, Debug)]
pub enum GazeCommand {
    Devices(devices::DevicesArgs),
    Monitor(Box<monitor::MonitorArgs>),
    Record(Box<record::RecordArgs>),
    Info(info::InfoArgs),
    Convert(convert::ConvertArgs),
    Synth(synth::SynthArgs),
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
        GazeCommand::Devices(args) => devices::run(args, json),
        GazeCommand::Monitor(args) => monitor::run(args, json),
        GazeCommand::Record(args) => record::run(args, json),
        GazeCommand::Info(args) => info::run(args, json),
        GazeCommand::Convert(args) => convert::run(args, json),
        GazeCommand::Synth(args) => synth::run(args, json),
        GazeCommand::Events(args) => events::run(args, json),
        GazeCommand::Predict(args) => predict::run(args, json),
        GazeCommand::Latency(args) => latency::run(args, json),
    }
}
