//! Tiles that touch, joined into one raster: they share a border of samples, or the next one begins a step beyond the last. In:
//! images of one coordinate system and one step. Out: one image; a gap where no tile lies.

use super::{Fault, GeographicGrid, ImportError, Imported, MOST_SAMPLES};
use crate::Heightfield;

/// Share of a step by which grids of two files may be off each other.
const OFF: f64 = 0.05;

/// Where a tile lies on the common grid.
struct Placed {
    tile: Imported,
    name: String,
    column: i64,
    row: i64,
}

/// Joins files into one. Of samples that several have, the first file's with data counts.
///
/// # Errors
/// For files without a place, of other systems, steps or meanings of samples than the first, for grids that do not line up, for
/// tiles that touch no other, and for more than [`MOST_SAMPLES`] in all.
pub fn join(files: Vec<(String, Imported)>) -> Result<Imported, ImportError> {
    let refuse = |name: &str, found: String, expected: String| {
        let (fault, advice) = (Fault::Apart, Fault::Apart.advice().into());
        ImportError { file: name.into(), fault, found: found.into(), expected: expected.into(), advice }
    };
    let mut files = files.into_iter();
    let Some((first_name, first)) = files.next() else { return Err(refuse("", "no file".into(), "at least one".into())) };
    let mut placed = vec![Placed { tile: first, name: first_name, column: 0, row: 0 }];
    for (name, tile) in files {
        let (column, row) = offset(&placed[0].tile, &tile).map_err(|(found, expected)| refuse(&name, found, expected))?;
        placed.push(Placed { tile, name, column, row });
    }
    if placed.len() == 1 {
        return Ok(placed.swap_remove(0).tile);
    }
    if let Some(alone) = alone(&placed) {
        let found = "a tile that touches none of the others".to_owned();
        return Err(refuse(&placed[alone].name, found, "tiles that share a border or lie a step apart".into()));
    }
    merged(placed).map_err(|(name, found)| refuse(&name, found, format!("at most {MOST_SAMPLES} in all")))
}

/// Columns and rows from the first tile's north-western sample to another's.
fn offset(first: &Imported, other: &Imported) -> Result<(i64, i64), (String, String)> {
    for tile in [first, other] {
        if let Some(error) = &tile.unplaced {
            return Err((error.found.to_string(), error.expected.to_string()));
        }
    }
    let (Some(a), Some(b)) = (&first.georeference, &other.georeference) else {
        return Err(("a file that does not state its place".into(), "files that do".into()));
    };
    if first.values != other.values {
        return Err(("samples of another meaning".into(), "levels or metres as in the first file".into()));
    }
    if a.crs != b.crs || a.body != b.body {
        return Err((b.crs.clone(), format!("{}, as in the first file", a.crs)));
    }
    let along = |from: f64, to: f64, step: f64| {
        let steps = (to - from) / step;
        let whole = steps.round();
        ((steps - whole).abs() <= OFF && whole.abs() < 1e9).then_some(whole as i64)
    };
    let same = |k: usize| {
        let most = first.field.columns().max(first.field.rows()).max(other.field.columns()).max(other.field.rows());
        (b.step[k] / a.step[k] - 1.0).abs() * most as f64 <= OFF
    };
    if !same(0) || !same(1) {
        return Err((
            format!("steps of {} x {}", b.step[0], b.step[1]),
            format!("{} x {}, as in the first file", a.step[0], a.step[1]),
        ));
    }
    let column = along(a.origin[0], b.origin[0], a.step[0]);
    let row = along(b.origin[1], a.origin[1], a.step[1]);
    column.zip(row).ok_or_else(|| ("samples between those of the first file".into(), "one grid for all files".into()))
}

/// The first tile that touches none of those that hang together with the first one.
fn alone(placed: &[Placed]) -> Option<usize> {
    let touches = |a: &Placed, b: &Placed| {
        let beside = |p: i64, n: usize, q: i64, m: usize| p <= q + m as i64 && q <= p + n as i64;
        beside(a.column, a.tile.field.columns(), b.column, b.tile.field.columns())
            && beside(a.row, a.tile.field.rows(), b.row, b.tile.field.rows())
    };
    let mut reached = vec![false; placed.len()];
    let mut front = vec![0];
    while let Some(tile) = front.pop() {
        if !std::mem::replace(&mut reached[tile], true) {
            front.extend((0..placed.len()).filter(|&other| !reached[other] && touches(&placed[tile], &placed[other])));
        }
    }
    reached.iter().position(|reached| !reached)
}

fn merged(mut placed: Vec<Placed>) -> Result<Imported, (String, String)> {
    let ends = |p: &Placed| [p.column, p.row, p.column + p.tile.field.columns() as i64, p.row + p.tile.field.rows() as i64];
    let all = placed.iter().map(ends).reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
    let [west, north, east, south] = all.unwrap_or_default();
    let (columns, rows) = ((east - west) as usize, (south - north) as usize);
    if columns.checked_mul(rows).is_none_or(|samples| samples > MOST_SAMPLES) {
        return Err((placed[0].name.clone(), format!("{columns} x {rows} samples with all files")));
    }
    let mut heights = vec![f32::NAN; columns * rows];
    let mut notes = Vec::new();
    for Placed { tile, column, row, name } in &mut placed {
        let at = |line: usize| (*row - north) as usize * columns + line * columns + (*column - west) as usize;
        for (line, samples) in tile.field.heights().chunks_exact(tile.field.columns()).enumerate() {
            let into = &mut heights[at(line)..][..samples.len()];
            into.iter_mut().zip(samples).filter(|(height, _)| height.is_nan()).for_each(|(height, &sample)| *height = sample);
        }
        notes.extend(tile.notes.drain(..).map(|note| format!("{name}: {note}")));
        tile.field = Heightfield { columns: 0, rows: 0, heights: Vec::new() };
    }
    let mut image = placed.swap_remove(0).tile;
    image.field = Heightfield { columns, rows, heights };
    image.notes = notes;
    image.count();
    move_to(&mut image, [west as f64, north as f64]);
    Ok(image)
}

/// Moves the place of the first tile to the common grid's north-western sample.
fn move_to(image: &mut Imported, [west, north]: [f64; 2]) {
    let (columns, rows) = (image.field.columns(), image.field.rows());
    let Some(place) = &mut image.georeference else { return };
    place.origin = [place.origin[0] + west * place.step[0], place.origin[1] - north * place.step[1]];
    if let Some(grid) = image.grid {
        let grid =
            GeographicGrid { west: grid.west + west * grid.step_east, north: grid.north - north * grid.step_south, ..grid };
        image.spacing_m = Some(grid.spacing_m(rows, &place.body));
        place.middle_deg = [0.5 * (grid.west + grid.east(columns)), 0.5 * (grid.north + grid.south(rows))];
        image.grid = Some(grid);
    }
}
