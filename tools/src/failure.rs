//! Failures as the user sees them: one line on stderr and an exit code.

use macula::Error;
use std::io;

const DISK_FULL: &str = "free some space or write elsewhere";

/// Why a command ends early.
#[derive(Debug)]
pub enum Failure {
    /// The command line makes no sense or a setting is out of range: exit code 2.
    Usage(String),
    /// A file, the device or the system is at fault: exit code 1.
    Environment(String),
    /// The reader of our output is gone (`macula ... | head`): nothing more to do, exit code 0.
    StdoutClosed,
}

impl Failure {
    /// A command line that makes no sense.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage(message.into())
    }

    /// A fault outside the program.
    pub fn environment(message: impl Into<String>) -> Self {
        Self::Environment(message.into())
    }

    /// The exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::StdoutClosed => 0,
            Self::Environment(_) => 1,
            Self::Usage(_) => 2,
        }
    }

    /// The line for stderr, if there is anything to say.
    pub fn line(&self) -> Option<String> {
        match self {
            Self::Usage(message) | Self::Environment(message) => {
                Some(format!("error: {}", message.split_whitespace().collect::<Vec<_>>().join(" ")))
            }
            Self::StdoutClosed => None,
        }
    }
}

/// What to do about an error of the system.
fn io_hint(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::NotFound => "check the path",
        io::ErrorKind::PermissionDenied => "check who may read and write there",
        io::ErrorKind::StorageFull => DISK_FULL,
        // Encoders hand the system's words on, but not its kind of error.
        _ if source.to_string().contains("No space left on device") => DISK_FULL,
        _ => "",
    }
}

impl Failure {
    /// An error that already says what to do is left as it is.
    fn with_hint(message: String, hint: &str) -> Self {
        if hint.is_empty() || message.contains(';') {
            return Self::Environment(message);
        }
        Self::Environment(format!("{message}; {hint}"))
    }
}

impl From<macula_trackers::Error> for Failure {
    fn from(error: macula_trackers::Error) -> Self {
        let message = error.to_string();
        match &error {
            macula_trackers::Error::Setting(_) => Self::Usage(message),
            macula_trackers::Error::Io { source, .. } => Self::with_hint(message, io_hint(source)),
            _ => Self::Environment(message),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let message = error.to_string();
        let hint = match &error {
            Error::Setting(_) => return Self::Usage(message),
            Error::Io { source, .. } => io_hint(source),
            Error::NoDevice(_) => "`macula doctor` shows what was found and what is missing",
            Error::Memory { .. } => "choose a smaller --size, or close what else uses the GPU",
            _ => "",
        };
        Self::with_hint(message, hint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_exit_with_2_and_files_with_1() {
        assert_eq!(Failure::from(Error::Setting("sigma is 0".into())).exit_code(), 2);
        let missing = Failure::from(Error::io("a.glb", io::Error::from(io::ErrorKind::NotFound)));
        assert_eq!(missing.exit_code(), 1);
        let line = missing.line().unwrap_or_default();
        assert!(line.starts_with("error: a.glb: ") && line.ends_with("; check the path"), "{line}");
    }

    #[test]
    fn a_full_disk_is_known_by_kind_or_by_words() {
        let words = io::Error::other("No space left on device (os error 28)");
        for source in [io::Error::from(io::ErrorKind::StorageFull), words] {
            let line = Failure::from(Error::io("a.png", source)).line().unwrap_or_default();
            assert!(line.ends_with(DISK_FULL), "{line}");
        }
    }

    #[test]
    fn a_message_is_one_line() {
        let line = Failure::usage("first\n  second").line();
        assert_eq!(line.as_deref(), Some("error: first second"));
    }
}
