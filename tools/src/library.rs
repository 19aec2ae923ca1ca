//! The library as the commands use it: one function for each thing that they ask of it.

use crate::failure::Failure;
use crate::options::HallArgs;
use glam::DVec2;
use macula::fovea::{AcuityModel, DisplayGeometry, Kernel, KfrMapping, LpCoord};
use macula::headless::{self, DeviceOptions, DeviceReport, HeadlessDevice};
use macula::io::image_file;
use macula::quality::acuity_error::{self, AcuityError};
use macula::quality::compare::{self, Comparison};
use macula::quality::picture::Picture;
use macula::scene::Scene;
use macula::scene::hall::{self, HallOptions};
use macula::scene::load::{LoadOptions, load};
use std::path::Path;

/// A kernel of given polynomial coefficients.
pub fn polynomial(beta: &[f64]) -> Result<Kernel, Failure> {
    Ok(Kernel::polynomial(beta)?)
}

/// A scene file at a time in seconds.
pub fn load_scene(path: &Path, time_s: f64) -> Result<Scene, Failure> {
    Ok(load(path, &LoadOptions { time_s, ..LoadOptions::default() })?)
}

/// The generated hall's options.
pub fn hall_options(args: &HallArgs) -> Result<HallOptions, Failure> {
    let default = HallOptions::default();
    let options = HallOptions {
        triangles: args.triangles.unwrap_or(default.triangles),
        lights: args.lights.unwrap_or(default.lights),
        seed: args.seed.unwrap_or(default.seed),
        ranged_lights: args.ranged_lights,
    };
    options.check()?;
    Ok(options)
}

/// The generated hall as a .glb file's bytes.
pub fn hall_glb(options: &HallOptions) -> Result<Vec<u8>, Failure> {
    Ok(hall::generate_glb(options)?)
}

/// The generated hall, loaded like any other file.
pub fn hall_scene(options: &HallOptions) -> Result<Scene, Failure> {
    let folder = tempfile::tempdir()
        .map_err(|error| Failure::environment(format!("no temporary folder: {error}; check TMPDIR")))?;
    let path = folder.path().join("hall.glb");
    write_file(&path, &hall_glb(options)?)?;
    load_scene(&path, 0.0)
}

/// Writes a file that appears under its name only when it is whole.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(image_file::write_atomically(path, |file| file.write_all(bytes))?)
}

/// As [`write_file`], for what is written piece by piece.
pub fn write_with(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> std::io::Result<()>,
) -> Result<(), Failure> {
    Ok(image_file::write_atomically(path, write)?)
}

/// Pixels per degree that FLIP takes where no display is given: 3840 px on 0.7 m, seen from 0.7 m.
pub const FLIP_PIXELS_PER_DEGREE: f32 = 67.02;

/// Compares two RGBA pictures of one size; with a display and a gaze also by eccentricity.
pub fn compare_pictures(
    a: &[u8],
    b: &[u8],
    size: [u32; 2],
    eye: Option<(&DisplayGeometry, DVec2)>,
) -> Result<Comparison, Failure> {
    let (a, b) = (compare::rgb_of_rgba(a), compare::rgb_of_rgba(b));
    if let Some((display, gaze_px)) = eye {
        return Ok(compare::compare(&a, &b, display, gaze_px)?);
    }
    Ok(Comparison {
        psnr_db: compare::psnr_db(&a, &b)?,
        flip: compare::flip_mean(&a, &b, size, FLIP_PIXELS_PER_DEGREE)?,
        psnr_within_5_deg_db: None,
        rings: Vec::new(),
    })
}

/// The acuity-surviving error of two RGBA pictures that fill a display, by the default acuity model.
pub fn acuity_error(
    a: &[u8],
    b: &[u8],
    (display, gaze_px): (&DisplayGeometry, DVec2),
) -> Result<AcuityError, Failure> {
    let (a, b) = (compare::rgb_of_rgba(a), compare::rgb_of_rgba(b));
    let acuity = AcuityModel::default();
    let cutoff_cpd = |ecc_deg| acuity.cpd(ecc_deg);
    Ok(acuity_error::acuity_error(Picture::Srgb8(&a), Picture::Srgb8(&b), display, gaze_px, cutoff_cpd)?)
}

/// An 8-bit picture from a PNG file.
pub fn read_png(path: &Path) -> Result<([u32; 2], Vec<u8>), Failure> {
    Ok(image_file::read_png_rgba8(path)?)
}

/// An 8-bit picture to a PNG file.
pub fn write_png(path: &Path, size: [u32; 2], rgba8: &[u8]) -> Result<(), Failure> {
    Ok(image_file::write_png_rgba8(path, size, rgba8)?)
}

/// A linear picture to an EXR file.
pub fn write_exr(path: &Path, size: [u32; 2], rgba: &[f32]) -> Result<(), Failure> {
    Ok(image_file::write_exr_rgba(path, size, rgba)?)
}

/// The KFR mapping on the CPU. Neither coordinate depends on sigma.
pub fn map_on_cpu(
    display: &DisplayGeometry,
    gaze_px: DVec2,
    kernel: &Kernel,
    points: &[DVec2],
) -> Vec<LpCoord> {
    let mapping = KfrMapping::new(display.size_px, gaze_px, *kernel, 1.0);
    points.iter().map(|&point| mapping.forward(point)).collect()
}

/// The engine's device; validation is asked for unless it is turned off.
pub fn device(no_validation: bool) -> Result<HeadlessDevice, Failure> {
    Ok(HeadlessDevice::new(&DeviceOptions { validation: !no_validation })?)
}

/// Every Vulkan device of this machine, best first, and whether the validation layer is installed.
pub fn device_reports() -> Result<(Vec<DeviceReport>, bool), Failure> {
    Ok(headless::device_reports()?)
}
