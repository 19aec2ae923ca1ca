//! `macula compare`: how far apart two pictures are.

use crate::failure::Failure;
use crate::library;
use crate::options::{gaze_px, parse_hfov, parse_pair};
use crate::output;
use clap::Args;
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use macula::quality::acuity_error::{AcuityError, AcuityRing};
use macula::quality::compare::{Comparison, Ring};
use serde::Serialize;
use std::path::PathBuf;

/// Compare two PNG pictures: PSNR, FLIP, and around a gaze what an eye's acuity leaves of the error
///
/// FLIP is 0 (equal) to 1. It depends on how large pixels look: with --hfov-deg the pictures fill such
/// a display, otherwise there are 67 pixels to a degree.
///
/// With a gaze everything is also given per ring of eccentricity, and the acuity-surviving error is
/// added: the PSNR after both pictures were low-passed at the acuity of each pixel's eccentricity.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula compare full.png kfr.png\n  \
                        macula compare full.png kfr.png --gaze 0.5,0.5 --hfov-deg 100 --json")]
pub struct CompareArgs {
    /// The reference
    a: PathBuf,
    /// The picture to judge, of the same size
    b: PathBuf,
    /// Gaze as fractions of the display, from the left and from the top: adds the rings and the
    /// acuity-surviving error
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
    let eye = eye.as_ref().map(|(display, gaze)| (display, *gaze));
    let report = Report {
        comparison: library::compare_pictures(&a, &b, size, eye)?,
        acuity_surviving: eye.map(|eye| library::acuity_error(&a, &b, eye)).transpose()?,
    };
    if json { output::print_json(&report) } else { output::print(&text(&report)) }
}

/// What the command prints.
#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    comparison: Comparison,
    /// Null without a gaze.
    acuity_surviving: Option<AcuityError>,
}

/// A PSNR, or a dash where there are no pixels.
pub fn decibels(psnr_db: Option<f64>) -> String {
    match psnr_db {
        Some(f64::INFINITY) => "equal".into(),
        Some(psnr_db) => format!("{psnr_db:.2} dB"),
        None => "-".into(),
    }
}

fn text(Report { comparison, acuity_surviving }: &Report) -> String {
    let mut text = format!("PSNR  {}\nFLIP  {:.4}\n", decibels(Some(comparison.psnr_db)), comparison.flip);
    let Some(acuity) = acuity_surviving else {
        return text;
    };
    text += &format!("PSNR within 5 degrees of the gaze  {}\n", decibels(comparison.psnr_within_5_deg_db));
    let surviving = decibels(Some(acuity.psnr_db));
    text += &format!("PSNR of what acuity leaves  {surviving} (RMSE {:.5})\n\n", acuity.rmse);
    let row = |(ring, acuity): (&Ring, &AcuityRing)| {
        let range = if ring.to_deg.is_finite() {
            format!("{} to {} degrees", ring.from_deg, ring.to_deg)
        } else {
            format!("{} degrees and more", ring.from_deg)
        };
        let flip = ring.flip.map_or("-".into(), |flip| format!("{flip:.4}"));
        let [psnr, surviving] = [ring.psnr_db, acuity.psnr_db].map(decibels);
        vec![range, output::grouped(ring.pixels), psnr, flip, surviving]
    };
    let rows = comparison.rings.iter().zip(&acuity.rings).map(row).collect::<Vec<_>>();
    text + &output::table(&["from the gaze", "pixels", "PSNR", "FLIP", "acuity leaves"], &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_become_a_table() {
        let ring = |from_deg, to_deg, psnr_db| Ring { from_deg, to_deg, pixels: 1200, psnr_db, flip: None };
        let acuity =
            |from_deg, to_deg, psnr_db| AcuityRing { from_deg, to_deg, pixels: 1200, rmse: None, psnr_db };
        let text = text(&Report {
            comparison: Comparison {
                psnr_db: 33.333,
                flip: 0.25,
                psnr_within_5_deg_db: Some(f64::INFINITY),
                rings: vec![ring(0.0, 5.0, Some(51.5)), ring(5.0, f64::INFINITY, None)],
            },
            acuity_surviving: Some(AcuityError {
                rmse: 0.0056,
                psnr_db: 45.0,
                rings: vec![acuity(0.0, 5.0, Some(62.25)), acuity(5.0, f64::INFINITY, None)],
            }),
        });
        for part in [
            "33.33 dB",
            "0.2500",
            "gaze  equal",
            "leaves  45.00 dB (RMSE 0.00560)",
            "0 to 5 degrees",
            "51.50 dB",
            "62.25 dB",
            "5 degrees and more",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }

    #[test]
    fn without_a_gaze_there_are_no_rings() {
        let comparison =
            Comparison { psnr_db: f64::INFINITY, flip: 0.0, psnr_within_5_deg_db: None, rings: vec![] };
        assert_eq!(text(&Report { comparison, acuity_surviving: None }), "PSNR  equal\nFLIP  0.0000\n");
    }
}
