//! `macula gaze`: sources to recordings, recordings to others, and what goes wrong on the way.

use macula_tests::cli::{Place, failure, json, macula, run};
use macula_tests::data::{recording, workspace};
use macula_trackers::EyeState;
use macula_trackers::formats::{ReadOptions, read};
use macula_trackers::recording::Recording;
use macula_trackers::sample::GazeSample;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A recording of two seconds at 120 Hz.
fn synth(place: &Place, name: &str) -> String {
    let path = place.path(name);
    let arguments = ["gaze", "synth", "-o", &path, "--preset", "vr-exploration", "--seconds", "2", "--json"];
    let told = json(&run(&arguments), "synth");
    assert_eq!((&told["samples"], &told["rate_hz"]), (&Value::from(240), &Value::from(120.0)));
    format!("{path}_recording-eye3_physio.tsv.gz")
}

fn load(path: impl AsRef<Path>) -> Recording {
    read(path.as_ref(), &ReadOptions::default()).expect("a recording")
}

fn samples(path: impl AsRef<Path>) -> Vec<GazeSample> {
    load(path).samples().collect()
}

/// `macula gaze record` under way, and the first line that it said.
struct Recorder {
    child: Child,
    first_line: String,
}

impl Recorder {
    fn start(arguments: &[&str]) -> Self {
        let mut command = macula(&["gaze", "record"]);
        command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("macula runs");
        let mut first_line = String::new();
        let stderr = child.stderr.take().expect("piped");
        let mut stderr = BufReader::new(stderr);
        stderr.read_line(&mut first_line).expect("a line");
        // What else it says must find a reader.
        std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
        Self { child, first_line }
    }

    /// A socket that sends to its bridge.
    fn sender(&self) -> UdpSocket {
        let (_, rest) = self.first_line.split_once("UDP port ").expect("a port");
        let port: u16 = rest.split(' ').next().unwrap_or_default().parse().expect("a port");
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(("127.0.0.1", port)).unwrap();
        socket
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    fn end(self) -> Value {
        json(&self.child.wait_with_output().unwrap(), "record")
    }
}

fn line(number: u32) -> Vec<u8> {
    let x = f64::from(number) * 1e-3;
    format!(r#"{{"t_ns": {}, "dir": [{x}, 0.25, -1.0]}}"#, u64::from(number) * 5_000_000).into_bytes()
}

#[test]
fn a_synthetic_session_converts_without_loss() {
    let place = Place::new();
    let made = synth(&place, "eye");
    let info = json(&run(&["gaze", "info", &made, "--json"]), "info");
    assert_eq!((&info["samples"], &info["space"]), (&Value::from(240), &Value::from("view")));
    let converted = place.path("again_physio");
    let told = json(&run(&["gaze", "convert", &made, &converted, "--json"]), "convert");
    assert_eq!((&told["samples"], &told["extra_columns"]), (&Value::from(240), &Value::from(4)));
    let (before, after) = (load(&made), load(format!("{converted}.tsv.gz")));
    assert_eq!(before.samples().collect::<Vec<_>>(), after.samples().collect::<Vec<_>>());
    assert_eq!(before.extra, after.extra);
    assert_eq!(before.info, after.info);
    // The truth is of the same eye: a saccade is somewhere in two seconds of looking about.
    assert!(after.extra_column("evt_truth").is_some_and(|labels| labels.contains(&2.0)));
}

#[test]
fn settings_go_over_the_preset() {
    let place = Place::new();
    let shown = run(&["gaze", "synth", "--preset", "reading", "--show-settings"]);
    let shown = String::from_utf8(shown.stdout).unwrap();
    let mine = place.path("mine.toml");
    std::fs::write(&mine, shown.replace("rate_hz = 1000.0", "rate_hz = 500.0")).unwrap();
    let path = place.path("eye");
    let synth = |settings: &str| {
        let arguments =
            ["gaze", "synth", "-o", &path, "--preset", "reading", "--seconds", "1", "--settings", settings];
        run(&[&arguments[..], &["--json", "--force"]].concat())
    };
    assert_eq!(json(&synth(&mine), "whole")["samples"], 500);
    std::fs::write(&mine, "[tracker]\nrate_hz = 250.0\n").unwrap();
    assert_eq!(json(&synth(&mine), "part")["samples"], 250);
    for wrong in ["[tracker]\nrate = 1\n", "[tracker", "tracker = 1"] {
        std::fs::write(&mine, wrong).unwrap();
        assert!(failure(&synth(&mine), 1, wrong).contains("mine.toml"));
    }
    std::fs::write(&mine, "[tracker]\nlatency_ms = -1.0\n").unwrap();
    assert!(failure(&synth(&mine), 2, "range").contains("tracker.latency_ms"));
}

#[test]
fn events_of_a_recording_are_converted_too() {
    let place = Place::new();
    let asc = "** CONVERTED FROM x.edf\n\
        MSG\t100 DISPLAY_COORDS 0 0 1919 1079\n\
        START\t100 \tRIGHT\tSAMPLES\tEVENTS\n\
        SAMPLES\tGAZE\tRIGHT\tRATE\t1000.00\tTRACKING\tCR\tFILTER\t2\n\
        SFIX R   100\n100\t960.0\t540.0\t1000.0\t...\n101\t960.0\t540.0\t1000.0\t...\n\
        102\t961.0\t540.0\t1000.0\t...\nEFIX R   100\t102\t3\t960.3\t540.0\t1000\n\
        SSACC R   103\n103\t980.0\t540.0\t1000.0\t...\n104\t990.0\t540.0\t1000.0\t...\n\
        ESACC R   103\t104\t2\t980.0\t540.0\t990.0\t540.0\t0.5\t100\nEND\t104 \tSAMPLES\tEVENTS\n";
    let file = place.path("eye.asc");
    std::fs::write(&file, asc).unwrap();
    let told = json(&run(&["gaze", "convert", &file, &place.path("eye"), "--json"]), "convert");
    assert_eq!((&told["format"], &told["events"]), (&Value::from("eyelink-asc"), &Value::from(2)));
    let events = load(place.path("eye_recording-eye3_physio.json")).events;
    let spans: Vec<_> = events.iter().map(|event| (event.kind, event.start_ns, event.end_ns)).collect();
    let ms = 1_000_000;
    assert_eq!(spans, [(EyeState::Fixation, 100 * ms, 102 * ms), (EyeState::Saccade, 103 * ms, 104 * ms)]);
}

#[test]
fn a_stepped_replay_records_what_was_recorded() {
    let place = Place::new();
    let made = synth(&place, "eye");
    for (file, name) in [
        (made, "a"),
        (recording("eyedentify3d/vive_blink.csv"), "b"),
        (recording("layouts/pupil_core.csv"), "c"),
    ] {
        let output = place.path(name);
        let told =
            json(&run(&["gaze", "record", "--replay", &file, "--fast", "-o", &output, "--json"]), &file);
        // Replayed by arrival; those of one arrival as in the file.
        let mut expected = samples(&file);
        expected.sort_by_key(|sample| sample.received_ns);
        let recorded = samples(format!("{output}_recording-eye3_physio.tsv.gz"));
        assert_eq!(recorded, expected, "{file}");
        assert_eq!((&told["samples"], &told["end"]), (&Value::from(expected.len()), &Value::from("ended")));
    }
    let notes = load(place.path("a_recording-eye3_physio.json")).info.notes;
    assert!(notes.iter().any(|note| note.contains("evt_truth")), "{notes:?}");
}

#[test]
fn a_synthetic_eye_by_a_stepped_clock_is_the_same_again() {
    let place = Place::new();
    let record = |name: &str| {
        let output = place.path(name);
        let arguments = ["--synth", "vr-exploration", "--seed", "3", "--fast", "--seconds", "5", "--json"];
        let told = json(&run(&[&["gaze", "record", "-o", &output][..], &arguments].concat()), name);
        assert_eq!(told["end"], "time");
        samples(format!("{output}_recording-eye3_physio.tsv.gz"))
    };
    let recorded = record("a");
    assert!(recorded.len() > 590, "{} samples", recorded.len());
    assert!(recorded.iter().all(|sample| sample.received_ns <= 5_000_000_000));
    assert_eq!(recorded, record("b"));
}

#[test]
fn no_device_is_no_failure() {
    let list = json(&run(&["gaze", "devices", "--json"]), "devices");
    let devices = list["devices"].as_array().expect("a list");
    if !devices.is_empty() {
        println!("skipped: there is a tracker");
        return;
    }
    let told = run(&["gaze", "devices"]);
    let text = String::from_utf8(told.stdout).unwrap();
    assert!(told.status.success());
    for word in ["No eye tracker", "FOVE", "Tobii", "Vive", "Varjo", "--bridge", "host_source", "--replay"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let place = Place::new();
    for source in [&[][..], &["--device", "04d8:003f"], &["--device", "/dev/hidraw99"]] {
        for command in [&["gaze", "monitor"][..], &["gaze", "record", "-o", &place.path("x")]] {
            failure(&run(&[command, source].concat()), 1, "no device");
        }
    }
    assert!(place.names().is_empty());
}

#[test]
fn wrong_arguments_are_one_line() {
    let place = Place::new();
    let (out, missing, broken) = (place.path("out"), place.path("missing.csv"), place.path("broken.csv"));
    std::fs::write(&broken, "\0\0\0").unwrap();
    let there = place.path("there.tsv.gz");
    std::fs::write(&there, "mine").unwrap();
    // Where not even the superuser may make a file.
    let unwritable = "/proc/macula";
    let nowhere = place.path("no/such/folder/x");
    let good = recording("eyedentify3d/vive_blink.csv");
    let before = place.names();
    for (code, arguments, named) in [
        (2, vec!["synth", "-o", &out, "--preset", "asleep"], "asleep"),
        (2, vec!["synth", "-o", &out, "--tracker", "none"], "none"),
        (2, vec!["synth", "-o", &out, "--seconds", "0"], "0"),
        (2, vec!["synth", "-o", &out, "--seconds", "1", "--rate", "99999"], "rate"),
        (2, vec!["synth", "--preset", "reading"], "--output"),
        (1, vec!["synth", "-o", &there, "--seconds", "1"], "there.tsv.gz"),
        (1, vec!["synth", "-o", &nowhere, "--seconds", "1"], "no/such/folder"),
        (1, vec!["synth", "-o", &out, "--settings", &missing], "missing.csv"),
        (1, vec!["convert", &missing, &out], "missing.csv"),
        (1, vec!["convert", &broken, &out], "broken.csv"),
        (1, vec!["convert", &good, &there], "there.tsv.gz"),
        (1, vec!["convert", &good, &nowhere], "no/such/folder"),
        (1, vec!["record", "--replay", &missing, "-o", &out], "missing.csv"),
        (1, vec!["record", "--replay", &broken, "-o", &out], "broken.csv"),
        (1, vec!["record", "--replay", &good, "-o", &there], "there.tsv.gz"),
        (1, vec!["record", "--replay", &good, "-o", &nowhere], "no/such/folder"),
        (1, vec!["synth", "-o", unwritable, "--seconds", "1"], unwritable),
        (1, vec!["convert", &good, unwritable], unwritable),
        (1, vec!["record", "--replay", &good, "-o", unwritable], unwritable),
        (2, vec!["record", "--replay", &good, "-o", &out, "--speed", "0"], "speed 0"),
        (2, vec!["record", "--synth", "asleep", "-o", &out], "asleep"),
        (2, vec!["record", "--synth", "reading", "--fast", "-o", &out], "--seconds"),
        (2, vec!["record", "--bridge", "udp:0", "--fast", "--seconds", "1", "-o", &out], "--fast"),
        (2, vec!["record", "--synth", "reading", "--replay", &good, "-o", &out], "--replay"),
        (2, vec!["monitor", "--bridge", "tcp:5"], "udp:PORT"),
        (2, vec!["monitor", "--seconds", "1e9", "--synth", "reading"], "at most"),
        (1, vec!["monitor", "--bridge", &format!("unix:{there}")], "there.tsv.gz"),
    ] {
        let arguments = [&["gaze"][..], &arguments].concat();
        let line = failure(&run(&arguments), code, &arguments.join(" "));
        assert!(line.contains(named), "{line}");
    }
    assert_eq!(place.names(), before);
    assert_eq!(std::fs::read(&there).unwrap(), b"mine");
}

#[test]
fn a_recording_is_replaced_only_by_force_and_never_by_itself() {
    let place = Place::new();
    let good = recording("eyedentify3d/vive_blink.csv");
    let out = place.path("x.tsv.gz");
    assert!(run(&["gaze", "convert", &good, &out]).status.success());
    failure(&run(&["gaze", "convert", &good, &out]), 1, "there");
    assert!(run(&["gaze", "convert", &good, &out, "--force"]).status.success());
    let before = std::fs::read(&out).unwrap();
    for input in [out.clone(), place.path("x.json")] {
        assert!(failure(&run(&["gaze", "convert", &input, &out, "--force"]), 2, "itself").contains("itself"));
    }
    assert_eq!(std::fs::read(&out).unwrap(), before);
}

#[test]
fn rubbish_on_a_bridge_is_counted_and_the_rest_recorded() {
    let place = Place::new();
    let output = place.path("bridge");
    let recorder = Recorder::start(&["--bridge", "udp:0", "-o", &output, "--json"]);
    let sender = recorder.sender();
    for number in 0..100 {
        if number % 10 == 3 {
            sender.send(b"{\"point\": \"rubbish\"}").unwrap();
        }
        sender.send(&line(number)).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    recorder.signal("-INT");
    let told = recorder.end();
    assert_eq!((&told["samples"], &told["rejected"]), (&Value::from(100), &Value::from(10)), "{told}");
    assert_eq!(told["end"], "interrupted");
    assert!(told["stalls"].as_u64() >= Some(1), "silence is told: {told}");
    let recording = load(format!("{output}_recording-eye3_physio.tsv.gz"));
    for (number, sample) in recording.samples().enumerate() {
        assert_eq!(sample.device_time_ns, Some(number as i64 * 5_000_000));
        assert_eq!(sample.combined.direction.map(|direction| direction.x), Some(number as f64 * 1e-3));
    }
    assert_eq!(recording.info.skipped.iter().map(|skipped| skipped.rows).sum::<u64>(), 10);
    assert!(recording.info.notes.iter().any(|note| note.contains("nothing new")));
}

#[test]
fn a_killed_recording_lacks_at_most_the_last_second() {
    let place = Place::new();
    let output = place.path("killed");
    let mut recorder = Recorder::start(&["--bridge", "udp:0", "-o", &output]);
    let sender = recorder.sender();
    let begun = Instant::now();
    let mut sent = 0;
    while begun.elapsed() < Duration::from_millis(3300) {
        sender.send(&line(sent)).unwrap();
        sent += 1;
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent_s = begun.elapsed().as_secs_f64();
    recorder.child.kill().unwrap();
    recorder.child.wait().unwrap();
    let file = format!("{output}_recording-eye3_physio.tsv.gz");
    let info = json(&run(&["gaze", "info", &file, "--json"]), "info");
    // A second, and what the disk and the scheduler take.
    let least = f64::from(sent) * (1.0 - 1.3 / sent_s);
    let recorded = info["samples"].as_f64().expect("a count");
    assert!(recorded >= least, "{recorded} of {sent}, at least {least}");
    assert!(info["notes"].to_string().contains("not ended"), "{info}");
    let times: Vec<_> = samples(&file).iter().filter_map(|sample| sample.device_time_ns).collect();
    assert!(times.iter().enumerate().all(|(number, time)| *time == number as i64 * 5_000_000));
}

#[test]
fn a_monitor_tells_each_second_and_the_sum() {
    let place = Place::new();
    let made = synth(&place, "eye");
    let output = run(&["gaze", "monitor", "--replay", &made, "--seconds", "20"]);
    assert!(output.status.success());
    let lines: Vec<Value> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).expect("a JSON line"))
        .collect();
    let kinds: Vec<_> = lines.iter().map(|line| line["type"].as_str().unwrap_or_default()).collect();
    // Arrivals span just under two seconds, so that the second line may come or not.
    assert!(kinds.starts_with(&["state"]) && kinds.ends_with(&["ended", "summary"]), "{kinds:?}");
    let rate_hz = lines[0]["rate_hz"].as_f64().expect("a rate");
    assert!((rate_hz - 120.0).abs() < 6.0, "{rate_hz}");
    let summary = &lines[lines.len() - 1];
    assert_eq!((&summary["samples"], &summary["end"]), (&Value::from(240), &Value::from("ended")));
}

/// The commands in the README beside the data, and what they wrote once.
fn commands() -> Vec<(Vec<String>, PathBuf)> {
    let folder = workspace().join("trackers/tests/data/synthetic");
    let readme = std::fs::read_to_string(folder.join("README.md")).expect("a README");
    let commands = readme.lines().filter_map(|line| line.trim().strip_prefix("macula "));
    commands
        .map(|command| {
            let words: Vec<_> = command.split_whitespace().map(str::to_owned).collect();
            let output = words.iter().position(|word| word == "-o").expect("an output") + 1;
            let file = folder.join(format!("{}.tsv.gz", words[output]));
            (words, file)
        })
        .collect()
}

#[test]
fn the_synthetic_test_data_is_made_again_by_its_command() {
    let place = Place::new();
    let commands = commands();
    assert_eq!(commands.len(), 2);
    for (words, file) in commands {
        let made: Vec<PathBuf> = (0..2)
            .map(|number| {
                let folder = place.folder().join(number.to_string());
                std::fs::create_dir_all(&folder).unwrap();
                let words: Vec<_> = words.iter().map(String::as_str).collect();
                let made = macula(&words).current_dir(&folder).output().expect("macula runs");
                assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
                folder.join(file.file_name().unwrap())
            })
            .collect();
        for path in [&made[0], &made[0].with_file_name(file_stem(&file) + ".json")] {
            let other = made[1].with_file_name(path.file_name().unwrap());
            assert_eq!(std::fs::read(path).unwrap(), std::fs::read(other).unwrap(), "{}", path.display());
        }
        assert_alike(&load(&made[0]), &load(&file), &file);
    }
}

fn file_stem(file: &Path) -> String {
    file.file_name().unwrap().to_string_lossy().trim_end_matches(".tsv.gz").to_owned()
}

/// Equal but for the last of the five decimals, which depends on the system's sine and cosine.
fn assert_alike(made: &Recording, kept: &Recording, file: &Path) {
    assert_eq!(made.len(), kept.len(), "{}", file.display());
    assert_eq!(made.times_ns(), kept.times_ns(), "{}", file.display());
    for (made, kept) in made.samples().zip(kept.samples()) {
        for (made, kept) in [(made.combined, kept.combined), (made.left, kept.left), (made.right, kept.right)]
        {
            assert_eq!(made.valid, kept.valid, "{}", file.display());
            assert_eq!(made.direction.is_some(), kept.direction.is_some());
            if let (Some(made), Some(kept)) = (made.direction, kept.direction) {
                assert!(made.abs_diff_eq(kept, 1.5e-5), "{}: {made} and {kept}", file.display());
            }
        }
    }
    assert_eq!(made.extra_column("evt_truth"), kept.extra_column("evt_truth"));
}
