//! The command line's binary.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The binary `macula` of this build's profile; built where it is missing.
///
/// # Panics
/// Where it cannot be built.
#[must_use]
pub fn binary() -> PathBuf {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(find_or_build).clone()
}

fn find_or_build() -> PathBuf {
    let test = std::env::current_exe().expect("this test's path");
    // target/<profile>/deps/<test>
    let folder = test.ancestors().nth(2).expect("a profile's folder").to_owned();
    let path = folder.join(format!("macula{}", std::env::consts::EXE_SUFFIX));
    let stale = |path: &PathBuf| {
        let time = |path: &PathBuf| path.metadata().and_then(|data| data.modified()).ok();
        time(path).is_none() || time(path) < time(&test)
    };
    if stale(&path) {
        // Quick where nothing has changed.
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(["build", "--quiet", "-p", "macula-tools"]).current_dir(crate::data::workspace());
        if folder.file_name().is_some_and(|name| name == "release") {
            cargo.arg("--release");
        }
        let built = cargo.status().expect("cargo runs");
        assert!(built.success() && path.exists(), "macula cannot be built");
    }
    path
}

/// `macula` with arguments, to be run.
#[must_use]
pub fn macula(arguments: &[&str]) -> Command {
    let mut command = Command::new(binary());
    command.args(arguments);
    command
}

/// Runs `macula`.
///
/// # Panics
/// Where it cannot be started.
#[must_use]
pub fn run(arguments: &[&str]) -> Output {
    macula(arguments).output().expect("macula runs")
}

/// Fails unless the run ended with `code`, with one line on stderr that begins with `error: ` and
/// nothing on stdout; gives that line.
///
/// # Panics
/// Then.
#[track_caller]
pub fn failure(output: &Output, code: i32, what: &str) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{what}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    assert!(stderr.starts_with("error: ") && stderr.len() > 15, "{what}: {stderr}");
    assert!(output.stdout.is_empty(), "{what}");
    stderr.trim_end().to_owned()
}

/// Fails unless the run succeeded; gives the JSON document on stdout.
///
/// # Panics
/// Then.
#[track_caller]
pub fn json(output: &Output, what: &str) -> serde_json::Value {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{what}: {stderr}");
    serde_json::from_slice(&output.stdout).expect("a JSON document")
}

/// A temporary folder for the files of a test.
pub struct Place(tempfile::TempDir);

impl Default for Place {
    fn default() -> Self {
        Self::new()
    }
}

impl Place {
    /// Makes one.
    ///
    /// # Panics
    /// Where there can be none.
    #[must_use]
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.0.path()
    }

    /// The path of a file in it, which need not exist.
    #[must_use]
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_string_lossy().into_owned()
    }

    /// Writes a file; its path.
    ///
    /// # Panics
    /// Where it cannot be written.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    }

    /// Names of the files in it, in order.
    ///
    /// # Panics
    /// Where the folder cannot be read.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a readable folder");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}
