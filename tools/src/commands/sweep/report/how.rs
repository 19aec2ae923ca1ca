//! Where and how it was measured, what can be turned, and the command.

use super::sheet::size_text;
use super::table::{Cell, Table};
use super::text::per_cent;
use crate::commands::sweep::record::{Machine, Manifest, Outcome, Path, Record};
use crate::page::escaped;
use macula::knobs::{KNOBS, Needs, Order, Value};
use std::fmt::Write;

/// The machines of the records, each once, with the records it made.
pub fn machines(records: &[Record]) -> Vec<(&Machine, usize)> {
    let mut machines: Vec<(&Machine, usize)> = Vec::new();
    for record in records {
        match machines.iter_mut().find(|(machine, _)| **machine == record.machine) {
            Some((_, count)) => *count += 1,
            None => machines.push((&record.machine, 1)),
        }
    }
    machines
}

/// Scene, display and machines as a list.
pub fn facts(manifest: &Manifest, records: &[Record]) -> String {
    let sizes = manifest.sizes.iter().map(|size| size_text(*size)).collect::<Vec<_>>().join(", ");
    let mut facts = vec![
        ("Scene", manifest.scene.clone()),
        ("Display", format!("{sizes} px, {} degrees across", manifest.hfov_deg)),
        ("Acuity", manifest.acuity.clone()),
        ("Base", manifest.base.to_string()),
        ("Reference", manifest.reference.to_string()),
    ];
    let machines = machines(records);
    for (machine, count) in &machines {
        let Machine { device, driver, cpu, threads, system } = machine;
        let of = if machines.len() > 1 { format!(" ({count} records)") } else { String::new() };
        facts.push(("GPU", format!("{device}{of}")));
        facts.push(("Driver", driver.clone()));
        facts.push(("Processor", format!("{cpu}, {threads} threads")));
        facts.push(("System", system.clone()));
    }
    facts.push(("Program", format!("macula {}", manifest.program)));
    let fact = |(name, value): (&str, String)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(&value));
    let list = facts.into_iter().map(fact).collect::<String>();
    let warning = if machines.len() > 1 {
        "<p><strong>Several machines measured this: compare ratios, not milliseconds.</strong></p>\n"
    } else {
        ""
    };
    format!("<dl>\n{list}</dl>\n{warning}")
}

/// How times and errors came about, in paragraphs.
pub fn measured(manifest: &Manifest, records: &[Record]) -> String {
    let count = |path: Path| manifest.views.iter().filter(|view| view.path == path).count();
    let [gazes, camera, gaze_move] = [Path::Gaze, Path::Camera, Path::GazeMove].map(count);
    let figures = records.iter().filter_map(|record| match &record.outcome {
        Outcome::Measured(figures) => Some(figures),
        Outcome::Failed(_) => None,
    });
    let pairs = figures.clone().map(|figures| figures.times.pairs);
    let (least, most) = (pairs.clone().min().unwrap_or(0), pairs.max().unwrap_or(0));
    let pairs = if least == most { format!("{least} pairs") } else { format!("{least} to {most} pairs") };
    let confidence = figures.map(|figures| figures.times.ratio_confidence).fold(1.0, f64::min);
    format!(
        "<p>Frames of the reference and of a setting were rendered alternately in one process, {pairs} for each \
         setting ({} for each view), after frames that are not counted. Times are the GPU's own, from the \
         start of the frame's first pass to the end of its last. The ratio is the median of the pairs' ratios: \
         what slows the machine down for a while slows both. Its interval lies between two of the ordered \
         ratios and holds the median with a probability of at least {} here, whatever the distribution. Bars \
         of milliseconds reach from the least to the greatest frame.</p>\n\
         <p>{} views were rendered: {gazes} gazes by themselves, {camera} steps of a slow move of the camera, \
         {gaze_move} steps of a slow move of the gaze over a still picture. Errors are roots of mean squares \
         over the views (FLIP: the mean), the same in every run of the program: they have no bars. Temporal \
         variance is that of each pixel's encoded luminance along a move.</p>\n",
        manifest.runs,
        per_cent(confidence),
        manifest.views.len()
    )
}

/// All knobs.
pub fn knobs() -> String {
    let row = |knob: &macula::knobs::Knob| {
        let trades = match knob.order {
            Order::MoreIsMoreAccurate => "more is more accurate",
            Order::LessIsMoreAccurate => "less is more accurate",
            Order::None => "no order",
        };
        let needs = match knob.needs {
            Needs::Nothing => String::new(),
            Needs::Foveation => "any method but full".to_owned(),
            Needs::PowerKernel => "kfr with the kernel pow".to_owned(),
            Needs::Methods(methods) => methods.join(", "),
        };
        let scene = match knob.ray_marched {
            Some(true) => "ray-marched scenes",
            Some(false) => "scenes of triangles",
            None => "",
        };
        let applies = [needs.as_str(), scene].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>();
        let applies = if applies.is_empty() { "always".to_owned() } else { applies.join("; ") };
        let texts = [
            knob.range.to_string(),
            Value::from(knob.reference).to_string(),
            trades.to_owned(),
            applies,
            knob.affects.to_owned(),
        ];
        (knob.name.to_owned(), None, texts.map(Cell::Text).into_iter().collect())
    };
    Table {
        caption: "Knobs: what trades accuracy for time".to_owned(),
        head: ["knob", "range", "most accurate", "trades", "applies to", "affects"]
            .map(str::to_owned)
            .to_vec(),
        rows: KNOBS.iter().map(row).collect(),
        class: "knobs",
        sortable: false,
    }
    .html()
}

/// The command line, as a shell takes it.
pub fn command(manifest: &Manifest) -> String {
    let mut line = String::from("macula");
    for word in &manifest.command {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            _ = write!(line, " {word}");
        } else {
            _ = write!(line, " '{}'", word.replace('\'', "'\\''"));
        }
    }
    format!("<pre tabindex=\"0\"><code>{}</code></pre>\n", escaped(&line))
}
