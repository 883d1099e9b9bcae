//! Eight numbers at a time, in a form that compilers turn into vector instructions. The results are the same bits with or
//! without them: every lane is on its own, and nothing is contracted.
//!
//! Plain loops over the lanes throughout: closures through `array::from_fn` or `map` are calls that may stay out of line, and a
//! function out of line is not compiled for the wider instructions of its caller.
#![allow(clippy::needless_range_loop, reason = "see above")]

use std::ops::{Add, Mul, Sub};

/// Numbers held together.
pub const LANES: usize = 8;

macro_rules! lanes {
    ($lanes:ident of $number:ty, $mask:ident of $bits:ty) => {
        /// Eight numbers.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $lanes(pub [$number; LANES]);

        /// All bits set where something holds, none where it does not.
        #[derive(Clone, Copy)]
        pub struct $mask([$bits; LANES]);

        lanes!(@operators $lanes, Add add +, Sub sub -, Mul mul *);

        impl $lanes {
            /// The same number eight times.
            #[inline(always)]
            pub fn splat(number: $number) -> Self {
                Self([number; LANES])
            }

            /// Where this is more than the other.
            #[inline(always)]
            pub fn more_than(self, other: Self) -> $mask {
                let mut mask = [0; LANES];
                for lane in 0..LANES {
                    mask[lane] = (0 as $bits).wrapping_sub(<$bits>::from(self.0[lane] > other.0[lane]));
                }
                $mask(mask)
            }

            /// The smaller of each two.
            #[inline(always)]
            pub fn min(self, other: Self) -> Self {
                self.more_than(other).select(other, self)
            }
        }

        impl $mask {
            /// `yes` where the mask is set, `no` where it is not.
            #[inline(always)]
            pub fn select(self, yes: $lanes, no: $lanes) -> $lanes {
                let mut lanes = [0.0; LANES];
                for lane in 0..LANES {
                    let (yes, no, mask) = (yes.0[lane].to_bits(), no.0[lane].to_bits(), self.0[lane]);
                    lanes[lane] = <$number>::from_bits(yes & mask | no & !mask);
                }
                $lanes(lanes)
            }
        }
    };
    (@operators $lanes:ident, $($operator:ident $name:ident $symbol:tt),*) => {
        $(impl $operator for $lanes {
            type Output = $lanes;

            #[inline(always)]
            fn $name(self, other: $lanes) -> $lanes {
                let mut lanes = [0.0; LANES];
                for lane in 0..LANES {
                    lanes[lane] = self.0[lane] $symbol other.0[lane];
                }
                $lanes(lanes)
            }
        })*
    };
}

lanes!(Singles of f32, SingleMask of u32);
lanes!(Doubles of f64, DoubleMask of u64);

impl Singles {
    /// Eight numbers in a row.
    #[inline(always)]
    pub fn load(numbers: &[f32], first: usize) -> Singles {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&numbers[first..first + LANES]);
        Singles(lanes)
    }

    /// Each without its sign.
    #[inline(always)]
    pub fn abs(self) -> Singles {
        let mut lanes = [0.0; LANES];
        for lane in 0..LANES {
            lanes[lane] = f32::from_bits(self.0[lane].to_bits() & 0x7fff_ffff);
        }
        Singles(lanes)
    }

    /// The largest of the eight.
    #[inline(always)]
    pub fn largest(self) -> f32 {
        let n = self.0;
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let half = [larger(n[0], n[4]), larger(n[1], n[5]), larger(n[2], n[6]), larger(n[3], n[7])];
        larger(larger(half[0], half[2]), larger(half[1], half[3]))
    }
}

impl Doubles {
    /// Rounded to single precision.
    #[inline(always)]
    pub fn to_singles(self) -> Singles {
        let mut lanes = [0.0; LANES];
        for lane in 0..LANES {
            lanes[lane] = self.0[lane] as f32;
        }
        Singles(lanes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_act_on_each_lane() {
        let (a, b) = (Singles([1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0, -8.0]), Singles::splat(2.0));
        assert_eq!(a.more_than(b).select(a, b).0, [2.0, 2.0, 3.0, 2.0, 5.0, 2.0, 7.0, 2.0]);
        assert_eq!(a.min(b).0, [1.0, -2.0, 2.0, -4.0, 2.0, -6.0, 2.0, -8.0]);
        assert_eq!((a * b - a).abs().largest(), 8.0);
        assert_eq!(Singles::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], 1).largest(), 8.0);
        assert_eq!((Doubles::splat(1.5) - Doubles::splat(0.25)).to_singles(), Singles::splat(1.25));
    }
}
