//! The tables of the shared recordings, against figures counted without the readers.

use super::{ReadOptions, read};
use crate::recording::Recording;
use crate::testing::shared;

/// What a file holds.
struct Counted {
    file: &'static str,
    format: &'static str,
    samples: usize,
    /// Samples of which the gaze of both, the left or the right can be used.
    valid: usize,
    duration_s: f64,
    rate_hz: f64,
}

/// Counted with Python's csv module: rows with a time; of Vive, bit 1 of `eye_valid` of either eye; of
/// Pupil, worn and no blink id; of Pico, a vector that is not 0; of Tobii, a validity of 0 or 1. The rate is one
/// over the median step of the ascending ones.
const COUNTED: &[Counted] = &[
    Counted {
        file: "eyedentify3d_vive_pro_eye/TESTNA01_360VR_Fist3.csv",
        format: "sranipal-csv",
        samples: 1665,
        valid: 1633,
        duration_s: 13.864,
        rate_hz: 125.0,
    },
    Counted {
        file: "eyedentify3d_vive_pro_eye/TESTNA01_2D_Fist3.csv",
        format: "sranipal-csv",
        samples: 1518,
        valid: 1308,
        duration_s: 12.639,
        rate_hz: 125.0,
    },
    Counted {
        file: "eyedentify3d_pico_neo3/boxing_VR.csv",
        format: "pico-csv",
        samples: 492,
        valid: 486,
        duration_s: 5.455_562_89,
        rate_hz: 90.0,
    },
    Counted {
        file: "eyedentify3d_pupil_invisible/gaze.csv",
        format: "pupil-cloud-csv",
        samples: 5338,
        valid: 3235,
        duration_s: 26.751_992,
        rate_hz: 1e3 / 4.022,
    },
    Counted {
        file: "i2mc_tobii_tx300/1.tsv",
        format: "tobii-sdk-tsv",
        samples: 651,
        valid: 642,
        duration_s: 2.166_361,
        rate_hz: 1e6 / 3351.0,
    },
    Counted {
        file: "pymovements_samples/gazebase_example.csv",
        format: "gazebase-csv",
        samples: 10,
        valid: 10,
        duration_s: 0.009,
        rate_hz: 1000.0,
    },
    Counted {
        file: "pymovements_samples/gazebase_vr_example.csv",
        format: "gazebase-vr-csv",
        samples: 10,
        valid: 10,
        duration_s: 0.035_943,
        rate_hz: 1e3 / 3.9926,
    },
    Counted {
        file: "pymovements_samples/judo1000_example.csv",
        format: "judo1000-tsv",
        samples: 10,
        valid: 10,
        duration_s: 0.009,
        rate_hz: 1000.0,
    },
];

fn usable(recording: &Recording) -> usize {
    let usable = |eye: &crate::sample::EyeSample| eye.valid;
    recording.samples().filter(|s| usable(&s.combined) || usable(&s.left) || usable(&s.right)).count()
}

#[test]
fn the_shared_tables_read_as_counted() {
    let Some(folder) = shared("data/gaze") else { return };
    for counted in COUNTED {
        let file = counted.file;
        let recording = read(&folder.join(file), &ReadOptions::default()).expect(file);
        assert_eq!(recording.info.format, counted.format, "{file}");
        assert_eq!(recording.len(), counted.samples, "{file}");
        assert_eq!(usable(&recording), counted.valid, "{file}");
        let duration_s = recording.duration_s();
        assert!((duration_s - counted.duration_s).abs() < 2e-9, "{file}: {duration_s}");
        let rate_hz = recording.rate_hz().expect("many samples");
        assert!((rate_hz / counted.rate_hz - 1.0).abs() < 1e-3, "{file}: {rate_hz}");
        assert_eq!(recording.info.skipped, [], "{file}");
    }
}

#[test]
fn the_damaged_file_of_the_vive_says_what_is_wrong() {
    let Some(file) = shared("data/gaze/eyedentify3d_vive_pro_eye/TESTVA03_2D_Spread9.csv") else { return };
    let error = read(&file, &ReadOptions::default()).expect_err("no samples").to_string();
    assert!(error.contains("holds a header but no samples"), "{error}");
}

#[test]
fn the_vive_keeps_its_device_clock_and_its_arrivals() {
    let Some(file) = shared("data/gaze/eyedentify3d_vive_pro_eye/TESTNA01_2D_Fist3.csv") else { return };
    let recording = read(&file, &ReadOptions::default()).expect("a good file");
    let first = recording.get(0).expect("not empty");
    // -1512415845 ms is 2782551451 ms as 32 bits without a sign.
    assert_eq!(first.device_time_ns, Some(2_782_551_451_000_000));
    // 638342794000115346 ticks less 621355968000000000 are 16986826000115346 of 100 ns.
    assert_eq!(first.received_ns, 1_698_682_600_011_534_600);
    assert!(recording.samples().all(|sample| sample.time_ns <= sample.received_ns));
    assert!(recording.samples().any(|sample| sample.time_ns == sample.received_ns));
}
