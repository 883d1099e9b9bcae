//! With the feature `gdal`: files that no reader here knows are read as GDAL reads them, with their place; without it their messages
//! name the feature.

use std::path::{Path, PathBuf};
use terrane_heightfield::import::load;

fn dem(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/dem").join(name)
}

/// A mosaic of one file, as gdalbuildvrt writes them.
fn mosaic(folder: &Path) -> PathBuf {
    let source = dem("utm.tif");
    let text = format!(
        "<VRTDataset rasterXSize=\"96\" rasterYSize=\"64\"><SRS>EPSG:32632</SRS>\
         <GeoTransform>500000, 10, 0, 5200000, 0, -10</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>\
         <SourceFilename relativeToVRT=\"0\">{}</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>",
        source.display()
    );
    let path = folder.join("a.vrt");
    std::fs::write(&path, text).unwrap();
    path
}

#[cfg(not(feature = "gdal"))]
#[test]
fn without_gdal_the_message_names_the_feature() {
    let folder = tempfile::tempdir().unwrap();
    let message = load(&mosaic(folder.path())).unwrap_err().to_string();
    assert!(message.contains("a.vrt: found no format that can be told") && message.contains("--features gdal"), "{message}");
    eprintln!("skipped: reading by GDAL, which this build is without");
}

#[cfg(feature = "gdal")]
mod with_gdal {
    use super::*;
    use terrane_heightfield::import::{load_with, Format, Options, Window};

    #[test]
    fn what_no_reader_here_knows_is_read_by_gdal() {
        let folder = tempfile::tempdir().unwrap();
        let ours = load(&dem("utm.tif")).unwrap();
        for path in [mosaic(folder.path()), dem("lerc.tif")] {
            let theirs = match load(&path) {
                Err(error) if error.to_string().contains("LERC") => {
                    eprintln!("skipped: this GDAL knows no LERC");
                    continue;
                }
                read => read.unwrap(),
            };
            assert_eq!((theirs.format, theirs.field == ours.field), (Format::Gdal, true), "{}", path.display());
            assert_eq!((&theirs.georeference, theirs.spacing_m), (&ours.georeference, ours.spacing_m));
            assert!(theirs.notes[0].contains("read by GDAL"), "{:?}", theirs.notes);
        }
    }

    #[test]
    fn gdal_reads_windows() {
        let folder = tempfile::tempdir().unwrap();
        let window = Window { column: 10, row: 20, columns: 30, rows: 40 };
        let options = Options { window: Some(window), ..Options::default() };
        let [ours, theirs] = [dem("utm.tif"), mosaic(folder.path())].map(|path| load_with(&path, &options).unwrap());
        assert_eq!((&theirs.field, &theirs.georeference), (&ours.field, &ours.georeference));
        assert_ne!(theirs.field, load(&dem("utm.tif")).unwrap().field);
    }

    #[test]
    fn what_gdal_does_not_know_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        std::fs::write(&path, "hello").unwrap();
        let message = load(&path).unwrap_err().to_string();
        assert!(message.contains("no format that can be told"), "{message}");
    }
}
