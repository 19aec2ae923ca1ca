//! Buffers and images with mandatory names, and memory from gpu-allocator.

use super::context::Context;
use crate::error::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Device memory.
    Gpu,
    /// Mapped, written by the CPU.
    Upload,
    /// Mapped, read by the CPU.
    Readback,
}

impl Location {
    fn memory(self) -> MemoryLocation {
        match self {
            Self::Gpu => MemoryLocation::GpuOnly,
            Self::Upload => MemoryLocation::CpuToGpu,
            Self::Readback => MemoryLocation::GpuToCpu,
        }
    }
}

/// A buffer.
pub struct Buffer {
    pub(crate) buffer: vk::Buffer,
    pub(crate) size: u64,
    /// A view as texels of four floats, of buffers with that usage.
    pub(crate) texel_view: vk::BufferView,
    allocation: Option<Allocation>,
    name: String,
    context: Arc<Context>,
}

impl Buffer {
    /// Makes a buffer of at least one byte. Its contents are undefined.
    ///
    /// # Errors
    /// [`Error::Memory`] and [`Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: Location,
    ) -> Result<Self> {
        let size = size.max(16);
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is alive.
        let buffer = unsafe { context.device.create_buffer(&info, None) };
        let buffer = Context::check(buffer, || format!("making the buffer {name}"))?;
        // SAFETY: the buffer was just made.
        let requirements = unsafe { context.device.get_buffer_memory_requirements(buffer) };
        let mut made = Self {
            buffer,
            size,
            texel_view: vk::BufferView::null(),
            allocation: None,
            name: name.to_owned(),
            context: context.clone(),
        };
        let allocation = allocate(context, name, requirements, location.memory(), true)?;
        // SAFETY: the memory is of a type and size that the buffer asked for.
        let bound =
            unsafe { context.device.bind_buffer_memory(buffer, allocation.memory(), allocation.offset()) };
        made.allocation = Some(allocation);
        Context::check(bound, || format!("binding memory to the buffer {name}"))?;
        context.set_name(buffer, name);
        if usage.contains(vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER) {
            let info = vk::BufferViewCreateInfo::default()
                .buffer(buffer)
                .format(vk::Format::R32G32B32A32_SFLOAT)
                .range(vk::WHOLE_SIZE);
            // SAFETY: the buffer is alive and bound to memory.
            let view = unsafe { context.device.create_buffer_view(&info, None) };
            made.texel_view = Context::check(view, || format!("making a view of {name}"))?;
        }
        Ok(made)
    }

    /// Copies `data` to `offset` in a mapped buffer.
    ///
    /// # Panics
    /// If the buffer is not mapped or too small: the caller chose both.
    pub fn write<T: bytemuck::Pod>(&mut self, offset: usize, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        let Some(target) = mapped.and_then(|mapped| mapped.get_mut(offset..offset + bytes.len())) else {
            unreachable!("{}: {} bytes at {offset} do not fit a mapped buffer", self.name, bytes.len())
        };
        target.copy_from_slice(bytes);
    }

    /// The bytes of a mapped buffer.
    ///
    /// # Panics
    /// If the buffer is not mapped: the caller chose that.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        let Some(bytes) = self.allocation.as_ref().and_then(Allocation::mapped_slice) else {
            unreachable!("{} is not mapped", self.name)
        };
        &bytes[..usize::try_from(self.size).unwrap_or(usize::MAX).min(bytes.len())]
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: whoever recorded commands with this buffer waits for them before dropping it.
        unsafe {
            self.context.device.destroy_buffer_view(self.texel_view, None);
            self.context.device.destroy_buffer(self.buffer, None);
        }
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for an allocation that is not this allocator's.
            let _ = self.context.allocator().free(allocation);
        }
    }
}

/// What an image is.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc<'a> {
    /// Name for debuggers and messages.
    pub name: &'a str,
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Array layers.
    pub layers: u32,
    /// Mip levels.
    pub levels: u32,
    /// Format.
    pub format: vk::Format,
    /// Usage.
    pub usage: vk::ImageUsageFlags,
    /// Its view is an array even with one layer.
    pub array_view: bool,
}

/// A 2D image or array of images, with a view of all of it.
pub struct Image {
    pub(crate) image: vk::Image,
    pub(crate) view: vk::ImageView,
    /// One view for each layer, of images with several layers.
    pub(crate) layer_views: Vec<vk::ImageView>,
    pub(crate) format: vk::Format,
    pub(crate) size: [u32; 2],
    pub(crate) levels: u32,
    pub(crate) layers: u32,
    allocation: Option<Allocation>,
    context: Arc<Context>,
}

impl Image {
    /// Makes an image in layout UNDEFINED.
    ///
    /// # Errors
    /// [`Error::Setting`] beyond the device's largest image, [`Error::Memory`], [`Error::Vulkan`].
    pub fn new(context: &Arc<Context>, desc: &ImageDesc<'_>) -> Result<Self> {
        let limit = context.limits.max_image_dimension2_d;
        if desc.size.iter().any(|&side| side == 0 || side > limit) {
            let [width, height] = desc.size;
            return Err(Error::Setting(format!(
                "{} would be {width}x{height}; this device's images have 1 to {limit} texels a side",
                desc.name
            )));
        }
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.size[0], height: desc.size[1], depth: 1 })
            .mip_levels(desc.levels)
            .array_layers(desc.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        // SAFETY: the device is alive.
        let image = unsafe { context.device.create_image(&info, None) };
        let image = Context::check(image, || format!("making the image {}", desc.name))?;
        let mut made = Self {
            image,
            view: vk::ImageView::null(),
            layer_views: Vec::new(),
            format: desc.format,
            size: desc.size,
            levels: desc.levels,
            layers: desc.layers,
            allocation: None,
            context: context.clone(),
        };
        // SAFETY: the image was just made.
        let requirements = unsafe { context.device.get_image_memory_requirements(image) };
        let allocation = allocate(context, desc.name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory is of a type and size that the image asked for.
        let bound =
            unsafe { context.device.bind_image_memory(image, allocation.memory(), allocation.offset()) };
        made.allocation = Some(allocation);
        Context::check(bound, || format!("binding memory to the image {}", desc.name))?;
        context.set_name(image, desc.name);
        let array = desc.array_view || desc.layers > 1;
        made.view = made.make_view(desc.name, 0, desc.layers, array)?;
        if array {
            for layer in 0..desc.layers {
                let view = made.make_view(desc.name, layer, 1, false)?;
                made.layer_views.push(view);
            }
        }
        Ok(made)
    }

    fn make_view(&self, name: &str, first: u32, count: u32, array: bool) -> Result<vk::ImageView> {
        let kind = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let range = vk::ImageSubresourceRange {
            aspect_mask: self.aspect(),
            base_mip_level: 0,
            level_count: self.levels,
            base_array_layer: first,
            layer_count: count,
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.image)
            .view_type(kind)
            .format(self.format)
            .subresource_range(range);
        // SAFETY: the image is alive and has the layers and levels.
        let view = unsafe { self.context.device.create_image_view(&info, None) };
        let view = Context::check(view, || format!("making a view of {name}"))?;
        self.context.set_name(view, name);
        Ok(view)
    }

    pub(crate) fn aspect(&self) -> vk::ImageAspectFlags {
        if self.format == vk::Format::D32_SFLOAT {
            vk::ImageAspectFlags::DEPTH
        } else {
            vk::ImageAspectFlags::COLOR
        }
    }

    /// Every level and layer.
    pub(crate) fn whole(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspect(),
            base_mip_level: 0,
            level_count: self.levels,
            base_array_layer: 0,
            layer_count: self.layers,
        }
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: whoever recorded commands with this image waits for them before dropping it.
        unsafe {
            for view in self.layer_views.drain(..) {
                self.context.device.destroy_image_view(view, None);
            }
            self.context.device.destroy_image_view(self.view, None);
            self.context.device.destroy_image(self.image, None);
        }
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for an allocation that is not this allocator's.
            let _ = self.context.allocator().free(allocation);
        }
    }
}

fn allocate(
    context: &Context,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    let desc = AllocationCreateDesc {
        name,
        requirements,
        location,
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    context
        .allocator()
        .allocate(&desc)
        .map_err(|error| Error::Memory { what: name.to_owned(), cause: error.to_string() })
}

/// A sampler.
pub struct Sampler {
    pub(crate) sampler: vk::Sampler,
    context: Arc<Context>,
}

impl Sampler {
    /// Makes a sampler.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(context: &Arc<Context>, name: &str, info: &vk::SamplerCreateInfo<'_>) -> Result<Self> {
        // SAFETY: the device is alive.
        let sampler = unsafe { context.device.create_sampler(info, None) };
        let sampler = Context::check(sampler, || format!("making the sampler {name}"))?;
        context.set_name(sampler, name);
        Ok(Self { sampler, context: context.clone() })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: as for images.
        unsafe { self.context.device.destroy_sampler(self.sampler, None) };
    }
}
