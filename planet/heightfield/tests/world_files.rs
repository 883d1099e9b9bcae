//! World files beside images say where these lie.

use crate::tiff_file::{height, TiffFile};
use std::path::Path;
use terrane_heightfield::import::{load, load_with, Imported, Options};

/// Writes a TIFF without a place and what lies beside it, and reads it.
fn read(folder: &Path, beside: &[(&str, &str)], options: &Options) -> Imported {
    let image = folder.join("dem.tif");
    std::fs::write(&image, TiffFile::floats().bytes()).unwrap();
    for (name, text) in beside {
        std::fs::write(folder.join(name), text).unwrap();
    }
    load_with(&image, options).unwrap()
}

#[test]
fn their_numbers_and_the_system_beside_them_are_a_place() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(read(folder.path(), &[], &Options::default()).spacing_m, None, "without a world file there is none");
    let world = "30\n0\n0\n-30\n500015\n5099985\n";
    let prj =
        "PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],\
               PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],\
               PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],\
               PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
    for (name, options) in
        [("dem.prj", Options::default()), ("dem.txt", Options { crs: Some("EPSG:32632".into()), ..Options::default() })]
    {
        let folder = tempfile::tempdir().unwrap();
        let image = read(folder.path(), &[("dem.tfw", world), (name, prj)], &options);
        let place = image.georeference.as_ref().unwrap();
        assert_eq!((place.origin, place.step), ([500_015.0, 5_099_985.0], [30.0; 2]), "{place:?}");
        assert_eq!(image.spacing_m, Some([30.0; 2]));
        assert!((place.corners_deg[0][0] - 9.0).abs() < 1e-3 && (place.corners_deg[0][1] - 46.05).abs() < 0.05, "{place:?}");
        assert!(image.notes.iter().any(|note| note.contains("dem.tfw")), "{:?}", image.notes);
    }
}

#[test]
fn south_up_images_are_turned_and_steps_without_a_system_are_metres() {
    let folder = tempfile::tempdir().unwrap();
    let image = read(folder.path(), &[("dem.wld", "25 0 0 25 700000 200000")], &Options::default());
    assert_eq!(image.spacing_m, Some([25.0; 2]));
    let (columns, rows) = (image.field.columns(), image.field.rows());
    assert!(
        (f64::from(image.field.heights()[0]) - height(0, rows - 1)).abs() < 1e-3,
        "the last row of the file is the northern one"
    );
    assert!((f64::from(image.field.heights()[(rows - 1) * columns]) - height(0, 0)).abs() < 1e-3);
}

#[test]
fn what_is_not_understood_is_said() {
    for (world, words) in
        [("30 0 0", "six numbers"), ("0.001 0 0 -0.001 9 46", "may be degrees"), ("30 0 0 steps 1 2", "in dem.tfw")]
    {
        let folder = tempfile::tempdir().unwrap();
        let image = read(folder.path(), &[("dem.tfw", world)], &Options::default());
        let error = image.unplaced.unwrap_or_else(|| panic!("'{world}' was read")).to_string();
        assert!(error.contains(words), "{error}");
    }
    // A place of its own goes before the file beside it.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.tif");
    std::fs::write(&path, TiffFile::floats().at([9.0, 46.0], [0.001; 2]).keys(&[(1024, 2), (2048, 4326)], &[]).bytes()).unwrap();
    std::fs::write(folder.path().join("own.tfw"), "30 0 0 -30 0 0").unwrap();
    let image = load(&path).unwrap();
    assert!(image.grid.is_some() && image.notes.iter().all(|note| !note.contains("own.tfw")), "{:?}", image.notes);
}
