//! The device that everything is created on: instance, GPU, queue and memory.

use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::choice::GpuChoice;
use super::features::{Extras, Features};
use super::gpu::{choose, Gpu, GpuInfo, GpuKind};
use super::instance::Instance;
use super::memory::allocation_error;
use super::messages::{MessageLog, ValidationMessage};
use super::surface::{Surface, Window};
use crate::vulkan::error::{api, Result, VulkanError};

/// How to create a [`Context`].
#[derive(Debug, Clone, Default)]
pub struct ContextOptions {
    /// Which GPU to use.
    pub gpu: GpuChoice,
    /// Whether to load the validation layer, with synchronization validation, and collect its messages.
    pub validation: bool,
    /// Samples a pixel for the ground's edges: 1, 2, 4 or 8, or fewer where the device has no more. `None` is 4, and 1
    /// on software renderers, which pay for every sample.
    pub samples: Option<u32>,
    /// Invocations per subgroup of compute pipelines, a power of two within [`GpuInfo::subgroup_sizes`]; the device's usual if `None`.
    pub subgroup_size: Option<u32>,
}

/// Samples a pixel, unless told otherwise.
const DEFAULT_SAMPLES: u32 = 4;

/// Shaders that take the place of those that the program was built with: SPIR-V by file name, such as `select.comp`.
#[cfg(feature = "hot-reload")]
pub type Replacements = std::collections::BTreeMap<String, Arc<[u32]>>;

/// A Vulkan device with one queue; shared by everything that is created on it.
pub struct Context {
    samples: u32,
    // Dropped by hand, before the device.
    allocator: ManuallyDrop<Mutex<Allocator>>,
    /// Bytes of all buffers and images.
    pub(in crate::vulkan) allocated: AtomicU64,
    pub(in crate::vulkan) allocations: AtomicU64,
    push_descriptor: khr::push_descriptor::Device,
    debug: Option<ext::debug_utils::Device>,
    device: ash::Device,
    queue: Mutex<vk::Queue>,
    /// SPIR-V in place of what the program was built with, by the shader's name.
    #[cfg(feature = "hot-reload")]
    replaced: Mutex<Replacements>,
    gpu: Gpu,
    instance: Arc<Instance>,
}

impl Context {
    /// Creates a context without a window.
    ///
    /// # Errors
    /// No loader, no driver, no usable GPU, or no validation layer where one is asked for.
    pub fn new(options: &ContextOptions) -> Result<Arc<Self>> {
        let instance = Arc::new(Instance::new(options.validation, &[])?);
        Self::on_instance(instance, None, options)
    }

    /// Creates a context that can draw to `window`, and the window's surface.
    ///
    /// # Errors
    /// As [`Context::new`], and where the driver cannot draw to this kind of window.
    pub fn with_window<W: Window>(options: &ContextOptions, window: Arc<W>) -> Result<(Arc<Self>, Surface)> {
        let extensions = Surface::extensions(&*window)?;
        let instance = Arc::new(Instance::new(options.validation, extensions)?);
        let surface = Surface::new(instance.clone(), window)?;
        let context = Self::on_instance(instance, Some(surface.handle), options)?;
        Ok((context, surface))
    }

    fn on_instance(instance: Arc<Instance>, surface: Option<vk::SurfaceKHR>, options: &ContextOptions) -> Result<Arc<Self>> {
        let mut gpu = choose(&instance, surface, &options.gpu)?;
        if let Some(size) = options.subgroup_size {
            gpu.info.subgroup_size = subgroup_size(&gpu.info, size)?;
        }
        let device = create_device(&instance, &gpu, surface.is_some())?;
        let allocator = match create_allocator(&instance, &gpu, &device) {
            Ok(allocator) => allocator,
            Err(error) => {
                // SAFETY: nothing was created on the device yet.
                unsafe { device.destroy_device(None) };
                return Err(error);
            }
        };
        // SAFETY: the family was enabled with one queue.
        let queue = unsafe { device.get_device_queue(gpu.queue_family, 0) };
        let debug = instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.handle, &device));
        let usual = if gpu.info.kind == GpuKind::Cpu { 1 } else { DEFAULT_SAMPLES };
        let wanted = options.samples.unwrap_or(usual);
        let samples = wanted.min(most_samples(&gpu.limits));
        if samples < wanted {
            tracing::warn!(wanted, samples, "the device has fewer samples a pixel than asked for");
        }
        tracing::info!(gpu = %gpu.info.name, driver = %gpu.info.driver_info, "Vulkan device");
        Ok(Arc::new(Self {
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            allocated: AtomicU64::new(0),
            allocations: AtomicU64::new(0),
            push_descriptor: khr::push_descriptor::Device::new(&instance.handle, &device),
            debug,
            device,
            queue: Mutex::new(queue),
            #[cfg(feature = "hot-reload")]
            replaced: Mutex::default(),
            samples,
            gpu,
            instance,
        }))
    }

    /// The GPU and its driver.
    pub fn device_info(&self) -> &GpuInfo {
        &self.gpu.info
    }

    /// Bytes of all buffers and images on the device: patches, textures, look-up tables, targets.
    pub fn allocated_bytes(&self) -> u64 {
        self.allocated.load(Ordering::Relaxed)
    }

    /// Allocations on the device since it was opened.
    pub fn allocations(&self) -> u64 {
        self.allocations.load(Ordering::Relaxed)
    }

    /// Samples a pixel that pictures are drawn with.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Most samples that colour and depth targets can have.
    pub fn most_samples(&self) -> u32 {
        most_samples(&self.gpu.limits)
    }

    /// Lets pipelines that are created from now on have these shaders in place of those of their names. Returns those before.
    #[cfg(feature = "hot-reload")]
    pub fn replace_shaders(&self, shaders: Replacements) -> Replacements {
        std::mem::replace(&mut *self.replaced.lock().unwrap_or_else(PoisonError::into_inner), shaders)
    }

    /// What pipelines are to have in place of a shader.
    #[cfg(feature = "hot-reload")]
    pub(in crate::vulkan) fn replacement(&self, name: &str) -> Option<Arc<[u32]>> {
        self.replaced.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    /// The limits of the device.
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.gpu.limits
    }

    /// The optional features that are enabled.
    pub fn extras(&self) -> &Extras {
        &self.gpu.extras
    }

    /// A copy of the validation messages so far; always empty without validation.
    pub fn messages(&self) -> Vec<ValidationMessage> {
        self.instance.log.all()
    }

    /// The log of validation messages, which may outlive the context: destruction is validated too.
    pub fn message_log(&self) -> Arc<MessageLog> {
        self.instance.log.clone()
    }

    /// Waits until the device has nothing left to do.
    ///
    /// # Errors
    /// Device loss.
    pub fn wait_idle(&self) -> Result<()> {
        let _queue = self.queue();
        // SAFETY: the only queue is locked.
        unsafe { self.device.device_wait_idle() }.map_err(api("vkDeviceWaitIdle"))
    }

    pub(crate) fn device(&self) -> &ash::Device {
        &self.device
    }

    pub(crate) fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    pub(crate) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub(crate) fn push_descriptor(&self) -> &khr::push_descriptor::Device {
        &self.push_descriptor
    }

    pub(crate) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    /// The queue, locked: submission needs external synchronization.
    pub(crate) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Names an object for validation messages and debuggers.
    pub(crate) fn set_name(&self, handle: impl vk::Handle, name: &str) {
        let (Some(debug), Ok(name)) = (&self.debug, std::ffi::CString::new(name)) else {
            return;
        };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the object is alive and belongs to this device. A failure costs a name only.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: every object holds an `Arc` of this context, so none is left; the allocator is dropped only here.
        unsafe {
            let _ = self.device.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
        }
    }
}

fn create_device(instance: &Instance, gpu: &Gpu, window: bool) -> Result<ash::Device> {
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(gpu.queue_family).queue_priorities(&priorities)];
    let mut extensions = vec![khr::push_descriptor::NAME.as_ptr()];
    if window {
        extensions.push(khr::swapchain::NAME.as_ptr());
    }
    let Features { v10, mut v11, mut v12, mut v13 } = Features::enabled(&gpu.extras);
    let mut features =
        vk::PhysicalDeviceFeatures2::default().features(v10).push_next(&mut v11).push_next(&mut v12).push_next(&mut v13);
    let info =
        vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&extensions).push_next(&mut features);
    // SAFETY: the GPU was checked to have these extensions and features.
    unsafe { instance.handle.create_device(gpu.handle, &info, None) }.map_err(api("vkCreateDevice"))
}

fn create_allocator(instance: &Instance, gpu: &Gpu, device: &ash::Device) -> Result<Allocator> {
    Allocator::new(&AllocatorCreateDesc {
        instance: instance.handle.clone(),
        device: device.clone(),
        physical_device: gpu.handle,
        debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
        buffer_device_address: true,
        allocation_sizes: gpu_allocator::AllocationSizes::default(),
    })
    .map_err(|error| allocation_error("the allocator", 0, &error))
}

/// The size of subgroups that is asked for, if compute pipelines of the GPU can have it.
fn subgroup_size(gpu: &GpuInfo, wanted: u32) -> Result<u32> {
    let [least, most] = gpu.subgroup_sizes;
    if wanted.is_power_of_two() && (least..=most).contains(&wanted) {
        return Ok(wanted);
    }
    Err(VulkanError::SubgroupSize { gpu: gpu.name.clone(), wanted, least, most })
}

/// Most samples that colour and depth targets, drawn to and then sampled, can have.
fn most_samples(limits: &vk::PhysicalDeviceLimits) -> u32 {
    let both = limits.framebuffer_color_sample_counts
        & limits.framebuffer_depth_sample_counts
        & limits.sampled_image_color_sample_counts
        & limits.sampled_image_depth_sample_counts;
    1 << (u32::BITS - 1 - (both.as_raw() | 1).leading_zeros())
}
