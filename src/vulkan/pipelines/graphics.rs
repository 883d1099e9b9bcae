//! Graphics pipelines for dynamic rendering; viewport and scissor are set by `begin_rendering`.

use std::sync::Arc;

use ash::vk;

use super::layout::{Bindable, RawPipeline, RawPipelineRef, Specialization};
use super::reflection::Reflection;
use super::shader::{current_words, Module, Shader};
use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::Context;

/// How fragments are combined with what is there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Blend {
    /// They replace it.
    #[default]
    Replace,
    /// By the fragment's alpha.
    Alpha,
    /// By an alpha that the colour was already multiplied by.
    Premultiplied,
    /// They are added.
    Add,
}

/// How depth is tested and written. Depth is reversed: nearer is greater, so the usual comparison is `GREATER_OR_EQUAL`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthTest {
    /// What passes.
    pub compare: vk::CompareOp,
    /// Whether what passes is written.
    pub write: bool,
}

/// What graphics pipeline to create.
#[derive(Debug, Clone, Copy)]
pub struct GraphicsDescription<'a> {
    /// Vertex shader; it pulls its vertices.
    pub vertex: Shader<'a>,
    /// Fragment shader; none to write depth only.
    pub fragment: Option<Shader<'a>>,
    /// Formats of the colour targets.
    pub color_formats: &'a [vk::Format],
    /// Format of the depth target.
    pub depth_format: Option<vk::Format>,
    /// The depth test; none passes always and writes nothing.
    pub depth: Option<DepthTest>,
    /// Filled, or lines; `fillModeNonSolid` is enabled.
    pub polygon: vk::PolygonMode,
    /// Faces not drawn.
    pub cull: vk::CullModeFlags,
    /// Winding of front faces, in framebuffer coordinates (y down).
    pub front: vk::FrontFace,
    /// The same for all colour targets.
    pub blend: Blend,
    /// Samples of the targets.
    pub samples: u32,
    /// Triangle list unless set.
    pub topology: vk::PrimitiveTopology,
    /// Specialization constants (id, value) of both shaders.
    pub specialization: &'a [(u32, u32)],
}

impl<'a> GraphicsDescription<'a> {
    /// Filled triangles of both windings, with no depth test and no blending.
    pub fn new(vertex: Shader<'a>, fragment: Option<Shader<'a>>, color_formats: &'a [vk::Format]) -> Self {
        Self {
            vertex,
            fragment,
            color_formats,
            depth_format: None,
            depth: None,
            polygon: vk::PolygonMode::FILL,
            cull: vk::CullModeFlags::NONE,
            front: vk::FrontFace::COUNTER_CLOCKWISE,
            blend: Blend::Replace,
            samples: 1,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            specialization: &[],
        }
    }
}

/// Vertex and fragment shaders with their fixed state.
pub struct GraphicsPipeline {
    raw: Arc<RawPipeline>,
}

impl GraphicsPipeline {
    /// Creates a pipeline.
    ///
    /// # Errors
    /// Shaders of the wrong stage, or whose bindings contradict each other, or that the device cannot run.
    pub fn new(context: &Arc<Context>, name: &str, description: &GraphicsDescription<'_>) -> Result<Self> {
        let mut built = vec![(description.vertex, vk::ShaderStageFlags::VERTEX)];
        let fragment = description.fragment.map(|s| (s, vk::ShaderStageFlags::FRAGMENT));
        built.extend(fragment);
        let constants = description.specialization;
        let words: Vec<_> = built.iter().map(|(s, _)| current_words(context, s, constants)).collect::<Result<_>>()?;
        let shaders: Vec<_> =
            built.iter().zip(&words).map(|((s, stage), words)| (Shader { name: s.name, words }, *stage)).collect();
        let reflections: Vec<Reflection> =
            shaders.iter().map(|(shader, stage)| reflect(shader, *stage, description.specialization)).collect::<Result<_>>()?;
        let point = vk::PipelineBindPoint::GRAPHICS;
        let mut raw = RawPipeline::new(context, name, point, &reflections)?;
        raw.handle = create(context, description, &shaders, raw.layout)?;
        context.set_name(raw.handle, name);
        Ok(Self { raw: Arc::new(raw) })
    }
}

impl Bindable for GraphicsPipeline {
    fn raw(&self) -> RawPipelineRef<'_> {
        RawPipelineRef(&self.raw)
    }
}

fn reflect(shader: &Shader<'_>, stage: vk::ShaderStageFlags, specialization: &[(u32, u32)]) -> Result<Reflection> {
    let reflection = Reflection::new(shader, specialization)?;
    if reflection.stage == stage {
        return Ok(reflection);
    }
    let problem = format!("it is for {:?}, not {stage:?}", reflection.stage);
    Err(VulkanError::Shader { shader: shader.name.to_owned(), problem })
}

fn create(
    context: &Context,
    description: &GraphicsDescription<'_>,
    shaders: &[(Shader<'_>, vk::ShaderStageFlags)],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline> {
    let specialization = Specialization::new(description.specialization);
    let specialization = specialization.info();
    let modules: Vec<Module<'_>> = shaders.iter().map(|(s, _)| Module::new(context, s)).collect::<Result<_>>()?;
    let stage = |(module, (_, stage)): (&Module<'_>, &(Shader<'_>, vk::ShaderStageFlags))| {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(*stage)
            .module(module.handle)
            .name(c"main")
            .specialization_info(&specialization)
    };
    let stages: Vec<_> = modules.iter().zip(shaders).map(stage).collect();
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(description.topology);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = rasterization(description);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(description.samples));
    let depth = depth_state(description.depth);
    let attachments = vec![blend_state(description.blend); description.color_formats.len()];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(description.color_formats)
        .depth_attachment_format(description.depth_format.unwrap_or_default());
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    let cache = vk::PipelineCache::null();
    // SAFETY: modules, layout and all states outlive the call.
    let created = unsafe { context.device().create_graphics_pipelines(cache, &[info], None) };
    let created = created.map_err(|(_, result)| api("vkCreateGraphicsPipelines")(result))?;
    Ok(created[0])
}

fn rasterization(description: &GraphicsDescription<'_>) -> vk::PipelineRasterizationStateCreateInfo<'static> {
    vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(description.polygon)
        .cull_mode(description.cull)
        .front_face(description.front)
        .line_width(1.0)
}

fn depth_state(test: Option<DepthTest>) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    let state = vk::PipelineDepthStencilStateCreateInfo::default();
    match test {
        None => state,
        Some(DepthTest { compare, write }) => state.depth_test_enable(true).depth_write_enable(write).depth_compare_op(compare),
    }
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    use vk::BlendFactor as F;
    let (source, target) = match blend {
        Blend::Replace => (F::ONE, F::ZERO),
        Blend::Alpha => (F::SRC_ALPHA, F::ONE_MINUS_SRC_ALPHA),
        Blend::Premultiplied => (F::ONE, F::ONE_MINUS_SRC_ALPHA),
        Blend::Add => (F::ONE, F::ONE),
    };
    // Alpha is covered, never multiplied by itself.
    let alpha = if blend == Blend::Alpha { F::ONE } else { source };
    vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(blend != Blend::Replace)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(target)
        .src_alpha_blend_factor(alpha)
        .dst_alpha_blend_factor(target)
}
