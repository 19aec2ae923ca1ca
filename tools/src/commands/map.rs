//! `macula map`: the mapping's coordinates of display points.

use crate::failure::Failure;
use crate::library;
use crate::options::{DisplayArgs, KernelArgs, parse_pair};
use crate::output;
use clap::{Args, ValueEnum};
use glam::DVec2;
use macula::fovea::{Kernel, LpCoord};
use macula::headless::{HeadlessDevice, map_points_on_gpu};
use serde::Serialize;
use std::io::{self, BufRead};

/// Points that are mapped and printed at a time: bounds the memory that a long input takes.
const BATCH: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MapMethod {
    /// Kernel foveated rendering.
    Kfr,
}

/// Map display points to log-polar coordinates
///
/// Reads `x,y` lines (display pixels, x right, y down, pixel centres at .5) from standard input and
/// prints a JSON line for each: x, y, u_norm (along the radius) and v_norm (along the angle), both 0
/// to 1. With --json all points come in one document.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  echo 0.5,0.5 | macula map --size 1920x1080 --gaze-px 960,540\n  \
                        macula map --kernel poly --beta 0,0.25,0.25,0.5 --gaze-px 100,900 < points.csv")]
pub struct MapArgs {
    /// The mapping
    #[arg(long, value_enum, default_value = "kfr")]
    method: MapMethod,
    #[command(flatten)]
    kernel: KernelArgs,
    #[command(flatten)]
    display: DisplayArgs,
    /// Gaze in display pixels; off the display is allowed [default: the display's centre]
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true)]
    gaze_px: Option<DVec2>,
    /// Map on the GPU (single precision), by the function that the renderer's passes use
    #[arg(long)]
    gpu: bool,
}

#[derive(Serialize)]
struct MappedPoint {
    x: f64,
    y: f64,
    u_norm: f64,
    v_norm: f64,
}

struct Mapper<'a> {
    args: &'a MapArgs,
    kernel: Kernel,
    gaze_px: DVec2,
    device: Option<HeadlessDevice>,
}

impl Mapper<'_> {
    fn map(&self, points: &[DVec2]) -> Result<Vec<MappedPoint>, Failure> {
        let display = self.args.display.geometry();
        let mapped = match &self.device {
            Some(device) => map_points_on_gpu(device, &display, self.gaze_px, &self.kernel, points)?,
            None => library::map_on_cpu(&display, self.gaze_px, &self.kernel, points),
        };
        let named = |(point, LpCoord { u_norm, v_norm }): (&DVec2, LpCoord)| MappedPoint {
            x: point.x,
            y: point.y,
            u_norm,
            v_norm,
        };
        Ok(points.iter().zip(mapped).map(named).collect())
    }
}

/// Runs the command.
///
/// # Errors
/// A line that is not a point, or what the device reports.
pub fn run(args: &MapArgs, json: bool) -> Result<(), Failure> {
    let MapMethod::Kfr = args.method;
    let kernel = args.kernel.kernel()?;
    args.display.geometry().check()?;
    let centre = DVec2::from_array(args.display.size_px().map(f64::from)) / 2.0;
    let device = if args.gpu { Some(library::device(true)?) } else { None };
    let mapper = Mapper { args, kernel, gaze_px: args.gaze_px.unwrap_or(centre), device };
    let mut all = Vec::new();
    read_points(io::stdin().lock(), |points| {
        let mapped = mapper.map(points)?;
        if json {
            all.extend(mapped);
            return Ok(());
        }
        output::print(&json_lines(&mapped)?)
    })?;
    if !json {
        return Ok(());
    }
    output::print_json(&serde_json::json!({
        "method": "kfr",
        "size": args.display.size_px(),
        "hfov_deg": args.display.hfov_deg(),
        "gaze_px": mapper.gaze_px.to_array(),
        "points": all,
    }))
}

fn json_lines(points: &[MappedPoint]) -> Result<String, Failure> {
    let mut text = String::new();
    for point in points {
        let line = serde_json::to_string(point);
        text += &line.map_err(|error| Failure::environment(format!("a point cannot be printed: {error}")))?;
        text.push('\n');
    }
    Ok(text)
}

/// Calls `take` with batches of the points in `input`; empty lines are skipped.
fn read_points(
    input: impl BufRead,
    mut take: impl FnMut(&[DVec2]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut points = Vec::new();
    for (index, line) in input.lines().enumerate() {
        let number = index + 1;
        let line =
            line.map_err(|error| Failure::environment(format!("standard input, line {number}: {error}")))?;
        if line.trim().is_empty() {
            continue;
        }
        points.push(parse_pair(&line).map_err(|_| {
            let shown = line.chars().take(40).collect::<String>();
            Failure::environment(format!(
                "standard input, line {number}: `{shown}` is not a point; write x,y in pixels, as in 960,540"
            ))
        })?);
        if points.len() == BATCH {
            take(&points)?;
            points.clear();
        }
    }
    if points.is_empty() { Ok(()) } else { take(&points) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points_of(input: &[u8]) -> Result<Vec<DVec2>, Failure> {
        let mut all = Vec::new();
        read_points(input, |points| {
            all.extend_from_slice(points);
            Ok(())
        })?;
        Ok(all)
    }

    #[test]
    fn lines_become_points() {
        let points = points_of(b"1,2\n\n -3.5 , 4e2\r\n");
        assert_eq!(points.ok(), Some(vec![DVec2::new(1.0, 2.0), DVec2::new(-3.5, 400.0)]));
        assert_eq!(points_of(b"").ok(), Some(vec![]));
    }

    #[test]
    fn a_bad_line_is_named() {
        for bad in [&b"1,2\n\n3;4\n"[..], b"1,2\n\n1,2,3\n", b"1,2\n\nnan,1", b"1,2\n\n\xff\xfe"] {
            let Err(failure) = points_of(bad) else { panic!("{bad:?} was accepted") };
            assert_eq!(failure.exit_code(), 1);
            assert!(failure.line().is_some_and(|line| line.contains("line 3: ")), "{failure:?}");
        }
    }

    #[test]
    fn long_inputs_come_in_batches() {
        let input = "1,1\n".repeat(BATCH + 1);
        let mut sizes = Vec::new();
        let result = read_points(input.as_bytes(), |points| {
            sizes.push(points.len());
            Ok(())
        });
        assert!(result.is_ok());
        assert_eq!(sizes, [BATCH, 1]);
    }
}
