//! Guards of interior collapses next to a border (TRIALS section 3, builder rule 4).
//!
//! A border vertex must be able to fall to its target when its time comes, whatever the interior did before. So before v → p
//! every border vertex β in v's ring, and every vertex b that β's line will have passed through on its way to the corner, must
//! keep *visibility* (the link of β is seen from where β falls to) and *certificate* (the fan that b's fall leaves behind keeps
//! the error that b's canonical wake promises).

use super::border_rules::Kind;
use super::fan::Fan;
use super::mesh::NONE;
use super::state::State;
use super::surface::{area, LEAST_AREA};
use crate::border::ROUNDING;

/// Scratch space of the guards.
#[derive(Default)]
pub struct Guard {
    star: Vec<(u32, u32)>,
    below: Vec<u32>,
    fan: Fan,
    passed: Vec<u32>,
}

impl Guard {
    /// Whether v → p leaves every border vertex in `ring` able to fall, visibly and within its wake.
    pub fn allows(&mut self, state: &State, v: u32, p: u32, ring: &[u32], kappa: f64) -> bool {
        let is_border = |&b: &u32| state.kind(b) == Kind::Border;
        if !ring.iter().any(&is_border) {
            return true;
        }
        for &beta in ring.iter().filter(|b| is_border(b)) {
            let mut b = beta;
            state.star_after(beta, v, p, &mut self.star);
            while is_border(&b) {
                let target = state.rules.target[b as usize];
                if !self.sees_link(state, beta, target) {
                    return false;
                }
                b = target;
            }
        }
        self.passed.clear();
        for &beta in ring.iter().filter(|b| is_border(b)) {
            let mut b = beta;
            while is_border(&b) && !self.passed.contains(&b) {
                self.passed.push(b);
                if !self.keeps_certificate(state, b, v, p, kappa) {
                    return false;
                }
                b = state.rules.target[b as usize];
            }
        }
        true
    }

    /// Whether the link edges of `beta` off its line are seen from `target`. `self.star` is beta's star.
    fn sees_link(&self, state: &State, beta: u32, target: u32) -> bool {
        let sides = state.rules.sides[beta as usize];
        let samples = &state.surface.samples;
        let off_line = |x: u32| state.rules.sides[x as usize] & sides == 0;
        self.star.iter().all(|&(x, y)| {
            !(off_line(x) && off_line(y))
                || area(&samples[target as usize], &samples[x as usize], &samples[y as usize]) > LEAST_AREA
        })
    }

    /// Whether the fan from target(b) over the links of all living line vertices that pass through b has an error within b's wake.
    fn keeps_certificate(&mut self, state: &State, b: u32, v: u32, p: u32, kappa: f64) -> bool {
        let longest = self.build_fan(state, b, v, p);
        let limit = (state.rules.low[b as usize] * (1.0 + 1e-9) - longest) * kappa - ROUNDING;
        if limit < 0.0 {
            return false;
        }
        self.below.push(v);
        state.samples_below_star(v, &mut self.below);
        let samples = &state.surface.samples;
        self.below.iter().all(|&s| self.fan.error_if_covered(&samples[s as usize]).is_none_or(|e| e <= limit))
    }

    /// Fills `self.fan` and the samples below it (`self.below`); returns the longest edge from b to the fan's rim.
    fn build_fan(&mut self, state: &State, b: u32, v: u32, p: u32) -> f64 {
        let (target, other) = (state.rules.target[b as usize], state.rules.other[b as usize]);
        let line = Line::new(state, b, other);
        let samples = &state.surface.samples;
        let side = state.rules.sides[b as usize];
        let on_line = |x: u32| state.rules.sides[x as usize] & side != 0;
        let mut longest = state.surface.distance(b, target).max(state.surface.distance(b, other));
        let mut closing = (i64::MIN, NONE);
        self.below.clear();
        self.fan.start(&samples[target as usize]);
        for i in 1 - line.step..line.step {
            let w = line.vertex(i);
            self.below.push(w);
            if !state.is_alive(w) {
                continue;
            }
            state.samples_below_star(w, &mut self.below);
            if 3 * i.abs() >= line.step {
                continue;
            }
            state.star_after(w, v, p, &mut self.star);
            for &(x, y) in &self.star {
                for z in [x, y].into_iter().filter(|&z| !on_line(z)) {
                    longest = longest.max(state.surface.distance(b, z));
                }
                match (on_line(x), on_line(y)) {
                    (false, false) => {
                        self.fan.push(&samples[x as usize], &samples[y as usize]);
                    }
                    (true, false) if line.index(x) > i => closing = closing.max((i, y)),
                    (false, true) if line.index(y) > i => closing = closing.max((i, x)),
                    _ => {}
                }
            }
        }
        if closing.1 != NONE {
            self.close_fan(state, target, other, closing.1);
        }
        longest
    }

    /// The last triangle of the fan, between the line and `rim`, whichever way round the side runs.
    fn close_fan(&mut self, state: &State, target: u32, other: u32, rim: u32) {
        let [t, o, r] = [target, other, rim].map(|x| &state.surface.samples[x as usize]);
        if area(t, o, r) > 0.0 {
            self.fan.push(o, r);
        } else {
            self.fan.push(r, o);
        }
    }
}

/// Vertices along a patch side, counted from `b` towards `other`.
struct Line {
    origin: i64,
    stride: i64,
    step: i64,
}

impl Line {
    fn new(state: &State, b: u32, other: u32) -> Line {
        let row = i64::from(state.surface.cells) + 1;
        let difference = i64::from(other) - i64::from(b);
        let along_row = difference.abs() < row;
        let stride = if along_row { 1 } else { row } * difference.signum();
        Line { origin: i64::from(b), stride, step: difference / stride }
    }

    fn vertex(&self, i: i64) -> u32 {
        (self.origin + self.stride * i) as u32
    }

    fn index(&self, vertex: u32) -> i64 {
        (i64::from(vertex) - self.origin) / self.stride
    }
}
