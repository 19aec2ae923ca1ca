//! The options of `macula gaze latency`.

use crate::commands::gaze::{ReadArgs, RunArgs};
use crate::commands::render::check_folder;
use crate::failure::Failure;
use clap::Args;
use macula_trackers::latency::{LatencyModel, preset};
use std::path::{Path, PathBuf};

/// How old and how far off the gaze is when its picture is displayed, and what foveation needs
///
/// Takes the recording through a model of tracker, renderer and display, refresh by refresh. Times from
/// which the model draws are in a preset or a TOML file (which may be based_on a preset). What the eye
/// did comes from labels in the recording, or else from the online classifier.
///
/// The renderer holds the newest sample that it has, unless --predictor or --filter puts the estimator
/// between; then the model's filter_delay is left out.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  macula gaze latency session.csv --preset vive-pro-eye -o latency.html\n  \
                        macula gaze latency session.csv --model mine.toml --predictor landing --late-latch --json\n  \
                        macula render hall -o a.png --json > gpu.json && \
                        macula gaze latency session.csv --preset generic-90hz --measured gpu=gpu.json\n  \
                        macula gaze latency --list-presets"
)]
pub struct LatencyArgs {
    /// The recording: any known format, recognised by its content
    #[arg(value_name = "FILE", required_unless_present = "list_presets")]
    pub file: Option<PathBuf>,
    #[command(flatten)]
    pub read: ReadArgs,
    /// A model that comes with macula; --list-presets names them
    #[arg(long, value_name = "NAME", required_unless_present_any = ["model", "list_presets"])]
    pub preset: Option<String>,
    /// A model from a TOML file
    #[arg(long, value_name = "FILE.toml", conflicts_with = "preset")]
    pub model: Option<PathBuf>,
    /// Lists the presets and does nothing else
    #[arg(long, conflicts_with_all = ["file", "preset", "model"])]
    pub list_presets: bool,
    #[command(flatten)]
    pub run: RunArgs,
    /// Writes a page with plots: one HTML file that needs nothing else
    #[arg(short, long, value_name = "PAGE.html")]
    pub output: Option<PathBuf>,
    /// Writes a CSV row for each refresh of the display
    #[arg(long, value_name = "FRAMES.csv")]
    pub ledger: Option<PathBuf>,
    /// Writes a CSV row for each sample: when it was taken, had, used and shown
    #[arg(long, value_name = "SAMPLES.csv")]
    pub sample_ledger: Option<PathBuf>,
}

impl LatencyArgs {
    /// The model with what the options change in it.
    ///
    /// # Errors
    /// An unknown preset, a broken file, a stage that does not exist.
    pub fn model(&self) -> Result<LatencyModel, Failure> {
        let model = match (&self.preset, &self.model) {
            (Some(name), None) => preset(name)?,
            (None, Some(path)) => LatencyModel::open(path)?,
            _ => return Err(Failure::usage("give either --preset or --model")),
        };
        self.run.changed(model)
    }

    /// Fails where one output would replace another or an input, or has no folder: before long work.
    ///
    /// # Errors
    /// Then.
    pub fn check_outputs(&self, file: &Path) -> Result<(), Failure> {
        let outputs = [&self.output, &self.ledger, &self.sample_ledger].into_iter().flatten();
        let measured = self.run.measured.iter().filter_map(|argument| Some(argument.split_once('=')?.1));
        let mut taken: Vec<PathBuf> = std::iter::once(file)
            .chain(self.model.as_deref())
            .chain(measured.map(Path::new))
            .map(place)
            .collect();
        for output in outputs {
            check_folder(output)?;
            let place = place(output);
            if taken.contains(&place) {
                let path = output.display();
                return Err(Failure::usage(format!(
                    "{path} is given twice; each file needs a name of its own"
                )));
            }
            taken.push(place);
        }
        Ok(())
    }
}

/// Where a path leads, as far as that exists.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(beside).unwrap_or_else(|| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use macula_trackers::estimator::FilterKind;
    use macula_trackers::predict::PredictorKind;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        args: LatencyArgs,
    }

    fn args(options: &str) -> Option<LatencyArgs> {
        let words = format!("latency {options}");
        Only::try_parse_from(words.split_whitespace()).ok().map(|only| only.args)
    }

    #[test]
    fn a_run_needs_a_recording_and_one_model() {
        for wrong in [
            "",
            "a.csv",
            "--preset fove-0",
            "a.csv --preset fove-0 --model a.toml",
            "a.csv --preset fove-0 --list-presets",
            "a.csv --preset fove-0 --target 1.5",
            "a.csv --preset fove-0 --radius-deg nan",
            "a.csv --preset fove-0 --predictor crystal-ball",
        ] {
            assert!(args(wrong).is_none(), "{wrong}");
        }
        for right in ["a.csv --preset fove-0", "a.csv --model a.toml", "--list-presets"] {
            assert!(args(right).is_some(), "{right}");
        }
    }

    #[test]
    fn the_estimator_is_used_where_it_is_named() {
        let estimator = |options: &str| {
            let args = args(&format!("a.csv --preset fove-0 {options}"))?;
            args.run.estimator().map(|settings| (settings.predictor, settings.filter))
        };
        assert_eq!(estimator(""), None);
        let predictor = estimator("--predictor kalman");
        assert_eq!(predictor, Some((PredictorKind::Kalman, FilterKind::SaccadeAware)));
        assert_eq!(estimator("--filter one-euro"), Some((PredictorKind::Hold, FilterKind::OneEuro)));
        let names = ["hold", "constant-velocity", "gate20", "kalman", "landing"];
        let kinds = names.map(|name| estimator(&format!("--predictor {name}")).map(|kinds| kinds.0));
        assert_eq!(kinds, PredictorKind::ALL.map(Some));
    }

    #[test]
    fn measured_stages_are_named_once_and_exist() {
        let model =
            |options: &str| args(&format!("a.csv --preset fove-0 {options}")).map(|args| args.model());
        for wrong in [
            "--measured gpu",
            "--measured nothing=a.json",
            "--measured pacing=a.json",
            "--measured exposure=a.json --recorded-arrival",
            "--measured filter_delay=a.json --filter none",
        ] {
            assert!(matches!(model(wrong), Some(Err(Failure::Usage(_)))), "{wrong}");
        }
        assert!(matches!(model("--measured gpu=no/such.json"), Some(Err(Failure::Environment(_)))));
        assert!(matches!(model("--late-latch"), Some(Ok(model)) if model.late_latch));
    }

    #[test]
    fn no_output_replaces_another_file() {
        let check = |options: &str| {
            args(&format!("a.csv --preset fove-0 {options}"))
                .map(|args| args.check_outputs(Path::new("a.csv")))
        };
        for wrong in ["-o a.csv", "-o ./a.csv", "-o b.html --ledger b.html", "--ledger no/such/folder/b.csv"]
        {
            assert!(matches!(check(wrong), Some(Err(_))), "{wrong}");
        }
        assert!(matches!(check("-o b.html --ledger b.csv --sample-ledger c.csv"), Some(Ok(()))));
    }
}
