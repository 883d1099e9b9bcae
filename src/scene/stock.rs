//! What is on the GPU of a ground: of the one that is drawn, or of the one that an edit is about to put in its place. Patches that an edit
//! does not reach belong to both.
//!
//! In: a view. Out: the cut, the textures that it shows, and what it lacks.

use super::renewal::Renewal;
use super::resident::{ResidentMesh, ResidentPatch};
use super::{PatchTextures, Scene, Scope};
use std::collections::{HashMap, HashSet};
use terrane_planet::draw::cut::{cut_by, cut_in_sight, shows_through, texture_level, urgency_within, Cut};
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;

/// A ground's patches on the GPU.
pub(super) struct Stock<'a> {
    pub(super) tree: &'a PatchTree,
    resident: &'a HashMap<PatchId, ResidentPatch>,
    /// What takes the place of some of them.
    renewal: Option<&'a Renewal>,
    has_textures: bool,
    pub(super) scope: Scope,
    pub(super) is_far: bool,
    share: f64,
}

impl Scene {
    /// The ground that is drawn.
    pub(super) fn now(&self) -> Stock<'_> {
        Stock {
            tree: &self.tree,
            resident: &self.resident,
            renewal: None,
            has_textures: self.has_textures,
            scope: self.scope,
            is_far: self.is_far,
            share: self.share,
        }
    }

    /// The ground that is to be drawn next, while an edit is under way.
    pub(super) fn then(&self) -> Option<Stock<'_>> {
        self.renewal.as_ref().map(|renewal| Stock { tree: &renewal.tree, renewal: Some(renewal), ..self.now() })
    }
}

impl<'a> Stock<'a> {
    pub(super) fn get(&self, id: PatchId) -> Option<&'a ResidentPatch> {
        match self.renewal {
            Some(renewal) if renewal.touches(id) => renewal.fresh.get(&id),
            _ => self.resident.get(&id),
        }
    }

    /// Whether it is of the ground that is to be drawn next: what only later views need of it can wait until it is drawn.
    pub(super) fn is_next(&self) -> bool {
        self.renewal.is_some()
    }

    pub(super) fn mesh(&self, id: PatchId) -> Option<&'a ResidentMesh> {
        self.get(id)?.mesh.as_ref()
    }

    pub(super) fn slot(&self, id: PatchId) -> Option<u32> {
        self.get(id)?.slot
    }

    /// The cut of a view from what is there.
    pub(super) fn cut(&self, view: &View) -> Cut {
        let drawable = |id| self.mesh(id).is_some_and(|mesh| mesh.suffices(view));
        match self.scope {
            Scope::Whole => cut_by(self.tree, &|id, node| urgency_within(self.tree, view, id, node, self.share), &drawable),
            Scope::Still | Scope::Flight => cut_in_sight(self.tree, view, self.scope == Scope::Flight, self.share, &drawable),
        }
    }

    /// The textures that a view draws a patch with: of the level that is fine enough, or coarser as long as those are not there.
    pub(super) fn textures_of(&self, view: &View, id: PatchId) -> PatchTextures {
        let mut at = Some(self.textures_wanted(view, id));
        while let Some(patch) = at {
            if let Some(slot) = self.slot(patch) {
                return PatchTextures { patch, slot };
            }
            at = patch.parent();
        }
        PatchTextures { patch: id, slot: 0 }
    }

    /// The patch whose textures a view would draw a patch with.
    pub(super) fn textures_wanted(&self, view: &View, id: PatchId) -> PatchId {
        let level = self.tree.get(id).map_or(id.level, |node| texture_level(self.tree, view, id.level, &node.space));
        id.ancestor(level)
    }

    /// Whether a patch can be drawn in a view: with all of its mesh that this can wake, and textures of its own or of an ancestor.
    pub(super) fn is_drawable(&self, view: &View, id: PatchId) -> bool {
        self.mesh(id).is_some_and(|mesh| mesh.suffices(view)) && self.has_textures_for(view, id)
    }

    /// Whether there are any textures to draw a patch with, if there are to be any.
    pub(super) fn has_textures_for(&self, view: &View, id: PatchId) -> bool {
        if !self.has_textures {
            return true;
        }
        let above = std::iter::successors(Some(self.textures_wanted(view, id)), |id| id.parent());
        above.into_iter().any(|patch| self.slot(patch).is_some())
    }

    /// The patches whose textures the drawn ones show.
    pub(super) fn textures_shown(&self, view: &View, cut: &Cut) -> HashSet<PatchId> {
        let mut shown = HashSet::new();
        for leaf in cut.leaves.iter().filter(|_| self.has_textures) {
            let patch = self.textures_wanted(view, leaf.id);
            let coarser = patch.parent().filter(|parent| {
                self.tree.get(leaf.id).is_some_and(|node| shows_through(self.tree, view, parent.level, &node.space))
            });
            shown.extend([patch].into_iter().chain(coarser));
        }
        shown
    }
}
