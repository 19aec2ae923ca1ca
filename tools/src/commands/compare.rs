//! `macula compare`: how far apart two pictures are.

use crate::failure::Failure;
use crate::library;
use crate::options::{gaze_px, parse_hfov, parse_pair};
use crate::output;
use clap::Args;
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use serde_json::Value;
use std::path::PathBuf;

/// Compare two PNG pictures: PSNR, FLIP, and both per ring of eccentricity around a gaze
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
    if json {
        return output::print_json(&comparison);
    }
    let value = serde_json::to_value(&comparison)
        .map_err(|error| Failure::environment(format!("the comparison cannot be shown: {error}")))?;
    output::print(&text(&value))
}

/// A number, or a dash where there is none (identical pictures have no finite PSNR).
fn cell(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => format!("{:.4}", number.as_f64().unwrap_or(f64::NAN)),
        Value::Null => "-".into(),
        other => other.to_string().trim_matches('"').to_owned(),
    }
}

/// Figures of the whole picture, one a line, then a table for each list (the rings).
fn text(comparison: &Value) -> String {
    let mut text = String::new();
    let Value::Object(fields) = comparison else { return text };
    for (name, value) in fields.iter().filter(|(_, value)| !value.is_array()) {
        text.push_str(&format!("{name:<10} {}\n", cell(value)));
    }
    for rows in fields.values().filter_map(Value::as_array) {
        let Some(Value::Object(first)) = rows.first() else { continue };
        let header = first.keys().map(String::as_str).collect::<Vec<_>>();
        let row = |row: &Value| header.iter().map(|&name| cell(&row[name])).collect::<Vec<_>>();
        text.push('\n');
        text.push_str(&output::table(&header, &rows.iter().map(row).collect::<Vec<_>>()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rings_become_a_table() {
        let text = text(&json!({
            "psnr_db": null, "flip": 0.25,
            "rings": [{"from_deg": 0.0, "psnr_db": 51.5}, {"from_deg": 5.0, "psnr_db": null}],
        }));
        assert!(text.contains("psnr_db    -\n") && text.contains("0.2500"), "{text}");
        assert!(text.contains("51.5000") && text.lines().count() == 7, "{text}");
    }
}
