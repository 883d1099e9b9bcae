//! Wake distances as 16 bits: 6 bits of exponent and 10 of mantissa, always rounded up.
//!
//! Closure (docs/design.md, "Wake distance") survives quantisation because a wake is rounded *before* it propagates to other
//! vertices.

/// A wake distance in lattice units. The vertex is in its own position when the viewer is nearer than this times the view's
/// scale, and awake from [`MORPH_REACH`] times as far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Wake(u16);

/// Bits of a wake's mantissa; its exponent has the rest.
pub const MANTISSA_BITS: u32 = 10;

/// Bits of a double's mantissa that a wake does not keep.
const DROPPED_BITS: u32 = f64::MANTISSA_DIGITS - 1 - MANTISSA_BITS;

/// What is left of the bits of 1.0 without them.
const ONE: u64 = 1.0f64.to_bits() >> DROPPED_BITS;

/// Factor on every sum of a wake and a distance, so that closure also holds for distances rounded to f32 (frustum term
/// included: its planes multiply the rounding error by at most G_max = 3).
pub const PROPAGATION_MARGIN: f64 = 1.0 + 4e-6;

/// How much farther than its wake a vertex already wakes, to slide from its parent's position to its own until the viewer is as
/// near as its wake. Wakes grow by this factor along every dependency, so that whatever a sliding vertex stands among stands
/// still.
pub const MORPH_REACH: f64 = 1.03125;

/// The least wake of a vertex with which it is awake and in its own position wherever one of this `wake`, `edge` away, is awake
/// at all.
pub fn asked(wake: f64, edge: f64) -> f64 {
    (wake * MORPH_REACH + edge) * PROPAGATION_MARGIN
}

/// The largest wake for which [`asked`] is at most `limit`, rounded to the safe side.
pub fn askable(limit: f64, edge: f64) -> f64 {
    (limit / PROPAGATION_MARGIN - edge * PROPAGATION_MARGIN) / (MORPH_REACH * PROPAGATION_MARGIN)
}

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
        if distance > Wake(u16::MAX - 1).distance() {
            return Wake::ALWAYS;
        }
        // The bits of a double above the mantissa's first 10, rounded up: a full mantissa carries into the exponent.
        let code = (distance.to_bits() + (1 << DROPPED_BITS) - 1) >> DROPPED_BITS;
        Wake((code - ONE).max(1) as u16)
    }

    /// The distance in lattice units: 0 for asleep, infinite for always.
    pub fn distance(self) -> f64 {
        match self {
            Wake::ASLEEP => 0.0,
            Wake::ALWAYS => f64::INFINITY,
            Wake(code) => f64::from_bits((u64::from(code) + ONE) << DROPPED_BITS),
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
        assert_eq!(Wake::round_up(Wake(u16::MAX - 1).distance()), Wake(u16::MAX - 1));
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
