//! Classes of pixels: what a pixel shows decides which passes run there. The class is kept as a depth that passes test against: software
//! renderers skip pixels that fail the depth test, but run the bodies of conditions that are false. Shaders: `classify.frag`,
//! `classes.glsl`.

use super::fullscreen::Fullscreen;
use super::targets::DEPTH_FORMAT;
use crate::vulkan::{vk, Access, ColorTarget, Commands, Context, DepthTarget, DepthTest, ImageView, Resource, Result, Shader};
use std::sync::Arc;

/// Constants of `fullscreen.vert`: the depth of the first triangle, and the ways to others.
const FIRST: u32 = 10;
const LOW: u32 = 11;
const HIGH: u32 = 12;

/// Pixels that a pass draws. One triangle passes all classes on one side of a depth; sets between others take one for each class.
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
    /// Those with neither air nor sea.
    Space,
    /// Those with air, but surely no cloud.
    Clear,
    /// Those where clouds may lie in front of all else.
    Cloudy,
}

impl Class {
    /// What passes; the first triangle's depth and the ways to the others (one bit of their number each, and all above) in halves of the
    /// steps in `classes.glsl`; and how many they are.
    fn test(self) -> (vk::CompareOp, [u32; 3], u32) {
        use vk::CompareOp as Pass;
        match self {
            Class::Noted | Class::Any => (Pass::ALWAYS, [0; 3], 1),
            Class::Edge => (Pass::EQUAL, [2, 4, 8], 5),
            Class::Sea => (Pass::EQUAL, [8, 2, 8], 4),
            Class::Space => (Pass::GREATER, [3, 0, 0], 1),
            Class::Clear => (Pass::EQUAL, [4, 2, 4], 4),
            Class::Cloudy => (Pass::LESS, [11, 0, 0], 1),
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
        (fragment, constant): (Shader<'_>, u32),
        format: vk::Format,
        class: Class,
    ) -> Result<ClassPass> {
        let (formats, (compare, [first, low, high], triangles)) = ([format], class.test());
        let constants = [(0, constant), (FIRST, first), (LOW, low), (HIGH, high)];
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
