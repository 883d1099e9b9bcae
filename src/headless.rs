//! Still pictures without a window.

pub use crate::frame::Edge;
use crate::frame::{FrameTables, Look, Renderer};
use crate::scene::{Scene, SceneError};
use crate::vulkan::{capture, download, vk, Access, Commands, Context, Image, ImageDescription, Timestamps, VulkanError};
use std::sync::Arc;
use std::time::Instant;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::{DrawnVertex, EmitState, Shading};
use terrane_planet::draw::view::View;

/// Format of pictures: UNORM, encoded by the tonemap shader.
pub const PICTURE_FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Draws single frames into an image of its own.
pub struct Headless {
    context: Arc<Context>,
    /// The stages.
    pub renderer: Renderer,
    picture: Image,
    commands: Commands,
}

/// What one frame did.
pub struct FrameReport {
    /// GPU times by stage, and the wall time from submission to completion.
    pub times: Timestamps,
    /// Counters of emission.
    pub counters: EmitState,
    /// The tables the frame was drawn from.
    pub tables: FrameTables,
    /// CPU milliseconds for making the tables and writing them into the GPU's buffers.
    pub tables_ms: f64,
    /// CPU milliseconds for recording the commands.
    pub record_ms: f64,
}

/// What the mesh stages of a frame left on the GPU.
pub struct Selection {
    /// Awake bits of all patches, at the offsets of the frame's tables.
    pub awake: Vec<u32>,
    /// What every vertex is drawn as, at the offsets of the frame's tables.
    pub resolved: Vec<u32>,
    /// Where every vertex is drawn, at the same offsets.
    pub drawn_positions: Vec<DrawnVertex>,
    /// Emitted triangles in no order: patch number above [`VERTEX_BITS`](terrane_planet::draw::layout::VERTEX_BITS), vertex below.
    pub triangles: Vec<[u32; 3]>,
}

impl Headless {
    /// Pipelines and targets for pictures of a size.
    pub fn new(context: &Arc<Context>, size: (u32, u32)) -> Result<Headless, SceneError> {
        Ok(Headless {
            context: context.clone(),
            renderer: Renderer::new(context, size, PICTURE_FORMAT)?,
            picture: picture(context, size)?,
            commands: Commands::new(context, "frame")?,
        })
    }

    /// Draws one frame and waits for it.
    pub fn render(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look) -> Result<FrameReport, SceneError> {
        let (tables, tables_ms, begun) = self.begin_mesh(scene, view, cut, look, false)?;
        self.renderer.record_picture(&mut self.commands, scene, look, self.picture.view())?;
        let record_ms = milliseconds_since(begun);
        let times = self.commands.submit_and_wait()?;
        let counters = self.renderer.counters()?;
        if counters.wanted > counters.capacity {
            tracing::warn!(wanted = counters.wanted, drawn = counters.capacity, "more triangles than the index buffer holds");
        }
        Ok(FrameReport { times, counters, tables, tables_ms, record_ms })
    }

    /// Follows a change of picture size.
    pub fn resize(&mut self, size: (u32, u32)) -> Result<(), SceneError> {
        if self.picture.mip_size(0) != size {
            self.picture = picture(&self.context, size)?;
        }
        Ok(self.renderer.resize(size)?)
    }

    /// Runs only the mesh stages of a frame over all patches of the cut, seen or not.
    pub fn select_whole(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look) -> Result<FrameReport, SceneError> {
        self.select(scene, view, cut, look, true)
    }

    /// Runs only the mesh stages of a frame, so that [`Headless::render_part`] can draw it.
    pub fn select_seen(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look) -> Result<FrameReport, SceneError> {
        self.select(scene, view, cut, look, false)
    }

    /// Draws a part of the picture whose mesh was selected last. `part` is that picture's view through a window, and `tables` are that
    /// selection's; the scene must not have been updated since.
    pub fn render_part(
        &mut self,
        scene: &Scene,
        part: &View,
        tables: &FrameTables,
        look: &Look,
    ) -> Result<(Timestamps, EmitState), SceneError> {
        self.renderer.prepare_again(scene, part, tables, look)?;
        self.commands.begin()?;
        self.renderer.record_part(&mut self.commands, scene, tables)?;
        self.renderer.record_picture(&mut self.commands, scene, look, self.picture.view())?;
        let times = self.commands.submit_and_wait()?;
        Ok((times, self.renderer.counters()?))
    }

    fn select(&mut self, scene: &Scene, view: &View, cut: &Cut, look: &Look, whole: bool) -> Result<FrameReport, SceneError> {
        let (tables, tables_ms, begun) = self.begin_mesh(scene, view, cut, look, whole)?;
        let record_ms = milliseconds_since(begun);
        let times = self.commands.submit_and_wait()?;
        Ok(FrameReport { times, counters: self.renderer.counters()?, tables, tables_ms, record_ms })
    }

    /// Prepares a frame, and records its mesh stages. The tables, the milliseconds that they took, and when recording began.
    fn begin_mesh(
        &mut self,
        scene: &Scene,
        view: &View,
        cut: &Cut,
        look: &Look,
        whole: bool,
    ) -> Result<(FrameTables, f64, Instant), SceneError> {
        let begun = Instant::now();
        let tables = self.renderer.prepare(scene, view, cut, look, whole)?;
        let tables_ms = milliseconds_since(begun);
        let begun = Instant::now();
        self.commands.begin()?;
        self.renderer.record_mesh(&mut self.commands, scene, &tables)?;
        Ok((tables, tables_ms, begun))
    }

    /// Reads back what the mesh stages of the latest frame wrote; `report` is that frame's.
    pub fn read_selection(&self, report: &FrameReport) -> Result<Selection, SceneError> {
        let buffers = &self.renderer.buffers;
        let emitted = report.counters.wanted.min(report.counters.capacity);
        Ok(Selection {
            awake: download(&self.context, &buffers.awake, report.tables.awake_words as usize)?,
            resolved: download(&self.context, &buffers.resolved, report.tables.vertices as usize)?,
            drawn_positions: download(&self.context, &buffers.drawn_positions, report.tables.vertices as usize)?,
            triangles: download(&self.context, &buffers.indices, emitted as usize)?,
        })
    }

    /// Radiance of the latest picture before it is mapped to the display: four numbers a pixel, row by row.
    pub fn radiance(&self) -> Result<Vec<f32>, SceneError> {
        Ok(capture(&self.context, &self.renderer.targets.radiance, (0, 0), Access::Sampled)?.to_f32()?)
    }

    /// Radiance of the latest picture's ground and sea before the air: four numbers a pixel, row by row.
    pub fn surface(&self) -> Result<Vec<f32>, SceneError> {
        Ok(capture(&self.context, &self.renderer.targets.water, (0, 0), Access::Sampled)?.to_f32()?)
    }

    /// Height above the sea in metres, up to [`SHORE_RANGE`](terrane_planet::ground::texture::SHORE_RANGE), of the ground in the latest
    /// picture; row by row.
    pub fn shore(&self) -> Result<Vec<f32>, SceneError> {
        let ground = capture(&self.context, &self.renderer.targets.ground, (0, 0), Access::Sampled)?.to_f32()?;
        Ok(ground.chunks_exact(4).map(|texel| texel[3]).collect())
    }

    /// The shading block of the latest picture.
    pub fn shading(&self) -> &Shading {
        self.renderer.shading()
    }

    /// Factor from radiance to what the tone curve took in the latest picture.
    pub fn exposure(&self) -> Result<f32, SceneError> {
        Ok(self.shading().exposure * self.metered()?)
    }

    /// The part of it that the latest picture asked for itself: 1 where it was not metered.
    pub(crate) fn metered(&self) -> Result<f32, SceneError> {
        if self.shading().adaptation < 0.0 {
            return Ok(1.0);
        }
        Ok(download::<f32>(&self.context, self.renderer.metered_factor(), 1)?.first().copied().unwrap_or(1.0))
    }

    /// Where the latest picture shows ground: its depth (near plane over distance), 0 where there is none, row by row.
    pub fn depth(&self) -> Result<Vec<f32>, SceneError> {
        Ok(capture(&self.context, &self.renderer.targets.depth, (0, 0), Access::Sampled)?.to_f32()?)
    }

    /// Which pixels of the latest picture are part of another surface, too; row by row.
    pub fn edges(&self) -> Result<Vec<Option<Edge>>, SceneError> {
        let targets = &self.renderer.targets;
        let captured = capture(&self.context, &targets.edges, (0, 0), Access::Sampled)?;
        // The image may be wider than the picture.
        let rows = captured.bytes.chunks_exact(captured.width as usize);
        Ok(rows.flat_map(|row| row[..targets.size.0 as usize].iter().map(|&code| Edge::decode(code))).collect())
    }

    /// The latest picture, four bytes a pixel, row by row.
    pub fn pixels(&self) -> Result<Vec<u8>, SceneError> {
        Ok(capture(&self.context, &self.picture, (0, 0), Access::ColorTarget)?.to_rgba8()?)
    }
}

fn picture(context: &Arc<Context>, size: (u32, u32)) -> Result<Image, VulkanError> {
    Image::new(context, &ImageDescription::new("picture", size, PICTURE_FORMAT, vk::ImageUsageFlags::COLOR_ATTACHMENT))
}

fn milliseconds_since(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}
