//! The engine's own instance and device.

use super::context::{Context, ContextParts};
use crate::error::{Error, Result};
use crate::host;
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What only the owner of a device holds. Dropped after everything made from the device.
pub(crate) struct OwnedHandles {
    device: ash::Device,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<AtomicU64>,
    validation: bool,
    instance: ash::Instance,
    /// The loaded Vulkan library; must outlive every call.
    _entry: ash::Entry,
}

impl OwnedHandles {
    pub(crate) fn validation_messages(&self) -> Option<u64> {
        self.validation.then(|| self.messages.load(Ordering::Relaxed))
    }
}

impl Drop for OwnedHandles {
    fn drop(&mut self) {
        // SAFETY: the context that holds this has destroyed everything made from the device, and
        // nothing runs on it: whoever submits work waits for it.
        unsafe {
            self.device.destroy_device(None);
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// Loads the Vulkan library.
pub(crate) fn load_entry() -> Result<ash::Entry> {
    // SAFETY: loading the system's Vulkan loader runs its initialisers, as every Vulkan program does.
    unsafe { ash::Entry::load() }.map_err(|error| {
        Error::NoDevice(format!(
            "no Vulkan loader found ({error}); install a Vulkan driver (Debian: apt-get install libvulkan1 mesa-vulkan-drivers)"
        ))
    })
}

/// Whether the validation layer is installed.
pub(crate) fn has_validation_layer(entry: &ash::Entry) -> bool {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str().is_ok_and(|name| name == VALIDATION_LAYER))
}

/// An instance for Vulkan 1.3; with the validation layer where asked for and installed.
pub(crate) fn make_instance(entry: &ash::Entry, validation: bool) -> Result<(ash::Instance, bool)> {
    // SAFETY: no preconditions.
    let version = unsafe { entry.try_enumerate_instance_version() };
    let version = version.ok().flatten().unwrap_or(vk::API_VERSION_1_0);
    if version < vk::API_VERSION_1_3 {
        return Err(Error::NoDevice("the Vulkan loader is older than 1.3; update libvulkan1".into()));
    }
    // SAFETY: no preconditions.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
    let debug_utils = extensions.iter().any(|extension| {
        extension.extension_name_as_c_str().is_ok_and(|name| name == ext::debug_utils::NAME)
    });
    let validation = validation && debug_utils && has_validation_layer(entry);
    let application = vk::ApplicationInfo::default()
        .application_name(c"macula")
        .engine_name(c"macula")
        .api_version(vk::API_VERSION_1_3);
    let layers = if validation { vec![VALIDATION_LAYER.as_ptr()] } else { Vec::new() };
    let mut names = Vec::new();
    if debug_utils {
        names.push(ext::debug_utils::NAME.as_ptr());
    }
    if validation {
        names.push(ext::validation_features::NAME.as_ptr());
    }
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&names);
    if validation {
        info = info.push_next(&mut features);
    }
    // SAFETY: every pointer in `info` outlives the call.
    let instance = unsafe { entry.create_instance(&info, None) };
    let instance = instance.map_err(|code| match code {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => no_driver(),
        code => Error::Vulkan { what: "making the Vulkan instance".into(), code },
    })?;
    Ok((instance, debug_utils))
}

fn no_driver() -> Error {
    Error::NoDevice(
        "no Vulkan driver found; install one (Debian: apt-get install mesa-vulkan-drivers), or point VK_DRIVER_FILES at its .json file"
            .into(),
    )
}

/// Every physical device, best first: discrete, integrated, virtual, software.
pub(crate) fn devices_by_preference(instance: &ash::Instance) -> Vec<vk::PhysicalDevice> {
    // SAFETY: the instance is alive.
    let mut devices = unsafe { instance.enumerate_physical_devices() }.unwrap_or_default();
    devices.sort_by_key(|&device| {
        // SAFETY: the handle came from this instance.
        match unsafe { instance.get_physical_device_properties(device) }.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => 0,
            vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
            vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
            _ => 3,
        }
    });
    devices
}

/// The first queue family that does graphics and compute.
pub(crate) fn queue_family(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<u32> {
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the handle came from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let usable = |family: &vk::QueueFamilyProperties| {
        family.queue_flags.contains(wanted) && family.timestamp_valid_bits > 0
    };
    families.iter().position(usable).and_then(|index| u32::try_from(index).ok())
}

/// Makes the engine's own device.
pub(crate) fn make_context(validation: bool) -> Result<Arc<Context>> {
    let entry = load_entry()?;
    let (instance, debug_utils) = make_instance(&entry, validation)?;
    let validation = validation && debug_utils && has_validation_layer(&entry);
    let messages = Box::new(AtomicU64::new(0));
    let messenger = validation.then(|| make_messenger(&entry, &instance, &messages)).transpose();
    let loader = messenger.as_ref().ok().cloned().flatten();
    let chosen = devices_by_preference(&instance).into_iter().find_map(|device| {
        let missing = host::missing_requirements(&instance, device);
        let family = queue_family(&instance, device)?;
        missing.is_empty().then_some((device, family))
    });
    let made = messenger.and_then(|messenger| {
        let (physical_device, family) = chosen.ok_or_else(|| {
            Error::NoDevice(
                "no Vulkan device meets the requirements (Vulkan 1.3 with a graphics and compute queue); `macula doctor` lists what each lacks"
                    .into(),
            )
        })?;
        let device = make_device(&instance, physical_device, family)?;
        Ok((messenger, physical_device, family, device))
    });
    let (messenger, physical_device, family, device) = match made {
        Ok(made) => made,
        Err(error) => {
            // SAFETY: the messenger is all that was made from the instance.
            unsafe {
                if let Some((loader, messenger)) = loader {
                    loader.destroy_debug_utils_messenger(messenger, None);
                }
                instance.destroy_instance(None);
            }
            return Err(error);
        }
    };
    // SAFETY: the queue was asked for when the device was made.
    let queue = unsafe { device.get_device_queue(family, 0) };
    let owned = OwnedHandles {
        device: device.clone(),
        messenger,
        messages,
        validation,
        instance: instance.clone(),
        _entry: entry,
    };
    let cache_file = cache_folder().map(|folder| folder.join("pipelines.bin"));
    let parts = ContextParts {
        instance,
        physical_device,
        device,
        queue,
        queue_family: family,
        debug_utils,
        cache_file,
    };
    Context::build(parts, Some(owned))
}

fn make_device(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
    family: u32,
) -> Result<ash::Device> {
    let queue = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let mut features = host::required_features();
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queue).push_next(&mut features);
    // SAFETY: the features are ones that `missing_requirements` found present.
    let device = unsafe { instance.create_device(physical_device, &info, None) };
    Context::check(device, || "making the Vulkan device".into())
}

fn make_messenger(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &AtomicU64,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
        )
        // Not PERFORMANCE: those advise against GENERAL layout, in which images here stay on purpose.
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(on_message))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast());
    // SAFETY: the counter is boxed and outlives the messenger.
    let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) };
    Ok((loader, Context::check(messenger, || "making the debug messenger".into())?))
}

/// Counts a message and prints it.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    counter: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `counter` is the boxed counter given when the messenger was made; `data` and its
    // message are valid during the call.
    unsafe {
        (*counter.cast::<AtomicU64>()).fetch_add(1, Ordering::Relaxed);
        if let Some(message) = (*data).message_as_c_str() {
            eprintln!("validation: {}", message.to_string_lossy());
        }
    }
    vk::FALSE
}

/// The user's cache folder for this program.
fn cache_folder() -> Option<PathBuf> {
    let base = std::env::var_os("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .or_else(|| std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".cache")))?;
    Some(base.join("macula"))
}

/// One feature of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FeatureReport {
    /// Vulkan's name.
    pub name: &'static str,
    /// The device has it.
    pub present: bool,
    /// What the engine uses it for.
    pub needed_for: &'static str,
    /// Without it the engine does not run.
    pub required: bool,
}

/// A device as `macula doctor` shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceReport {
    /// Name.
    pub name: String,
    /// Driver and version.
    pub driver: String,
    /// Vulkan version, as in `1.3.230`.
    pub api_version: String,
    /// Discrete, integrated, virtual, software or other.
    pub device_type: &'static str,
    /// The engine can run on it.
    pub usable: bool,
    /// What it lacks, one clause each.
    pub missing: Vec<String>,
    /// Features.
    pub features: Vec<FeatureReport>,
    /// Longest side of an image, texels.
    pub max_image_px: u32,
    /// Largest storage buffer, bytes.
    pub max_storage_bytes: u32,
    /// Nanoseconds of a timestamp's tick.
    pub timestamp_period_ns: f32,
}

/// Every Vulkan device of this machine, best first, and whether the validation layer is installed.
///
/// # Errors
/// [`Error::NoDevice`] where there is no Vulkan loader or no driver.
pub fn device_reports() -> Result<(Vec<DeviceReport>, bool)> {
    let entry = load_entry()?;
    let (instance, _) = make_instance(&entry, false)?;
    let reports: Vec<_> =
        devices_by_preference(&instance).into_iter().map(|device| report(&instance, device)).collect();
    let validation = has_validation_layer(&entry);
    // SAFETY: nothing else was made from the instance.
    unsafe { instance.destroy_instance(None) };
    if reports.is_empty() {
        return Err(no_driver());
    }
    Ok((reports, validation))
}

fn report(instance: &ash::Instance, device: vk::PhysicalDevice) -> DeviceReport {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the handle came from this instance, which is of version 1.3.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    let properties = properties.properties;
    let text = |text: Result<&CStr, std::ffi::FromBytesUntilNulError>| {
        text.map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
    };
    let mut missing = host::missing_requirements(instance, device);
    if queue_family(instance, device).is_none() {
        missing.push("a queue for graphics and compute with timestamps".to_owned());
    }
    let has = |feature: &str| !missing.iter().any(|lack| lack == feature || lack.starts_with("Vulkan 1.3"));
    let required = |name: &'static str, needed_for: &'static str| FeatureReport {
        name,
        present: has(name),
        needed_for,
        required: true,
    };
    let version = properties.api_version;
    DeviceReport {
        name: text(properties.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        api_version: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        device_type: match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
            vk::PhysicalDeviceType::CPU => "software",
            _ => "other",
        },
        usable: missing.is_empty(),
        features: vec![
            required("dynamicRendering", "every raster pass"),
            required("synchronization2", "barriers and timestamps"),
            required("shaderDemoteToHelperInvocation", "alpha masks"),
        ],
        missing,
        max_image_px: properties.limits.max_image_dimension2_d,
        max_storage_bytes: properties.limits.max_storage_buffer_range,
        timestamp_period_ns: properties.limits.timestamp_period,
    }
}
