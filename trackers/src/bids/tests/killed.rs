//! A process that records and is killed: this test itself, run once more.

use super::{Recorder, load};
use crate::recording::RecordingInfo;
use crate::sample::GazeSample;
use crate::time::host_now_ns;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const FOLDER: &str = "MACULA_TEST_RECORDS_INTO";
const SECOND_NS: i64 = 1_000_000_000;
/// Before each line, among what the tests' own output says.
const MARK: &str = "pushed ";

/// Records until killed, and tells after each sample when it was taken and when that was done.
fn record(folder: &Path) -> ! {
    let mut recorder = Recorder::create(&folder.join("me"), &RecordingInfo::default(), &[]).expect("created");
    // Not captured, and not buffered for longer than a line.
    let mut told = std::io::stdout();
    loop {
        let taken_ns = host_now_ns();
        recorder.push(&GazeSample::at(taken_ns)).expect("on the disk, or waiting");
        writeln!(told, "{MARK}{taken_ns} {}", host_now_ns()).expect("the parent reads");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_killed_process_loses_at_most_its_last_second() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        record(Path::new(&folder));
    }
    let folder = super::folder();
    let name = "bids::tests::killed::a_killed_process_loses_at_most_its_last_second";
    let mut child = Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", name, "--nocapture"])
        .env(FOLDER, folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a second process");
    // (taken, done) of each sample; half a second after the first that must be there.
    let mut pushed: Vec<(i64, i64)> = Vec::new();
    let mut lines = BufReader::new(child.stdout.take().expect("its output")).lines();
    let mut read = |pushed: &mut Vec<(i64, i64)>| {
        let Some(Ok(line)) = lines.next() else { return false };
        let times = line.rsplit_once(MARK).and_then(|(_, times)| times.split_once(' '));
        pushed.extend(times.and_then(|(taken, done)| Some((taken.parse().ok()?, done.parse().ok()?))));
        true
    };
    while pushed.last().map_or(0, |last| last.0 - pushed[0].0) < SECOND_NS * 3 / 2 {
        assert!(read(&mut pushed), "it records until it is killed");
    }
    child.kill().expect("SIGKILL");
    // What it had told by then.
    while read(&mut pushed) {}
    assert!(!child.wait().expect("its end").success());

    let recording = load(&folder.path().join("me_recording-eye3_physio.tsv.gz"));
    // The last push returned, so whatever had waited for a second when it began is on the disk.
    let must_ns = pushed.last().expect("samples").0 - SECOND_NS;
    let must = pushed.iter().filter(|(_, done_ns)| *done_ns <= must_ns).count();
    assert!(must > 0 && recording.len() >= must, "{} of {}, {must} at least", recording.len(), pushed.len());
    let taken: Vec<i64> = pushed.iter().map(|pair| pair.0).take(recording.len()).collect();
    // One sample may be on the disk that it could not tell of any more.
    assert_eq!(recording.times_ns()[..taken.len()], taken);
    assert!(recording.len() <= pushed.len() + 1);
    assert_eq!(recording.info.notes.len(), 1, "{:?}", recording.info.notes);
}
