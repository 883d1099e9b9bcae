//! A whole planet on the CPU with mixed levels, and views of it.

#![allow(dead_code, reason = "every test program uses its own part")]

use crate::common::TestField;
use glam::DVec3;
use std::collections::HashMap;
use terrane_planet::draw::cut::{at_data_rim, Cut};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::{Ground, HeightGrid};
use terrane_planet::mesh::builder::Faults;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::verify::{RandomViews, Rings, SurfaceCheck, SurfaceReport};

/// All patches, in memory.
pub(crate) struct Planet {
    pub(crate) tree: PatchTree,
    pub(crate) patches: HashMap<PatchId, (LoadedPatch, Rings)>,
}

/// All patches of levels 0..=2, and three more levels around one face corner.
pub(crate) fn planet(field: &TestField, cells: u32) -> Planet {
    let ground = field.ground(cells);
    let mut ids: Vec<PatchId> = PatchId::roots().collect();
    let mut at = 0;
    while at < ids.len() {
        let id = ids[at];
        at += 1;
        let near_corner = id.centre().distance(DVec3::new(1.0, 1.0, 1.0).normalize()) < 2.0 / f64::from(1u32 << id.level);
        if id.level < 2 || (id.level < 5 && near_corner) {
            ids.extend(id.children().into_iter().flatten());
        }
    }
    of_meshes(ground.lattice, cells, ids.into_iter().map(|id| build(&ground, id)))
}

/// The planet of such patches.
pub(crate) fn of_meshes(lattice: Lattice, cells: u32, meshes: impl Iterator<Item = PatchMesh>) -> Planet {
    let load = |mesh: PatchMesh| {
        let rings = Rings::new(&mesh).expect("the hierarchy replays");
        (mesh.id, (LoadedPatch::new(mesh, &lattice), rings))
    };
    let patches: HashMap<_, _> = meshes.map(load).collect();
    let facts = patches.values().map(|(p, _)| (p.mesh.id, p.mesh.facts));
    let lowest = patches.values().map(|(p, _)| p.mesh.facts.heights[0]).min().expect("six roots");
    Planet { tree: PatchTree::new(lattice, cells, f64::from(lowest), facts), patches }
}

fn build(ground: &Ground, id: PatchId) -> PatchMesh {
    let (mesh, faults) = PatchMesh::build(ground, &HeightGrid::sample(ground, id));
    assert_eq!(faults, Faults::default());
    mesh
}

/// Random views without culling, tolerances in turn.
pub(crate) fn views(planet: &Planet, field: &TestField, count: usize) -> Vec<View> {
    views_over(planet, &|d| field.at(d), count)
}

/// [`views`] over ground whose height is `height`.
pub(crate) fn views_over(planet: &Planet, height: &dyn Fn(DVec3) -> f64, count: usize) -> Vec<View> {
    let cameras = RandomViews::new(&planet.tree, 7, height).take(count);
    let tolerance = |k: usize| [1.0, 0.5, 2.0, 4.0][k % 4];
    cameras
        .enumerate()
        .map(|(k, c)| View::new(c, &planet.tree.lattice, planet.tree.cells, tolerance(k)).without_culling())
        .collect()
}

/// Draws a cut without culling: the report on its surface, and closure violations away from the rim of the data.
pub(crate) fn draw(planet: &Planet, view: &View, cut: &Cut, forget_sides: bool) -> (SurfaceReport, usize) {
    let (check, violations) = surface(planet, view, cut, forget_sides);
    (check.finish(), violations)
}

/// [`draw`], for who says what counts as a crack.
pub(crate) fn surface(planet: &Planet, view: &View, cut: &Cut, forget_sides: bool) -> (SurfaceCheck, usize) {
    let mut check = SurfaceCheck::default();
    let mut violations = 0;
    for leaf in &cut.leaves {
        let (patch, rings) = &planet.patches[&leaf.id];
        let work = patch.reach.work(view);
        let vertices = &patch.vertices[..work.vertices as usize];
        let sides = if forget_sides { 0 } else { u32::from(leaf.coarser_sides) };
        let Selected { awake, drawn_positions } = select(&view.gpu, vertices, sides);
        let triangles = emit(&view.gpu, &patch.triangles(&work), &resolve(vertices, &awake), &drawn_positions);
        check.add(vertices, &drawn_positions, &triangles);
        if !at_data_rim(&planet.tree, leaf) {
            violations += rings.violations(&awake, &drawn_positions);
        }
    }
    (check, violations)
}
