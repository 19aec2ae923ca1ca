//! What the build script learned of each shader.

use ash::vk;

/// A compiled shader.
#[derive(Debug)]
pub struct ShaderInfo {
    /// File name, as in `lp_shade.comp`.
    pub name: &'static str,
    /// Stage.
    pub stage: Stage,
    /// SPIR-V words.
    pub spirv: &'static [u32],
    /// Descriptors.
    pub bindings: &'static [BindingInfo],
    /// Specialization constants: name and id.
    pub spec: &'static [(&'static str, u32)],
    /// Structs reachable from descriptors and push constants.
    pub structs: &'static [StructInfo],
    /// Size of the push constant block.
    pub push_constant_bytes: u32,
}

/// Shader stages in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader.
    Compute,
}

impl Stage {
    /// Vulkan's flag.
    #[must_use]
    pub fn flags(self) -> vk::ShaderStageFlags {
        match self {
            Self::Vertex => vk::ShaderStageFlags::VERTEX,
            Self::Fragment => vk::ShaderStageFlags::FRAGMENT,
            Self::Compute => vk::ShaderStageFlags::COMPUTE,
        }
    }
}

/// A descriptor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BindingInfo {
    /// Name in the shader: the variable's, or else the block's.
    pub name: &'static str,
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// Kind.
    pub kind: DescriptorKind,
    /// Array size.
    pub count: u32,
}

/// Kinds of descriptor in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptorKind {
    /// Image and sampler.
    CombinedImageSampler,
    /// Image without sampler.
    SampledImage,
    /// Storage image.
    StorageImage,
    /// Uniform block.
    UniformBuffer,
    /// Storage block.
    StorageBuffer,
    /// Buffer read as texels.
    UniformTexelBuffer,
}

impl DescriptorKind {
    /// Vulkan's type.
    #[must_use]
    pub fn vk(self) -> vk::DescriptorType {
        match self {
            Self::CombinedImageSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            Self::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
            Self::UniformTexelBuffer => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        }
    }
}

/// A struct in a shader: what a Rust twin must match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructInfo {
    /// Name.
    pub name: &'static str,
    /// Bytes; 0 where the last member is an array without a size.
    pub size: usize,
    /// Member names and offsets in bytes.
    pub members: &'static [(&'static str, usize)],
}

/// A Rust struct that a shader reads: its fields and their offsets, for the comparison with
/// [`StructInfo`].
pub trait GpuLayout: bytemuck::Pod {
    /// The struct's name in GLSL.
    const NAME: &'static str;
    /// Field names and byte offsets.
    const FIELDS: &'static [(&'static str, usize)];
}

/// Implements [`GpuLayout`] for a struct.
#[macro_export]
macro_rules! gpu_layout {
    ($rust:ident, $glsl:literal { $($field:ident),* $(,)? }) => {
        impl $crate::gpu::reflect::GpuLayout for $rust {
            const NAME: &'static str = $glsl;
            const FIELDS: &'static [(&'static str, usize)] =
                &[$((stringify!($field), std::mem::offset_of!($rust, $field))),*];
        }
    };
}

/// Compares a Rust struct with every GLSL struct of its name.
///
/// # Errors
/// One line for the first difference: a field that only one side has, or another offset or size.
pub fn check_layout<T: GpuLayout>(shaders: &[&ShaderInfo]) -> Result<usize, String> {
    let mut compared = 0;
    for shader in shaders {
        for of in shader.structs.iter().filter(|of| of.name == T::NAME) {
            let at = |field: &str| format!("{}: {}.{field}", shader.name, T::NAME);
            if of.members.len() != T::FIELDS.len() {
                return Err(format!(
                    "{}: GLSL has {} fields, Rust {}",
                    at("*"),
                    of.members.len(),
                    T::FIELDS.len()
                ));
            }
            for (name, offset) in of.members {
                match T::FIELDS.iter().find(|(field, _)| field == name) {
                    None => return Err(format!("{}: missing in Rust", at(name))),
                    Some((_, rust)) if rust != offset => {
                        return Err(format!("{}: offset {offset} in GLSL, {rust} in Rust", at(name)));
                    }
                    Some(_) => {}
                }
            }
            // GLSL's size may leave out the padding at the end.
            let rust = size_of::<T>();
            if of.size > rust || of.size.next_multiple_of(16) < rust {
                return Err(format!("{}: {} bytes in GLSL, {rust} in Rust", at("*"), of.size));
            }
            compared += 1;
        }
    }
    Ok(compared)
}
