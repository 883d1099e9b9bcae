//! The surface of a window.

use std::ffi::c_char;
use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};

use super::instance::Instance;
use crate::vulkan::error::{api, Result, VulkanError};

/// A window that a surface can be made for, such as one of winit.
pub trait Window: HasWindowHandle + HasDisplayHandle + Send + Sync + 'static {}

impl<W: HasWindowHandle + HasDisplayHandle + Send + Sync + 'static> Window for W {}

/// What a swapchain presents to. Keeps its window alive.
pub struct Surface {
    pub(crate) handle: vk::SurfaceKHR,
    pub(crate) functions: khr::surface::Instance,
    _window: Arc<dyn Window>,
    _instance: Arc<Instance>,
}

impl Surface {
    /// The instance extensions that surfaces for `window` need.
    pub(crate) fn extensions(window: &impl Window) -> Result<&'static [*const c_char]> {
        let display = window.display_handle().map_err(handle_error)?;
        ash_window::enumerate_required_extensions(display.as_raw()).map_err(api("enumerating the extensions for a window"))
    }

    pub(crate) fn new<W: Window>(instance: Arc<Instance>, window: Arc<W>) -> Result<Self> {
        let display = window.display_handle().map_err(handle_error)?.as_raw();
        let raw = window.window_handle().map_err(handle_error)?.as_raw();
        // SAFETY: the extensions for this display are enabled; the window is kept alive longer than the surface.
        let handle = unsafe { ash_window::create_surface(&instance.entry, &instance.handle, display, raw, None) }
            .map_err(api("creating a surface"))?;
        let functions = khr::surface::Instance::new(&instance.entry, &instance.handle);
        Ok(Self { handle, functions, _window: window, _instance: instance })
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: its swapchain, which owns it, is already destroyed.
        unsafe { self.functions.destroy_surface(self.handle, None) };
    }
}

fn handle_error(error: HandleError) -> VulkanError {
    VulkanError::Access { what: "window".to_owned(), problem: error.to_string() }
}
