//! Climate of a living world on a coarse grid: how high and how rugged the ground is on the whole, and how much rain the winds
//! bring. Trade winds, westerlies and polar winds carry moisture from the seas; it falls where they rise, so that the far side of
//! mountains is dry. In: the terrain. Out: three numbers for each direction, smooth over a hundred kilometres on an Earth.
//!
//! Edits change nothing here: their ground stays the only ground that they touch.

use super::points::{axes, LANES};
use super::Terrain;
use glam::DVec3;

/// Cells along a side of each of the six faces of the cube.
const SIDE: usize = 80;

/// How far winds are followed, in steps of so many radii.
const STEPS: usize = 26;
const STEP: f64 = 0.018;

/// Rain that seas around bring whatever the prevailing wind.
const MONSOON: f32 = 0.4;

/// What is known of the climate of a site.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Weather {
    /// Metres above the datum on the whole, the sea's surface counting as ground.
    pub(super) mean_m: f32,
    /// Root mean square of how much the ground departs from that, in metres.
    pub(super) rugged_m: f32,
    /// Rain, from 0 to about 1.
    pub(super) rain: f32,
}

impl Weather {
    #[inline(always)]
    fn mixed(a: Weather, b: Weather, t: f32) -> Weather {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Weather { mean_m: mix(a.mean_m, b.mean_m), rugged_m: mix(a.rugged_m, b.rugged_m), rain: mix(a.rain, b.rain) }
    }
}

/// The grid: the corners of the cells of all faces, so that faces share those on their edges.
pub(super) struct Climate {
    nodes: Vec<Weather>,
}

impl Climate {
    pub(super) fn new(terrain: &Terrain) -> Self {
        let directions: Vec<DVec3> = (0..6 * (SIDE + 1) * (SIDE + 1)).map(direction).collect();
        let samples = Self { nodes: relief(terrain, &directions) };
        let smooth = Self { nodes: directions.iter().map(|&d| samples.around(d)).collect() };
        let with_rain = |&d: &DVec3| Weather { rain: smooth.rain(d, terrain.sea_level), ..smooth.at(d) };
        let wet = Self { nodes: directions.iter().map(with_rain).collect() };
        Self { nodes: directions.iter().map(|&d| wet.around(d)).collect() }
    }

    /// The climate at a direction, which need not be a unit vector.
    #[inline(always)]
    pub(super) fn at(&self, d: DVec3) -> Weather {
        let (a, [x, y, z]) = (d.abs(), [d.x, d.y, d.z]);
        let (face, first, second, axis) = if a.x >= a.y && a.x >= a.z {
            (usize::from(x < 0.0), y, z, a.x)
        } else if a.y >= a.z {
            (2 + usize::from(y < 0.0), z, x, a.y)
        } else {
            (4 + usize::from(z < 0.0), x, y, a.z)
        };
        let cell_and_share = |c: f64| {
            let at = (c / axis + 1.0) * (0.5 * SIDE as f64);
            let cell = (at as usize).min(SIDE - 1);
            (cell, (at - cell as f64) as f32)
        };
        let ((column, u), (row, v)) = (cell_and_share(first), cell_and_share(second));
        let at = |i: usize, j: usize| self.nodes[(face * (SIDE + 1) + row + j) * (SIDE + 1) + column + i];
        Weather::mixed(Weather::mixed(at(0, 0), at(1, 0), u), Weather::mixed(at(0, 1), at(1, 1), u), v)
    }

    /// The mean over the cells around a direction.
    fn around(&self, d: DVec3) -> Weather {
        let [east, north] = compass(d).map(|axis| axis * (1.1 * std::f64::consts::FRAC_PI_2 / SIDE as f64));
        let mut sum = Weather::default();
        for (i, j) in
            [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, 0.7), (0.7, -0.7), (-0.7, -0.7)]
        {
            let near = self.at(d + east * i + north * j);
            sum.mean_m += near.mean_m;
            sum.rugged_m += near.rugged_m;
            sum.rain += near.rain;
        }
        let share = 1.0 / 9.0;
        Weather { mean_m: sum.mean_m * share, rugged_m: sum.rugged_m * share, rain: sum.rain * share }
    }

    /// What falls of the moisture that the wind brings to a site.
    fn rain(&self, d: DVec3, sea_level: Option<f64>) -> f32 {
        let sea = sea_level.unwrap_or(-1e9) as f32;
        let (mut path, mut site) = ([0.0; STEPS], d);
        for height in &mut path {
            *height = self.at(site).mean_m - sea;
            let upwind = site - wind(site) * STEP;
            site = upwind / upwind.length();
        }
        let (mut moisture, mut rain) = (0.5, 0.0);
        for pair in path.windows(2).rev() {
            let (here, lift) = (pair[0], (pair[0] - pair[1]).max(0.0));
            // Ground that is lower than 60 m on the whole is partly sea.
            let land = (here * (1.0 / 60.0)).clamp(0.0, 1.0);
            let falls = (0.032 * land + lift * (1.0 / 3200.0)).min(0.5);
            rain = moisture * falls;
            moisture += (1.0 - moisture) * 0.2 * (1.0 - land) - 0.7 * rain;
        }
        moisture + 1.5 * rain + MONSOON * self.sea_around(d, sea)
    }

    /// Share of sea within a thousand kilometres on an Earth.
    fn sea_around(&self, d: DVec3, sea: f32) -> f32 {
        let [east, north] = compass(d);
        let mut share = 0.0;
        for (i, j) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, 0.7), (0.7, -0.7), (-0.7, -0.7)] {
            for reach in [0.05, 0.11] {
                let here = self.at(d + (east * i + north * j) * reach).mean_m - sea;
                share += (1.0 - here * (1.0 / 60.0)).clamp(0.0, 1.0);
            }
        }
        share * (1.0 / 16.0)
    }
}

/// Direction of a node. Nodes that faces share get the same bits from each.
fn direction(node: usize) -> DVec3 {
    let (face, row, column) = (node / ((SIDE + 1) * (SIDE + 1)), node / (SIDE + 1) % (SIDE + 1), node % (SIDE + 1));
    let coordinate = |k: usize| k as f64 * (2.0 / SIDE as f64) - 1.0;
    let sign = if face % 2 == 0 { 1.0 } else { -1.0 };
    let (u, v) = (coordinate(column), coordinate(row));
    let d = [DVec3::new(sign, u, v), DVec3::new(v, sign, u), DVec3::new(u, v, sign)][face / 2];
    d / d.length()
}

/// Mean height and ruggedness of the ground within a cell of each direction, from four samples.
fn relief(terrain: &Terrain, directions: &[DVec3]) -> Vec<Weather> {
    const CORNERS: [DVec3; 4] =
        [DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)];
    let sea = terrain.sea_level.unwrap_or(-1e9);
    let mut nodes = Vec::with_capacity(directions.len());
    for directions in directions.chunks(LANES / 4) {
        let near = |d: DVec3| CORNERS.map(|corner| (d + corner * (0.4 / SIDE as f64)).normalize());
        let samples: Vec<DVec3> = directions.iter().flat_map(|&d| near(d)).collect();
        let mut heights = vec![0.0; samples.len()];
        super::chunk_heights(terrain, &samples, &mut heights);
        for own in heights.chunks_exact(4) {
            let own: [f64; 4] = std::array::from_fn(|k| own[k].max(sea));
            let mean = (own[0] + own[1] + own[2] + own[3]) * 0.25;
            let square = own.iter().fold(0.0, |sum, h| sum + (h - mean) * (h - mean)) * (1.0 / 3.0);
            nodes.push(Weather { mean_m: mean as f32, rugged_m: square.sqrt() as f32, rain: 0.0 });
        }
    }
    nodes
}

/// Unit vectors east and north of a direction; anything across at the poles.
fn compass(d: DVec3) -> [DVec3; 2] {
    let east = if d.z.abs() < 0.999_999 { DVec3::new(-d.y, d.x, 0.0) } else { DVec3::Y };
    let east = east / east.length();
    [east, d.cross(east)]
}

/// The prevailing wind: from the east in the tropics and about the poles, from the west between 30 and 60 degrees; towards the
/// equator with the trade winds, towards the poles with the westerlies.
pub(super) fn wind(d: DVec3) -> DVec3 {
    let [east, north] = compass(d);
    let s2 = d.z * d.z;
    let zonal = -(1.0 - 4.0 * s2) * (1.0 - s2 * (4.0 / 3.0));
    let meridional = -6.0 * d.z * (0.25 - s2) * (0.75 - s2);
    let wind = east * zonal + north * meridional;
    let length = wind.length().max(0.12);
    DVec3::from_array(axes(|k| wind[k] / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::direction_at;
    use crate::recipe::Recipe;
    use std::path::Path;

    fn climate() -> Climate {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/terra.toml");
        Climate::new(&Terrain::new(&Recipe::load(&path).unwrap()).unwrap())
    }

    #[test]
    fn climate_is_continuous_at_the_edges_of_faces() {
        let (climate, mut rain) = (climate(), [1.0f64, 0.0]);
        for i in 0..400 {
            let along = f64::from(i) / 200.0 - 1.0;
            for edge in [DVec3::new(1.0, 1.0, along), DVec3::new(-1.0, along, 1.0), DVec3::new(along, 1.0, -1.0)] {
                let step = DVec3::new(1e-7, -1e-7, 1e-7);
                let (a, b) = (climate.at(edge + step), climate.at(edge - step));
                assert!((a.rain - b.rain).abs() < 1e-4 && (a.mean_m - b.mean_m).abs() < 0.1, "{edge}: {a:?} {b:?}");
                rain = [rain[0].min(a.rain.into()), rain[1].max(a.rain.into())];
            }
        }
        assert!(rain[1] - rain[0] > 0.2, "rain is the same everywhere: {rain:?}");
    }

    #[test]
    fn the_lee_of_mountains_is_drier() {
        // A mountain wall from pole to pole across the trade winds, and low ground elsewhere: the lee is drier than the windward side.
        let directions: Vec<DVec3> = (0..6 * (SIDE + 1) * (SIDE + 1)).map(direction).collect();
        let wall =
            |d: &DVec3| Weather { mean_m: if d.x > 0.0 && d.y.abs() < 0.1 { 3000.0 } else { 100.0 }, ..Weather::default() };
        let climate = Climate { nodes: directions.iter().map(wall).collect() };
        let rain = |longitude: f64| climate.rain(direction_at(5.0, longitude), Some(0.0));
        assert!(rain(9.0) > 1.3 * rain(-9.0), "{} and {}", rain(9.0), rain(-9.0));
    }

    #[test]
    fn winds_turn_with_the_latitude() {
        let zonal = |latitude: f64| wind(direction_at(latitude, 0.0)).y;
        assert!(zonal(10.0) < -0.5 && zonal(45.0) > 0.5 && zonal(-45.0) > 0.5 && zonal(75.0) < 0.0);
    }
}
