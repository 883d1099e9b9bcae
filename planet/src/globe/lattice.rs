//! The lattice: exact planet-fixed positions as three `i32`, so that neither CPU nor GPU needs f64 to be free of cracks.

use glam::{DVec3, IVec3};

/// Lattice positions stay within ±this many units, so that differences of two of them fit an `i32`.
pub const EXTENT: i32 = 1 << 30;

/// Farthest that ground may lie from the centre, in units: room for rounding within [`EXTENT`].
const FARTHEST: f64 = EXTENT as f64 - 2.0;

/// Unit and radius of one planet's lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Length of one lattice unit in metres, a power of two.
    pub unit: f64,
    /// Planet radius (the datum that heights refer to) in units.
    pub radius: f64,
}

impl Lattice {
    /// The lattice of a planet of `radius` metres whose highest terrain lies `highest` metres above the datum: the smallest
    /// power-of-two unit for which both together stay within [`EXTENT`].
    ///
    /// Both must be finite and their sum positive; recipes are checked for this before.
    pub fn new(radius: f64, highest: f64) -> Lattice {
        let reach = radius + highest.max(0.0);
        let mut unit = 1.0;
        while reach / unit >= FARTHEST {
            unit *= 2.0;
        }
        while reach / (unit / 2.0) < FARTHEST {
            unit /= 2.0;
        }
        Lattice { unit, radius: radius / unit }
    }

    /// Highest ground that the lattice holds, in metres above the datum.
    pub fn highest(&self) -> f64 {
        (FARTHEST - 1.0 - self.radius) * self.unit
    }

    /// Mean distance in units of neighbouring samples of a level's patches, of `cells` cells a side.
    pub fn sample_spacing(&self, cells: u32, level: u8) -> f64 {
        std::f64::consts::FRAC_PI_2 * self.radius / f64::from(cells) / f64::from(1u32 << level)
    }

    /// A height in metres as whole units.
    #[inline(always)]
    pub fn quantise_height(&self, height: f64) -> i32 {
        (height / self.unit).round() as i32
    }

    /// The lattice position `height` units above the datum in a unit direction.
    #[inline]
    pub fn position(&self, direction: DVec3, height: i32) -> IVec3 {
        let r = self.radius + f64::from(height);
        IVec3::new((direction.x * r).round() as i32, (direction.y * r).round() as i32, (direction.z * r).round() as i32)
    }
}

/// Exact sign of det(a, b, c): positive when the triangle a, b, c turns counter-clockwise seen from outside the planet.
pub fn orientation(a: IVec3, b: IVec3, c: IVec3) -> i32 {
    determinant(a, b, c).signum() as i32
}

/// det(a, b, c), exactly.
pub fn determinant(a: IVec3, b: IVec3, c: IVec3) -> i128 {
    let [a, b, c] = [a, b, c].map(|p| [i128::from(p.x), i128::from(p.y), i128::from(p.z)]);
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// Axis-aligned box of lattice positions, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeBox {
    /// Smallest components.
    pub low: IVec3,
    /// Largest components.
    pub high: IVec3,
}

impl LatticeBox {
    /// The box that contains nothing.
    pub const EMPTY: LatticeBox = LatticeBox { low: IVec3::MAX, high: IVec3::MIN };

    /// Grows the box to hold a point.
    pub fn include(&mut self, point: IVec3) {
        self.low = self.low.min(point);
        self.high = self.high.max(point);
    }

    /// The smallest box around both.
    pub fn union(self, other: LatticeBox) -> LatticeBox {
        LatticeBox { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box with so many lattice units more on every side.
    pub fn widened(self, margin: i32) -> LatticeBox {
        let margin = IVec3::splat(margin);
        LatticeBox { low: self.low.saturating_sub(margin), high: self.high.saturating_add(margin) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earth_has_eight_millimetre_units() {
        let lattice = Lattice::new(6_371_000.0, 9_000.0);
        assert_eq!(lattice.unit, 1.0 / 128.0);
        assert_eq!(Lattice::new(1_737_400.0, 11_000.0).unit, 1.0 / 512.0);
        assert_eq!(Lattice::new(6e9, 0.0).unit, 8.0);
    }

    #[test]
    fn orientation_is_exact_where_floats_are_not() {
        let a = IVec3::new(EXTENT, 0, 0);
        let b = IVec3::new(EXTENT, 1, 0);
        assert_eq!(orientation(a, b, IVec3::new(EXTENT, 1, 1)), 1);
        assert_eq!(orientation(a, b, IVec3::new(EXTENT - 1, 2, 0)), 0);
        assert_eq!(orientation(b, a, IVec3::new(EXTENT, 1, 1)), -1);
    }
}
