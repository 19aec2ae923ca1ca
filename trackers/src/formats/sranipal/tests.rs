use super::super::testing::input;
use super::*;
use crate::testing::shared;
use glam::DVec3;

const HEADER: &str = "time(100ns);time_stamp(ms);time(UnityVideoPlayer);frame;eye_valid_L;eye_valid_R;\
    openness_L;openness_R;pupil_diameter_L(mm);pupil_diameter_R(mm);gaze_origin_L.x(mm);gaze_origin_L.y(mm);\
    gaze_origin_L.z(mm);gaze_origin_R.x(mm);gaze_origin_R.y(mm);gaze_origin_R.z(mm);gaze_direct_L.x;\
    gaze_direct_L.y;gaze_direct_L.z;gaze_direct_R.x;gaze_direct_R.y;gaze_direct_R.z;helmet_pos_x;\
    helmet_pos_y;helmet_pos_z;helmet_rot_x;helmet_rot_y;helmet_rot_z\r\n";

/// A row of two eyes that look alike, at a device time in ms and an arrival in ticks after 2020 began.
fn row(device_ms: i64, ticks: i64, mask: u32) -> String {
    // 2020-01-01 is 1 577 836 800 s after 1970.
    let ticks = UNIX_FROM_NET_TICKS + 15_778_368_000_000_000 + ticks;
    format!(
        "{ticks};{device_ms};0.5;7;{mask};31;0.75;1;-1;3.5;38;2;-39;-31;1;-37;0.6;0;0.8;0;0.6;0.8;1;1.5;-2;0;90;0\r\n"
    )
}

fn read_text(rows: &str) -> Recording {
    super::super::read_input(&input(format!("{HEADER}{rows}\r\n")), &ReadOptions::default())
        .expect("well formed")
}

#[test]
fn left_is_left_and_forward_is_forward() {
    let recording = read_text(&row(5000, 0, 31));
    let sample = recording.get(0).expect("one");
    assert_eq!(sample.left.direction, Some(DVec3::new(-0.6, 0.0, -0.8)));
    assert_eq!(sample.right.direction, Some(DVec3::new(0.0, 0.6, -0.8)));
    assert_eq!(sample.left.origin_m, Some(DVec3::new(-0.038, 0.002, 0.039)));
    assert!(sample.left.valid && sample.right.valid && !sample.combined.valid);
    assert_eq!((sample.left.pupil_mm, sample.right.pupil_mm), (None, Some(3.5)), "-1 is no diameter");
    let head = sample.head.expect("told");
    assert_eq!(head.position_m, DVec3::new(1.0, 1.5, 2.0));
    assert!((head.world_from_view * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-15));
    assert_eq!(sample.device_time_ns, Some(5_000_000_000));
    assert_eq!(sample.received_ns, 1_577_836_800_000_000_000);
    assert_eq!(recording.extra_column("frame"), Some([7.0].as_slice()));
}

#[test]
fn the_mask_says_what_can_be_used() {
    // Origin, openness and pupil position; then openness alone; then all but the direction.
    let rows = [row(0, 0, 25), row(8, 0, 8), row(16, 0, 29)].concat();
    let left: Vec<_> = read_text(&rows).samples().map(|sample| sample.left).collect();
    assert!(left.iter().all(|eye| !eye.valid && eye.openness == Some(0.75)));
    let origins: Vec<_> = left.iter().map(|eye| eye.origin_m.is_some()).collect();
    assert_eq!(origins, [true, false, true]);
}

#[test]
fn a_clock_of_32_bits_goes_on_over_its_ends() {
    let ends = [i64::from(i32::MAX) - 3, i64::from(i32::MIN) + 4, i64::from(i32::MIN) + 12];
    let rows: String = ends.iter().zip(0..).map(|(ms, n)| row(*ms, n * 80_000, 31)).collect();
    let recording = read_text(&rows);
    let steps: Vec<_> = recording.times_ns().windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert_eq!(steps, [8_000_000, 8_000_000]);
    let rows: String = [-4, 4, 12].iter().zip(0..).map(|(ms, n)| row(*ms, n * 80_000, 31)).collect();
    let recording = read_text(&rows);
    let device: Vec<_> = recording.samples().filter_map(|sample| sample.device_time_ns).collect();
    // -4 is 2^32 - 4 as the device counts.
    assert_eq!(device, [4_294_967_292_000_000, 4_294_967_300_000_000, 4_294_967_308_000_000]);
}

#[test]
fn the_least_delay_puts_device_times_on_the_hosts_clock() {
    // Arrivals 5 ms, 0 and 2 ms after the device's own steps of 8 ms.
    let rows = [row(100, 50_000, 31), row(108, 80_000, 31), row(116, 180_000, 31)].concat();
    let recording = read_text(&rows);
    let begin_ns = 1_577_836_800_000_000_000;
    let times_ns: Vec<_> = recording.times_ns().iter().map(|time_ns| time_ns - begin_ns).collect();
    assert_eq!(times_ns, [0, 8_000_000, 16_000_000]);
    assert!(recording.samples().all(|sample| sample.time_ns <= sample.received_ns));
}

#[test]
fn repeated_samples_stay_and_are_told() {
    let rows = [row(100, 0, 31), row(100, 10, 31), row(100, 20, 31), row(108, 90_000, 31)].concat();
    let recording = read_text(&rows);
    assert_eq!(recording.len(), 4);
    assert!(recording.info.notes.iter().any(|note| note.starts_with("2 samples have the same time")));
}

/// Degrees a second of the mean of both eyes between neighbours, the middle one of all.
fn median_speed(recording: &Recording, direction: impl Fn(&GazeSample) -> Option<DVec3>) -> f64 {
    let samples: Vec<_> = recording.samples().collect();
    let mut speeds: Vec<f64> = samples
        .windows(2)
        .filter_map(|pair| {
            let seconds = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
            let angle = direction(&pair[0])?.angle_between(direction(&pair[1])?);
            Some(angle.to_degrees() / seconds)
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds[speeds.len() / 2]
}

#[test]
fn gaze_in_the_world_stands_still_only_with_the_axes_taken() {
    let Some(folder) = shared("data/gaze/eyedentify3d_vive_pro_eye") else { return };
    let file = folder.join("TESTNA01_360VR_Fist3.csv");
    let recording = super::super::read(&file, &ReadOptions::default()).expect("a good file");
    let in_world = |sample: &GazeSample, mirror: f64| {
        let (direction, one_eye) = sample.gaze_direction()?;
        let head = sample.head.filter(|_| !one_eye)?;
        Some(head.world_from_view * (direction * DVec3::new(mirror, 1.0, 1.0)))
    };
    let taken = median_speed(&recording, |sample| in_world(sample, 1.0));
    let mirrored = median_speed(&recording, |sample| in_world(sample, -1.0));
    assert!(taken < 0.85 * mirrored, "{taken} {mirrored}");
}
