//! Twin of `tonemap.frag`: from radiance to encoded display values, for pictures of more bits than the shader writes.
//!
//! In: radiance, its factor and the curve. Out: sRGB-encoded channels from 0 to 1.

use crate::draw::layout::{
    Mode, Tone, AGX_CONTRAST, AGX_CURVE, AGX_EXPOSURE, AGX_MIX, AGX_RANGE, AGX_SATURATION, AGX_UNMIX, DITHER, LUMINANCE,
    TONE_GREY, TONE_PALING, TONE_SATURATION, TONE_SHADOWS, TONE_SHOULDER,
};
use crate::draw::tone::Curve;
use glam::{Mat3, Vec3};

/// The encoded display value of what the scene's image holds, with `exposure` the factor from radiance to what the curve takes.
pub fn display(mode: Mode, curve: &Curve, exposure: f32, color: Vec3) -> Vec3 {
    match (mode, curve.tone) {
        (Mode::Normals | Mode::Depth, _) => color.clamp(Vec3::ZERO, Vec3::ONE),
        (Mode::Albedo, _) => encode_srgb(color.clamp(Vec3::ZERO, Vec3::ONE)),
        (_, Tone::Neutral) => encode_srgb(neutral(curve.bend, color * exposure)),
        (_, Tone::Agx) => agx(color * exposure),
    }
}

/// An S about middle grey on the luminance, so that hues stay; then the shoulder of PBR Neutral (Khronos 2024) on the brightest channel.
fn neutral([grey, slope, reach]: [f32; 3], color: Vec3) -> Vec3 {
    let luminance = color.dot(Vec3::from_array(LUMINANCE)).max(1e-10);
    let above = (luminance / TONE_GREY).ln();
    let [slope, reach] = if above < 0.0 { TONE_SHADOWS } else { [slope, reach] };
    let lift = slope * above / (1.0 + (above / reach).powi(2)).sqrt();
    let saturation = 1.0 + TONE_SATURATION * TONE_GREY / (TONE_GREY + luminance);
    // As a power of ratios: no channel falls below nothing, as it would by a factor on differences.
    let vivid = luminance * (color.max(Vec3::ZERO) / luminance).powf(saturation);
    shoulder(vivid * (grey / TONE_GREY * lift.exp()))
}

/// What is brighter than the straight part reaches 1 only in the end, and pales on the way.
fn shoulder(color: Vec3) -> Vec3 {
    let peak = color.max_element();
    if peak <= TONE_SHOULDER {
        return color;
    }
    let room = 1.0 - TONE_SHOULDER;
    let lower = 1.0 - room * room / (peak + room - TONE_SHOULDER);
    let kept = 1.0 / (TONE_PALING * (peak - lower) + 1.0);
    Vec3::splat(lower).lerp(color * (lower / peak), kept)
}

/// The curve of AgX (Sobotka 2022) in Wrensch's fit, whose result is encoded already.
fn agx(color: Vec3) -> Vec3 {
    let log = (Mat3::from_cols_array(&AGX_MIX) * color * AGX_EXPOSURE).max(Vec3::splat(1e-10)).to_array().map(f32::log2);
    let [black, white] = AGX_RANGE;
    let x = ((Vec3::from(log) - black) / (white - black)).clamp(Vec3::ZERO, Vec3::ONE);
    let (x2, x4) = (x * x, x * x * x * x);
    let [c6, c5, c4, c3, c2, c1, c0] = AGX_CURVE;
    let x = c6 * x4 * x2 + c5 * x4 * x + c4 * x4 + c3 * x2 * x + c2 * x2 + c1 * x + c0;
    let x = x.max(Vec3::ZERO).powf(AGX_CONTRAST);
    let grey = Vec3::splat(x.dot(Vec3::from_array(LUMINANCE)));
    (Mat3::from_cols_array(&AGX_UNMIX) * (grey + AGX_SATURATION * (x - grey))).clamp(Vec3::ZERO, Vec3::ONE)
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

    /// The code of a grey.
    fn code(curve: &Curve, light: f64) -> f32 {
        255.0 * display(Mode::Shaded, curve, 1.0, Vec3::splat(light as f32)).x
    }

    #[test]
    fn brighter_is_brighter_and_grey_stays_grey() {
        for (tone, white) in
            [(Tone::Neutral, 0.85), (Tone::Neutral, 0.4), (Tone::Neutral, 1.0), (Tone::Neutral, 0.05), (Tone::Agx, 0.85)]
        {
            let (curve, mut before) = (Curve::new(tone, white), -1.0);
            for k in -120..=64 {
                let shown = display(Mode::Shaded, &curve, 0.5, Vec3::splat(2f32.powf(k as f32 / 8.0)));
                assert!(
                    shown.x >= before && (shown.x - shown.y).abs() < 1e-3 && (shown.x - shown.z).abs() < 1e-3,
                    "{k}: {shown}"
                );
                before = shown.x;
            }
            assert!(before > 0.9 && before <= 1.0);
        }
    }

    #[test]
    fn middle_grey_is_grey_and_each_white_is_white() {
        for white in [0.3, 0.4, 0.55, 0.7, 0.85, 1.0] {
            let curve = Curve::new(Tone::Neutral, white);
            assert!((code(&curve, 0.18) - 118.0).abs() < 8.0, "{}", code(&curve, 0.18));
            assert!((code(&curve, white) - 240.0).abs() < 4.0, "{white}: {}", code(&curve, white));
        }
        let agx = Curve::new(Tone::Agx, 0.85);
        assert!((code(&agx, 0.18) - 118.0).abs() < 8.0, "{}", code(&agx, 0.18));
    }

    #[test]
    fn bright_colours_pale_and_keep_their_hue() {
        let curve = Curve::new(Tone::Neutral, 0.85);
        let shown = |exposure: f32| decode_srgb(display(Mode::Shaded, &curve, exposure, Vec3::new(1.0, 0.45, 0.1)));
        // Share of the way from the weakest channel to the strongest at which the middle one lies.
        let hue = |c: Vec3| (c.y - c.z) / (c.x - c.z);
        let purity = |c: Vec3| 1.0 - c.min_element() / c.max_element();
        let [day, glare, sun] = [0.3, 4.0, 200.0].map(shown);
        assert!((hue(day) - hue(glare)).abs() < 0.06, "{day} {glare}");
        assert!(
            purity(day) > purity(glare) && purity(glare) > 2.0 * purity(sun) && sun.min_element() > 0.9,
            "{day} {glare} {sun}"
        );
    }
}
