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
    mapped_on(EARTH, vec![Asset { name: name.into(), bytes }], keys)
}

/// The same on a planet of another radius, of several files.
fn mapped_on(radius: f64, assets: Vec<Asset>, keys: &str) -> Result<Terrain, String> {
    let names: Vec<&str> = assets.iter().map(|asset| asset.name.as_str()).collect();
    let files = if names.len() == 1 { format!("\"{}\"", names[0]) } else { format!("{names:?}") };
    let text = format!(
        "name = \"T\"\nradius_m = {radius:.1}\nseed = 1\n[[layer]]\nkind = \"heightmap\"\nfile = {files}\n{keys}\n\
         [palette]\nkind = \"airless\"\nhighland = [1, 2, 3]\nmare = [1, 2, 3]\nray = [1, 2, 3]\nmare_m = [0, 1]\npatch_m = 500\n"
    );
    let recipe = Recipe::from_parts(&text, "t.toml", assets).map_err(|e| e.to_string())?;
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
        ("m.tif", &nowhere, "placement = \"file\"", &["no coordinate system", "`crs`"]),
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

/// A GeoTIFF of doubles: 64 × 32 samples from a north-western sample on, with keys and doubles beside them.
fn doubles(at: [f64; 2], step: f64, keys: &[u16], beside: &[f64], sample: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let samples: Vec<f64> = (0..64 * 32).map(|i| sample(i % 64, i / 64)).collect();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<colortype::Gray64Float>(64, 32).unwrap();
    image.encoder().write_tag(Tag::ModelPixelScaleTag, &[step, step, 0.0][..]).unwrap();
    image.encoder().write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, at[0], at[1], 0.0][..]).unwrap();
    image.encoder().write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
    image.encoder().write_tag(Tag::GeoDoubleParamsTag, beside).unwrap();
    image.write_data(&samples).unwrap();
    bytes.into_inner()
}

fn one(name: &str, bytes: Vec<u8>) -> Vec<Asset> {
    vec![Asset { name: name.into(), bytes }]
}

/// A peak of 900 m at column 40, row 10, on 100 m.
fn peak(column: usize, row: usize) -> f64 {
    if (column, row) == (40, 10) {
        900.0
    } else {
        100.0
    }
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-3, "{found}, expected {expected}");
}

#[test]
fn doubles_in_degrees_of_nad_83_lie_where_they_say() {
    let keys = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4269];
    let map = doubles([-85.0, 36.0], 0.01, &keys, &[0.0], peak);
    let terrain = mapped_on(EARTH, one("m.tif", map), "placement = \"file\"\nblend_m = 0.0").unwrap();
    near(at(&terrain, 36.0 - 0.1, -85.0 + 0.4), 900.0);
    near(at(&terrain, 36.0 - 0.12, -85.0 + 0.4), 100.0);
    for (south, east) in [(-0.001, 0.3), (0.311, 0.3), (0.15, -0.001), (0.15, 0.631)] {
        near(at(&terrain, 36.0 - south, -85.0 + east), 0.0);
    }
}

#[test]
fn a_lunar_map_in_degrees_lies_on_the_moon() {
    let keys = [1, 1, 0, 5, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 32_767, 2057, 34_736, 1, 0, 2058, 34_736, 1, 1];
    let map = || doubles([10.0, 1.0], 0.01, &keys, &[1_737_400.0; 2], peak);
    let terrain = mapped_on(1_737_400.0, one("m.tif", map()), "placement = \"file\"\nblend_m = 0.0").unwrap();
    near(at(&terrain, 0.9, 10.4), 900.0);
    near(at(&terrain, 0.9, 10.42), 100.0);
    near(at(&terrain, 0.9, 10.631), 0.0);
    // Put elsewhere it has the Moon's size: 64 samples of 303.2 m.
    let terrain = mapped_on(1_737_400.0, one("m.tif", map()), "latitude_deg = 0.0\nlongitude_deg = 20.0\nblend_m = 0.0").unwrap();
    let metre = 1.0 / 1_737_400.0_f64.to_radians();
    near(at(&terrain, 0.0, 20.0 + 9_690.0 * metre), 100.0);
    near(at(&terrain, 0.0, 20.0 + 9_715.0 * metre), 0.0);
}

#[test]
fn neighbouring_tiles_have_no_seam_between_them() {
    let tile = |name: &str, west: usize| {
        let height = |i: usize| (500 + west + i % 1201) as i16;
        Asset { name: name.into(), bytes: (0..1201 * 1201).flat_map(|i| height(i).to_be_bytes()).collect() }
    };
    let both = || vec![tile("N36W085.hgt", 0), tile("N36W084.hgt", 1200)];
    let terrain = mapped_on(EARTH, both(), "placement = \"file\"\nblend_m = 5000.0").unwrap();
    // Along the parallel through the middle the ground rises as the samples do, over the border too.
    for k in -40..=40 {
        let east = f64::from(k) / 4.0;
        let found = at(&terrain, 36.5, -84.0 + east / 1200.0);
        assert!((found - (1700.0 + east)).abs() < 0.01, "{found} at {east} samples from the border");
    }
    // Each for itself fades there.
    let alone = mapped_on(EARTH, both()[..1].to_vec(), "placement = \"file\"\nblend_m = 5000.0").unwrap();
    assert!(at(&alone, 36.5, -84.001) < 100.0);
    let apart = vec![tile("N36W085.hgt", 0), tile("N36W082.hgt", 0)];
    let message = mapped_on(EARTH, apart, "placement = \"file\"").err().unwrap();
    assert!(
        message.contains("N36W085.hgt, N36W082.hgt: found a tile that touches none of the others in N36W082.hgt"),
        "{message}"
    );
}

#[test]
fn a_map_of_the_whole_planet_begins_at_the_files_west() {
    // 64 × 32 samples of 5.625 degrees, by the corners of areas: from longitude 0, from -180, and from 90.
    let keys = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326];
    for west in [0.0, -180.0, 90.0] {
        let terrain = mapped_on(EARTH, one("m.tif", doubles([west, 90.0], 5.625, &keys, &[0.0], peak)), "").unwrap();
        let longitude = west + 40.5 * 5.625;
        near(at(&terrain, 90.0 - 10.5 * 5.625, longitude), 900.0);
        near(at(&terrain, 90.0 - 10.5 * 5.625, longitude + 180.0), 100.0);
    }
    // Part of a planet is not stretched over all of it, though it is twice as wide as high.
    let part = mapped_on(EARTH, one("m.tif", doubles([0.0, 50.0], 0.01, &keys, &[0.0], peak)), "").err().unwrap();
    assert!(part.contains("0.640 x 0.320 degrees") && part.contains("placement = \"file\""), "{part}");
    // Equirectangular metres, as maps of Mars are.
    let keys = [
        1, 1, 0, 6, 1024, 0, 1, 1, 2048, 0, 1, 32_767, 2057, 34_736, 1, 0, 2058, 34_736, 1, 1, 3072, 0, 1, 32_767, 3075, 0, 1, 17,
    ];
    let radius = 3_396_190.0;
    let step = 2.0 * std::f64::consts::PI * radius / 64.0;
    let map = doubles([-32.0 * step, 16.0 * step], step, &keys, &[radius; 2], peak);
    let terrain = mapped_on(radius, one("m.tif", map), "").unwrap();
    near(at(&terrain, 90.0 - 10.5 * 5.625, -180.0 + 40.5 * 5.625), 900.0);
}

#[test]
fn a_projected_file_lies_where_it_says() {
    // UTM zone 32: the peak at 500,400 east and 5,199,900 north is at 9.0052567 degrees east, 46.9526292 north (GDAL 3.6).
    let keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, 32_632];
    let map = doubles([500_000.0, 5_200_000.0], 10.0, &keys, &[0.0], peak);
    let terrain = mapped_on(EARTH, one("m.tif", map), "placement = \"file\"\nblend_m = 0.0").unwrap();
    let found = at(&terrain, 46.9526292, 9.0052567);
    assert!((found - 900.0).abs() < 3.0, "{found}");
    near(at(&terrain, 46.9526292, 9.0056567), 100.0);
    near(at(&terrain, 46.9546292, 9.0052567), 0.0);
    // Maps over which the projection bends are refused: Web Mercator far north.
    let keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, 3857];
    let wide = doubles([0.0, 9_000_000.0], 40_000.0, &keys, &[0.0], peak);
    let message = mapped_on(EARTH, one("m.tif", wide), "placement = \"file\"").err().unwrap();
    assert!(message.contains("too large to lie flat") && message.contains("gdalwarp"), "{message}");
}
