//! What can go wrong outside the program's own control. Every message is one line that says what, where
//! and what to do.

use std::path::{Path, PathBuf};

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the environment. What is expected of a live source (a disconnect, a loss) is no error but
/// a [`crate::source::SourceEvent`].
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or socket could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is broken or of an unknown kind.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, where in the file, and what to do.
        cause: String,
    },
    /// A device cannot be used.
    #[error("{device}: {cause}")]
    Device {
        /// The device's name or path.
        device: String,
        /// What is wrong and what to do.
        cause: String,
    },
    /// A setting is out of range or contradicts another.
    #[error("{0}")]
    Setting(String),
}

impl Error {
    /// An [`Error::Io`] about `path`.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), source }
    }

    /// An [`Error::File`] about `path`. `cause` is brought onto one line.
    pub fn file(path: impl AsRef<Path>, cause: impl std::fmt::Display) -> Self {
        Self::File { path: path.as_ref().to_owned(), cause: one_line(&cause.to_string()) }
    }

    /// An [`Error::Device`]. `cause` is brought onto one line.
    pub fn device(device: impl Into<String>, cause: impl std::fmt::Display) -> Self {
        Self::Device { device: device.into(), cause: one_line(&cause.to_string()) }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
