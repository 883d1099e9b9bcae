//! Where craters are. In: a chunk of points. Out: the sites that may reach it, each with its centre on the sphere and a hash that
//! decides everything else about its crater.
//!
//! A turned cube about the planet has a square lattice of cells on each side, seen along that side's axis. A cell holds at most one
//! site, anywhere in it, and only where its axis is the longest: so each point belongs to one side, and craters cross from side
//! to side without a seam. Nothing reaches farther than [`REACH`] of a cell, so a point has four cells to ask, on most of the
//! planet of one side alone.

use crate::terrain::noise::{nearest, Lattice, PRIMES};
use crate::terrain::points::{Lane, Points, Turned, LANES};

/// Farthest that a crater acts, in cells.
pub(super) const REACH: f64 = 0.5;
/// Cells past which a chunk's lanes each ask their own four: about where the costs cross.
const FEW_CELLS: f64 = 20.0;

/// The sites of one set of craters.
pub(super) struct Sites {
    lattice: Lattice,
    /// Squared planet radius in cells.
    radius2: f64,
    /// Site hashes below this hold a crater.
    threshold: u32,
}

/// What a cell holds: its crater's centre in turned cells (across its side's axis, then along it), the site's hash, and 1 if there is a
/// crater, else 0.
#[derive(Clone, Copy)]
struct Site {
    centre: [f64; 3],
    hash: u32,
    here: f32,
}

/// One site for each lane, as seen from there.
pub(super) struct Seen {
    /// Squared distance in cells.
    pub(super) length2: Lane,
    /// Way from the centre, in cells; the axes are those of the site's side. Kept for those who ask.
    pub(super) way: [Lane; 3],
    pub(super) hashes: [u32; LANES],
    /// 1 where there is a crater, else 0.
    pub(super) here: Lane,
}

/// Looks at sites. A trait, because closures are not sure to be inlined, and then miss the widest instructions.
pub(super) trait Visitor {
    /// Whether it asks for [`Seen::way`].
    const WAY: bool;
    fn visit(&mut self, seen: &Seen);
}

/// Scrambles the sum of a cell's axis hashes.
#[inline(always)]
fn scramble(h: u32) -> u32 {
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// The other two axes of a side.
#[inline(always)]
fn across(side: usize) -> [usize; 2] {
    [(side + 1) % 3, (side + 2) % 3]
}

impl Sites {
    /// Sites in cells of `cell_m` metres, `share` of which hold one, on a planet of `planet_m` metres.
    pub(super) fn new(seed: u64, turn: usize, cell_m: f64, share: f64, planet_m: f64) -> Self {
        let radius = planet_m / cell_m;
        let threshold = (share.clamp(0.0, 1.0) * 65536.0) as u32;
        Self { lattice: Lattice::new(seed, turn, cell_m), radius2: radius * radius, threshold }
    }

    /// Hash of a cell of a side, on the sphere's half where the side's axis is negative or not.
    #[inline(always)]
    fn hash(&self, side: usize, negative: bool, cell: [u32; 2]) -> u32 {
        let half = if negative { 0x68e3_1da4 } else { 0 };
        let seed = self.lattice.seed.wrapping_add(PRIMES[side]) ^ half;
        scramble(cell[0].wrapping_mul(PRIMES[0]) ^ cell[1].wrapping_mul(PRIMES[1]) ^ seed)
    }

    /// The site of a cell with that hash.
    #[inline(always)]
    fn site(&self, shift: [f64; 2], negative: bool, cell: [u32; 2], hash: u32) -> Site {
        let offset = |bits: u32| f64::from(((hash >> bits) & 2047) as i32) * (1.0 / 2048.0) - 1.0;
        let u = f64::from(cell[0] as i32) + offset(21) - shift[0];
        let v = f64::from(cell[1] as i32) + offset(10) - shift[1];
        let (u2, v2) = (u * u, v * v);
        let w2 = self.radius2 - u2 - v2;
        let up = w2.max(0.0).sqrt();
        let site = scramble(hash ^ 0x5bd1_e995);
        let here = ((site & 0xffff) < self.threshold) & (w2 > u2) & (w2 > v2);
        Site { centre: [u, v, if negative { -up } else { up }], hash: site, here: if here { 1.0 } else { 0.0 } }
    }

    /// Shows every site that may reach the chunk to a visitor, as seen from every lane: where the chunk spans few cells once a site, with
    /// all lanes; else once for each of the four cells that lanes ask, each lane its own. Both bring a lane the same craters in the
    /// same order, and others that are out of reach.
    #[inline(always)]
    pub(super) fn visit(&self, p: &Points, visitor: &mut impl Visitor) {
        let turned = &p.turned[self.lattice.turn];
        for side in 0..3 {
            if !self.touched(turned, side) {
                continue;
            }
            if let Some((from, counts)) = self.few_cells(turned, side) {
                self.visit_shared(turned, side, from, counts, visitor);
            } else {
                self.visit_each(turned, side, visitor);
            }
        }
    }

    /// Whether a site of this side may be in reach of any lane: somewhere near its axis must be the longest.
    #[inline(always)]
    fn touched(&self, turned: &Turned, side: usize) -> bool {
        let (low, high) = (turned.low[side].abs(), turned.high[side].abs());
        let longest = low.max(high) * self.lattice.per_metre + 2.0 * REACH;
        let shortest = |k: usize| {
            let (low, high) = (turned.low[k], turned.high[k]);
            low.max(-high).max(0.0) * self.lattice.per_metre
        };
        let [i, j] = across(side);
        shortest(i) <= longest && shortest(j) <= longest
    }

    /// First cell that the chunk can be touched from and how many there are on each axis, if they are few and on one half.
    #[inline(always)]
    fn few_cells(&self, turned: &Turned, side: usize) -> Option<([f64; 2], [u32; 2])> {
        let cell = |k: usize, metres: f64| nearest(self.lattice.coordinate(k, metres)).1;
        let [i, j] = across(side);
        let from = [cell(i, turned.low[i]), cell(j, turned.low[j])];
        let counts = [cell(i, turned.high[i]) - from[0] + 2.0, cell(j, turned.high[j]) - from[1] + 2.0];
        let one_half = turned.low[side] >= 0.0 || turned.high[side] < 0.0;
        (one_half && counts[0] * counts[1] <= FEW_CELLS).then(|| (from, [counts[0] as u32, counts[1] as u32]))
    }

    #[inline(always)]
    fn visit_shared(&self, turned: &Turned, side: usize, from: [f64; 2], counts: [u32; 2], visitor: &mut impl Visitor) {
        let first = [nearest(from[0]).0, nearest(from[1]).0];
        let negative = turned.low[side] < 0.0;
        let shift = across(side).map(|k| self.lattice.shift[k]);
        let mut seen = Seen::default();
        for step in 0..counts[0] * counts[1] {
            let cell = [first[0].wrapping_add(step % counts[0]), first[1].wrapping_add(step / counts[0])];
            let hash = self.hash(side, negative, cell);
            let site = self.site(shift, negative, cell, hash);
            if site.here > 0.0 && self.near(turned, side, &site) {
                self.see(turned, side, &mut seen, visitor, |_| site);
            }
        }
    }

    /// Whether a site is in reach of the box about all lanes.
    #[inline(always)]
    fn near(&self, turned: &Turned, side: usize, site: &Site) -> bool {
        let [i, j] = across(side);
        let gap = |axis: usize, k: usize| {
            let (low, high) = (turned.low[axis] * self.lattice.per_metre, turned.high[axis] * self.lattice.per_metre);
            (low - site.centre[k]).max(site.centre[k] - high).max(0.0)
        };
        let (x, y, z) = (gap(i, 0), gap(j, 1), gap(side, 2));
        x * x + y * y + z * z <= REACH * REACH
    }

    /// One corner at a time, and first what is integer, then what is f64, so that each vectorises.
    #[inline(always)]
    fn visit_each(&self, turned: &Turned, side: usize, visitor: &mut impl Visitor) {
        let [i, j] = across(side);
        let shift = [self.lattice.shift[i], self.lattice.shift[j]];
        let (u, v, w) = (&turned.axes[i], &turned.axes[j], &turned.axes[side]);
        let (mut cells, mut corners, mut hashes) = ([[0; LANES]; 2], [[0; LANES]; 2], [0; LANES]);
        for i in 0..LANES {
            cells[0][i] = nearest(u[i] * self.lattice.per_metre + shift[0]).0;
            cells[1][i] = nearest(v[i] * self.lattice.per_metre + shift[1]).0;
        }
        let mut seen = Seen::default();
        for corner in 0..4 {
            for i in 0..LANES {
                corners[0][i] = cells[0][i].wrapping_add(corner & 1);
                corners[1][i] = cells[1][i].wrapping_add(corner >> 1);
                hashes[i] = self.hash(side, w[i] < 0.0, [corners[0][i], corners[1][i]]);
            }
            self.see(turned, side, &mut seen, visitor, |i| {
                self.site(shift, w[i] < 0.0, [corners[0][i], corners[1][i]], hashes[i])
            });
        }
    }

    /// Shows a visitor the site that `of` gives for each lane.
    #[inline(always)]
    fn see<V: Visitor>(&self, turned: &Turned, side: usize, seen: &mut Seen, visitor: &mut V, of: impl Fn(usize) -> Site) {
        let [i, j] = across(side);
        let (u, v, w) = (&turned.axes[i], &turned.axes[j], &turned.axes[side]);
        for i in 0..LANES {
            let site = of(i);
            let x = u[i] * self.lattice.per_metre - site.centre[0];
            let y = v[i] * self.lattice.per_metre - site.centre[1];
            let z = w[i] * self.lattice.per_metre - site.centre[2];
            seen.length2[i] = (x * x + y * y + z * z) as f32;
            if V::WAY {
                (seen.way[0][i], seen.way[1][i], seen.way[2][i]) = (x as f32, y as f32, z as f32);
            }
            seen.hashes[i] = site.hash;
            seen.here[i] = site.here;
        }
        visitor.visit(seen);
    }
}

impl Default for Seen {
    #[inline(always)]
    fn default() -> Self {
        Self { length2: [0.0; LANES], way: [[0.0; LANES]; 3], hashes: [0; LANES], here: [0.0; LANES] }
    }
}
