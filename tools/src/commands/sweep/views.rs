//! What is rendered with every setting: gazes, a slow move of the camera, a slow move of the gaze.

use super::record::{Path, View};
use crate::commands::gaze::{ReadArgs, with_directions};
use crate::content::moved;
use crate::failure::Failure;
use crate::options::{gaze_px, parse_pair};
use clap::Args;
use glam::{DMat4, DVec2};
use macula::fovea::DisplayGeometry;
use macula::headless::FrameInput;
use macula_trackers::formats;
use macula_trackers::recording::Recording;
use std::path::PathBuf;

/// From frame to frame of the camera's move: as much as a head that tries to keep still.
const YAW_STEP_DEG: f64 = 0.05;
const MOVE_STEP_MM: f64 = 2.0;
/// From frame to frame of the gaze's move, as a share of the display's width: a pursuit of about 30 degrees
/// a second at 90 Hz on a display of 100 degrees.
const GAZE_STEP: f64 = 1.0 / 300.0;
/// Seconds from frame to frame of a recorded gaze's move: a display's refresh.
const REFRESH_S: f64 = 1.0 / 90.0;

/// Where the eye is and looks.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// Gaze as fractions of the display, from the left and from the top
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = parse_pair, allow_hyphen_values = true,
          conflicts_with_all = ["gaze_grid", "gaze_file"])]
    gaze: DVec2,
    /// N times N gazes spread over the display, 1 to 16
    #[arg(long, value_name = "N", conflicts_with = "gaze_file", value_parser = clap::value_parser!(u32).range(1..=16))]
    gaze_grid: Option<u32>,
    /// Gazes of a recorded session, of any known format
    #[arg(long, value_name = "FILE")]
    gaze_file: Option<PathBuf>,
    /// How many gazes are taken from --gaze-file, evenly spread over its time
    #[arg(long, value_name = "N", default_value_t = 4, requires = "gaze_file", value_parser = clap::value_parser!(u32).range(1..=1000))]
    gazes: u32,
    #[command(flatten)]
    read: ReadArgs,
    /// Frames of the slow moves of camera and gaze, from which the change over time is taken; 0 leaves it
    /// out
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = parse_move_frames)]
    move_frames: u32,
}

fn parse_move_frames(text: &str) -> Result<u32, String> {
    let frames = text.parse().ok().filter(|frames| *frames == 0 || (2..=1000).contains(frames));
    frames.ok_or_else(|| "expected 0, or 2 to 1000 frames".into())
}

impl ViewArgs {
    /// The views, gazes first.
    ///
    /// # Errors
    /// A recording that cannot be read or has no gaze on the display.
    pub fn views(&self, display: &DisplayGeometry) -> Result<Vec<View>, Failure> {
        let [gazes, moved] = match (&self.gaze_file, self.gaze_grid) {
            (Some(file), _) => {
                let recording = with_directions(formats::read(file, &self.read.options())?)?;
                let on_display = on_display(&recording, display);
                if on_display.is_empty() {
                    return Err(Failure::environment(format!(
                        "{}: no gaze of the recording lies on this display; give a larger --hfov-deg",
                        file.display()
                    )));
                }
                let gazes = spread(&on_display, self.gazes as usize);
                [gazes, following(&on_display, self.move_frames)]
            }
            (None, Some(side)) => {
                let gazes = grid(side);
                let first = gazes[gazes.len() / 2];
                [gazes, pursuit(first, self.move_frames)]
            }
            (None, None) => [vec![self.gaze], pursuit(self.gaze, self.move_frames)],
        };
        let still = |path, gaze: DVec2| View { path, gaze: gaze.to_array(), yaw_deg: 0.0, step_mm: 0.0 };
        let mut views: Vec<_> = gazes.iter().map(|&gaze| still(Path::Gaze, gaze)).collect();
        // The moves begin at the first gaze of theirs.
        let start = moved.first().copied().unwrap_or(gazes[0]);
        views.extend((0..self.move_frames).map(|frame| View {
            yaw_deg: f64::from(frame) * YAW_STEP_DEG,
            step_mm: f64::from(frame) * MOVE_STEP_MM,
            ..still(Path::Camera, start)
        }));
        views.extend(moved.iter().map(|&gaze| still(Path::GazeMove, gaze)));
        Ok(views)
    }
}

/// The middles of N times N parts of the display.
fn grid(side: u32) -> Vec<DVec2> {
    let at = |index: u32| (f64::from(index) + 0.5) / f64::from(side);
    (0..side * side).map(|index| DVec2::new(at(index % side), at(index / side))).collect()
}

/// A gaze that moves to the right.
fn pursuit(from: DVec2, frames: u32) -> Vec<DVec2> {
    (0..frames).map(|frame| from + DVec2::X * (GAZE_STEP * f64::from(frame))).collect()
}

/// Times in seconds, and gazes as fractions of the display.
fn on_display(recording: &Recording, display: &DisplayGeometry) -> Vec<(f64, DVec2)> {
    let size = DVec2::from_array(display.size_px.map(f64::from));
    let at = |sample: macula_trackers::sample::GazeSample| {
        let (direction, _) = sample.gaze_direction()?;
        let gaze = display.px_of_ray(direction)? / size;
        let inside = gaze.cmpge(DVec2::ZERO).all() && gaze.cmple(DVec2::ONE).all();
        inside.then_some((sample.time_ns as f64 * 1e-9, gaze))
    };
    recording.samples().filter_map(at).collect()
}

fn spread(samples: &[(f64, DVec2)], count: usize) -> Vec<DVec2> {
    let count = count.min(samples.len());
    (0..count).map(|index| samples[(2 * index + 1) * samples.len() / (2 * count)].1).collect()
}

/// The gaze at successive refreshes from the middle of the session on.
fn following(samples: &[(f64, DVec2)], frames: u32) -> Vec<DVec2> {
    let middle = samples.len() / 2;
    let begin_s = samples[middle].0;
    let at = |frame: u32| {
        let wanted_s = begin_s + f64::from(frame) * REFRESH_S;
        let after = samples[middle..].iter().take_while(|(time_s, _)| *time_s <= wanted_s).last();
        after.map_or(samples[middle].1, |(_, gaze)| *gaze)
    };
    (0..frames).map(at).collect()
}

/// A view as the renderer takes it.
pub fn frame_input(view: &View, world_from_view: DMat4, display: &DisplayGeometry) -> FrameInput {
    FrameInput {
        world_from_view: moved(world_from_view, view.yaw_deg, view.step_mm),
        gaze_px: gaze_px(DVec2::from_array(view.gaze), display.size_px),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_lies_evenly_on_the_display() {
        assert_eq!(grid(1), [DVec2::splat(0.5)]);
        let two = grid(2);
        assert_eq!((two.len(), two[1]), (4, DVec2::new(0.75, 0.25)));
    }

    #[test]
    fn a_recordings_gazes_are_spread_over_its_time() {
        let samples: Vec<_> =
            (0..100).map(|i| (f64::from(i) / 90.0, DVec2::splat(f64::from(i) / 100.0))).collect();
        let x =
            |gazes: Vec<DVec2>| gazes.iter().map(|gaze| (gaze.x * 100.0).round() as i32).collect::<Vec<_>>();
        assert_eq!(x(spread(&samples, 4)), [12, 37, 62, 87]);
        assert_eq!(spread(&samples[..2], 4).len(), 2);
        // A hair after each refresh, so that rounding does not decide.
        let nudged: Vec<_> = samples.iter().map(|&(time_s, gaze)| (time_s - 1e-6, gaze)).collect();
        assert_eq!(x(following(&nudged, 3)), [50, 51, 52]);
        assert_eq!(x(following(&nudged[..51], 3)), [25, 26, 27]);
    }

    #[test]
    fn numbers_of_frames_are_read_or_refused() {
        assert_eq!((parse_move_frames("0"), parse_move_frames("2")), (Ok(0), Ok(2)));
        assert!(parse_move_frames("1").is_err() && parse_move_frames("-3").is_err());
    }
}
