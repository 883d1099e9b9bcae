//! The Vulkan loader and instance, with or without validation. Everything else hangs below it.

use std::ffi::{c_char, CStr};
use std::sync::Arc;

use ash::{ext, vk};

use super::messages::MessageLog;
use crate::vulkan::error::{api, Result, VulkanError};

/// The validation layer, asked for by [`ContextOptions::validation`](crate::vulkan::ContextOptions).
const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Owns the instance; dropped last of all Vulkan objects.
pub(crate) struct Instance {
    pub(crate) entry: ash::Entry,
    pub(crate) handle: ash::Instance,
    /// Whether `VK_EXT_debug_utils` is enabled: names and labels.
    pub(crate) debug_utils: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    // The messenger points into it, so it must be declared (and dropped) after it.
    pub(crate) log: Arc<MessageLog>,
}

impl Instance {
    /// Loads Vulkan and creates an instance with the extensions that a window asks for.
    pub(crate) fn new(validation: bool, window_extensions: &[*const c_char]) -> Result<Self> {
        // SAFETY: the system's Vulkan loader is trusted to be one; nothing of it is used after the entry is dropped.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| VulkanError::NoLoader { reason: e.to_string() })?;
        if validation && !has_layer(&entry)? {
            return Err(VulkanError::MissingValidation);
        }
        let debug_utils = validation || has_extension(&entry, ext::debug_utils::NAME)?;
        for &name in window_extensions {
            // SAFETY: ash-window hands out static names.
            let name = unsafe { CStr::from_ptr(name) };
            if !has_extension(&entry, name)? {
                let extension = name.to_string_lossy().into_owned();
                return Err(VulkanError::MissingExtension { extension });
            }
        }
        let mut extensions = window_extensions.to_vec();
        if debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let log = Arc::new(MessageLog::default());
        let handle = create(&entry, validation, &extensions, &log)?;
        let mut instance = Self { entry, handle, debug_utils, messenger: None, log };
        if validation {
            instance.messenger = Some(instance.create_messenger()?);
        }
        Ok(instance)
    }

    /// All physical devices; none is the error `NoDriver`.
    pub(crate) fn physical_devices(&self) -> Result<Vec<vk::PhysicalDevice>> {
        // SAFETY: the instance is alive.
        let devices = unsafe { self.handle.enumerate_physical_devices() }.map_err(|result| match result {
            // What the loader returns when every driver has failed to start.
            vk::Result::ERROR_INITIALIZATION_FAILED => VulkanError::NoDriver,
            result => api("vkEnumeratePhysicalDevices")(result),
        })?;
        if devices.is_empty() {
            return Err(VulkanError::NoDriver);
        }
        Ok(devices)
    }

    fn create_messenger(&self) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
        let functions = ext::debug_utils::Instance::new(&self.entry, &self.handle);
        // SAFETY: the log outlives the messenger, see `drop`.
        let messenger = unsafe { functions.create_debug_utils_messenger(&self.log.messenger(), None) }
            .map_err(api("vkCreateDebugUtilsMessengerEXT"))?;
        Ok((functions, messenger))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: all children hold an `Arc` of this instance, so none is left; the log is dropped after this.
        unsafe {
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.handle.destroy_instance(None);
        }
    }
}

fn create(entry: &ash::Entry, validation: bool, extensions: &[*const c_char], log: &MessageLog) -> Result<ash::Instance> {
    let application =
        vk::ApplicationInfo::default().application_name(c"Terrane").engine_name(c"Terrane").api_version(vk::API_VERSION_1_3);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut messenger = log.messenger();
    let layers = [VALIDATION_LAYER.as_ptr()];
    let mut info = vk::InstanceCreateInfo::default().application_info(&application).enabled_extension_names(extensions);
    if validation {
        info = info.enabled_layer_names(&layers).push_next(&mut features).push_next(&mut messenger);
    }
    // SAFETY: everything the info points to outlives the call; the log outlives the instance.
    unsafe { entry.create_instance(&info, None) }.map_err(api("vkCreateInstance"))
}

fn has_layer(entry: &ash::Entry) -> Result<bool> {
    // SAFETY: the loader is alive.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.map_err(api("vkEnumerateInstanceLayerProperties"))?;
    Ok(layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)))
}

fn has_extension(entry: &ash::Entry, name: &CStr) -> Result<bool> {
    // SAFETY: the loader is alive.
    let extensions =
        unsafe { entry.enumerate_instance_extension_properties(None) }.map_err(api("vkEnumerateInstanceExtensionProperties"))?;
    Ok(extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name)))
}
