use super::super::testing::input;
use super::*;

const BASE: &str = "raw_timestamp,relative_to_unix_epoch_timestamp,relative_to_video_first_frame_timestamp,\
    focus_distance,frame_number,stability,status,gaze_forward_x,gaze_forward_y,gaze_forward_z,gaze_origin_x,\
    gaze_origin_y,gaze_origin_z,left_forward_x,left_forward_y,left_forward_z,left_origin_x,left_origin_y,\
    left_origin_z,left_pupil_size,left_status,right_forward_x,right_forward_y,right_forward_z,\
    right_origin_x,right_origin_y,right_origin_z,right_pupil_size,right_status,left_pupil_diameter_in_mm,\
    left_eye_openness,right_pupil_diameter_in_mm,right_eye_openness\n";

#[test]
fn base_has_two_clocks_and_two_kinds_of_status() {
    let none = "-nan(ind),-nan(ind),-nan(ind)";
    let file = format!(
        "{BASE}1000,1700000000000000007,0,1.5,1,0.9,2,0.6,0,0.8,0,0,0,0,0.6,0.8,-0.032,0,0,0.5,3,0,0,1,0.032,0,0,0.5,1,3.5,1,3.25,0.5\n\
         5001000,1700000000005000007,0,-nan(ind),2,0,0,{none},{none},{none},{none},0,0,{none},{none},0,0,\
         -nan(ind),0,-nan(ind),0\n\
         10001000,17000000000100"
    );
    let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
    assert_eq!(recording.len(), 2);
    let first = recording.get(0).expect("two");
    assert_eq!((first.device_time_ns, first.time_ns), (Some(1000), 1_700_000_000_000_000_007));
    assert_eq!(first.combined.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
    assert_eq!(first.left.direction, Some(DVec3::new(0.0, 0.6, -0.8)));
    assert_eq!(first.left.origin_m, Some(DVec3::new(-0.032, 0.0, 0.0)));
    assert!(first.combined.valid && first.left.valid && !first.right.valid, "an eye that is merely visible");
    assert_eq!((first.left.pupil_mm, first.right.openness), (Some(3.5), Some(0.5)));
    let second = recording.get(1).expect("two");
    assert!(!second.combined.valid && second.combined.direction.is_none() && second.left.pupil_mm.is_none());
    let skipped = &recording.info.skipped;
    assert_eq!(skipped.len(), 1, "{skipped:?}");
    assert_eq!(skipped[0].rows, 1);
    assert_eq!(skipped[0].why, "the file breaks off in line 4");
    assert!(recording.extra_column("stability").is_some_and(|values| values == [0.9, 0.0]));
}

const UNITY: &str = "Frame;CaptureTime;LogTime;HMDPosition;HMDRotation;GazeStatus;CombinedGazeForward;\
    CombinedGazePosition;InterPupillaryDistanceInMM;LeftEyeStatus;LeftEyeForward;LeftEyePosition;\
    LeftPupilDiameterInMM;RightEyeStatus;RightEyeForward;RightEyePosition;RightPupilDiameterInMM\n";

#[test]
fn vectors_in_brackets_are_read_with_points_and_commas() {
    // 63 713 433 600 000 ms of .NET are the begin of 2020.
    let point = "1;2000000;63713433600000;(1.000, 1.500, -2.000);(0.000, 0.707, 0.000, 0.707);VALID;\
        (0.600, 0.000, 0.800);(0.000, 0.000, 0.000);63.5;VALID;(0.000, 0.600, 0.800);\
        (-0.032, 0.000, 0.000);3.5;INVALID;;;\n";
    let comma = point.replace("63.5", "63,5").replace("3.5", "3,5").replace("1;2000000", "2;2010000");
    let comma = comma.replace("(0.600, 0.000, 0.800)", "(0,600, 0,000, 0,800)");
    let recording =
        read_unity(&input(format!("{UNITY}{point}{comma}")), &ReadOptions::default()).expect("both");
    for sample in recording.samples() {
        assert_eq!(sample.combined.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
        assert_eq!(sample.left.direction, Some(DVec3::new(0.0, 0.6, -0.8)));
        assert_eq!(sample.left.pupil_mm, Some(3.5));
        assert!(sample.combined.valid && sample.left.valid && !sample.right.valid);
        assert_eq!(sample.received_ns, 1_577_836_800_000_000_000);
    }
    let head = recording.get(0).and_then(|sample| sample.head).expect("told");
    assert_eq!(head.position_m, DVec3::new(1.0, 1.5, 2.0));
    assert!((head.world_from_view * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-15));
    let device: Vec<_> = recording.samples().filter_map(|sample| sample.device_time_ns).collect();
    assert_eq!(device, [2_000_000, 2_010_000]);
    // Both were logged in the same ms: the later one had the least delay.
    assert_eq!(recording.times_ns()[1], 1_577_836_800_000_000_000);
    assert_eq!(recording.extra_column("InterPupillaryDistanceInMM"), Some([63.5, 63.5].as_slice()));
}

#[test]
fn broken_vectors_are_missing() {
    for field in ["", "(", "()", "(1, 2)", "(a, b, c)", "1 2 3", "(1,,3)"] {
        let vector: [f64; 3] = vector_of(field.as_bytes());
        assert!(vector.iter().any(|value| value.is_nan()), "{field} {vector:?}");
    }
}
