//! Esri ASCII grids: a header of names and numbers, then heights row by row from the north. They name no coordinate system; one
//! beside them (`.prj`) is read where the file is.

use super::crs::Crs;
use super::gaps::Gaps;
use super::place::{self, Raster};
use super::{Fault, Format, ImportError, Imported, Source, Values};

#[derive(Default)]
struct Header {
    columns: Option<usize>,
    rows: Option<usize>,
    /// First coordinates, and whether they are those of the sample's centre.
    west: Option<(f64, bool)>,
    south: Option<(f64, bool)>,
    step: [Option<f64>; 2],
    no_data: Option<f64>,
}

/// Whether the bytes begin as such a grid.
pub(super) fn is_grid(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"ncols"))
}

/// Reads a grid; `projection` is the text of the file beside it.
pub(super) fn read(source: &Source, projection: Option<&str>) -> Result<Imported, ImportError> {
    let damaged = |found: String, expected: &str| source.refuse(Fault::Damaged, found, expected);
    let text = std::str::from_utf8(source.bytes).map_err(|e| damaged(e.to_string(), "an Esri ASCII grid in ASCII"))?;
    let mut words = text.split_ascii_whitespace().peekable();
    let mut header = Header::default();
    while let Some(name) =
        words.next_if(|word| word.starts_with(|c: char| c.is_ascii_alphabetic()) && !word.eq_ignore_ascii_case("nan"))
    {
        let value = words.next().unwrap_or_default();
        header.take(name, value).ok_or_else(|| damaged(format!("'{name} {value}'"), "a line of an Esri ASCII grid's header"))?;
    }
    let size = header.columns.zip(header.rows).ok_or_else(|| damaged("no size".into(), "ncols and nrows"))?;
    let size = [size.0, size.1];
    let samples = source.check_size(size)?;
    let gaps = Gaps::new(source, header.no_data.or(Some(-9999.0)));
    let mut heights = Vec::with_capacity(samples);
    for word in words {
        let number: f64 = word.parse().map_err(|_| damaged(format!("'{word}'"), "a height"))?;
        if heights.len() == samples || number.is_infinite() {
            return Err(damaged(format!("'{word}' at sample {}", heights.len()), "as many finite heights as the header states"));
        }
        let height = number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
        heights.push(if gaps.holds(number, true) { f32::NAN } else { height });
    }
    if heights.len() != samples {
        return Err(damaged(format!("{} heights", heights.len()), &format!("{samples}, as the header states")));
    }
    let mut image = Imported::new(source, Format::Asc, Values::Metres, size, heights)?;
    image.declared_no_data = header.no_data;
    Ok(header.place(source, image, projection))
}

impl Header {
    fn take(&mut self, name: &str, value: &str) -> Option<()> {
        let number = || value.parse::<f64>().ok().filter(|n| n.is_finite());
        match name.to_ascii_lowercase().as_str() {
            "ncols" => self.columns = Some(value.parse().ok()?),
            "nrows" => self.rows = Some(value.parse().ok()?),
            "xllcorner" => self.west = Some((number()?, false)),
            "yllcorner" => self.south = Some((number()?, false)),
            "xllcenter" => self.west = Some((number()?, true)),
            "yllcenter" => self.south = Some((number()?, true)),
            "cellsize" => self.step = [Some(number()?); 2],
            "dx" => self.step[0] = Some(number()?),
            "dy" => self.step[1] = Some(number()?),
            "nodata_value" => self.no_data = Some(value.parse().ok()?),
            _ => return None,
        }
        Some(())
    }

    fn place(&self, source: &Source, image: Imported, projection: Option<&str>) -> Imported {
        let named = source.options.crs.as_deref().or(projection);
        let system = |text| {
            let known = Crs::of_user(text);
            known.map_err(|found| source.refuse(Fault::Place, found, "a coordinate system that is known"))
        };
        let placed = self.raster(source, &image).and_then(|raster| Ok((named.map(system).transpose()?, raster)));
        match placed {
            Ok((Some(crs), raster)) => place::place(source, image, &crs, raster),
            Ok((None, raster)) => place::without_system(source, image, raster),
            Err(error) => Imported { unplaced: Some(Box::new(error)), ..image },
        }
    }

    fn raster(&self, source: &Source, image: &Imported) -> Result<Raster, ImportError> {
        let step = self.step.map(|step| step.filter(|s| *s > 0.0));
        let ([Some(across), Some(down)], Some(west), Some(south)) = (step, self.west, self.south) else {
            let found = "a header without place or step";
            return Err(source.refuse(Fault::Place, found, "xllcorner, yllcorner and cellsize"));
        };
        let centre = |(at, centre): (f64, bool), step: f64| if centre { at } else { at + 0.5 * step };
        let (west, south) = (centre(west, across), centre(south, down));
        let north = south + (image.field.rows() as f64 - 1.0) * down;
        Ok(Raster { origin: [west, north], step: [across, down] })
    }
}
