//! Wake distances as 16 bits: 6 bits of exponent and 10 of mantissa, always rounded up.
//!
//! Closure (DESIGN section 4) survives quantisation because a wake is rounded *before* it propagates to other vertices.

/// A wake distance in lattice units: the vertex is awake when the viewer is nearer than this times the view's scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Wake(u16);

const MANTISSA_BITS: u32 = 10;
const MANTISSA: u32 = 1 << MANTISSA_BITS;

/// Factor on every sum of a wake and a distance, so that closure also holds for distances rounded to f32 (frustum term
/// included: its planes multiply the rounding error by at most G_max = 3).
pub const PROPAGATION_MARGIN: f64 = 1.0 + 4e-6;

impl Wake {
    /// Never awake.
    pub const ASLEEP: Wake = Wake(0);
    /// Awake at any distance.
    pub const ALWAYS: Wake = Wake(u16::MAX);

    /// The smallest representable wake that is at least `distance` lattice units (at least one).
    pub fn round_up(distance: f64) -> Wake {
        if distance <= 1.0 {
            return Wake(1);
        }
        if distance >= Wake(u16::MAX - 1).distance() {
            return Wake::ALWAYS;
        }
        let mut exponent = 0;
        let mut power = 1.0;
        while power * 2.0 <= distance {
            power *= 2.0;
            exponent += 1;
        }
        // The mantissa may round up to a full 1024, which is the next exponent's zero: the sum carries.
        let mantissa = ((distance / power - 1.0) * f64::from(MANTISSA)).ceil() as u32;
        Wake(((exponent << MANTISSA_BITS) + mantissa).max(1) as u16)
    }

    /// The distance in lattice units: 0 for asleep, infinite for always.
    pub fn distance(self) -> f64 {
        match self {
            Wake::ASLEEP => 0.0,
            Wake::ALWAYS => f64::INFINITY,
            Wake(code) => {
                let (exponent, mantissa) = (u32::from(code) >> MANTISSA_BITS, u32::from(code) & (MANTISSA - 1));
                f64::from(MANTISSA + mantissa) * (2f64.powi(exponent as i32) / f64::from(MANTISSA))
            }
        }
    }

    /// The 16 bits, as stored and as the GPU sees them.
    pub fn code(self) -> u16 {
        self.0
    }

    /// A wake from its 16 bits; every code is valid, and codes order like distances.
    pub fn from_code(code: u16) -> Wake {
        Wake(code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn codes_order_like_distances() {
        for code in 1..u16::MAX {
            assert!(Wake(code).distance() < Wake(code + 1).distance(), "{code}");
        }
    }

    proptest! {
        #[test]
        fn rounding_goes_up_by_at_most_a_thousandth(distance in 1.0f64..4e18) {
            let rounded = Wake::round_up(distance).distance();
            prop_assert!(rounded >= distance && rounded <= distance * (1.0 + 1.0 / 1024.0) + 0.01);
        }

        #[test]
        fn representable_distances_stay(code in 1u16..u16::MAX) {
            prop_assert_eq!(Wake::round_up(Wake(code).distance()).code(), code);
        }
    }
}
