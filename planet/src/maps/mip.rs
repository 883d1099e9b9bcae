//! Mip levels of tables of numbers.

/// All levels of a square of `side` texels (a power of two), from `finest` down to one texel.
pub fn levels<const N: usize>(finest: Vec<[f32; N]>, side: usize) -> Vec<Vec<[f32; N]>> {
    let mut levels = vec![finest];
    for power in (1..=side.ilog2()).rev() {
        let finer = levels.last().map_or(&[][..], |level| level.as_slice());
        levels.push(halved(finer, 1 << power));
    }
    levels
}

/// The next level of a square of `side` texels: the mean of every four.
pub fn halved<const N: usize>(texels: &[[f32; N]], side: usize) -> Vec<[f32; N]> {
    let half = side / 2;
    let mean = |k: usize| {
        let at = 2 * (k / half) * side + 2 * (k % half);
        std::array::from_fn(|c| 0.25 * (texels[at][c] + texels[at + 1][c] + texels[at + side][c] + texels[at + side + 1][c]))
    };
    (0..half * half).map(mean).collect()
}
