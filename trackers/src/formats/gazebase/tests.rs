use super::super::testing::input;
use super::*;
use glam::DVec3;

/// `(tan x, tan y, -1)` of degrees, scaled to length 1.
fn expected(tan_x: f64, tan_y: f64) -> DVec3 {
    DVec3::new(tan_x, tan_y, -1.0).normalize()
}

fn near(told: Option<DVec3>, expected: DVec3) {
    assert!(told.is_some_and(|told| told.abs_diff_eq(expected, 1e-12)), "{told:?} {expected}");
}

#[test]
fn degrees_become_directions_and_val_decides() {
    let file =
        "n,x,y,val,dP,lab,xT,yT\n0,45,0,0,3000,1,10,NaN\n1,0,-45,1,3001,1,10,NaN\n2,NaN,NaN,1,0,3,10,NaN\n";
    let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
    assert_eq!(recording.times_ns(), [0, 1_000_000, 2_000_000]);
    let left: Vec<_> = recording.samples().map(|sample| sample.left).collect();
    near(left[0].direction, expected(1.0, 0.0));
    near(left[1].direction, expected(0.0, -1.0));
    assert_eq!(left[2].direction, None);
    assert_eq!(left.iter().map(|eye| eye.valid).collect::<Vec<_>>(), [true, false, false]);
    assert_eq!(recording.extra_column("lab"), Some([1.0, 1.0, 3.0].as_slice()));
    assert_eq!(recording.extra_column("yT"), None, "never told");
}

#[test]
fn a_file_without_its_header_is_read_in_the_documented_order() {
    let options = ReadOptions { format: Some("gazebase-csv".to_owned()), ..ReadOptions::default() };
    let file = "0,45,0,0,3000,1,NaN,NaN\n1,45,0,0,3000,1,NaN,NaN\n";
    let recording = super::super::read_input(&input(file), &options).expect("eight columns");
    assert_eq!(recording.len(), 2);
    assert!(recording.info.notes[0].contains("no header"), "{:?}", recording.info.notes);
    let error = super::super::read_input(&input("1,2,3\n4,5,6\n"), &options).expect_err("three columns");
    assert!(error.to_string().contains("the columns n, x, y"), "{error}");
}

#[test]
fn three_columns_are_enough() {
    let text = input("n,x,y\n0,0,0\n1,nan,0\n");
    let recording = super::super::read_input(&text, &ReadOptions::default()).expect("time and angles");
    assert_eq!(recording.info.format, "gazebase-csv");
    assert_eq!(recording.samples().map(|sample| sample.left.valid).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn the_vr_data_set_has_three_gazes_and_two_eyes() {
    let file = "n,x,y,lx,ly,rx,ry,xT,yT,zT,clx,cly,clz,crx,cry,crz\n\
        0.0,0,0,45,0,-45,0,0,0,1.5,-0.03,0.002,-0.029,0.031,0.004,-0.03\n\
        3.9699,0,45,nan,nan,0,0,0,0,1.5,-0.03,0.002,-0.029,0.031,0.004,-0.03\n";
    let recording = read_vr(&input(file), &ReadOptions::default()).expect("well formed");
    assert_eq!(recording.times_ns(), [0, 3_969_900]);
    let first = recording.get(0).expect("two");
    near(first.combined.direction, DVec3::NEG_Z);
    near(first.left.direction, expected(1.0, 0.0));
    near(first.right.direction, expected(-1.0, 0.0));
    assert_eq!(first.left.origin_m, Some(DVec3::new(-0.03, 0.002, 0.029)));
    let second = recording.get(1).expect("two");
    assert!(second.combined.valid && second.right.valid && !second.left.valid);
}

#[test]
fn px_become_fractions_and_directions_of_the_display() {
    let file = "trialId\tpointId\ttime\tx_left\ty_left\tx_right\ty_right\n\
        1\t1\t8005274\t640\t512\t1280\t0\n1\t1\t8005275\tnan\tnan\t640\t512\n";
    let recording = read_judo(&input(file), &ReadOptions::default()).expect("well formed");
    let first = recording.get(0).expect("two");
    assert_eq!(first.time_ns, 8_005_274_000_000);
    assert_eq!(first.left.point, Some(DVec2::splat(0.5)));
    near(first.left.direction, DVec3::NEG_Z);
    // The top right corner of 38 x 30.2 cm at 68 cm.
    near(first.right.direction, expected(0.19 / 0.68, 0.151 / 0.68));
    assert!(!recording.get(1).expect("two").left.valid);
    assert_eq!(recording.extra_column("trialId"), Some([1.0, 1.0].as_slice()));
}
