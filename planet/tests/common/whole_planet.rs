//! A whole planet on the CPU with mixed levels, and views of it.

#![allow(dead_code, reason = "every test program uses its own part")]

use crate::common::TestField;
use std::collections::HashMap;
use terrane_planet::ground::{Ground, HeightGrid};
use terrane_planet::patch::PatchId;
use terrane_planet::progressive::PatchMesh;
use terrane_planet::simplify::builder::Faults;
use terrane_planet::tree::{PatchFacts, PatchTree};
use terrane_planet::verify::{LoadedPatch, RandomViews, Rings};
use terrane_planet::view::View;

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
        let near_corner = id.centre().distance(glam::DVec3::new(1.0, 1.0, 1.0).normalize()) < 2.0 / f64::from(1u32 << id.level);
        if id.level < 2 || (id.level < 5 && near_corner) {
            ids.extend(id.children().into_iter().flatten());
        }
    }
    let patches: HashMap<_, _> = ids.into_iter().map(|id| (id, load(&ground, id))).collect();
    let facts = patches.values().map(|(p, _)| PatchFacts::from(&p.mesh));
    let lowest = patches.values().map(|(p, _)| p.mesh.heights[0]).min().expect("six roots");
    Planet { tree: PatchTree::new(ground.lattice, cells, f64::from(lowest), facts), patches }
}

fn load(ground: &Ground, id: PatchId) -> (LoadedPatch, Rings) {
    let (mesh, faults) = PatchMesh::build(ground, id, &HeightGrid::sample(ground, id));
    assert_eq!(faults, Faults::default());
    let rings = Rings::new(&mesh).expect("the hierarchy replays");
    (LoadedPatch::new(mesh, &ground.lattice), rings)
}

/// Random views without culling, tolerances in turn.
pub(crate) fn views(planet: &Planet, field: &TestField, count: usize) -> Vec<View> {
    let height = |d| field.at(d);
    let cameras = RandomViews::new(&planet.tree, 7, &height).take(count);
    let tolerance = |k: usize| [1.0, 0.5, 2.0, 4.0][k % 4];
    cameras
        .enumerate()
        .map(|(k, c)| View::new(c, &planet.tree.lattice, planet.tree.cells, tolerance(k)).without_culling())
        .collect()
}
