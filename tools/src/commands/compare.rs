//! `macula compare`: how far apart two pictures are.

use crate::failure::Failure;
use crate::library;
use crate::options::{gaze_px, parse_hfov, parse_pair};
use crate::output;
use clap::Args;
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use macula::quality::compare::{Comparison, Ring};
use std::path::PathBuf;

/// Compare two PNG pictures: PSNR, FLIP, and both per ring of eccentricity around a gaze
///
/// FLIP is 0 (equal) to 1. It depends on how large pixels look: with --hfov-deg the pictures fill such
/// a display, otherwise there are 67 pixels to a degree.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula compare full.png kfr.png\n  \
                        macula compare full.png kfr.png --gaze 0.5,0.5 --hfov-deg 100 --json")]
pub struct CompareArgs {
    /// The reference
    a: PathBuf,
    /// The picture to judge, of the same size
    b: PathBuf,
    /// Gaze as fractions of the display, from the left and from the top: adds the rings
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true, requires = "hfov_deg")]
    gaze: Option<DVec2>,
    /// Horizontal field of view of the display in degrees, above 0 and below 179
    #[arg(long, value_name = "D", value_parser = parse_hfov, requires = "gaze")]
    hfov_deg: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// Pictures that cannot be read or differ in size.
pub fn run(args: &CompareArgs, json: bool) -> Result<(), Failure> {
    let (size, a) = library::read_png(&args.a)?;
    let (size_b, b) = library::read_png(&args.b)?;
    if size != size_b {
        return Err(Failure::environment(format!(
            "{} is {}x{} px and {} is {}x{} px; only pictures of one size can be compared",
            args.a.display(),
            size[0],
            size[1],
            args.b.display(),
            size_b[0],
            size_b[1]
        )));
    }
    let eye = args
        .gaze
        .zip(args.hfov_deg)
        .map(|(gaze, hfov_deg)| (DisplayGeometry::symmetric(size, hfov_deg), gaze_px(gaze, size)));
    let comparison =
        library::compare_pictures(&a, &b, size, eye.as_ref().map(|(display, gaze)| (display, *gaze)))?;
    if json { output::print_json(&comparison) } else { output::print(&text(&comparison)) }
}

/// A PSNR, or a dash where there are no pixels.
pub fn decibels(psnr_db: Option<f64>) -> String {
    match psnr_db {
        Some(f64::INFINITY) => "equal".into(),
        Some(psnr_db) => format!("{psnr_db:.2} dB"),
        None => "-".into(),
    }
}

fn text(comparison: &Comparison) -> String {
    let mut text = format!("PSNR  {}\nFLIP  {:.4}\n", decibels(Some(comparison.psnr_db)), comparison.flip);
    if comparison.rings.is_empty() {
        return text;
    }
    text += &format!("PSNR within 5 degrees of the gaze  {}\n\n", decibels(comparison.psnr_within_5_deg_db));
    let row = |ring: &Ring| {
        let range = if ring.to_deg.is_finite() {
            format!("{} to {} degrees", ring.from_deg, ring.to_deg)
        } else {
            format!("{} degrees and more", ring.from_deg)
        };
        let flip = ring.flip.map_or("-".into(), |flip| format!("{flip:.4}"));
        vec![range, output::grouped(ring.pixels), decibels(ring.psnr_db), flip]
    };
    let rows = comparison.rings.iter().map(row).collect::<Vec<_>>();
    text + &output::table(&["from the gaze", "pixels", "PSNR", "FLIP"], &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_become_a_table() {
        let ring = |from_deg, to_deg, psnr_db| Ring { from_deg, to_deg, pixels: 1200, psnr_db, flip: None };
        let text = text(&Comparison {
            psnr_db: 33.333,
            flip: 0.25,
            psnr_within_5_deg_db: Some(f64::INFINITY),
            rings: vec![ring(0.0, 5.0, Some(51.5)), ring(5.0, f64::INFINITY, None)],
        });
        for part in ["33.33 dB", "0.2500", "gaze  equal", "0 to 5 degrees", "51.50 dB", "5 degrees and more"]
        {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn without_a_gaze_there_are_no_rings() {
        let whole =
            Comparison { psnr_db: f64::INFINITY, flip: 0.0, psnr_within_5_deg_db: None, rings: vec![] };
        assert_eq!(text(&whole), "PSNR  equal\nFLIP  0.0000\n");
    }
}
