//! The queue of collapses of one patch: always the vertex whose wake is smallest, until only fixed vertices are left.
//!
//! The queue is lazy. A collapse only marks its ring as changed; a vertex is looked at again when its turn comes, which is about
//! a third of the work of keeping every key exact. Keys nearly always rise, so a stale one is a lower bound.

use super::border::ROUNDING;
use super::border_rules::{BorderRules, Kind};
use super::guard::{Guard, Patch};
use super::surface::Surface;
use super::wake::{askable, asked, Wake};
use terrane_heightfield::decimate::decimator::Decimator;
use terrane_heightfield::decimate::mesh::NONE;
use terrane_heightfield::decimate::queue::Queue;

/// The finished hierarchy of one patch, by vertex number.
pub struct Hierarchy {
    /// Wake next to equal or finer neighbours.
    pub wake: Vec<Wake>,
    /// Wake next to a coarser neighbour (equal to `wake` away from the parent's boundary).
    pub coarser_wake: Vec<Wake>,
    /// The vertex each one collapsed into; itself if it never did.
    pub parent: Vec<u32>,
    /// Vertices in order of collapse.
    pub order: Vec<u32>,
    /// Wake that each vertex's own error and star asked for when it collapsed, without what vertices that depend on it ask for:
    /// what a selection without dependencies would need. 0 for vertices that never did.
    pub demand: Vec<f32>,
    /// Counts of what went wrong; all zero unless there is a bug.
    pub faults: Faults,
}

/// What the builder's rules exclude; counted to be able to say so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Border vertices that could not collapse.
    pub stuck_border: usize,
    /// Interior vertices left although nothing fixes them.
    pub stuck_interior: usize,
    /// Collapses whose measured error exceeds what their wake certifies.
    pub uncertified: usize,
}

/// What the queue knows of a vertex.
#[derive(Clone, Copy)]
struct Entry {
    /// Wake that the vertices already collapsed ask for.
    reached: f64,
    /// Position in the queue, the wake it had when last looked at.
    key: f32,
    /// The collapse of least error when last looked at.
    into: u32,
    /// Its radial error between samples.
    between: f64,
    /// Whether it waits in the queue (once), and not for a change of its ring.
    queued: bool,
    /// Whether nothing changed around it since `into` was chosen.
    fresh: bool,
}

/// A possible collapse of an interior vertex.
struct Choice {
    into: u32,
    /// About its largest radial error, at samples and between.
    error: f64,
    /// Its largest radial error between samples.
    between: f64,
}

struct Builder<'a> {
    patch: Patch<'a>,
    kappa: f64,
    entries: Vec<Entry>,
    queue: Queue,
    result: Hierarchy,
    guard: Guard,
    rejected: Vec<u32>,
    /// Distances of the gathered ring, and the largest of them.
    distances: Vec<f64>,
    longest: f64,
}

/// Simplifies a patch down to its fixed vertices. `kappa`: radians of error per unit of distance that a wake allows.
pub fn build(surface: &Surface, rules: BorderRules, kappa: f64) -> Hierarchy {
    let count = surface.len();
    let side = surface.cells as usize + 1;
    let result = Hierarchy {
        wake: rules.wake.clone(),
        coarser_wake: rules.coarser_wake.clone(),
        parent: (0..count as u32).collect(),
        order: Vec::with_capacity(count),
        demand: vec![0.0; count],
        faults: Faults::default(),
    };
    let untouched = Entry { reached: 0.0, key: 0.0, into: NONE, between: 0.0, queued: false, fresh: false };
    let mut builder = Builder {
        patch: Patch { surface, rules, decimator: Decimator::new(surface.samples.clone(), side, side) },
        kappa,
        entries: vec![untouched; count],
        queue: Queue::new(),
        result,
        guard: Guard::default(),
        rejected: Vec::new(),
        distances: Vec::new(),
        longest: 0.0,
    };
    builder.run();
    builder.result
}

impl Builder<'_> {
    fn run(&mut self) {
        for v in 0..self.entries.len() as u32 {
            self.entries[v as usize].key = self.first_key(v);
            self.enqueue(v);
        }
        while let Some(v) = self.queue.pop() {
            self.entries[v as usize].queued = false;
            if self.patch.decimator.is_alive(v) {
                match self.patch.kind(v) {
                    Kind::Interior => self.visit_interior(v),
                    Kind::Border => self.visit_border(v),
                    Kind::Fixed => {}
                }
            }
        }
        self.count_stuck();
    }

    /// A lower bound of every interior wake, so that each is looked at before anything collapses.
    fn first_key(&self, v: u32) -> f32 {
        match self.patch.kind(v) {
            Kind::Border => (self.patch.rules.key[v as usize] as f32).min(f32::MAX),
            _ => 0.0,
        }
    }

    /// Puts a vertex into the queue unless it is there.
    fn enqueue(&mut self, v: u32) {
        let kind = self.patch.kind(v);
        let entry = &mut self.entries[v as usize];
        if !entry.queued && kind != Kind::Fixed {
            entry.queued = true;
            self.queue.push(entry.key, 0, v);
        }
    }

    fn gather(&mut self, v: u32) {
        let Patch { decimator, surface, .. } = &mut self.patch;
        decimator.gather(v);
        self.distances.clear();
        self.distances.extend(decimator.star.ring.iter().map(|&r| surface.distance(v, r)));
        self.longest = self.distances.iter().copied().fold(0.0, f64::max);
    }

    /// What the gathered vertex's own error and star ask for.
    fn demand(&self, error: f64) -> f64 {
        (error + ROUNDING) / self.kappa + self.longest
    }

    /// The wake of the gathered interior vertex, before it is rounded, with an error: its own demand, or what it has to reach.
    fn raw_wake(&self, v: u32, error: f64) -> f64 {
        self.demand(error).max(self.entries[v as usize].reached)
    }

    fn interior_wake(&self, v: u32, error: f64) -> Wake {
        Wake::round_up(self.raw_wake(v, error))
    }

    /// Collapses an interior vertex if it is its turn, puts it back if its key has risen, or leaves it to wait for a change of its
    /// ring where it has no way to go.
    fn visit_interior(&mut self, v: u32) {
        let entry = &mut self.entries[v as usize];
        entry.key = entry.key.max(entry.reached as f32);
        if !self.queue.is_due(entry.key) {
            return self.enqueue(v);
        }
        self.gather(v);
        if !self.entries[v as usize].fresh && self.look_again(v) {
            return;
        }
        let beside_border = self.patch.decimator.star.ring.iter().any(|&r| self.patch.kind(r) == Kind::Border);
        if beside_border {
            self.collapse_beside_border(v);
        } else {
            let Entry { into, between, .. } = self.entries[v as usize];
            let error = self.measure(v, into).max(between);
            if !self.waits_its_turn(v, error) {
                self.perform_collapse(v, into, error, self.interior_wake(v, error));
            }
        }
    }

    /// Ranks the gathered vertex anew; true if that ends its turn.
    fn look_again(&mut self, v: u32) -> bool {
        self.rejected.clear();
        let Some(choice) = self.rank(v) else { return true };
        let key = self.raw_wake(v, choice.error) as f32;
        let entry = &mut self.entries[v as usize];
        (entry.into, entry.between, entry.fresh, entry.key) = (choice.into, choice.between, true, entry.key.max(key));
        let risen = !self.queue.is_due(key);
        if risen {
            self.enqueue(v);
        }
        risen
    }

    /// The legal collapse of least error of the gathered interior vertex, without those rejected.
    fn rank(&mut self, v: u32) -> Option<Choice> {
        let Patch { rules, decimator, surface } = &mut self.patch;
        let is_border = |r: u32| rules.kind[r as usize] == Kind::Border;
        let ring_sides = decimator.star.ring.iter().filter(|&&r| is_border(r)).fold(0, |all, &r| all | rules.sides[r as usize]);
        let rejected = &self.rejected;
        let joins_sides = |p: u32| is_border(p) && ring_sides & !rules.sides[p as usize] != 0;
        let leaves_side = |p: u32| rules.sides[v as usize] & !rules.sides[p as usize] != 0;
        let allowed = |p: u32| !joins_sides(p) && !leaves_side(p) && !rejected.contains(&p);
        // About how much depth makes a lattice unit of height.
        let own = surface.samples.at(v).q;
        let unit = own / surface.distance_from_centre(v);
        let best = decimator.rank_between(allowed, |s, own, depth| surface.radial_error(s, own, depth), unit)?;
        Some(Choice { into: best.into, error: f64::from(best.error) / unit, between: best.between })
    }

    /// Puts the gathered vertex back if the measured error of its collapse asks for more than it was ranked with, and says so.
    fn waits_its_turn(&mut self, v: u32, error: f64) -> bool {
        let key = self.raw_wake(v, error) as f32;
        let waits = !self.queue.is_due(key);
        if waits {
            let entry = &mut self.entries[v as usize];
            (entry.key, entry.between) = (key, error);
            self.enqueue(v);
        }
        waits
    }

    /// Largest radial error at samples of the gathered vertex's collapse, and of every position on the way.
    fn measure(&mut self, v: u32, into: u32) -> f64 {
        let surface = self.patch.surface;
        let error = |s: u32, own: f64, depth: f64| surface.radial_error(s, own, depth);
        self.patch.decimator.measure(into, error).max(self.patch.decimator.measure_slide(v, into, error))
    }

    /// Rules 3 to 5: with border vertices in its ring, a vertex waits for them and must leave them able to fall.
    fn collapse_beside_border(&mut self, v: u32) {
        let limit = self.border_limit();
        let Entry { mut into, mut between, .. } = self.entries[v as usize];
        self.rejected.clear();
        loop {
            let error = self.measure(v, into).max(between);
            let wake = self.interior_wake(v, error);
            if wake.distance() > limit {
                return self.wait(v);
            }
            if self.guard.allows(&self.patch, v, into, self.kappa) {
                return self.perform_collapse(v, into, error, wake);
            }
            self.rejected.push(into);
            let Some(other) = self.rank(v) else { return self.wait(v) };
            let key = self.raw_wake(v, other.error) as f32;
            if !self.queue.is_due(key) {
                // A worse way than the one it was queued for: its turn comes later.
                let entry = &mut self.entries[v as usize];
                (entry.key, entry.fresh) = (key, false);
                return self.enqueue(v);
            }
            (into, between) = (other.into, other.between);
        }
    }

    /// Leaves a vertex out of the queue until its ring changes.
    fn wait(&mut self, v: u32) {
        self.entries[v as usize].fresh = false;
    }

    /// Rule 3: the largest wake an interior vertex may have while these border vertices are in its ring.
    fn border_limit(&self) -> f64 {
        let patch = &self.patch;
        let ring = patch.decimator.star.ring.iter().zip(&self.distances);
        let limit = |(&r, &distance): (&u32, &f64)| askable(patch.rules.low[r as usize], distance);
        ring.filter(|(&r, _)| patch.kind(r) == Kind::Border).map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Rule 2: a border vertex falls to its target, once it stands alone between its two line neighbours.
    fn visit_border(&mut self, b: u32) {
        let (target, other) = (self.patch.rules.target[b as usize], self.patch.rules.other[b as usize]);
        self.gather(b);
        let decimator = &self.patch.decimator;
        let ready = decimator.star.ring.contains(&target) && decimator.star.ring.contains(&other);
        if !ready || !decimator.is_open(target) {
            return;
        }
        let Patch { decimator, surface, .. } = &self.patch;
        let between =
            decimator.samples.error_between(&decimator.star.ring, target, |s, own, depth| surface.radial_error(s, own, depth));
        let error = self.measure(b, target).max(between);
        if self.demand(error) > self.patch.rules.low[b as usize] * (1.0 + 1e-9) {
            self.result.faults.uncertified += 1;
        }
        self.perform_collapse(b, target, error, Wake::ASLEEP);
    }

    /// Collapses the vertex gathered and measured last. `interior` is its wake, unless its border gives it one.
    fn perform_collapse(&mut self, v: u32, into: u32, error: f64, interior: Wake) {
        let wake = if self.patch.kind(v) == Kind::Interior {
            self.result.wake[v as usize] = interior;
            self.result.coarser_wake[v as usize] = interior;
            interior.distance()
        } else {
            self.patch.rules.high[v as usize]
        };
        self.result.demand[v as usize] = self.demand(error) as f32;
        self.result.parent[v as usize] = into;
        self.result.order.push(v);
        self.patch.decimator.collapse(v, into);
        for k in 0..self.patch.decimator.star.ring.len() {
            let r = self.patch.decimator.star.ring[k];
            if self.patch.rules.last[v as usize] && self.patch.rules.sides[r as usize] == 0 {
                self.patch.rules.kind[r as usize] = Kind::Fixed;
            }
            let entry = &mut self.entries[r as usize];
            entry.reached = entry.reached.max(asked(wake, self.distances[k]));
            entry.fresh = false;
            self.enqueue(r);
        }
    }

    fn is_enclosed(&mut self, v: u32) -> bool {
        self.gather(v);
        let patch = &self.patch;
        let ring = &patch.decimator.star.ring;
        ring.iter().all(|&r| patch.kind(r) == Kind::Fixed && !patch.decimator.is_open(r))
    }

    /// What is left stays awake; anything left that no rule fixes is a fault. A vertex among fixed ones only, none of which sees its
    /// whole ring, is as fixed as they are: some millions hold one, between the rings of two mid-edge vertices.
    fn count_stuck(&mut self) {
        for v in 0..self.entries.len() {
            if !self.patch.decimator.is_alive(v as u32) {
                continue;
            }
            self.result.wake[v] = Wake::ALWAYS;
            self.result.coarser_wake[v] = Wake::ALWAYS;
            match self.patch.kind(v as u32) {
                Kind::Border => self.result.faults.stuck_border += 1,
                Kind::Interior if self.is_enclosed(v as u32) => {}
                Kind::Interior => self.result.faults.stuck_interior += 1,
                Kind::Fixed => {}
            }
        }
    }
}
