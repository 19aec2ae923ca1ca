//! `macula displays`: the displays that are known by name.

use crate::failure::Failure;
use crate::output;
use clap::Args;
use macula::fovea::DisplayPreset;
use serde::Serialize;

/// List the displays that --display knows
///
/// Pixels are those of one eye: the panel's, and the rendered picture's, which lenses then distort. ppd
/// are the rendered picture's pixels per degree on the view axis, beside what is published. Degrees are
/// the left eye's; the right eye sees the mirror image. A ? marks a guess.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula displays\n  macula displays --json\n  \
                        macula render hall -o left.png --display pimax-crystal --size 1078x1275")]
pub struct DisplaysArgs {}

/// A [`DisplayPreset`] as JSON has it; its field names are an interface.
#[derive(Serialize)]
struct Display {
    name: &'static str,
    about: &'static str,
    panel_px: [u32; 2],
    render_px: [u32; 2],
    /// Left, right, up, down.
    left_eye_tangents: [f64; 4],
    right_eye_tangents: [f64; 4],
    ppd: f64,
    published_ppd: Option<f64>,
    refresh_hz: f64,
    ipd_mm: f64,
    tracker_latency_ms: f64,
    latency_preset: &'static str,
    source: &'static str,
    guesses: &'static [&'static str],
}

impl From<&DisplayPreset> for Display {
    fn from(preset: &DisplayPreset) -> Self {
        let right = preset.right();
        Self {
            name: preset.name,
            about: preset.about,
            panel_px: preset.panel_px,
            render_px: preset.render_px,
            left_eye_tangents: preset.left_eye_tangents,
            right_eye_tangents: [right.tan_left, right.tan_right, right.tan_up, right.tan_down],
            ppd: preset.ppd(),
            published_ppd: preset.published_ppd,
            refresh_hz: preset.refresh_hz,
            ipd_mm: preset.ipd_mm,
            tracker_latency_ms: preset.tracker_latency_ms,
            latency_preset: preset.latency_preset,
            source: preset.source,
            guesses: preset.guesses,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// [`Failure::Environment`] where standard output cannot be written.
pub fn run(_args: &DisplaysArgs, json: bool) -> Result<(), Failure> {
    let presets = DisplayPreset::all();
    if json {
        return output::print_json(&presets.iter().map(Display::from).collect::<Vec<_>>());
    }
    output::print(&text(presets))
}

fn text(presets: &[DisplayPreset]) -> String {
    let header = [
        "display",
        "panel px",
        "rendered px",
        "left, right, up, down deg",
        "ppd",
        "published",
        "Hz",
        "IPD mm",
        "tracker ms",
        "latency model",
    ];
    let rows = presets.iter().map(row).collect::<Vec<_>>();
    let mut text = output::table(&header, &rows);
    text.push_str("\n? a guess; --json says where the other figures come from\n");
    text
}

fn row(preset: &DisplayPreset) -> Vec<String> {
    let marked = |field: &str, value: String| if preset.is_guess(field) { value + "?" } else { value };
    let pixels = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let degrees = preset.left_eye_tangents.map(|tangent| format!("{:.1}", tangent.atan().abs().to_degrees()));
    let published = preset.published_ppd.map_or_else(|| "-".into(), |ppd| format!("{ppd:.0}"));
    vec![
        preset.name.into(),
        marked("panel_px", pixels(preset.panel_px)),
        marked("render_px", pixels(preset.render_px)),
        marked("left_eye_tangents", degrees.join(" ")),
        format!("{:.1}", preset.ppd()),
        marked("published_ppd", published),
        marked("refresh_hz", format!("{:.0}", preset.refresh_hz)),
        marked("ipd_mm", format!("{:.0}", preset.ipd_mm)),
        marked("tracker_latency_ms", format!("{:.1}", preset.tracker_latency_ms)),
        preset.latency_preset.into(),
    ]
}
