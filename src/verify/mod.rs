//! Verification of what the GPU makes of a planet file: every stage against its CPU twin, and the emitted triangles of the
//! whole planet against the invariants (watertight by bits, nothing flipped, closure kept).
//!
//! In: a scene without textures, a headless renderer and views. Out: [`VerifyReport`]. The patches are read from the file, or built, a
//! second time, so that nothing that the GPU was given is taken on trust.

mod report;
pub mod screen;
mod twins;

pub use report::{MeshFaults, Mismatches, VerifyReport, ViewReport};
pub use screen::{Perturbation, ScreenErrors, ScreenReport};

use crate::frame::Look;
use crate::headless::{FrameReport, Headless, Selection};
use crate::scene::{Scene, SceneError};
use glam::DVec3;
use std::collections::hash_map::{Entry, HashMap};
use std::path::Path;
use std::sync::Arc;
use terrane_planet::draw::cut::at_data_rim;
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::Planet;
use terrane_planet::store::{PlanetFile, StoreError};
use terrane_planet::verify::{GridCache, RandomViews, SurfaceCheck};
pub(crate) use twins::triangles_by_patch;
use twins::{differing_triangles, KnownPatch, Twin};

/// Tolerances in pixels that random views take in turn, if none are asked for.
pub const TOLERANCES: [f64; 4] = [1.0, 0.5, 2.0, 4.0];

/// The light does not matter here.
const LOOK: Look = Look::daylight(DVec3::X);

/// The CPU's copies of the patches, and how to get more.
pub struct Verifier {
    source: PatchSource,
    lattice: Lattice,
    patches: HashMap<PatchId, KnownPatch>,
    grids: GridCache,
}

/// Random views over a planet: sites and heights from [`RandomViews`], `tolerances` in turn (at least one).
pub fn random_views(scene: &Scene, seed: u64, count: usize, tolerances: &[f64]) -> Vec<View> {
    let planet = scene.planet();
    let height = |site: DVec3| planet.terrain.height(site);
    let cameras = RandomViews::new(scene.tree(), seed, &height).take(count);
    let view = |(k, camera): (usize, Camera)| {
        // Sites take turns in fours: a shift every round brings every tolerance to every kind of site.
        let tolerance = tolerances[(k + k / 4) % tolerances.len()];
        View::new(camera, &planet.lattice, planet.cells, tolerance)
    };
    cameras.enumerate().map(view).collect()
}

/// Views near the ground of `sites` random sites on land, see [`terrane_planet::verify::ground_views`]; `tolerances` in turn.
pub fn ground_views(scene: &Scene, seed: u64, sites: usize, count: usize, tolerances: &[f64]) -> Vec<View> {
    let planet = scene.planet();
    let sea = planet.recipe.sea.as_ref().map_or(f64::NEG_INFINITY, |sea| sea.level_m);
    let height = |site: DVec3| planet.terrain.height(site);
    let cameras = terrane_planet::verify::ground_views(seed, sites, count, planet.recipe.radius, sea, &height);
    let view = |(k, camera)| View::new(camera, &planet.lattice, planet.cells, tolerances[k % tolerances.len()]);
    cameras.into_iter().enumerate().map(view).collect()
}

/// Patches from the file, or built where it lacks them.
struct PatchSource {
    file: PlanetFile,
    planet: Arc<Planet>,
}

impl PatchSource {
    fn mesh(&self, id: PatchId) -> Result<PatchMesh, StoreError> {
        if self.file.contains(id)? {
            self.file.mesh(id)
        } else {
            Ok(self.planet.build(id).0)
        }
    }
}

impl Verifier {
    /// A verifier of the file that `scene` was opened from.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn new(path: &Path, scene: &Scene) -> Result<Verifier, SceneError> {
        let open = || Ok::<_, SceneError>(PatchSource { file: PlanetFile::open(path)?, planet: scene.shared_planet() });
        let (source, finest) = (open()?, open()?);
        let grids = GridCache::new(scene.tree(), Box::new(move |id| finest.mesh(id)));
        Ok(Verifier { source, lattice: *scene.lattice(), patches: HashMap::new(), grids })
    }

    /// Draws the whole planet in one view twice, without culling for its surface and with it for what it leaves, and checks both.
    ///
    /// # Errors
    /// If patches cannot be read, or the GPU fails. Faults of the mesh are no errors: they are in the report.
    pub fn check(&mut self, scene: &mut Scene, headless: &mut Headless, view: &View) -> Result<ViewReport, SceneError> {
        let cut = scene.settle(view)?;
        for leaf in &cut.leaves {
            self.patch_mut(leaf.id)?;
        }
        let frame = headless.select_whole(scene, &view.without_culling(), &cut, &LOOK)?;
        let leaves = frame.tables.leaves.iter();
        let twins: Vec<Twin> = leaves.filter_map(|leaf| Some(Twin::new(view, leaf, self.patches.get(&leaf.id)?))).collect();
        let mut report = ViewReport::default();
        report.mismatches.patches = cut.leaves.len() - twins.len();
        check_surface(scene, &twins, &frame, &headless.read_selection(&frame)?, &mut report);
        let culled = headless.select_whole(scene, view, &cut, &LOOK)?;
        check_culled(view, &twins, &culled, &headless.read_selection(&culled)?, &mut report);
        Ok(report)
    }

    /// Forgets all copies of patches, to make room: for views somewhere else.
    pub fn forget(&mut self) {
        self.patches.clear();
    }

    /// The CPU's copy of a patch. Change it only to see that a difference is noticed.
    ///
    /// # Errors
    /// If the patch in the file is damaged.
    pub fn patch_mut(&mut self, id: PatchId) -> Result<&mut LoadedPatch, StoreError> {
        match self.patches.entry(id) {
            Entry::Occupied(known) => Ok(&mut known.into_mut().loaded),
            Entry::Vacant(vacant) => {
                let mesh = self.source.mesh(id)?;
                Ok(&mut vacant.insert(KnownPatch::new(mesh, &self.lattice)).loaded)
            }
        }
    }
}

/// The surface that the GPU emitted without culling, and every stage on the way to it.
fn check_surface(scene: &Scene, twins: &[Twin], frame: &FrameReport, selection: &Selection, report: &mut ViewReport) {
    let (lists, stray) = triangles_by_patch(&frame.tables.patches, &selection.triangles);
    report.mismatches.triangles = stray;
    report.triangles = selection.triangles.len();
    report.dropped = overflow(frame);
    let mut surface = SurfaceCheck::default();
    for ((twin, draw), triangles) in twins.iter().zip(&frame.tables.patches).zip(lists) {
        let before = surface.so_far();
        surface.add(&twin.known.loaded.vertices, twin.drawn_positions_of(draw, selection), &triangles);
        let after = surface.so_far();
        let mismatches = twin.compare_stages(draw, selection);
        report.mismatches += mismatches;
        report.mismatches.triangles += differing_triangles(triangles, twin.emit(None));
        report.awake_vertices += twin.awake_count();
        let at_rim = at_data_rim(scene.tree(), &twin.leaf);
        let faults = if at_rim { &mut report.faults_at_data_rim } else { &mut report.faults };
        faults.flipped += after.flipped - before.flipped;
        faults.degenerate += after.degenerate - before.degenerate;
        match &twin.known.rings {
            Some(rings) if mismatches.patches == 0 => {
                faults.closure_violations +=
                    rings.violations(twin.words_of(draw, selection), twin.drawn_positions_of(draw, selection))
            }
            Some(_) => {}
            None => report.broken_hierarchies += 1,
        }
    }
    report.patches = twins.len();
    report.cracks = surface.finish().cracks;
    report.mismatches.counters = usize::from(frame.counters.awake as usize != report.awake_vertices);
}

/// The triangles that the GPU kept with culling.
fn check_culled(view: &View, twins: &[Twin], frame: &FrameReport, selection: &Selection, report: &mut ViewReport) {
    let (lists, stray) = triangles_by_patch(&frame.tables.patches, &selection.triangles);
    report.mismatches.culled_triangles = stray;
    report.triangles_after_culling = selection.triangles.len();
    report.dropped += overflow(frame);
    for (twin, triangles) in twins.iter().zip(lists) {
        report.mismatches.culled_triangles += differing_triangles(triangles, twin.emit(Some(view)));
    }
}

/// Triangles that did not fit the index buffer.
fn overflow(frame: &FrameReport) -> usize {
    frame.counters.wanted.saturating_sub(frame.counters.capacity) as usize
}
