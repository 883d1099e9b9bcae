//! Our own surfaces, drawn by the CPU's stages.

use super::setting::{CutRule, PatchCache, Setting};
use super::sheet::Sheet;
use super::Method;
use glam::IVec3;
use terrane_planet::layout::PatchVertex;
use terrane_planet::patch::PatchId;
use terrane_planet::reference::cut::distance_to_box;
use terrane_planet::reference::{emit::emit, resolve::resolve, select::select};
use terrane_planet::store::StoreError;
use terrane_planet::verify::LoadedPatch;
use terrane_planet::view::{Camera, View};

/// Wake distances; the knob is the tolerance.
pub(crate) struct Ours {
    patches: PatchCache<LoadedPatch>,
}

impl Ours {
    /// Without any patch yet.
    pub(crate) fn new() -> Ours {
        Ours { patches: PatchCache::new() }
    }

    /// Vertices and triangles of every patch that may be in view.
    pub(crate) fn patches(
        &self,
        setting: &Setting,
        view: &View,
        mut drawn: impl FnMut(PatchId, &[PatchVertex], &[[u32; 3]]),
    ) -> Result<(), StoreError> {
        for leaf in setting.visible_leaves(view, CutRule::AsDrawn) {
            let patch = self.patches.get(leaf.id, || Ok(LoadedPatch::new(setting.read(leaf.id)?, &setting.tree.lattice)))?;
            let level = patch.reach.level_for(distance_to_box(view, &patch.mesh.bounds), view.scale);
            let vertices = &patch.vertices[..level.vertices as usize];
            let awake = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
            let triangles = emit(&view.gpu, vertices, patch.triangles(level), &resolve(vertices, &awake));
            drawn(leaf.id, vertices, &triangles);
        }
        Ok(())
    }
}

impl Method for Ours {
    fn family(&self) -> &'static str {
        "ours"
    }

    fn variant(&self) -> String {
        "wake distances".into()
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        self.patches(setting, &setting.view(camera, knob), |id, vertices, triangles| {
            let position = |v: u32| IVec3::from_array(vertices[v as usize].position).as_dvec3();
            sheet.add(id.face, vertices.len(), position, triangles);
        })
    }
}
