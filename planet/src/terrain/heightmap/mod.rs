//! Heightfield files as elevation, over the whole planet, at a placed rectangle, or where the file says. In: a file's
//! bytes and a placement. Out: for each direction a height and the weight with which it replaces the ground.
//!
//! Between samples: Catmull-Rom (1974), clamped to the range of heights.

mod basins;
mod cover;
pub(super) mod footprint;
mod globe;
mod projected;
mod rugged;
mod steps;

use super::grid::Grid;
use super::layer::{Evaluate, Past};
use super::points::{Lane, Points, WideLane, LANES};
use crate::recipe::{self, HeightScale, Recipe, RecipeError};
use cover::Cover;
use footprint::{Footprint, Spot};
use terrane_heightfield::import;
use terrane_heightfield::import::{ImportError, Imported, Values};
use terrane_heightfield::Heightfield;

/// 0 below `edges[0]`, 1 above `edges[1]`, smooth in between.
pub(super) fn smoothstep(edges: [f64; 2], v: f64) -> f64 {
    let t = ((v - edges[0]) / (edges[1] - edges[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Heights that a planet can have, in metres.
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -1e5..=1e5;

/// A decoded heightmap.
pub(crate) struct Heightmap {
    columns: usize,
    rows: usize,
    samples: Vec<f32>,
    /// Where the file has no data, if anywhere.
    cover: Option<Cover>,
    scale: Scale,
    footprint: Footprint,
    /// Value and weight that the poles take on a map of the whole planet: means of the first and of the last row.
    poles: [(f64, f64); 2],
    /// Local relief in metres, where other layers ask for it.
    relief: Option<Grid>,
    /// How firmly the sea is kept out, if it is anywhere.
    dry: Option<Grid>,
    /// The sea's level, where there is one.
    sea_m: Option<f64>,
    /// The planet's, in metres.
    radius: f64,
}

/// From samples to metres: `low_m + span_m * sample / full`.
struct Scale {
    full: f64,
    low_m: f64,
    span_m: f64,
    /// What `sample / full` is clamped to between samples.
    limits: [f64; 2],
}

impl Scale {
    /// What the recipe says about heights must fit what the file says, or the words for what was found and expected.
    fn new(image: &Imported, wanted: &HeightScale) -> Result<Scale, (String, &'static str)> {
        let name = image.format.name();
        let scale = match (image.values, wanted) {
            (Values::Levels { full }, HeightScale::Range([low, high])) => {
                Scale { full, low_m: *low, span_m: high - low, limits: [0.0, 1.0] }
            }
            (Values::Metres, HeightScale::Metres { scale, offset_m }) => {
                Scale { full: 1.0, low_m: *offset_m, span_m: *scale, limits: image.range.map(f64::from) }
            }
            (Values::Levels { full }, HeightScale::Metres { .. }) => {
                return Err((
                    format!("{name} of levels from 0 to {full}"),
                    "`range_m`: the heights of the lowest and highest level",
                ));
            }
            (Values::Metres, HeightScale::Range(_)) => {
                return Err((format!("`range_m` for a {name} in metres"), "`scale` and `offset_m`, or neither"));
            }
        };
        let (low, high) = scale.range();
        if HEIGHTS_M.contains(&low) && HEIGHTS_M.contains(&high) {
            Ok(scale)
        } else {
            Err((format!("heights from {low} to {high} m"), "heights from -100000 to 100000 m; `scale` can shrink them"))
        }
    }

    /// Metres of one level.
    fn per_level_m(&self) -> f64 {
        self.span_m / self.full
    }

    fn range(&self) -> (f64, f64) {
        (self.low_m + self.span_m * self.limits[0], self.low_m + self.span_m * self.limits[1])
    }
}

/// A field without its last columns, which say again what the first ones say.
fn first_columns(field: Heightfield, wanted: usize) -> Heightfield {
    let (columns, rows) = (field.columns(), field.rows());
    if wanted >= columns {
        return field;
    }
    let heights = field.heights().chunks_exact(columns).flat_map(|row| row[..wanted].iter().copied()).collect();
    Heightfield::new(wanted, rows, heights).unwrap_or(field)
}

/// The files of a layer, as one image.
fn read(map: &recipe::Heightmap, recipe: &Recipe) -> Result<Imported, RecipeError> {
    let fault = |e: ImportError| {
        let found = if map.files.len() > 1 { format!("{} in {}", e.found, e.file) } else { e.found.into() };
        recipe.heightmap_error(map, found, &format!("{}; {}", e.expected, e.advice))
    };
    let mut images = Vec::new();
    for file in &map.files {
        let asset = recipe.assets.iter().find(|a| a.name == *file);
        let asset = asset.ok_or_else(|| recipe.heightmap_error(map, "no such asset".into(), "its bytes among the assets"))?;
        let image = import::read_with(&asset.bytes, &asset.name, &map.reading).map_err(fault)?;
        images.push((file.clone(), image));
    }
    let image = import::join(images).map_err(fault)?;
    for note in &image.notes {
        tracing::warn!("{}: {note}", map.files.join(", "));
    }
    Ok(image)
}

impl Evaluate for Heightmap {
    type Recipe = recipe::Heightmap;

    fn new(_: u64, map: &recipe::Heightmap, recipe: &Recipe) -> Result<Self, RecipeError> {
        let fault = |found: String, expected: &str| recipe.heightmap_error(map, found, expected);
        let image = read(map, recipe)?;
        let scale = Scale::new(&image, &map.heights).map_err(|(found, expected)| fault(found, expected))?;
        let footprint =
            Footprint::new(&image, &map.placement, recipe.radius).map_err(|(found, expected)| fault(found, &expected))?;
        let mut field = image.field;
        if let Footprint::Planet(globe) = &footprint {
            field = first_columns(field, globe.turn());
        }
        let cover = Cover::new(&field);
        let (columns, rows) = (field.columns(), field.rows());
        field.fill_gaps();
        let mut samples = field.into_heights();
        if map.smooth_steps {
            steps::smooth(&mut samples, [columns, rows], footprint.wraps());
        }
        let (poles, radius) = ([(0.0, 1.0); 2], recipe.radius);
        let sea_m = recipe.sea.as_ref().map(|sea| sea.level_m);
        let mut map = Self { columns, rows, samples, cover, scale, footprint, poles, relief: None, dry: None, sea_m, radius };
        map.poles = [0, rows - 1].map(|row| map.row_mean(row));
        if rugged::is_asked_for(recipe) {
            map.relief =
                Some(map.grid(rugged::relief(&map.samples, [columns, rows], map.footprint.wraps(), map.scale.per_level_m())));
        }
        map.dry = sea_m.and_then(|sea_m| map.basins(sea_m)).map(|dry| map.grid(dry));
        Ok(map)
    }

    fn is_base(&self) -> bool {
        true
    }

    /// It adds nothing: it replaces what there is.
    #[inline(always)]
    fn metres(&self, _: &Points, _: &mut Past) -> Option<Lane> {
        None
    }

    #[inline(always)]
    fn compose(&self, p: &Points, past: &mut Past, height: Option<&mut WideLane>) {
        let at = |i: usize| self.at([0, 1, 2].map(|k| p.position[k][i] / self.radius));
        let found: [(f64, f64); LANES] = std::array::from_fn(at);
        for (base, (metres, weight)) in past.base.iter_mut().zip(found) {
            *base += ((metres - f64::from(*base)) * weight) as f32;
        }
        if let Some(relief) = &self.relief {
            let own = self.on_grid(relief, p);
            for (relief, ((_, weight), own)) in past.relief.iter_mut().zip(found.into_iter().zip(own)) {
                *relief += (own - *relief) * weight as f32;
            }
        }
        for (height, (metres, weight)) in height.into_iter().flatten().zip(found) {
            *height += (metres - *height) * weight;
        }
    }

    #[inline(always)]
    fn dry(&self, p: &Points) -> Option<Lane> {
        self.dry.as_ref().map(|dry| self.on_grid(dry, p))
    }

    /// A little below the deepest basin: between samples the ground may be lower.
    fn lowest_dry(&self) -> Option<f64> {
        self.dry.as_ref().and(self.sea_m).map(|level| level - 1.2 * basins::DEEPEST_M)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        self.scale.range()
    }

    fn bound(&self, (low, high): (f64, f64)) -> (f64, f64) {
        let (own_low, own_high) = self.scale.range();
        (low.min(own_low), high.max(own_high))
    }
}

impl Heightmap {
    fn grid(&self, values: Vec<f32>) -> Grid {
        Grid { size: [self.columns, self.rows], values, wraps: self.footprint.wraps() }
    }

    /// A grid's number at each point, 0 outside the map.
    fn on_grid(&self, grid: &Grid, p: &Points) -> Lane {
        let mut own = [0.0; LANES];
        for (i, own) in own.iter_mut().enumerate() {
            let spot = self.footprint.locate([0, 1, 2].map(|k| p.position[k][i] / self.radius));
            *own = spot.map_or(0.0, |spot| grid.at(spot.column, spot.row));
        }
        own
    }

    /// See [`basins::dry`].
    fn basins(&self, sea_m: f64) -> Option<Vec<f32>> {
        let [low, high] = self.scale.limits;
        let depth =
            |&s: &f32| (sea_m - self.scale.low_m - self.scale.span_m * (f64::from(s) / self.scale.full).clamp(low, high)) as f32;
        let depths: Vec<f32> = self.samples.iter().map(depth).collect();
        basins::dry(&depths, [self.columns, self.rows], self.footprint.wraps())
    }

    /// Height in metres and weight (0 to 1) at a unit direction.
    pub(crate) fn at(&self, d: [f64; 3]) -> (f64, f64) {
        let Some(spot) = self.footprint.locate(d) else { return (0.0, 0.0) };
        let (value, weight) = self.value(&spot);
        (self.scale.low_m + self.scale.span_m * value, weight)
    }

    fn value(&self, spot: &Spot) -> (f64, f64) {
        let wraps = self.footprint.wraps();
        let value = self.sample(spot.column, spot.row, wraps);
        let cover = self.cover.as_ref().map_or(1.0, |cover| cover.at(spot.column, spot.row, wraps));
        if !wraps {
            return (value, spot.weight * cover);
        }
        // Beyond the outermost rows' centres all longitudes meet: go over to the row's mean.
        let north = smoothstep([0.0, 0.5], -spot.row);
        let south = smoothstep([0.0, 0.5], spot.row - (self.rows as f64 - 1.0));
        let [(first, first_cover), (last, last_cover)] = self.poles;
        let between = |here: f64, first: f64, last: f64| here + (first - here) * north + (last - here) * south;
        (between(value, first, last), between(cover, first_cover, last_cover))
    }

    /// Mean value and weight of a row.
    fn row_mean(&self, row: usize) -> (f64, f64) {
        let samples = &self.samples[row * self.columns..][..self.columns];
        let value = samples.iter().map(|&s| f64::from(s)).sum::<f64>() / (self.scale.full * self.columns as f64);
        (value, self.cover.as_ref().map_or(1.0, |cover| cover.row_mean(row)))
    }

    fn pixel(&self, column: i64, row: i64, wraps: bool) -> f64 {
        let (columns, rows) = (self.columns as i64, self.rows as i64);
        let column = if wraps { column.rem_euclid(columns) } else { column.clamp(0, columns - 1) };
        let index = row.clamp(0, rows - 1) * columns + column;
        f64::from(self.samples[index as usize]) * (1.0 / self.scale.full)
    }

    fn sample(&self, column: f64, row: f64, wraps: bool) -> f64 {
        let (c, r) = (column.floor(), row.floor());
        let (across, down) = (weights(column - c), weights(row - r));
        let mut sum = 0.0;
        for (j, wj) in down.iter().enumerate() {
            for (i, wi) in across.iter().enumerate() {
                sum += wi * wj * self.pixel(c as i64 + i as i64 - 1, r as i64 + j as i64 - 1, wraps);
            }
        }
        sum.clamp(self.scale.limits[0], self.scale.limits[1])
    }
}

/// Catmull-Rom weights of the four pixels about a fraction.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}
