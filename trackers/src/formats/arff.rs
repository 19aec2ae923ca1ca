//! ARFF with the extensions of the GazeCom and 360_em data sets: `%@METADATA` lines tell the display,
//! `time` is in us, `x` and `y` in px, `confidence` from 0 to 1, labels are nominal attributes.
//!
//! Of 360_em, where `x_head` and `y_head` are there, `x` and `y` are px of an equirectangular picture all
//! around: the gaze in the world. Head and gaze together give the direction of the eye in the head. The
//! middle of the picture is taken as straight ahead in the world.

use super::rows::{Extras, Rejects, lines, ns_of};
use super::{Format, Input, ReadOptions};
use crate::error::{Error, Result};
use crate::recording::{Recording, RecordingInfo, Screen, Space};
use crate::sample::{GazeSample, HeadPose};
use glam::{DQuat, DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// The format.
pub const FORMAT: Format = Format { name: "arff", matches, read };

/// Samples with less confidence are not valid. The scripts of the data sets' authors leave out samples
/// below 0.8; a smaller value lets in more of the samples around blinks.
const MIN_CONFIDENCE: f64 = 0.8;
/// The most attributes: the data sets have about ten.
const MAX_ATTRIBUTES: usize = 1024;

/// A column.
struct Attribute {
    name: String,
    /// The names of a nominal attribute; empty for a number.
    labels: Vec<String>,
}

/// What comes before the data.
#[derive(Default)]
struct Header {
    attributes: Vec<Attribute>,
    metadata: HashMap<String, f64>,
}

/// Where the columns with a meaning are.
struct Columns {
    time: usize,
    x: usize,
    y: usize,
    confidence: Option<usize>,
    /// `x_head`, `y_head`, and `angle_deg_head`.
    head: Option<(usize, usize, Option<usize>)>,
}

fn matches(_: &Input, head: &str) -> bool {
    let mut lines = head.lines().map(str::trim_start);
    lines.any(|line| starts_with(line, "@relation")) && head.lines().any(|line| attribute_of(line).is_some())
}

/// Keywords are of any case.
fn starts_with(line: &str, keyword: &str) -> bool {
    line.get(..keyword.len()).is_some_and(|start| start.eq_ignore_ascii_case(keyword))
}

/// Without the quotes that names with spaces have.
fn unquoted(text: &str) -> &str {
    text.trim().trim_matches(['\'', '"'])
}

fn attribute_of(line: &str) -> Option<Attribute> {
    let line = line.trim();
    let rest = starts_with(line, "@attribute").then(|| line["@attribute".len()..].trim_start())?;
    let (name, kind) = match rest.chars().next()? {
        quote @ ('\'' | '"') => rest[1..].split_once(quote)?,
        _ => rest.split_once(|letter: char| letter.is_whitespace())?,
    };
    let labels = match kind.trim().strip_prefix('{') {
        Some(inner) => {
            inner.trim_end_matches('}').split(',').map(|label| unquoted(label).to_owned()).collect()
        }
        None => Vec::new(),
    };
    Some(Attribute { name: name.to_owned(), labels })
}

impl Header {
    /// Takes a line; true at the line that begins the data.
    fn line(&mut self, line: &str) -> bool {
        let line = line.trim();
        if starts_with(line, "%@metadata") {
            let mut words = line.split_whitespace().skip(1);
            if let (Some(name), Some(value)) = (words.next(), words.next())
                && let Ok(value) = fast_float2::parse(value)
                && self.metadata.len() < MAX_ATTRIBUTES
            {
                self.metadata.insert(name.to_ascii_lowercase(), value);
            }
        } else if self.attributes.len() < MAX_ATTRIBUTES {
            self.attributes.extend(attribute_of(line));
        }
        starts_with(line, "@data")
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.attributes.iter().position(|attribute| attribute.name.eq_ignore_ascii_case(name))
    }

    fn columns(&self, input: &Input) -> Result<Columns> {
        let found = |name: &str| {
            self.find(name).ok_or_else(|| {
                let names: Vec<_> = self.attributes.iter().map(|attribute| attribute.name.as_str()).collect();
                Error::file(&input.path, format!("has no attribute {name}, only {}", names.join(", ")))
            })
        };
        Ok(Columns {
            time: found("time")?,
            x: found("x")?,
            y: found("y")?,
            confidence: self.find("confidence"),
            head: self
                .find("x_head")
                .zip(self.find("y_head"))
                .map(|(x, y)| (x, y, self.find("angle_deg_head"))),
        })
    }

    /// A positive number of the metadata.
    fn size(&self, name: &str) -> Option<f64> {
        self.metadata.get(name).copied().filter(|value| *value > 0.0 && value.is_finite())
    }

    fn size_px(&self) -> Option<DVec2> {
        Some(DVec2::new(self.size("width_px")?, self.size("height_px")?))
    }

    /// The display as the file tells it.
    fn screen(&self) -> Option<Screen> {
        let size_m = DVec2::new(self.size("width_mm")?, self.size("height_mm")?) * 1e-3;
        Some(Screen { size_px: self.size_px()?, size_m, distance_m: self.size("distance_mm")? * 1e-3 })
    }
}

/// Reads the values of a row; what is wrong with it otherwise.
fn row_of(text: &str, attributes: &[Attribute], values: &mut Vec<f64>) -> Result<(), &'static str> {
    if text.starts_with('{') {
        return Err("a sparse row, which is not read");
    }
    values.clear();
    let mut cells = text.split(',');
    for attribute in attributes {
        let cell = unquoted(cells.next().ok_or("too few values")?);
        let value = if cell == "?" {
            Some(f64::NAN)
        } else if attribute.labels.is_empty() {
            fast_float2::parse(cell).ok()
        } else {
            attribute.labels.iter().position(|label| label == cell).map(|index| index as f64)
        };
        values.push(value.ok_or("a value that is no number or label")?);
    }
    Ok(())
}

/// The angles of a place in an equirectangular picture: to the right and up from its middle, radians.
fn angles_of(at_px: DVec2, size_px: DVec2) -> DVec2 {
    let at = at_px / size_px - 0.5;
    DVec2::new(at.x * TAU, -at.y * PI)
}

/// How the head is turned that looks at these angles and leans to its right by `roll_rad`.
fn turn_of(angles: DVec2, roll_rad: f64) -> DQuat {
    DQuat::from_rotation_y(-angles.x) * DQuat::from_rotation_x(angles.y) * DQuat::from_rotation_z(-roll_rad)
}

/// What a gaze column becomes.
enum Place {
    /// A point of a display, whose directions are known with the screen.
    Display { size_px: Option<DVec2>, screen: Option<Screen> },
    /// A place in the picture around.
    Around { size_px: DVec2, head: (usize, usize, Option<usize>) },
}

impl Place {
    fn sample(&self, at_px: DVec2, values: &[f64], time_ns: i64) -> GazeSample {
        let value = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
        let mut sample = GazeSample::at(time_ns);
        match self {
            Self::Display { size_px, screen } => {
                let point = size_px.map(|size_px| at_px / size_px).filter(|point| !point.is_nan());
                sample.combined.point = point;
                sample.combined.direction =
                    screen.zip(point).map(|(screen, point)| screen.direction_of(point));
            }
            Self::Around { size_px, head: (x, y, roll) } => {
                let roll_rad = roll.map_or(0.0, |roll| value(roll).to_radians());
                let head = turn_of(angles_of(DVec2::new(value(*x), value(*y)), *size_px), roll_rad);
                let gaze = turn_of(angles_of(at_px, *size_px), 0.0) * DVec3::NEG_Z;
                let direction = head.inverse() * gaze;
                sample.combined.direction = (!direction.is_nan()).then_some(direction);
                sample.head =
                    (!head.is_nan()).then_some(HeadPose { position_m: DVec3::ZERO, world_from_view: head });
            }
        }
        sample
    }

    fn info(&self, header: &Header) -> RecordingInfo {
        let mut notes = Vec::new();
        for attribute in header.attributes.iter().filter(|attribute| !attribute.labels.is_empty()).take(32) {
            let labels: Vec<_> = attribute
                .labels
                .iter()
                .take(32)
                .enumerate()
                .map(|(index, label)| format!("{index} {label}"))
                .collect();
            notes.push(format!("{} is a label: {}", attribute.name, labels.join(", ")));
        }
        let (space, screen) = match self {
            Self::Display { screen, size_px } => {
                if size_px.is_none() {
                    notes.push("the size of the display is not known, so x and y are only extra columns; give the screen".into());
                }
                (Space::Display, *screen)
            }
            Self::Around { .. } => {
                notes.push("gaze and head are px of a picture all around, its middle straight ahead; a positive angle of the head leans right".into());
                (Space::View, None)
            }
        };
        RecordingInfo {
            space,
            screen,
            notes,
            device_clock: "us of the tracker".into(),
            ..RecordingInfo::default()
        }
    }
}

/// What `x` and `y` are.
fn place_of(input: &Input, header: &Header, columns: &Columns, options: &ReadOptions) -> Result<Place> {
    let size_px = header.size_px().or_else(|| Some(options.screen?.size_px));
    match (columns.head, size_px) {
        (Some(head), Some(size_px)) => Ok(Place::Around { size_px, head }),
        (Some(_), None) => {
            let cause = "has no width_px and height_px of its picture; add the %@METADATA lines";
            Err(Error::file(&input.path, cause))
        }
        (None, size_px) => {
            let told =
                options.screen.map(|screen| Screen { size_px: size_px.unwrap_or(screen.size_px), ..screen });
            Ok(Place::Display { size_px, screen: told.or(header.screen()) })
        }
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut lines = lines(input.text());
    let mut header = Header::default();
    if !lines.by_ref().any(|(_, line)| header.line(&line)) {
        return Err(Error::file(&input.path, "has no @DATA line; it is cut off in its header"));
    }
    let columns = header.columns(input)?;
    let place = place_of(input, &header, &columns, options)?;
    let in_sample = match place {
        Place::Display { size_px: Some(_), .. } => vec![columns.time, columns.x, columns.y],
        _ => vec![columns.time],
    };
    let mut recording = Recording::new(place.info(&header));
    let mut extras = Extras::new(header.attributes.iter().map(|attribute| attribute.name.as_str()));
    let (mut rejects, mut values) = (Rejects::default(), Vec::new());
    for (number, line) in lines {
        let text = line.trim();
        if text.is_empty() || text.starts_with('%') {
            continue;
        }
        if let Err(what) = row_of(text, &header.attributes, &mut values) {
            rejects.add(format_args!("line {number}"), what);
            continue;
        }
        let value = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
        let Some(time_ns) = ns_of(value(columns.time), options.time_unit_s.unwrap_or(1e-6)) else {
            rejects.add(format_args!("line {number}"), "its time is no number or beyond 64 bits of ns");
            continue;
        };
        let at_px = DVec2::new(value(columns.x), value(columns.y));
        let mut sample = place.sample(at_px, &values, time_ns);
        sample.combined.confidence = columns.confidence.map(value).filter(|confidence| !confidence.is_nan());
        let sure = sample.combined.confidence.is_none_or(|confidence| confidence >= MIN_CONFIDENCE);
        sample.combined.valid = at_px.is_finite() && sure;
        for (column, value) in values.iter().enumerate() {
            if !in_sample.contains(&column) && Some(column) != columns.confidence {
                extras.set(column, recording.len(), *value);
            }
        }
        recording.push(&sample);
    }
    extras.finish(&mut recording);
    rejects.report(&mut recording, "rows are no sample");
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{read_input, testing::input};

    const GAZECOM: &str = "@RELATION gaze_labels\n\n\
        %@METADATA width_px 1280\n%@METADATA height_px 720\n%@METADATA distance_mm 450.00\n\
        %@METADATA width_mm 400.00\n%@METADATA height_mm 225.00\n\n\
        @ATTRIBUTE time NUMERIC\n@attribute 'x' numeric\n@ATTRIBUTE y NUMERIC\n@ATTRIBUTE confidence NUMERIC\n\
        @ATTRIBUTE handlabeller_final {UNKNOWN, FIX, SACCADE, 'SP'}\n\n@DATA\n\
        1000,640.00,360.00,1.00,FIX\n\
        5000,1280.00,0.00,1.00,SP\r\n\
        9000,0.00,0.00,0.00,?\n\
        % a comment\n13000,640\n17000,640,x,1,FIX\n21000,640,360,1,GLISSADE\n?,640,360,1,FIX\n";

    #[test]
    fn gazecom_points_directions_and_labels() {
        let recording = read_input(&input(GAZECOM), &ReadOptions::default()).expect("read");
        assert_eq!((recording.info.format, recording.info.space), ("arff", Space::Display));
        assert_eq!(recording.times_ns(), [1_000_000, 5_000_000, 9_000_000]);
        let samples: Vec<_> = recording.samples().map(|sample| sample.combined).collect();
        assert_eq!(samples[0].point, Some(DVec2::splat(0.5)));
        assert_eq!(samples[0].direction, Some(DVec3::NEG_Z));
        // The top right corner: 200 mm to the right and 112.5 mm up at 450 mm.
        let corner = DVec3::new(200.0, 112.5, -450.0).normalize();
        assert!(samples[1].direction.is_some_and(|direction| direction.abs_diff_eq(corner, 1e-15)));
        assert_eq!(samples.iter().map(|eye| eye.valid).collect::<Vec<_>>(), [true, true, false]);
        assert_eq!(samples[2].confidence, Some(0.0));
        let labels = recording.extra_column("handlabeller_final").expect("labels");
        assert_eq!(labels[..2], [1.0, 3.0]);
        assert!(labels[2].is_nan());
        assert!(recording.info.notes[0].contains("1 FIX, 2 SACCADE, 3 SP"), "{}", recording.info.notes[0]);
        assert_eq!(recording.info.skipped.len(), 1);
        assert_eq!(recording.info.skipped[0].rows, 4);
    }

    fn around(row: &str) -> GazeSample {
        let text = format!(
            "@RELATION gaze_360\n%@METADATA height_px 1080\n%@METADATA width_px 1920\n\
             @ATTRIBUTE time INTEGER\n@ATTRIBUTE x NUMERIC\n@ATTRIBUTE y NUMERIC\n@ATTRIBUTE confidence NUMERIC\n\
             @ATTRIBUTE x_head NUMERIC\n@ATTRIBUTE y_head NUMERIC\n@ATTRIBUTE angle_deg_head NUMERIC\n@DATA\n{row}\n"
        );
        read_input(&input(text), &ReadOptions::default()).expect("read").get(0).expect("one")
    }

    #[test]
    fn eye_in_head_is_what_the_head_does_not_do() {
        let near = |sample: GazeSample, expected: DVec3| {
            let direction = sample.combined.direction.expect("known");
            assert!(direction.abs_diff_eq(expected.normalize(), 1e-12), "{direction} {expected}");
        };
        // Head and gaze agree, wherever.
        near(around("0,300,200,1,300,200,25"), DVec3::NEG_Z);
        // The head straight ahead: an eighth of the width is 45 degrees to the right.
        near(around("0,1200,540,1,960,540,0"), DVec3::new(1.0, 0.0, -1.0));
        // Up is a smaller y: a quarter of the height is 45 degrees.
        near(around("0,960,270,1,960,540,0"), DVec3::new(0.0, 1.0, -1.0));
        // The head turned right by 90 degrees: what lies ahead in the world is at its left.
        near(around("0,960,540,1,1440,540,0"), DVec3::NEG_X);
        // The head leaning right by 90 degrees: what lies to the right in the world is above for it.
        let leaning = around("0,1200,540,1,960,540,90");
        near(leaning, DVec3::new(0.0, 1.0, -1.0));
        let up = leaning.head.expect("known").world_from_view * DVec3::Y;
        assert!(up.abs_diff_eq(DVec3::X, 1e-12), "{up}");
    }

    #[test]
    fn headers_that_lack_something_say_so() {
        let cut = &GAZECOM[..GAZECOM.find("@DATA").expect("there")];
        let nameless = GAZECOM.replace("'x'", "gx");
        for (text, expected) in [(cut, "@DATA"), (&nameless, "no attribute x, only time, gx")] {
            let error = read_input(&input(text), &ReadOptions::default()).expect_err("broken").to_string();
            assert!(error.contains(expected), "{error}");
        }
        let sizeless = GAZECOM.replace("width_px", "width");
        let recording = read_input(&input(sizeless), &ReadOptions::default()).expect("read");
        assert_eq!(recording.get(0).and_then(|sample| sample.combined.point), None);
        assert_eq!(recording.extra_column("x").map(|column| column[1]), Some(1280.0));
    }
}
