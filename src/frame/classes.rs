//! Classes of pixels: what a pixel shows decides which passes run there. The class is kept as a depth that passes test against: software
//! renderers skip pixels that fail the depth test, but run the bodies of conditions that are false. Shaders: `classify.frag`,
//! `classes.glsl`.

use super::fullscreen::Fullscreen;
use super::targets::DEPTH_FORMAT;
use crate::vulkan::{vk, Access, ColorTarget, Commands, Context, DepthTarget, DepthTest, ImageView, Resource, Result, Shader};
use std::sync::Arc;

/// Bits of a class, as in `classes.glsl`.
const EDGE_BIT: u32 = 0;
const SEA_BIT: u32 = 1;
const CLOUDS_BIT: u32 = 2;

/// Constant of `fullscreen.vert`.
const BIT: u32 = 10;

/// Pixels that a pass draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Class {
    /// All of them, and notes their classes as the fragment's depth.
    Noted,
    /// All of them.
    Any,
    /// Those that show several surfaces.
    Edge,
    /// Those where the sea lies in front of the ground.
    Sea,
    /// Those where no cloud lies in front of ground and sea.
    Clear,
    /// Those where one may.
    Cloudy,
}

impl Class {
    /// The bit looked at, what passes, and how many triangles that takes.
    fn test(self) -> (Option<u32>, vk::CompareOp, u32) {
        match self {
            Class::Noted | Class::Any => (None, vk::CompareOp::ALWAYS, 1),
            Class::Edge => (Some(EDGE_BIT), vk::CompareOp::EQUAL, 4),
            Class::Sea => (Some(SEA_BIT), vk::CompareOp::EQUAL, 4),
            Class::Clear => (Some(CLOUDS_BIT), vk::CompareOp::GREATER, 1),
            Class::Cloudy => (Some(CLOUDS_BIT), vk::CompareOp::LESS, 1),
        }
    }
}

/// A pass over the pixels of a class.
pub(super) struct ClassPass {
    pass: Fullscreen,
    triangles: u32,
}

impl ClassPass {
    /// Builds the pipeline of a fragment shader that writes one colour target of a format; `constant` is the value of its first
    /// specialization constant, where it has one.
    pub(super) fn new(
        context: &Arc<Context>,
        name: &str,
        (fragment, constant): (Shader<'_>, bool),
        format: vk::Format,
        class: Class,
    ) -> Result<ClassPass> {
        let (formats, (bit, compare, triangles)) = ([format], class.test());
        let constants: Vec<_> = [(0, u32::from(constant))].into_iter().chain(bit.map(|bit| (BIT, bit))).collect();
        let mut description = Fullscreen::description(fragment, &formats);
        description.specialization = &constants;
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare, write: class == Class::Noted });
        Ok(ClassPass { pass: Fullscreen::described(context, name, &description)?, triangles })
    }

    /// Draws it, while rendering to [`begin`]'s targets.
    pub(super) fn draw(&self, commands: &mut Commands, resources: &[(&str, Resource<'_>)]) -> Result<()> {
        self.pass.draw(commands, self.triangles, resources)
    }
}

/// Begins rendering to a colour target anew, by classes, which are found anew or were found before. The caller has made ready what is read.
pub(super) fn begin(commands: &mut Commands, color: &ImageView, classes: &ImageView, found: bool) -> Result<()> {
    let depth = if found { classes.to(Access::DepthTarget) } else { classes.anew(Access::DepthTarget) };
    commands.ready(&[color.anew(Access::ColorTarget), depth])?;
    let color = ColorTarget { view: color, clear: Some([0.0; 4]) };
    commands.begin_rendering(&[color], Some(DepthTarget { view: classes, clear: (!found).then_some(0.0) }))
}
