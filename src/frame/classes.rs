//! Classes of pixels: what a pixel shows decides which passes run there. The class is kept as a depth that passes test against: software
//! renderers skip pixels that fail the depth test, but run the bodies of conditions that are false. Shaders: `classify.frag`,
//! `classes.glsl`.

use super::fullscreen::Fullscreen;
use super::targets::DEPTH_FORMAT;
use crate::shaders;
use crate::vulkan::{vk, Commands, Context, DepthTest, Resource, Result, Shader};
use std::sync::Arc;

/// Bits of a class, as in `classes.glsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ClassBit {
    /// The sea lies in front of the ground.
    Sea,
    /// Clouds may lie in front of both.
    Clouds,
    /// There are several surfaces.
    Edge,
}

/// Classes that have a bit as a pass wants it.
const CLASSES: u32 = 4;

/// Constants of `fullscreen.vert`.
const BIT: u32 = 10;
const VALUE: u32 = 11;

/// Finds the class of each pixel, into a colour target of a format and a depth target.
pub(super) fn classify(context: &Arc<Context>, format: vk::Format) -> Result<Fullscreen> {
    let formats = [format];
    let mut description = Fullscreen::description(shaders::CLASSIFY_FRAG, &formats);
    description.depth_format = Some(DEPTH_FORMAT);
    description.depth = Some(DepthTest { compare: vk::CompareOp::ALWAYS, write: true });
    Fullscreen::described(context, "classify", &description)
}

/// A pass over the pixels whose class has a bit set, or not.
pub(super) struct ClassPass {
    pass: Fullscreen,
}

impl ClassPass {
    /// Builds the pipeline of a fragment shader that writes one colour target of a format, with its specialization constants.
    pub(super) fn new(
        context: &Arc<Context>,
        name: &str,
        (fragment, constants): (Shader<'_>, &[(u32, u32)]),
        format: vk::Format,
        (bit, value): (ClassBit, bool),
    ) -> Result<ClassPass> {
        let formats = [format];
        let constants = [constants, &[(BIT, bit as u32), (VALUE, u32::from(value))]].concat();
        let mut description = Fullscreen::description(fragment, &formats);
        description.specialization = &constants;
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare: vk::CompareOp::EQUAL, write: false });
        Ok(ClassPass { pass: Fullscreen::described(context, name, &description)? })
    }

    /// Draws it, while rendering with the classes as the depth target.
    pub(super) fn draw(&self, commands: &mut Commands, resources: &[(&str, Resource<'_>)]) -> Result<()> {
        self.pass.draw(commands, CLASSES, resources)
    }
}
