//! The features that Terrane needs of a GPU, and those that it uses where they exist.

use ash::vk;

use super::instance::Instance;

/// Optional features, enabled where they exist.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Extras {
    /// Anisotropic filtering.
    pub anisotropy: bool,
    /// 8-bit integers in storage buffers and arithmetic.
    pub int8: bool,
    /// 16-bit integers in storage buffers and arithmetic.
    pub int16: bool,
    /// `gl_DrawID`, `gl_BaseVertex` and `gl_BaseInstance`.
    pub draw_parameters: bool,
    /// More than one draw per indirect call.
    pub multi_draw_indirect: bool,
    /// The number of indirect draws read from a buffer.
    pub draw_indirect_count: bool,
    /// A subgroup size chosen per pipeline, and full subgroups.
    pub subgroup_size_control: bool,
}

/// The feature structures of Vulkan 1.0 to 1.3, linked when they are passed on.
#[derive(Default)]
pub(crate) struct Features {
    pub(crate) v10: vk::PhysicalDeviceFeatures,
    pub(crate) v11: vk::PhysicalDeviceVulkan11Features<'static>,
    pub(crate) v12: vk::PhysicalDeviceVulkan12Features<'static>,
    pub(crate) v13: vk::PhysicalDeviceVulkan13Features<'static>,
}

impl Features {
    fn query(instance: &Instance, gpu: vk::PhysicalDevice) -> Self {
        let mut features = Self::default();
        let (mut v11, mut v12, mut v13) = (features.v11, features.v12, features.v13);
        let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut v11).push_next(&mut v12).push_next(&mut v13);
        // SAFETY: the device belongs to this instance; structures it does not know stay zero.
        unsafe { instance.handle.get_physical_device_features2(gpu, &mut all) };
        features.v10 = all.features;
        let null = std::ptr::null_mut();
        // The chain ran through locals that are moved now: cut the links.
        (v11.p_next, v12.p_next, v13.p_next) = (null, null, null);
        Self { v11, v12, v13, ..features }
    }

    /// What to enable: all that is required and the extras that exist.
    pub(crate) fn enabled(extras: &Extras) -> Self {
        let mut features = Self::default();
        for required in REQUIRED {
            *(required.field)(&mut features) = vk::TRUE;
        }
        let set = |on: bool| if on { vk::TRUE } else { vk::FALSE };
        features.v10.sampler_anisotropy = set(extras.anisotropy);
        features.v10.multi_draw_indirect = set(extras.multi_draw_indirect);
        features.v10.shader_int16 = set(extras.int16);
        features.v11.storage_buffer16_bit_access = set(extras.int16);
        features.v11.shader_draw_parameters = set(extras.draw_parameters);
        features.v12.shader_int8 = set(extras.int8);
        features.v12.storage_buffer8_bit_access = set(extras.int8);
        features.v12.draw_indirect_count = set(extras.draw_indirect_count);
        features.v13.subgroup_size_control = set(extras.subgroup_size_control);
        features.v13.compute_full_subgroups = set(extras.subgroup_size_control);
        features
    }
}

impl Extras {
    pub(crate) fn query(instance: &Instance, gpu: vk::PhysicalDevice) -> Self {
        let Features { v10, v11, v12, v13 } = Features::query(instance, gpu);
        let all = |flags: &[vk::Bool32]| flags.iter().all(|flag| *flag == vk::TRUE);
        Self {
            anisotropy: all(&[v10.sampler_anisotropy]),
            int8: all(&[v12.shader_int8, v12.storage_buffer8_bit_access]),
            int16: all(&[v10.shader_int16, v11.storage_buffer16_bit_access]),
            draw_parameters: all(&[v11.shader_draw_parameters]),
            multi_draw_indirect: all(&[v10.multi_draw_indirect]),
            draw_indirect_count: all(&[v12.draw_indirect_count]),
            subgroup_size_control: all(&[v13.subgroup_size_control, v13.compute_full_subgroups]),
        }
    }
}

struct Required {
    name: &'static str,
    field: fn(&mut Features) -> &mut vk::Bool32,
}

/// Without these a GPU is not usable.
const REQUIRED: &[Required] = &[
    Required { name: "fullDrawIndexUint32", field: |f| &mut f.v10.full_draw_index_uint32 },
    Required { name: "fillModeNonSolid", field: |f| &mut f.v10.fill_mode_non_solid },
    Required { name: "bufferDeviceAddress", field: |f| &mut f.v12.buffer_device_address },
    Required { name: "scalarBlockLayout", field: |f| &mut f.v12.scalar_block_layout },
    Required { name: "dynamicRendering", field: |f| &mut f.v13.dynamic_rendering },
    Required { name: "synchronization2", field: |f| &mut f.v13.synchronization2 },
    Required { name: "maintenance4", field: |f| &mut f.v13.maintenance4 },
];

/// Names of the required features that a device lacks. The device must have Vulkan 1.3.
pub(crate) fn missing_features(instance: &Instance, gpu: vk::PhysicalDevice) -> Vec<String> {
    let mut features = Features::query(instance, gpu);
    let lacking = REQUIRED.iter().filter(|r| *(r.field)(&mut features) != vk::TRUE);
    lacking.map(|required| required.name.to_owned()).collect()
}
