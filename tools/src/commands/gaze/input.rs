//! A recording as an argument, with what its file does not say.

use crate::failure::Failure;
use clap::Args;
use glam::DVec2;
use macula_trackers::formats::{self, ReadOptions};
use macula_trackers::recording::{Recording, Screen};
use std::path::PathBuf;

/// A recording.
#[derive(Args, Clone, Debug)]
pub struct GazeFileArgs {
    /// The recording: any known format, recognised by its content
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    #[command(flatten)]
    pub read: ReadArgs,
}

/// What the file does not say, or says wrongly.
#[derive(Args, Clone, Debug, Default)]
pub struct ReadArgs {
    /// Read the recording as this format instead of looking at its content; a wrong name lists all
    #[arg(long, value_name = "NAME")]
    pub format: Option<String>,
    /// Unit of the recording's times, where the file is silent or wrong
    #[arg(long, value_name = "UNIT", value_enum)]
    pub time_unit: Option<TimeUnit>,
    /// The display of recorded points: pixels, millimetres and distance in millimetres, as in
    /// 1920x1080,533x301,565
    #[arg(long, value_name = "PX,MM,DISTANCE", value_parser = parse_screen)]
    pub screen: Option<Screen>,
}

/// Units of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TimeUnit {
    /// Seconds
    S,
    /// Milliseconds
    Ms,
    /// Microseconds
    Us,
    /// Nanoseconds
    Ns,
}

impl TimeUnit {
    fn seconds(self) -> f64 {
        match self {
            Self::S => 1.0,
            Self::Ms => 1e-3,
            Self::Us => 1e-6,
            Self::Ns => 1e-9,
        }
    }
}

fn parse_screen(text: &str) -> Result<Screen, String> {
    let form = || "expected pixels, millimetres and distance, as in 1920x1080,533x301,565".to_owned();
    let parts = text.split(',').map(str::trim).collect::<Vec<_>>();
    let [pixels, millimetres, distance] = parts[..] else { return Err(form()) };
    let pair = |text: &str| {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some(DVec2::new(width.parse().ok()?, height.parse().ok()?))
    };
    let size_px = pair(pixels).ok_or_else(form)?;
    let size_mm = pair(millimetres).ok_or_else(form)?;
    let distance_mm: f64 = distance.parse().map_err(|_| form())?;
    let within = |value: f64, most: f64| value > 0.0 && value <= most;
    let sane = [size_px.x, size_px.y].into_iter().all(|side| within(side, 1e5))
        && [size_mm.x, size_mm.y, distance_mm].into_iter().all(|length| within(length, 1e5));
    sane.then_some(Screen { size_px, size_m: size_mm * 1e-3, distance_m: distance_mm * 1e-3 })
        .ok_or_else(|| "sizes and distance must be above 0 and at most 100000".to_owned())
}

impl ReadArgs {
    /// As the readers want it.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.format.clone(),
            time_unit_s: self.time_unit.map(TimeUnit::seconds),
            screen: self.screen,
        }
    }
}

impl GazeFileArgs {
    /// Reads it.
    ///
    /// # Errors
    /// [`Failure::Environment`] for a file that cannot be read, with what to do.
    pub fn read(&self) -> Result<Recording, Failure> {
        Ok(formats::read(&self.file, &self.read.options())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn screens_are_read_or_refused() {
        let screen = parse_screen("1920x1080, 533x301, 565").expect("a screen");
        assert_eq!(screen.size_px, DVec2::new(1920.0, 1080.0));
        assert!((screen.size_m - DVec2::new(0.533, 0.301)).length() < 1e-12);
        assert!((screen.distance_m - 0.565).abs() < 1e-12);
        for bad in ["", "1920x1080", "1920x1080,533x301", "0x1,1x1,1", "1x1,1x1,-5", "1x1,1x1,nan", "a,b,c"] {
            assert!(parse_screen(bad).is_err(), "{bad}");
        }
    }
}
