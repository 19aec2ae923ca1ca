//! Pages of one file that needs nothing else, not even a network: the demo's, and what other pages share
//! with it.

pub mod axis;
pub mod picture;

use crate::commands::compare::decibels;
use crate::measure::PassMedian;
use crate::output::grouped;
use macula::quality::compare::Comparison;
use macula::stats::{Effects, LpStats};
use std::fmt::Write;

const TEMPLATE: &str = include_str!("page.html");
/// What all pages look like.
pub const BASE_STYLE: &str = include_str!("base.css");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// What the page shows.
pub struct Page<'a> {
    /// Display size, px.
    pub size: [u32; 2],
    /// Lines of what was rendered and on what.
    pub facts: Vec<(&'static str, String)>,
    /// One for each scene and gaze.
    pub gazes: Vec<GazePart>,
    /// What the effect plan decided.
    pub effects: &'a Effects,
}

/// One gaze point's pictures and figures.
pub struct GazePart {
    /// A short name.
    pub name: &'static str,
    /// Fractions of the display.
    pub gaze: [f64; 2],
    /// The fully shaded picture as a PNG file; `None` where it is that of the part before.
    pub full_png: Option<Vec<u8>>,
    /// The foveated picture as a PNG file.
    pub kfr_png: Vec<u8>,
    /// The difference between both, amplified, as a PNG file.
    pub difference_png: Vec<u8>,
    /// The foveated picture with rings of eccentricity, as a PNG file.
    pub rings_png: Vec<u8>,
    /// The LP-buffer as a PNG file.
    pub lp_png: Vec<u8>,
    /// Its size and use.
    pub lp: LpStats,
    /// Median GPU time with full shading.
    pub full_ms: f64,
    /// Median GPU time foveated.
    pub kfr_ms: f64,
    /// Median of the pairs' ratios.
    pub speedup: f64,
    /// Shading samples of both.
    pub samples: [u64; 2],
    /// Foveated passes.
    pub passes: Vec<PassMedian>,
    /// The foveated picture against the full one.
    pub error: Comparison,
}

impl Page<'_> {
    /// The page's text.
    pub fn html(&self) -> String {
        let chooser = self.gazes.iter().enumerate().map(|(index, part)| choice(index, part));
        let values = [
            ("style", format!("{BASE_STYLE}{STYLE}")),
            ("summary", self.summary()),
            ("chooser", chooser.collect()),
            ("gazes", self.gazes.iter().enumerate().map(|(index, part)| self.section(index, part)).collect()),
            ("times", self.times()),
            ("passes", self.passes()),
            ("effects", effects(self.effects)),
            ("facts", facts(&self.facts)),
            ("script", SCRIPT.to_owned()),
        ];
        filled(TEMPLATE, &values)
    }

    fn summary(&self) -> String {
        let speedups = self.gazes.iter().map(|part| part.speedup);
        let (low, high) = (speedups.clone().fold(f64::INFINITY, f64::min), speedups.fold(0.0, f64::max));
        let shares = self.gazes.iter().map(|part| part.samples[1] as f64 / part.samples[0].max(1) as f64);
        let share = shares.fold(0.0, f64::max);
        let card = |value: String, what: &str| format!("<div><b>{value}</b><span>{what}</span></div>");
        let range = if format!("{low:.1}") == format!("{high:.1}") {
            format!("{high:.1}×")
        } else {
            format!("{low:.1}–{high:.1}×")
        };
        card(range, "speed-up of the whole frame")
            + &card(format!("{:.0} %", share * 100.0), "of the shading samples, at most")
            + &card(format!("{}×{}", self.size[0], self.size[1]), "pixels")
    }

    fn section(&self, index: usize, part: &GazePart) -> String {
        let [width, height] = self.size;
        let name = escaped(part.name);
        let hidden = if index == 0 { "" } else { " hidden" };
        // A full picture is embedded once; the script hands it to the sections that follow.
        let full = part.full_png.as_deref().map(source).unwrap_or_default();
        let over = |view: &str, alt: &str, png: &[u8], hidden: &str| {
            format!(
                "<img class=\"over\" data-view=\"{view}\" width=\"{width}\" height=\"{height}\" \
                 alt=\"{alt}, gaze {name}\"{}{hidden}>\n",
                source(png)
            )
        };
        let [x, y] = part.gaze.map(|fraction| fraction * 100.0);
        let LpStats { width: lp_width, height: lp_height, shaded, native_pixels, .. } = part.lp;
        format!(
            "<section class=\"gaze\" data-gaze=\"{index}\" aria-label=\"Gaze {name}\"{hidden}>\n\
             <h3 class=\"print-only\">Gaze {name}</h3>\n\
             <div class=\"stack\" style=\"--ratio:{width}/{height};--x:{x}%;--y:{y}%\">\n\
             <div class=\"pane\"><img class=\"under\" width=\"{width}\" height=\"{height}\" alt=\"Full shading\"{full}>\
             <span class=\"mark\" title=\"gaze\"></span><span class=\"tag\">full</span></div>\n\
             <div class=\"pane top\">{}{}{}<span class=\"mark\" title=\"gaze\"></span>\
             <span class=\"tag right\">foveated</span></div>\n\
             <span class=\"line\"></span>\n\
             <input type=\"range\" min=\"0\" max=\"100\" step=\"0.1\" value=\"50\" \
             aria-label=\"Where the full picture ends and the other begins, gaze {name}\">\n</div>\n\
             <figure class=\"lp\"><img width=\"{lp_width}\" height=\"{lp_height}\" \
             alt=\"LP-buffer, gaze {name}\"{}>\n\
             <figcaption>The LP-buffer, {lp_width}×{lp_height} texels: the distance from the gaze runs to \
             the right, the angle downwards. {} texels are shaded. The dark ones miss the display, or lie at \
             the gaze, where {} pixels are shaded one by one instead.</figcaption></figure>\n</section>\n",
            over("foveated", "Foveated", &part.kfr_png, ""),
            over("difference", "Difference times 4", &part.difference_png, " hidden"),
            over("rings", "Rings of eccentricity", &part.rings_png, " hidden"),
            source(&part.lp_png),
            grouped(shaded),
            grouped(native_pixels),
        )
    }

    fn times(&self) -> String {
        let mut rows = String::new();
        for part in &self.gazes {
            let [full, kfr] = part.samples;
            _ = writeln!(
                rows,
                "<tr><th scope=\"row\">{} <small>({}, {})</small></th><td><b>{:.2}×</b></td>\
                 <td>{:.1}</td><td>{:.1}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.3}</td></tr>",
                escaped(part.name),
                part.gaze[0],
                part.gaze[1],
                part.speedup,
                part.full_ms,
                part.kfr_ms,
                grouped(full),
                grouped(kfr),
                decibels(part.error.psnr_within_5_deg_db),
                part.error.flip
            );
        }
        rows
    }

    fn passes(&self) -> String {
        let Some(part) = self.gazes.first() else { return String::new() };
        let row = |pass: &PassMedian| {
            let share = (pass.gpu_ms / part.kfr_ms.max(f64::MIN_POSITIVE) * 100.0).clamp(0.0, 100.0);
            format!(
                "<tr><th scope=\"row\">{}</th><td>{:.2}</td><td class=\"bar\"><i style=\"width:{share:.1}%\"></i>\
                 </td></tr>\n",
                escaped(pass.name),
                pass.gpu_ms
            )
        };
        part.passes.iter().map(row).collect()
    }
}

fn choice(index: usize, part: &GazePart) -> String {
    let checked = if index == 0 { " checked" } else { "" };
    format!(
        "<label><input type=\"radio\" name=\"gaze\" value=\"{index}\"{checked}><span>{}</span></label>\n",
        escaped(part.name)
    )
}

fn effects(effects: &Effects) -> String {
    let mut rows = String::new();
    for (state, notes) in [("runs", &effects.run), ("left out", &effects.skipped)] {
        for note in notes {
            let class = if state == "runs" { "on" } else { "off" };
            _ = writeln!(
                rows,
                "<tr class=\"{class}\"><th scope=\"row\">{}</th><td>{state}</td><td>{}</td></tr>",
                escaped(note.name),
                escaped(&note.why)
            );
        }
    }
    rows
}

fn facts(facts: &[(&str, String)]) -> String {
    facts.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value))).collect()
}

fn source(png: &[u8]) -> String {
    format!(" src=\"{}\"", data_url("image/png", png))
}

/// A file as an address that holds it.
pub fn data_url(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", base64::encode(bytes))
}

/// A template with every `{{name}}` replaced by its value. Values are not looked through again.
pub fn filled(template: &str, values: &[(&str, String)]) -> String {
    let length = values.iter().map(|(_, value)| value.len()).sum::<usize>();
    let mut text = String::with_capacity(template.len() + length);
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        text.push_str(before);
        let Some((name, after)) = after.split_once("}}") else { break };
        let value = values.iter().find(|(key, _)| *key == name);
        text.push_str(value.map_or("", |(_, value)| value));
        rest = after;
    }
    text + rest
}

/// Text as it may stand in HTML, in XML, and in their attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::stats::EffectNote;

    fn part(name: &'static str) -> GazePart {
        GazePart {
            name,
            gaze: [0.25, 0.5],
            kfr_png: vec![1],
            difference_png: vec![2],
            rings_png: vec![3],
            lp_png: vec![4],
            lp: LpStats { width: 5, height: 3, texels: 15, on_display: 9, ..LpStats::default() },
            full_png: None,
            full_ms: 30.0,
            kfr_ms: 10.0,
            speedup: 3.0,
            samples: [2_073_600, 500_000],
            passes: vec![PassMedian { name: "lp_shade", gpu_ms: 6.0 }],
            error: Comparison { psnr_db: 30.0, flip: 0.1, psnr_within_5_deg_db: Some(45.0), rings: vec![] },
        }
    }

    fn html() -> String {
        let note = EffectNote { name: "sky", why: "no <environment> & no sky".into() };
        let effects = Effects { run: vec![], skipped: vec![note] };
        let page = Page {
            size: [1920, 1080],
            facts: vec![("Device", "a \"GPU\"".into())],
            gazes: vec![
                GazePart { full_png: Some(vec![7; 3]), ..part("centre") },
                part("left"),
                GazePart { full_png: Some(vec![8; 3]), ..part("other scene") },
            ],
            effects: &effects,
        };
        page.html()
    }

    #[test]
    fn the_page_is_whole_and_needs_no_network() {
        let html = html();
        assert!(!html.contains("{{") && !html.contains("}}"));
        for far in ["http:", "https:", "src=\"/", "url(", "@import", "<link"] {
            assert!(!html.contains(far), "{far}");
        }
        assert!(html.starts_with("<!doctype html>") && html.trim_end().ends_with("</html>"));
    }

    #[test]
    fn every_picture_is_embedded_once() {
        let html = html();
        assert_eq!(html.matches("data:image/png;base64,").count(), 2 + 3 * 4);
        assert_eq!(html.matches(&source(&[7; 3])).count(), 1);
    }

    #[test]
    fn text_is_escaped() {
        let html = html();
        assert!(html.contains("no &lt;environment&gt; &amp; no sky"));
        assert!(html.contains("a &quot;GPU&quot;"));
    }
}
