//! Draws a hillshaded, coloured map of a recipe, to look at terrain without a renderer. In: a recipe, and for a local
//! map a centre and a width. Out: a PNG, and the cost of a sample.
//!
//! `cargo run --release -p terrane-planet --example map -- RECIPE.toml OUT.png [--at LAT,LON --width-km W] [--size PX]`

use glam::DVec3;
use std::{error::Error, fs::File, io::BufWriter, path::Path, time::Instant};
use terrane_planet::recipe::Recipe;
use terrane_planet::terrain::{GroundPoint, Terrain};

/// What to draw: the whole planet, or a window `width_m` wide.
struct View {
    columns: usize,
    rows: usize,
    window: Option<([f64; 2], f64)>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [recipe, out, options @ ..] = words.as_slice() else {
        return Err("usage: map RECIPE.toml OUT.png [--at LAT,LON --width-km W] [--size PX]".into());
    };
    let recipe = Recipe::load(Path::new(recipe))?;
    let terrain = Terrain::new(&recipe)?;
    let view = View::parse(options)?;
    let (directions, spacing) = view.directions(recipe.radius);
    let mut heights = vec![0.0; directions.len()];
    let start = Instant::now();
    terrain.heights(&directions, &mut heights);
    let nanoseconds = start.elapsed().as_nanos() as f64 / heights.len() as f64;
    let image = view.shade(&recipe, &terrain, &directions, &heights, &spacing);
    write_png(Path::new(out), view.columns, view.rows, &image)?;
    let centre = heights[view.rows / 2 * view.columns + view.columns / 2];
    report(&recipe, &terrain, &heights, [nanoseconds, centre]);
    Ok(())
}

fn report(recipe: &Recipe, terrain: &Terrain, heights: &[f64], [nanoseconds, centre]: [f64; 2]) {
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (least, most) = terrain.height_range();
    println!("{}: {nanoseconds:.0} ns/sample, heights {low:.1} to {high:.1} m of {least:.0} to {most:.0} m", recipe.name);
    println!("height at the centre: {centre:.1} m");
    if let Some(sea) = &recipe.sea {
        let wet = heights.iter().filter(|&&h| h < sea.level_m).count();
        println!("{:.1} % of the map under water", 100.0 * wet as f64 / heights.len() as f64);
    }
}

impl View {
    fn parse(words: &[String]) -> Result<Self, Box<dyn Error>> {
        let option = |name: &str| words.iter().position(|w| w == name).and_then(|i| words.get(i + 1));
        let size = option("--size").map_or(Ok(0), |s| s.parse())?;
        let Some(at) = option("--at") else {
            let rows = if size > 0 { size / 2 } else { 512 };
            return Ok(Self { columns: 2 * rows, rows, window: None });
        };
        let (lat, lon) = at.split_once(',').ok_or("--at takes LAT,LON in degrees")?;
        let width: f64 = option("--width-km").ok_or("--at needs --width-km")?.parse()?;
        let size = if size > 0 { size } else { 640 };
        Ok(Self { columns: size, rows: size, window: Some(([lat.parse()?, lon.parse()?], width * 1000.0)) })
    }

    /// Directions row by row from the north-west, and for each row the metres between samples (east, south).
    fn directions(&self, radius: f64) -> (Vec<DVec3>, Vec<[f64; 2]>) {
        let mut directions = Vec::with_capacity(self.columns * self.rows);
        let mut spacing = Vec::new();
        for row in 0..self.rows {
            let v = (row as f64 + 0.5) / self.rows as f64;
            for column in 0..self.columns {
                let u = (column as f64 + 0.5) / self.columns as f64;
                directions.push(self.direction(u, v, radius));
            }
            let shrink = if self.window.is_some() { 1.0 } else { ((0.5 - v) * std::f64::consts::PI).cos().max(0.02) };
            let width = self.window.map_or(radius * std::f64::consts::TAU, |(_, w)| w);
            let step = width / self.columns as f64;
            spacing.push([step * shrink, step]);
        }
        (directions, spacing)
    }

    fn direction(&self, u: f64, v: f64, radius: f64) -> DVec3 {
        let turn = |lat: f64, lon: f64| DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
        let Some(([lat, lon], width)) = self.window else {
            return turn((0.5 - v) * std::f64::consts::PI, (u - 0.5) * std::f64::consts::TAU);
        };
        let centre = turn(lat.to_radians(), lon.to_radians());
        let east = DVec3::Z.cross(centre).normalize();
        let north = centre.cross(east);
        let (x, y) = ((u - 0.5) * width / radius, (0.5 - v) * width / radius);
        (centre * (1.0 - x * x - y * y).max(0.0).sqrt() + east * x + north * y).normalize()
    }

    fn shade(&self, recipe: &Recipe, terrain: &Terrain, directions: &[DVec3], heights: &[f64], spacing: &[[f64; 2]]) -> Vec<u8> {
        let gradients: Vec<[f64; 2]> = (0..heights.len()).map(|i| self.gradient(heights, spacing, i)).collect();
        let ground = |i: usize| GroundPoint {
            direction: directions[i],
            height: heights[i],
            slope: (gradients[i][0] * gradients[i][0] + gradients[i][1] * gradients[i][1]).sqrt(),
            north: -gradients[i][1],
            spacing: spacing[i / self.columns][1],
        };
        let points: Vec<GroundPoint> = (0..heights.len()).map(ground).collect();
        let mut albedo = vec![[0; 3]; points.len()];
        let start = Instant::now();
        terrain.albedo(&points, &mut albedo);
        println!("albedo: {:.0} ns/sample", start.elapsed().as_nanos() as f64 / points.len() as f64);
        // Coarse maps flatten slopes, so the shading exaggerates them.
        let exaggeration = (spacing[0][1] / 400.0).clamp(1.0, 12.0);
        let lit = |i: usize| light(recipe, albedo[i], heights[i], gradients[i].map(|g| g * exaggeration));
        (0..heights.len()).flat_map(lit).collect()
    }

    /// Metres risen a metre towards east and south.
    fn gradient(&self, heights: &[f64], spacing: &[[f64; 2]], i: usize) -> [f64; 2] {
        let (row, column) = (i / self.columns, i % self.columns);
        let (west, east) = (column.saturating_sub(1), (column + 1).min(self.columns - 1));
        let (north, south) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let at = |r: usize, c: usize| heights[r * self.columns + c];
        let across = (at(row, east) - at(row, west)) / ((east - west) as f64 * spacing[row][0]);
        let down = (at(south, column) - at(north, column)) / ((south - north) as f64 * spacing[row][1]);
        [across, down]
    }
}

/// Sunlight from the north-west at 40 degrees; water absorbs with depth.
fn light(recipe: &Recipe, albedo: [u8; 3], height: f64, gradient: [f64; 2]) -> [u8; 3] {
    let normal = DVec3::new(-gradient[0], gradient[1], 1.0).normalize();
    let sun = DVec3::new(-0.54, 0.54, 0.64).normalize();
    let bright = (normal.dot(sun).max(0.0) / sun.z * 0.85 + 0.15) * 1.05;
    let mut linear = albedo.map(|c| (f64::from(c) / 255.0).powf(2.2) * bright);
    if let Some(sea) = recipe.sea.as_ref().filter(|s| height < s.level_m) {
        let depth = sea.level_m - height;
        for (k, rate) in [0.25, 0.06, 0.04].into_iter().enumerate() {
            let clear = (-depth * rate).exp();
            let water = sea.deep[k] + (sea.shallow[k] - sea.deep[k]) * (-depth / 120.0).exp();
            linear[k] = linear[k] * clear + water * (1.0 - clear);
        }
    }
    linear.map(|c| (c.min(1.0).powf(1.0 / 2.2) * 255.0) as u8)
}

fn write_png(path: &Path, columns: usize, rows: usize, image: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(image)?;
    Ok(())
}
