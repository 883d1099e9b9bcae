//! Heightmap layers: files that know their site lie there at true scale, gaps leave the ground alone, and recipes that do
//! not fit their file are refused.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use glam::DVec3;
use std::io::Cursor;
use std::path::Path;
use terrane_heightfield::import::load;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::recipe::{Asset, Recipe};
use terrane_planet::terrain::Terrain;
use tiff::encoder::{colortype, TiffEncoder};
use tiff::tags::Tag;

const EARTH: f64 = 6_371_000.0;

/// Terrain of one heightmap over a plane of height 0.
fn mapped(name: &str, bytes: Vec<u8>, keys: &str) -> Result<Terrain, String> {
    let text = format!(
        "name = \"T\"\nradius_m = {EARTH:.1}\nseed = 1\n[[layer]]\nkind = \"heightmap\"\nfile = \"{name}\"\n{keys}\n\
         [palette]\nkind = \"airless\"\nhighland = [1, 2, 3]\nmare = [1, 2, 3]\nray = [1, 2, 3]\nmare_m = [0, 1]\npatch_m = 500\n"
    );
    let recipe = Recipe::from_parts(&text, "t.toml", vec![Asset { name: name.into(), bytes }]).map_err(|e| e.to_string())?;
    Terrain::new(&recipe).map_err(|e| e.to_string())
}

/// GeoTIFF keys: coordinates in degrees on WGS 84, samples at points.
const GEOGRAPHIC: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4326];

/// A 64 × 32 GeoTIFF with steps of 1/100 degree whose first sample lies at a site; no data is -32768.
fn geotiff([north, west]: [f64; 2], keys: &[u16], sample: impl Fn(usize, usize) -> i16) -> Vec<u8> {
    let samples: Vec<i16> = (0..64 * 32).map(|i| sample(i % 64, i / 64)).collect();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<colortype::GrayI16>(64, 32).unwrap();
    image.encoder().write_tag(Tag::ModelPixelScaleTag, &[0.01, 0.01, 0.0][..]).unwrap();
    image.encoder().write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, west, north, 0.0][..]).unwrap();
    image.encoder().write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
    image.encoder().write_tag(Tag::GdalNodata, "-32768").unwrap();
    image.write_data(&samples).unwrap();
    bytes.into_inner()
}

fn at(terrain: &Terrain, latitude: f64, longitude: f64) -> f64 {
    terrain.height(direction_at(latitude, longitude))
}

#[test]
fn a_file_lies_where_it_says() {
    // A peak at column 40, row 10; the second site crosses the date line.
    for [north, west] in [[36.0, -85.0], [-12.0, 179.8]] {
        let peak = |c: usize, r: usize| if (c, r) == (40, 10) { 900 } else { 100 };
        let terrain =
            mapped("m.tif", geotiff([north, west], &GEOGRAPHIC, peak), "placement = \"file\"\nblend_m = 2000.0").unwrap();
        let near = |latitude: f64, longitude: f64, expected: f64| {
            let found = at(&terrain, latitude, longitude);
            assert!((found - expected).abs() < 1e-3, "{found}, expected {expected} at {latitude}, {longitude}");
        };
        near(north - 0.1, west + 0.4, 900.0);
        near(north - 0.12, west + 0.4, 100.0);
        near(north - 0.1, west + 0.38, 100.0);
        // Beyond the outermost samples the ground is as before, and in the middle of the blend half-way.
        for (south, east) in [(-0.001, 0.3), (0.311, 0.3), (0.15, -0.001), (0.15, 0.631)] {
            near(north - south, west + east, 0.0);
        }
        near(north - 1000.0 / (EARTH.to_radians()), west + 0.3, 50.0);
        near(-north, west, 0.0);
        near(north, west + 180.0, 0.0);
    }
}

#[test]
fn a_file_in_degrees_is_to_scale() {
    // At 60 degrees a step east is half a step south. The map is put at the equator with its own size: 64 steps east.
    let column = |c: usize, _: usize| i16::from(c >= 32) * 500;
    let row = |_: usize, r: usize| i16::from(r >= 16) * 500;
    let keys = "latitude_deg = 0.0\nlongitude_deg = 20.0\nblend_m = 0.0";
    let degree = EARTH.to_radians();
    let edge = |sample: &dyn Fn(usize, usize) -> i16, step: &dyn Fn(f64) -> [f64; 2]| {
        let terrain = mapped("m.tif", geotiff([60.155, 10.0], &GEOGRAPHIC, sample), keys).unwrap();
        (1..60_000).map(f64::from).find(|m| {
            let [north, east] = step(*m);
            at(&terrain, north / degree, 20.0 + east / degree) == 0.0
        })
    };
    let east = edge(&column, &|m| [0.0, m]).unwrap();
    let south = edge(&row, &|m| [-m, 0.0]).unwrap();
    // A degree at latitude 60 is 55,800 m of longitude and 111,412 m of latitude.
    assert!((east - 32.0 * 558.0).abs() < 30.0 && (south - 16.0 * 1114.1).abs() < 30.0, "{east} {south}");
}

#[test]
fn gaps_leave_the_ground_as_before_and_fade_out() {
    let gap = |c: usize, r: usize| if (30..34).contains(&c) && (14..18).contains(&r) { i16::MIN } else { 1000 };
    let map = geotiff([10.0, 10.0], &GEOGRAPHIC, gap);
    let terrain = mapped("m.tif", map, "placement = \"file\"\nblend_m = 100.0").unwrap();
    let on = |c: f64| at(&terrain, 10.0 - 0.155, 10.0 + 0.01 * c);
    assert_eq!(on(31.5), 0.0, "in the gap the ground is as before");
    assert!((on(20.0) - 1000.0).abs() < 1e-6, "away from the gap the map counts fully");
    let profile: Vec<f64> = (0..1200).map(|k| on(20.0 + f64::from(k) * 0.01)).collect();
    assert!(profile.windows(2).all(|w| w[0] >= w[1] && w[0] - w[1] < 5.0), "the map fades out without a step");
    assert_eq!(terrain.height_range(), (-0.5, 1000.5));
}

#[test]
fn metres_are_scaled_and_offset_as_stated() {
    let map = || geotiff([10.0, 10.0], &GEOGRAPHIC, |c, _| if c < 20 { -200 } else { 800 });
    let height = |keys: &str| {
        let terrain = mapped("m.tif", map(), &format!("placement = \"file\"\n{keys}")).unwrap();
        (at(&terrain, 9.85, 10.4), terrain.height_range())
    };
    let near = |(found, range): (f64, (f64, f64)), expected: f64, bounds: (f64, f64)| {
        assert!((found - expected).abs() < 1e-6 && range == bounds, "{found} {range:?}");
    };
    near(height(""), 800.0, (-200.5, 800.5));
    near(height("scale = 0.5\noffset_m = -1000.0"), -600.0, (-1100.5, 0.5));
}

#[test]
fn recipes_that_do_not_fit_their_file_are_refused() {
    let known = geotiff([36.0, -85.0], &GEOGRAPHIC, |_, _| 5);
    let polar = geotiff([86.0, -85.0], &GEOGRAPHIC, |_, _| 5);
    let nowhere = geotiff([36.0, -85.0], &[1, 1, 0, 0], |_, _| 5);
    let raw = vec![1; 2 * 64 * 64];
    let cases: [(&str, &Vec<u8>, &str, &[&str]); 11] = [
        ("m.tif", &nowhere, "placement = \"file\"", &["does not state its place", "latitude_deg"]),
        ("m.tif", &polar, "placement = \"file\"", &["latitudes 85.690 and 86", "within 85 degrees"]),
        ("m.tif", &known, "placement = \"file\"\nblend_m = 30000", &["`blend_m` of 30000", "half the map"]),
        ("m.tif", &known, "placement = \"here\"", &["`layer[0].placement`", "\"here\"", "\"file\""]),
        ("m.tif", &known, "placement = \"file\"\nlatitude_deg = 3", &["`layer[0].latitude_deg`", "unknown key"]),
        ("m.tif", &known, "range_m = [0, 1]", &["`range_m` for a TIFF in metres", "`scale`"]),
        ("m.tif", &known, "range_m = [0, 1]\nscale = 2", &["`layer[0].scale`", "beside `range_m`"]),
        ("m.raw", &raw, "", &["RAW of levels from 0 to 65535", "`range_m`"]),
        ("m.raw", &raw, "range_m = [0, 9]", &["64 x 64 samples", "twice as wide as high"]),
        ("m.raw", &raw, "range_m = [0, 9]\nlatitude_deg = 1\nlongitude_deg = 2", &["does not state its spacing", "`width_m`"]),
        ("m.raw", &vec![1; 3], "range_m = [0, 9]", &["3 bytes", "square", "without a header"]),
    ];
    for (name, bytes, keys, words) in cases {
        let message = mapped(name, bytes.clone(), keys).err().unwrap_or_else(|| panic!("accepted: {keys}"));
        for word in words.iter().chain(&["t.toml:"]) {
            assert!(message.contains(word), "{message:?} lacks {word:?}");
        }
    }
    let tall = mapped("m.tif", geotiff([36.0, -85.0], &GEOGRAPHIC, |_, _| 32_000), "scale = 4");
    assert!(tall.err().unwrap().contains("heights from 128000 to 128000 m"));
    assert!(mapped("m.raw", raw, "range_m = [0, 9]\nlatitude_deg = 1\nlongitude_deg = 2\nwidth_m = 500").is_ok());
}

#[test]
fn jacksboro_lies_at_its_site() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes");
    let recipe = Recipe::load(&folder.join("jacksboro.toml")).unwrap();
    let file = load(&folder.join("jacksboro_fault_dem.tif")).unwrap();
    let (terrain, grid) = (Terrain::new(&recipe).unwrap(), file.grid.unwrap());
    let mut worst: f64 = 0.0;
    for (column, row) in (48..355).step_by(7).flat_map(|c| (40..304).step_by(7).map(move |r| (c, r))) {
        let [north, east] = [grid.north - row as f64 * grid.step_south, grid.west + column as f64 * grid.step_east];
        let wanted = f64::from(file.field.at(column, row));
        worst = worst.max((terrain.height(direction_at(north, east)) - wanted).abs());
    }
    // The recipe adds finer relief to the file's heights.
    assert!(worst > 0.0 && worst < 15.0, "{worst} m");
    // No step where the data ends: beside every edge the ground rises no more than hills do.
    let step = |a: DVec3, b: DVec3| (terrain.height(a) - terrain.height(b)).abs() / (a.distance(b) * recipe.radius);
    for k in 0..200 {
        let t = f64::from(k) / 200.0;
        let (latitude, longitude) = (36.44625 + t * 0.28667, -84.41375 + t * 0.33583);
        for (a, b) in
            [([latitude, -84.41375], [0.0, 2e-4]), ([latitude, -84.07792], [0.0, 2e-4]), ([36.44625, longitude], [2e-4, 0.0])]
        {
            let (inner, outer) = (direction_at(a[0] + b[0], a[1] + b[1]), direction_at(a[0] - b[0], a[1] - b[1]));
            assert!(step(inner, outer) < 0.8, "{} at {a:?}", step(inner, outer));
        }
    }
}
