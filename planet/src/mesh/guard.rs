//! Guards of interior collapses next to a border (docs/design.md, "Borders", builder rule 4).
//!
//! A border vertex must be able to fall to its target when its time comes, whatever the interior did before. So before v → p
//! every border vertex β in v's ring, and every vertex b that β's line will have passed through on its way to the corner, must
//! keep *visibility* (the link of β is seen from where β falls to) and *certificate* (the fan that b's fall leaves behind keeps
//! the error that b's canonical wake promises).

use super::border::ROUNDING;
use super::border_rules::{BorderRules, Kind};
use super::surface::Surface;
use terrane_heightfield::decimate::decimator::Decimator;
use terrane_heightfield::decimate::fan::{Fan, SLACK};
use terrane_heightfield::decimate::lanes::{Doubles, LANES};
use terrane_heightfield::decimate::mesh::{next, previous, NONE};
use terrane_heightfield::decimate::samples::{area, Sample};
use terrane_heightfield::decimate::star::LEAST_AREA;
use terrane_heightfield::decimate::sweep::Sweep;

/// A patch between two collapses.
pub struct Patch<'a> {
    /// What it approximates.
    pub surface: &'a Surface,
    /// Border rules; kinds change as mid-edge vertices go.
    pub rules: BorderRules,
    /// The mesh.
    pub decimator: Decimator,
}

impl Patch<'_> {
    /// Kind of a vertex.
    pub fn kind(&self, v: u32) -> Kind {
        self.rules.kind[v as usize]
    }

    fn sample(&self, v: u32) -> Sample {
        self.surface.samples.at(v)
    }

    /// Appends the removed samples below all triangles of `v`'s star.
    fn samples_below_star(&self, v: u32, below: &mut Vec<u32>) {
        for e in self.decimator.mesh.star(v) {
            let mut s = self.decimator.mesh.first_sample(e);
            while s != NONE {
                below.push(s);
                s = self.decimator.samples.next(s);
            }
        }
    }

    /// Triangles (b, x, y) of the star of `b` as they will be after `v` → `p`.
    fn star_after(&self, b: u32, v: u32, p: u32, star: &mut Vec<(u32, u32)>) {
        star.clear();
        let mesh = &self.decimator.mesh;
        let moved = |x: u32| if x == v { p } else { x };
        let mut add = |e: u32| {
            let (x, y) = (moved(mesh.corner(next(e))), moved(mesh.corner(previous(e))));
            if x != b && y != b && x != y {
                star.push((x, y));
            }
        };
        mesh.star(b).for_each(&mut add);
        if p == b {
            mesh.star(v).for_each(&mut add);
        }
    }
}

/// Scratch space of the guards.
#[derive(Default)]
pub struct Guard {
    star: Vec<(u32, u32)>,
    below: Vec<u32>,
    fan: Fan,
    /// Off the line, the corners of the fan.
    rim: Vec<u32>,
    sweep: Sweep,
    passed: Vec<u32>,
}

impl Guard {
    /// Whether v → p leaves every border vertex in the ring of `v`, which is gathered, able to fall, visibly and within its wake.
    pub fn allows(&mut self, patch: &Patch, v: u32, p: u32, kappa: f64) -> bool {
        let is_border = |&b: &u32| patch.kind(b) == Kind::Border;
        let ring = &patch.decimator.star.ring;
        for &beta in ring.iter().filter(|b| is_border(b)) {
            let mut b = beta;
            patch.star_after(beta, v, p, &mut self.star);
            while is_border(&b) {
                let target = patch.rules.target[b as usize];
                if !self.sees_link(patch, beta, target) {
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
                if !self.keeps_certificate(patch, b, v, p, kappa) {
                    return false;
                }
                b = patch.rules.target[b as usize];
            }
        }
        true
    }

    /// Whether the link edges of `beta` off its line are seen from `target`. `self.star` is beta's star.
    fn sees_link(&self, patch: &Patch, beta: u32, target: u32) -> bool {
        let sides = patch.rules.sides[beta as usize];
        let off_line = |x: u32| patch.rules.sides[x as usize] & sides == 0;
        let target = patch.sample(target);
        let seen = |x: u32, y: u32| area(&target, &patch.sample(x), &patch.sample(y)) > LEAST_AREA;
        self.star.iter().all(|&(x, y)| !(off_line(x) && off_line(y)) || seen(x, y))
    }

    /// Whether the fan from target(b) over the links of all living line vertices that pass through b has an error within b's wake.
    fn keeps_certificate(&mut self, patch: &Patch, b: u32, v: u32, p: u32, kappa: f64) -> bool {
        let longest = self.build_fan(patch, b, v, p);
        let limit = (patch.rules.low[b as usize] * (1.0 + 1e-9) - longest) * kappa - ROUNDING;
        if limit < 0.0 {
            return false;
        }
        let target = patch.rules.target[b as usize];
        let error = |s: u32, own: f64, depth: f64| patch.surface.radial_error(s, own, depth);
        let samples = &patch.decimator.samples;
        if self.rim.iter().any(|&z| samples.edge_error(target, z, error) > limit) {
            return false;
        }
        let [end, start] = [target, b].map(|x| patch.sample(x));
        self.sweep.start(&end);
        self.rim.iter().for_each(|&z| self.sweep.push(&end, &start, &patch.sample(z)));
        self.below.push(v);
        patch.samples_below_star(v, &mut self.below);
        self.below.chunks(LANES).all(|numbers| self.is_within(patch, numbers, limit))
    }

    /// Whether the fan keeps to an error at those of up to eight samples that it covers, and while b slides to its target.
    fn is_within(&self, patch: &Patch, numbers: &[u32], limit: f64) -> bool {
        let [mut x, mut y, mut q] = [Doubles::splat(0.0); 3];
        for (lane, &s) in numbers.iter().enumerate() {
            let sample = patch.sample(s);
            (x.0[lane], y.0[lane], q.0[lane]) = (sample.x, sample.y, sample.q);
        }
        let (inside, depth) = self.fan.cover(x, y);
        let [low, high] = self.sweep.range(x, y, q);
        let within = |(lane, &s): (usize, &u32)| {
            let keeps = |depth: Doubles| patch.surface.radial_error(s, q.0[lane], depth.0[lane]) <= limit;
            (inside.0[lane] < -SLACK || keeps(depth)) && keeps(low) && keeps(high)
        };
        numbers.iter().enumerate().all(within)
    }

    /// Fills `self.fan` and the samples below it (`self.below`); returns the longest edge from b to the fan's rim.
    fn build_fan(&mut self, patch: &Patch, b: u32, v: u32, p: u32) -> f64 {
        let (target, other) = (patch.rules.target[b as usize], patch.rules.other[b as usize]);
        let line = Line::new(patch, b, other);
        let side = patch.rules.sides[b as usize];
        let on_line = |x: u32| patch.rules.sides[x as usize] & side != 0;
        let mut longest = patch.surface.distance(b, target).max(patch.surface.distance(b, other));
        let mut closing = (i64::MIN, NONE);
        self.below.clear();
        self.rim.clear();
        self.fan.start(&patch.sample(target));
        for i in 1 - line.step..line.step {
            let w = line.vertex(i);
            self.below.push(w);
            if !patch.decimator.is_alive(w) {
                continue;
            }
            patch.samples_below_star(w, &mut self.below);
            if 3 * i.abs() >= line.step {
                continue;
            }
            patch.star_after(w, v, p, &mut self.star);
            for &(x, y) in &self.star {
                for z in [x, y].into_iter().filter(|&z| !on_line(z)) {
                    longest = longest.max(patch.surface.distance(b, z));
                    if self.rim.last() != Some(&z) {
                        self.rim.push(z);
                    }
                }
                match (on_line(x), on_line(y)) {
                    (false, false) => {
                        self.fan.push(&patch.sample(x), &patch.sample(y));
                    }
                    (true, false) if line.index(x) > i => closing = closing.max((i, y)),
                    (false, true) if line.index(y) > i => closing = closing.max((i, x)),
                    _ => {}
                }
            }
        }
        if closing.1 != NONE {
            self.close_fan(patch, target, other, closing.1);
        }
        longest
    }

    /// The last triangle of the fan, between the line and `rim`, whichever way round the side runs.
    fn close_fan(&mut self, patch: &Patch, target: u32, other: u32, rim: u32) {
        let [t, o, r] = [target, other, rim].map(|x| patch.sample(x));
        if area(&t, &o, &r) > 0.0 {
            self.fan.push(&o, &r);
        } else {
            self.fan.push(&r, &o);
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
    fn new(patch: &Patch, b: u32, other: u32) -> Line {
        let row = i64::from(patch.surface.cells) + 1;
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
