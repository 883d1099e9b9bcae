//! The ground that an edit makes, until it is drawn. All that is drawn is of one ground: patches that the edit reaches are loaded beside those
//! that they replace, and change places with them all at once.
//!
//! In: the cut of the ground that is drawn. Out: what the workers are to do for the next, and when that can be drawn.

use super::edit_worker::NextGround;
use super::loader::{Order, Parts, Request};
use super::resident::ResidentPatch;
use super::wants::wanted_by;
use super::{Scene, Scope};
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::edits::Touched;
use terrane_planet::planet::Planet;
use terrane_planet::query::PatchGrid;

/// Longest time that the ground of before is drawn while a moving view goes on wanting more; then the picture is coarser for a moment.
const PATIENCE: Duration = Duration::from_secs(4);

/// Urgencies of what was drawn: whole faces, then what is known of the patches down to it, then itself, before all that a view wants.
const FACES: f64 = -3.0;
const KNOWN: f64 = -2.0;
const DRAWN: f64 = -1.0;

/// The ground of after an edit, as far as it is there.
pub(super) struct Renewal {
    pub(super) planet: Arc<Planet>,
    pub(super) tree: PatchTree,
    reach: Touched,
    /// The patches on the GPU that take the place of others.
    pub(super) fresh: HashMap<PatchId, ResidentPatch>,
    /// Their ground, and that of others.
    pub(super) grids: HashMap<PatchId, PatchGrid>,
    /// Whether one of them was turned away.
    pub(super) is_full: bool,
    /// Whether it can be drawn.
    is_ready: bool,
    /// Patches that it still lacks.
    pub(super) lacking: usize,
    begun: Instant,
}

impl Renewal {
    /// Whether a patch of this ground is another than that of before.
    pub(super) fn touches(&self, id: PatchId) -> bool {
        self.reach.touches(id)
    }

    /// Whether it can be drawn.
    pub(super) fn is_ready(&self) -> bool {
        self.is_ready
    }
}

impl Scene {
    /// Begins to load the ground of after an edit.
    pub(super) fn begin_renewal(&mut self, next: NextGround) {
        let NextGround { planet, reach, facts, around, loader, keeper, .. } = next;
        let bare = self.supply.bare_tree(&planet);
        let mut tree = bare.with_known(&self.tree, |id| !reach.touches(id));
        facts.iter().for_each(|(id, facts)| tree.insert(*id, facts));
        let (fresh, grids) = (HashMap::new(), HashMap::new());
        let begun = Instant::now();
        // What the workers of before still find is of the ground of before: it goes with them.
        let before = (std::mem::replace(&mut self.loader, loader), std::mem::replace(&mut self.keeper, keeper));
        self.edits.retire(before);
        self.around = around;
        self.renewal = Some(Renewal { planet, tree, reach, fresh, grids, is_full: false, is_ready: false, lacking: 0, begun });
        // All light is of the ground of before.
        self.sun.write().unwrap_or_else(PoisonError::into_inner).number += 1;
    }

    /// Asks for what the ground of after lacks, once that of before is drawn as `drawn`, which shows the textures of `shown`.
    pub(super) fn renew(&mut self, view: &View, drawn: &Cut, shown: &HashSet<PatchId>) {
        let Some((then, renewal)) = self.then().zip(self.renewal.as_ref()) else { return };
        let cut = then.cut(view);
        let next_shown = then.textures_shown(view, &cut);
        let mut orders = self.orders_for_drawn(renewal, view, drawn, shown);
        let asked: HashSet<PatchId> = orders.iter().map(|order| order.0).collect();
        let touched = |id: &PatchId| renewal.touches(*id);
        let mut lacking = asked.clone();
        lacking.extend(cut.wanted.iter().map(|(id, _)| *id).filter(touched));
        lacking.extend(cut.leaves.iter().map(|leaf| leaf.id).filter(|id| touched(id) && !then.is_drawable(view, *id)));
        lacking.extend(next_shown.iter().copied().filter(|id| touched(id) && then.slot(*id).is_none()));
        let has_faces = orders.iter().all(|(id, ..)| id.level > 0);
        let is_late = renewal.is_full || renewal.begun.elapsed() > PATIENCE;
        let is_ready = has_faces && (lacking.is_empty() || is_late);
        orders.extend(then.orders(view, &cut, &next_shown).into_iter().filter(|order| !asked.contains(&order.0)));
        self.loader.request(orders);
        self.mark_used(&cut, &next_shown);
        if let Some(renewal) = &mut self.renewal {
            (renewal.is_ready, renewal.lacking) = (is_ready, lacking.len());
        }
    }

    /// What takes the place of what is drawn, most likely: so much is asked for at once, where a search would learn of one level after
    /// the other. And the whole faces, without which nothing can be drawn.
    fn orders_for_drawn(&self, renewal: &Renewal, view: &View, drawn: &Cut, shown: &HashSet<PatchId>) -> Vec<Order> {
        let fresh = |id: &PatchId| renewal.fresh.get(id);
        let lacks = |id: &PatchId, texture: bool| Parts {
            mesh: fresh(id).is_none_or(|patch| patch.mesh.as_ref().is_none_or(|mesh| !mesh.suffices(view))),
            texture: texture && fresh(id).is_none_or(|patch| patch.slot.is_none()),
        };
        let snapshot = Arc::new(*view);
        let mut orders: HashMap<PatchId, Order> = HashMap::new();
        let mut order = |id: PatchId, parts: Parts, view, urgency| {
            orders.entry(id).or_insert((id, Request::Load(parts, view), urgency));
        };
        for id in PatchId::roots().filter(|&id| renewal.touches(id)) {
            let parts = Parts { mesh: fresh(&id).is_none_or(|p| p.mesh.is_none()), ..lacks(&id, self.has_textures) };
            if parts != Parts::default() {
                order(id, parts, None, FACES);
            }
        }
        for id in drawn.leaves.iter().map(|leaf| leaf.id).filter(|&id| renewal.touches(id)) {
            let parts = lacks(&id, shown.contains(&id));
            if parts != Parts::default() {
                order(id, parts, Some(snapshot.clone()), DRAWN);
            }
        }
        let needs_ground = self.scope == Scope::Flight;
        let unknown = |id: &PatchId| renewal.tree.get(*id).is_none() || (needs_ground && !renewal.grids.contains_key(id));
        let above = wanted_by(drawn).chain(self.underfoot(view)).filter(|id| renewal.touches(*id));
        for id in above {
            let parts = Parts { mesh: false, texture: lacks(&id, shown.contains(&id)).texture };
            if unknown(&id) || parts.texture {
                order(id, parts, None, KNOWN + f64::from(id.level) / 64.0);
            }
        }
        orders.into_values().collect()
    }

    /// The patches that say where the ground below the viewer is.
    fn underfoot(&self, view: &View) -> Vec<PatchId> {
        let known = &self.ground.known;
        let Some(finest) = known.height_at(view.eye).filter(|_| self.scope == Scope::Flight) else { return Vec::new() };
        let below = std::iter::successors(Some(PatchId::containing(view.eye.normalize(), finest.level)), |id| id.parent());
        let siblings = below.flat_map(|id| id.parent().and_then(PatchId::children).unwrap_or([id; 4]));
        siblings.filter(|&id| known.contains(id)).collect()
    }

    /// Puts the ground of after in place of that of before, once it is ready.
    pub(super) fn finish_renewal(&mut self) {
        let Some(Renewal { planet, tree, reach, fresh, grids, .. }) = self.renewal.take_if(|renewal| renewal.is_ready) else {
            return;
        };
        let going: Vec<PatchId> = self.resident.keys().copied().filter(|&id| reach.touches(id)).collect();
        going.into_iter().for_each(|id| self.remove(id));
        self.ground.known.forget(|id| reach.touches(id));
        for grid in grids.into_values() {
            self.ground.known.insert(grid);
        }
        let frame = self.frame;
        self.resident.extend(fresh.into_iter().map(|(id, patch)| (id, ResidentPatch { last_used: frame, ..patch })));
        (self.planet, self.tree) = (planet, tree);
        if self.scope == Scope::Flight {
            // Whoever edits waits for it; only now others go first again.
            self.loader.step_back();
        }
        self.edits.is_drawn(&self.supply, &self.planet);
    }
}
