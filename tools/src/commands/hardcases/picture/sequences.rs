//! Sequences of frames: each frame is that of its own gaze, whatever came before it.
//!
//! The engine keeps nothing from frame to frame but the last valid gaze: every expected picture is that of
//! another renderer, which went through the gazes in another order.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::{Subject, methods};
use super::scenes::pattern;
use super::stage::{Frame, frame, looking_ahead, renderer, upload};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use macula::headless::OffscreenRenderer;
use macula::renderer::FrameSlot;
use macula::settings::Method;

/// What the catalogue names and the engine does not have: name and reason. The family `history` fails once
/// a pass keeps something from frame to frame.
pub const LEFT_OUT: [(&str, &str); 4] = [
    ("history after jumps, cuts and disocclusion", "no pass reads what an earlier frame left"),
    ("a NaN in the history", "there is no history"),
    (
        "jitter sequences and 2^24 frames",
        "nothing is jittered, and frame numbers only choose one of two slots",
    ),
    ("a display that changes its size", "a renderer has one size; the family `frames` makes one for each"),
];

const SIZE: [u32; 2] = [128, 72];

/// Fine enough for the acuity to ask for fewer samples than pixels.
fn display() -> DisplayGeometry {
    DisplayGeometry::symmetric(SIZE, 1.5)
}

pub fn families() -> Vec<Family> {
    let family = |name, what, cases| Family {
        name,
        what,
        part: Part::Temporal,
        place: Place::Gpu,
        bound: 0.0,
        unit: "values",
        cases,
    };
    vec![
        family("gaze-jump", "after a jump of the gaze the frame is that of the new gaze alone", || {
            cases(true, true, jumps)
        }),
        family(
            "no-gaze",
            "a gaze that is none keeps the last one, or the centre at first, and says so",
            || cases(true, true, no_gaze),
        ),
        family("run-to-run", "another run gives the same picture, bit for bit", || cases(false, true, again)),
        family("dropped-frame", "a frame that is recorded and not submitted changes no other", || {
            cases(false, true, dropped)
        }),
        family("late-latch", "a gaze latched late gives the picture of a gaze recorded", || {
            cases(true, true, latched)
        }),
        family("history", "no pass keeps anything from frame to frame", histories),
    ]
}

/// A renderer, and another one for the expected pictures.
struct Sequence {
    renderer: OffscreenRenderer,
    other: OffscreenRenderer,
}

impl Sequence {
    fn next(&mut self, gaze_px: DVec2) -> Result<Frame, Failure> {
        frame(&mut self.renderer, SIZE, &looking_ahead(gaze_px))
    }

    /// What the frame of a gaze must be.
    fn expected(&mut self, gaze_px: DVec2) -> Result<Frame, Failure> {
        frame(&mut self.other, SIZE, &looking_ahead(gaze_px))
    }

    /// The frame that was launched last.
    fn finish(&mut self, slot: FrameSlot) -> Result<Frame, Failure> {
        self.renderer.wait()?;
        let stats = self.renderer.read_stats(slot)?;
        Ok(Frame { size: SIZE, stats, hdr: self.renderer.read_hdr()? })
    }
}

/// How many values of a frame are not the expected ones.
fn compare(found: &Frame, expected: &Frame, what: &str, finding: &mut Finding) {
    found.must_be_whole(finding, what);
    finding.error(found.differing(expected) as f64, || what.to_owned());
}

type Check = fn(&mut Sequence, &mut Finding) -> Result<(), Failure>;

/// Methods that differ in what they keep for a frame: tables computed on the GPU, tables of the display and
/// tables of the gaze.
const KINDS: [&str; 4] = ["kfr", "vafr", "visual-polar", "guenter3"];

/// A case for each method with its defaults, or for those that differ in kind. `quick`: the first case is in
/// the subset.
fn cases(all: bool, quick: bool, check: Check) -> Vec<Case> {
    let wanted = |subject: &Subject| subject.quick && (all || KINDS.contains(&subject.name));
    let case = |subject: Subject| {
        Case::new(subject.name, quick && subject.name == "vafr", move |bench| {
            let content = upload(bench, &pattern(&display()), None)?;
            let renderer = || renderer(bench, &content, &display(), &subject.method);
            let mut finding = Finding::default();
            let mut sequence = Sequence { renderer: renderer()?, other: renderer()? };
            check(&mut sequence, &mut finding)?;
            Ok(finding)
        })
    };
    methods().into_iter().filter(wanted).map(case).collect()
}

/// A place on the display, one of its corners, one off it, one far off it.
const HERE: DVec2 = DVec2::new(40.0, 30.0);
const THERE: DVec2 = DVec2::new(110.25, 60.5);
const CORNER: DVec2 = DVec2::new(128.0, 0.0);
const OFF: DVec2 = DVec2::new(-60.0, 36.0);
const FAR: DVec2 = DVec2::new(1e6, 1e6);

fn jumps(sequence: &mut Sequence, finding: &mut Finding) -> Result<(), Failure> {
    let gazes = [HERE, THERE, CORNER, OFF, FAR];
    let mut expected = Vec::new();
    for gaze_px in gazes {
        expected.push(sequence.expected(gaze_px)?);
    }
    let noticed = expected[0].differing(&expected[1]) > 0;
    finding.holds(noticed, || "the gaze makes no difference to the picture".to_owned());
    // Most after most others, the first ones twice.
    for index in [4, 0, 1, 0, 2, 1, 3, 0, 4, 2, 4, 1] {
        let frame = sequence.next(gazes[index])?;
        compare(&frame, &expected[index], &format!("gaze {}", gazes[index]), finding);
    }
    Ok(())
}

const NONE: [DVec2; 3] = [DVec2::NAN, DVec2::new(f64::INFINITY, 3.0), DVec2::new(2.0, f64::NAN)];

fn no_gaze(sequence: &mut Sequence, finding: &mut Finding) -> Result<(), Failure> {
    let mut expected = sequence.expected(display().center_px())?;
    let mut what = "before the first gaze".to_owned();
    for after in [None, Some(HERE), Some(CORNER), Some(OFF)] {
        if let Some(gaze_px) = after {
            expected = sequence.next(gaze_px)?;
            finding.holds(!expected.stats.gaze_held, || format!("gaze {gaze_px} is said to be held"));
            what = format!("after gaze {gaze_px}");
        }
        for none in NONE {
            let frame = sequence.next(none)?;
            compare(&frame, &expected, &what, finding);
            finding.holds(frame.stats.gaze_held, || format!("{what}: the frame does not say so"));
        }
    }
    Ok(())
}

fn again(sequence: &mut Sequence, finding: &mut Finding) -> Result<(), Failure> {
    for gaze_px in [HERE, THERE] {
        let first = sequence.next(gaze_px)?;
        for run in ["the same renderer", "the same renderer, later"] {
            compare(&sequence.next(gaze_px)?, &first, run, finding);
        }
        compare(&sequence.expected(gaze_px)?, &first, "another renderer", finding);
    }
    Ok(())
}

fn dropped(sequence: &mut Sequence, finding: &mut Finding) -> Result<(), Failure> {
    for gaze_px in [CORNER, HERE] {
        let expected = sequence.expected(gaze_px)?;
        for count in 1..=3 {
            for _ in 0..count {
                sequence.renderer.record(&looking_ahead(THERE))?;
            }
            let frame = sequence.next(gaze_px)?;
            compare(&frame, &expected, &format!("after {count} dropped frames"), finding);
        }
        // While one is on its way, another is recorded and dropped.
        let slot = sequence.renderer.record(&looking_ahead(gaze_px))?;
        sequence.renderer.launch()?;
        sequence.renderer.record(&looking_ahead(THERE))?;
        let frame = sequence.finish(slot)?;
        compare(&frame, &expected, "before a dropped frame", finding);
    }
    Ok(())
}

fn latched(sequence: &mut Sequence, finding: &mut Finding) -> Result<(), Failure> {
    let none = DVec2::NAN;
    for (recorded, late) in [(HERE, THERE), (THERE, HERE), (HERE, OFF), (none, HERE), (HERE, none)] {
        let expected = sequence.expected(if late.is_finite() { late } else { recorded })?;
        let slot = sequence.renderer.record(&looking_ahead(recorded))?;
        sequence.renderer.late_latch(slot, late);
        sequence.renderer.launch()?;
        let frame = sequence.finish(slot)?;
        let what = format!("gaze {recorded}, latched to {late}");
        compare(&frame, &expected, &what, finding);
        finding.holds(!frame.stats.gaze_held, || format!("{what}: said to be held"));
    }
    Ok(())
}

/// A pass that reads an earlier frame needs motion vectors; the plan says that nothing does.
fn history(bench: &Bench, method: &Method) -> Result<Finding, Failure> {
    let content = upload(bench, &pattern(&display()), None)?;
    let mut finding = Finding::default();
    let renderer = renderer(bench, &content, &display(), method)?;
    let left_out = renderer.effects().skipped.iter().any(|note| note.name == "motion vectors");
    finding.error(f64::from(u8::from(!left_out)), || {
        "motion vectors are read: the catalogue's cases of history have to be added".to_owned()
    });
    Ok(finding)
}

fn histories() -> Vec<Case> {
    let case = |subject: Subject| {
        let quick = subject.name == "vafr";
        Case::new(subject.name, quick, move |bench| history(bench, &subject.method))
    };
    methods().into_iter().filter(|subject| KINDS.contains(&subject.name)).map(case).collect()
}
