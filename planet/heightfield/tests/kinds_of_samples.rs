//! Kinds of files by their samples: number types, codings, scale, and what stands for no data.

use crate::kinds::{Case, Expect, Right};
use crate::tiff_file::{heights, Kind, TiffFile, Value, SIZE};
use std::path::Path;
use terrane_heightfield::import::{NoData, Options, Window};

const KEYS: [(u16, u16); 3] = [(1024, 1), (1025, 1), (3072, 32_632)];

fn right() -> Right {
    Right { size: SIZE, spacing: Some([10.0; 2]), corner: None, heights: [400.0, 800.0], levels: false, gaps: 0, notes: &[] }
}

fn placed(file: TiffFile) -> TiffFile {
    file.at([5e5, 52e5], [10.0; 2]).keys(&KEYS, &[])
}

fn of(kind: &'static str, number: Kind, bytes: impl Fn(f64) -> Vec<u8>) -> Case {
    Case::new(kind, "a.tif", placed(TiffFile::terrain(number, bytes)).bytes(), Expect::Reads(right()))
}

/// A fixture that GDAL 3.6 wrote: the terrain of `data/dem`, 96 × 64 samples 10 m apart.
pub(crate) fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/dem").join(name)).unwrap()
}

/// Lowest and highest of the fixtures.
pub(crate) const FIXTURE: [f64; 2] = [400.023_376, 802.653_626];

fn fixed(kind: &'static str, name: &'static str, gaps: usize, notes: &'static [&'static str]) -> Case {
    Case::new(kind, name, fixture(name), Expect::Reads(Right { heights: FIXTURE, gaps, notes, ..right() }))
}

pub(crate) fn samples() -> Vec<Case> {
    [types(), codings(), missing(), images()].into_iter().flatten().collect()
}

/// A half float of a height that it can hold.
fn half(height: f64) -> Vec<u8> {
    let exponent = height.log2().floor() as i32;
    let mantissa = (height / f64::from(exponent).exp2() - 1.0) * 1024.0;
    (((exponent + 15) as u16) << 10 | mantissa.round() as u16).to_le_bytes().to_vec()
}

fn types() -> Vec<Case> {
    let item = |role: &str, value: &str| format!("<Item name=\"{role}\" sample=\"0\" role=\"{role}\">{value}</Item>");
    let levels = |full: Right| Right { levels: true, ..full };
    let text = format!("<GDALMetadata>{}{}</GDALMetadata>", item("scale", "0.25"), item("offset", "300"));
    let band = placed(TiffFile::terrain([16, 2], |h| ((4.0 * (h - 300.0)) as i16).to_le_bytes().to_vec()));
    let band = band.tag(42_112, Value::Text(&text)).bytes();
    vec![
        of("TIFF of single floats", [32, 3], |h| (h as f32).to_le_bytes().to_vec()),
        of("TIFF of doubles", [64, 3], |h| h.to_le_bytes().to_vec()),
        of("TIFF of half floats", [16, 3], half),
        of("TIFF of signed integers of 16 bits", [16, 2], |h| (h as i16).to_le_bytes().to_vec()),
        of("TIFF of signed integers of 32 bits", [32, 2], |h| (h as i32).to_le_bytes().to_vec()),
        of("TIFF of unsigned integers of 32 bits", [32, 1], |h| (h as u32).to_le_bytes().to_vec()),
        Case {
            expect: Expect::Reads(Right { heights: [40.0, 80.0], ..right() }),
            ..of("TIFF of signed bytes", [8, 2], |h| vec![(h / 10.0) as u8])
        },
        Case {
            expect: Expect::Reads(levels(right())),
            ..of("TIFF of unsigned integers of 16 bits", [16, 1], |h| (h as u16).to_le_bytes().to_vec())
        },
        Case {
            expect: Expect::Reads(Right { heights: [40.0, 80.0], ..levels(right()) }),
            ..of("TIFF of unsigned bytes", [8, 1], |h| vec![(h / 10.0) as u8])
        },
        Case::new("TIFF of quarter metres above 300 m (scale and offset of the band)", "a.tif", band, Expect::Reads(right())),
    ]
}

fn codings() -> Vec<Case> {
    let left_out: &[&str] = &["12 tiles or strips are left out"];
    let window = Window { column: 40, row: 10, columns: 50, rows: 20 };
    let part = Right {
        size: [50, 20],
        corner: None,
        heights: [crate::tiff_file::height(40, 29), crate::tiff_file::height(89, 10)],
        ..right()
    };
    vec![
        fixed("TIFF in tiles, deflate, floating-point predictor (COG)", "cog.tif", 0, &[]),
        fixed("BigTIFF", "big.tif", 0, &[]),
        fixed("TIFF with ZSTD compression", "zstd.tif", 0, &[]),
        Case::new("TIFF with LERC compression", "lerc.tif", fixture("lerc.tif"), Expect::Refused(&["LERC", "COMPRESS=ZSTD"])),
        fixed("sparse TIFF, deflate", "sparse_d.tif", 3072, left_out),
        fixed("sparse TIFF, uncompressed", "sparse_r.tif", 3072, left_out),
        Case::new("part of a TIFF", "a.tif", placed(TiffFile::floats()).bytes(), Expect::Reads(part))
            .with("--window 40,10,50,20", Options { window: Some(window), ..Options::default() }),
        Case::new(
            "part of a TIFF that it does not have",
            "a.tif",
            placed(TiffFile::floats()).bytes(),
            Expect::Refused(&["from column 40, row 10", "inside 96 x 64"]),
        )
        .with("--window 40,10,57,20", Options { window: Some(Window { columns: 57, ..window }), ..Options::default() }),
    ]
}

/// The terrain with a hole of 5 × 4 samples of some number.
fn holed<const N: usize>(kind: Kind, hole: f64, number: impl Fn(f64) -> [u8; N]) -> TiffFile {
    let inside = |i: usize| (20..25).contains(&(i % 96)) && (30..34).contains(&(i / 96));
    let data = heights().into_iter().enumerate().flat_map(|(i, h)| number(if inside(i) { hole } else { h })).collect();
    placed(TiffFile::new(SIZE, kind, data))
}

fn missing() -> Vec<Case> {
    let float = |hole: f64| holed([32, 3], hole, |h| (h as f32).to_le_bytes());
    let double = |hole: f64| holed([64, 3], hole, f64::to_le_bytes);
    let gaps = |notes: &'static [&'static str]| Expect::Reads(Right { gaps: 20, notes, ..right() });
    let taken: &[&str] = &["20 samples of", "the first at column 20, row 30", "taken as gaps"];
    let case = |kind: &'static str, file: TiffFile, expect: Expect| Case::new(kind, "a.tif", file.bytes(), expect);
    let tag = |text: &'static str| Value::Text(text);
    let stated = |value: f64| Options { no_data: Some(NoData::Value(value)), ..Options::default() };
    let kept = Options { no_data: Some(NoData::Declared), ..Options::default() };
    let below = Right { heights: [-9999.0, 800.0], notes: &["20 heights are hardly possible"], ..right() };
    let all = TiffFile::new(SIZE, [32, 3], vec![0; 4 * 96 * 64]);
    let wild = Right { heights: [-20_000.0, 800.0], notes: &["20 heights are hardly possible", "column 20, row 30"], ..right() };
    vec![
        case("gaps of NaN, undeclared", float(f64::NAN), gaps(&[])),
        case("gaps of NaN, another number declared", float(f64::NAN).tag(42_113, tag("-9999")), gaps(&[])),
        case("gaps of -9999, declared", float(-9999.0).tag(42_113, tag("-9999")), gaps(&[])),
        case("gaps of -9999, undeclared", float(-9999.0), gaps(taken)),
        case("the same", float(-9999.0), Expect::Reads(below)).with("--no-data declared", kept),
        case(
            "gaps of the lowest float, declared",
            float(f64::from(f32::MIN)).tag(42_113, tag("-3.4028234663852886e+38")),
            gaps(&[]),
        ),
        case("gaps of the lowest float, undeclared", float(f64::from(f32::MIN)), gaps(taken)),
        case("gaps of the lowest double, undeclared", double(f64::MIN), gaps(taken)),
        case("gaps of -32768 in 16 bits, undeclared", holed([16, 2], -32_768.0, |h| (h as i16).to_le_bytes()), gaps(taken)),
        case("gaps of 0, named by the user", float(0.0), gaps(&[])).with("--no-data 0", stated(0.0)),
        case("a pit of 20 km", float(-20_000.0), Expect::Reads(wild)),
        case("an infinite height", float(f64::INFINITY), Expect::Refused(&["inf at column 20, row 30", "--no-data"])),
        case("no-data that is no number", float(0.0).tag(42_113, tag("many")), Expect::Refused(&["'many'", "42113"])),
        case("nothing but gaps", all.tag(42_113, tag("0")), Expect::Refused(&["no sample with data"])),
    ]
}

fn images() -> Vec<Case> {
    let grey = || TiffFile::terrain([8, 1], |h| vec![(h / 10.0) as u8]);
    let palette = grey().tag(262, Value::Shorts(&[3])).tag(320, Value::Shorts(&[0; 768])).bytes();
    let white = placed(TiffFile::floats()).tag(262, Value::Shorts(&[0])).bytes();
    let channels = |count: u16, photometric: u16| {
        let data = heights().into_iter().flat_map(|h| vec![(h / 10.0) as u8; usize::from(count)]).collect();
        let bits = vec![8; usize::from(count)];
        TiffFile::new(SIZE, [8, 1], data)
            .tag(258, Value::Shorts(&bits))
            .tag(277, Value::Shorts(&[count]))
            .tag(262, Value::Shorts(&[photometric]))
            .bytes()
    };
    let refused = |kind: &'static str, bytes: Vec<u8>, words: &'static [&'static str]| {
        Case::new(kind, "a.tif", bytes, Expect::Refused(words))
    };
    vec![
        refused("TIFF of a palette", palette, &["palette", "legend"]),
        refused("TIFF of red, green and blue", channels(3, 2), &["RGB(8)", "--encoding"]),
        refused("TIFF of two bands", channels(2, 1), &["gdal_translate -b 1"]),
        refused("TIFF whose 0 is white", white, &["0 is white", "MINISBLACK"]),
    ]
}
