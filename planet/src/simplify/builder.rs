//! The queue of collapses: always the vertex whose wake is smallest, until only fixed vertices are left.

use super::border_rules::{BorderRules, Kind};
use super::fan::Fan;
use super::guard::Guard;
use super::mesh::NONE;
use super::state::State;
use super::surface::Surface;
use crate::border::ROUNDING;
use crate::wake::{Wake, PROPAGATION_MARGIN};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The finished hierarchy of one patch, by vertex number.
pub struct Hierarchy {
    /// Wake next to equal or finer neighbours.
    pub own: Vec<Wake>,
    /// Wake next to a coarser neighbour (equal to `own` away from the parent's boundary).
    pub coarser: Vec<Wake>,
    /// The vertex each one collapsed into; itself if it never did.
    pub parent: Vec<u32>,
    /// Vertices in order of collapse.
    pub order: Vec<u32>,
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

/// A collapse chosen for a vertex.
#[derive(Clone, Copy)]
struct Choice {
    into: u32,
    error: f64,
}

struct Builder<'a> {
    state: State<'a>,
    kappa: f64,
    /// Wake that the vertices already collapsed ask of each vertex.
    reached: Vec<f64>,
    version: Vec<u32>,
    queue: BinaryHeap<Reverse<(u64, u32, u32)>>,
    result: Hierarchy,
    guard: Guard,
    fan: Fan,
    ring: Vec<u32>,
    closed: bool,
    below: Vec<u32>,
    neighbours: Vec<u32>,
    star: Vec<u32>,
    changed: Vec<u32>,
}

/// Simplifies a patch down to its fixed vertices. `kappa`: radians of error per unit of distance that a wake allows.
pub fn build(surface: &Surface, rules: BorderRules, kappa: f64) -> Hierarchy {
    let count = surface.len();
    let result = Hierarchy {
        own: rules.own.clone(),
        coarser: rules.coarser.clone(),
        parent: (0..count as u32).collect(),
        order: Vec::with_capacity(count),
        faults: Faults::default(),
    };
    let mut builder = Builder {
        state: State::new(surface, rules),
        kappa,
        reached: vec![0.0; count],
        version: vec![0; count],
        queue: BinaryHeap::with_capacity(8 * count),
        result,
        guard: Guard::default(),
        fan: Fan::default(),
        ring: Vec::new(),
        closed: false,
        below: Vec::new(),
        neighbours: Vec::new(),
        star: Vec::new(),
        changed: Vec::new(),
    };
    builder.run();
    builder.result
}

impl Builder<'_> {
    fn run(&mut self) {
        (0..self.reached.len() as u32).for_each(|v| self.enqueue(v));
        while let Some(Reverse((key, v, version))) = self.queue.pop() {
            if self.state.is_alive(v) && self.version[v as usize] == version {
                self.try_collapse(v, f64::from_bits(key));
            }
        }
        self.count_stuck();
    }

    /// Puts a vertex into the queue with its present wake, if it has any legal collapse.
    fn enqueue(&mut self, v: u32) {
        if self.state.kind(v) == Kind::Fixed {
            return;
        }
        self.gather(v);
        if let Some(choice) = self.choose(v, false) {
            let key = self.key(v, choice.error);
            self.queue.push(Reverse((key.to_bits(), v, self.version[v as usize])));
        }
    }

    /// Fills ring and samples of a vertex's star.
    fn gather(&mut self, v: u32) {
        self.closed = self.state.mesh.ring(v, &mut self.ring);
        self.below.clear();
        self.below.push(v);
        self.state.samples_below_star(v, &mut self.below);
    }

    fn longest_edge(&self, v: u32) -> f64 {
        self.ring.iter().map(|&r| self.state.surface.distance(v, r)).fold(0.0, f64::max)
    }

    /// What this vertex's own error and star ask for.
    fn demand(&self, v: u32, error: f64) -> f64 {
        (error + ROUNDING) / self.kappa + self.longest_edge(v)
    }

    fn key(&self, v: u32, error: f64) -> f64 {
        match self.state.kind(v) {
            Kind::Border => self.state.rules.key[v as usize],
            _ => self.demand(v, error).max(self.reached[v as usize]),
        }
    }

    /// The legal collapse of least error of the gathered vertex; `guarded` also asks the border guards.
    fn choose(&mut self, v: u32, guarded: bool) -> Option<Choice> {
        if self.state.kind(v) == Kind::Border {
            return self.choose_border(v);
        }
        let ring_sides = self
            .ring
            .iter()
            .filter(|&&r| self.state.kind(r) == Kind::Border)
            .fold(0, |all, &r| all | self.state.rules.sides[r as usize]);
        let mut best: Option<Choice> = None;
        for k in 0..self.ring.len() {
            let p = self.ring[k];
            let joins_sides = self.state.kind(p) == Kind::Border && ring_sides & !self.state.rules.sides[p as usize] != 0;
            if joins_sides || !self.state.fan_after(&self.ring, self.closed, p, &mut self.fan) || !self.link_condition(p) {
                continue;
            }
            let limit = best.map_or(f64::INFINITY, |b| b.error);
            let Some(error) = self.fan.largest_error(self.state.surface, &self.below, limit) else { continue };
            if !guarded || self.guard.allows(&self.state, v, p, &self.ring, self.kappa) {
                best = Some(Choice { into: p, error });
            }
        }
        best
    }

    /// Rule 2: a border vertex falls to its target, once it stands alone between its two line neighbours.
    fn choose_border(&mut self, b: u32) -> Option<Choice> {
        let (target, other) = (self.state.rules.target[b as usize], self.state.rules.other[b as usize]);
        let ready = self.ring.contains(&target) && self.ring.contains(&other);
        if !ready || !self.state.fan_after(&self.ring, self.closed, target, &mut self.fan) || !self.link_condition(target) {
            return None;
        }
        let error = self.fan.largest_error(self.state.surface, &self.below, f64::INFINITY)?;
        Some(Choice { into: target, error })
    }

    /// The common neighbours of the gathered vertex and p are exactly those of the triangles on their edge.
    fn link_condition(&mut self, p: u32) -> bool {
        self.state.mesh.ring(p, &mut self.neighbours);
        let common = self.neighbours.iter().filter(|r| self.ring.contains(r)).count();
        common == if self.closed { 2 } else { 1 }
    }

    /// Rule 3: the largest wake an interior vertex may have while these border vertices are in its ring.
    fn border_limit(&self, v: u32) -> f64 {
        let limit = |&r: &u32| {
            self.state.rules.low[r as usize] / PROPAGATION_MARGIN - self.state.surface.distance(v, r) * PROPAGATION_MARGIN
        };
        self.ring.iter().filter(|&&r| self.state.kind(r) == Kind::Border).map(limit).fold(f64::INFINITY, f64::min)
    }

    fn interior_wake(&self, v: u32, error: f64) -> Wake {
        Wake::round_up(self.demand(v, error).max(self.reached[v as usize]))
    }

    /// Collapses `v` if guards and border wakes allow it now. If not it waits: a change of its ring queues it again.
    fn try_collapse(&mut self, v: u32, key: f64) {
        if self.state.kind(v) == Kind::Fixed {
            return;
        }
        self.gather(v);
        let limit = match self.state.kind(v) {
            Kind::Interior => self.border_limit(v),
            _ => f64::INFINITY,
        };
        let beside_border = limit < f64::INFINITY;
        if beside_border {
            let Some(easiest) = self.choose(v, false) else { return };
            if self.interior_wake(v, easiest.error).distance() > limit {
                return;
            }
        }
        let Some(choice) = self.choose(v, true) else { return };
        if beside_border {
            let risen = self.key(v, choice.error);
            if risen > key * (1.0 + 1e-4) {
                self.queue.push(Reverse((risen.to_bits(), v, self.version[v as usize])));
                return;
            }
            if self.interior_wake(v, choice.error).distance() > limit {
                return;
            }
        }
        self.perform_collapse(v, choice);
    }

    fn perform_collapse(&mut self, v: u32, choice: Choice) {
        let wake = self.assign_wake(v, choice.error);
        for &r in &self.ring {
            let asked = (wake + self.state.surface.distance(v, r)) * PROPAGATION_MARGIN;
            let reached = &mut self.reached[r as usize];
            *reached = reached.max(asked);
        }
        if self.state.rules.last[v as usize] {
            for &r in self.ring.iter().filter(|&&r| self.state.rules.sides[r as usize] == 0) {
                self.state.rules.kind[r as usize] = Kind::Fixed;
            }
        }
        self.result.parent[v as usize] = choice.into;
        self.result.order.push(v);
        self.state.fan_after(&self.ring, self.closed, choice.into, &mut self.fan);
        self.state.collapse(v, choice.into, &self.fan, &self.below, &mut self.star);
        std::mem::swap(&mut self.ring, &mut self.changed);
        for k in 0..self.changed.len() {
            let r = self.changed[k];
            self.version[r as usize] += 1;
            self.enqueue(r);
        }
    }

    /// Records the wake of a vertex about to collapse and returns the one to propagate.
    fn assign_wake(&mut self, v: u32, error: f64) -> f64 {
        let demand = self.demand(v, error);
        let (certified, propagated) = match self.state.kind(v) {
            Kind::Border => (self.state.rules.low[v as usize], self.state.rules.high[v as usize]),
            _ => {
                let wake = self.interior_wake(v, error);
                self.result.own[v as usize] = wake;
                self.result.coarser[v as usize] = wake;
                (wake.distance(), wake.distance())
            }
        };
        if demand > certified * (1.0 + 1e-9) {
            self.result.faults.uncertified += 1;
        }
        propagated
    }

    /// What is left stays awake; anything left that no rule fixes is a fault.
    fn count_stuck(&mut self) {
        for v in 0..self.reached.len() {
            if self.state.mesh.outgoing[v] == NONE {
                continue;
            }
            self.result.own[v] = Wake::ALWAYS;
            self.result.coarser[v] = Wake::ALWAYS;
            match self.state.rules.kind[v] {
                Kind::Border => self.result.faults.stuck_border += 1,
                Kind::Interior => self.result.faults.stuck_interior += 1,
                Kind::Fixed => {}
            }
        }
    }
}
