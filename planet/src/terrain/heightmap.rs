//! 16-bit greyscale PNGs as elevation, over the whole planet or a placed rectangle. In: PNG bytes and a placement. Out:
//! for each direction a height and the weight with which it replaces the ground.
//!
//! Between pixels: Catmull-Rom (1974), clamped to the image's range.

use super::angles::{atan2, sin_cos};
use crate::recipe::{self, Placement, Recipe, RecipeError};
use std::f64::consts::PI;
use std::io::Cursor;

/// Largest width and height of an image, in pixels.
const LARGEST_PIXELS: u32 = 32_768;

/// A decoded heightmap.
pub(crate) struct Heightmap {
    width: usize,
    height: usize,
    pixels: Vec<u16>,
    low_m: f64,
    span_m: f64,
    place: Place,
}

enum Place {
    /// Mean of the first and of the last row, which the poles take (0 to 1).
    Planet {
        poles: [f64; 2],
    },
    Local {
        centre: [f64; 3],
        right: [f64; 3],
        up: [f64; 3],
        half_m: [f64; 2],
        blend_m: f64,
        radius: f64,
    },
}

/// 0 below `edges[0]`, 1 above `edges[1]`, smooth in between.
fn smoothstep(edges: [f64; 2], v: f64) -> f64 {
    let t = ((v - edges[0]) / (edges[1] - edges[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Heightmap {
    pub(crate) fn new(recipe: &Recipe, map: &recipe::Heightmap) -> Result<Self, RecipeError> {
        let asset = recipe.assets.iter().find(|a| a.name == map.file);
        let fault = |found: String, expected: &str| recipe.heightmap_error(map, found, expected);
        let asset = asset.ok_or_else(|| fault("no such asset".into(), "its bytes among the assets"))?;
        let (width, height, pixels) = decode(&asset.bytes).map_err(|(found, expected)| fault(found, expected))?;
        let place = match map.placement {
            Placement::Planet if width != 2 * height => {
                return Err(fault(format!("{width} x {height} pixels"), "a whole-planet map twice as wide as high"));
            }
            Placement::Planet => {
                let mean = |row: &[u16]| row.iter().map(|&p| f64::from(p)).sum::<f64>() / (65535.0 * width as f64);
                Place::Planet { poles: [mean(&pixels[..width]), mean(&pixels[width * (height - 1)..])] }
            }
            Placement::Local { latitude_deg, longitude_deg, width_m, heading_deg, blend_m } => {
                let half_m = [0.5 * width_m, 0.5 * width_m * height as f64 / width as f64];
                let [centre, right, up] = frame(latitude_deg, longitude_deg, heading_deg);
                Place::Local { centre, right, up, half_m, blend_m, radius: recipe.radius }
            }
        };
        Ok(Self { width, height, pixels, low_m: map.low_m, span_m: map.high_m - map.low_m, place })
    }

    /// Height in metres and weight (0 to 1) at a unit direction.
    pub(crate) fn at(&self, d: [f64; 3]) -> (f64, f64) {
        let (value, weight) = match &self.place {
            Place::Planet { poles } => (self.on_planet(d, *poles), 1.0),
            Place::Local { centre, right, up, half_m, blend_m, radius } => {
                let ahead = dot(d, *centre);
                if ahead <= 0.1 {
                    return (0.0, 0.0);
                }
                let (u, v) = (dot(d, *right) / ahead * radius, dot(d, *up) / ahead * radius);
                let inside = (half_m[0] - u.abs()).min(half_m[1] - v.abs());
                if inside < 0.0 {
                    return (0.0, 0.0);
                }
                let weight = if *blend_m > 0.0 { smoothstep([0.0, *blend_m], inside) } else { 1.0 };
                let column = (u / half_m[0] * 0.5 + 0.5) * self.width as f64 - 0.5;
                let row = (0.5 - v / half_m[1] * 0.5) * self.height as f64 - 0.5;
                (self.sample(column, row, false), weight)
            }
        };
        (self.low_m + self.span_m * value, weight)
    }

    /// Lowest and highest height in metres.
    pub(crate) fn range(&self) -> (f64, f64) {
        (self.low_m, self.low_m + self.span_m)
    }

    fn on_planet(&self, d: [f64; 3], poles: [f64; 2]) -> f64 {
        let longitude = atan2(d[1], d[0]);
        let latitude = atan2(d[2], (d[0] * d[0] + d[1] * d[1]).sqrt());
        let column = (longitude / (2.0 * PI) + 0.5) * self.width as f64 - 0.5;
        let row = (0.5 - latitude / PI) * self.height as f64 - 0.5;
        let value = self.sample(column, row, true);
        // Beyond the outermost rows' centres all longitudes meet: go over to the row's mean.
        let north = smoothstep([0.0, 0.5], -row);
        let south = smoothstep([0.0, 0.5], row - (self.height as f64 - 1.0));
        value + (poles[0] - value) * north + (poles[1] - value) * south
    }

    fn pixel(&self, column: i64, row: i64, wraps: bool) -> f64 {
        let (width, height) = (self.width as i64, self.height as i64);
        let column = if wraps { column.rem_euclid(width) } else { column.clamp(0, width - 1) };
        let index = row.clamp(0, height - 1) * width + column;
        f64::from(self.pixels[index as usize]) * (1.0 / 65535.0)
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
        sum.clamp(0.0, 1.0)
    }
}

/// Catmull-Rom weights of the four pixels about a fraction.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

/// Centre, right and up of an image placed on the sphere.
fn frame(latitude_deg: f64, longitude_deg: f64, heading_deg: f64) -> [[f64; 3]; 3] {
    let (sin_lat, cos_lat) = sin_cos(latitude_deg);
    let (sin_lon, cos_lon) = sin_cos(longitude_deg);
    let (sin_head, cos_head) = sin_cos(heading_deg);
    let east = [-sin_lon, cos_lon, 0.0];
    let north = [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat];
    let turn = |a: f64, b: f64| [0, 1, 2].map(|k| a * east[k] + b * north[k]);
    [[cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], turn(cos_head, -sin_head), turn(sin_head, cos_head)]
}

type Fault = (String, &'static str);

fn decode(bytes: &[u8]) -> Result<(usize, usize, Vec<u16>), Fault> {
    let expected = "an undamaged PNG";
    let damaged = |e: png::DecodingError| (e.to_string(), expected);
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(damaged)?;
    let info = reader.info();
    if info.color_type != png::ColorType::Grayscale {
        return Err((format!("colour type {:?}", info.color_type), "greyscale without alpha"));
    }
    if info.bit_depth != png::BitDepth::Sixteen {
        return Err((format!("{} bits a pixel", info.bit_depth as u8), "16 bits a pixel"));
    }
    let (width, height) = (info.width, info.height);
    if width.min(height) < 2 || width.max(height) > LARGEST_PIXELS {
        return Err((format!("{width} x {height} pixels"), "2 to 32768 pixels a side"));
    }
    let size = reader.output_buffer_size().ok_or(("an image too large for memory".to_owned(), expected))?;
    let mut raw = vec![0; size];
    reader.next_frame(&mut raw).map_err(damaged)?;
    let pixels = raw.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
    Ok((width as usize, height as usize, pixels))
}
