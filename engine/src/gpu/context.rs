//! The device as the rest of the engine sees it, owned or borrowed from a host.

use super::owned::OwnedHandles;
use crate::error::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::CString;
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a context is made of.
pub struct ContextParts {
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device, with [`crate::host::required_features`] enabled.
    pub device: ash::Device,
    /// A queue that can do graphics and compute.
    pub queue: vk::Queue,
    /// Its family.
    pub queue_family: u32,
    /// `VK_EXT_debug_utils` is enabled on the instance.
    pub debug_utils: bool,
    /// Where the pipeline cache is kept; `None`: not on disk.
    pub cache_file: Option<PathBuf>,
}

/// A device, its allocator and its pipeline cache. Shared by everything that owns Vulkan objects.
pub struct Context {
    pub(crate) device: ash::Device,
    pub(crate) queue: vk::Queue,
    pub(crate) queue_family: u32,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) pipeline_cache: vk::PipelineCache,
    debug: Option<ash::ext::debug_utils::Device>,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    name: String,
    driver: String,
    cache_file: Option<PathBuf>,
    /// `None` where the host owns instance and device. Dropped last.
    owned: Option<OwnedHandles>,
}

impl Context {
    /// Wraps handles that the host owns.
    ///
    /// # Safety
    /// The handles must belong together, the device must have [`crate::host::required_features`]
    /// enabled, and all must outlive the context and everything made with it. The queue must not be
    /// used by another thread while something is uploaded or built. The command buffers and images
    /// that are later given to [`crate::renderer::Renderer::record_frame`] must be the device's, valid,
    /// and in the state that is declared for them; what a frame uses must live until it is finished.
    ///
    /// # Errors
    /// [`Error::Vulkan`] and [`Error::Memory`].
    pub unsafe fn from_host(parts: ContextParts) -> Result<Arc<Self>> {
        Self::build(parts, None)
    }

    pub(crate) fn build(parts: ContextParts, owned: Option<OwnedHandles>) -> Result<Arc<Self>> {
        let ContextParts { instance, physical_device, device, queue, queue_family, debug_utils, cache_file } =
            parts;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|error| Error::Memory { what: "the allocator".into(), cause: error.to_string() })?;
        let mut driver_properties = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver_properties);
        // SAFETY: both handles are alive, and the chain holds only structures of Vulkan 1.2.
        unsafe { instance.get_physical_device_properties2(physical_device, &mut properties) };
        let properties = properties.properties;
        let text = |characters: Option<&std::ffi::CStr>| {
            characters.map_or_else(String::new, |text| text.to_string_lossy().into_owned())
        };
        let driver = format!(
            "{} {}",
            text(driver_properties.driver_name_as_c_str().ok()),
            text(driver_properties.driver_info_as_c_str().ok())
        );
        let initial = cache_file.as_ref().and_then(|path| std::fs::read(path).ok()).unwrap_or_default();
        let pipeline_cache = make_cache(&device, &initial)?;
        let debug = debug_utils.then(|| ash::ext::debug_utils::Device::new(&instance, &device));
        Ok(Arc::new(Self {
            device,
            queue,
            queue_family,
            limits: properties.limits,
            pipeline_cache,
            debug,
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            name: text(properties.device_name_as_c_str().ok()),
            driver: driver.trim().to_owned(),
            cache_file,
            owned,
        }))
    }

    /// The device's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The driver's name and version.
    #[must_use]
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// Messages of the validation layer so far, or `None` where it is off.
    #[must_use]
    pub fn validation_messages(&self) -> Option<u64> {
        self.owned.as_ref()?.validation_messages()
    }

    /// Names an object for debuggers and validation messages.
    pub(crate) fn set_name<T: vk::Handle>(&self, handle: T, name: &str) {
        let (Some(debug), Ok(name)) = (&self.debug, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle belongs to this device, and names are set before the object is shared.
        // A failure would only cost the name.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    pub(crate) fn begin_label(&self, commands: vk::CommandBuffer, name: &std::ffi::CStr) {
        if let Some(debug) = &self.debug {
            let label = vk::DebugUtilsLabelEXT::default().label_name(name);
            // SAFETY: `commands` is being recorded.
            unsafe { debug.cmd_begin_debug_utils_label(commands, &label) };
        }
    }

    pub(crate) fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(debug) = &self.debug {
            // SAFETY: `commands` is being recorded, and a label has been begun in it.
            unsafe { debug.cmd_end_debug_utils_label(commands) };
        }
    }

    /// Bytes of GPU memory in use by buffers and images.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.allocator().generate_report().total_allocated_bytes
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        // A panic while the lock was held leaves the allocator's lists whole: it changes them last.
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Turns a Vulkan result into an error that says what was being done.
    pub(crate) fn check<T>(result: ash::prelude::VkResult<T>, what: impl FnOnce() -> String) -> Result<T> {
        result.map_err(|code| match code {
            vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost(what()),
            code => Error::Vulkan { what: what(), code },
        })
    }

    /// Writes the pipeline cache to its file. A cache that cannot be written is only slower next time.
    fn save_cache(&self) {
        let Some(path) = &self.cache_file else { return };
        // SAFETY: the cache is alive.
        let Ok(data) = (unsafe { self.device.get_pipeline_cache_data(self.pipeline_cache) }) else { return };
        if std::fs::read(path).is_ok_and(|old| old == data) {
            return;
        }
        if let Some(folder) = path.parent() {
            let _ = std::fs::create_dir_all(folder);
        }
        let _ = crate::io::image_file::write_atomically(path, |file| file.write_all(&data));
    }
}

fn make_cache(device: &ash::Device, initial: &[u8]) -> Result<vk::PipelineCache> {
    let info = vk::PipelineCacheCreateInfo::default().initial_data(initial);
    // SAFETY: the device is alive. The driver checks the data's header; a cache it does not know is
    // ignored by it.
    let cache = unsafe { device.create_pipeline_cache(&info, None) };
    Context::check(cache, || "making the pipeline cache".into())
}

impl Drop for Context {
    fn drop(&mut self) {
        self.save_cache();
        // SAFETY: every object that used the cache or the allocator held this context alive, so
        // none is left; the allocator frees its blocks before the device may go.
        unsafe {
            self.device.destroy_pipeline_cache(self.pipeline_cache, None);
            ManuallyDrop::drop(&mut self.allocator);
        }
    }
}
