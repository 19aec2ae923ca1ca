//! A real HID tracker, as the Linux kernel sees one: within a virtual machine, whose first process is this
//! very test, uhid makes the device and everything of [`macula_trackers::hid`] runs on `/dev/hidraw0`.
//!
//! Outside, the test boots that machine. Where it cannot be had it says `SKIPPED:` and passes.

mod checks;
mod machine;
mod uhid;

use std::io::Write;
use std::path::Path;
use std::process::Command;

/// What `tools/hid-vm` says where there can be no machine.
const CANNOT_BE_HAD: i32 = 77;

#[test]
fn a_real_tracker() {
    if machine::is_inside() {
        machine::prepare();
        checks::run();
        println!("hid-vm: passed");
        machine::end();
    } else {
        boot();
    }
}

fn boot() {
    let binary = std::env::current_exe().expect("this test is a file");
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in a workspace");
    // .../target/debug/deps/hid_vm-0123
    let target = binary.ancestors().nth(3).expect("tests lie within the target folder");
    let output = Command::new(workspace.join("tools/hid-vm"))
        .arg(&binary)
        .arg("a_real_tracker")
        .env("CARGO_TARGET_DIR", target)
        .output()
        .expect("tools/hid-vm can be run");
    let told = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(CANNOT_BE_HAD) {
        let why = errors.lines().last().unwrap_or_default();
        // Straight to the stream: what is printed in a test that passes is not shown.
        writeln!(std::io::stderr(), "SKIPPED: a real HID tracker in a virtual machine: {why}")
            .expect("stderr");
        return;
    }
    println!("{told}");
    assert!(output.status.success(), "{errors}");
}
