//! The command line of macula: parses, calls the library, prints.

mod commands;
mod content;
mod failure;
mod library;
mod measure;
mod options;
mod output;
mod page;
mod progress;
mod shading;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

const AFTER_HELP: &str = "\
Results go to stdout, everything else to stderr. Exit codes: 0 success; 1 a file, the device or the
system is at fault; 2 the command line makes no sense or a setting is out of range.

Examples:
  macula doctor
  macula render hall -o hall.png --gaze 0.3,0.6
  macula bench kfr --sizes 1280x720 --runs 5";

/// Foveated rendering on raw Vulkan: shades where the eye looks, cheaply elsewhere
#[derive(Parser, Debug)]
#[command(name = "macula", version, after_help = AFTER_HELP)]
struct Cli {
    /// Print the result as one JSON document
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Doctor(commands::doctor::DoctorArgs),
    Displays(commands::displays::DisplaysArgs),
    /// Generate scenes
    #[command(subcommand)]
    Scene(commands::scene::SceneCommand),
    Info(commands::info::InfoArgs),
    Compare(commands::compare::CompareArgs),
    Render(Box<commands::render::RenderArgs>),
    /// Measure what foveation saves
    #[command(subcommand)]
    Bench(commands::bench::BenchCommand),
    Map(commands::map::MapArgs),
    Hardcases(commands::hardcases::HardcasesArgs),
    Rates(commands::rates::RatesArgs),
    Sweep(Box<commands::sweep::SweepArgs>),
    Choose(commands::choose::ChooseArgs),
    Replay(Box<commands::replay::ReplayArgs>),
    /// Eye trackers, recorded gaze, synthetic eyes and the latency budget
    #[command(subcommand)]
    Gaze(commands::gaze::GazeCommand),
    Demo(commands::demo::DemoArgs),
}

fn run(cli: &Cli) -> Result<(), Failure> {
    match &cli.command {
        Command::Doctor(args) => commands::doctor::run(args, cli.json),
        Command::Displays(args) => commands::displays::run(args, cli.json),
        Command::Scene(command) => commands::scene::run(command, cli.json),
        Command::Info(args) => commands::info::run(args, cli.json),
        Command::Compare(args) => commands::compare::run(args, cli.json),
        Command::Render(args) => commands::render::run(args, cli.json),
        Command::Bench(command) => commands::bench::run(command, cli.json),
        Command::Map(args) => commands::map::run(args, cli.json),
        Command::Hardcases(args) => commands::hardcases::run(args, cli.json),
        Command::Rates(args) => commands::rates::run(args, cli.json),
        Command::Sweep(args) => commands::sweep::run(args, cli.json),
        Command::Choose(args) => commands::choose::run(args, cli.json),
        Command::Replay(args) => commands::replay::run(args, cli.json),
        Command::Gaze(command) => commands::gaze::run(command, cli.json),
        Command::Demo(args) => commands::demo::run(args, cli.json),
    }
}

/// Help goes to stdout as clap writes it; a usage error becomes one line.
fn parse() -> Result<Cli, Failure> {
    Cli::try_parse().map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // Styled where stdout is a terminal; if it is closed there is no one to tell.
            _ = error.print();
            Failure::StdoutClosed
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Failure::usage("a command is missing; `macula --help` lists them")
        }
        _ => Failure::Usage(usage_line(&error.render().to_string())),
    })
}

/// clap's cause and hints, without the usage text, as one line.
fn usage_line(rendered: &str) -> String {
    let lines = rendered.lines().map(str::trim);
    let told = lines.filter(|line| !line.is_empty()).take_while(|line| !line.starts_with("Usage:"));
    let told = told.filter(|line| !line.starts_with("For more information")).collect::<Vec<_>>().join(" ");
    format!("{}; --help shows the options", told.strip_prefix("error: ").unwrap_or(&told))
}

fn main() -> ExitCode {
    let Err(failure) = parse().and_then(|cli| run(&cli)) else { return ExitCode::SUCCESS };
    if let Some(line) = failure.line() {
        output::note(&line);
    }
    ExitCode::from(failure.exit_code())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn usage_errors_are_one_line() {
        for wrong in [
            vec!["macula", "render"],
            vec!["macula", "render", "hall", "-o", "a.png", "--size", "0x5"],
            vec!["macula", "render", "hall", "-o", "a.png", "--eye", "0,0,0"],
            vec!["macula", "render", "hall", "-o", "a.png", "--camera", "a", "--eye", "0,0,0"],
            vec!["macula", "frobnicate"],
        ] {
            let Err(error) = Cli::try_parse_from(&wrong) else { panic!("{wrong:?} was accepted") };
            let line = usage_line(&error.render().to_string());
            assert!(!line.contains('\n') && !line.starts_with("error") && !line.contains("Usage:"), "{line}");
        }
    }

    #[test]
    fn negative_numbers_are_values() {
        let cli = Cli::try_parse_from([
            "macula",
            "render",
            "hall",
            "-o",
            "a.png",
            "--gaze",
            "-0.2,0.5",
            "--eye",
            "-1,0,0",
            "--look-at",
            "-2,0,0",
            "--beta",
            "-0.5,1.5",
            "--json",
        ]);
        assert!(cli.is_ok_and(|cli| cli.json));
    }
}
