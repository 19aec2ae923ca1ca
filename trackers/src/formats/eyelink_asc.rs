//! EyeLink recordings as `edf2asc` writes them: one or two eyes, any rate.
//!
//! Sample lines begin with the time in the first column: `t x y pupil` for each eye, then what else was
//! asked for (velocity, resolution, input, flags), which is left out. A missing value is a dot. Lines of
//! the calibration begin with numbers too, but are indented. Positions are px of the display (`GAZE`),
//! angles in the head (`HREF`) or of the camera (`RAW`), as the `SAMPLES` line says. The pupil is an area
//! or diameter in units of the camera, so it is kept as an extra column.

use super::rows::{Extras, Rejects, lines, ns_of};
use super::{Format, Input, ReadOptions};
use crate::EyeState;
use crate::error::{Error, Result};
use crate::recording::{EventEye, RecordedEvent, Recording, RecordingInfo, Screen, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};

/// The format.
pub const FORMAT: Format = Format { name: "eyelink-asc", matches, read };

/// Distance of the plane of `HREF` coordinates from the eye, in their units (EyeLink manual, "HREF"). In
/// that plane x points right and y down: calibrations tell the target at the top with a negative y.
const HREF_DISTANCE: f64 = 15_000.0;
/// From here on a value means "missing": what older converters write instead of a dot.
const MISSING: f64 = 1e8;
/// What the tracker itself writes for "missing".
const MISSING_DATA: f64 = -32_768.0;

/// Of the unknown, the left and the right eye.
const EXTRA_COLUMNS: [&str; 9] =
    ["pupil", "x", "y", "pupil_left", "x_left", "y_left", "pupil_right", "x_right", "y_right"];

/// What the positions of the sample lines are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Position {
    Gaze,
    Href,
    Raw,
}

/// Of one eye in a sample line: x, y, pupil.
type Triple = [f64; 3];

/// What the lines so far have told.
struct Reader<'a> {
    options: &'a ReadOptions,
    recording: Recording,
    /// Left, top and size of the display, px.
    display_px: Option<(DVec2, DVec2)>,
    /// Left, right; both false before the first block.
    eyes: [bool; 2],
    position: Position,
    rate_hz: Option<f64>,
    last_time: f64,
    extras: Extras,
    halved: u64,
    rejects: Rejects,
}

fn matches(_: &Input, head: &str) -> bool {
    head.starts_with("** CONVERTED FROM")
        || head.lines().any(|line| {
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                Some("START") => words.any(|word| word == "SAMPLES"),
                Some("SAMPLES") => words.next().is_some_and(|word| ["GAZE", "HREF", "RAW"].contains(&word)),
                _ => false,
            }
        })
}

/// A value of a sample line: NaN where missing, `None` where it is no number.
fn value_of(word: &str) -> Option<f64> {
    if word == "." {
        return Some(f64::NAN);
    }
    let value: f64 = fast_float2::parse(word).ok()?;
    Some(if value >= MISSING || value == MISSING_DATA { f64::NAN } else { value })
}

/// Left and right by the words of a `START` or `SAMPLES` line.
fn eyes_of(words: &[&str]) -> [bool; 2] {
    ["LEFT", "RIGHT"].map(|eye| words.contains(&eye))
}

/// The display by `left top right bottom` in px. Some set-ups write the last pixel (1919), some the size
/// (1920): displays have even sizes, so an odd difference is taken as that of the last pixel.
fn display_of(words: &[&str]) -> Option<(DVec2, DVec2)> {
    let mut sides = [0.0; 4];
    for (side, word) in sides.iter_mut().zip(words.get(..4)?) {
        *side = fast_float2::parse(word).ok().filter(|value: &f64| value.is_finite())?;
    }
    let [left, top, right, bottom] = sides;
    let size = |difference: f64| difference + f64::from(difference.rem_euclid(2.0) == 1.0);
    let size_px = DVec2::new(size(right - left), size(bottom - top));
    (size_px.min_element() > 0.0).then_some((DVec2::new(left, top), size_px))
}

impl<'a> Reader<'a> {
    fn new(options: &'a ReadOptions) -> Self {
        let recording = Recording::new(RecordingInfo {
            device: "EyeLink".into(),
            space: Space::Display,
            device_clock: "ms of the tracker".into(),
            ..RecordingInfo::default()
        });
        Self {
            options,
            recording,
            display_px: None,
            eyes: [false; 2],
            position: Position::Gaze,
            rate_hz: None,
            last_time: f64::NAN,
            extras: Extras::new(EXTRA_COLUMNS),
            halved: 0,
            rejects: Rejects::default(),
        }
    }

    fn time_ns(&self, time: f64) -> Option<i64> {
        ns_of(time, self.options.time_unit_s.unwrap_or(1e-3))
    }

    fn line(&mut self, number: usize, line: &str) {
        if line.as_bytes().first().is_some_and(u8::is_ascii_digit) {
            if self.sample(line).is_none() {
                self.rejects.add(format_args!("line {number}"), line);
            }
            return;
        }
        let words: Vec<_> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["MSG", _, "GAZE_COORDS", sides @ ..] => {
                self.display_px = display_of(sides).or(self.display_px);
            }
            ["MSG", _, "DISPLAY_COORDS", sides @ ..] if self.display_px.is_none() => {
                self.display_px = display_of(sides);
            }
            ["START", _, words @ ..] => {
                self.eyes = eyes_of(words);
                self.position = Position::Gaze;
            }
            ["SAMPLES", words @ ..] => self.samples_line(words),
            [kind @ ("EFIX" | "ESACC" | "EBLINK"), eye, start, end, ..] => {
                self.event(kind, eye, start, end);
            }
            _ => {}
        }
    }

    fn samples_line(&mut self, words: &[&str]) {
        let eyes = eyes_of(words);
        self.eyes = if eyes == [false; 2] { self.eyes } else { eyes };
        self.position = match words.first() {
            Some(&"HREF") => Position::Href,
            Some(&"RAW" | &"PUPIL") => Position::Raw,
            _ => Position::Gaze,
        };
        let mut after = words.iter().skip_while(|word| **word != "RATE").skip(1);
        let rate_hz = after.next().and_then(|word| fast_float2::parse(word).ok());
        let rate_hz = rate_hz.filter(|rate: &f64| *rate > 0.0 && rate.is_finite());
        if rate_hz.is_some() && self.rate_hz.is_some() && rate_hz != self.rate_hz {
            self.note("blocks have different sampling rates; the first is told");
        }
        self.rate_hz = self.rate_hz.or(rate_hz);
    }

    fn note(&mut self, note: &str) {
        if !self.recording.info.notes.iter().any(|told| told == note) {
            self.recording.info.notes.push(note.into());
        }
    }

    fn event(&mut self, kind: &str, eye: &str, start: &str, end: &str) {
        let time = |word: &str| self.time_ns(fast_float2::parse(word).ok()?);
        let (Some(start_ns), Some(end_ns)) = (time(start), time(end)) else { return };
        let kind = match kind {
            "EFIX" => EyeState::Fixation,
            "ESACC" => EyeState::Saccade,
            _ => EyeState::Blink,
        };
        let eye = match eye {
            "L" => EventEye::Left,
            "R" => EventEye::Right,
            _ => EventEye::Both,
        };
        self.recording.events.push(RecordedEvent { kind, start_ns, end_ns, eye });
    }

    /// Takes a sample line; `None` where it is none.
    fn sample(&mut self, line: &str) -> Option<()> {
        let mut words = line.split_ascii_whitespace();
        let mut time: f64 = fast_float2::parse(words.next()?).ok()?;
        let mut triple = || -> Option<Triple> {
            Some([value_of(words.next()?)?, value_of(words.next()?)?, value_of(words.next()?)?])
        };
        let first = triple()?;
        let triples = match self.eyes {
            [true, true] => [None, Some(first), Some(triple()?)],
            [true, false] => [None, Some(first), None],
            [false, true] => [None, None, Some(first)],
            // No block was begun: two eyes if there is room for them, else one that is unknown.
            [false, false] => match triple() {
                Some(second) => [None, Some(first), Some(second)],
                None => [Some(first), None, None],
            },
        };
        // At 2 kHz a converter that writes whole milliseconds gives two samples the same time.
        if time == self.last_time && self.rate_hz.is_some_and(|rate| rate > 1000.0) {
            time += 0.5;
            self.halved += 1;
        } else {
            self.last_time = time;
        }
        let time_ns = self.time_ns(time)?;
        let [combined, left, right] =
            triples.map(|triple| triple.map_or_else(EyeSample::default, |triple| self.eye_of(triple)));
        self.keep_extras(triples);
        self.recording.push(&GazeSample { combined, left, right, ..GazeSample::at(time_ns) });
        Some(())
    }

    /// Left, top and size of the display in px: as the file says, or else as the caller does.
    fn display(&self) -> Option<(DVec2, DVec2)> {
        self.display_px.or_else(|| Some((DVec2::ZERO, self.options.screen?.size_px)))
    }

    fn eye_of(&self, [x, y, _]: Triple) -> EyeSample {
        let at = DVec2::new(x, y);
        if at.is_nan() {
            return EyeSample::default();
        }
        let point = match self.position {
            Position::Gaze => self.display().map(|(origin, size)| (at - origin) / size),
            Position::Href | Position::Raw => None,
        };
        let direction = match self.position {
            Position::Gaze => {
                self.options.screen.zip(point).map(|(screen, point)| screen.direction_of(point))
            }
            Position::Href => Some(DVec3::new(x, -y, -HREF_DISTANCE).normalize()),
            Position::Raw => None,
        };
        EyeSample { valid: self.position != Position::Raw, point, direction, ..EyeSample::default() }
    }

    /// Keeps what has no place in a sample: pupils, and positions that are no points.
    fn keep_extras(&mut self, triples: [Option<Triple>; 3]) {
        let index = self.recording.len();
        let positions =
            self.position == Position::Raw || self.position == Position::Gaze && self.display().is_none();
        for (triple, first_column) in triples.into_iter().zip((0..).step_by(3)) {
            let Some([x, y, pupil]) = triple else { continue };
            self.extras.set(first_column, index, pupil);
            if positions {
                self.extras.set(first_column + 1, index, x);
                self.extras.set(first_column + 2, index, y);
            }
        }
    }

    fn finish(mut self, input: &Input) -> Result<Recording> {
        if self.recording.is_empty() {
            return Err(Error::file(
                &input.path,
                "holds no sample; convert it with samples (edf2asc -s or without -e)",
            ));
        }
        let display = self.display();
        if self.position == Position::Gaze && display.is_none() {
            self.note(
                "the size of the display is not known, so positions are extra columns in px; give the screen",
            );
        }
        if self.position == Position::Raw {
            self.note("positions are those of the camera and tell no gaze; they are extra columns");
        }
        self.note("pupil sizes are in units of the camera and are extra columns");
        let Self { mut recording, options, extras, rejects, halved, rate_hz, .. } = self;
        extras.finish(&mut recording);
        if halved > 0 {
            recording
                .info
                .notes
                .push(format!("{halved} samples had the time of the one before; 0.5 ms were added"));
        }
        recording.info.nominal_rate_hz = rate_hz;
        recording.info.screen = options.screen.map(|screen| Screen {
            size_px: display.map_or(screen.size_px, |(_, size_px)| size_px),
            ..screen
        });
        rejects.report(&mut recording, "lines begin as a sample but are none");
        Ok(recording)
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut reader = Reader::new(options);
    for (number, line) in lines(input.text()) {
        reader.line(number, &line);
    }
    reader.finish(input)
}

#[cfg(test)]
mod tests;
