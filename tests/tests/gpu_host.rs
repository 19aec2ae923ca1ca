//! A host that brings its own instance, device, queue, command buffer and image: the engine draws into
//! it, leaves the image in the state that was declared, and the validation layer has nothing to say.

use ash::{ext, vk};
use glam::DVec3;
use macula::content::{Content, GpuContent};
use macula::headless::FrameInput;
use macula::host::{self, Context, ContextParts, TargetImage};
use macula::renderer::Renderer;
use macula::scene::Scene;
use macula::settings::{Method, RenderSettings};
use macula_tests::scenes::{add, at, light, one, quad, sun, unlit, white};
use macula_tests::{INSTALL_LAYER, ahead, gpu, kfr, render, settings};
use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const LAYER: &std::ffi::CStr = c"VK_LAYER_KHRONOS_validation";
const SIZE: [u32; 2] = [96, 64];

static MESSAGES: AtomicU64 = AtomicU64::new(0);

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _user: *mut c_void,
) -> vk::Bool32 {
    MESSAGES.fetch_add(1, Ordering::Relaxed);
    // SAFETY: the layer's data is valid during the call.
    if let Some(message) = unsafe { (*data).message_as_c_str() } {
        eprintln!("validation: {}", message.to_string_lossy());
    }
    vk::FALSE
}

/// What a host owns.
struct Host {
    instance: ash::Instance,
    debug: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    physical_device: vk::PhysicalDevice,
    device: ash::Device,
    queue: vk::Queue,
    family: u32,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    _entry: ash::Entry,
}

impl Host {
    fn new() -> Self {
        // SAFETY: plain Vulkan set-up; every structure outlives its call.
        unsafe {
            let entry = ash::Entry::load().expect("a Vulkan loader");
            let layers = entry.enumerate_instance_layer_properties().unwrap();
            let has_layer = layers.iter().any(|of| of.layer_name_as_c_str() == Ok(LAYER));
            assert!(has_layer, "{INSTALL_LAYER}");
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let layers = [LAYER.as_ptr()];
            let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
            let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut validation = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut validation);
            let instance = entry.create_instance(&info, None).unwrap();
            let debug = ext::debug_utils::Instance::new(&entry, &instance);
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::ERROR
                        | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
                )
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(on_message));
            let messenger = debug.create_debug_utils_messenger(&info, None).unwrap();
            let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            let (physical_device, family) = instance
                .enumerate_physical_devices()
                .unwrap()
                .into_iter()
                .filter(|device| host::missing_requirements(&instance, *device).is_empty())
                .find_map(|device| {
                    let families = instance.get_physical_device_queue_family_properties(device);
                    let family = families.iter().position(|of| of.queue_flags.contains(wanted))?;
                    Some((device, u32::try_from(family).unwrap()))
                })
                .expect("a device that meets the requirements");
            let queues =
                [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
            let mut features = host::required_features();
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
            let device = instance.create_device(physical_device, &info, None).unwrap();
            let queue = device.get_device_queue(family, 0);
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None).unwrap();
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).unwrap()[0];
            Self {
                instance,
                debug,
                messenger,
                physical_device,
                device,
                queue,
                family,
                pool,
                commands,
                _entry: entry,
            }
        }
    }

    fn context(&self) -> Arc<Context> {
        let parts = ContextParts {
            instance: self.instance.clone(),
            physical_device: self.physical_device,
            device: self.device.clone(),
            queue: self.queue,
            queue_family: self.family,
            debug_utils: true,
            cache_file: None,
        };
        // SAFETY: the handles belong together and live as long as `self`, which outlives the context.
        unsafe { Context::from_host(parts) }.unwrap()
    }

    fn memory(&self, needs: vk::MemoryRequirements, flags: vk::MemoryPropertyFlags) -> vk::DeviceMemory {
        // SAFETY: both handles are alive.
        unsafe {
            let types = self.instance.get_physical_device_memory_properties(self.physical_device);
            let index = (0..types.memory_type_count)
                .find(|index| {
                    needs.memory_type_bits >> index & 1 == 1
                        && types.memory_types[*index as usize].property_flags.contains(flags)
                })
                .unwrap();
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
            self.device.allocate_memory(&info, None).unwrap()
        }
    }

    fn image(&self, format: vk::Format) -> Picture {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC);
        let bytes = u64::from(4 * SIZE[0] * SIZE[1]);
        // SAFETY: plain Vulkan set-up; freed in `destroy`.
        unsafe {
            let image = self.device.create_image(&info, None).unwrap();
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.memory(needs, vk::MemoryPropertyFlags::empty());
            self.device.bind_image_memory(image, memory, 0).unwrap();
            let view = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(WHOLE);
            let view = self.device.create_image_view(&view, None).unwrap();
            let info = vk::BufferCreateInfo::default().size(bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
            let buffer = self.device.create_buffer(&info, None).unwrap();
            let needs = self.device.get_buffer_memory_requirements(buffer);
            let flags = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let buffer_memory = self.memory(needs, flags);
            self.device.bind_buffer_memory(buffer, buffer_memory, 0).unwrap();
            Picture { image, view, memory, buffer, buffer_memory, bytes }
        }
    }

    fn destroy(&self, picture: &Picture) {
        // SAFETY: nothing runs any more.
        unsafe {
            self.device.destroy_buffer(picture.buffer, None);
            self.device.free_memory(picture.buffer_memory, None);
            self.device.destroy_image_view(picture.view, None);
            self.device.destroy_image(picture.image, None);
            self.device.free_memory(picture.memory, None);
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: everything made from the device is gone; the layer reports what is not.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            self.debug.destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
    }
}

const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// The host's image and a buffer to read it back.
struct Picture {
    image: vk::Image,
    view: vk::ImageView,
    memory: vk::DeviceMemory,
    buffer: vk::Buffer,
    buffer_memory: vk::DeviceMemory,
    bytes: u64,
}

/// Records a frame between commands of the host, submits it, and reads the picture back. The host
/// clears the image first where the engine is to find it as an attachment.
fn draw(
    host: &Host,
    renderer: &mut Renderer,
    input: &FrameInput,
    picture: &Picture,
    entry_layout: vk::ImageLayout,
) -> Vec<u8> {
    let target = TargetImage {
        image: picture.image,
        view: picture.view,
        entry_layout,
        exit_layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
    };
    let device = &host.device;
    // SAFETY: the frame before was waited for; the host's objects are alive.
    unsafe {
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        device.begin_command_buffer(host.commands, &begin).unwrap();
        if entry_layout != vk::ImageLayout::UNDEFINED {
            let barrier = [vk::ImageMemoryBarrier2::default()
                .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                .dst_stage_mask(vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT)
                .dst_access_mask(vk::AccessFlags2::COLOR_ATTACHMENT_WRITE)
                .old_layout(vk::ImageLayout::UNDEFINED)
                .new_layout(entry_layout)
                .image(picture.image)
                .subresource_range(WHOLE)];
            device.cmd_pipeline_barrier2(
                host.commands,
                &vk::DependencyInfo::default().image_memory_barriers(&barrier),
            );
        }
        let slot = renderer.record_frame(host.commands, input, &target);
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::COPY)
            .dst_access_mask(vk::AccessFlags2::TRANSFER_READ)];
        device.cmd_pipeline_barrier2(host.commands, &vk::DependencyInfo::default().memory_barriers(&barrier));
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 })];
        device.cmd_copy_image_to_buffer(
            host.commands,
            picture.image,
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            picture.buffer,
            &region,
        );
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::COPY)
            .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        device.cmd_pipeline_barrier2(host.commands, &vk::DependencyInfo::default().memory_barriers(&barrier));
        device.end_command_buffer(host.commands).unwrap();
        let list = [host.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&list)];
        device.queue_submit(host.queue, &submit, vk::Fence::null()).unwrap();
        device.queue_wait_idle(host.queue).unwrap();
        let stats = renderer.read_stats(slot).unwrap();
        assert_eq!((stats.non_finite, stats.holes), (Some(0), Some(0)));
        let flags = vk::MemoryMapFlags::empty();
        let mapped = device.map_memory(picture.buffer_memory, 0, picture.bytes, flags).unwrap();
        let bytes = std::slice::from_raw_parts(mapped.cast::<u8>(), picture.bytes as usize).to_vec();
        device.unmap_memory(picture.buffer_memory);
        bytes
    }
}

fn scene() -> Scene {
    let mut scene = one(quad(2.0, 2.0), at(0.0, 0.0, -2.0), white(0.3, 0.5));
    add(&mut scene, quad(0.3, 0.2), at(0.3, 0.2, -1.5), unlit(0.9, 0.2, 0.1));
    scene.lights.push(sun(4.0, DVec3::new(0.3, -0.2, -1.0)));
    let kind = macula::scene::LightKind::Point { range: 4.0 };
    scene.lights.push(light(1.0, DVec3::new(-0.5, 0.3, -1.2), DVec3::NEG_Z, kind));
    scene
}

#[test]
fn a_host_brings_everything_and_gets_the_headless_picture() {
    let scene = scene();
    let expected: Vec<(RenderSettings, Vec<u8>)> = [Method::Full, kfr(1.8, 4.0)]
        .map(|method| {
            let settings = settings(SIZE, 70.0, method);
            let frame = render(&gpu(), &scene, None, &settings, &ahead(&settings));
            (settings, frame.rgba8)
        })
        .into();
    let host = Host::new();
    {
        let context = host.context();
        let content = Content::Scene { scene: &scene, environment: None };
        let content = GpuContent::upload(&context, &content).unwrap();
        for (format, entry_layout) in [
            (vk::Format::R8G8B8A8_UNORM, vk::ImageLayout::UNDEFINED),
            (vk::Format::R8G8B8A8_SRGB, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL),
            (vk::Format::B8G8R8A8_UNORM, vk::ImageLayout::UNDEFINED),
        ] {
            let picture = host.image(format);
            for (settings, expected) in &expected {
                let mut renderer = Renderer::new(&context, &content, settings, format).unwrap();
                for _ in 0..3 {
                    let mut bytes = draw(&host, &mut renderer, &ahead(settings), &picture, entry_layout);
                    if format == vk::Format::B8G8R8A8_UNORM {
                        bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
                    }
                    let worst = bytes.iter().zip(expected).map(|(a, b)| a.abs_diff(*b)).max();
                    assert!(worst <= Some(1), "{format:?}: off by {worst:?}/255");
                }
            }
            host.destroy(&picture);
        }
    }
    // Also reports what the engine has not destroyed.
    drop(host);
    assert_eq!(MESSAGES.load(Ordering::Relaxed), 0, "messages of the validation layer, see above");
}
