//! Frames of a flight that waits for nothing: each is drawn with the patches that have arrived by then, as in a window.
//!
//! In: a scene, views in turn. Out: what each frame cost, and, where asked for, faults of the surface that it drew.

use super::milliseconds;
use crate::frame::Look;
use crate::headless::Headless;
use crate::scene::{uploads_within, Scene, SceneError};
use crate::verify::triangles_by_patch;
use crate::vulkan::{download, Context};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::{Planet, CLEARANCE_M};
use terrane_planet::verify::SurfaceCheck;

/// Pixels between the lines of sight that look for missing ground.
const SIGHT_STEP: usize = 4;

/// Times and counts of one frame of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveFrame {
    /// Milliseconds for uploads and the cut.
    pub update_ms: f64,
    /// Milliseconds for everything, to the GPU's completion.
    pub frame_ms: f64,
    /// Triangles drawn.
    pub triangles: u32,
    /// Patches drawn.
    pub patches: usize,
    /// Patches on the GPU.
    pub resident: usize,
    /// Patches asked for that were not there yet.
    pub pending: usize,
    /// Bytes of patches on the GPU.
    pub gpu_bytes: u64,
    /// Bytes of everything on the GPU.
    pub allocated_bytes: u64,
    /// Metres by which the camera was lifted above drawn ground and sea.
    pub lifted_m: f64,
    /// Whether nothing was missing.
    pub settled: bool,
}

/// What is wrong with the surface of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveFaults {
    /// Directed edges that nothing cancels.
    pub cracks: usize,
    /// Triangles turned over.
    pub flipped: usize,
    /// Lines of sight into the planet that met no ground in the picture.
    pub holes: usize,
}

impl LiveFaults {
    /// All together.
    pub fn total(&self) -> usize {
        self.cracks + self.flipped + self.holes
    }
}

/// A flight over a scene.
pub struct LiveFlight<'a> {
    context: Arc<Context>,
    scene: &'a mut Scene,
    headless: &'a mut Headless,
    /// Patches taken in by each frame.
    uploads: usize,
    /// The vertices of resident patches as the GPU has them.
    vertices: HashMap<PatchId, Vec<PatchVertex>>,
    /// The planet that they are of: an edit makes another.
    planet: Arc<Planet>,
}

impl<'a> LiveFlight<'a> {
    /// A flight with `step` seconds from frame to frame.
    pub fn new(context: &Arc<Context>, scene: &'a mut Scene, headless: &'a mut Headless, step: f64) -> LiveFlight<'a> {
        let uploads = uploads_within(step);
        let planet = scene.shared_planet();
        LiveFlight { context: context.clone(), scene, headless, uploads, vertices: HashMap::new(), planet }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// The scene, to edit its ground.
    pub fn scene_mut(&mut self) -> &mut Scene {
        self.scene
    }

    /// Draws the next frame of what `view` makes of a camera. The camera is lifted to [`CLEARANCE_M`] above drawn ground
    /// and sea.
    ///
    /// # Errors
    /// If a patch cannot be read, or the GPU fails.
    pub fn frame(
        &mut self,
        camera: Camera,
        view: &dyn Fn(Camera) -> View,
        look: &Look,
    ) -> Result<(LiveFrame, View, Cut), SceneError> {
        let begun = Instant::now();
        self.scene.set_sun(look.sun);
        let mut seen = view(camera);
        let mut cut = self.scene.update(&seen, self.uploads)?;
        let lifted = lifted(self.scene, camera);
        if lifted != camera {
            seen = view(lifted);
            cut = self.scene.choose(&seen);
        }
        let update_ms = milliseconds(begun);
        let report = self.headless.render(self.scene, &seen, &cut, look)?;
        let frame = LiveFrame {
            update_ms,
            frame_ms: milliseconds(begun),
            triangles: report.counters.wanted.min(report.counters.capacity),
            patches: report.tables.patches.len(),
            resident: self.scene.resident_count(),
            pending: self.scene.pending(),
            gpu_bytes: self.scene.gpu_bytes().0,
            allocated_bytes: self.context.allocated_bytes(),
            lifted_m: lifted.position.distance(camera.position),
            settled: self.scene.is_settled(),
        };
        Ok((frame, seen, cut))
    }

    /// Faults of the frame that was just drawn: of its surface as far as it is in sight, and of its picture.
    ///
    /// # Errors
    /// If the GPU fails.
    pub fn faults(&mut self, view: &View, cut: &Cut, look: &Look) -> Result<LiveFaults, SceneError> {
        let planet = self.scene.shared_planet();
        let lowest = planet.recipe.radius + planet.terrain.height_range().0;
        // The outline of what is drawn may lie inside the planet's by the tolerance.
        let inside = (view.tolerance + 1.0) * view.camera.pixel_angle() * view.camera.position.length();
        let holes = holes(&view.camera, &self.headless.depth()?, lowest - inside);
        let frame = self.headless.select_whole(self.scene, &view.without_culling(), cut, look)?;
        let selection = self.headless.read_selection(&frame)?;
        // A triangle that belongs to no patch leaves a hole, which counts.
        let (triangles, _) = triangles_by_patch(&frame.tables.patches, &selection.triangles);
        self.read_vertices(frame.tables.leaves.iter().map(|leaf| leaf.id))?;
        let mut surface = SurfaceCheck::default();
        for ((leaf, draw), triangles) in frame.tables.leaves.iter().zip(&frame.tables.patches).zip(&triangles) {
            let drawn_positions =
                &selection.drawn_positions[draw.resolve_offset as usize..(draw.resolve_offset + draw.vertex_count) as usize];
            surface.add(&self.vertices[&leaf.id], drawn_positions, triangles);
        }
        let report = surface.finish_in_sight(view, self.scene.tree().hidden_radius);
        Ok(LiveFaults { cracks: report.cracks, flipped: report.flipped, holes })
    }

    /// Reads back the vertices of patches that were not drawn before, and forgets those of patches that are gone.
    fn read_vertices(&mut self, drawn: impl Iterator<Item = PatchId>) -> Result<(), SceneError> {
        let planet = self.scene.shared_planet();
        if !Arc::ptr_eq(&planet, &self.planet) {
            self.vertices.clear();
            self.planet = planet;
        }
        self.vertices.retain(|id, _| self.scene.mesh(*id).is_some());
        let row = self.scene.planet().cells as usize + 1;
        for id in drawn {
            if let (false, Some(patch)) = (self.vertices.contains_key(&id), self.scene.mesh(id)) {
                self.vertices.insert(id, download(&self.context, patch.buffer(), row * row)?);
            }
        }
        Ok(())
    }
}

/// The camera, above the ground that is drawn below it and above the sea.
fn lifted(scene: &Scene, camera: Camera) -> Camera {
    let (up, planet) = (camera.position.normalize(), scene.planet());
    let surface = planet.terrain.ground_or_sea(&planet.recipe, up, scene.ground().height_at(up).unwrap_or(f64::NEG_INFINITY));
    let lowest = surface + planet.recipe.radius + CLEARANCE_M;
    let position = if camera.position.length() < lowest { up * lowest } else { camera.position };
    Camera { position, ..camera }
}

/// Lines of sight that run into the ball of radius `lowest` (metres), below all ground, where a picture's depth shows none.
pub fn holes(camera: &Camera, depth: &[f32], lowest: f64) -> usize {
    let [width, height] = camera.size.map(|side| side as usize);
    let (h, v) = camera.half_extents();
    let (right, up) = (camera.right() * h, camera.up * v);
    let meets = |x: usize, y: usize| {
        let [across, down] = [(x, width), (y, height)].map(|(at, side)| (at as f64 + 0.5) / side as f64 * 2.0 - 1.0);
        let ray: DVec3 = (camera.forward + right * across - up * down).normalize();
        let nearest = -camera.position.dot(ray);
        nearest > 0.0 && camera.position.cross(ray).length() < lowest
    };
    let pixels = (0..height).step_by(SIGHT_STEP).flat_map(|y| (0..width).step_by(SIGHT_STEP).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| depth[y * width + x] <= 0.0 && meets(x, y)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_ground_is_counted() {
        let camera = Camera::looking(DVec3::X * 3e6, 0.0, -90.0, 0.9, [64, 32]);
        let mut depth = vec![0.5; 64 * 32];
        assert_eq!(holes(&camera, &depth, 1e6), 0);
        depth[16 * 64 + 32] = 0.0;
        assert_eq!(holes(&camera, &depth, 1e6), 1);
        // Beside the planet there need be none.
        depth[0] = 0.0;
        assert_eq!(holes(&camera, &depth, 1e6), 1);
    }
}
