//! What a host must bring, and what it brings: an instance, a device, a queue and images with
//! declared entry and exit states. The host owns them all; the engine only borrows.

use ash::vk;

pub use crate::gpu::context::{Context, ContextParts};

/// The device features that the engine needs; all are mandatory in Vulkan 1.3, so any 1.3 device
/// has them. A host chains this into its own `VkDeviceCreateInfo`.
pub fn required_features() -> vk::PhysicalDeviceVulkan13Features<'static> {
    vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .synchronization2(true)
        .shader_demote_to_helper_invocation(true)
}

/// What a device lacks, one clause each; empty for a usable device.
#[must_use]
pub fn missing_requirements(instance: &ash::Instance, device: vk::PhysicalDevice) -> Vec<String> {
    // SAFETY: the caller gives a device of this instance.
    let properties = unsafe { instance.get_physical_device_properties(device) };
    if properties.api_version < vk::API_VERSION_1_3 {
        let version = properties.api_version;
        return vec![format!(
            "Vulkan 1.3 (has {}.{})",
            vk::api_version_major(version),
            vk::api_version_minor(version)
        )];
    }
    let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan13);
    // SAFETY: as above; the chain holds only structures of Vulkan 1.3.
    unsafe { instance.get_physical_device_features2(device, &mut features) };
    let mut missing = Vec::new();
    let needed = [
        (vulkan13.dynamic_rendering, "dynamicRendering"),
        (vulkan13.synchronization2, "synchronization2"),
        (vulkan13.shader_demote_to_helper_invocation, "shaderDemoteToHelperInvocation"),
    ];
    for (present, name) in needed {
        if present == vk::FALSE {
            missing.push(name.to_owned());
        }
    }
    missing
}

/// An image of the host that the engine draws the finished picture into.
#[derive(Clone, Copy, Debug)]
pub struct TargetImage {
    /// The image; it needs the usage `COLOR_ATTACHMENT`.
    pub image: vk::Image,
    /// A 2D colour view of it.
    pub view: vk::ImageView,
    /// The layout in which the engine finds it. `UNDEFINED` discards what it holds.
    pub entry_layout: vk::ImageLayout,
    /// The layout in which the engine leaves it.
    pub exit_layout: vk::ImageLayout,
}
