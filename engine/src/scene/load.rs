//! glTF files.
