//! Images, with layers and mip levels, and views of parts of them.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::vulkan::device::memory::{self, Memory};
use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::Context;

/// What image to create.
#[derive(Debug, Clone, Copy)]
pub struct ImageDescription<'a> {
    /// Name, for messages.
    pub name: &'a str,
    /// Width of mip level 0 in texels.
    pub width: u32,
    /// Height of mip level 0 in texels.
    pub height: u32,
    /// Array layers, 1 or more, checked against the device's limit.
    pub layers: u32,
    /// Whether shaders see an array (`sampler2DArray`) even if there is one layer; more layers always make one.
    pub array: bool,
    /// Mip levels, 1 or more.
    pub mips: u32,
    /// Samples a texel, 1 or what [`Context::most_samples`] allows.
    pub samples: u32,
    /// Texel format.
    pub format: vk::Format,
    /// Uses, to which copying from and to is added.
    pub usage: vk::ImageUsageFlags,
}

impl<'a> ImageDescription<'a> {
    /// A plain 2D image with one layer and one level.
    pub fn new(name: &'a str, size: (u32, u32), format: vk::Format, usage: vk::ImageUsageFlags) -> Self {
        let (width, height) = size;
        Self { name, width, height, layers: 1, array: false, mips: 1, samples: 1, format, usage }
    }
}

/// A rectangle of one layer and mip level of an image, in texels of that level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageRegion {
    /// Array layer.
    pub layer: u32,
    /// Mip level.
    pub mip: u32,
    /// Column and row of the first texel.
    pub origin: (u32, u32),
    /// Width and height, 1 or more.
    pub size: (u32, u32),
}

impl ImageRegion {
    /// Whether two regions of one image share a texel.
    pub(crate) fn overlaps(&self, other: &ImageRegion) -> bool {
        let meet = |a: u32, a_length: u32, b: u32, b_length: u32| a < b + b_length && b < a + a_length;
        (self.layer, self.mip) == (other.layer, other.mip)
            && meet(self.origin.0, self.size.0, other.origin.0, other.size.0)
            && meet(self.origin.1, self.size.1, other.origin.1, other.size.1)
    }
}

/// A 2D image or array of them. Commands keep the images alive that they use.
pub struct Image {
    view: ImageView,
    mips: u32,
    layers: u32,
}

/// A view of some layers and levels of an image; clones share it.
#[derive(Clone)]
pub struct ImageView {
    pub(crate) raw: Arc<RawView>,
}

pub(crate) struct RawView {
    pub(crate) image: Arc<RawImage>,
    pub(crate) handle: vk::ImageView,
    pub(crate) range: vk::ImageSubresourceRange,
}

/// A Vulkan image; without an allocation it belongs to a swapchain.
pub(crate) struct RawImage {
    context: Arc<Context>,
    pub(crate) name: String,
    pub(crate) handle: vk::Image,
    pub(crate) format: vk::Format,
    pub(crate) extent: vk::Extent2D,
    allocation: Option<Allocation>,
    owned: bool,
}

impl Image {
    /// Creates an image, its contents and layout undefined.
    ///
    /// # Errors
    /// Out of memory, or a size or format that the device does not support.
    pub fn new(context: &Arc<Context>, description: &ImageDescription<'_>) -> Result<Self> {
        check_limits(context, description)?;
        let ImageDescription { name, width, height, layers, mips, format, .. } = *description;
        let transfer = vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(mips)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::from_raw(description.samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(description.usage | transfer);
        // SAFETY: the device is alive, the sizes are within its limits.
        let handle = unsafe { context.device().create_image(&info, None) }.map_err(api("vkCreateImage"))?;
        context.set_name(handle, name);
        let mut raw = RawImage {
            context: context.clone(),
            name: name.to_owned(),
            handle,
            format,
            extent: vk::Extent2D { width, height },
            allocation: None,
            owned: true,
        };
        raw.bind()?;
        let array = description.array || layers > 1;
        let view = ImageView::new(Arc::new(raw), 0..layers, 0..mips, array)?;
        Ok(Self { view, mips, layers })
    }

    /// The view of all layers and levels.
    pub fn view(&self) -> &ImageView {
        &self.view
    }

    /// A 2D view of one layer and level, as a rendering target or storage image.
    ///
    /// # Errors
    /// A layer or level that does not exist.
    pub fn layer_view(&self, layer: u32, mip: u32) -> Result<ImageView> {
        self.check(layer, mip)?;
        ImageView::new(self.raw().clone(), layer..layer + 1, mip..mip + 1, false)
    }

    /// Width and height of mip level 0.
    pub fn size(&self) -> (u32, u32) {
        self.view.size()
    }

    /// Width and height of mip level `mip`, at least 1.
    pub fn mip_size(&self, mip: u32) -> (u32, u32) {
        let vk::Extent2D { width, height } = self.raw().extent;
        let shrink = |length: u32| length.checked_shr(mip).unwrap_or(0).max(1);
        (shrink(width), shrink(height))
    }

    /// Texel format.
    pub fn format(&self) -> vk::Format {
        self.raw().format
    }

    /// Number of array layers.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// Number of mip levels.
    pub fn mips(&self) -> u32 {
        self.mips
    }

    /// Name, as in messages.
    pub fn name(&self) -> &str {
        &self.raw().name
    }

    /// Bytes of device memory that it takes, all layers and levels.
    pub fn allocated_bytes(&self) -> u64 {
        self.raw().allocation.as_ref().map_or(0, Allocation::size)
    }

    /// All texels of a layer and level.
    ///
    /// # Errors
    /// A layer or level that does not exist.
    pub fn whole(&self, layer: u32, mip: u32) -> Result<ImageRegion> {
        self.check(layer, mip)?;
        Ok(ImageRegion { layer, mip, origin: (0, 0), size: self.mip_size(mip) })
    }

    /// Bytes of a region, tightly packed. Fails unless the region lies in the image.
    pub(crate) fn region_bytes(&self, region: &ImageRegion) -> Result<u64> {
        let ImageRegion { layer, mip, origin, size } = *region;
        self.check(layer, mip)?;
        let (width, height) = self.mip_size(mip);
        let fits = |first: u32, length: u32, end: u32| length > 0 && first.checked_add(length).is_some_and(|last| last <= end);
        if !fits(origin.0, size.0, width) || !fits(origin.1, size.1, height) {
            let problem = format!("{size:?} texels at {origin:?} do not lie within level {mip}, {width} × {height} texels");
            return Err(VulkanError::Access { what: self.name().to_owned(), problem });
        }
        Ok(self.layer_bytes(mip)? / (u64::from(width) * u64::from(height)) * u64::from(size.0) * u64::from(size.1))
    }

    /// Bytes of one layer of a mip level, tightly packed.
    pub(crate) fn layer_bytes(&self, mip: u32) -> Result<u64> {
        let texel = texel_bytes(self.format()).ok_or_else(|| {
            let problem = format!("format {:?} is not supported here", self.format());
            VulkanError::Access { what: self.name().to_owned(), problem }
        })?;
        let (width, height) = self.mip_size(mip);
        Ok(texel * u64::from(width) * u64::from(height))
    }

    /// Another handle to the same image.
    pub(crate) fn share(&self) -> Self {
        Self { view: self.view.clone(), mips: self.mips, layers: self.layers }
    }

    pub(crate) fn raw(&self) -> &Arc<RawImage> {
        &self.view.raw.image
    }

    /// Fails unless the layer and level exist.
    pub(crate) fn check(&self, layer: u32, mip: u32) -> Result<()> {
        if layer < self.layers && mip < self.mips {
            return Ok(());
        }
        let problem =
            format!("layer {layer}, level {mip} does not exist: there are {} layers and {} levels", self.layers, self.mips);
        Err(VulkanError::Access { what: self.name().to_owned(), problem })
    }
}

impl ImageView {
    pub(crate) fn new(
        image: Arc<RawImage>,
        layers: std::ops::Range<u32>,
        mips: std::ops::Range<u32>,
        array: bool,
    ) -> Result<Self> {
        let range = vk::ImageSubresourceRange {
            aspect_mask: aspect(image.format),
            base_mip_level: mips.start,
            level_count: mips.end - mips.start,
            base_array_layer: layers.start,
            layer_count: layers.end - layers.start,
        };
        let kind = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info =
            vk::ImageViewCreateInfo::default().image(image.handle).view_type(kind).format(image.format).subresource_range(range);
        // SAFETY: the image is alive and has these layers and levels.
        let handle = unsafe { image.context.device().create_image_view(&info, None) }.map_err(api("vkCreateImageView"))?;
        image.context.set_name(handle, &image.name);
        Ok(Self { raw: Arc::new(RawView { image, handle, range }) })
    }

    /// Width and height of the first level of the view.
    pub fn size(&self) -> (u32, u32) {
        let vk::Extent2D { width, height } = self.raw.image.extent;
        let mip = self.raw.range.base_mip_level;
        let shrink = |length: u32| length.checked_shr(mip).unwrap_or(0).max(1);
        (shrink(width), shrink(height))
    }

    /// Texel format.
    pub fn format(&self) -> vk::Format {
        self.raw.image.format
    }
}

impl RawImage {
    /// An image that a swapchain owns.
    pub(crate) fn borrowed(
        context: &Arc<Context>,
        name: String,
        handle: vk::Image,
        format: vk::Format,
        extent: vk::Extent2D,
    ) -> Self {
        let context = context.clone();
        context.set_name(handle, &name);
        Self { context, name, handle, format, extent, allocation: None, owned: false }
    }

    fn bind(&mut self) -> Result<()> {
        let device = self.context.device();
        // SAFETY: the image is alive and has no memory yet.
        let needs = unsafe { device.get_image_memory_requirements(self.handle) };
        let allocation = memory::allocate(&self.context, &self.name, needs, Memory::Device, false)?;
        // SAFETY: the allocation fits the requirements and belongs to this image alone.
        let bound = unsafe { device.bind_image_memory(self.handle, allocation.memory(), allocation.offset()) };
        self.allocation = Some(allocation);
        bound.map_err(api("vkBindImageMemory"))
    }
}

impl Drop for RawImage {
    fn drop(&mut self) {
        if !self.owned {
            return;
        }
        // SAFETY: views and commands hold an `Arc` of this until they are done.
        unsafe { self.context.device().destroy_image(self.handle, None) };
        if let Some(allocation) = self.allocation.take() {
            memory::free(&self.context, allocation);
        }
    }
}

impl Drop for RawView {
    fn drop(&mut self) {
        // SAFETY: commands hold an `Arc` of this until they are done; the image is still alive.
        unsafe { self.image.context.device().destroy_image_view(self.handle, None) };
    }
}

/// The aspects of a format: depth for depth formats, else colour. Stencil is not used.
pub(crate) fn aspect(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT | vk::Format::D16_UNORM => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

/// Bytes of one texel; none for formats that nothing here copies.
fn texel_bytes(format: vk::Format) -> Option<u64> {
    use vk::Format as F;
    Some(match format {
        F::R8_UNORM | F::R8_UINT | F::R8_SNORM => 1,
        F::R8G8_UNORM | F::R8G8_SNORM | F::R16_UNORM | F::R16_SNORM | F::R16_SFLOAT => 2,
        F::R16_UINT | F::D16_UNORM => 2,
        F::R8G8B8A8_UNORM | F::R8G8B8A8_SRGB | F::R8G8B8A8_SNORM | F::B8G8R8A8_UNORM => 4,
        F::R16G16_UNORM | F::R16G16_SNORM | F::R16G16_SFLOAT => 4,
        F::R32_SFLOAT | F::R32_UINT | F::R32_SINT | F::D32_SFLOAT => 4,
        F::R16G16B16A16_SFLOAT | F::R16G16B16A16_UNORM | F::R16G16B16A16_SNORM => 8,
        F::R32G32_SFLOAT | F::R32G32_UINT => 8,
        F::R32G32B32A32_SFLOAT | F::R32G32B32A32_UINT => 16,
        _ => return None,
    })
}

/// Past these limits some drivers create an image all the same, and return wrong texels.
fn check_limits(context: &Context, description: &ImageDescription<'_>) -> Result<()> {
    let limits = context.limits();
    let fits = |length: u32| (1..=limits.max_image_dimension2_d).contains(&length);
    let (width, height) = (description.width, description.height);
    let levels = 32 - width.max(height).leading_zeros();
    let problem = if !fits(width) || !fits(height) {
        let limit = limits.max_image_dimension2_d;
        format!("{width} × {height} texels; sides must be 1 to {limit}")
    } else if !(1..=limits.max_image_array_layers).contains(&description.layers) {
        let limit = limits.max_image_array_layers;
        format!("{} layers; there can be 1 to {limit}", description.layers)
    } else if !(1..=levels).contains(&description.mips) {
        format!("{} mip levels; there can be 1 to {levels}", description.mips)
    } else if !description.samples.is_power_of_two() || description.samples > context.most_samples() {
        format!("{} samples a texel; there can be 1, 2, 4 and so on up to {}", description.samples, context.most_samples())
    } else {
        return Ok(());
    };
    Err(VulkanError::Access { what: description.name.to_owned(), problem })
}
