//! A frame: the stages in order, each in a file of its own (docs/design.md, "A frame").
//!
//! In: a scene, a cut and a view. Out: a picture in a colour target, counters, and GPU times by stage.

mod air;
mod buffers;
mod classes;
mod draw;
mod edge_shapes;
mod edges;
mod emit;
mod fullscreen;
#[cfg(feature = "app")]
mod gui;
mod meter;
mod ocean;
mod passed;
mod resolve;
mod select;
mod shading;
mod sky;
mod stage;
mod stages;
mod stars;
mod tables;
mod targets;
mod tiles;
mod tonemap;
mod upscale;

pub use buffers::{FrameBuffers, MAX_TRIANGLES};
pub use edges::Edge;
#[cfg(feature = "app")]
pub use gui::{Gui, GuiFrame};
pub use shading::{shading, sun_over, sun_seen_from, Look};
pub use stage::{PerStage, Stage};
pub use tables::{FrameTables, MeshTasks};
pub use targets::{Targets, DEPTH_FORMAT, RADIANCE_FORMAT};

use crate::scene::Scene;
#[cfg(feature = "hot-reload")]
use crate::vulkan::Replacements;
use crate::vulkan::{vk, Buffer, Commands, Context, Image, ImageView, Result};
use passed::Shared;
use stages::Stages;
use std::sync::Arc;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::{EmitState, FrameView, Mode, Shading};
use terrane_planet::draw::view::View;

/// Seconds after which the sea begins again, before single precision runs out.
const WAVES_REPEAT: f64 = 7200.0;

/// Pipelines, targets and buffers of all stages.
pub struct Renderer {
    stages: Stages,
    /// Whether stars are drawn where there is nothing else.
    pub starry: bool,
    /// Whether the meter has been read before.
    metered: bool,
    context: Arc<Context>,
    /// Seconds, for things that move by themselves: 0 in still pictures.
    pub time: f64,
    /// Of the frame that was prepared last.
    shading: Shading,
    /// Of the density in use.
    pub(crate) targets: Targets,
    /// Of densities used before, at the same size.
    spare_targets: Vec<(f64, Targets)>,
    /// Width and height of pictures.
    size: (u32, u32),
    format: vk::Format,
    density: f64,
    /// Buffers shared by the stages.
    pub buffers: FrameBuffers,
}

impl Renderer {
    /// Builds everything for pictures of a size and format.
    pub fn new(context: &Arc<Context>, size: (u32, u32), format: vk::Format) -> Result<Renderer> {
        let samples = context.samples();
        Ok(Renderer {
            stages: Stages::new(context, samples, format)?,
            starry: true,
            metered: false,
            context: context.clone(),
            time: 0.0,
            shading: Shading::default(),
            targets: Targets::new(context, size, samples)?,
            spare_targets: Vec::new(),
            size,
            format,
            density: 1.0,
            buffers: FrameBuffers::new(context)?,
        })
    }

    /// Builds all stages again, with shaders that take the place of those that the program was built with. Waits for the GPU.
    ///
    /// # Errors
    /// Shaders that ask for other resources than the program gives them, or that the device cannot run: the stages before stay.
    #[cfg(feature = "hot-reload")]
    pub fn reload(&mut self, shaders: Replacements) -> Result<()> {
        let before = self.context.replace_shaders(shaders);
        let built = Stages::new(&self.context, self.context.samples(), self.format);
        let stages = built.inspect_err(|_| drop(self.context.replace_shaders(before)))?;
        self.context.wait_idle()?;
        self.stages = stages;
        self.metered = false;
        Ok(())
    }

    /// Follows a change of picture size.
    pub fn resize(&mut self, size: (u32, u32)) -> Result<()> {
        if self.size != size {
            self.spare_targets.clear();
            self.size = size;
            self.targets = self.targets_of(self.density)?;
        }
        Ok(())
    }

    /// Draws pictures with so many pixels along a side for each of their own, from 0 to 1, and enlarges them. The mesh stays that of all
    /// pixels. Targets of other densities are kept, so that going back and forth costs nothing.
    pub fn set_density(&mut self, density: f64) -> Result<()> {
        if self.density == density {
            return Ok(());
        }
        let kept = self.spare_targets.iter().position(|(of, _)| *of == density);
        let targets = match kept {
            Some(index) => self.spare_targets.swap_remove(index).1,
            None => self.targets_of(density)?,
        };
        let before = std::mem::replace(&mut self.targets, targets);
        self.spare_targets.push((std::mem::replace(&mut self.density, density), before));
        Ok(())
    }

    fn targets_of(&self, density: f64) -> Result<Targets> {
        if density == 1.0 {
            return Targets::new(&self.context, self.size, self.context.samples());
        }
        Targets::sparse(&self.context, self.size, self.format, density)
    }

    /// Prepares the tables of the next frame and hands them to the GPU. `whole` draws patches out of sight too.
    pub fn prepare(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look, whole: bool) -> Result<FrameTables> {
        let _span = tracing::trace_span!("prepare").entered();
        let tables = FrameTables::new(scene, view, cut, whole);
        self.shading = self.lit(scene, view, look);
        self.buffers.write(&tables, &view.gpu, &self.shading)?;
        Ok(tables)
    }

    /// Prepares another picture of a mesh that is selected and emitted already, from wherever `view` is. `tables` are those of the
    /// frame before, and the scene must not have been updated since.
    pub fn prepare_again(&mut self, scene: &Scene, view: &View, tables: &FrameTables, look: &Look) -> Result<()> {
        self.shading = self.lit(scene, view, look);
        let shift = (tables.eye - view.eye).as_vec3().to_array();
        self.buffers.write(tables, &FrameView { shift, ..view.gpu }, &self.shading)
    }

    /// In place of [`Renderer::record_mesh`] after [`Renderer::prepare_again`] with a part of the same view: emits, from the mesh that is
    /// selected already, the triangles in its window.
    pub fn record_part(&self, commands: &mut Commands, scene: &Scene, tables: &FrameTables) -> Result<()> {
        keep_patches(commands, scene, tables);
        self.buffers.record_reset(commands)?;
        Stage::Emit.record(commands, |c| self.stages.emit.record(c, &self.buffers))?;
        self.buffers.record_readback(commands)
    }

    /// In place of [`Renderer::record_mesh`] after [`Renderer::prepare_again`].
    pub fn record_again(&self, commands: &mut Commands, scene: &Scene, tables: &FrameTables) -> Result<()> {
        keep_patches(commands, scene, tables);
        self.buffers.record_readback(commands)
    }

    /// Records the mesh stages of the prepared frame: which vertices are awake, what they are drawn as and where, which triangles.
    pub fn record_mesh(&self, commands: &mut Commands, scene: &Scene, tables: &FrameTables) -> Result<()> {
        let _span = tracing::trace_span!("record mesh").entered();
        keep_patches(commands, scene, tables);
        self.buffers.record_reset(commands)?;
        Stage::Select.record(commands, |c| self.stages.select.record(c, &self.buffers))?;
        Stage::Resolve.record(commands, |c| self.stages.resolve.record(c, &self.buffers))?;
        Stage::Emit.record(commands, |c| self.stages.emit.record(c, &self.buffers))?;
        self.buffers.record_readback(commands)
    }

    /// Records the picture stages into `picture`, whose contents are thrown away, and which is left as
    /// [`Access::ColorTarget`](crate::vulkan::Access::ColorTarget).
    pub fn record_picture(&mut self, commands: &mut Commands, scene: &Scene, look: &Look, picture: &ImageView) -> Result<()> {
        let _span = tracing::trace_span!("record picture").entered();
        self.stages.air.record(commands, &self.buffers, &self.shading)?;
        let Renderer { stages, buffers, targets, shading: lit, .. } = &*self;
        let Stages { air, tiles, .. } = stages;
        let shared = Shared { lit, buffers, scene, targets, air, tiles };
        let drawn = Stage::Draw.record(commands, |c| stages.draw.record(c, &shared))?;
        let ground = Stage::Edges.record(commands, |c| stages.edges.record(c, &shared, drawn))?;
        let water = Stage::Ocean.record(commands, |c| stages.ocean.record(c, &shared, ground))?;
        if look.mode == Mode::Wire {
            Stage::Lines.record(commands, |c| stages.draw.record_lines(c, &shared, water, ground.depth))?;
        }
        let seen = Stage::Sky.record(commands, |c| stages.sky.record(c, &shared, ground, water))?;
        if self.starry && !look.mode.is_diagram() {
            Stage::Stars.record(commands, |c| stages.stars.record(c, &shared, ground.depth, seen))?;
        }
        let metered = match look.metering {
            Some(_) => Stage::Meter.record(commands, |c| stages.meter.record(c, &shared, seen))?,
            None => stages.meter.factor(),
        };
        let few = targets.few.as_ref().map(Image::view);
        let toned = few.unwrap_or(picture);
        Stage::Tonemap.record(commands, |c| stages.tonemap.record(c, &shared, (seen, ground.edges), metered, toned))?;
        if let Some(few) = few {
            Stage::Upscale.record(commands, |c| stages.upscale.record(c, targets, few, picture))?;
        }
        self.metered |= look.metering.is_some();
        Ok(())
    }

    /// The shading of a view. In the ground it is dark: what is seen from there are slopes from behind and the sky through them.
    fn lit(&self, scene: &Scene, view: &View, look: &Look) -> Shading {
        let planet = scene.planet();
        let view = view.with_density(self.density);
        let mut shading = shading(&planet.recipe, planet.terrain.height_range().0, &view, look);
        if scene.ground().buries(view.camera.position) {
            shading.exposure = 0.0;
        }
        shading.time = (self.time % WAVES_REPEAT) as f32;
        // The first reading has nothing to adapt from.
        if look.metering.is_some() && !self.metered {
            shading.adaptation = 1.0;
        }
        shading
    }

    /// The shading block of the frame that was prepared last.
    pub fn shading(&self) -> &Shading {
        &self.shading
    }

    /// What the meter said last: a factor on exposure. Wait for the frame first.
    pub(crate) fn metered_factor(&self) -> &Buffer {
        self.stages.meter.factor()
    }

    /// Counters of the latest frame; wait for it first.
    pub fn counters(&self) -> Result<EmitState> {
        self.buffers.counters()
    }

    /// Counters of the frame before the latest; wait for that one first. All 0 before there is one.
    pub fn earlier_counters(&self) -> Result<EmitState> {
        self.buffers.earlier_counters()
    }
}

/// Keeps the drawn patches on the GPU until the commands are done.
fn keep_patches(commands: &mut Commands, scene: &Scene, tables: &FrameTables) {
    let patches = tables.leaves.iter().filter_map(|leaf| scene.mesh(leaf.id));
    patches.for_each(|patch| commands.keep(patch.buffer()));
}
