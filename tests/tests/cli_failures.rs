//! Bad input: one clear line, the right exit code, and nothing half-written left behind.

use macula_tests::cli::{Place, binary, failure, macula, run};
use std::process::{Command, Stdio};

const NO_DRIVER: [(&str, &str); 2] =
    [("VK_DRIVER_FILES", "/nonexistent/driver.json"), ("VK_ICD_FILENAMES", "/nonexistent/driver.json")];

/// A small scene that loads.
fn scene(place: &Place) -> String {
    place.write("empty.gltf", r#"{"asset":{"version":"2.0"},"scenes":[{}],"scene":0}"#)
}

#[test]
fn files_that_are_missing_or_broken() {
    let place = Place::new();
    let out = place.path("out.png");
    let missing = place.path("missing.glb");
    let broken = place.path("broken.glb");
    std::fs::write(&broken, b"glTF\x02\x00\x00\x00\xff\xff\xff\x7f").unwrap();
    let empty = place.path("zero.gltf");
    std::fs::write(&empty, b"").unwrap();
    let noise = place.path("noise.hdr");
    std::fs::write(&noise, b"#?RADIANCE\nnoise").unwrap();
    let scene = scene(&place);
    let before = place.names();
    for (arguments, named) in [
        (vec!["render", &missing, "-o", &out], "missing.glb"),
        (vec!["render", &broken, "-o", &out], "broken.glb"),
        (vec!["render", &empty, "-o", &out], "zero.gltf"),
        (vec!["render", &scene, "-o", &out, "--env", &noise], "noise.hdr"),
        (vec!["info", &missing], "missing.glb"),
        (vec!["info", &broken], "broken.glb"),
        (vec!["compare", &missing, &broken], "missing.glb"),
        (vec!["compare", &noise, &broken], "noise.hdr"),
    ] {
        for json in [false, true] {
            let mut arguments = arguments.clone();
            if json {
                arguments.push("--json");
            }
            let line = failure(&run(&arguments), 1, named);
            assert!(line.contains(named), "{line}");
        }
    }
    assert_eq!(place.names(), before);
}

#[test]
fn settings_out_of_range() {
    let place = Place::new();
    let (scene, out) = (scene(&place), place.path("out.png"));
    let before = place.names();
    for wrong in [
        vec!["--size", "0x100"],
        vec!["--size", "100x0"],
        vec!["--size", "100"],
        vec!["--size", "100000x100"],
        vec!["--size", "4000000000x4000000000"],
        vec!["--sigma", "0.5"],
        vec!["--sigma", "-1"],
        vec!["--sigma", "nan"],
        vec!["--sigma", "1e9"],
        vec!["--alpha", "0.5"],
        vec!["--alpha", "7"],
        vec!["--alpha", "inf"],
        vec!["--kernel", "cubic"],
        vec!["--kernel", "poly", "--beta", "0,0.5"],
        vec!["--kernel", "poly", "--beta", "0,3,-2"],
        vec!["--hfov-deg", "0"],
        vec!["--hfov-deg", "180"],
        vec!["--gaze", "nan,0"],
        vec!["--exposure", "-1"],
        vec!["--shadowed-lights", "99"],
        vec!["--shadow-map-size", "1"],
        vec!["--method", "other"],
        vec!["--nonsense"],
        vec!["--camera", "missing"],
    ] {
        let output = run(&[&["render", &scene, "-o", &out][..], &wrong].concat());
        failure(&output, 2, &format!("{wrong:?}"));
    }
    for wrong in [
        vec!["scene", "hall", "-o", "a.glb", "--triangles", "5"],
        vec!["scene", "hall", "-o", "a.glb", "--lights", "0"],
        vec!["scene", "hall", "-o", "a.txt"],
        vec!["map", "--size", "0x0"],
        vec!["map", "--alpha", "9"],
        vec![],
        vec!["frobnicate"],
    ] {
        failure(&macula(&wrong).stdin(Stdio::null()).output().unwrap(), 2, &format!("{wrong:?}"));
    }
    assert_eq!(place.names(), before);
}

#[test]
fn pictures_that_cannot_be_written() {
    let place = Place::new();
    let scene = scene(&place);
    let nowhere = place.path("no/such/folder/out.png");
    let line = failure(&run(&["render", &scene, "-o", &nowhere, "--size", "32x32"]), 1, "no folder");
    assert!(line.contains("out.png") && line.contains("folder"), "{line}");
    // Taken by a folder: found only when the file is put in its place.
    let taken = place.path("taken.png");
    std::fs::create_dir(&taken).unwrap();
    let before = place.names();
    let line = failure(&run(&["render", &scene, "-o", &taken, "--size", "32x32"]), 1, "a folder");
    assert!(line.contains("taken.png"), "{line}");
    assert_eq!(place.names(), before);
    let line = failure(&run(&["render", &scene, "-o", "/dev/full"]), 2, "/dev/full");
    assert!(line.contains("/dev/full"), "{line}");
    let glb = place.path("no/such/hall.glb");
    let line = failure(&run(&["scene", "hall", "-o", &glb, "--triangles", "10000"]), 1, "no folder");
    assert!(line.contains("hall.glb"), "{line}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let place = Place::new();
    let before = place.names();
    // Files may grow to 64 KiB and not beyond, and the signal that says so is ignored, as a full disk
    // would: the hall does not fit.
    let limited = |arguments: &str| {
        let script = format!("trap '' XFSZ; ulimit -f 64; exec \"$0\" {arguments}");
        Command::new("sh").arg("-c").arg(script).arg(binary()).current_dir(place.folder()).output().unwrap()
    };
    let line = failure(&limited("scene hall -o hall.glb --triangles 10000"), 1, "disk");
    assert!(line.contains("hall.glb"), "{line}");
    let line =
        failure(&limited("render sdf:primitives -o out.exr --size 256x256 --no-validation"), 1, "disk");
    assert!(line.contains("out.exr"), "{line}");
    assert_eq!(place.names(), before, "something half-written is left");
    // The result itself.
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = macula(&["scene", "--help"]).output().unwrap();
    assert!(output.status.success());
    let output = macula(&["doctor", "--json"]).stdout(full).output().unwrap();
    failure(&output, 1, "/dev/full");
}

#[test]
fn no_vulkan_driver() {
    let place = Place::new();
    let (scene, out) = (scene(&place), place.path("out.png"));
    let before = place.names();
    for arguments in [
        vec!["render", &scene, "-o", &out, "--size", "32x32"],
        vec!["render", "sdf:primitives", "-o", &out, "--json"],
        vec!["map", "--gpu"],
    ] {
        let output = macula(&arguments).envs(NO_DRIVER).stdin(Stdio::null()).output().unwrap();
        let line = failure(&output, 1, &format!("{arguments:?}"));
        assert!(line.contains("driver") || line.contains("device"), "{line}");
    }
    // What needs no device still works.
    assert!(macula(&["info", &scene]).envs(NO_DRIVER).output().unwrap().status.success());
    let output = macula(&["doctor"]).envs(NO_DRIVER).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(stderr.lines().count() == 1 && stderr.contains("driver"), "{stderr}");
    assert_eq!(place.names(), before);
}

#[test]
fn a_reader_that_goes_away() {
    let mut child = macula(&["map", "--size", "64x64"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    // The program may end before it has read everything.
    let _ = std::io::Write::write_all(&mut child.stdin.take().unwrap(), "1,2\n".repeat(10_000).as_bytes());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
}
