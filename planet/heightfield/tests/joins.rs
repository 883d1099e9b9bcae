//! Tiles that touch become one raster without a seam; tiles that do not are refused.

use crate::tiff_file::{Kind, TiffFile};
use terrane_heightfield::import::{join, read, Fault, Imported};

const F32: Kind = [32, 3];

/// Ground over a plane of columns and rows that all tiles have in common.
fn ground(column: usize, row: usize) -> f32 {
    (500.0 + (column as f64 * 0.37).sin() * 40.0 + row as f64 * 0.25) as f32
}

/// A tile of 20 × 16 samples from a column and a row on, 10 m apart, by the corners of areas or by samples.
fn tile([column, row]: [usize; 2], code: u16, point: bool) -> Vec<u8> {
    let data = (0..20 * 16).flat_map(|i| ground(column + i % 20, row + i / 20).to_le_bytes()).collect();
    let keys = [(1024, 1), (1025, if point { 2 } else { 1 }), (3072, code)];
    let at = [5e5 + 10.0 * column as f64, 52e5 - 10.0 * row as f64];
    TiffFile::new([20, 16], F32, data).at(at, [10.0; 2]).keys(&keys, &[]).bytes()
}

fn named(files: &[Vec<u8>]) -> Vec<(String, Imported)> {
    files.iter().enumerate().map(|(k, bytes)| (format!("{k}.tif"), read(bytes, "a.tif").unwrap())).collect()
}

fn wrong(image: &Imported, [column, row]: [usize; 2]) -> usize {
    let columns = image.field.columns();
    let same = |(i, &h): (usize, &f32)| h == ground(column + i % columns, row + i / columns);
    image.field.heights().iter().enumerate().filter(|&sample| !same(sample)).count()
}

#[test]
fn tiles_that_touch_have_no_seam() {
    // Side by side as areas are, with a border of samples in common, and overlapping; the first file is not the north-western one.
    for (step, point) in [(20, false), (19, true), (15, false)] {
        let files = [[step, 0], [0, 0], [0, step - 4], [step, step - 4]].map(|at| tile(at, 32_632, point));
        let joined = join(named(&files)).unwrap();
        assert_eq!([joined.field.columns(), joined.field.rows()], [20 + step, 16 + step - 4]);
        assert_eq!((wrong(&joined, [0, 0]), joined.no_data, joined.spacing_m), (0, 0, Some([10.0; 2])), "{step}");
        assert!(wrong(&joined, [1, 0]) > 0, "the check sees a shift");
        let half = if point { 0.0 } else { 5.0 };
        assert_eq!(joined.georeference.unwrap().origin, [5e5 + half, 52e5 - half]);
    }
}

#[test]
fn where_no_tile_lies_there_is_a_gap() {
    let joined = join(named(&[[0, 0], [20, 0], [0, 16]].map(|at| tile(at, 32_632, false)))).unwrap();
    assert_eq!((joined.field.columns(), joined.field.rows(), joined.no_data), (40, 32, 20 * 16));
    assert!(joined.field.at(39, 31).is_nan() && joined.field.at(39, 15) == ground(39, 15));
}

#[test]
fn a_gap_of_one_tile_takes_the_samples_of_another() {
    let mut files = named(&[[0, 0], [15, 0]].map(|at| tile(at, 32_632, false)));
    let holed: Vec<f32> =
        files[0].1.field.heights().iter().enumerate().map(|(i, &h)| if i % 20 > 15 { f32::NAN } else { h }).collect();
    files[0].1.field = terrane_heightfield::Heightfield::new(20, 16, holed).unwrap();
    let joined = join(files).unwrap();
    assert_eq!((joined.no_data, wrong(&joined, [0, 0])), (0, 0));
}

#[test]
fn neighbouring_srtm_tiles_share_their_border() {
    let tile = |west: usize| {
        let bytes: Vec<u8> = (0..1201 * 1201).flat_map(|i| ((west + i % 1201 + i / 1201) as i16).to_be_bytes()).collect();
        bytes
    };
    let files = [(tile(0), "N36W085.hgt"), (tile(1200), "N36W084.hgt")];
    let joined = join(files.map(|(bytes, name)| (name.to_owned(), read(&bytes, name).unwrap())).into()).unwrap();
    assert_eq!([joined.field.columns(), joined.field.rows()], [2401, 1201]);
    let off = (0..2401 * 1201).filter(|i| joined.field.heights()[*i] != (i % 2401 + i / 2401) as f32).count();
    let grid = joined.grid.unwrap();
    assert_eq!((off, grid.west, grid.north), (0, -85.0, 37.0));
    assert!((grid.east(2401) + 83.0).abs() < 1e-9 && (grid.south(1201) - 36.0).abs() < 1e-9);
}

#[test]
fn tiles_that_do_not_fit_are_refused() {
    let first = || tile([0, 0], 32_632, false);
    let plain = TiffFile::new([20, 16], F32, vec![0; 4 * 320]).bytes();
    let unknown = TiffFile::new([20, 16], F32, vec![0; 4 * 320]).at([5e5, 52e5], [10.0; 2]).bytes();
    let coarse = TiffFile::new([20, 16], F32, vec![0; 4 * 320])
        .at([500_200.0, 52e5], [20.0; 2])
        .keys(&[(1024, 1), (3072, 32_632)], &[])
        .bytes();
    let between = TiffFile::new([20, 16], F32, vec![0; 4 * 320])
        .at([500_203.0, 52e5], [10.0; 2])
        .keys(&[(1024, 1), (3072, 32_632)], &[])
        .bytes();
    let cases: [(Vec<u8>, &str); 6] = [
        (tile([21, 0], 32_632, false), "touches none of the others"),
        (tile([20, 0], 32_633, false), "found EPSG:32633, expected EPSG:32632"),
        (coarse, "steps of 20 x 20"),
        (between, "samples between those"),
        (plain, "does not state its place"),
        (unknown, "no coordinate system"),
    ];
    for (other, words) in cases {
        let error = join(named(&[first(), other])).expect_err(words);
        assert!(
            error.fault == Fault::Apart && error.to_string().contains(words) && error.to_string().contains("1.tif"),
            "{error}"
        );
    }
}
