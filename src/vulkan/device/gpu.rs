//! The GPUs of this machine: what they are, and whether they will do. `choice.rs` says which one to take.

use std::ffi::CStr;

use ash::{khr, vk};

use super::choice::{pick, GpuChoice};
use super::features::{missing_features, Extras};
use super::instance::Instance;
use crate::vulkan::error::{api, Result};

/// What sort of device a GPU is, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum GpuKind {
    /// A graphics card.
    Discrete,
    /// A GPU that shares memory with the CPU.
    Integrated,
    /// A GPU of a virtual machine.
    Virtual,
    /// A software renderer.
    Cpu,
    /// Something else.
    Other,
}

impl GpuKind {
    /// A lower-case word, as in JSON output.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Cpu => "cpu",
            Self::Other => "other",
        }
    }

    fn new(kind: vk::PhysicalDeviceType) -> Self {
        match kind {
            vk::PhysicalDeviceType::DISCRETE_GPU => Self::Discrete,
            vk::PhysicalDeviceType::INTEGRATED_GPU => Self::Integrated,
            vk::PhysicalDeviceType::VIRTUAL_GPU => Self::Virtual,
            vk::PhysicalDeviceType::CPU => Self::Cpu,
            _ => Self::Other,
        }
    }
}

/// One GPU.
#[derive(Debug, Clone)]
pub struct GpuInfo {
    /// Position in the list, for [`GpuChoice::Index`].
    pub index: usize,
    /// Name given by the driver.
    pub name: String,
    /// What sort of device it is.
    pub kind: GpuKind,
    /// What tells it from others of its name, the same after a restart: 32 hex digits in groups, as `VkPhysicalDeviceIDProperties` has them.
    pub uuid: String,
    /// Name of the driver, such as `llvmpipe`.
    pub driver: String,
    /// Version text of the driver.
    pub driver_info: String,
    /// Vulkan version as `major.minor.patch`.
    pub api_version: String,
    /// PCI vendor id.
    pub vendor_id: u32,
    /// PCI device id.
    pub device_id: u32,
    /// Invocations per subgroup: of a [`Context`](crate::vulkan::Context)'s, those that it asks for.
    pub subgroup_size: u32,
    /// Fewest and most invocations per subgroup that compute pipelines may ask for; both are `subgroup_size` where they may not.
    pub subgroup_sizes: [u32; 2],
    /// Why it cannot be used; empty if it can.
    pub unusable: Vec<String>,
}

/// A physical device with all that a context needs to know of it.
pub(crate) struct Gpu {
    pub(crate) handle: vk::PhysicalDevice,
    pub(crate) info: GpuInfo,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) queue_family: u32,
    pub(crate) timestamp_bits: u32,
    pub(crate) extras: Extras,
    /// Most subgroups of a workgroup that asks for their size; 0 where none may.
    pub(crate) most_subgroups: u32,
}

/// Lists the GPUs of this machine, usable or not.
///
/// # Errors
/// No loader or no driver.
pub fn list_gpus() -> Result<Vec<GpuInfo>> {
    let instance = Instance::new(false, &[])?;
    let gpus = inspect_all(&instance, None)?;
    Ok(gpus.into_iter().map(|gpu| gpu.info).collect())
}

/// Chooses a GPU that can present to `surface`, if one is given.
pub(crate) fn choose(instance: &Instance, surface: Option<vk::SurfaceKHR>, choice: &GpuChoice) -> Result<Gpu> {
    let mut gpus = inspect_all(instance, surface)?;
    let infos: Vec<GpuInfo> = gpus.iter().map(|gpu| gpu.info.clone()).collect();
    let index = pick(&infos, choice)?;
    Ok(gpus.swap_remove(index))
}

fn inspect_all(instance: &Instance, surface: Option<vk::SurfaceKHR>) -> Result<Vec<Gpu>> {
    let devices = instance.physical_devices()?;
    let numbered = devices.into_iter().enumerate();
    numbered.map(|(index, handle)| inspect(instance, surface, index, handle)).collect()
}

fn inspect(instance: &Instance, surface: Option<vk::SurfaceKHR>, index: usize, handle: vk::PhysicalDevice) -> Result<Gpu> {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
    let mut id = vk::PhysicalDeviceIDProperties::default();
    let mut all = vk::PhysicalDeviceProperties2::default()
        .push_next(&mut driver)
        .push_next(&mut subgroup)
        .push_next(&mut sizes)
        .push_next(&mut id);
    // SAFETY: the device belongs to this instance; structures of versions that it lacks are left as they are.
    unsafe { instance.handle.get_physical_device_properties2(handle, &mut all) };
    let properties = all.properties;
    let mut unusable = Vec::new();
    if properties.api_version < vk::API_VERSION_1_3 {
        unusable.push(format!("Vulkan 1.3 (it has {})", version(properties.api_version)));
    } else {
        unusable.extend(missing_features(instance, handle));
    }
    let mut wanted = vec![khr::push_descriptor::NAME];
    wanted.extend(surface.map(|_| khr::swapchain::NAME));
    unusable.extend(missing_extensions(instance, handle, &wanted)?);
    let family = find_queue_family(instance, handle, surface)?;
    if family.is_none() {
        unusable.push("a queue for graphics, compute and this window".to_owned());
    }
    let (queue_family, timestamp_bits) = family.unwrap_or_default();
    let extras = Extras::query(instance, handle);
    let chooses = extras.subgroup_size_control && sizes.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
    let most_subgroups = if chooses { sizes.max_compute_workgroup_subgroups } else { 0 };
    let size = subgroup.subgroup_size;
    let info = GpuInfo {
        index,
        name: text(properties.device_name_as_c_str().ok()),
        kind: GpuKind::new(properties.device_type),
        uuid: uuid(id.device_uuid),
        driver: text(driver.driver_name_as_c_str().ok()),
        driver_info: text(driver.driver_info_as_c_str().ok()),
        api_version: version(properties.api_version),
        vendor_id: properties.vendor_id,
        device_id: properties.device_id,
        subgroup_size: size,
        subgroup_sizes: if chooses { [sizes.min_subgroup_size, sizes.max_subgroup_size] } else { [size; 2] },
        unusable,
    };
    Ok(Gpu { handle, info, limits: properties.limits, queue_family, timestamp_bits, extras, most_subgroups })
}

fn missing_extensions(instance: &Instance, handle: vk::PhysicalDevice, wanted: &[&CStr]) -> Result<Vec<String>> {
    // SAFETY: the device belongs to this instance.
    let present = unsafe { instance.handle.enumerate_device_extension_properties(handle) }
        .map_err(api("vkEnumerateDeviceExtensionProperties"))?;
    let has = |name: &CStr| present.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    Ok(wanted.iter().filter(|name| !has(name)).map(|name| text(Some(name))).collect())
}

/// The first family with graphics and compute (and the surface), and its valid timestamp bits.
fn find_queue_family(
    instance: &Instance,
    handle: vk::PhysicalDevice,
    surface: Option<vk::SurfaceKHR>,
) -> Result<Option<(u32, u32)>> {
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the device belongs to this instance.
    let families = unsafe { instance.handle.get_physical_device_queue_family_properties(handle) };
    for (index, family) in (0u32..).zip(families) {
        if family.queue_flags.contains(wanted) && presents(instance, handle, index, surface)? {
            return Ok(Some((index, family.timestamp_valid_bits)));
        }
    }
    Ok(None)
}

fn presents(instance: &Instance, handle: vk::PhysicalDevice, family: u32, surface: Option<vk::SurfaceKHR>) -> Result<bool> {
    let Some(surface) = surface else {
        return Ok(true);
    };
    let functions = khr::surface::Instance::new(&instance.entry, &instance.handle);
    // SAFETY: device and surface belong to this instance, whose surface extension is enabled.
    unsafe { functions.get_physical_device_surface_support(handle, family, surface) }
        .map_err(api("vkGetPhysicalDeviceSurfaceSupportKHR"))
}

fn version(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}

fn text(name: Option<&CStr>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Hex digits in the usual groups of 8, 4, 4, 4 and 12.
fn uuid(bytes: [u8; 16]) -> String {
    let digits = format!("{:032x}", u128::from_be_bytes(bytes));
    [0..8, 8..12, 12..16, 16..20, 20..32].map(|group| &digits[group]).join("-")
}
