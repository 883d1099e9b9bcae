//! The shape of one crater, fresh or worn. In: how far from its middle, how old, and a noise that takes the circle out of it. Out: its
//! height over its depth, and how much of what was there before it has wiped away.
//!
//! Fresh small craters are bowls; past a transition they have flat floors, terraced walls and central peaks (Melosh 1989, chapters V
//! and VIII). Worn ones are shallow, round-rimmed hollows: what diffusion leaves (Fassett and Thomson 2014).

/// Height of the rim over the depth below it.
pub(crate) const RIM: f32 = 0.25;
/// Ledges on a terraced wall.
const LEDGES: f32 = 2.5;
/// Added to a float below 2^22 it rounds to a whole number: 1.5 * 2^23.
const ROUND: f32 = 12_582_912.0;

/// What the craters of one size class have in common.
pub(super) struct Shape {
    /// 0 for bowls, 1 for flat floors with central peaks.
    pub(super) complex: f32,
    /// How much the noise bends rims.
    pub(super) ragged: f32,
    /// Squared distance at which the ejecta end, in rim radii.
    pub(super) end2: f32,
    /// One over the width of the ejecta in those units.
    pub(super) per_end: f32,
}

/// One crater's height over its depth, and how much of the ground it has renewed, 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Relief {
    pub(super) height: f32,
    pub(super) renewed: f32,
}

impl Shape {
    pub(super) fn new(complex: f32, ragged: f32, end: f64) -> Self {
        let end2 = (end * end) as f32;
        Self { complex, ragged, end2, per_end: 1.0 / (end2 - 1.0) }
    }

    /// A crater at the squared distance `t`, in rim radii: `young` from 0 to 1 is its rank by age, `noise` is about -1 to 1.
    #[inline(always)]
    pub(super) fn relief(&self, t: f32, young: f32, noise: f32) -> Relief {
        // Bent rims, but where the ejecta end nothing moves.
        let t = t * (1.0 + self.ragged * noise * (1.0 - t / self.end2).max(0.0));
        let fresh = sharpness(young);
        let worn = self.worn(t);
        let sharp = self.sharp(t, noise);
        let strength = 0.4 + 0.6 * young * young;
        let renewed = fresh * ((2.0 - t) * 1.25).clamp(0.0, 1.0);
        Relief { height: strength * (worn + (sharp - worn) * fresh), renewed }
    }

    /// A fresh crater.
    #[inline(always)]
    fn sharp(&self, t: f32, noise: f32) -> f32 {
        let far = (self.end2 - t).max(0.0) * self.per_end;
        let ejecta = RIM * far * far * far * (1.0 + 0.8 * noise * (t - 1.0).clamp(0.0, 1.0));
        let mut inside = bowl(t, self.complex);
        if self.complex > 0.0 {
            let foot = (1.0 - t * 22.0).max(0.0);
            inside += self.complex * (terraces(inside, noise) + (0.4 + 0.5 * noise) * foot * foot);
        }
        if t < 1.0 {
            inside
        } else {
            ejecta
        }
    }

    /// A crater whose rim is gone: a hollow with a low swell about it, filled where it was flat.
    #[inline(always)]
    fn worn(&self, t: f32) -> f32 {
        let hollow = (1.0 - t * (1.0 / 1.6)).max(0.0);
        let swell = (1.0 - t / self.end2).max(0.0);
        (0.3 * swell * swell - hollow * hollow).max(-0.7 + 0.3 * self.complex)
    }
}

/// How sharp a crater still is, by its rank by age: only the youngest are.
#[inline(always)]
pub(super) fn sharpness(young: f32) -> f32 {
    let t = ((young - 0.5) * (1.0 / 0.5)).clamp(0.0, 1.0);
    t * t
}

/// Height within the rim relative to the depth: `t` is the squared distance over the squared rim radius, `complex` from 0 (a bowl) to 1
/// (a flat floor). [`RIM`] at the rim.
#[inline(always)]
pub(crate) fn bowl(t: f32, complex: f32) -> f32 {
    ((1.0 + RIM) * (1.0 + 0.9 * complex) * (t - 1.0)).max(-1.0 - RIM) + RIM
}

/// What slumping adds to a wall at a height between floor (-1) and [`RIM`]: treads and risers, none at its ends.
#[inline(always)]
fn terraces(height: f32, noise: f32) -> f32 {
    let up = ((height + 1.0) * (1.0 / (1.0 + RIM))).clamp(0.0, 1.0);
    let phase = up * LEDGES + 1.6 * noise;
    let share = phase - ((phase + ROUND) - ROUND);
    let wave = share * (1.0 - 4.0 * share * share);
    -(1.0 + RIM) * (0.5 / LEDGES) * wave * (4.0 * up * (1.0 - up))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISES: [f32; 5] = [-1.0, -0.4, 0.0, 0.3, 1.0];

    /// Heights every two thousandth of a rim radius, out to past the end.
    fn heights(shape: &Shape, young: f32, noise: f32) -> Vec<f32> {
        let at = |r: f32| shape.relief(r * r, young, noise).height;
        (0..5000).map(|i| at(i as f32 * 5e-4)).collect()
    }

    #[test]
    fn craters_are_continuous_and_end() {
        for (complex, young, noise) in
            [0.0, 0.5, 1.0].into_iter().flat_map(|c| [0.0, 0.6, 1.0].into_iter().flat_map(move |y| NOISES.map(|n| (c, y, n))))
        {
            let heights = heights(&Shape::new(complex, 0.8, 2.0), young, noise);
            let step = heights.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
            assert!(step < 0.012, "a step of {step}: complex {complex}, young {young}, noise {noise}");
            assert!(heights[4001..].iter().all(|&h| h == 0.0));
            assert!(heights.iter().all(|h| (-1.3..0.7).contains(h)));
        }
    }

    #[test]
    fn old_craters_are_shallower_and_smoother() {
        let shape = Shape::new(0.0, 0.0, 2.0);
        let depth = |young| heights(&shape, young, 0.0).into_iter().fold(0.0, f32::min);
        assert!(depth(1.0) < -0.95 && depth(0.2) > -0.35, "{} and {}", depth(1.0), depth(0.2));
        let bend = |young| {
            let h = heights(&shape, young, 0.0);
            h.windows(3).map(|w| (w[0] + w[2] - 2.0 * w[1]).abs()).fold(0.0, f32::max)
        };
        assert!(bend(1.0) > 50.0 * bend(0.2), "{} and {}", bend(1.0), bend(0.2));
    }

    #[test]
    fn walls_of_complex_craters_have_terraces() {
        let rises = |complex: f32| {
            let walls: Vec<f32> = (480..1000).map(|i| bowl(i as f32 * 1e-3, complex)).map(|h| h + terraces(h, 0.0)).collect();
            let rises: Vec<f32> = walls.windows(2).map(|w| w[1] - w[0]).collect();
            rises.iter().fold(0.0_f32, |a, &b| a.max(b)) / rises.iter().sum::<f32>() * rises.len() as f32
        };
        assert!(rises(1.0) > 1.8, "{}", rises(1.0));
        assert_eq!((terraces(-1.0, 0.3), terraces(RIM, 0.3)), (0.0, 0.0));
    }
}
