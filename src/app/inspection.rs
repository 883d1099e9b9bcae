//! What is at a site: the patch that is drawn there, and what is known of it.

use crate::frame::FrameTables;
use crate::scene::Scene;
use glam::DVec3;
use std::collections::HashSet;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::latitude_longitude;

/// What is known of a site and of the patch that is drawn there.
#[derive(Clone, Copy, Debug)]
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
}

/// What is drawn in a direction from the planet's centre. None if nothing is.
pub(super) fn inspect(scene: &Scene, view: &View, tables: &FrameTables, site: DVec3) -> Option<Inspected> {
    let drawn: HashSet<PatchId> = tables.leaves.iter().map(|leaf| leaf.id).collect();
    let deepest = drawn.iter().map(|id| id.level).max()?;
    let patch = (0..=deepest).rev().map(|level| PatchId::containing(site, level)).find(|id| drawn.contains(id))?;
    let at = tables.leaves.iter().position(|leaf| leaf.id == patch)?;
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
    })
}
