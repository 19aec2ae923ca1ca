//! `macula choose`: the setting of a sweep that fits a budget or a quality.

use crate::commands::sweep::folder::Folder;
use crate::commands::sweep::front::{Point, front};
use crate::commands::sweep::record::{Figures, Manifest};
use crate::failure::Failure;
use crate::library;
use crate::options::{parse_size, parse_within};
use crate::output;
use clap::Args;
use macula::knobs::Setting;
use serde::Serialize;
use std::path::PathBuf;

/// Neighbours on the front that are shown to either side.
const NEIGHBOURS: usize = 2;

/// Choose the setting that fits a frame time or an error from what a sweep measured
///
/// With --budget-ms it is the most accurate setting whose median GPU time is within the budget, with
/// --max-error the fastest one whose acuity-surviving error is within E. Only what was measured is chosen:
/// times hold for the machine, the scene and the size of the sweep.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula choose --budget-ms 8.3 --from sweep -o setting.toml\n  \
                        macula choose --max-error 0.01 --from sweep\n  \
                        macula render hall -o hall.png --setting setting.toml")]
pub struct ChooseArgs {
    /// The sweep's folder
    #[arg(long, value_name = "FOLDER")]
    from: PathBuf,
    /// GPU time of a frame, milliseconds
    #[arg(long, value_name = "MS", value_parser = parse_budget, required_unless_present = "max_error", conflicts_with = "max_error")]
    budget_ms: Option<f64>,
    /// Acuity-surviving RMSE of encoded values, 0 to 1
    #[arg(long, value_name = "E", value_parser = parse_error)]
    max_error: Option<f64>,
    /// Which of the sweep's sizes [default: the first]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Write the setting to a file that `render`, `replay` and the library read
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
}

fn parse_budget(text: &str) -> Result<f64, String> {
    parse_within(text, 1e-3, 1e6)
}

fn parse_error(text: &str) -> Result<f64, String> {
    parse_within(text, 0.0, 1.0)
}

/// A setting on the front.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Candidate {
    setting: Setting,
    gpu_ms: f64,
    /// Over the reference's time.
    time_ratio: f64,
    /// Acuity-surviving RMSE.
    error: f64,
    flip: f64,
}

/// The result; its field names are an interface.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    size: [u32; 2],
    device: String,
    chosen: &'a Candidate,
    /// On the front, from the fastest to the most accurate, the chosen one among them.
    neighbours: &'a [Candidate],
    wrote: Option<&'a PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A folder without a sweep, and a budget or quality that no setting reaches.
pub fn run(args: &ChooseArgs, json: bool) -> Result<(), Failure> {
    let (folder, manifest) = Folder::open(&args.from)?;
    let size = args.size(&manifest)?;
    let records: Vec<_> =
        folder.records(&manifest)?.into_iter().filter(|record| record.size == size).collect();
    let measured: Vec<_> = records.iter().filter_map(|record| Some((record, record.figures()?))).collect();
    let Some((first, figures)) = measured.first() else {
        return Err(Failure::environment(format!(
            "{}: no setting was measured at this size; run the sweep to its end",
            args.from.display()
        )));
    };
    let mut candidates = vec![reference(&manifest, figures)];
    candidates.extend(
        measured.iter().map(|(record, figures)| candidate(&record.setting.over(&manifest.base), figures)),
    );
    let candidates = on_front(&candidates);
    let place = args.place(&candidates)?;
    let neighbours =
        &candidates[place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS + 1).min(candidates.len())];
    let report = Report {
        scene: &manifest.scene,
        size,
        device: first.machine.device.clone(),
        chosen: &candidates[place],
        neighbours,
        wrote: args.output.as_ref(),
    };
    if let Some(path) = &args.output {
        library::write_file(path, file(&report).as_bytes())?;
    }
    if json { output::print_json(&report) } else { output::print(&text(&report)) }
}

impl ChooseArgs {
    fn size(&self, manifest: &Manifest) -> Result<[u32; 2], Failure> {
        let Some(size) = self.size else { return Ok(manifest.sizes[0]) };
        if manifest.sizes.contains(&size) {
            return Ok(size);
        }
        let sizes = manifest.sizes.iter().map(|[width, height]| format!("{width}x{height}"));
        let sizes = sizes.collect::<Vec<_>>().join(", ");
        Err(Failure::usage(format!("--size: the sweep measured {sizes}; name one of them")))
    }

    /// Place of the chosen one among candidates from the fastest to the most accurate.
    fn place(&self, candidates: &[Candidate]) -> Result<usize, Failure> {
        if let Some(budget_ms) = self.budget_ms {
            return candidates.iter().rposition(|of| of.gpu_ms <= budget_ms).ok_or_else(|| {
                Failure::environment(format!(
                    "no setting of the sweep takes {budget_ms} ms or less; the fastest is {} with {:.3} ms; \
                     sweep cheaper settings or a smaller size",
                    candidates[0].setting, candidates[0].gpu_ms
                ))
            });
        }
        let most = self.max_error.unwrap_or_default();
        // The reference has an error of 0.
        Ok(candidates.iter().position(|of| of.error <= most).unwrap_or(candidates.len() - 1))
    }
}

fn candidate(setting: &Setting, figures: &Figures) -> Candidate {
    Candidate {
        setting: setting.clone(),
        gpu_ms: figures.times.setting_ms.median,
        time_ratio: figures.times.ratio.median,
        error: figures.errors.acuity_rmse,
        flip: figures.errors.flip,
    }
}

fn reference(manifest: &Manifest, figures: &Figures) -> Candidate {
    let gpu_ms = figures.times.reference_ms.median;
    Candidate { setting: manifest.reference.clone(), gpu_ms, time_ratio: 1.0, error: 0.0, flip: 0.0 }
}

/// From the fastest to the most accurate.
fn on_front(candidates: &[Candidate]) -> Vec<Candidate> {
    let points: Vec<_> = candidates.iter().map(|of| Point::new(of.gpu_ms, of.error)).collect();
    front(&points).into_iter().map(|place| candidates[place].clone()).collect()
}

/// The setting's file, with what it was measured at as comments.
fn file(report: &Report<'_>) -> String {
    let [width, height] = report.size;
    let chosen = report.chosen;
    format!(
        "# Measured at {width}x{height} on {}: {:.3} ms, {:.3} of the reference's time, acuity-surviving RMSE {:.5}.\n{}",
        report.device.replace(['\n', '\r'], " "),
        chosen.gpu_ms,
        chosen.time_ratio,
        chosen.error,
        chosen.setting.to_toml()
    )
}

fn text(report: &Report<'_>) -> String {
    let row = |of: &Candidate| {
        vec![
            if of == report.chosen { "->" } else { "" }.to_owned(),
            of.setting.to_string(),
            format!("{:.3}", of.gpu_ms),
            format!("{:.3}", of.time_ratio),
            format!("{:.5}", of.error),
            format!("{:.4}", of.flip),
        ]
    };
    let rows = report.neighbours.iter().map(row).collect::<Vec<_>>();
    let [width, height] = report.size;
    let mut text = format!("{} at {width}x{height} on {}\n\n", report.scene, report.device);
    text += &output::table(&["", "setting", "GPU ms", "ratio", "acuity error", "FLIP"], &rows);
    if let Some(path) = report.wrote {
        text += &format!("\nwrote      {}\n", path.display());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(gpu_ms: f64, error: f64) -> Candidate {
        Candidate { setting: Setting::default(), gpu_ms, time_ratio: gpu_ms / 10.0, error, flip: error }
    }

    fn args(budget_ms: Option<f64>, max_error: Option<f64>) -> ChooseArgs {
        ChooseArgs { from: "sweep".into(), budget_ms, max_error, size: None, output: None }
    }

    #[test]
    fn the_most_accurate_within_the_budget_or_the_fastest_within_the_error() {
        let candidates = on_front(&[of(10.0, 0.0), of(6.0, 0.01), of(7.0, 0.02), of(3.0, 0.05)]);
        let times: Vec<_> = candidates.iter().map(|of| of.gpu_ms).collect();
        assert_eq!(times, [3.0, 6.0, 10.0]);
        let chosen = |budget, error| args(budget, error).place(&candidates).map(|place| times[place]);
        assert!(matches!(chosen(Some(8.3), None), Ok(6.0)));
        assert!(matches!(chosen(Some(6.0), None), Ok(6.0)));
        assert!(matches!(chosen(Some(99.0), None), Ok(10.0)));
        assert!(matches!(chosen(None, Some(0.05)), Ok(3.0)));
        assert!(matches!(chosen(None, Some(0.04)), Ok(6.0)));
        assert!(matches!(chosen(None, Some(0.0)), Ok(10.0)));
        let Err(failure) = chosen(Some(2.0), None) else { panic!("nothing takes 2 ms") };
        assert!(failure.line().is_some_and(|line| line.contains("3.000 ms")), "{failure:?}");
    }

    #[test]
    fn the_file_is_a_setting() {
        let setting = Setting::default().with("method", "vafr").unwrap().with("acuity-scale", 0.8).unwrap();
        let chosen = Candidate { setting: setting.clone(), ..of(4.0, 0.01) };
        let report = Report {
            scene: "hall",
            size: [64, 32],
            device: "a\ndevice".into(),
            chosen: &chosen,
            neighbours: &[],
            wrote: None,
        };
        assert_eq!(Setting::from_toml(&file(&report)).unwrap(), setting);
    }
}
