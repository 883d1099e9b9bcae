//! The curve from exposed light to the display: which one, and how a planet's white bends it. In: a recipe's white. Out: a [`Curve`], for
//! the shading block and for the twin of `tonemap.frag`.

use super::layout::{Tone, TONE_GREY};

/// What middle grey becomes on a planet of [`BRIGHT`] whites, and the power by which it rises where whites are darker: code 119 to 124.
const GREY: (f64, f64) = (0.185, 0.1);
/// The white of snow and of thick cloud.
const BRIGHT: f64 = 0.85;
/// What a recipe's white comes to before the shoulder: code 242 after it.
const WHITE: f64 = 1.03;
/// The least that the curve adds to the slope above grey, and how much more than the straight way to white.
const STEEPER: (f64, f64) = (0.65, 1.25);

/// A tone curve for planets of one white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Which one.
    pub tone: Tone,
    /// Reflectance that becomes white on a level card.
    pub white: f32,
    /// What middle grey becomes, what the curve adds to the slope just above it, and over how many powers of e that goes on.
    pub bend: [f32; 3],
}

impl Curve {
    /// The curve that takes middle grey and `white`, a reflectance, to where they belong.
    ///
    /// Above grey the logarithm of light is lifted by `a u / √(1 + (u / r)²)`, u being how many powers of e it lies above grey: steeper at
    /// first, then parallel. The darker the white, the steeper and the longer.
    pub fn new(tone: Tone, white: f64) -> Curve {
        let grey = f64::from(TONE_GREY);
        let shown = GREY.0 * (BRIGHT / white).powf(GREY.1);
        // Whites near grey or below have no room for a curve.
        let above = (white / grey).ln().max(0.1);
        let lift = ((WHITE / shown).ln() - above).max(1e-3);
        let slope = STEEPER.0.max(STEEPER.1 * lift / above);
        let reach = above / ((slope * above / lift).powi(2) - 1.0).sqrt();
        Curve { tone, white: white as f32, bend: [shown, slope, reach].map(|x| x as f32) }
    }
}
