//! The first process of the machine: what an init must do.

use rustix::mount::{MountFlags, mount};
use rustix::system::{RebootCommand, init_module, reboot};
use std::fs;

/// Whether this runs within the machine; set on the kernel's command line.
pub fn is_inside() -> bool {
    std::env::var_os("MACULA_HID_VM").is_some()
}

/// Mounts the kernel's file systems and loads the modules that lie in `/modules`.
pub fn prepare() {
    for (kind, at) in [("devtmpfs", "/dev"), ("sysfs", "/sys"), ("proc", "/proc")] {
        mount(kind, at, kind, MountFlags::empty(), None)
            .unwrap_or_else(|error| panic!("mount {at}: {error}"));
    }
    let order = fs::read_to_string("/modules/order").expect("the list of modules");
    for name in order.lines() {
        let image = fs::read(format!("/modules/{name}")).expect("a module");
        init_module(&image, c"").unwrap_or_else(|error| panic!("module {name}: {error}"));
    }
}

/// Ends the machine.
pub fn end() {
    reboot(RebootCommand::Restart).expect("the first process may end the machine");
}
