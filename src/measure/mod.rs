//! What one frame costs when everything it needs is resident.
//!
//! In: a scene and a view. Out: a row of times and counts. Loading is not part of it: the scene settles first, and the time of
//! that stands by itself.

pub mod live;

use crate::frame::{Look, PerStage, Stage};
use crate::headless::Headless;
use crate::scene::{Scene, SceneError};
use std::time::Instant;
use terrane_planet::draw::view::View;

/// Times and counts of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCost {
    /// Milliseconds until the view's patches were resident; not part of the other times.
    pub settle_ms: f64,
    /// CPU milliseconds for the cut and its requests.
    pub cut_ms: f64,
    /// CPU milliseconds for making the tables and writing them.
    pub tables_ms: f64,
    /// CPU milliseconds for recording the commands.
    pub record_ms: f64,
    /// GPU milliseconds of each stage; `None` for stages that did not run, or without timestamps.
    pub stages_ms: PerStage<Option<f64>>,
    /// Milliseconds from submission to completion.
    pub gpu_wall_ms: f64,
    /// Milliseconds from the cut to the GPU's completion: CPU and GPU one after the other, as nothing overlaps here.
    pub frame_ms: f64,
    /// Triangles drawn.
    pub triangles: u32,
    /// Awake vertices.
    pub awake: u32,
    /// Vertices that selection looked at: the prefixes of all drawn patches.
    pub prefix_vertices: u32,
    /// Triangles that emission looked at.
    pub candidate_triangles: u32,
    /// Patches drawn.
    pub patches: usize,
    /// Patches on the GPU.
    pub resident: usize,
}

impl FrameCost {
    /// GPU milliseconds of the stages that make the mesh: select, resolve and emit. `None` without timestamps.
    pub fn mesh_ms(&self) -> Option<f64> {
        Stage::MESH.iter().map(|stage| self.stages_ms[*stage]).sum()
    }
}

/// Settles the scene on a view and measures one frame of it.
///
/// # Errors
/// If a patch cannot be read, or the GPU fails.
pub fn measure_frame(scene: &mut Scene, headless: &mut Headless, view: &View, look: &Look) -> Result<FrameCost, SceneError> {
    let begun = Instant::now();
    scene.set_sun(look.sun);
    scene.settle(view)?;
    let settle_ms = milliseconds(begun);
    let begun = Instant::now();
    let cut = scene.update(view, 0)?;
    let cut_ms = milliseconds(begun);
    let report = headless.render(scene, view, &cut, look)?;
    Ok(FrameCost {
        settle_ms,
        cut_ms,
        tables_ms: report.tables_ms,
        record_ms: report.record_ms,
        stages_ms: PerStage::gpu_ms(&report.times),
        gpu_wall_ms: report.times.wall_ms,
        frame_ms: milliseconds(begun),
        triangles: report.counters.wanted.min(report.counters.capacity),
        awake: report.counters.awake,
        prefix_vertices: report.tables.vertices,
        candidate_triangles: report.tables.triangles,
        patches: report.tables.patches.len(),
        resident: scene.resident_count(),
    })
}

fn milliseconds(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}
