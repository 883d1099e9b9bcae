//! Frames on their way to a window: two in flight, recreated whenever the window changes.

use std::sync::Arc;
use std::time::Duration;

use ash::{khr, vk};

use super::commands::timestamps::Timestamps;
use super::commands::{Commands, Submission};
use super::device::surface::Surface;
use super::error::{api, Result, VulkanError};
use super::resources::image::{ImageView, RawImage};
use super::Context;

/// How long to wait for the window to give an image back: some windows give none while they are hidden. Past it: no frame.
const ACQUIRE_LIMIT: Duration = Duration::from_millis(250);

/// Frames that may be on the GPU while the next is recorded.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// The images of a window and the frames drawn to them.
pub struct Swapchain {
    context: Arc<Context>,
    functions: khr::swapchain::Device,
    handle: vk::SwapchainKHR,
    format: vk::Format,
    images: Vec<Target>,
    slots: [Slot; FRAMES_IN_FLIGHT],
    next: usize,
    /// Wanted by the window; (0, 0) while it is minimized.
    size: (u32, u32),
    mailbox: bool,
    outdated: bool,
    /// Whether what was made last is called suboptimal, though made anew for that reason: some windows always are.
    tolerated: bool,
    // Dropped after the swapchain.
    surface: Surface,
}

struct Target {
    view: ImageView,
    /// Signalled when drawing is done. One per image: presentation holds it until the image comes back.
    drawn: Semaphore,
}

struct Slot {
    commands: Option<Commands>,
    acquired: Semaphore,
}

/// A frame being recorded; give it back with [`Swapchain::present`].
pub struct Frame {
    /// Begun; record the frame here.
    pub commands: Commands,
    /// The image to draw to, its contents undefined; leave it as [`Access::Present`](super::Access::Present).
    pub target: ImageView,
    /// Times of the frame that used these commands before, if there was one.
    pub timestamps: Option<Timestamps>,
    image: u32,
    slot: usize,
}

impl Frame {
    /// Which of the [`FRAMES_IN_FLIGHT`] it is: the frame that used the same commands before has the same number.
    pub fn slot(&self) -> usize {
        self.slot
    }
}

impl Swapchain {
    /// Creates a swapchain for a surface of the context's window, `size` being the window's in pixels. With `mailbox`
    /// frames are not held back to the screen's rate, where the driver can do that.
    ///
    /// # Errors
    /// Out of memory, or a surface without a format of 8-bit RGBA or BGRA.
    pub fn new(context: &Arc<Context>, surface: Surface, size: (u32, u32), mailbox: bool) -> Result<Self> {
        let format = choose_format(context, &surface)?;
        let instance = &context.instance().handle;
        let slot = |name| -> Result<Slot> {
            let commands = Some(Commands::new(context, name)?);
            Ok(Slot { commands, acquired: Semaphore::new(context)? })
        };
        let mut swapchain = Self {
            context: context.clone(),
            functions: khr::swapchain::Device::new(instance, context.device()),
            handle: vk::SwapchainKHR::null(),
            format,
            images: Vec::new(),
            slots: [slot("frame 0")?, slot("frame 1")?],
            next: 0,
            size,
            mailbox,
            outdated: true,
            tolerated: false,
            surface,
        };
        swapchain.recreate()?;
        Ok(swapchain)
    }

    /// Format of the images: UNORM, so shaders encode sRGB themselves.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Width and height of the images; (0, 0) while there are none.
    pub fn size(&self) -> (u32, u32) {
        self.images.first().map_or((0, 0), |target| target.view.size())
    }

    /// Tells the window's new size; the next frame has it.
    pub fn resize(&mut self, width: u32, height: u32) {
        if (width, height) != self.size {
            self.outdate();
        }
        self.size = (width, height);
    }

    /// Begins a frame, after the one before the last is done. None while there is nothing to draw to: the window is
    /// minimized, hidden or has just changed; try again at its next redraw.
    ///
    /// # Errors
    /// Device loss, out of memory, or a window that is gone.
    pub fn acquire(&mut self) -> Result<Option<Frame>> {
        let slot = self.next;
        let Some(commands) = &mut self.slots[slot].commands else {
            return Err(self.not_presented());
        };
        // Also makes the semaphore `acquired` free again.
        let timestamps = if commands.is_pending() { Some(commands.wait()?) } else { None };
        if self.outdated {
            self.recreate()?;
        }
        if self.handle == vk::SwapchainKHR::null() {
            return Ok(None);
        }
        let Some(image) = self.acquire_image(slot)? else {
            return Ok(None);
        };
        let Some(mut commands) = self.slots[slot].commands.take() else {
            return Err(self.not_presented());
        };
        commands.begin()?;
        let target = self.images[image as usize].view.clone();
        self.next = (slot + 1) % FRAMES_IN_FLIGHT;
        Ok(Some(Frame { commands, target, timestamps, image, slot }))
    }

    /// Submits a frame and shows it.
    ///
    /// # Errors
    /// Device loss, or a window that is gone.
    pub fn present(&mut self, frame: Frame) -> Result<()> {
        let _span = tracing::trace_span!("present").entered();
        let Frame { mut commands, image, slot, .. } = frame;
        // Other stages, culling above all, need not wait for the screen.
        let stages = vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT | vk::PipelineStageFlags2::ALL_TRANSFER;
        let drawn = self.images[image as usize].drawn.handle;
        let submission = Submission { wait: Some((self.slots[slot].acquired.handle, stages)), signal: Some(drawn) };
        commands.submit(&submission)?;
        self.slots[slot].commands = Some(commands);
        let (waits, swapchains, indices) = ([drawn], [self.handle], [image]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&swapchains).image_indices(&indices);
        let presented = {
            let queue = self.context.queue();
            // SAFETY: the image was acquired, the queue is locked, the semaphore will be signalled.
            unsafe { self.functions.queue_present(*queue, &info) }
        };
        match presented {
            Ok(suboptimal) => self.improve(suboptimal),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.outdate(),
            Err(result) => return Err(api("vkQueuePresentKHR")(result)),
        }
        // Tracy counts frames by this field.
        tracing::trace!(tracy.frame_mark = true);
        Ok(())
    }

    fn acquire_image(&mut self, slot: usize) -> Result<Option<u32>> {
        let _span = tracing::trace_span!("acquire").entered();
        let semaphore = self.slots[slot].acquired.handle;
        let limit = ACQUIRE_LIMIT.as_nanos() as u64;
        // SAFETY: the swapchain is alive; nothing waits for the semaphore any more.
        let acquired = unsafe { self.functions.acquire_next_image(self.handle, limit, semaphore, vk::Fence::null()) };
        match acquired {
            Ok((image, suboptimal)) => {
                self.improve(suboptimal);
                Ok(Some(image))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.outdate();
                Ok(None)
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(None),
            Err(result) => Err(api("vkAcquireNextImageKHR")(result)),
        }
    }

    /// Makes the images anew before the next frame.
    fn outdate(&mut self) {
        (self.outdated, self.tolerated) = (true, false);
    }

    /// Makes images that are said to be suboptimal anew, once: if that does not help, they will do.
    fn improve(&mut self, suboptimal: bool) {
        if suboptimal && !self.tolerated {
            (self.outdated, self.tolerated) = (true, true);
        }
    }

    /// Makes images of the window's present size, or none if it has no area.
    fn recreate(&mut self) -> Result<()> {
        self.context.wait_idle()?;
        let gpu = self.context.gpu().handle;
        // SAFETY: device and surface belong to the same instance.
        let can = unsafe { self.surface.functions.get_physical_device_surface_capabilities(gpu, self.surface.handle) }
            .map_err(api("vkGetPhysicalDeviceSurfaceCapabilitiesKHR"))?;
        let extent = choose_extent(&can, self.size);
        self.images.clear();
        let old = std::mem::replace(&mut self.handle, vk::SwapchainKHR::null());
        let created = if extent.width > 0 && extent.height > 0 { self.create(&can, extent, old) } else { Ok(()) };
        // SAFETY: the device is idle and the views of its images are gone; a null handle is ignored.
        unsafe { self.functions.destroy_swapchain(old, None) };
        created?;
        self.outdated = self.handle == vk::SwapchainKHR::null();
        Ok(())
    }

    fn create(&mut self, can: &vk::SurfaceCapabilitiesKHR, extent: vk::Extent2D, old: vk::SwapchainKHR) -> Result<()> {
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        // Copying to the images puts a picture into them that is drawn already. Every driver known allows it, though none must.
        let copy = vk::ImageUsageFlags::TRANSFER_DST;
        if !can.supported_usage_flags.contains(copy) {
            let problem = "its images cannot be copied to; another driver or window system may allow that".to_owned();
            return Err(VulkanError::Access { what: "the window".to_owned(), problem });
        }
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface.handle)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(self.format)
            .image_color_space(vk::ColorSpaceKHR::SRGB_NONLINEAR)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | copy)
            .pre_transform(can.current_transform)
            .composite_alpha(choose_alpha(can))
            .present_mode(self.present_mode()?)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: surface and old swapchain are alive, and the values within the surface's capabilities.
        self.handle = unsafe { self.functions.create_swapchain(&info, None) }.map_err(api("vkCreateSwapchainKHR"))?;
        // SAFETY: the swapchain is alive.
        let images = unsafe { self.functions.get_swapchain_images(self.handle) }.map_err(api("vkGetSwapchainImagesKHR"))?;
        for (index, image) in images.into_iter().enumerate() {
            let name = format!("swapchain {index}");
            let raw = RawImage::borrowed(&self.context, name, image, self.format, extent);
            let view = ImageView::new(Arc::new(raw), 0..1, 0..1, false)?;
            self.images.push(Target { view, drawn: Semaphore::new(&self.context)? });
        }
        Ok(())
    }

    fn present_mode(&self) -> Result<vk::PresentModeKHR> {
        let gpu = self.context.gpu().handle;
        // SAFETY: device and surface belong to the same instance.
        let modes = unsafe { self.surface.functions.get_physical_device_surface_present_modes(gpu, self.surface.handle) }
            .map_err(api("vkGetPhysicalDeviceSurfacePresentModesKHR"))?;
        let mailbox = self.mailbox && modes.contains(&vk::PresentModeKHR::MAILBOX);
        // FIFO exists everywhere.
        Ok(if mailbox { vk::PresentModeKHR::MAILBOX } else { vk::PresentModeKHR::FIFO })
    }

    fn not_presented(&self) -> VulkanError {
        VulkanError::Commands {
            commands: format!("frame {}", self.next),
            problem: "an acquired frame was dropped, not presented".to_owned(),
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        let _ = self.context.wait_idle();
        self.images.clear();
        // SAFETY: the device is idle; a null handle is ignored.
        unsafe { self.functions.destroy_swapchain(self.handle, None) };
    }
}

/// A binary semaphore.
struct Semaphore {
    context: Arc<Context>,
    handle: vk::Semaphore,
}

impl Semaphore {
    fn new(context: &Arc<Context>) -> Result<Self> {
        let info = vk::SemaphoreCreateInfo::default();
        // SAFETY: the device is alive.
        let handle = unsafe { context.device().create_semaphore(&info, None) }.map_err(api("vkCreateSemaphore"))?;
        Ok(Self { context: context.clone(), handle })
    }
}

impl Drop for Semaphore {
    fn drop(&mut self) {
        // SAFETY: the swapchain waits for the device before it drops its semaphores.
        unsafe { self.context.device().destroy_semaphore(self.handle, None) };
    }
}

fn choose_format(context: &Context, surface: &Surface) -> Result<vk::Format> {
    let gpu = context.gpu().handle;
    // SAFETY: device and surface belong to the same instance.
    let formats = unsafe { surface.functions.get_physical_device_surface_formats(gpu, surface.handle) }
        .map_err(api("vkGetPhysicalDeviceSurfaceFormatsKHR"))?;
    let wanted = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
    let srgb = vk::ColorSpaceKHR::SRGB_NONLINEAR;
    let found = wanted.into_iter().find(|want| formats.iter().any(|f| f.format == *want && f.color_space == srgb));
    found.ok_or_else(|| VulkanError::Access {
        what: "window".to_owned(),
        problem: "it has no format of 8-bit RGBA or BGRA".to_owned(),
    })
}

fn choose_extent(can: &vk::SurfaceCapabilitiesKHR, size: (u32, u32)) -> vk::Extent2D {
    // All ones: the swapchain decides the window's size.
    if can.current_extent.width != u32::MAX {
        return can.current_extent;
    }
    if size.0 == 0 || size.1 == 0 {
        return vk::Extent2D::default();
    }
    let (least, most) = (can.min_image_extent, can.max_image_extent);
    vk::Extent2D { width: size.0.clamp(least.width, most.width), height: size.1.clamp(least.height, most.height) }
}

fn choose_alpha(can: &vk::SurfaceCapabilitiesKHR) -> vk::CompositeAlphaFlagsKHR {
    let wanted = vk::CompositeAlphaFlagsKHR::OPAQUE;
    if can.supported_composite_alpha.contains(wanted) {
        return wanted;
    }
    vk::CompositeAlphaFlagsKHR::INHERIT
}
