//! The recording that a command writes.

use crate::failure::Failure;
use clap::Args;
use macula_trackers::bids;
use std::path::{Path, PathBuf};

/// Whether what is there may go.
#[derive(Args, Clone, Copy, Debug)]
pub struct ForceArgs {
    /// Replace a recording of that name
    #[arg(long)]
    force: bool,
}

impl ForceArgs {
    /// Fails where a recording of this name is there and must not be replaced.
    ///
    /// # Errors
    /// Then.
    pub fn check(self, path: &Path) -> Result<(), Failure> {
        let there = files(path).into_iter().find(|file| file.exists());
        match there {
            Some(file) if !self.force => Err(Failure::environment(format!(
                "{} is there already; choose another name, or --force replaces it",
                file.display()
            ))),
            _ => Ok(()),
        }
    }
}

/// All files of a recording of this name, whether they are there or not: data, side-car, events and their
/// side-car.
pub fn files(path: &Path) -> [PathBuf; 4] {
    let (data, sidecar) = bids::paths(path);
    let (events, events_sidecar) = bids::event_paths(&data);
    [data, sidecar, events, events_sidecar]
}

/// Those that are there.
pub fn written(path: &Path) -> Vec<PathBuf> {
    files(path).into_iter().filter(|file| file.exists()).collect()
}

/// Their names for a person.
pub fn names(files: &[PathBuf]) -> String {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ")
}
