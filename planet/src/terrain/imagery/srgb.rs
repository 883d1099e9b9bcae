//! The transfer curve of sRGB (IEC 61966-2-1) from `+ - * /` and `sqrt` alone. In: encoded values from 0 to 255. Out: light from 0 to 1,
//! and back.

/// Light of every encoded value, rising.
pub(in crate::terrain) struct Curve {
    light: [f32; 256],
}

/// `x` to the power of 2.4.
fn power(x: f64) -> f64 {
    // The fifth root of the square, by Newton's steps from above, which end at the same bits everywhere.
    let square = x * x;
    let mut root = 1.0;
    for _ in 0..64 {
        root = (4.0 * root + square / (root * root * root * root)) * 0.2;
    }
    square * root
}

impl Curve {
    pub(in crate::terrain) fn new() -> Curve {
        let light = |encoded: usize| {
            let share = encoded as f64 / 255.0;
            (if share <= 0.04045 { share / 12.92 } else { power((share + 0.055) / 1.055) }) as f32
        };
        Curve { light: std::array::from_fn(light) }
    }

    /// Light from 0 to 1 of an encoded value.
    #[inline(always)]
    pub(in crate::terrain) fn light(&self, encoded: u8) -> f32 {
        self.light[usize::from(encoded)]
    }

    /// Encoded value from 0 to 255 of light, between whole ones in straight lines.
    pub(in crate::terrain) fn encoded(&self, light: f32) -> f32 {
        let next = self.light.partition_point(|&l| l <= light).clamp(1, 255);
        let (low, high) = (self.light[next - 1], self.light[next]);
        (next - 1) as f32 + ((light - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// The nearest whole encoded value.
    pub(in crate::terrain) fn byte(&self, light: f32) -> u8 {
        (self.encoded(light) + 0.5) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_srgb_and_goes_back() {
        let curve = Curve::new();
        for encoded in 0..=255u8 {
            let share = f64::from(encoded) / 255.0;
            let light = if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) };
            assert!((f64::from(curve.light(encoded)) - light).abs() < 1e-7, "{encoded}: {}", curve.light(encoded));
            assert_eq!(curve.byte(curve.light(encoded)), encoded);
        }
        assert_eq!((curve.encoded(-1.0), curve.encoded(2.0)), (0.0, 255.0));
    }
}
