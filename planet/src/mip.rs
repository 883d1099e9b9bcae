//! Mip levels of tables of numbers.

/// The next level of a square of `side` texels: the mean of every four.
pub fn halved<const N: usize>(texels: &[[f32; N]], side: usize) -> Vec<[f32; N]> {
    let half = side / 2;
    let mean = |k: usize| {
        let at = 2 * (k / half) * side + 2 * (k % half);
        std::array::from_fn(|c| 0.25 * (texels[at][c] + texels[at + 1][c] + texels[at + side][c] + texels[at + side + 1][c]))
    };
    (0..half * half).map(mean).collect()
}
