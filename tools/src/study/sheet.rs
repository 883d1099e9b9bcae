//! The contact sheet: a row a cost, a column a face count, every mesh with its errors.

use super::canvas::Canvas;
use super::relief::Frame;
use super::Series;
use glam::Vec3;
use terrane_heightfield::classic::Cost;
use terrane_heightfield::Heightfield;

/// Size of one mesh's picture, in pixels.
const CELL: [usize; 2] = [284, 184];

/// Room for the name of a row, above it.
const BAND: usize = 44;

/// Room for the numbers below a picture.
const CAPTION: usize = 44;

/// Room at the left and right, and below.
const MARGIN: usize = 16;

const PAPER: Vec3 = Vec3::ONE;
const INK: Vec3 = Vec3::new(0.13, 0.15, 0.19);
const FAINT: Vec3 = Vec3::new(0.42, 0.44, 0.48);
const RULE: Vec3 = Vec3::new(0.80, 0.80, 0.78);

/// What a row is called.
fn title(cost: Cost) -> &'static str {
    match cost {
        Cost::Certified => "CERTIFIED  error measured at every sample",
        Cost::Quadric => "QUADRIC  planes of merged faces (Garland, Heckbert 1997)",
        Cost::Spring => "SPRING  springs to merged vertices (after Sklyar)",
    }
}

/// Draws the sheet.
pub(crate) fn draw(field: &Heightfield, all: &[Series]) -> Canvas {
    let row_height = BAND + CELL[1] + CAPTION;
    let columns = all.iter().map(|series| series.pictured.len()).max().unwrap_or(0);
    let mut canvas = Canvas::new([2 * MARGIN + columns * CELL[0], all.len() * row_height + MARGIN], PAPER);
    let (low, high) = field.heights().iter().fold((f32::MAX, f32::MIN), |(low, high), &z| (low.min(z), high.max(z)));
    let heights = [low, high].map(f64::from);
    for (row, series) in all.iter().enumerate() {
        let top = (row * row_height) as f64;
        let width = (canvas.size[0] - 2 * MARGIN) as f64;
        if row > 0 {
            canvas.rectangle([MARGIN as f64, top], [width, 1.0], RULE);
        }
        canvas.text([MARGIN as f64 + 8.0, top + 18.0], 2.0, title(series.cost), INK);
        for (column, sample) in series.pictured.iter().enumerate() {
            let corner = [(MARGIN + column * CELL[0]) as f64, top + BAND as f64];
            let width = (field.columns().max(field.rows()) - 1) as f64;
            Frame { corner, size: CELL.map(|s| s as f64), width, heights }.draw(&mut canvas, &sample.surface);
            let (faces, error) = (sample.surface.faces.len(), sample.deviation);
            let below = corner[1] + CELL[1] as f64;
            let errors = format!("max {} rms {}", number(error.max), number(error.rms));
            canvas.text([corner[0] + 8.0, below], 2.0, &format!("{faces} faces"), INK);
            canvas.text([corner[0] + 8.0, below + 20.0], 1.5, &errors, FAINT);
        }
    }
    canvas
}

/// Two significant digits, but at most four decimals.
fn number(value: f64) -> String {
    if value > 0.0 && value < 0.000_05 {
        return "<0.0001".to_owned();
    }
    let decimals = if value >= 10.0 || value == 0.0 { 0 } else { (1.0 - value.log10().floor()).clamp(1.0, 4.0) as usize };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits_that_count() {
        let shown = [12.34, 1.234, 0.1234, 0.001_234, 0.000_01, 0.0].map(number);
        assert_eq!(shown, ["12", "1.2", "0.12", "0.0012", "<0.0001", "0"]);
    }
}
