//! `macula map`: the mapping's coordinates of display points.

use crate::failure::Failure;
use crate::library;
use crate::options::{DisplayArgs, KernelArgs, parse_pair};
use crate::output;
use crate::shading::{AcuityArgs, MethodName};
use clap::Args;
use glam::DVec2;
use macula::fovea::{Kernel, LpCoord, Mapping};
use macula::headless::{GpuMapping, HeadlessDevice, map_points_on_gpu};
use macula::settings::{Method, RenderSettings};
use serde::Serialize;
use std::io::{self, BufRead};

/// Points that are mapped and printed at a time: bounds the memory that a long input takes.
const BATCH: usize = 1 << 16;

/// Map display points to the LP-buffer's coordinates
///
/// Reads `x,y` lines (display pixels, x right, y down, pixel centres at .5) from standard input and
/// prints a JSON line for each. kfr: x, y, u_norm (along the radius) and v_norm (along the angle), both 0
/// to 1. Other methods: x, y, ecc_deg (eccentricity as an angle between rays), u (texels), height (texels
/// of the column there, before rounding), v (texels) and native (the pixel is shaded itself); u, height
/// and v are null where the method has no texels. With --json all points come in one document.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  echo 0.5,0.5 | macula map --size 1920x1080 --gaze-px 960,540\n  \
                        macula map --kernel poly --beta 0,0.25,0.25,0.5 --gaze-px 100,900 < points.csv\n  \
                        macula map --method vafr --display vive-pro-eye < points.csv")]
pub struct MapArgs {
    /// The mapping
    #[arg(long, value_enum, value_name = "NAME", default_value = "kfr")]
    method: MethodName,
    #[command(flatten)]
    kernel: KernelArgs,
    #[command(flatten)]
    acuity: AcuityArgs,
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
#[serde(untagged)]
enum MappedPoint {
    /// By kernels.
    Shares { x: f64, y: f64, u_norm: f64, v_norm: f64 },
    /// By the other methods.
    Texels { x: f64, y: f64, ecc_deg: f64, u: Option<f64>, height: Option<f64>, v: Option<f64>, native: bool },
}

enum Mapper {
    Kernel(Kernel),
    KernelOnGpu(Kernel, HeadlessDevice),
    Any(Box<dyn Mapping>),
    AnyOnGpu(Box<dyn Mapping>, Box<GpuMapping>),
}

struct Job<'a> {
    args: &'a MapArgs,
    gaze_px: DVec2,
    mapper: Mapper,
}

impl<'a> Job<'a> {
    fn new(args: &'a MapArgs) -> Result<Self, Failure> {
        let display = args.display.geometry();
        display.check()?;
        let gaze_px = args.gaze_px.unwrap_or(display.center_px());
        let device = if args.gpu { Some(library::device(true)?) } else { None };
        if args.method == MethodName::Kfr {
            if let Some(name) = args.acuity.given() {
                return Err(Failure::usage(format!("{name} has no meaning with --method kfr; leave it out")));
            }
            let kernel = args.kernel.kernel()?;
            let mapper = match device {
                Some(device) => Mapper::KernelOnGpu(kernel, device),
                None => Mapper::Kernel(kernel),
            };
            return Ok(Self { args, gaze_px, mapper });
        }
        if let Some(name) = args.kernel.given() {
            let method = args.method.name();
            return Err(Failure::usage(format!(
                "{name} has no meaning with --method {method}; leave it out"
            )));
        }
        let method: Method = args.method.with_acuity(&args.acuity.model()?);
        let mapping = method.mapping(&display, gaze_px).ok_or_else(|| {
            Failure::usage("full shading maps nothing; choose a foveated method with --method")
        })?;
        let mapper = match device {
            Some(device) => {
                let on_gpu = GpuMapping::new(&device, &RenderSettings::new(display, method))?;
                Mapper::AnyOnGpu(mapping, Box::new(on_gpu))
            }
            None => Mapper::Any(mapping),
        };
        Ok(Self { args, gaze_px, mapper })
    }

    fn map(&mut self, points: &[DVec2]) -> Result<Vec<MappedPoint>, Failure> {
        let display = self.args.display.geometry();
        let shares = |(point, LpCoord { u_norm, v_norm }): (&DVec2, LpCoord)| MappedPoint::Shares {
            x: point.x,
            y: point.y,
            u_norm,
            v_norm,
        };
        match &mut self.mapper {
            Mapper::Kernel(kernel) => {
                let mapped = library::map_on_cpu(&display, self.gaze_px, kernel, points);
                Ok(points.iter().zip(mapped).map(shares).collect())
            }
            Mapper::KernelOnGpu(kernel, device) => {
                let mapped = map_points_on_gpu(device, &display, self.gaze_px, kernel, points)?;
                Ok(points.iter().zip(mapped).map(shares).collect())
            }
            Mapper::Any(mapping) => Ok(points.iter().map(|px| texels(mapping.as_ref(), *px)).collect()),
            Mapper::AnyOnGpu(mapping, on_gpu) => {
                let mapped = on_gpu.forward(self.gaze_px, points)?;
                let place = |(px, at): (&DVec2, macula::headless::MappedPoint)| MappedPoint::Texels {
                    x: px.x,
                    y: px.y,
                    ecc_deg: display.eccentricity_rad(mapping.gaze_px(), *px).to_degrees(),
                    u: Some(at.point.u),
                    height: Some(mapping.column_height(at.point.u)),
                    v: Some(at.point.v_share * mapping.column_height(at.point.u)),
                    native: at.past_native <= 0.0,
                };
                Ok(points.iter().zip(mapped).map(place).collect())
            }
        }
    }
}

fn texels(mapping: &dyn Mapping, px: DVec2) -> MappedPoint {
    let point = mapping.forward(px);
    let height = point.map(|point| mapping.column_height(point.u));
    MappedPoint::Texels {
        x: px.x,
        y: px.y,
        ecc_deg: mapping.display().eccentricity_rad(mapping.gaze_px(), px).to_degrees(),
        u: point.map(|point| point.u),
        height,
        v: point.zip(height).map(|(point, height)| point.v_share * height),
        native: mapping.is_native(px),
    }
}

/// Runs the command.
///
/// # Errors
/// A line that is not a point, or what the device reports.
pub fn run(args: &MapArgs, json: bool) -> Result<(), Failure> {
    let mut job = Job::new(args)?;
    let mut all = Vec::new();
    read_points(io::stdin().lock(), |points| {
        let mapped = job.map(points)?;
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
        "method": args.method.name(),
        "size": args.display.size_px(),
        "hfov_deg": args.display.hfov_deg(),
        "gaze_px": job.gaze_px.to_array(),
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
