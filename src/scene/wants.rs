//! What a scene wants for a view: which meshes and textures, in which order, and what is left out where memory is short.

use super::loader::{Order, Parts, Request};
use super::options::Scope;
use super::stock::Stock;
use super::Scene;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, PoisonError};
use terrane_planet::draw::cut::{cut, Cut};
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;

/// How much nearer patches split each time that one was turned away, all resident ones being in use.
const NEARER: f64 = 0.7;

/// How much farther they split again in every frame in which less than so much of the room is taken.
const FARTHER: f64 = 1.02;
const ROOMY: f64 = 0.6;

/// Patches of which something is known, past which those that nothing needs any more are forgotten.
const MOST_KNOWN: usize = 100_000;

/// Urgency of textures without their mesh: after all that is seen of the mesh, the urgency of which is below 1.
const AFTER_MESHES: f64 = 1.0;

/// Updates from one look around to the next: it takes as long as choosing what to draw.
const LOOKS_EVERY: u64 = 16;

/// All that a view would draw, and their ancestors.
pub(super) fn wanted_by(cut: &Cut) -> impl Iterator<Item = PatchId> + '_ {
    cut.ideal.iter().copied().chain(cut.above.iter().map(|(id, _)| *id))
}

impl Scene {
    /// Of the patches whose textures are shown, those whose light is that of an earlier sun.
    pub(super) fn stale(&self, shown: &HashSet<PatchId>) -> Vec<PatchId> {
        let number = self.sun.read().unwrap_or_else(PoisonError::into_inner).number;
        let of_earlier = |id: &&PatchId| self.resident.get(id).is_some_and(|patch| patch.slot.is_some() && patch.sun != number);
        shown.iter().filter(of_earlier).copied().collect()
    }

    /// Where not all fits that the view wants, patches split nearer, until it does.
    pub(super) fn keep_within_budget(&mut self) {
        if std::mem::take(&mut self.full) {
            self.share *= NEARER;
        } else if self.is_roomy() {
            self.share = (self.share * FARTHER).min(1.0);
        }
    }

    /// Whether a good part of the room for patches is free.
    pub(super) fn is_roomy(&self) -> bool {
        let shares = [self.resident.len() as f64 / self.capacity as f64, self.mesh_bytes as f64 / self.most_mesh_bytes as f64];
        shares.iter().all(|&taken| taken < ROOMY)
    }

    /// Whether the latest picture is coarser than its view wants, because no more fits.
    pub fn is_limited(&self) -> bool {
        self.share < 1.0
    }

    /// Asks now and then for what the view would draw out of sight: whoever turns around finds it.
    pub(super) fn look_around(&self, view: &View) {
        if self.frame.is_multiple_of(LOOKS_EVERY) {
            let around = cut(&self.tree, view, &|id| self.mesh(id).is_some());
            let snapshot = Arc::new(*view);
            let explore = |(id, urgency)| (id, Request::Explore(snapshot.clone()), urgency);
            self.loader.request(around.wanted.into_iter().map(explore).collect());
        }
    }

    /// Forgets patches that neither the view needs nor the GPU holds, when many are known.
    pub(super) fn forget_unused(&mut self, cut: &Cut) {
        if self.tree.len() > MOST_KNOWN {
            let used: HashSet<PatchId> = wanted_by(cut).collect();
            let resident = &self.resident;
            self.tree.forget_but(|id| id.level == 0 || used.contains(&id) || resident.contains_key(&id));
        }
    }

    /// Notes what the latest cut uses: it is not evicted.
    pub(super) fn mark_used(&mut self, cut: &Cut, shown: &HashSet<PatchId>) {
        // Those that wait for others count as used: taken out to make room for these, they would be asked for for ever.
        let waiting = wanted_by(cut);
        for id in waiting.chain(cut.leaves.iter().map(|leaf| leaf.id)).chain(shown.iter().copied()) {
            if let Some(patch) = self.resident.get_mut(&id) {
                patch.last_used = self.frame;
            }
        }
    }
}

impl Stock<'_> {
    /// What the workers are to do for a view.
    pub(super) fn orders(&self, view: &View, cut: &Cut, shown: &HashSet<PatchId>) -> Vec<Order> {
        let mut meshes: HashMap<PatchId, f64> = cut.wanted.iter().copied().collect();
        if self.scope != Scope::Still && !self.is_next() {
            // Coarse to fine: their urgency is smaller than that of what replaces them.
            meshes.extend(cut.above.iter().copied().filter(|(id, _)| self.mesh(*id).is_none()));
        }
        // What the picture cannot do without, until there is something better; over a line nothing else gets in its way.
        let leaves = || cut.leaves.iter().map(|leaf| leaf.id);
        let bare: HashSet<PatchId> =
            leaves().filter(|id| !self.has_textures_for(view, *id)).map(|id| self.textures_wanted(view, id)).collect();
        let lacking: Vec<PatchId> = leaves().filter(|id| self.mesh(*id).is_none_or(|mesh| !mesh.suffices(view))).collect();
        let first_things_first = self.is_far && !(bare.is_empty() && lacking.is_empty());
        if first_things_first {
            meshes.clear();
        }
        meshes.extend(lacking.into_iter().map(|id| (id, 0.0)));
        let is_missing = |id: &PatchId| self.slot(*id).is_none() && (!first_things_first || bare.contains(id));
        let textures: HashSet<PatchId> = shown.iter().copied().filter(is_missing).collect();
        let snapshot = Arc::new(*view);
        let mesh_order = |(&id, &urgency): (&PatchId, &f64)| {
            let parts = Parts { mesh: true, texture: textures.contains(&id) };
            (
                id,
                if self.tree.get(id).is_some() {
                    Request::Load(parts, Some(snapshot.clone()))
                } else {
                    Request::Explore(snapshot.clone())
                },
                urgency,
            )
        };
        let mut orders: Vec<Order> = meshes.iter().map(mesh_order).collect();
        let only = Parts { mesh: false, texture: true };
        let alone = textures.iter().filter(|id| !meshes.contains_key(id));
        let urgency = |id: &PatchId| if bare.contains(id) { 0.0 } else { AFTER_MESHES };
        orders.extend(alone.map(|id| (*id, Request::Load(only, None), urgency(id))));
        orders
    }
}
