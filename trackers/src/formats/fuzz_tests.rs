//! Mutated small files through every reader, also through those of other formats: no panic.

use super::{FORMATS, Input, ReadOptions, read_input};
use crate::recording::Screen;
use glam::DVec2;
use proptest::prelude::*;
use std::fs;
use std::path::Path;

/// Bytes of a text that mean something to a reader.
const SPECIAL: &[u8] = b",;\t\n\r\"'.-+eEnN09 ()[]:\0\xff";

/// A few rows of each layout.
fn seeds() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/layouts");
    let entries = fs::read_dir(folder).expect("the project's own data");
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension != "toml"));
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("readable")).collect()
}

/// One edit: where, what, which byte.
type Edit = (prop::sample::Index, u8, u8);

fn edited(mut bytes: Vec<u8>, edits: &[Edit]) -> Vec<u8> {
    for (place, kind, byte) in edits {
        if bytes.is_empty() {
            break;
        }
        let at = place.index(bytes.len());
        let special = SPECIAL[usize::from(*byte) % SPECIAL.len()];
        match kind % 6 {
            0 => bytes[at] = *byte,
            1 => bytes[at] = special,
            2 => bytes.insert(at, special),
            3 => bytes.truncate(at),
            4 => drop(bytes.drain(at..(at + usize::from(*byte)).min(bytes.len()))),
            _ => {
                let copy = bytes[at..(at + usize::from(*byte)).min(bytes.len())].to_vec();
                bytes.splice(at..at, copy);
            }
        }
    }
    bytes
}

/// What a reader makes of it must be whole: as many extra values as samples.
fn read_and_check(input: &Input, options: &ReadOptions) -> Result<(), TestCaseError> {
    match read_input(input, options) {
        Ok(recording) => {
            for extra in &recording.extra {
                prop_assert_eq!(extra.values.len(), recording.len());
            }
            prop_assert!(!recording.is_empty());
            prop_assert_eq!(recording.samples().count(), recording.len());
        }
        Err(error) => prop_assert!(!error.to_string().contains('\n')),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn no_mutation_panics(
        seed in any::<prop::sample::Index>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<u8>()), 0..12),
        format in prop::option::of(prop::sample::select(FORMATS)),
        with_screen in any::<bool>(),
    ) {
        let seeds = seeds();
        let bytes = edited(seeds[seed.index(seeds.len())].clone(), &edits);
        let Ok(input) = Input::of_bytes(Path::new("mutated"), bytes) else { return Ok(()) };
        let screen = Screen { size_px: DVec2::new(1600.0, 1200.0), size_m: DVec2::ONE, distance_m: 1.0 };
        let options = ReadOptions {
            format: format.map(|format| format.name.to_owned()),
            screen: with_screen.then_some(screen),
            ..ReadOptions::default()
        };
        read_and_check(&input, &options)?;
    }
}
