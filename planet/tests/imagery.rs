//! Pictures of the ground: colours at known places, around the planet and at the poles, blended at their edges, without a jump between
//! levels; what is no picture is refused. Coasts and basins that follow from maps.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use glam::DVec3;
use std::path::Path;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Asset, Recipe};
use terrane_planet::terrain::{GroundPoint, Terrain};

const RADIUS: f64 = 1e6;

/// A PNG of a colour for each column and row.
fn png(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let pixels: Vec<u8> = (0..size[0] * size[1]).flat_map(|k| pixel(k % size[0], k / size[0])).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    bytes
}

/// A grey PNG of heights.
fn heights_png(size: [u32; 2], level: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let levels: Vec<u8> = (0..size[0] * size[1]).map(|k| level(k % size[0], k / size[0])).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&levels).unwrap();
    bytes
}

/// A recipe of some layers over level ground of a grey palette.
fn recipe(layers: &str, assets: Vec<(&str, Vec<u8>)>) -> Result<Recipe, String> {
    let text = format!(
        "name = \"T\"\nradius_m = {RADIUS:.1}\nseed = 1\n{layers}\n[palette]\nkind = \"airless\"\nhighland = [90, 90, 90]\n\
         mare = [90, 90, 90]\nray = [90, 90, 90]\nmare_m = [0, 1]\npatch_m = 500\n"
    );
    let assets = assets.into_iter().map(|(name, bytes)| Asset { name: name.into(), bytes }).collect();
    Recipe::from_parts(&text, "t.toml", assets).map_err(|e| e.to_string())
}

fn terrain(layers: &str, assets: Vec<(&str, Vec<u8>)>) -> Result<Terrain, String> {
    Terrain::new(&recipe(layers, assets)?).map_err(|e| e.to_string())
}

/// Terrain of one picture.
fn pictured(keys: &str, picture: Vec<u8>) -> Terrain {
    terrain(&format!("[[layer]]\nkind = \"imagery\"\nfile = \"a.png\"\n{keys}"), vec![("a.png", picture)]).unwrap()
}

/// The colour where samples stand `spacing` metres apart. Wide spacings show no noise of the ground.
fn colour_of(terrain: &Terrain, direction: DVec3, spacing: f64) -> [i32; 3] {
    let height = terrain.height(direction);
    let mut albedo = [[0; 3]];
    terrain.albedo(&[GroundPoint { direction, height, slope: 0.0, north: 0.0, spacing }], &mut albedo);
    albedo[0].map(i32::from)
}

fn colour(terrain: &Terrain, latitude: f64, longitude: f64) -> [i32; 3] {
    colour_of(terrain, direction_at(latitude, longitude), 3e3)
}

#[track_caller]
fn assert_near(found: [i32; 3], expected: [i32; 3], within: i32) {
    assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() <= within), "found {found:?}, expected {expected:?}");
}

#[test]
fn a_map_of_the_planet_colours_the_places_that_it_shows() {
    // Four quarters around the planet, each of its own colour, brighter in the north.
    let quarter = |c: u32, r: u32| {
        let bright = if r < 16 { 200 } else { 100 };
        [[bright, 20, 20], [20, bright, 20], [20, 20, bright], [bright, bright, 20]][c as usize / 16]
    };
    let terrain = pictured("", png([64, 32], quarter));
    for (latitude, longitude, expected) in [
        (45.0, -135.0, [200, 20, 20]),
        (45.0, -45.0, [20, 200, 20]),
        (45.0, 45.0, [20, 20, 200]),
        (45.0, 135.0, [200, 200, 20]),
        (-45.0, -135.0, [100, 20, 20]),
        (-45.0, 45.0, [20, 20, 100]),
    ] {
        assert_near(colour(&terrain, latitude, longitude), expected, 2);
    }
}

#[test]
fn a_map_closes_at_the_date_line_and_at_the_poles() {
    let stripes = |c: u32, _: u32| if c.is_multiple_of(2) { [250, 250, 250] } else { [10, 10, 10] };
    let terrain = pictured("", png([64, 32], stripes));
    // The first column is bright, the last one dark; between them the colour passes through the middle of light.
    let across: Vec<i32> = (-60..=60).map(|k| colour(&terrain, 0.0, 180.0 + f64::from(k) * 0.1)[0]).collect();
    assert!(across.windows(2).all(|w| (w[1] - w[0]).abs() < 16), "{across:?}");
    assert!(across.iter().max().unwrap() - across.iter().min().unwrap() > 60, "the stripes show: {across:?}");
    let around: Vec<[i32; 3]> = (0..36).map(|k| colour(&terrain, 89.99, f64::from(k) * 10.0)).collect();
    around.iter().for_each(|&found| assert_near(found, around[0], 1));
    // Near the poles columns are narrower than rows are high: no stripe is left.
    let near: Vec<i32> = (0..360).map(|k| colour(&terrain, 80.0, f64::from(k))[0]).collect();
    assert!(near.iter().max().unwrap() - near.iter().min().unwrap() < 40, "{near:?}");
}

#[test]
fn levels_change_without_a_jump_and_keep_the_mean_light() {
    let noise = |c: u32, r: u32| if (c * 7 + r * 13 + c * r) % 5 < 2 { [240, 240, 240] } else { [30, 30, 30] };
    let terrain = pictured("", png([256, 128], noise));
    let pixel = std::f64::consts::PI * RADIUS / 128.0;
    for site in [direction_at(10.0, 20.0), direction_at(-50.0, 179.9), direction_at(88.0, -70.0)] {
        let over: Vec<i32> = (0..900).map(|k| colour_of(&terrain, site, pixel * 0.2 * 1.01_f64.powi(k))[0]).collect();
        assert!(over.windows(2).all(|w| (w[1] - w[0]).abs() <= 3), "a jump: {over:?}");
        // A third of the light of 240 (0.32 x 0.871 + 0.68 x 0.013): encoded 147. The mean of codes is 97.
        assert!((over[899] - 147).abs() < 6, "far off the mean of light is left, not that of codes: {}", over[899]);
    }
    let near = |longitude: f64| colour_of(&terrain, direction_at(10.0, longitude), 0.2 * pixel)[0];
    let spread: Vec<i32> = (0..200).map(|k| near(f64::from(k) * 0.7)).collect();
    assert!(spread.iter().max().unwrap() - spread.iter().min().unwrap() > 100, "the control: pixels differ where they are seen");
}

#[test]
fn a_placed_picture_fades_out_at_its_edge() {
    let keys = "latitude_deg = 10.0\nlongitude_deg = 20.0\nwidth_m = 100000.0\nblend_m = 20000.0";
    let terrain = pictured(keys, png([20, 20], |_, _| [250, 10, 10]));
    let degree = RADIUS.to_radians();
    let east: Vec<[i32; 3]> = (0..60).map(|k| colour(&terrain, 10.0, 20.0 + f64::from(k) * 1e3 / degree)).collect();
    assert_near(east[20], [250, 10, 10], 4);
    assert_near(east[40], [170, 50, 50], 12);
    assert_near(east[55], [90, 90, 90], 12);
    assert!(east.windows(2).all(|w| w[1][0] <= w[0][0] + 6 && w[0][0] - w[1][0] < 24), "{east:?}");
}

#[test]
fn the_same_picture_gives_the_same_bytes() {
    let picture = || png([64, 32], |c, r| [(c * 4) as u8, (r * 8) as u8, 77]);
    let [first, second] = [pictured("", picture()), pictured("", picture())];
    let other = pictured("", png([64, 32], |c, r| [(c * 4) as u8, (r * 8) as u8, 78]));
    let sites = || (0..500).map(|k| direction_at(f64::from(k % 25) * 7.0 - 86.0, f64::from(k) * 3.7 - 180.0));
    let all = |terrain: &Terrain| sites().map(|site| colour_of(terrain, site, 700.0)).collect::<Vec<_>>();
    assert_eq!(all(&first), all(&second));
    assert_ne!(all(&first), all(&other), "one step of blue shows");
}

#[test]
fn jpeg_png_and_tiff_say_the_same() {
    let seed = |name: &str| std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds/photo").join(name)).unwrap();
    let read = |name: &str| terrane_heightfield::import::photo::read(&seed(name), name).unwrap();
    let [png, tiff, lzw, alpha, jpeg] = ["colour.png", "colour.tif", "lzw.tif", "alpha.png", "colour.jpg"].map(read);
    assert_eq!(png.size(), [16, 8]);
    for same in [tiff, lzw, alpha] {
        assert_eq!(same.pixels, png.pixels);
    }
    let off = |a: &[u8; 3], b: &[u8; 3]| (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>() / 3.0;
    let mean = jpeg.pixels.iter().zip(&png.pixels).map(|(a, b)| off(a, b)).sum::<f64>() / 128.0;
    assert!((0.01..25.0).contains(&mean), "a JPEG is near: {mean}");
    let grey = read("grey.jpg");
    assert!(grey.pixels.iter().all(|p| p[0] == p[1] && p[1] == p[2]));
}

#[test]
fn what_is_no_picture_is_refused_with_what_was_found() {
    let sound = png([64, 32], |_, _| [1, 2, 3]);
    let seed = |name: &str| std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds/photo").join(name)).unwrap();
    let refused = |name: &str, bytes: Vec<u8>, keys: &str, parts: &[&str]| {
        let layers = format!("[[layer]]\nkind = \"imagery\"\nfile = \"{name}\"\n{keys}");
        let message = terrain(&layers, vec![(name, bytes)]).err().unwrap_or_else(|| panic!("{name} {keys} is taken"));
        for part in ["layer[0].file", name, "found", "expected"].iter().chain(parts) {
            assert!(message.contains(part), "{message:?} lacks {part:?}");
        }
    };
    refused("a.png", sound[..sound.len() / 2].to_vec(), "", &["PNG"]);
    refused("a.jpg", seed("cut.jpg"), "", &["JPEG"]);
    refused("a.jpg", b"no picture at all".to_vec(), "", &["first bytes"]);
    refused("a.png", png([32, 32], |_, _| [1, 2, 3]), "", &["32 x 32", "twice as wide as high"]);
    refused("a.png", sound.clone(), "placement = \"file\"", &["does not state its place"]);
    refused("a.png", png([1, 1], |_, _| [1, 2, 3]), "", &["1 x 1"]);
    let keys = |keys: &str| {
        let layers = format!("[[layer]]\nkind = \"imagery\"\nfile = \"a.png\"\n{keys}");
        terrain(&layers, vec![("a.png", sound.clone())]).err().unwrap_or_else(|| panic!("{keys} is taken"))
    };
    assert!(keys("strength = 1.5").contains("layer[0].strength") && keys("colour = 1").contains("unknown key"));
    let missing = recipe("[[layer]]\nkind = \"imagery\"\nfile = \"a.png\"", vec![]).unwrap_err();
    assert!(missing.contains("layer[0].file") && missing.contains("no such asset"), "{missing}");
}

const SEA: &str = "[sea]\nshallow = [0.1, 0.1, 0.1]\ndeep = [0, 0, 0]\n";

/// A picture with land between longitudes -45 and 45, and a lake of a few pixels in it.
fn continent(c: u32, r: u32) -> [u8; 3] {
    let lake = (64..67).contains(&c) && (30..33).contains(&r);
    if (48..80).contains(&c) && !lake {
        [120, 110, 60]
    } else {
        [15, 40, 90]
    }
}

#[test]
fn a_seabed_has_land_where_the_picture_has_and_deepens_from_the_coast() {
    // Heights that say 0 everywhere, as data without a sea floor do.
    let layers = format!(
        "{SEA}[[layer]]\nkind = \"seabed\"\nfile = \"a.png\"\nsmallest_km2 = 100000.0\nland_m = 4.0\nshelf_m = 60e3\nslope_m = 80e3"
    );
    let terrain = terrain(&layers, vec![("a.png", png([128, 64], continent))]).unwrap();
    let height = |latitude: f64, longitude: f64| terrain.height(direction_at(latitude, longitude));
    assert!((height(10.0, 20.0) - 4.0).abs() < 0.1 && (height(-40.0, -30.0) - 4.0).abs() < 0.1, "land stands above the sea");
    assert!((height(0.5, 1.5) - 4.0).abs() < 0.1, "a lake is land");
    let out: Vec<f64> = (0..120).map(|k| height(0.0, 44.0 + f64::from(k) * 0.5)).collect();
    assert!(out.windows(2).all(|w| w[1] <= w[0] + 0.01), "ever deeper: {out:?}");
    assert!((out[119] + 5200.0).abs() < 1.0 && height(0.0, 180.0) < -5000.0, "{out:?}");
    let shore = (0..300).map(|k| 44.0 + f64::from(k) * 0.01).find(|&longitude| height(0.0, longitude) < 0.0).unwrap();
    assert!((shore - 45.0).abs() < 0.3, "the coast is where the picture has it: {shore}");
}

#[test]
fn water_of_a_picture_does_not_stain_the_coast() {
    let shown = |keys: &str| pictured(keys, png([128, 64], continent));
    let [clean, stained] = [shown("water = true"), shown("")];
    // Half a pixel inland, where a plain picture already goes over to the sea's blue.
    assert_near(colour(&clean, 10.0, 43.9), [120, 110, 60], 3);
    assert!(colour(&stained, 10.0, 43.9)[2] > 63, "the control: {:?}", colour(&stained, 10.0, 43.9));
}

#[test]
fn dry_areas_are_ground_below_the_sea() {
    let basin = "[[layer]]\nkind = \"shield\"\nlatitude_deg = 10.0\nlongitude_deg = 20.0\nradius_m = 90e3\nheight_m = 300.0\n";
    let dry = "[[layer]]\nkind = \"dry\"\nlatitude_deg = 10.0\nlongitude_deg = 20.0\nradius_m = 40e3\n";
    let sea = "[sea]\nlevel_m = 400.0\nshallow = [0.1, 0.1, 0.1]\ndeep = [0, 0, 0]\n";
    for (layers, is_dry) in [(format!("{sea}{basin}{dry}"), true), (format!("{sea}{basin}"), false)] {
        let planet = Planet::from_recipe(recipe(&layers, vec![]).unwrap(), 16).unwrap();
        let middle = direction_at(10.0, 20.0);
        let point = |direction: DVec3| {
            let height = planet.terrain.height(direction);
            GroundPoint { direction, height, slope: 0.0, north: 0.0, spacing: 10.0 }
        };
        let above = planet.terrain.above_sea(&[point(middle), point(direction_at(-10.0, 20.0))]).unwrap();
        assert_eq!((above[0] > 0.0, above[1] < 0.0), (is_dry, true), "{above:?}");
        let surface = planet.surface_height(middle);
        assert_eq!(surface, if is_dry { planet.terrain.height(middle) } else { 400.0 });
        assert_eq!(planet.surface_height(direction_at(-10.0, 20.0)), 400.0);
        // A ball that hides what is behind it must not hide dry ground.
        let hidden = planet.tree(std::iter::empty()).hidden_radius * planet.lattice.unit - RADIUS;
        assert_eq!(hidden <= planet.terrain.height(middle), is_dry, "{hidden}");
    }
}

#[test]
fn basins_of_a_map_stay_dry_and_its_sea_does_not() {
    // Levels a metre apart from -300 m: a sea at -200 m, land at -50 m above a sea of level -100 m, and a basin at -250 m.
    let level = |c: u32, r: u32| match (c, r) {
        (0..32, _) => 100,
        (90..100, 30..36) => 50,
        _ => 250,
    };
    let layers = "[sea]\nlevel_m = -100.0\nshallow = [0.1, 0.1, 0.1]\ndeep = [0, 0, 0]\n[[layer]]\nkind = \"heightmap\"\n\
                  file = \"a.png\"\nrange_m = [-300.0, -45.0]\n";
    let terrain = terrain(layers, vec![("a.png", heights_png([128, 64], level))]).unwrap();
    let [basin, sea, land] = [(-3.0, 86.0), (0.0, -150.0), (0.0, 0.0)].map(|(lat, lon)| direction_at(lat, lon));
    assert!((terrain.height(basin) + 250.0).abs() < 1.0 && terrain.is_kept_dry(basin));
    assert!((terrain.height(sea) + 200.0).abs() < 1.0 && !terrain.is_kept_dry(sea) && !terrain.is_kept_dry(land));
    assert!(terrain.lowest_dry().unwrap() < -250.0);
}

#[test]
fn the_earth_has_its_continents_seas_and_colours() {
    let earth = Terrain::new(&terrane_planet::recipe::shipped::load("earth").unwrap()).unwrap();
    let height = |latitude: f64, longitude: f64| earth.height(direction_at(latitude, longitude));
    // Low land: Dhaka, Amsterdam's east, the Mekong's plain, West Siberia, Florida.
    for (latitude, longitude) in [(23.7, 90.4), (52.2, 5.8), (10.5, 105.8), (62.0, 72.0), (28.0, -81.5)] {
        let found = height(latitude, longitude);
        assert!((0.5..150.0).contains(&found), "{found} m at {latitude}, {longitude}");
    }
    for (latitude, longitude) in
        [(30.0, -40.0), (38.0, 5.0), (43.0, 34.0), (56.0, 3.0), (20.0, 90.0), (88.0, 0.0), (-65.0, 170.0)]
    {
        let found = height(latitude, longitude);
        assert!(found < -10.0, "{found} m at {latitude}, {longitude}");
    }
    assert!(height(28.5, 84.0) > 2500.0 && height(32.0, 88.0) > 4200.0 && height(46.5, 10.0) > 1200.0, "Himalaya, Tibet, Alps");
    // Tibet is high, and no plain: but the Sahara's south is level.
    let relief = |latitude: f64, longitude: f64| {
        let heights: Vec<f64> = (0..60).map(|k| height(latitude + 0.003 * f64::from(k), longitude)).collect();
        heights.iter().fold(f64::MIN, |a, &b| a.max(b)) - heights.iter().fold(f64::MAX, |a, &b| a.min(b))
    };
    assert!(relief(28.4, 84.0) > 800.0 && relief(23.7, 90.0) < 60.0, "{} {}", relief(28.4, 84.0), relief(23.7, 90.0));
    let [sahara, congo, greenland] = [(23.0, 10.0), (0.0, 22.0), (72.0, -40.0)].map(|(lat, lon)| colour(&earth, lat, lon));
    assert!(sahara[0] > 150 && sahara[0] > sahara[2] + 30, "{sahara:?}");
    assert!(congo[1] > congo[0] && congo[1] < 90 && greenland.iter().all(|&c| c > 220), "{congo:?} {greenland:?}");
}

/// A GeoTIFF's bare cousin: 16-bit samples in metres.
fn metres_tiff(size: [u32; 2], sample: impl Fn(u32, u32) -> i16) -> Vec<u8> {
    let samples: Vec<i16> = (0..size[0] * size[1]).map(|k| sample(k % size[0], k / size[0])).collect();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).unwrap();
    encoder.write_image::<tiff::encoder::colortype::GrayI16>(size[0], size[1], &samples).unwrap();
    bytes.into_inner()
}

#[test]
fn the_recipes_for_maps_of_ones_own_make_planets() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/own-planets.md");
    let page = std::fs::read_to_string(page).unwrap();
    let recipes: Vec<&str> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let whole: Vec<&&str> = recipes.iter().filter(|text| text.starts_with("name")).collect();
    assert_eq!(whole.len(), 2, "the Moon and Mars");
    for text in whole {
        let hilly = |c: u32, r: u32| (((c * 37 + r * 91) % 64) * 60) as i16 - 1500;
        let mut assets = Vec::new();
        for name in ["moon-heights.tif", "mars-heights.tif"].into_iter().filter(|name| text.contains(name)) {
            assets.push(Asset { name: name.into(), bytes: metres_tiff([128, 64], hilly) });
        }
        for name in ["moon.jpg", "mars.jpg"].into_iter().filter(|name| text.contains(name)) {
            assets.push(Asset { name: name.into(), bytes: png([128, 64], |c, _| [160, (c + 60) as u8, 90]) });
        }
        assert_eq!(assets.len(), 2);
        let terrain = Terrain::new(&Recipe::from_parts(text, "own.toml", assets).unwrap()).unwrap();
        let heights: Vec<f64> = (0..40).map(|k| terrain.height(direction_at(10.0, f64::from(k) * 9.0))).collect();
        assert!(heights.iter().any(|&h| h > 500.0) && heights.iter().any(|&h| h < -200.0), "{heights:?}");
        assert!(colour(&terrain, 10.0, 150.0)[1] > colour(&terrain, 10.0, -150.0)[1] + 60, "the picture colours it");
    }
}
