//! Planetary terrain as a pure function of direction: the recipe's layers, composed in order. In: unit directions. Out:
//! heights in metres and albedo, the same bits on every machine and however the directions are cut into slices.
//!
//! Only + - * / and sqrt on floats, comparisons and integer hashing (docs/design.md, "The lattice"). Points go through all layers
//! in chunks; each chunk is dispatched once to code for the widest instructions at hand. Those give the same bits: the compiler
//! neither reorders nor contracts float operations.

#![allow(clippy::needless_range_loop, reason = "a loop over lanes reads and writes several arrays alike")]

mod albedo;
mod canyons;
mod caps;
mod climate;
mod craters;
mod desert;
mod dry;
mod dunes;
pub(crate) mod edits;
mod eroded;
mod grid;
mod heightmap;
mod imagery;
mod lava;
mod layer;
mod living;
mod local_frame;
pub(crate) mod noise;
pub(crate) mod octaves;
pub(crate) mod points;
mod profile;
mod regions;
mod relief;
mod rift;
mod seabed;
mod shield;
mod shores;

pub use crate::ground::GroundPoint;
use crate::recipe::{Edit, Layer, Palette, Recipe, RecipeError, Sea};
use caps::Caps;
use craters::Craters;
use dunes::Dunes;
use edits::Edits;
use glam::DVec3;
use layer::{Past, Step};
use noise::mix;
use octaves::{Fractal, Ramp};
use points::{Lane, Points, WideLane, LANES};
use rift::Rift;
use std::sync::Arc;

/// A planet's ground, ready to evaluate. Shared freely between threads.
pub struct Terrain {
    radius: f64,
    /// What takes long to prepare is shared by all that differ by edits alone.
    steps: Arc<[Step]>,
    sea_level: Option<f64>,
    /// Half-width in metres of the band about the sea that is flattened; 0 for none.
    beach_m: f64,
    /// Where the coast has beaches.
    coast: Fractal,
    /// Changes after all layers and beaches.
    edits: Edits,
    layers_range: (f64, f64),
    edits_range: Vec<(f64, f64)>,
    lowest_dry: Option<f64>,
    palette: Palette,
    tints: Arc<albedo::Tints>,
}

/// Slope at the waterline relative to what it would be without beaches.
const BEACH_SLOPE: f64 = 0.22;
/// How far the widest beaches are felt, in heights of a beach.
const BEACH_REACH: f64 = 4.0;
/// Length of a stretch of coast with or without beaches, in metres and in radii: whichever is less.
const COAST_M: f64 = 9e3;
const COAST: f64 = 0.05;

impl Terrain {
    /// Prepares a recipe's terrain and decodes its heightmaps.
    ///
    /// # Errors
    /// If a heightmap is missing among the recipe's assets, damaged, or does not fit what the recipe says about it.
    pub fn new(recipe: &Recipe) -> Result<Self, RecipeError> {
        let step = |(i, layer): (usize, &Layer)| Step::new(mix(recipe.seed ^ mix(i as u64 + 1)), layer, recipe);
        let steps = recipe.layers.iter().enumerate().map(step).collect::<Result<Arc<[_]>, _>>()?;
        let mut terrain = Self {
            radius: recipe.radius,
            steps,
            sea_level: recipe.sea.as_ref().map(|s| s.level_m),
            beach_m: recipe.sea.as_ref().map_or(0.0, |s: &Sea| s.beach_m),
            coast: Fractal::few(mix(recipe.seed ^ 0xc0a5), COAST_M.min(COAST * recipe.radius), 4),
            edits: Edits::new(&recipe.edits, recipe.radius),
            layers_range: (0.0, 0.0),
            edits_range: Vec::new(),
            lowest_dry: None,
            palette: recipe.palette.clone(),
            tints: Arc::new(albedo::Tints::new(mix(recipe.seed ^ 0xa1be), &recipe.palette)),
        };
        terrain.layers_range = terrain.bound();
        terrain.edits_range = terrain.edits.bounds(terrain.layers_range);
        terrain.lowest_dry = terrain.find_lowest_dry();
        Ok(terrain)
    }

    /// The same ground under other edits.
    pub(crate) fn with_edits(&self, edits: &[Edit]) -> Self {
        let edits = Edits::new(edits, self.radius);
        let mut terrain = Self {
            steps: self.steps.clone(),
            coast: self.coast.clone(),
            edits_range: edits.bounds(self.layers_range),
            edits,
            palette: self.palette.clone(),
            tints: self.tints.clone(),
            ..*self
        };
        terrain.lowest_dry = terrain.find_lowest_dry();
        terrain
    }

    /// Height in metres above the radius for each unit direction (planet-fixed: +Z is north, longitude 0 is +X, 90 east
    /// is +Y). `heights[i]` belongs to `directions[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        assert_eq!(directions.len(), heights.len(), "one height for each direction");
        for (directions, heights) in directions.chunks(LANES).zip(heights.chunks_mut(LANES)) {
            chunk_heights(self, directions, heights);
        }
        self.edits.apply(directions, heights);
    }

    /// Height of the sea's surface in metres above the datum, if there is a sea.
    pub fn sea_level(&self) -> Option<f64> {
        self.sea_level
    }

    /// Height in metres above the radius at one unit direction: the same bits as [`Terrain::heights`].
    pub fn height(&self, direction: DVec3) -> f64 {
        let mut height = [0.0];
        self.heights(&[direction], &mut height);
        height[0]
    }

    /// Heights that no point lies below or above, in metres. Conservative: the extremes of all layers at once, and of all edits.
    pub fn height_range(&self) -> (f64, f64) {
        self.edits_range.iter().fold(self.layers_range, |(low, high), edit| (low.min(edit.0), high.max(edit.1)))
    }

    /// [`Terrain::height_range`] without the edits: the lattice follows from it, so that no edit changes the lattice.
    pub fn layers_range(&self) -> (f64, f64) {
        self.layers_range
    }

    /// Heights that no point within reach of each edit lies below or above once it is made, in metres.
    pub fn edits_range(&self) -> &[(f64, f64)] {
        &self.edits_range
    }

    #[inline(always)]
    fn points(&self, count: usize, direction: impl Fn(usize) -> DVec3) -> Points {
        Points::new(self.radius, count, direction)
    }

    #[inline(always)]
    fn chunk_heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        let p = self.points(directions.len(), |i| directions[i]);
        let mut sum = [0.0; LANES];
        self.compose(&p, Some(&mut sum));
        self.shore(&p, &mut sum);
        for h in &mut sum {
            // Adding 0 turns -0 into 0.
            *h += 0.0;
        }
        heights.copy_from_slice(&sum[..heights.len()]);
    }

    /// Base elevation: continents, basins, lava, volcanoes and heightmaps alone. Adds all layers to `height` where one is given.
    #[inline(always)]
    fn compose(&self, p: &Points, mut height: Option<&mut WideLane>) -> Lane {
        let mut past = Past::over([0.0; LANES]);
        for step in &*self.steps {
            step.compose(p, &mut past, height.as_deref_mut());
        }
        past.base
    }

    fn craters(&self) -> impl Iterator<Item = &Craters> {
        self.steps.iter().filter_map(|s| if let Step::Craters(c) = s { Some(c.as_ref()) } else { None })
    }

    fn caps(&self) -> impl Iterator<Item = &Caps> {
        self.steps.iter().filter_map(|s| if let Step::Caps(c) = s { Some(c.as_ref()) } else { None })
    }

    fn rifts(&self) -> impl Iterator<Item = &Rift> {
        self.steps.iter().filter_map(|s| if let Step::Rift(r) = s { Some(r.as_ref()) } else { None })
    }

    fn dunes(&self) -> impl Iterator<Item = &Dunes> {
        self.steps.iter().filter_map(|s| if let Step::Dunes(d) = s { Some(d.as_ref()) } else { None })
    }

    /// Flattens the ground about sea level into beaches and shelves, on some coasts more than on others; monotone, and far from the
    /// sea nothing changes.
    #[inline(always)]
    fn shore(&self, p: &Points, heights: &mut WideLane) {
        let Some(level) = self.sea_level.filter(|_| self.beach_m > 0.0) else { return };
        let reach = BEACH_REACH * self.beach_m;
        if !heights.iter().fold(false, |any, h| any | ((h - level).abs() < reach)) {
            return;
        }
        let sandy = self.sandy(p);
        for i in 0..LANES {
            let h = heights[i] - level;
            let off = h / (reach * (0.12 + 0.88 * f64::from(sandy[i])));
            let near = (1.0 - off * off).max(0.0);
            let flat = level + h * (1.0 - (1.0 - BEACH_SLOPE) * near * near);
            heights[i] = if near > 0.0 { flat } else { heights[i] };
        }
    }

    /// How much beach the coast has here, 0 to 1.
    #[inline(always)]
    fn sandy(&self, p: &Points) -> Lane {
        const SANDY: Ramp = Ramp::new([-0.05, 0.55]);
        SANDY.lanes(&self.coast.brownian(p))
    }

    fn bound(&self) -> (f64, f64) {
        let (low, high) = self.steps.iter().fold((0.0, 0.0), |range, step| step.bound(range));
        // Half a metre for rounding in the sums.
        (low - 0.5, high + 0.5)
    }
}

/// Heights of up to [`LANES`] directions.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn chunk_heights(terrain: &Terrain, directions: &[DVec3], heights: &mut [f64]) {
    terrain.chunk_heights(directions, heights);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[multiversion::multiversion(targets("x86_64+avx2"))]
    fn narrower_heights(terrain: &Terrain, directions: &[DVec3], heights: &mut [f64]) {
        terrain.chunk_heights(directions, heights);
    }

    #[multiversion::multiversion(targets("x86_64+avx2"))]
    fn narrower_albedo(terrain: &Terrain, points: &[GroundPoint], albedo: &mut [[u8; 3]]) {
        terrain.chunk_albedo(points, albedo);
    }

    fn terrain(name: &str) -> Terrain {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recipes/{name}.toml"));
        Terrain::new(&Recipe::load(&path).unwrap()).unwrap()
    }

    /// Chunks of several spacings all over the planet, from metres to a whole face.
    fn chunks(radius: f64) -> impl Iterator<Item = Vec<DVec3>> {
        let site = |n: u32| {
            let draw = |k: u64| noise::unit(mix(u64::from(n) ^ mix(k))) * 2.0 - 1.0;
            DVec3::new(draw(1), draw(2), draw(3)).normalize()
        };
        let square = move |n: u32, spacing: f64| {
            let (east, north) = site(n).any_orthonormal_pair();
            let at = move |i: usize| (east * (i % 8) as f64 + north * (i / 8) as f64) * (spacing / radius);
            (0..LANES - 5).map(|i| (site(n) + at(i)).normalize()).collect()
        };
        (0..24).flat_map(move |n| [0.3, 40.0, 3000.0, 5e5].map(|spacing| square(n, spacing)))
    }

    #[test]
    fn wide_instructions_keep_the_bits_of_heights() {
        for name in ["terra", "luna", "mars", "tiny"] {
            let terrain = terrain(name);
            let mut distinct = std::collections::HashSet::new();
            for directions in chunks(terrain.radius) {
                let [mut widest, mut narrower, mut portable] = [(); 3].map(|()| vec![0.0; directions.len()]);
                chunk_heights(&terrain, &directions, &mut widest);
                narrower_heights(&terrain, &directions, &mut narrower);
                terrain.chunk_heights(&directions, &mut portable);
                let bits = |heights: &[f64]| heights.iter().map(|h| h.to_bits()).collect::<Vec<u64>>();
                assert_eq!(bits(&widest), bits(&portable), "{name} at {}", directions[0]);
                assert_eq!(bits(&narrower), bits(&portable), "{name} at {}", directions[0]);
                distinct.extend(bits(&widest));
            }
            assert!(distinct.len() > 2000, "{name}: only {} different heights", distinct.len());
        }
    }

    #[test]
    fn wide_instructions_keep_the_albedo() {
        for name in ["terra", "luna", "mars"] {
            let terrain = terrain(name);
            let mut distinct = std::collections::HashSet::new();
            for directions in chunks(terrain.radius) {
                let ground = |&direction: &DVec3| GroundPoint {
                    direction,
                    height: terrain.height(direction),
                    slope: 0.3,
                    north: 0.1,
                    spacing: 2.0,
                };
                let points: Vec<GroundPoint> = directions.iter().step_by(7).map(ground).collect();
                let [mut widest, mut narrower, mut portable] = [(); 3].map(|()| vec![[0; 3]; points.len()]);
                albedo::chunk_albedo(&terrain, &points, &mut widest);
                narrower_albedo(&terrain, &points, &mut narrower);
                terrain.chunk_albedo(&points, &mut portable);
                assert_eq!((&widest, &narrower), (&portable, &portable), "{name} at {}", directions[0]);
                distinct.extend(widest);
            }
            assert!(distinct.len() > 100, "{name}: only {} different colours", distinct.len());
        }
    }
}
