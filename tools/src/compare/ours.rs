//! Our own surfaces, drawn by the CPU's stages.

use super::setting::{CutRule, PatchCache, Setting};
use super::sheet::Sheet;
use super::Method;
use std::sync::Arc;
use terrane_planet::draw::layout::{DrawnVertex, PatchVertex};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::position::exact_position;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::store::StoreError;

/// Wake distances; the knob is the tolerance.
pub(crate) struct Ours {
    patches: Arc<PatchCache<LoadedPatch>>,
    geomorphs: bool,
    /// Tolerance of the cut over the knob.
    cut: f64,
}

/// The triangles of one patch.
pub(crate) struct Drawn<'a> {
    pub(crate) id: PatchId,
    pub(crate) vertices: &'a [PatchVertex],
    pub(crate) drawn_positions: &'a [DrawnVertex],
    pub(crate) triangles: &'a [[u32; 3]],
}

impl Drawn<'_> {
    /// Adds it to what is measured.
    pub(crate) fn measure(&self, sheet: &mut Sheet) {
        sheet.add(
            self.id.face,
            self.vertices.len(),
            |v| exact_position(self.vertices, v, self.drawn_positions[v as usize].weight),
            self.triangles,
        );
    }
}

impl Ours {
    /// With geomorphs, as the run time draws, and without any patch yet.
    pub(crate) fn new() -> Ours {
        Ours { patches: Arc::new(PatchCache::new()), geomorphs: true, cut: 1.0 }
    }

    /// The same with every awake vertex in its own position.
    pub(crate) fn without_geomorphs(&self) -> Ours {
        Ours { patches: self.patches.clone(), geomorphs: false, ..*self }
    }

    /// The same over the patches that the run time would draw with `cut` times the knob as tolerance, at most 1: with finer patches
    /// than there must be, surfaces stay closed and certified.
    pub(crate) fn with_cut(&self, cut: f64) -> Ours {
        Ours { patches: self.patches.clone(), cut, ..*self }
    }

    /// Calls back with every patch that may be in view.
    pub(crate) fn patches(&self, setting: &Setting, view: &View, mut drawn: impl FnMut(&Drawn)) -> Result<(), StoreError> {
        let finer = setting.view(&view.camera, self.cut * view.tolerance);
        for leaf in setting.visible_leaves(&finer, CutRule::AsDrawn) {
            let patch = self.patches.get(leaf.id, || Ok(LoadedPatch::new(setting.read(leaf.id)?, &setting.tree.lattice)))?;
            let work = patch.reach.work(view);
            let vertices = &patch.vertices[..work.vertices as usize];
            let Selected { awake, drawn_positions } = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
            let triangles = emit(&view.gpu, &patch.triangles(&work), &resolve(vertices, &awake), &drawn_positions);
            drawn(&Drawn { id: leaf.id, vertices, drawn_positions: &drawn_positions, triangles: &triangles });
        }
        Ok(())
    }
}

impl Method for Ours {
    fn family(&self) -> &'static str {
        "ours"
    }

    fn variant(&self) -> String {
        let geomorphs = if self.geomorphs { "with" } else { "without" };
        format!("{geomorphs} geomorphs, {}", CutRule::AsDrawn.describe(self.cut))
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let view = setting.view(camera, knob);
        let view = if self.geomorphs { view } else { view.without_geomorphs() };
        self.patches(setting, &view, |drawn| drawn.measure(sheet))
    }
}
