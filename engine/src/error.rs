//! The errors that the environment can cause. Each names the file, device or object it is about,
//! and says what to do where something can be done. A caller's bug is an assertion, not an error.

use std::path::{Path, PathBuf};

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong outside the program's own control. `Display` is one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A scene, image or environment file is broken or asks for what is not supported.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and where.
        cause: String,
    },
    /// A setting is out of range.
    #[error("{0}")]
    Setting(String),
    /// No usable Vulkan driver or device.
    #[error("{0}")]
    NoDevice(String),
    /// A Vulkan call failed.
    #[error("Vulkan: {what} failed: {code}")]
    Vulkan {
        /// What was being done, with the object's name.
        what: String,
        /// The code that Vulkan returned.
        code: ash::vk::Result,
    },
    /// The device was lost: the driver or the hardware gave up on the submitted work.
    #[error(
        "the Vulkan device was lost while {0}; restart the program, and update the driver if it happens again"
    )]
    DeviceLost(String),
    /// GPU memory could not be had.
    #[error("GPU memory for {what}: {cause}")]
    Memory {
        /// The resource's name.
        what: String,
        /// What the allocator said.
        cause: String,
    },
}

impl Error {
    /// An [`Error::Io`] about `path`.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), source }
    }

    /// An [`Error::File`] about `path`. `cause` is brought onto one line.
    pub fn file(path: impl AsRef<Path>, cause: impl std::fmt::Display) -> Self {
        let cause = cause.to_string();
        Self::File {
            path: path.as_ref().to_owned(),
            cause: cause.split_whitespace().collect::<Vec<_>>().join(" "),
        }
    }
}
