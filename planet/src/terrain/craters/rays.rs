//! Bright rays of young craters, for the albedo: thin, broken lines away from the crater over a halo. In: a chunk of points and the sites
//! of a class. Out: brightness at each point.

use super::sites::{Seen, Visitor};
use super::{size, young, Class};
use crate::terrain::noise::noise_at;
use crate::terrain::points::{axes, Lane, Points, LANES};

/// Sums the brightness of rays.
struct Painter<'a> {
    class: &'a Class,
    sum: Lane,
}

impl Visitor for Painter<'_> {
    const WAY: bool = true;

    #[inline(always)]
    fn visit(&mut self, seen: &Seen) {
        for i in 0..LANES {
            let t = seen.length2[i] * self.class.per_rim2 * size(seen.hashes[i]);
            if t < self.class.reach2 && seen.here[i] > 0.0 {
                self.sum[i] += self.class.rays(t, axes(|k| seen.way[k][i]), seen.hashes[i]);
            }
        }
    }
}

impl Class {
    /// Adds the brightness of this class's rays, up to 1 a class, times `strength`.
    #[inline(always)]
    pub(super) fn add_rays(&self, p: &Points, strength: f32, bright: &mut Lane) {
        let mut painter = Painter { class: self, sum: [0.0; LANES] };
        for sites in &self.sets {
            sites.visit(p, &mut painter);
        }
        for i in 0..LANES {
            bright[i] += strength * painter.sum[i].min(1.0);
        }
    }

    /// Brightness of one crater's rays at the squared distance `t`, in rim radii, on the way `v` from its centre.
    #[inline(always)]
    fn rays(&self, t: f32, v: [f32; 3], site: u32) -> f32 {
        let fade = 1.0 - (t / self.reach2).sqrt();
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-6);
        let away = axes(|k| v[k] / length);
        // Noise of the direction is constant along rays; noise of the position breaks them up.
        let seed = self.streaks ^ site;
        // The larger the crater, the more and the finer its rays; small ones have a few broad lobes.
        let lines = noise_at(seed, axes(|k| away[k] * (1.6 + 3.0 * self.shape.complex)));
        let broken = noise_at(seed ^ 1, axes(|k| away[k] * 2.5 + v[k] * self.per_break));
        let narrow = 0.35 - 0.24 * self.shape.complex + 0.2 * fade * fade;
        let line = (1.0 - lines.abs() / narrow).max(0.0);
        let line = line * line * (3.0 - 2.0 * line) * (0.45 + 1.7 * broken).clamp(0.0, 1.0);
        let fresh = young(site);
        // Rays fade long before the relief does: few craters have bright ones.
        let fresh = fresh * fresh;
        let halo = 1.0 / (1.0 + t * (0.16 + 0.1 * broken));
        let blanket = (1.0 - t * 0.07).max(0.0);
        fade * (0.8 * halo * (blanket + 0.25 * fade) + line * fade) * fresh * fresh * 1.3
    }
}
