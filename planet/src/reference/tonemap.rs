//! Twin of `tonemap.frag`: from radiance to encoded display values, for pictures of more bits than the shader writes.
//!
//! In: radiance and its factor. Out: sRGB-encoded channels from 0 to 1. The curve is that of AgX (Sobotka 2022) in Wrensch's fit.

use crate::draw::layout::{
    Mode, DITHER, LUMINANCE, TONE_CONTRAST, TONE_CURVE, TONE_MIX, TONE_RANGE, TONE_SATURATION, TONE_UNMIX,
};
use glam::{Mat3, Vec3};

/// The encoded display value of what the scene's image holds, with `exposure` the factor from radiance to display.
pub fn display(mode: Mode, exposure: f32, color: Vec3) -> Vec3 {
    match mode {
        Mode::Normals | Mode::Depth => color.clamp(Vec3::ZERO, Vec3::ONE),
        Mode::Albedo => encode_srgb(color.clamp(Vec3::ZERO, Vec3::ONE)),
        Mode::Shaded | Mode::Wire | Mode::Levels => filmic(color * exposure),
    }
}

fn filmic(color: Vec3) -> Vec3 {
    let log = (Mat3::from_cols_array(&TONE_MIX) * color).max(Vec3::splat(1e-10)).to_array().map(f32::log2);
    let [black, white] = TONE_RANGE;
    let x = ((Vec3::from(log) - black) / (white - black)).clamp(Vec3::ZERO, Vec3::ONE);
    let (x2, x4) = (x * x, x * x * x * x);
    let [c6, c5, c4, c3, c2, c1, c0] = TONE_CURVE;
    let x = c6 * x4 * x2 + c5 * x4 * x + c4 * x4 + c3 * x2 * x + c2 * x2 + c1 * x + c0;
    let x = x.max(Vec3::ZERO).powf(TONE_CONTRAST);
    let grey = Vec3::splat(x.dot(Vec3::from_array(LUMINANCE)));
    (Mat3::from_cols_array(&TONE_UNMIX) * (grey + TONE_SATURATION * (x - grey))).clamp(Vec3::ZERO, Vec3::ONE)
}

/// What the shader adds to 8-bit pictures against banding, in steps: interleaved gradient noise (Jimenez 2014) of the pixel at a
/// position.
pub fn dither(x: u32, y: u32) -> f32 {
    let [column, row, factor] = DITHER;
    let at = (x as f32 + 0.5) * column + (y as f32 + 0.5) * row;
    (factor * at.fract()).fract() - 0.5
}

/// sRGB from linear light, both from 0 to 1.
pub fn encode_srgb(x: Vec3) -> Vec3 {
    Vec3::from(x.to_array().map(|x| if x < 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }))
}

/// Linear light from sRGB, both from 0 to 1.
pub fn decode_srgb(x: Vec3) -> Vec3 {
    Vec3::from(x.to_array().map(|x| if x < 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_goes_back_and_forth() {
        for k in 0..=1000 {
            let x = Vec3::splat(k as f32 / 1000.0);
            assert!((decode_srgb(encode_srgb(x)) - x).abs().max_element() < 1e-5, "{x}");
        }
    }

    #[test]
    fn brighter_is_brighter_and_grey_stays_grey() {
        let mut before = -1.0;
        for k in -40..=16 {
            let shown = display(Mode::Shaded, 0.5, Vec3::splat(2f32.powf(k as f32 / 4.0)));
            assert!(shown.x >= before && (shown.x - shown.y).abs() < 1e-3 && (shown.x - shown.z).abs() < 1e-3, "{k}: {shown}");
            before = shown.x;
        }
        assert!(before > 0.9);
    }
}
