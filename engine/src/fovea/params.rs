//! What the shaders need to know of the mapping.
/// Stub.
pub struct FoveaParams;
