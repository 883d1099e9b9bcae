//! The ground of the study: a curved ridge, a winding valley, the edge of a plateau and a little roughness, so that every kind
//! of feature that a cost may keep or lose is there once. The same on every machine.

use terrane_heightfield::Heightfield;

/// The study's heightfield: `side` × `side` samples, heights in sample spacings.
pub(crate) fn study_field(side: usize) -> Heightfield {
    let last = (side - 1) as f64;
    let height = |sample: usize| {
        let (x, y) = ((sample % side) as f64 / last, 1.0 - (sample / side) as f64 / last);
        (last * ground(x, y)) as f32
    };
    Heightfield::new(side, side, (0..side * side).map(height).collect()).expect("a square of samples")
}

/// Height in sides of the square at a position in it, from 0 to 1 eastwards and northwards.
fn ground(x: f64, y: f64) -> f64 {
    let plain = 0.04 + 0.05 * y;
    let rough = 0.035 * (noise(6.0 * x, 6.0 * y) - 0.5) + 0.012 * (noise(14.0 * x + 40.0, 14.0 * y) - 0.5);
    plain + ridge(x, y) + plateau(x, y) - valley(x, y) + rough
}

/// A crest that bends from the west side to the north-east corner, with a saddle.
fn ridge(x: f64, y: f64) -> f64 {
    let crest = 0.52 + 0.42 * x * x;
    let distance = (y - crest).abs() / 0.2;
    let saddle = 1.0 - 0.45 * bell((x - 0.5) / 0.2);
    let fade = 1.0 - smooth((x - 0.55) / 0.6);
    // Sharp at the top, soft at the foot.
    0.27 * saddle * fade * (1.0 - distance).max(0.0) * (1.0 - 0.5 * distance.min(1.0))
}

/// A tableland in the south-east that breaks off along a curved edge.
fn plateau(x: f64, y: f64) -> f64 {
    let (east, south) = (1.05 - x, y + 0.05);
    let distance = (east * east + south * south).sqrt();
    0.17 * (1.0 - smooth((distance - 0.44) / 0.08))
}

/// A winding valley from the west side to the south.
fn valley(x: f64, y: f64) -> f64 {
    let course = 0.36 - 0.62 * x + 0.05 * wave(2.5 * x + 0.1);
    0.075 * bell((y - course) / 0.13)
}

/// 1 at 0, falling to both sides.
fn bell(t: f64) -> f64 {
    1.0 / ((1.0 + t * t) * (1.0 + t * t))
}

/// 0 below 0, 1 above 1, smooth between.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A wave of period 1 and height 1 made of parabolas.
fn wave(t: f64) -> f64 {
    let t = 2.0 * (t - t.floor());
    if t < 1.0 {
        4.0 * t * (1.0 - t)
    } else {
        -4.0 * (t - 1.0) * (2.0 - t)
    }
}

/// Smooth value noise between 0 and 1 with cells of 1.
fn noise(x: f64, y: f64) -> f64 {
    let corner = |i: f64, j: f64| {
        let hash = ((x.floor() + i) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ ((y.floor() + j) as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (hash.wrapping_mul(0xd6e8_feb8_6659_fd93) >> 40) as f64 / f64::from(1 << 24)
    };
    let (u, v) = (smooth(x - x.floor()), smooth(y - y.floor()));
    let south = corner(0.0, 0.0) * (1.0 - u) + corner(1.0, 0.0) * u;
    let north = corner(0.0, 1.0) * (1.0 - u) + corner(1.0, 1.0) * u;
    south * (1.0 - v) + north * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_is_the_same_everywhere_and_has_relief() {
        let field = study_field(40);
        let (low, high) = field.heights().iter().fold((f32::MAX, f32::MIN), |(l, h), &z| (l.min(z), h.max(z)));
        assert!(high - low > 8.0 && high - low < 20.0, "{low} to {high}");
        let sum = field.heights().iter().fold(0u32, |sum, z| sum.wrapping_mul(31).wrapping_add(z.to_bits()));
        assert_eq!(sum, 0x7217_e312, "the pictures in docs/study/ and what is said of them are of other ground: {sum:#x}");
    }
}
