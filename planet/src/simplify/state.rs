//! The mesh of a patch while it is being simplified: connectivity, rules, and the samples below every triangle.

use super::border_rules::{BorderRules, Kind};
use super::fan::Fan;
use super::mesh::{next, previous, Mesh, NONE};
use super::surface::{Surface, LEAST_AREA};

/// A patch mesh between two collapses.
pub struct State<'a> {
    /// The patch's samples.
    pub surface: &'a Surface,
    /// Border rules; kinds change as mid-edge vertices go.
    pub rules: BorderRules,
    /// Current connectivity.
    pub mesh: Mesh,
    first_sample: Vec<u32>,
    next_sample: Vec<u32>,
}

impl<'a> State<'a> {
    /// The full grid, with no sample removed yet.
    pub fn new(surface: &'a Surface, rules: BorderRules) -> Self {
        let mesh = Mesh::grid(surface.cells);
        let first_sample = vec![NONE; mesh.triangle_slots()];
        State { surface, rules, mesh, first_sample, next_sample: vec![NONE; surface.len()] }
    }

    /// Whether a vertex still exists.
    pub fn is_alive(&self, v: u32) -> bool {
        self.mesh.outgoing[v as usize] != NONE
    }

    /// Kind of a vertex.
    pub fn kind(&self, v: u32) -> Kind {
        self.rules.kind[v as usize]
    }

    /// Appends the removed samples below all triangles of `v`'s star.
    pub fn samples_below_star(&self, v: u32, samples: &mut Vec<u32>) {
        for e in self.mesh.star(v) {
            let mut s = self.first_sample[(e / 3) as usize];
            while s != NONE {
                samples.push(s);
                s = self.next_sample[s as usize];
            }
        }
    }

    /// Fills `fan` with the triangles that replace `v`'s star after `v` → `p`; false if one would turn over or vanish.
    pub fn fan_after(&self, ring: &[u32], closed: bool, p: u32, fan: &mut Fan) -> bool {
        let samples = &self.surface.samples;
        fan.start(&samples[p as usize]);
        let pairs = if closed { ring.len() } else { ring.len() - 1 };
        (0..pairs).all(|k| {
            let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
            a == p || b == p || fan.push(&samples[a as usize], &samples[b as usize]) > LEAST_AREA
        })
    }

    /// Triangles (b, x, y) of the star of `b` as they will be after `v` → `p`.
    pub fn star_after(&self, b: u32, v: u32, p: u32, star: &mut Vec<(u32, u32)>) {
        star.clear();
        let moved = |x: u32| if x == v { p } else { x };
        let mut add = |e: u32| {
            let (x, y) = (moved(self.mesh.corner[next(e) as usize]), moved(self.mesh.corner[previous(e) as usize]));
            if x != b && y != b && x != y {
                star.push((x, y));
            }
        };
        self.mesh.star(b).for_each(&mut add);
        if p == b {
            self.mesh.star(v).for_each(&mut add);
        }
    }

    /// Collapses `v` into `p`: `fan` holds the new triangles (from [`State::fan_after`]), `below` the samples of the old star and
    /// `v` itself, `star` is scratch space.
    pub fn collapse(&mut self, v: u32, p: u32, fan: &Fan, below: &[u32], star: &mut Vec<u32>) {
        self.mesh.collapse(v, p, star);
        // The star's edges come in ring order, and so do the fan's triangles: those that survived, in the same order.
        star.retain(|&e| self.mesh.corner[e as usize] != NONE);
        for &e in star.iter() {
            self.first_sample[(e / 3) as usize] = NONE;
        }
        for &s in below {
            let triangle = star[fan.locate(&self.surface.samples[s as usize])] / 3;
            self.next_sample[s as usize] = self.first_sample[triangle as usize];
            self.first_sample[triangle as usize] = s;
        }
    }
}
