//! The page: whole, safe, and with a conclusion that follows from the figures.

use super::*;
use crate::estimate::EyeState;

fn page_of(session: &SessionGaze, readout_ms: f64, radius_deg: f64) -> String {
    let mut model = steady();
    constant(&mut model, Stage::Readout, readout_ms);
    let settings = RunSettings { radius_deg, sweep_points: 9, ..RunSettings::default() };
    let run = run(session, &model, &settings, 1).expect("a run");
    let summary = run.summary(session, run.budget(session, None));
    page(&report_data(&run, session, summary, "<script>alert(1)</script> & \"co\".tsv"))
}

/// Elements that end, in order; void ones and those that end themselves left out.
fn check_nesting(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let body = html.split_once("</style>").expect("a style").1;
    for part in body.split('<').skip(1) {
        let tag = part.split('>').next().expect("a tag");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().expect("a name");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{part}");
        } else if !tag.ends_with('/') && !["br", "meta", "!doctype"].contains(&name) {
            open.push(name);
        }
    }
    // The style ended within the head, which was opened before.
    assert_eq!(open, Vec::<&str>::new());
}

fn check(html: &str) {
    let nested = html.replacen("</style>", "</style><html><head>", 1);
    check_nesting(&nested);
    assert!(!html.contains("{{") && !html.contains("NaN") && !html.contains("inf "));
    assert!(!html.contains("<script") && html.contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp;"));
    assert!(!html.contains("http") && !html.contains("url(") && !html.contains("@import"));
    assert_eq!(html.matches("<svg").count(), html.matches("role=\"img\"><title>").count());
    for label in ["Time, s", "Azimuth, deg", "Elevation, deg", "Error, deg", "Age, ms", "Radius needed, deg"]
    {
        assert!(html.contains(&format!(">{label}</text>")), "{label}");
    }
}

#[test]
fn a_pursuit_within_the_radius_works_and_beyond_it_does_not() {
    // 20 deg/s: 2 degrees behind after 100 ms.
    let session = session(3.0, MS, |time| 20.0 * time - 30.0).with_intervals(&[EyeInterval {
        state: EyeState::Pursuit,
        start_ns: 0,
        end_ns: 3000 * MS,
    }]);
    let works = page_of(&session, 100.0, 2.5);
    check(&works);
    assert!(works.contains("Foveation works with this latency and a radius of 2.5"));
    assert!(works.contains("verdict good"));
    let fails = page_of(&session, 100.0, 1.5);
    check(&fails);
    assert!(fails.contains("Foveation does not work with this latency and a radius of 1.5"));
    assert!(fails.contains("outside the 1.5° of full quality for 100.00 %"));
    assert!(fails.contains("It would need a radius of 2.00°."));
    assert!(fails.contains("with this radius it may be 75.0 ms old"));
    assert!(fails.contains("Attack readout first (100.0 ms)"));
}

#[test]
fn a_page_of_next_to_nothing_is_a_page() {
    let mut recording = Recording::new(RecordingInfo::default());
    recording.push(&looking(0, 1.0));
    recording.push(&looking(1, 1.0));
    let nothing = SessionGaze::new(&recording).expect("a session");
    let html = page_of(&nothing, 3.0, 5.0);
    check(&html);
    assert!(html.contains("cannot tell whether foveation works"));
}

#[test]
fn the_closer_look_is_at_the_misses() {
    // At rest for 30 s, but for a pursuit of 50 deg/s around 20 s, 5 degrees behind after 100 ms.
    let session = session(30.0, 2 * MS, |time| (time - 20.0).clamp(0.0, 0.5) * 50.0);
    let mut model = steady();
    constant(&mut model, Stage::Readout, 100.0);
    let settings = RunSettings { radius_deg: 3.0, sweep_points: 2, ..RunSettings::default() };
    let run = run(&session, &model, &settings, 1).expect("a run");
    let summary = run.summary(&session, run.budget(&session, None));
    let data = report_data(&run, &session, summary, "rest");
    let missed: Vec<f64> = data.close.iter().filter(|point| point.missed).map(|point| point.time_s).collect();
    assert_eq!(missed.len(), run.frames.iter().filter(|frame| frame.outside).count());
    assert!(missed.iter().all(|time| (20.05..20.6).contains(time)));
    assert!(data.close.len() <= 402 && data.overview.len() == 480);
    let share: f64 = data.error_deg.shares.iter().sum();
    assert!((share - 1.0).abs() < 1e-9);
}
