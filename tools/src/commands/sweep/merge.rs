//! `macula sweep merge`: parts of one sweep, measured apart, become one.

use super::finish;
use super::folder::{Folder, Picture};
use crate::failure::Failure;
use crate::library;
use clap::Args;
use std::path::PathBuf;

/// Put the parts of a sweep together that --shard measured apart
///
/// The parts must be of the same sweep: the same scene, sizes, settings and views. Where a setting is in
/// several parts, the first one counts. With one folder and no --output, that folder's table and report are
/// made anew.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula sweep merge part1 part2 -o sweep\n  macula sweep merge sweep")]
pub struct MergeArgs {
    /// Folders of the parts
    #[arg(value_name = "FOLDER", required = true)]
    parts: Vec<PathBuf>,
    /// Folder for the whole [default: the only part's]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Folders that are no parts of one sweep, and what cannot be read or written.
pub fn run(args: &MergeArgs, json: bool) -> Result<(), Failure> {
    let opened = args.parts.iter().map(|path| Folder::open(path)).collect::<Result<Vec<_>, _>>()?;
    let (first, manifest) = &opened[0];
    for ((_, other), path) in opened.iter().zip(&args.parts) {
        if let Some(what) = manifest.difference(other) {
            let first = args.parts[0].display();
            return Err(Failure::usage(format!(
                "{}: is of a sweep with {what} than {first}; merge parts of one sweep only",
                path.display()
            )));
        }
    }
    let output = match (&args.output, &opened[..]) {
        (Some(path), _) => &Folder::begin(path, manifest, true)?,
        (None, [_]) => first,
        (None, _) => return Err(Failure::usage("several parts need a folder for the whole; add --output")),
    };
    for (size, index) in manifest.units() {
        if output.record(manifest, size, index)?.is_some() {
            continue;
        }
        for (part, _) in &opened {
            let Some(record) = part.record(manifest, size, index)? else { continue };
            for picture in [Picture::Reference, Picture::Of(index), Picture::Difference(index)] {
                if let Some(bytes) = part.picture(size, picture) {
                    library::write_file(&output.picture_path(size, picture), &bytes)?;
                }
            }
            output.store_record(&record)?;
            break;
        }
    }
    if output.effects()?.is_none() {
        for (part, _) in &opened {
            if let Some(effects) = part.effects()? {
                output.store_effects(&effects)?;
                break;
            }
        }
    }
    finish::finish(output, manifest, json)
}
