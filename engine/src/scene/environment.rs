//! Environment maps.
/// Stub.
pub struct Environment;
