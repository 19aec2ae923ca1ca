//! What the channels of a gaze stream mean, by the specification "Gaze Meta Data" of XDF: for each
//! channel `label`, `eye`, `type` and `unit`; by the label where a type is missing or general.
//!
//! Values whose unit is not told, and what has no place in a sample, become extra columns. The axes of
//! directions are not specified. Streams of Pupil Capture are known by their labels: scene camera, x
//! right, y down, z forward, points with the origin at the bottom. Of other streams x is taken as right
//! and y as up, and z as forward where most directions have a positive z.

use crate::formats::ReadOptions;
use crate::formats::rows::Extras;
use crate::recording::Space;
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};

/// Samples with less confidence are not valid: Pupil Labs advises against data below 0.6. Smaller lets in
/// more of what the tracker guesses around blinks.
const MIN_CONFIDENCE: f64 = 0.6;

/// A channel as the header describes it.
#[derive(Clone, Debug, Default)]
pub(super) struct Channel {
    pub(super) label: String,
    eye: String,
    kind: String,
    unit: String,
}

/// The places of one eye that channels fill.
const POINT: usize = 0;
const DIRECTION: usize = 2;
const ORIGIN: usize = 5;
const PUPIL: usize = 8;
const CONFIDENCE: usize = 9;
const OPENNESS: usize = 10;
const PLACES: usize = 11;

/// Where a channel's value goes.
#[derive(Clone, Copy, Debug)]
struct Target {
    /// 0 both, 1 left, 2 right.
    eye: usize,
    place: usize,
    scale: f64,
}

/// How the values of a stream become samples.
#[derive(Debug)]
pub(super) struct Layout {
    targets: Vec<Option<Target>>,
    /// Labels of Pupil Capture.
    camera: bool,
    /// How many directions have a positive z, less those with a negative one.
    forward: i64,
    unknown_units: Vec<String>,
}

/// The text of a child element.
pub(super) fn text_of<'a>(node: roxmltree::Node<'a, '_>, name: &str) -> Option<&'a str> {
    let child = node.children().find(|child| child.has_tag_name(name))?;
    child.text().map(str::trim)
}

/// The channels that the header describes, as many as it counts.
pub(super) fn channels_of(info: roxmltree::Node<'_, '_>, count: usize) -> Vec<Channel> {
    let child = |name| move |node: &roxmltree::Node| node.has_tag_name(name);
    let described = info.children().filter(child("desc")).flat_map(|desc| desc.children());
    let described = described.filter(child("channels")).flat_map(|channels| channels.children());
    let described = described.filter(child("channel")).map(|node| {
        let text = |name| text_of(node, name).unwrap_or_default().to_lowercase();
        Channel {
            label: text_of(node, "label").unwrap_or_default().to_owned(),
            eye: text("eye"),
            kind: text("type"),
            unit: text("unit"),
        }
    });
    let mut channels: Vec<_> = described.take(count).collect();
    channels.resize(count, Channel::default());
    for (channel, number) in channels.iter_mut().zip(1..) {
        if channel.label.is_empty() {
            channel.label = format!("channel {number}");
        }
    }
    channels
}

impl Channel {
    fn eye(&self, label: &str) -> usize {
        let says = |side: &str| self.eye == side || self.eye.is_empty() && label.contains(side);
        if says("left") {
            1
        } else if says("right") {
            2
        } else {
            0
        }
    }

    /// The place and, where it is one of several, its axis: by the label where the type is general.
    fn place(&self, label: &str) -> Option<usize> {
        // Pupil Capture tells its gaze normals as positions.
        let direction = ["direction", "gaze_normal"].iter().any(|word| label.contains(word));
        let (kind, axes) = match self.kind.as_str() {
            _ if direction => (DIRECTION, 3),
            kind if kind.starts_with("screen") => (POINT, 2),
            kind if kind.starts_with("direction") => (DIRECTION, 3),
            kind if kind.starts_with("position") => (ORIGIN, 3),
            "diameter" | "radius" => return Some(PUPIL),
            "confidence" => return Some(CONFIDENCE),
            "" | "gaze" | "eye" | "eyetracking" | "misc" => Self::place_by(label)?,
            _ => return None,
        };
        let axis_of = |text: &str| match text.chars().last()? {
            'x' | '0' => Some(0),
            'y' | '1' => Some(1),
            'z' | '2' => Some(2),
            _ => None,
        };
        if axes == 1 {
            return Some(kind);
        }
        let axis = axis_of(&self.kind).or_else(|| axis_of(label)).filter(|axis| *axis < axes)?;
        Some(kind + axis)
    }

    /// The kind of place and how many axes it has, by the words of a label.
    fn place_by(label: &str) -> Option<(usize, usize)> {
        let has = |words: &[&str]| words.iter().any(|word| label.contains(word));
        Some(if has(&["validity", "available", "valid"]) {
            return None;
        } else if has(&["confidence"]) {
            (CONFIDENCE, 1)
        } else if has(&["openness"]) {
            (OPENNESS, 1)
        } else if has(&["pupil_diameter", "pupildiameter"]) {
            (PUPIL, 1)
        } else if has(&["origin", "eye_center"]) {
            (ORIGIN, 3)
        } else if has(&[
            "display_area",
            "norm_pos",
            "gaze_point",
            "screen",
            "gaze_x",
            "gaze_y",
            "gazex",
            "gazey",
        ]) {
            (POINT, 2)
        } else {
            return None;
        })
    }

    /// What the value is multiplied by; `None` where the unit does not fit or is not told.
    fn scale(&self, place: usize, label: &str, size_px: Option<DVec2>) -> Option<f64> {
        let unit = self.unit.trim();
        let length_m = || match unit {
            "m" | "meter" | "meters" | "metre" | "metres" => Some(1.0),
            "cm" | "centimeters" | "centimetres" => Some(1e-2),
            "mm" | "millimeters" | "millimetres" => Some(1e-3),
            _ => None,
        };
        match place {
            DIRECTION..ORIGIN | CONFIDENCE | OPENNESS => Some(1.0),
            ORIGIN..PUPIL => length_m(),
            PUPIL => Some(length_m()? * 1e3 * if self.kind == "radius" { 2.0 } else { 1.0 }),
            _ if unit.starts_with("norm") || unit.starts_with("fraction") => Some(1.0),
            _ if unit.starts_with("pix") || unit == "px" => {
                size_px.map(|size_px| 1.0 / if place == POINT { size_px.x } else { size_px.y })
            }
            _ if unit.is_empty() && ["norm", "display_area"].iter().any(|word| label.contains(word)) => {
                Some(1.0)
            }
            _ => None,
        }
    }
}

impl Layout {
    pub(super) fn new(channels: &[Channel], options: &ReadOptions) -> Self {
        let camera = |channel: &Channel| {
            ["norm_pos_", "gaze_point_3d_", "gaze_normal"]
                .iter()
                .any(|start| channel.label.starts_with(start))
        };
        let size_px = options.screen.map(|screen| screen.size_px);
        let mut layout = Self {
            targets: Vec::new(),
            camera: channels.iter().any(camera),
            forward: 0,
            unknown_units: Vec::new(),
        };
        let mut taken = [[false; PLACES]; 3];
        for channel in channels {
            let label = channel.label.to_lowercase();
            let eye = channel.eye(&label);
            let target = channel.place(&label).and_then(|place| {
                let Some(scale) = channel.scale(place, &label, size_px) else {
                    layout.unknown_units.push(channel.label.clone());
                    return None;
                };
                Some(Target { eye, place, scale })
            });
            // Two channels for one place: the first counts, the other stays an extra column.
            layout.targets.push(target.filter(|target| {
                let taken = &mut taken[target.eye][target.place];
                !std::mem::replace(taken, true)
            }));
        }
        layout
    }

    /// Looks at a sample before any is read, to learn which way z points.
    pub(super) fn look(&mut self, values: &[f64]) {
        for (target, value) in self.targets.iter().zip(values) {
            if target.is_some_and(|target| target.place == DIRECTION + 2) {
                self.forward += i64::from(*value > 0.0) - i64::from(*value < 0.0);
            }
        }
    }

    pub(super) fn space(&self) -> Space {
        let tells = |places: std::ops::Range<usize>| {
            self.targets.iter().flatten().any(|target| places.contains(&target.place))
        };
        if self.camera {
            Space::SceneCamera
        } else if tells(DIRECTION..ORIGIN) {
            Space::View
        } else if tells(POINT..DIRECTION) {
            Space::Display
        } else {
            Space::Unknown
        }
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.camera {
            notes.push(
                "labels of Pupil Capture: axes of the scene camera, points from the bottom left".into(),
            );
        } else if self.forward > 0 {
            notes.push("most directions have a positive z, so z is taken as forward, x right, y up".into());
        }
        if !self.unknown_units.is_empty() {
            let labels: Vec<_> = self.unknown_units.iter().take(32).map(String::as_str).collect();
            notes.push(format!(
                "extra columns, as their unit is not known (px needs the screen): {}",
                labels.join(", ")
            ));
        }
        notes
    }

    /// To view space.
    fn view_of(&self, values: &[f64]) -> Option<DVec3> {
        let [x, y, z] = *values.first_chunk()?;
        let vector = if self.camera {
            DVec3::new(x, -y, -z)
        } else if self.forward > 0 {
            DVec3::new(x, y, -z)
        } else {
            DVec3::new(x, y, z)
        };
        (!vector.is_nan()).then_some(vector)
    }

    /// Puts the values into a sample.
    pub(super) fn fill(&self, sample: &mut GazeSample, values: &[f64]) {
        let mut places = [[f64::NAN; PLACES]; 3];
        for (target, value) in self.targets.iter().zip(values) {
            if let Some(Target { eye, place, scale }) = *target {
                places[eye][place] = value * scale;
            }
        }
        let told = |value: f64| (!value.is_nan()).then_some(value);
        let both = told(places[0][CONFIDENCE]);
        let eyes = places.map(|places| {
            let point = DVec2::new(places[POINT], places[POINT + 1]);
            let point = if self.camera { DVec2::new(point.x, 1.0 - point.y) } else { point };
            let point = (!point.is_nan()).then_some(point);
            let direction = self.view_of(&places[DIRECTION..ORIGIN]);
            let confidence = told(places[CONFIDENCE]);
            let sure = confidence.or(both).is_none_or(|confidence| confidence >= MIN_CONFIDENCE);
            EyeSample {
                valid: sure && (point.is_some() || direction.is_some()),
                origin_m: self.view_of(&places[ORIGIN..PUPIL]),
                direction,
                point,
                confidence,
                pupil_mm: told(places[PUPIL]),
                openness: told(places[OPENNESS]),
            }
        });
        [sample.combined, sample.left, sample.right] = eyes;
    }

    /// Keeps the values that have no place in a sample.
    pub(super) fn keep(&self, extras: &mut Extras, index: usize, values: &[f64]) {
        for (column, (target, value)) in self.targets.iter().zip(values).enumerate() {
            if target.is_none() {
                extras.set(column, index, *value);
            }
        }
    }
}
