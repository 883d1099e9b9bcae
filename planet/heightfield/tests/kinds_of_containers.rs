//! Kinds of files by format: grids in ASCII, SRTM tiles, files without a header, images, compressed ones.

use crate::kinds::{Case, Expect, Right};
use crate::tiff_file::{height, heights, TiffFile, SIZE};
use std::io::{Cursor, Write};
use terrane_heightfield::import::{Encoding, Options, RawType};

fn right(spacing: Option<[f64; 2]>) -> Right {
    Right { size: SIZE, spacing, corner: None, heights: [400.0, 800.0], levels: false, gaps: 0, notes: &[] }
}

fn levels(heights: [f64; 2]) -> Expect {
    Expect::Reads(Right { levels: true, heights, ..right(None) })
}

pub(crate) fn containers() -> Vec<Case> {
    [grids(), tiles(), headerless(), pictures(), others()].into_iter().flatten().collect()
}

/// An ASCII grid of the terrain under a header.
fn grid(header: &str) -> Vec<u8> {
    let row = |r: usize| (0..96).map(|c| height(c, r).to_string()).collect::<Vec<_>>().join(" ");
    (format!("ncols 96\nnrows 64\n{header}\n") + &(0..64).map(row).collect::<Vec<_>>().join("\n")).into_bytes()
}

fn grids() -> Vec<Case> {
    let metres = "xllcorner 500000\nyllcorner 5199360\ncellsize 10\nNODATA_value -9999";
    let degrees = "xllcenter -84\nyllcenter 36\ncellsize 0.0002777777777778";
    let taken = Right { notes: &["its steps are taken as metres"], ..right(Some([10.0; 2])) };
    let crs = |code: &str| Options { crs: Some(code.into()), ..Options::default() };
    let latitude = 36.0 + 31.5 / 3600.0;
    let c = |k: f64| (k * f64::to_radians(latitude)).cos();
    let second = [111_412.84 * c(1.0) - 93.5 * c(3.0), 111_132.92 - 559.82 * c(2.0) + 1.175 * c(4.0)].map(|d| d / 3600.0);
    let second = Right { corner: Some([-84.0, 36.0 + 63.0 / 3600.0]), ..right(Some(second)) };
    let gap = String::from_utf8_lossy(&grid(metres)).replacen("\n450 ", "\n-9999 ", 1).into_bytes();
    vec![
        Case::new("Esri ASCII grid, lengths", "a.asc", grid(metres), Expect::Reads(taken.clone())),
        Case::new("the same", "a.asc", grid(metres), Expect::Reads(right(Some([10.0; 2]))))
            .with("--crs EPSG:32632", crs("EPSG:32632")),
        Case::new("Esri ASCII grid with a gap", "a.asc", gap, Expect::Reads(Right { gaps: 1, ..taken.clone() })),
        Case::new(
            "Esri ASCII grid with cells that are not square",
            "a.asc",
            grid("xllcorner 500000\nyllcorner 5199360\ndx 10\ndy 20"),
            Expect::Reads(Right { spacing: Some([10.0, 20.0]), ..taken }),
        ),
        Case::new(
            "Esri ASCII grid, steps that may be degrees",
            "a.asc",
            grid(degrees),
            Expect::Refused(&["may be degrees", "--crs"]),
        ),
        Case::new("the same", "a.asc", grid(degrees), Expect::Reads(second)).with("--crs EPSG:4269", crs("EPSG:4269")),
        Case::new(
            "Esri ASCII grid with too few heights",
            "a.asc",
            grid(metres)[..20_000].to_vec(),
            Expect::Refused(&["heights", "6144"]),
        ),
    ]
}

/// An SRTM tile that rises to the north-east, with one gap and some spikes.
fn tile([columns, rows]: [usize; 2], spikes: usize) -> Vec<u8> {
    let sample = |i: usize| match i {
        0 => i16::MIN,
        i if (1..=spikes).contains(&i) => i16::MAX,
        i => (400 + 200 * (i % columns) / (columns - 1) + 200 * (rows - 1 - i / columns) / (rows - 1)) as i16,
    };
    (0..columns * rows).flat_map(|i| sample(i).to_be_bytes()).collect()
}

/// An archive that holds some files.
fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut file = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    file.write_all(bytes).unwrap();
    file.finish().unwrap()
}

fn tiles() -> Vec<Case> {
    let c = |latitude: f64, k: f64| (k * latitude.to_radians()).cos();
    let length = |latitude: f64, columns: usize, rows: usize| {
        let c = |k: f64| c(latitude, k);
        let degree = [111_412.84 * c(1.0) - 93.5 * c(3.0) + 0.118 * c(5.0), 111_132.92 - 559.82 * c(2.0) + 1.175 * c(4.0)];
        Some([degree[0] / (columns - 1) as f64, degree[1] / (rows - 1) as f64])
    };
    let small =
        Right { size: [1201, 1201], spacing: length(36.5, 1201, 1201), corner: Some([-85.0, 37.0]), gaps: 1, ..right(None) };
    let reads = || Expect::Reads(small.clone());
    let north = Right {
        size: [1801, 3601],
        spacing: length(60.5, 1801, 3601),
        corner: Some([10.0, 61.0]),
        gaps: 1,
        notes: &["3 % longer"],
        ..right(None)
    };
    let spiked = Right { gaps: 4, notes: &["3 spikes of 32767"], ..small.clone() };
    let plain = tile([1201, 1201], 0);
    vec![
        Case::new("SRTM tile of 3 seconds", "N36W085.hgt", plain.clone(), reads()),
        Case::new("SRTM tile far north, 1801 × 3601", "N60E010.hgt", tile([1801, 3601], 0), Expect::Reads(north)),
        Case::new("SRTM tile with spikes of 32767", "N36W085.hgt", tile([1201, 1201], 3), Expect::Reads(spiked)),
        Case::new("SRTM tile, gzip", "N36W085.hgt.gz", gzipped(&plain), reads()),
        Case::new("SRTM tile in a zip archive", "any.zip", zipped(&[("N36W085.hgt", &plain), ("readme.txt", b"hello")]), reads()),
        Case::new(
            "zip archive of two tiles",
            "any.zip",
            zipped(&[("N36W085.hgt", b""), ("N36W084.hgt", b"")]),
            Expect::Refused(&["2 elevation files", "unpack"]),
        ),
        Case::new(
            "SRTM tile whose name tells no place",
            "tile.hgt",
            plain.clone(),
            Expect::Reads(Right { spacing: None, corner: None, ..small.clone() }),
        ),
        Case::new(
            "SRTM tile that is cut off",
            "N36W085.hgt",
            plain[2..].to_vec(),
            Expect::Refused(&["2884800 bytes", "2884802"]),
        ),
    ]
}

fn headerless() -> Vec<Case> {
    let of = |bytes: &dyn Fn(f64) -> Vec<u8>| heights().into_iter().flat_map(bytes).collect::<Vec<u8>>();
    let sized = |name: &str| Options { raw_size: Some(SIZE), raw_type: RawType::named(name), ..Options::default() };
    let size = Options { raw_size: Some(SIZE), ..Options::default() };
    let shorts = of(&|h| (h as u16).to_le_bytes().to_vec());
    let square = |i: usize| height((i % 64) * 95 / 63, i / 64) as u16;
    let square: Vec<u8> = (0..64 * 64).flat_map(|i| square(i).to_le_bytes()).collect();
    vec![
        Case::new(
            "Terragen RAW, a square",
            "a.raw",
            square,
            Expect::Reads(Right { size: [64, 64], levels: true, ..right(None) }),
        ),
        Case::new("`.r16` that is not square", "a.r16", shorts.clone(), Expect::Refused(&["12288 bytes", "--raw-size"])),
        Case::new("the same", "a.r16", shorts.clone(), levels([400.0, 800.0])).with("--raw-size 96x64", size.clone()),
        Case::new(
            "the same, said wrongly",
            "a.r16",
            shorts,
            Expect::Refused(&["12288 bytes", "96 x 64 samples of 4 bytes, 24576"]),
        )
        .with("--raw-size 96x64 --raw-type f32le", sized("f32le")),
        Case::new("`.r32` of metres", "a.r32", of(&|h| (h as f32).to_le_bytes().to_vec()), Expect::Reads(right(None)))
            .with("--raw-size 96x64", size.clone()),
        Case::new("`.r32` from 0 to 1", "a.r32", of(&|h| ((h / 1000.0) as f32).to_le_bytes().to_vec()), levels([0.4, 0.8]))
            .with("--raw-size 96x64", size),
        Case::new("bytes", "a.bin", of(&|h| vec![(h / 10.0) as u8]), levels([40.0, 80.0]))
            .with("--raw-size 96x64 --raw-type u8", sized("u8")),
        Case::new(
            "signed shorts, highest byte first",
            "a.bin",
            of(&|h| (h as i16).to_be_bytes().to_vec()),
            Expect::Reads(right(None)),
        )
        .with("--raw-size 96x64 --raw-type i16be", sized("i16be")),
        Case::new("doubles, highest byte first", "a.bin", of(&|h| h.to_be_bytes().to_vec()), Expect::Reads(right(None)))
            .with("--raw-size 96x64 --raw-type f64be", sized("f64be")),
        Case::new("integers of 32 bits", "a.bin", of(&|h| (h as i32).to_le_bytes().to_vec()), Expect::Reads(right(None)))
            .with("--raw-size 96x64 --raw-type i32le", sized("i32le")),
    ]
}

fn png(colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 96, 64);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == png::ColorType::Indexed {
        encoder.set_palette(vec![0; 768]);
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn pictures() -> Vec<Case> {
    use png::{BitDepth, ColorType};
    let of = |bytes: &dyn Fn(f64) -> Vec<u8>| heights().into_iter().flat_map(bytes).collect::<Vec<u8>>();
    let terrarium = of(&|h| {
        let code = ((h + 32_768.0) * 256.0) as u32;
        vec![(code >> 16) as u8, (code >> 8) as u8, code as u8]
    });
    let terrarium = png(ColorType::Rgb, BitDepth::Eight, &terrarium);
    let mapbox = of(&|h| {
        let code = ((h + 10_000.0) * 10.0).round() as u32;
        vec![(code >> 16) as u8, (code >> 8) as u8, code as u8]
    });
    let mapbox = png(ColorType::Rgb, BitDepth::Eight, &mapbox);
    let coded = |encoding| Options { encoding: Some(encoding), ..Options::default() };
    let wide = png(ColorType::Grayscale, BitDepth::Sixteen, &of(&|h| (h as u16).to_be_bytes().to_vec()));
    let bytes = of(&|h| vec![(h / 10.0) as u8]);
    let mut holes = of(&|h| [(h as u16).to_be_bytes(), [255; 2]].concat());
    holes[2..4].fill(0);
    let holes = png(ColorType::GrayscaleAlpha, BitDepth::Sixteen, &holes);
    let gap = Right { levels: true, gaps: 1, ..right(None) };
    let case = |kind: &'static str, bytes: &[u8], expect: Expect| Case::new(kind, "a.png", bytes.to_vec(), expect);
    vec![
        case("PNG of 16 bits", &wide, levels([400.0, 800.0])),
        case("PNG of 8 bits", &png(ColorType::Grayscale, BitDepth::Eight, &bytes), levels([40.0, 80.0])),
        case("PNG of 16 bits with a transparent sample", &holes, Expect::Reads(gap)),
        case("PNG of Terrarium's colours", &terrarium, Expect::Refused(&["Rgb", "--encoding terrarium or mapbox"])),
        case("the same", &terrarium, Expect::Reads(right(None))).with("--encoding terrarium", coded(Encoding::Terrarium)),
        case("PNG of Mapbox's colours", &mapbox, Expect::Reads(Right { heights: [400.0, 800.0], ..right(None) }))
            .with("--encoding mapbox", coded(Encoding::Mapbox)),
        case("greyscale PNG, said to be colours", &wide, Expect::Refused(&["leave --encoding away"]))
            .with("--encoding mapbox", coded(Encoding::Mapbox)),
        case("PNG of a palette", &png(ColorType::Indexed, BitDepth::Eight, &bytes), Expect::Refused(&["Indexed", "legend"])),
    ]
}

fn others() -> Vec<Case> {
    let tiff = TiffFile::floats().at([5e5, 52e5], [10.0; 2]).keys(&[(1024, 1), (3072, 32_632)], &[]).bytes();
    vec![
        Case::new("GeoTIFF, gzip", "a.tif.gz", gzipped(&tiff), Expect::Reads(right(Some([10.0; 2])))),
        Case::new("TIFF that is cut off", "a.tif", tiff[..10_000].to_vec(), Expect::Refused(&["a.tif"])),
        Case::new(
            "another format",
            "a.nc",
            b"CDF\x01 and more".to_vec(),
            Expect::Refused(&["no format that can be told", "GDAL"]),
        ),
    ]
}
