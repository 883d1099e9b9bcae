//! Terrain: the same bits whatever points are evaluated together, inside its stated range, detailed down to a metre, finite everywhere.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use glam::DVec3;
use proptest::prelude::*;
use std::path::Path;
use terrane_planet::recipe::{Asset, Recipe};
use terrane_planet::terrain::{GroundPoint, Terrain};

const SHIPPED: [&str; 4] = ["terra", "luna", "mars", "tiny"];

fn recipe(name: &str) -> Recipe {
    Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recipes/{name}.toml"))).unwrap()
}

fn terrain(name: &str) -> Terrain {
    Terrain::new(&recipe(name)).unwrap()
}

/// Directions spread evenly over the sphere (spherical Fibonacci, Gonzalez 2010).
fn spread(count: usize) -> Vec<DVec3> {
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let at = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * (turn * i as f64).cos(), r * (turn * i as f64).sin(), z)
    };
    (0..count).map(at).collect()
}

fn heights(terrain: &Terrain, directions: &[DVec3]) -> Vec<f64> {
    let mut heights = vec![0.0; directions.len()];
    terrain.heights(directions, &mut heights);
    heights
}

fn turned(latitude: f64, longitude: f64) -> DVec3 {
    let (lat, lon) = (latitude.to_radians(), longitude.to_radians());
    DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
}

#[test]
fn heights_have_the_same_bits_in_any_slice() {
    for name in SHIPPED {
        let (terrain, directions) = (terrain(name), spread(777));
        let whole = heights(&terrain, &directions);
        for length in [1, 3, 64, 127, 128, 129, 500] {
            let cut: Vec<f64> = directions.chunks(length).flat_map(|d| heights(&terrain, d)).collect();
            assert!(whole.iter().zip(&cut).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}, slices of {length}");
        }
        for (d, h) in directions.iter().zip(&whole) {
            assert_eq!(terrain.height(*d).to_bits(), h.to_bits(), "{name} at {d}");
        }
    }
}

#[test]
fn close_points_that_share_craters_have_the_bits_of_single_points() {
    // Neighbouring points of a chunk share one lookup of crater sites, single points do not: rows of 128 at several spacings must agree
    // with single points.
    for name in ["luna", "mars", "tiny"] {
        let (recipe, terrain) = (recipe(name), terrain(name));
        for (site, spacing) in spread(12).into_iter().flat_map(|d| [0.3, 4.0, 70.0, 900.0].map(|s| (d, s))) {
            let along = site.any_orthonormal_vector() * (spacing / recipe.radius);
            let row: Vec<DVec3> = (0..128).map(|i| (site + along * f64::from(i)).normalize()).collect();
            for (d, h) in row.iter().zip(heights(&terrain, &row)) {
                assert_eq!(terrain.height(*d).to_bits(), h.to_bits(), "{name}, {spacing} m apart, at {d}");
            }
        }
    }
}

#[test]
fn albedo_is_the_same_in_any_slice() {
    for name in SHIPPED {
        let (terrain, directions) = (terrain(name), spread(300));
        let ground = |&direction: &DVec3| GroundPoint {
            direction,
            height: terrain.height(direction),
            slope: 0.3,
            north: 0.1,
            spacing: 2.0,
        };
        let points: Vec<GroundPoint> = directions.iter().map(ground).collect();
        let (mut whole, mut single) = (vec![[0; 3]; 300], vec![[0; 3]; 300]);
        terrain.albedo(&points, &mut whole);
        points.chunks(7).zip(single.chunks_mut(7)).for_each(|(p, a)| terrain.albedo(p, a));
        assert_eq!(whole, single, "{name}");
        assert!(whole.iter().any(|a| *a != whole[0]), "{name} has one colour");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn heights_are_the_same_in_any_order(seed in 0_u64..1000, split in 1_usize..199) {
        let mut recipe = recipe("tiny");
        recipe.seed = seed;
        let terrain = Terrain::new(&recipe).unwrap();
        let mut directions = spread(200);
        let before = heights(&terrain, &directions);
        directions.rotate_left(split.min(199));
        let mut after = heights(&terrain, &directions);
        after.rotate_right(split.min(199));
        prop_assert_eq!(before, after);
    }
}

#[test]
fn heights_stay_within_their_range() {
    for name in SHIPPED {
        let terrain = terrain(name);
        let (low, high) = terrain.height_range();
        for h in heights(&terrain, &spread(60_000)) {
            assert!(h.is_finite() && (low..=high).contains(&h), "{name}: {h} outside {low} to {high}");
        }
    }
}

#[test]
fn heights_are_finite_on_axes_and_at_poles() {
    let mut directions = Vec::new();
    for x in [-1.0, 0.0, -0.0, 1.0] {
        for y in [-1.0, 0.0, -0.0, 1.0] {
            for z in [-1.0, 0.0, 1.0] {
                directions.extend(DVec3::new(x, y, z).try_normalize());
            }
        }
    }
    for name in SHIPPED {
        assert!(heights(&terrain(name), &directions).iter().all(|h| h.is_finite()), "{name}");
    }
}

#[test]
fn terra_is_mostly_ocean() {
    let terrain = terrain("terra");
    let ground = heights(&terrain, &spread(60_000));
    let wet = ground.iter().filter(|&&h| h < 0.0).count() as f64 / ground.len() as f64;
    assert!((0.60..0.72).contains(&wet), "{wet}");
    let deep = ground.iter().filter(|&&h| h < -3000.0).count() as f64 / ground.len() as f64;
    assert!(deep > 0.3, "abyssal plains cover {deep}");
    // Sites 90 km apart seldom are summits: more sites are evaluated around the highest of them.
    let (mut sites, near) = (spread(60_000), spread(400));
    sites.sort_by_cached_key(|&site| -terrain.height(site) as i64);
    let closely: Vec<DVec3> =
        sites[..20].iter().flat_map(|&site| near.iter().map(move |&d| (site + d * 0.006).normalize())).collect();
    let highest = heights(&terrain, &closely).iter().copied().fold(0.0, f64::max);
    assert!((6000.0..10_500.0).contains(&highest), "highest {highest}");
}

#[test]
fn terrain_has_relief_at_one_metre() {
    for name in SHIPPED {
        let (recipe, terrain) = (recipe(name), terrain(name));
        let mut rough = 0;
        for d in spread(200) {
            let step = d.any_orthonormal_vector() / recipe.radius;
            let rise = (terrain.height((d + step).normalize()) - terrain.height(d)).abs();
            assert!(rise < 8.0, "{name}: a cliff of {rise} m over one metre");
            // The second difference over a metre, which is near zero where only larger features are.
            let back = terrain.height((d - step).normalize());
            let ahead = terrain.height((d + step).normalize());
            rough += usize::from((ahead + back - 2.0 * terrain.height(d)).abs() > 1e-3);
        }
        assert!(rough > 150, "{name}: only {rough} of 200 sites have relief at one metre");
    }
}

#[test]
fn ground_is_continuous_between_neighbours() {
    // A millimetre apart, heights differ by millimetres: cell borders, crater rims and map edges included.
    for name in SHIPPED {
        let (recipe, terrain) = (recipe(name), terrain(name));
        for d in spread(4000) {
            let near = (d + d.any_orthonormal_vector() * (1e-3 / recipe.radius)).normalize();
            let step = (terrain.height(near) - terrain.height(d)).abs();
            assert!(step < 0.02, "{name}: {step} m over a millimetre at {d}");
        }
    }
}

/// A planet of 50 km with one layer, and a desert's colours.
fn dry(layer: &str) -> Terrain {
    let text = format!(
        "name = \"T\"\nradius_m = 50000.0\nseed = 1\n[[layer]]\n{layer}\n[palette]\nkind = \"desert\"\ndust = [190, 130, 80]\n\
         sand = [90, 70, 50]\ndune = [0, 0, 255]\nrock = [120, 80, 60]\nstrata = [170, 130, 90]\nice = [230, 230, 230]\n\
         ice_deg = 80\nsand_cover = 0.0\nrock_slope = [0.5, 0.9]\nclimate_m = 30000\npatch_m = 5000\n"
    );
    Terrain::new(&Recipe::from_parts(&text, "t.toml", Vec::new()).unwrap()).unwrap()
}

const CANYONS: &str =
    "kind = \"canyons\"\nwavelength_m = 20000\ndetail_m = 500\ngain = 0.5\ndepth_m = 900\nwidth = 0.6\nwall = 0.3\n\
                       region_m = 60000\ncover = 1.0";
const DUNES: &str = "kind = \"dunes\"\nwavelength_m = 400\namplitude_m = 30\nregion_m = 60000\ncover = 1.0";

#[test]
fn canyons_have_rims_walls_and_floors_below_the_ground() {
    let ground = heights(&dry(CANYONS), &spread(20_000));
    let share = |of: &dyn Fn(f64) -> bool| ground.iter().filter(|&&h| of(h)).count() as f64 / ground.len() as f64;
    assert!(ground.iter().all(|&h| (-900.001..=0.0).contains(&h)));
    assert!(share(&|h| h == 0.0) > 0.3, "rims");
    assert!(share(&|h| h < -899.0) > 0.05, "floors");
    assert!(share(&|h| (-700.0..-200.0).contains(&h)) > 0.03, "walls");
}

#[test]
fn dunes_are_steeper_on_one_side() {
    // Rows across dunes: one side of a dune is steeper than the other, whichever way the wind blows.
    let terrain = dry(DUNES);
    let (mut longest, mut crests) = (0.0_f64, 0);
    for d in spread(300) {
        for across in [d.any_orthonormal_vector(), d.cross(d.any_orthonormal_vector())] {
            let row: Vec<DVec3> = (0..200).map(|i| (d + across * (f64::from(i) * 10.0 / 50_000.0)).normalize()).collect();
            let rises: Vec<f64> = heights(&terrain, &row).windows(2).map(|w| w[1] - w[0]).collect();
            let steepest = |sign: f64| rises.iter().map(|r| r * sign).fold(0.0, f64::max);
            let (up, down) = (steepest(1.0), steepest(-1.0));
            if up.min(down) > 0.5 {
                longest = longest.max(up.max(down) / up.min(down));
                crests += 1;
            }
        }
    }
    assert!(crests > 200 && longest > 2.5, "{crests} rows across dunes, slopes differ by {longest} at most");
}

#[test]
fn dunes_have_their_own_colour() {
    let blue = |layer: &str| {
        let terrain = dry(layer);
        let ground = |&direction: &DVec3| GroundPoint { direction, height: 0.0, slope: 0.0, north: 0.0, spacing: 2.0 };
        let points: Vec<GroundPoint> = spread(300).iter().filter(|d| d.z.abs() < 0.7).map(ground).collect();
        let mut colours = vec![[0; 3]; points.len()];
        terrain.albedo(&points, &mut colours);
        colours.iter().map(|c| u32::from(c[2])).sum::<u32>() / colours.len() as u32
    };
    let ripples = DUNES.replace("= 400", "= 10");
    assert!(blue(DUNES) > blue(&ripples) + 20, "{} and {}", blue(DUNES), blue(&ripples));
}

#[test]
fn poles_of_a_desert_have_ice() {
    let terrain = dry(DUNES);
    let white = |z: f64| {
        let points: Vec<GroundPoint> = spread(4000)
            .into_iter()
            .filter(|d| (d.z - z).abs() < 0.01)
            .map(|direction| GroundPoint { direction, height: 0.0, slope: 0.0, north: 0.0, spacing: 2.0 })
            .collect();
        let mut colours = vec![[0; 3]; points.len()];
        terrain.albedo(&points, &mut colours);
        colours.iter().filter(|c| c[2] > 170 && c[0] > 170).count() as f64 / colours.len() as f64
    };
    assert!(white(0.99) > 0.4 && white(-0.99) > 0.4, "{} {}", white(0.99), white(-0.99));
    assert_eq!(white(0.3), 0.0);
}

const SHIELD: &str = "kind = \"shield\"\nlatitude_deg = 20\nlongitude_deg = 50\nradius_m = 15000\nheight_m = 2000\nscarp = 0.2\n\
                      caldera_m = 2500\ncaldera_depth_m = 400";
const RIFT: &str =
    "kind = \"rift\"\nlatitude_deg = -10\nlongitude_deg = 70\nheading_deg = 90\nlength_m = 60000\nwidth_m = 6000\ndepth_m = 900";
const CAPS: &str = "kind = \"caps\"\nlatitude_deg = 75\nheight_m = 900\ntrough_m = 300\napart_m = 2500";

#[test]
fn a_shield_volcano_has_flanks_and_a_caldera() {
    let terrain = dry(SHIELD);
    let (low, high) = terrain.height_range();
    assert!(heights(&terrain, &spread(20_000)).iter().all(|h| (low..=high).contains(h)));
    let top = turned(20.0, 50.0);
    let at = |metres: f64| terrain.height((top + top.any_orthonormal_vector() * (metres / 50_000.0)).normalize());
    assert!(at(0.0) < at(3500.0) - 80.0, "no caldera: {} and {}", at(0.0), at(3500.0));
    assert!(at(3500.0) > at(8000.0) + 200.0 && at(8000.0) > 500.0, "{} and {}", at(3500.0), at(8000.0));
    assert_eq!(at(25_000.0), 0.0);
}

#[test]
fn a_rift_has_a_floor_and_lies_at_its_site() {
    let terrain = dry(RIFT);
    let ground = heights(&terrain, &spread(40_000));
    assert!(ground.iter().all(|h| (-900.001..=0.0).contains(h)));
    assert!(ground.iter().filter(|&&h| h < -600.0).count() > 100);
    let far = spread(40_000).into_iter().filter(|d| d.dot(turned(-10.0, 70.0)) < 0.5);
    assert!(heights(&terrain, &far.collect::<Vec<_>>()).iter().all(|&h| h == 0.0));
    // Two rifts at one site are as deep as one.
    let twice = dry(&format!("{RIFT}\n[[layer]]\n{RIFT}"));
    assert!(heights(&twice, &spread(40_000)).iter().all(|h| (-900.001..=0.0).contains(h)));
}

#[test]
fn ice_buries_old_craters() {
    let craters = "kind = \"craters\"\nlargest_m = 800\nsmallest_m = 100\ndensity = 2\nreach = 1.6";
    let [plain, iced] = [dry(craters), dry(&format!("{CAPS}\n[[layer]]\n{craters}"))];
    let smooth = dry(CAPS);
    let pole: Vec<DVec3> = spread(20_000).into_iter().filter(|d| d.z > 0.985).collect();
    let deep = |heights: Vec<f64>| heights.iter().filter(|h| h.abs() > 4.0).count();
    let own: Vec<f64> = heights(&iced, &pole).iter().zip(heights(&smooth, &pole)).map(|(a, b)| a - b).collect();
    let (with, without) = (deep(own), deep(heights(&plain, &pole)));
    assert!(4 * with < without && with > 0, "{with} and {without}");
}

#[test]
fn landmarks_are_the_same_in_any_slice() {
    // A chunk may skip only layers that add nothing to its points: single points must agree with chunks all over the planet.
    for layer in [SHIELD, RIFT, CAPS] {
        let terrain = dry(layer);
        let directions = spread(30_000);
        for (d, h) in directions.iter().zip(heights(&terrain, &directions)).filter(|(_, h)| *h != 0.0) {
            assert_eq!(terrain.height(*d).to_bits(), h.to_bits(), "{layer} at {d}");
        }
        let changed = heights(&terrain, &directions).iter().filter(|h| **h != 0.0).count();
        assert!((100..20_000).contains(&changed), "{layer} changes {changed} of 30,000 sites");
        let zeros = directions.iter().zip(heights(&terrain, &directions)).filter(|(_, h)| *h == 0.0);
        assert!(zeros.step_by(7).all(|(d, _)| terrain.height(*d) == 0.0), "{layer}");
    }
}

#[test]
fn colours_about_the_poles_are_the_same_in_any_slice() {
    // Features near some points of a slice must not colour its other points: frost at the polar caps once did.
    for name in ["mars", "luna", "terra"] {
        let terrain = terrain(name);
        let about_poles = spread(40_000).into_iter().filter(|d| d.z.abs() > 0.95);
        let ground = |direction| GroundPoint { direction, height: 100.0, slope: 0.05, north: 0.0, spacing: 200.0 };
        let points: Vec<GroundPoint> = about_poles.map(ground).collect();
        let colours = |slice: &[GroundPoint]| {
            let mut albedo = vec![[0; 3]; slice.len()];
            terrain.albedo(slice, &mut albedo);
            albedo
        };
        let whole = colours(&points);
        assert!(whole.iter().any(|colour| *colour != whole[0]), "{name} has one colour");
        for (k, point) in points.iter().enumerate() {
            assert_eq!(colours(&[*point])[0], whole[k], "{name} at {}", point.direction);
        }
    }
}

#[test]
fn the_north_of_mars_is_low() {
    let (terrain, sites) = (terrain("mars"), spread(4000));
    let mean = |sign: f64| {
        let half: Vec<DVec3> = sites.iter().copied().filter(|d| d.z * sign > 0.4).collect();
        heights(&terrain, &half).iter().sum::<f64>() / half.len() as f64
    };
    assert!(mean(-1.0) - mean(1.0) > 2500.0, "{} and {}", mean(1.0), mean(-1.0));
}

#[test]
fn the_seed_changes_the_terrain() {
    let mut recipe = recipe("tiny");
    let before = heights(&Terrain::new(&recipe).unwrap(), &spread(100));
    recipe.seed += 1;
    let after = heights(&Terrain::new(&recipe).unwrap(), &spread(100));
    assert!(before.iter().zip(&after).filter(|(a, b)| a != b).count() > 95);
}

/// Encodes a PNG of any kind.
fn image(width: u32, height: u32, colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn grey16(width: u32, height: u32, pixel: impl Fn(u32, u32) -> u16) -> Vec<u8> {
    let data: Vec<u8> =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y).to_be_bytes()).collect();
    image(width, height, png::ColorType::Grayscale, png::BitDepth::Sixteen, &data)
}

fn mapped(bytes: Vec<u8>, placement: &str) -> Result<Terrain, String> {
    let text = format!(
        "name = \"T\"\nradius_m = 10000.0\nseed = 1\n[[layer]]\nkind = \"heightmap\"\nfile = \"m.png\"\n\
         range_m = [-100, 900]\n{placement}\n[palette]\nkind = \"airless\"\nhighland = [1, 2, 3]\nmare = [1, 2, 3]\n\
         ray = [1, 2, 3]\nmare_m = [0, 1]\npatch_m = 500\n"
    );
    let recipe = Recipe::from_parts(&text, "t.toml", vec![Asset { name: "m.png".into(), bytes }]).map_err(|e| e.to_string())?;
    Terrain::new(&recipe).map_err(|e| e.to_string())
}

#[test]
fn wrong_images_are_refused() {
    use png::{BitDepth, ColorType};
    let grey = ColorType::Grayscale;
    let cases = [
        (image(4, 2, grey, BitDepth::Four, &[0; 4]), "4 bits", "16 or 8 bits"),
        (image(4, 2, ColorType::Rgb, BitDepth::Sixteen, &[0; 48]), "Rgb", "greyscale"),
        (grey16(4, 4, |_, _| 0), "4 x 4", "twice as wide"),
        (grey16(2, 1, |_, _| 0), "2 x 1", "at least 2 x 2"),
        (b"not a png at all".to_vec(), "first bytes", "png file"),
        (grey16(64, 32, |x, y| (x * y) as u16)[..90].to_vec(), "found", "undamaged PNG"),
    ];
    for (bytes, found, expected) in cases {
        let message = mapped(bytes, "").err().expect("this image should be refused");
        for part in ["t.toml:6", "`layer[0].file`", "m.png", found, expected] {
            assert!(message.contains(part), "{message:?} lacks {part:?}");
        }
    }
}

#[test]
fn a_map_of_the_planet_lies_where_it_should() {
    // White in the column east of longitude 90, black elsewhere but for a grey northernmost row.
    let pixel = |x: u32, y: u32| if y == 0 { 32_768 } else { u16::from(x == 48) * 65_535 };
    let terrain = mapped(grey16(64, 32, pixel), "").unwrap();
    let at = |lat: f64, lon: f64| terrain.height(turned(lat, lon));
    assert!((at(0.0, 92.8125) - 900.0).abs() < 1.0, "{}", at(0.0, 92.8125));
    assert!((at(0.0, 0.0) + 100.0).abs() < 1e-6 && (at(-40.0, -92.0) + 100.0).abs() < 1e-6);
    assert!((terrain.height(DVec3::Z) - 400.0).abs() < 0.1);
    // No seam at the date line.
    assert!((at(10.0, 179.999_999) - at(10.0, -179.999_999)).abs() < 0.01);
}

#[test]
fn a_local_map_lies_at_its_site() {
    // 4000 m wide, its right half white; centre at 30 N 40 E.
    let placement = "latitude_deg = 30.0\nlongitude_deg = 40.0\nwidth_m = 4000.0\nblend_m = 400.0\n";
    let bytes = grey16(64, 64, |x, _| u16::from(x >= 32) * 65_535);
    let centre = turned(30.0, 40.0);
    let at = |terrain: &Terrain, east: f64, north: f64| {
        let e = DVec3::Z.cross(centre).normalize();
        terrain.height((centre + (e * east + centre.cross(e) * north) / 10_000.0).normalize())
    };
    let level = mapped(bytes.clone(), placement).unwrap();
    assert!((at(&level, 1000.0, 0.0) - 900.0).abs() < 1e-6 && (at(&level, -1000.0, 0.0) + 100.0).abs() < 1e-6);
    assert_eq!(at(&level, 2100.0, 0.0), 0.0, "beyond the edge the ground is as before");
    assert!((at(&level, 1800.0, 0.0) - 450.0).abs() < 1.0, "half-way through the blend");
    assert_eq!(level.height(-centre), 0.0, "the far side is untouched");
    // Turned by 90 degrees the image's right edge points south.
    let turned_map = mapped(bytes, &format!("{placement}heading_deg = 90.0\n")).unwrap();
    assert!((at(&turned_map, 0.0, -1000.0) - 900.0).abs() < 1e-6 && (at(&turned_map, 0.0, 1000.0) + 100.0).abs() < 1e-6);
}
