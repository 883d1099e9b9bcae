//! Heightfield files: the same terrain from every format, and each kind of bad file refused with what, where and what next.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::io::Cursor;
use std::path::{Path, PathBuf};
use terrane_heightfield::import::{load, read, Fault, Format, ImportError, Imported, Values, MOST_SAMPLES};
use tiff::encoder::{colortype, Compression, TiffEncoder};
use tiff::tags::Tag;

fn data(name: &str) -> PathBuf {
    let folder = if name.ends_with("tif") { "../recipes" } else { "../../tests/data" };
    Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(name)
}

fn jacksboro() -> Imported {
    load(&data("jacksboro_fault_dem.tif")).unwrap()
}

#[test]
fn formats_agree_about_the_same_terrain() {
    let tiff = jacksboro();
    let png = load(&data("jacksboro_fault_dem.png")).unwrap();
    let raw = load(&data("jacksboro_257.raw")).unwrap();
    assert_eq!([tiff.format, png.format, raw.format], [Format::Tiff, Format::Png, Format::Raw]);
    assert_eq!((tiff.values, png.values), (Values::Metres, Values::Levels { full: 65_535.0 }));
    assert_eq!((tiff.field.columns(), tiff.field.rows(), tiff.no_data, tiff.range), (403, 344, 0, [236.0, 1076.0]));
    assert_eq!(tiff.field, png.field);
    assert_eq!((raw.field.columns(), raw.field.rows()), (257, 257));
    let window = |row: usize| (0..257).map(move |column| (column, row));
    let wrong = (0..257).flat_map(window).filter(|&(c, r)| raw.field.at(c, r) != tiff.field.at(c + 60, r + 40));
    assert_eq!(wrong.count(), 0);
    // The check sees a window that is one column off.
    assert!((0..257).flat_map(window).any(|(c, r)| raw.field.at(c, r) != tiff.field.at(c + 61, r + 40)));
}

#[test]
fn a_geotiff_lies_at_its_stated_site() {
    let tiff = jacksboro();
    let grid = tiff.grid.unwrap();
    let half = 0.5 / 1200.0;
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-5, "{found}, expected {expected}");
    near(grid.west - half, -84.41375);
    near(grid.east(403) + half, -84.07792);
    near(grid.north + half, 36.73292);
    near(grid.south(344) - half, 36.44625);
    let [east, south] = tiff.spacing_m.unwrap();
    assert!((east - 74.5).abs() < 0.2 && (south - 92.5).abs() < 0.2, "{east} {south}");
    assert!(load(&data("jacksboro_fault_dem.png")).unwrap().grid.is_none());
}

/// A tile of one slope with a gap, as SRTM distributes them.
fn tile() -> Vec<u8> {
    let sample = |i: usize| if i == 5 { i16::MIN } else { (i / 1201) as i16 - 300 };
    (0..1201 * 1201).flat_map(|i| sample(i).to_be_bytes()).collect()
}

#[test]
fn an_srtm_tile_is_read() {
    let hgt = read(&tile(), "tiles/N36W085.hgt").unwrap();
    assert_eq!((hgt.format, hgt.values, hgt.no_data, hgt.range), (Format::Hgt, Values::Metres, 1, [-300.0, 900.0]));
    assert!(hgt.field.at(5, 0).is_nan() && hgt.field.at(0, 1200) == 900.0);
    let grid = hgt.grid.unwrap();
    assert_eq!((grid.west, grid.north, grid.south(1201), grid.east(1201)), (-85.0, 37.0, 36.0, -84.0));
    assert!(read(&tile(), "somewhere.hgt").unwrap().grid.is_none());
}

/// Encodes a TIFF of 5 × 3 samples.
fn tiff5x3<C: colortype::ColorType>(samples: &[C::Inner], compression: Compression, no_data: Option<&str>) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
    let mut image = encoder.new_image::<C>(5, 3).unwrap();
    image.rows_per_strip(2).unwrap();
    if let Some(text) = no_data {
        image.encoder().write_tag(Tag::GdalNodata, text).unwrap();
    }
    image.write_data(samples).unwrap();
    bytes.into_inner()
}

fn floats(change: impl Fn(&mut [f32]), no_data: Option<&str>) -> Vec<u8> {
    let mut samples: Vec<f32> = (0..15).map(|i| i as f32 * 1.5 - 4.0).collect();
    change(&mut samples);
    tiff5x3::<colortype::Gray32Float>(&samples, Compression::Lzw, no_data)
}

#[test]
fn each_kind_of_tiff_is_read() {
    let expected: Vec<f32> = (0..15).map(|i| i as f32 * 100.0 - 700.0).collect();
    let signed: Vec<i16> = expected.iter().map(|&h| h as i16).collect();
    for compression in [Compression::Uncompressed, Compression::Lzw, Compression::Deflate(Default::default())] {
        let image = read(&tiff5x3::<colortype::GrayI16>(&signed, compression, None), "a").unwrap();
        assert_eq!((image.field.heights(), image.values), (&expected[..], Values::Metres));
        let image = read(&tiff5x3::<colortype::Gray32Float>(&expected, compression, None), "a").unwrap();
        assert_eq!((image.field.heights(), image.values), (&expected[..], Values::Metres));
    }
    let levels: Vec<u16> = (0..15).map(|i| 65_000 + i).collect();
    let image = read(&tiff5x3::<colortype::Gray16>(&levels, Compression::Lzw, Some("65003")), "a").unwrap();
    assert_eq!((image.values, image.no_data), (Values::Levels { full: 65_535.0 }, 1));
    assert!(image.field.at(3, 0).is_nan() && image.field.at(4, 2) == 65_014.0 && image.grid.is_none());
}

#[test]
fn samples_without_data_are_counted() {
    let count = |change: fn(&mut [f32]), no_data| read(&floats(change, no_data), "a").map(|i| i.no_data);
    assert_eq!(count(|s| (s[2], s[9]) = (-999.0, f32::NAN), Some("nan")), Ok(1));
    assert_eq!(count(|s| (s[2], s[9]) = (-9999.0, -9999.0), Some("-9999 ")), Ok(2));
    // As GDAL writes the lowest float.
    assert_eq!(count(|s| s[0] = f32::MIN, Some("-3.4028234663852886e+38")), Ok(1));
    assert_eq!(count(|_| (), Some("-9999")), Ok(0));
}

/// Checks an error's kind and that its message holds some words.
#[track_caller]
fn assert_refused(result: Result<Imported, ImportError>, fault: Fault, words: &[&str]) {
    let error = result.expect_err("this file should be refused");
    let message = error.to_string();
    assert_eq!(error.fault, fault, "{message}");
    for word in words.iter().chain(&["found", "expected", &error.advice]) {
        assert!(message.contains(word), "{message:?} lacks {word:?}");
    }
}

#[test]
fn samples_that_are_no_heights_are_refused() {
    let infinite = read(&floats(|s| s[14] = f32::INFINITY, Some("-9999")), "f.tif");
    assert_refused(infinite, Fault::Sample, &["f.tif", "inf at column 4, row 2", "--no-data"]);
    assert_refused(read(&floats(|s| s.fill(f32::NAN), Some("nan")), "f.tif"), Fault::Empty, &["no sample with data"]);
    assert_refused(read(&floats(|_| (), Some("many")), "f.tif"), Fault::Damaged, &["'many'", "42113"]);
}

#[test]
fn other_images_are_refused() {
    let none = Compression::Uncompressed;
    let rgb = read(&tiff5x3::<colortype::RGB8>(&[0; 45], none, None), "d.tif");
    assert_eq!(rgb.unwrap_err().fault, Fault::Kind);
    let image = |colour, depth, data: &[u8]| read(&png_image(4, 2, colour, depth, data), "p.png");
    use png::{BitDepth, ColorType};
    for (colour, depth, data, words) in [
        (ColorType::Rgb, BitDepth::Eight, &[0; 24][..], "--encoding"),
        (ColorType::Grayscale, BitDepth::Four, &[0; 4], "4 bits"),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, &[0; 16], "no sample with data"),
    ] {
        let message = image(colour, depth, data).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let grey = image(ColorType::Grayscale, BitDepth::Eight, &[0, 1, 2, 3, 4, 5, 6, 255]).unwrap();
    assert_eq!((grey.values, grey.range), (Values::Levels { full: 255.0 }, [0.0, 255.0]));
}

fn png_image(width: u32, height: u32, colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

#[test]
fn wrong_lengths_are_refused() {
    assert_refused(read(&[0; 4 * 4 * 2 + 2], "a.raw"), Fault::Length, &["a.raw", "34 bytes", "32 (4 x 4) or 50 bytes"]);
    assert_refused(read(&[0; 33], "a.RAW"), Fault::Length, &["33 bytes"]);
    assert_refused(read(&[0; 2], "a.raw"), Fault::Size, &["1 x 1", "at least 2 x 2"]);
    assert_refused(read(&[], "a.raw"), Fault::Size, &["0 x 0"]);
    assert_refused(read(&tile()[2..], "N36W085.hgt"), Fault::Length, &["2884800 bytes", "2884802"]);
    assert_eq!(read(&[1; 8], "a.raw").unwrap().field.heights(), [257.0; 4]);
}

#[test]
fn truncated_files_are_refused() {
    for name in ["jacksboro_fault_dem.tif", "jacksboro_fault_dem.png"] {
        let bytes = std::fs::read(data(name)).unwrap();
        for part in [3, 8, 20, 100, 1000, bytes.len() / 2, bytes.len() - 100] {
            let error = read(&bytes[..part], name).expect_err("a truncated file").to_string();
            assert!(error.contains(name) && error.contains("expected"), "{part} bytes: {error}");
        }
        assert!(read(&bytes, "no extension").is_ok(), "{name} is known by its first bytes");
    }
}

#[test]
fn stated_sizes_that_the_file_cannot_hold_are_refused() {
    // 100,000 x 100,000, and 8,192 x 8,192 in a file of some hundred bytes.
    for (side, fault, word) in [(100_000_u32, Fault::Size, MOST_SAMPLES.to_string()), (8192, Fault::Damaged, "stated in".into())]
    {
        let mut png = png_image(4, 2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 8]);
        png[16..20].copy_from_slice(&side.to_be_bytes());
        png[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = crc32fast::hash(&png[12..29]);
        png[29..33].copy_from_slice(&crc.to_be_bytes());
        assert_refused(read(&png, "bomb.png"), fault, &["bomb.png", &side.to_string(), &word]);
        let mut tiff = tiff5x3::<colortype::Gray16>(&[0; 15], Compression::Uncompressed, None);
        // Width, length and rows a strip, so that the two strips fit.
        for (tag, number) in [([0, 1], side), ([1, 1], side), ([22, 1], side / 2)] {
            let entry = tiff.windows(8).position(|w| w[..2] == tag && w[3..] == [0, 1, 0, 0, 0]).unwrap();
            tiff[entry + 2] = 4;
            tiff[entry + 8..entry + 12].copy_from_slice(&number.to_le_bytes());
        }
        assert_refused(read(&tiff, "bomb.tif"), fault, &["bomb.tif", &side.to_string(), &word]);
    }
}

#[test]
fn unknown_files_are_refused_with_advice() {
    assert_refused(read(b"hello", "notes.txt"), Fault::Format, &["notes.txt", ".r32 or .hgt"]);
    assert_refused(read(b"hello", "a.png"), Fault::Damaged, &["a.png", "[68, 65, 6c, 6c]"]);
    assert_refused(load(Path::new("/no/such.hgt")), Fault::Unreadable, &["/no/such.hgt", "No such file"]);
}
