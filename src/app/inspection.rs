//! What is at a site: the patch that is drawn there, what is known of it, and the vertices that the nearest one collapses into.

use crate::frame::FrameTables;
use crate::scene::Scene;
use glam::{DVec3, IVec3};
use std::collections::HashSet;
use std::sync::Arc;
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::mesh::wake::Wake;
use terrane_planet::planet::Planet;
use terrane_planet::reference::select::{morph_weight, on_sides};

/// What is known of a site and of the patch that is drawn there.
#[derive(Clone, Debug)]
pub(super) struct Inspected {
    /// Degrees north and east.
    pub(super) site: [f64; 2],
    /// Metres of the ground above the datum.
    pub(super) height_m: Option<f64>,
    pub(super) patch: PatchId,
    /// Metres between samples of the patch.
    pub(super) spacing_m: f64,
    /// Metres above the datum between which the ground of the patch lies, whatever finer patches there may be.
    pub(super) heights_m: [f64; 2],
    /// Vertices of the patch that selection looks at, and all.
    pub(super) vertices: [u32; 2],
    /// Metres from which the patch splits because of the vertices on its sides, and because its grid deviates too much.
    pub(super) splits_m: [f64; 2],
    /// The patch's vertex that is nearest to the site, its parent, and so on to one that never collapses.
    pub(super) chain: Vec<Link>,
}

/// A vertex of a chain of parents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// Column and row in the patch's grid.
    pub(super) grid: [u32; 2],
    /// Metres from the planet's centre.
    pub(super) position: DVec3,
    /// Metres of selection distance from nearer than which it is awake in this view. None: it always is.
    pub(super) awake_m: Option<f64>,
    /// How far it has slid towards its parent: 0 in its own position. None: it sleeps.
    pub(super) weight: Option<f32>,
}

/// The vertices of the patch that is looked at. The scene has them on the GPU alone, so the patch is built once more: it is a pure function of
/// its planet.
pub(super) struct Anatomy {
    planet: Arc<Planet>,
    patch: PatchId,
    vertices: Vec<PatchVertex>,
}

impl Anatomy {
    /// The vertices of a patch of a scene's planet.
    pub(super) fn of(scene: &Scene, patch: PatchId) -> Anatomy {
        let planet = scene.shared_planet();
        let (mesh, _) = planet.survey(patch).mesh(&planet.ground());
        let vertices = PatchVertex::of_patch(&mesh, scene.lattice());
        Anatomy { planet, patch, vertices }
    }

    /// Whether they are those of this patch, of the ground that is drawn now.
    pub(super) fn is_of(&self, scene: &Scene, patch: PatchId) -> bool {
        self.patch == patch && Arc::ptr_eq(&self.planet, &scene.shared_planet())
    }

    /// The chain of parents of the vertex that is nearest to a site.
    fn chain(&self, view: &View, sides: u32, unit: f64, site: DVec3) -> Vec<Link> {
        let direction = |vertex: &PatchVertex| IVec3::from_array(vertex.position).as_dvec3().normalize();
        let nearness = |k: &usize| direction(&self.vertices[*k]).dot(site);
        let nearest = (0..self.vertices.len()).max_by(|a, b| nearness(a).total_cmp(&nearness(b)));
        let parent = |k: &usize| Some(self.vertices[*k].parent() as usize).filter(|parent| parent < k);
        std::iter::successors(nearest, parent).map(|k| self.link(k, view, sides, unit)).collect()
    }

    fn link(&self, k: usize, view: &View, sides: u32, unit: f64) -> Link {
        let (vertex, cells) = (&self.vertices[k], view.gpu.cells);
        let wake = vertex.wake_beside(on_sides(vertex.grid(), cells, sides));
        let awake_m = (wake != Wake::ALWAYS).then(|| view.reach * wake.distance() * unit);
        Link {
            grid: [vertex.grid() % (cells + 1), vertex.grid() / (cells + 1)],
            position: IVec3::from_array(vertex.position).as_dvec3() * unit,
            awake_m,
            weight: morph_weight(&view.gpu, vertex, sides),
        }
    }
}

/// The number, in a frame's tables, of the patch that is drawn in a direction from the planet's centre. None if nothing is.
pub(super) fn drawn_at(tables: &FrameTables, site: DVec3) -> Option<usize> {
    let drawn: HashSet<PatchId> = tables.leaves.iter().map(|leaf| leaf.id).collect();
    let deepest = drawn.iter().map(|id| id.level).max()?;
    let patch = (0..=deepest).rev().map(|level| PatchId::containing(site, level)).find(|id| drawn.contains(id))?;
    tables.leaves.iter().position(|leaf| leaf.id == patch)
}

/// What is known of a site at which the patch with this number is drawn, selected by `view`.
pub(super) fn inspect(
    scene: &Scene,
    view: &View,
    tables: &FrameTables,
    at: usize,
    anatomy: &Anatomy,
    site: DVec3,
) -> Option<Inspected> {
    let leaf = tables.leaves.get(at)?;
    let patch = leaf.id;
    let node = scene.tree().get(patch)?;
    let (latitude, longitude) = latitude_longitude(site);
    let unit = scene.lattice().unit;
    let metres = |wake: f64| wake * f64::from(view.gpu.scale) * unit;
    let detail = node.quarters.iter().map(|quarter| quarter.detail_wake).fold(0.0, f64::max);
    Some(Inspected {
        site: [latitude, longitude],
        height_m: scene.ground().height_at(site),
        patch,
        spacing_m: scene.ground().known.spacing(patch.level),
        heights_m: node.space.heights.map(|height| f64::from(height) * unit),
        vertices: [tables.patches[at].vertex_count, (scene.tree().cells + 1).pow(2)],
        splits_m: [metres(node.closure_wake), metres(detail)],
        chain: anatomy.chain(view, u32::from(leaf.coarser_sides), unit, site),
    })
}
