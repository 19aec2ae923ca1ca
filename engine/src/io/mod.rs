//! Pictures in and out of files. A file appears under its name only when it is whole: everything
//! is written under a temporary name in the same folder and then renamed.

pub mod image_file;
