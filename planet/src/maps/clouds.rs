//! A sheet of cloud over a planet: how much cloud there is in every direction, and a tile of finer detail.
//!
//! In: the recipe's `[clouds]` and its seed. Out: a map of all directions, and mip levels of it and of a tile. Fractal noise, pushed about by slower noise and
//! wound up around storms of the middle latitudes; wet belts along the equator and the storm tracks, dry ones between (Hadley
//! circulation). A planet file keeps the map once it was computed.

use super::mip;
use crate::globe::random::Random;
use crate::recipe::{Clouds, Recipe};
use crate::terrain::noise::mix;
use crate::terrain::octaves::{Fractal, Warp};
use crate::terrain::points::{Lane, Points, LANES};
use glam::DVec3;
use rayon::prelude::*;

/// Texels along a side of the map.
pub const CLOUD_SIDE: usize = 2048;
/// Texels along a side of the tile of detail.
pub const DETAIL_SIDE: usize = 256;
/// What the map holds where cloud begins: so much less is clear by that margin.
pub const CLOUD_EDGE: f32 = 0.5;

/// Noise to units of the map.
const CONTRAST: f32 = 0.5;
/// Longest waves of the noise and of what pushes it, shares of the radius.
const WEATHER: f64 = 0.36;
const DRIFT: f64 = 0.36;
/// How far it is pushed, a share of the radius.
const PUSH: f64 = 0.2;
/// Weather is longer along parallels than across by this factor.
const FLATNESS: f64 = 1.5;

const STORMS: usize = 34;
/// Latitudes of storms in degrees, and their radii as chords of the unit sphere.
const STORM_LATITUDES: [f64; 2] = [30.0, 64.0];
const STORM_RADII: [f64; 2] = [0.07, 0.2];
/// Radians by which a storm turns its middle.
const STORM_TURNS: [f64; 2] = [1.0, 2.8];
/// What a storm adds to the cover.
const STORM_COVER: f32 = 0.05;

/// Sine of the latitude, and what is added to the cover there.
const BELTS: [(f32, f32); 7] = [(0.0, 0.09), (0.1, 0.05), (0.28, -0.09), (0.45, -0.08), (0.68, 0.06), (0.86, 0.07), (1.0, -0.02)];

/// A level of the map, row by row: shares of 255.
pub type CloudLevel = Vec<u8>;

/// A storm: where, how wide, and how far it winds its middle up.
struct Storm {
    centre: DVec3,
    radius: f64,
    turn: f64,
}

struct Weather {
    radius: f64,
    noise: Fractal,
    warp: Option<Warp>,
    storms: Vec<Storm>,
}

/// The map, an octahedron unfolded into a square (Cigolle et al. 2014) of `side` texels (a power of two): 0 to 1, cloud
/// above [`CLOUD_EDGE`], over about the recipe's share of the planet. The outermost texels lie on the octahedron's edges, and are the
/// same on both sides of them.
pub fn cloud_map(recipe: &Recipe, clouds: &Clouds, side: usize) -> CloudLevel {
    let weather = Weather::new(recipe);
    let texels: Vec<f32> = (0..side).into_par_iter().flat_map_iter(|row| weather.row(row, side)).collect();
    let mut sorted = texels.clone();
    let clear = ((1.0 - clouds.cover) * (sorted.len() - 1) as f64) as usize;
    let (_, &mut edge, _) = sorted.select_nth_unstable_by(clear, f32::total_cmp);
    let code = |x: f32| ((CLOUD_EDGE + CONTRAST * (x - edge)).clamp(0.0, 1.0) * 255.0).round() as u8;
    let mut texels: CloudLevel = texels.into_iter().map(code).collect();
    share_edges(&mut texels, side);
    texels
}

/// Mip levels of the map, from `finest` down to one texel.
pub fn cloud_levels(finest: CloudLevel, side: usize) -> Vec<CloudLevel> {
    let mut levels = vec![finest];
    for power in (1..=side.ilog2()).rev() {
        let (finer, half) = (&levels[levels.len() - 1], 1 << (power - 1));
        let mean = |k: usize| {
            let at = 2 * (k / half) * 2 * half + 2 * (k % half);
            let four = [at, at + 1, at + 2 * half, at + 2 * half + 1].map(|at| u32::from(finer[at]));
            ((four.iter().sum::<u32>() + 2) / 4) as u8
        };
        let mut level: CloudLevel = (0..half * half).map(mean).collect();
        share_edges(&mut level, half);
        levels.push(level);
    }
    levels
}

/// Gives texels that lie on the same point of the octahedron the same value.
fn share_edges(level: &mut [u8], side: usize) {
    let last = side - 1;
    for k in 0..side / 2 {
        for [a, b] in [
            [k, last - k],
            [last * side + k, last * side + last - k],
            [k * side, (last - k) * side],
            [k * side + last, (last - k) * side + last],
        ] {
            let mean = level[a].midpoint(level[b]);
            (level[a], level[b]) = (mean, mean);
        }
    }
}

/// Mip levels of the tile of detail: heaps with creases between them, a mean of 0 and a mean square of 1.
pub fn cloud_detail(seed: u64) -> Vec<Vec<[f32; 1]>> {
    let mut heights = vec![[0.0f32]; DETAIL_SIDE * DETAIL_SIDE];
    let mut gain = 1.0;
    for cells in [6, 13, 27, 55] {
        let mut random = Random::new(mix(seed ^ cells as u64));
        let centres: Vec<[f32; 2]> = (0..cells * cells).map(|_| [random.unit() as f32, random.unit() as f32]).collect();
        for (k, height) in heights.iter_mut().enumerate() {
            height[0] -= gain * nearest_centre(&centres, cells, [k % DETAIL_SIDE, k / DETAIL_SIDE]);
        }
        gain *= 0.62;
    }
    let count = heights.len() as f32;
    let mean = heights.iter().map(|h| h[0]).sum::<f32>() / count;
    let deviation = (heights.iter().map(|h| (h[0] - mean) * (h[0] - mean)).sum::<f32>() / count).sqrt();
    heights.iter_mut().for_each(|h| h[0] = (h[0] - mean) / deviation);
    mip::levels(heights, DETAIL_SIDE)
}

/// Distance from a texel to the nearest of the centres, one in each cell of a periodic grid, in cells (Worley 1996).
fn nearest_centre(centres: &[[f32; 2]], cells: usize, texel: [usize; 2]) -> f32 {
    let [x, y] = texel.map(|t| t as f32 * cells as f32 / DETAIL_SIDE as f32);
    let (column, row) = (x as usize, y as usize);
    let mut nearest = f32::MAX;
    for (j, i) in (0..3).flat_map(|j| (0..3).map(move |i| (j, i))) {
        let centre = centres[(row + j + cells - 1) % cells * cells + (column + i + cells - 1) % cells];
        let away = [column as f32 + i as f32 - 1.0 + centre[0] - x, row as f32 + j as f32 - 1.0 + centre[1] - y];
        nearest = nearest.min(away[0] * away[0] + away[1] * away[1]);
    }
    nearest.sqrt()
}

impl Weather {
    fn new(recipe: &Recipe) -> Self {
        let (seed, radius) = (mix(recipe.seed ^ 0xc10d), recipe.radius);
        let octaves = crate::recipe::Octaves { wavelength_m: WEATHER * radius, detail_m: radius / 700.0, gain: 0.66 };
        let mut random = Random::new(mix(seed));
        let storm = |k: usize| {
            let half = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let latitude = random.range(STORM_LATITUDES[0], STORM_LATITUDES[1]);
            let centre = crate::globe::sphere::direction_at(latitude * half, random.range(-180.0, 180.0));
            let radius = random.range(STORM_RADII[0], STORM_RADII[1]);
            Storm { centre, radius, turn: half * random.range(STORM_TURNS[0], STORM_TURNS[1]) }
        };
        Self {
            radius,
            noise: Fractal::new(mix(seed ^ 1), &octaves),
            warp: Warp::new(mix(seed ^ 2), DRIFT * radius, PUSH * radius, 5),
            storms: (0..STORMS).map(storm).collect(),
        }
    }

    /// Cloudiness along a row of the map, around 0.
    fn row(&self, row: usize, side: usize) -> Vec<f32> {
        let mut cover = vec![0.0; side];
        let coordinate = |k: usize| (2 * k) as f64 / (side - 1) as f64 - 1.0;
        for (chunk, out) in cover.chunks_mut(LANES).enumerate() {
            let directions: Vec<DVec3> =
                (0..out.len()).map(|i| unfolded(coordinate(chunk * LANES + i), coordinate(row))).collect();
            self.chunk(&directions, out);
        }
        cover
    }

    fn chunk(&self, directions: &[DVec3], out: &mut [f32]) {
        let mut wound = [DVec3::Z; LANES];
        let mut added = [0.0; LANES];
        for (i, &direction) in directions.iter().enumerate() {
            (wound[i], added[i]) = self.wind(direction);
        }
        let points = Points::new(self.radius, directions.len(), |i| wound[i] * DVec3::new(1.0, 1.0, FLATNESS));
        let noise = noise_of(self, &points);
        for (i, (cover, direction)) in out.iter_mut().zip(directions).enumerate() {
            *cover = noise[i] + added[i] + belt(direction.z.abs() as f32);
        }
    }

    /// Where the noise of a direction is looked up, wound around the storms, and what these add to the cover.
    fn wind(&self, direction: DVec3) -> (DVec3, f32) {
        let (mut wound, mut added) = (direction, 0.0);
        for storm in &self.storms {
            let near = 1.0 - wound.distance_squared(storm.centre) / (storm.radius * storm.radius);
            if near > 0.0 {
                let (sin, cos) = (storm.turn * near * near).sin_cos();
                let c = storm.centre;
                wound = wound * cos + c.cross(wound) * sin + c * (c.dot(wound) * (1.0 - cos));
                added += STORM_COVER * (near * near) as f32;
            }
        }
        (wound, added)
    }
}

/// Noise of a chunk; see [`crate::terrain`] for why wide instructions give the same bits.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn noise_of(weather: &Weather, points: &Points) -> Lane {
    let mut room = None;
    weather.noise.brownian(Warp::moved(weather.warp.as_ref(), points, &mut room))
}

fn belt(sine: f32) -> f32 {
    let above = BELTS.iter().position(|&(at, _)| at >= sine).unwrap_or(BELTS.len() - 1).max(1);
    let [(a, low), (b, high)] = [BELTS[above - 1], BELTS[above]];
    low + (high - low) * (sine - a) / (b - a)
}

/// Where a direction lies in the map, both coordinates from -1 to 1; twin of that in `shared/clouds.glsl`.
pub fn octahedral(direction: DVec3) -> [f64; 2] {
    let d = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    if d.z >= 0.0 {
        return [d.x, d.y];
    }
    [(1.0 - d.y.abs()).copysign(d.x), (1.0 - d.x.abs()).copysign(d.y)]
}

/// Direction of a point of the map, both coordinates from -1 to 1.
fn unfolded(x: f64, y: f64) -> DVec3 {
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) = if z >= 0.0 { (x, y) } else { ((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum()) };
    DVec3::new(x, y, z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn map(cover: f64) -> Vec<CloudLevel> {
        let text = format!("{}\n[clouds]\ncover = {cover}\n", include_str!("../../recipes/tiny.toml"));
        let recipe = Recipe::from_toml(&text, "tiny.toml", Path::new("")).unwrap();
        cloud_levels(cloud_map(&recipe, &recipe.clouds.clone().unwrap(), 128), 128)
    }

    #[test]
    fn clouds_cover_the_share_that_the_recipe_says() {
        for cover in [0.2, 0.6] {
            let covered = map(cover)[0].iter().filter(|&&x| f32::from(x) > 255.0 * CLOUD_EDGE).count();
            assert!((covered as f64 / (128 * 128) as f64 - cover).abs() < 0.01);
        }
    }

    #[test]
    fn edges_of_the_map_meet() {
        for (power, level) in map(0.5).iter().enumerate() {
            let (side, last) = (128 >> power, (128 >> power) - 1);
            for k in 0..side {
                assert_eq!(level[k], level[last - k], "top of level {power}");
                assert_eq!(level[k * side + last], level[(last - k) * side + last], "right of level {power}");
            }
        }
        // Two texels of one point have the same direction, and a texel beside them has another.
        let [a, b, c] = [unfolded(0.25, -1.0), unfolded(-0.25, -1.0), unfolded(0.25, -0.9)];
        assert!(a.distance(b) < 1e-12 && a.distance(c) > 0.05);
        for [x, y] in [[0.3, 0.2], [-0.9, 0.8], [0.7, -0.6], [-0.1, -0.95]] {
            let back = octahedral(unfolded(x, y));
            assert!((back[0] - x).abs() + (back[1] - y).abs() < 1e-12);
        }
        assert!(unfolded(0.0, 0.0).distance(DVec3::Z) < 1e-12 && unfolded(1.0, 1.0).distance(-DVec3::Z) < 1e-12);
    }

    #[test]
    fn detail_keeps_the_mean_and_repeats() {
        let levels = cloud_detail(5);
        assert!(levels[8][0][0].abs() < 1e-3 && levels.len() == 9);
        let step = |x: usize| (levels[0][x][0] - levels[0][(x + 1) % DETAIL_SIDE][0]).abs();
        assert!(step(DETAIL_SIDE - 1) < 3.0 * (0..DETAIL_SIDE - 1).map(step).fold(0.0, f32::max));
    }
}
