//! Planetary terrain as a pure function of direction: the recipe's layers, composed in order. In: unit directions. Out:
//! heights in metres and albedo, the same bits on every machine and however the directions are cut into slices.
//!
//! Only + - * / and sqrt on f64, comparisons and integer hashing (DESIGN, section 2).

mod albedo;
pub(crate) mod angles;
mod craters;
mod heightmap;
mod noise;
mod octaves;
mod profile;
mod relief;

pub use crate::ground::GroundPoint;
use crate::recipe::{Layer, Palette, Recipe, RecipeError, Sea};
use craters::Craters;
use glam::DVec3;
use heightmap::Heightmap;
use noise::{mix, Lane, Points, LANES};
use relief::{Continents, Hills, Mountains, Plains};

/// A planet's ground, ready to evaluate. Shared freely between threads.
pub struct Terrain {
    radius: f64,
    steps: Vec<Step>,
    sea_level: Option<f64>,
    /// Half-width in metres of the band about the sea that is flattened; 0 for none.
    beach_m: f64,
    range: (f64, f64),
    palette: Palette,
    tints: albedo::Tints,
}

enum Step {
    Continents(Continents),
    Mountains(Mountains),
    Hills(Hills),
    Plains(Plains),
    Craters(Craters),
    Heightmap(Box<Heightmap>),
}

/// Slope at the waterline relative to what it would be without beaches.
const BEACH_SLOPE: f64 = 0.22;

impl Terrain {
    /// Prepares a recipe's terrain and decodes its heightmaps.
    ///
    /// # Errors
    /// If a heightmap is missing among the recipe's assets, damaged, or does not fit what the recipe says about it.
    pub fn new(recipe: &Recipe) -> Result<Self, RecipeError> {
        let step = |(i, layer): (usize, &Layer)| Step::new(recipe, mix(recipe.seed ^ mix(i as u64 + 1)), layer);
        let steps = recipe.layers.iter().enumerate().map(step).collect::<Result<Vec<_>, _>>()?;
        let mut terrain = Self {
            radius: recipe.radius,
            steps,
            sea_level: recipe.sea.as_ref().map(|s| s.level_m),
            beach_m: recipe.sea.as_ref().map_or(0.0, |s: &Sea| s.beach_m),
            range: (0.0, 0.0),
            palette: recipe.palette.clone(),
            tints: albedo::Tints::new(mix(recipe.seed ^ 0xa1be), &recipe.palette),
        };
        terrain.range = terrain.bound();
        Ok(terrain)
    }

    /// Height in metres above the radius for each unit direction (planet-fixed: +Z is north, longitude 0 is +X, 90 east
    /// is +Y). `heights[i]` belongs to `directions[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        assert_eq!(directions.len(), heights.len(), "one height for each direction");
        let (mut base, mut height) = ([0.0; LANES], [0.0; LANES]);
        for (directions, heights) in directions.chunks(LANES).zip(heights.chunks_mut(LANES)) {
            let p = self.points(directions.iter().copied());
            self.compose(&p, &mut base, Some(&mut height));
            for (out, &h) in heights.iter_mut().zip(&height) {
                *out = self.shore(h);
            }
        }
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

    /// Heights that no point lies below or above, in metres. Conservative: the extremes of all layers at once.
    pub fn height_range(&self) -> (f64, f64) {
        self.range
    }

    fn points(&self, directions: impl Iterator<Item = DVec3>) -> Points {
        let mut p = Points { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES], count: 0 };
        for (i, d) in directions.take(LANES).enumerate() {
            (p.x[i], p.y[i], p.z[i]) = (d.x * self.radius, d.y * self.radius, d.z * self.radius);
            p.count = i + 1;
        }
        p
    }

    /// Base elevation alone: continents, basins and heightmaps.
    fn base(&self, p: &Points, base: &mut Lane) {
        self.compose(p, base, None);
    }

    /// Composes base elevation and, unless only that is wanted, height. Layers skip what their masks hide from the whole
    /// chunk; that adds 0 elsewhere, so the bits do not depend on the chunk (the last `+ 0.0` turns -0 into 0).
    fn compose(&self, p: &Points, base: &mut Lane, mut height: Option<&mut Lane>) {
        base[..p.count].fill(0.0);
        let mut sum = [0.0; LANES];
        for step in &self.steps {
            match step {
                Step::Continents(layer) => {
                    let mut own = [0.0; LANES];
                    layer.add(p, &mut own);
                    add_to_both(p.count, &own, base, &mut sum);
                }
                Step::Craters(layer) if layer.basins() => {
                    let mut own = [0.0; LANES];
                    layer.add(p, base, &mut own);
                    add_to_both(p.count, &own, base, &mut sum);
                }
                Step::Heightmap(layer) => self.replace(layer, p, base, &mut sum),
                _ if height.is_none() => {}
                Step::Mountains(layer) => layer.add(p, base, &mut sum),
                Step::Hills(layer) => layer.add(p, base, &mut sum),
                Step::Plains(layer) => layer.add(p, &mut sum),
                Step::Craters(layer) => layer.add(p, base, &mut sum),
            }
        }
        if let Some(height) = height.as_mut() {
            for (h, s) in height[..p.count].iter_mut().zip(sum) {
                *h = s + 0.0;
            }
        }
    }

    fn replace(&self, map: &Heightmap, p: &Points, base: &mut Lane, sum: &mut Lane) {
        for i in 0..p.count.min(LANES) {
            let d = [p.x[i] / self.radius, p.y[i] / self.radius, p.z[i] / self.radius];
            let (height, weight) = map.at(d);
            base[i] += (height - base[i]) * weight;
            sum[i] += (height - sum[i]) * weight;
        }
    }

    fn craters(&self) -> impl Iterator<Item = &Craters> {
        self.steps.iter().filter_map(|s| if let Step::Craters(c) = s { Some(c) } else { None })
    }

    /// Flattens the ground about sea level into beaches and shelves; monotone, and far from the sea nothing changes.
    fn shore(&self, height: f64) -> f64 {
        let Some(level) = self.sea_level.filter(|_| self.beach_m > 0.0) else {
            return height;
        };
        let (h, w2) = (height - level, self.beach_m * self.beach_m);
        level + h * (h * h + BEACH_SLOPE * w2) / (h * h + w2)
    }

    fn bound(&self) -> (f64, f64) {
        let (mut low, mut high) = (0.0, 0.0);
        for step in &self.steps {
            if let Step::Heightmap(map) = step {
                let (l, h) = map.range();
                (low, high) = (f64::min(low, l), f64::max(high, h));
            } else {
                let (l, h) = step.range();
                (low, high) = (low + l, high + h);
            }
        }
        // Half a metre for rounding in the sums.
        (self.shore(low) - 0.5, self.shore(high) + 0.5)
    }
}

fn add_to_both(count: usize, own: &Lane, base: &mut Lane, sum: &mut Lane) {
    for ((own, base), sum) in own[..count].iter().zip(base).zip(sum) {
        *base += own;
        *sum += own;
    }
}

impl Step {
    fn new(recipe: &Recipe, seed: u64, layer: &Layer) -> Result<Self, RecipeError> {
        Ok(match layer {
            Layer::Continents(l) => Self::Continents(Continents::new(seed, l)),
            Layer::Mountains(l) => Self::Mountains(Mountains::new(seed, l)),
            Layer::Hills(l) => Self::Hills(Hills::new(seed, l)),
            Layer::Plains(l) => Self::Plains(Plains::new(seed, l)),
            Layer::Craters(l) => Self::Craters(Craters::new(seed, l, recipe.radius)),
            Layer::Heightmap(l) => Self::Heightmap(Box::new(Heightmap::new(recipe, l)?)),
        })
    }

    fn range(&self) -> (f64, f64) {
        match self {
            Self::Continents(l) => l.range(),
            Self::Mountains(l) => l.range(),
            Self::Hills(l) => l.range(),
            Self::Plains(l) => l.range(),
            Self::Craters(l) => l.range(),
            Self::Heightmap(l) => l.range(),
        }
    }
}
