//! One JSON object into one sample.

use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::{DQuat, DVec2, DVec3};
use serde::Deserialize;

/// Reasons for a rejection are cut to so many characters: they may quote what was sent.
const MAX_REASON: usize = 160;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Message {
    t_ns: Option<i64>,
    combined: Option<Eye>,
    left: Option<Eye>,
    right: Option<Eye>,
    dir: Option<[f64; 3]>,
    point: Option<[f64; 2]>,
    head: Option<Head>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Eye {
    valid: Option<bool>,
    dir: Option<[f64; 3]>,
    origin_m: Option<[f64; 3]>,
    point: Option<[f64; 2]>,
    confidence: Option<f64>,
    pupil_mm: Option<f64>,
    openness: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Head {
    position_m: [f64; 3],
    rotation: [f64; 4],
}

/// A sample from one message of the line protocol ([`crate::bridge`]). `device_time_ns` is the message's
/// time; the other times are 0.
///
/// # Errors
/// What is wrong with it, in one line.
pub fn parse(message: &[u8]) -> Result<GazeSample, String> {
    let message: Message = serde_json::from_slice(message).map_err(|error| {
        let reason = error.to_string();
        reason
            .chars()
            .map(|letter| if letter.is_control() { ' ' } else { letter })
            .take(MAX_REASON)
            .collect::<String>()
    })?;
    let Message { t_ns, combined, left, right, dir, point, head } = message;
    if combined.is_none() && left.is_none() && right.is_none() && dir.is_none() && point.is_none() {
        return Err("tells no gaze: none of combined, left, right, dir and point is there".into());
    }
    let mut combined = combined.unwrap_or_default();
    combined.dir = combined.dir.or(dir);
    combined.point = combined.point.or(point);
    let head = head.map(pose).transpose()?;
    Ok(GazeSample {
        device_time_ns: t_ns,
        combined: combined.sample(),
        left: left.unwrap_or_default().sample(),
        right: right.unwrap_or_default().sample(),
        head,
        ..GazeSample::default()
    })
}

fn pose(head: Head) -> Result<HeadPose, String> {
    let turn = DQuat::from_array(head.rotation);
    // Beyond these its length is no number.
    if !(1e-100..1e100).contains(&turn.length()) {
        return Err("head.rotation has no length to speak of; give a quaternion".into());
    }
    Ok(HeadPose { position_m: DVec3::from_array(head.position_m), world_from_view: turn.normalize() })
}

impl Eye {
    fn sample(self) -> EyeSample {
        EyeSample {
            valid: self.valid.unwrap_or(self.dir.is_some() || self.point.is_some()),
            origin_m: self.origin_m.map(DVec3::from_array),
            direction: self.dir.map(DVec3::from_array),
            point: self.point.map(DVec2::from_array),
            confidence: self.confidence,
            pupil_mm: self.pupil_mm,
            openness: self.openness,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_key_arrives() {
        let text = br#"{"t_ns": -7, "left": {"valid": false, "dir": [0, 1, -2], "origin_m": [0.03, 0, 0.5],
            "point": [0.25, 1.5], "confidence": 0.5, "pupil_mm": 3.5, "openness": 0.75, "later": [1]},
            "right": {"valid": true}, "point": [0.5, 0.625], "dir": [0, 0, -1],
            "head": {"position_m": [0, 1.6, 0], "rotation": [0, 2, 0, 0]}, "version": 9}"#;
        let sample = parse(text).expect("a sample");
        assert_eq!(sample.device_time_ns, Some(-7));
        let left = EyeSample {
            valid: false,
            direction: Some(DVec3::new(0.0, 1.0, -2.0)),
            origin_m: Some(DVec3::new(0.03, 0.0, 0.5)),
            point: Some(DVec2::new(0.25, 1.5)),
            confidence: Some(0.5),
            pupil_mm: Some(3.5),
            openness: Some(0.75),
        };
        assert_eq!(sample.left, left);
        assert_eq!(sample.right, EyeSample { valid: true, ..EyeSample::default() });
        assert!(sample.combined.valid);
        assert_eq!(sample.combined.point, Some(DVec2::new(0.5, 0.625)));
        assert_eq!(sample.combined.direction, Some(DVec3::NEG_Z));
        let head = sample.head.expect("a head");
        assert_eq!(head.position_m, DVec3::new(0.0, 1.6, 0.0));
        assert_eq!(head.world_from_view, DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0));
    }

    #[test]
    fn rubbish_is_named_in_one_line() {
        let long = format!("{{\"combined\": \"{}\"}}", "x".repeat(5000));
        for text in [
            "",
            "{}",
            "[]",
            "nonsense",
            "{\"t_ns\": 1}",
            "{\"t_ns\": 1.5, \"point\": [0, 0]}",
            "{\"t_ns\": 9223372036854775808, \"point\": [0, 0]}",
            "{\"point\": [0, 1e999]}",
            "{\"point\": [0, 1, 2]}",
            "{\"dir\": [0, NaN, 1]}",
            "{\"point\": [0, 0], \"head\": {\"position_m\": [0, 0, 0], \"rotation\": [0, 0, 0, 0]}}",
            "{\"point\": [0, 0]} {}",
            &long,
        ] {
            let why = parse(text.as_bytes()).expect_err(text);
            assert!(!why.contains('\n') && why.len() < 400, "{why}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(&bytes);
        }
    }
}
