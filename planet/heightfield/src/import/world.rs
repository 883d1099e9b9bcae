//! World files: six numbers beside an image that say where its pixels lie (Esri). In: an image whose own bytes do not say it, and the
//! path that it came from. They name no coordinate system; one beside them (`.prj`) is read, too.

use super::crs::Crs;
use super::geotiff::{Part, Tags};
use super::place::{self, Raster};
use super::tiff::turn;
use super::{Fault, Imported, Source, Window};
use std::path::Path;

/// What such a file holds, in its order: steps of x and y along a row, steps of x and y along a column, and the centre of the first pixel.
const EXPECTED: &str = "six numbers: steps along rows and columns, and the first pixel's centre";

/// The image with the place that the file beside it states, if there is one and the image has none.
pub(super) fn placed(source: &Source, image: Imported, path: &Path, projection: Option<&str>) -> Imported {
    let has_place = image.spacing_m.is_some() || image.unplaced.is_some();
    let Some((name, text)) = beside(path).filter(|_| !has_place) else { return image };
    let unclear = |found: String, expected: &str| source.refuse(Fault::Place, format!("{found} in {name}"), expected);
    let numbers: Result<Vec<f64>, _> = text.split_ascii_whitespace().map(str::parse).collect();
    let Ok(&[a, d, b, e, x, y]) = numbers.as_deref() else {
        let found = text.lines().take(7).collect::<Vec<_>>().join(", ");
        let error = unclear(format!("'{}'", found.chars().take(80).collect::<String>()), EXPECTED);
        return Imported { unplaced: Some(Box::new(error)), ..image };
    };
    let options = source.options;
    if options.window.is_some() || options.overview.is_some_and(|overview| overview > 0) {
        let error =
            unclear("the place of the whole image".into(), "the whole image").with_advice("leave --window and --overview away");
        return Imported { unplaced: Some(Box::new(error)), ..image };
    }
    let tags = Tags::of_affine([x - 0.5 * (a + b), a, b, y - 0.5 * (d + e), d, e]);
    let mut image = image;
    let columns = image.field.columns();
    turn(&mut image.field.heights, columns, tags.turned());
    image.notes.push(format!("its place is that of {name}"));
    let named = options.crs.is_some() || projection.is_some();
    if named {
        let part = Part { window: Window::whole([columns, image.field.rows()]), factor: [1.0; 2] };
        return tags.placed(source, image, part, || Crs::of_user(projection.unwrap_or_default()));
    }
    place::without_system(source, image, Raster { origin: [x, y], step: [a.abs(), e.abs()] })
}

/// The name and the text of the file beside an image: the first and the last letter of its extension and a `w`, the extension and a `w`,
/// or `wld`.
fn beside(path: &Path) -> Option<(String, String)> {
    let extension = path.extension()?.to_str()?;
    let (first, last) = (extension.chars().next()?, extension.chars().next_back()?);
    [format!("{first}{last}w"), format!("{extension}w"), "wld".to_owned()].into_iter().find_map(|extension| {
        let path = path.with_extension(extension);
        let text = std::fs::read_to_string(&path).ok()?;
        Some((path.file_name()?.to_string_lossy().into_owned(), text))
    })
}
