//! Mutated descriptors and reports: never a panic, never more memory than stated. The same properties as
//! the fuzz targets, bounded.

use super::{TRACKER, report};
use crate::hid::{Layout, Role};
use crate::testing::shared;
use proptest::prelude::*;

fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![TRACKER.to_vec()];
    for entry in shared("data/hid").into_iter().flat_map(std::fs::read_dir).flatten().flatten() {
        if entry.path().extension().is_some_and(|extension| extension == "bin") {
            seeds.extend(std::fs::read(entry.path()));
        }
    }
    seeds
}

#[derive(Clone, Copy, Debug)]
enum Edit {
    Set(u8),
    Insert(u8),
    Remove,
    /// Repeats so many bytes from here on.
    Repeat(usize),
}

fn edits() -> impl Strategy<Value = Vec<(prop::sample::Index, Edit)>> {
    // Bytes of main, global and local items and extreme numbers go deeper than any byte.
    let byte =
        prop_oneof![any::<u8>(), prop::sample::select(&b"\x81\xb1\xa1\xc0\xa4\xb4\x97\x77\xff\x00"[..])];
    let edit = prop_oneof![
        4 => byte.clone().prop_map(Edit::Set),
        2 => byte.prop_map(Edit::Insert),
        2 => Just(Edit::Remove),
        1 => (1usize..64).prop_map(Edit::Repeat),
    ];
    prop::collection::vec((any::<prop::sample::Index>(), edit), 0..12)
}

fn mutate(bytes: &mut Vec<u8>, edits: &[(prop::sample::Index, Edit)]) {
    for (index, edit) in edits {
        if bytes.is_empty() {
            return;
        }
        let at = index.index(bytes.len());
        match *edit {
            Edit::Set(byte) => bytes[at] = byte,
            Edit::Insert(byte) => bytes.insert(at, byte),
            Edit::Remove => drop(bytes.remove(at)),
            Edit::Repeat(length) => {
                let end = (at + length).min(bytes.len());
                bytes.extend_from_within(at..end);
            }
        }
    }
}

/// What holds for every descriptor and report.
fn check(layout: &Layout, bytes: &[u8]) -> Result<(), TestCaseError> {
    let Ok(decoded) = layout.decode(bytes) else { return Ok(()) };
    for &role in Role::ALL {
        prop_assert!(decoded.value(role).is_none() || decoded.raw(role).is_some());
    }
    let sample = decoded.to_sample(decoded.configuration().screen_m(), i64::MAX);
    for eye in [&sample.combined, &sample.left, &sample.right] {
        prop_assert!(eye.direction.is_none_or(|direction| (direction.length() - 1.0).abs() < 1e-9));
        prop_assert!(!eye.valid || eye.point.is_some() || eye.direction.is_some());
    }
    let fields = layout.raw_fields(bytes).expect("it was decoded").count();
    prop_assert!(fields <= bytes.len() * 8);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_descriptors_and_reports(
        seed in any::<prop::sample::Index>(),
        edits in edits(),
        bytes in prop::collection::vec(any::<u8>(), 0..80),
    ) {
        let seeds = seeds();
        let mut descriptor = seeds[seed.index(seeds.len())].clone();
        mutate(&mut descriptor, &edits);
        if let Ok(layout) = Layout::parse(&descriptor) {
            let fields: usize = layout.reports.iter().map(|report| report.fields.len()).sum();
            prop_assert!(fields <= 1 << 18);
            check(&layout, &bytes)?;
            for report in layout.reports.iter().filter(|report| report.bytes < 1 << 16) {
                let mut fitting = bytes.clone();
                fitting.resize(report.bytes, 0xff);
                if let Some(first) = fitting.first_mut().filter(|_| layout.has_ids) {
                    *first = report.id;
                }
                check(&layout, &fitting)?;
                let _ = layout.decode_feature(&fitting);
            }
        }
    }

    #[test]
    fn any_bytes(descriptor in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = Layout::parse(&descriptor);
    }

    #[test]
    fn mutated_reports(time in any::<u64>(), values in any::<[i32; 8]>(), edits in edits()) {
        let layout = Layout::parse(TRACKER).expect("a good descriptor");
        let mut bytes = report(time, values);
        let decoded = layout.decode(&bytes).expect("a good report");
        let told = [Role::GazeX, Role::GazeY, Role::LeftX, Role::LeftY, Role::LeftZ, Role::RightX, Role::RightY];
        for (role, value) in told.into_iter().zip(values) {
            prop_assert_eq!(decoded.raw(role), Some(i64::from(value)));
        }
        mutate(&mut bytes, &edits);
        check(&layout, &bytes)?;
    }
}
