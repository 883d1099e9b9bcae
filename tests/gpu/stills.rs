//! Still pictures: those drawn in tiles equal whole ones, 16-bit ones equal the shader's 8-bit ones; supersampling; transparency.

use crate::harness::{device_with, planet_file};
use glam::DVec3;
use std::sync::Arc;
use terrane::frame::{sun_over, Look};
use terrane::headless::Headless;
use terrane::scene::{Scene, SceneOptions};
use terrane::stills::{PixelFormat, Pixels, Still, StillOptions, Studio};
use terrane::vulkan::Context;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;

const SIZE: [u32; 2] = [150, 98];

/// A scene settled for a view of ground, sea, air and space.
struct Set {
    context: Arc<Context>,
    scene: Scene,
    view: View,
    cut: Cut,
    look: Look,
}

impl Set {
    fn new(context: &Arc<Context>, altitude: f64, pitch: f64) -> Set {
        let mut scene = Scene::open(context, planet_file(), SceneOptions::default()).unwrap();
        let planet = scene.planet();
        let site = highest(planet);
        let position = planet.position_above(site, altitude);
        let view = View::new(Camera::looking(position, 20.0, pitch, 0.9, SIZE), scene.lattice(), planet.cells, 1.0);
        let look = Look::daylight(sun_over(site, 120.0, 30.0));
        let cut = scene.settle(&view).unwrap();
        Set { context: context.clone(), scene, view, cut, look }
    }

    fn draw(&self, options: StillOptions) -> Still {
        self.draw_view(&self.view, options)
    }

    fn draw_view(&self, view: &View, options: StillOptions) -> Still {
        let mut studio = Studio::new(&self.context, SIZE, options).unwrap();
        let still = studio.draw(&self.scene, view, &self.cut, &self.look, &|_, _| ()).unwrap();
        assert_eq!(still.dropped_triangles, 0);
        still
    }
}

/// The highest of some sites all around the planet.
fn highest(planet: &Planet) -> DVec3 {
    let sites = (0..24).flat_map(|i| (-5..=5).map(move |j| direction_at(15.0 * f64::from(j), 15.0 * f64::from(i))));
    sites.max_by(|a, b| planet.terrain.height(*a).total_cmp(&planet.terrain.height(*b))).unwrap()
}

fn eight(still: &Still) -> &[u8] {
    match &still.pixels {
        Pixels::Eight(pixels) => pixels,
        other => panic!("{other:?}"),
    }
}

fn sixteen(still: &Still) -> &[u16] {
    match &still.pixels {
        Pixels::Sixteen(pixels) => pixels,
        other => panic!("{other:?}"),
    }
}

/// Pixels with a channel that differs by more than one code.
fn apart(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len());
    a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count()
}

/// Rasterisation rounds positions in a tile and in a whole picture differently: one pixel in a thousand may lie on the other side of an
/// outline.
const OUTLINE_PIXELS: usize = (SIZE[0] * SIZE[1] / 1000) as usize;

#[test]
fn a_picture_by_tiles_is_the_picture_at_once() {
    let Some(context) = device_with(Some(1)) else { return };
    for (altitude, pitch) in [(3000.0, -25.0), (200.0, -8.0)] {
        let set = Set::new(&context, altitude, pitch);
        let whole = set.draw(StillOptions::default());
        let tiled = set.draw(StillOptions { tile: 64, ..StillOptions::default() });
        assert_eq!((whole.tiles, tiled.tiles), (1, 6));
        assert_eq!(whole.exposure, tiled.exposure);
        let differing = apart(eight(&whole), eight(&tiled));
        assert!(differing <= OUTLINE_PIXELS, "{differing} pixels differ at {altitude} m");
        // The negative control: a picture that is moved by one pixel differs.
        let mut moved = set.view.camera;
        moved.forward = (moved.forward + moved.right() * moved.pixel_angle()).normalize();
        let moved = View::new(moved, set.scene.lattice(), set.scene.planet().cells, 1.0);
        let differing = apart(eight(&whole), eight(&set.draw_view(&moved, StillOptions { tile: 64, ..StillOptions::default() })));
        assert!(differing > 10 * OUTLINE_PIXELS.max(10), "only {differing} pixels differ in a moved picture");
    }
}

#[test]
fn sixteen_bits_say_what_the_shader_says_with_eight() {
    let Some(context) = device_with(Some(1)) else { return };
    let mut set = Set::new(&context, 3000.0, -20.0);
    let shaded = Tone::ALL.map(|tone| (Mode::Shaded, tone));
    let others = [Mode::Levels, Mode::Albedo, Mode::Normals, Mode::Depth].map(|mode| (mode, Tone::Neutral));
    for (mode, tone) in shaded.into_iter().chain(others) {
        (set.look.mode, set.look.tone) = (mode, tone);
        let shader = set.draw(StillOptions::default());
        let ours = set.draw(StillOptions { format: PixelFormat::Sixteen, ..StillOptions::default() });
        // Half a step for rounding, half for dither, and a tenth for `pow` of shader and CPU.
        let worst = |shader: &Still| {
            let differences =
                eight(shader).iter().zip(sixteen(&ours)).map(|(a, b)| (f32::from(*a) - f32::from(*b) / 257.0).abs());
            differences.fold(0.0f32, f32::max)
        };
        assert!(worst(&shader) <= 1.1, "{mode:?}: {} steps", worst(&shader));
        if mode == Mode::Shaded {
            set.look.exposure *= 1.1;
            let brighter = worst(&set.draw(StillOptions::default()));
            assert!(brighter > 1.5, "a tenth more light is {brighter} steps");
            set.look.exposure /= 1.1;
        }
    }
}

#[test]
fn supersampling_softens_outlines_and_one_sample_changes_nothing() {
    let Some(context) = device_with(Some(1)) else { return };
    // In pictures of depth all ground is brighter than some value, and space is black.
    let mut set = Set::new(&context, 3000.0, -20.0);
    set.look.mode = Mode::Depth;
    let shades = |still: &Still| sixteen(still).chunks_exact(4).map(|p| p[0]).filter(|&p| p > 0).collect::<Vec<u16>>();
    let options = |ssaa| StillOptions { format: PixelFormat::Sixteen, ssaa, ..StillOptions::default() };
    let least_ground = shades(&set.draw(options(1))).into_iter().min().unwrap();
    let soft = shades(&set.draw(options(3))).into_iter().filter(|&p| p < least_ground / 16 * 15).count();
    assert!(soft > SIZE[0] as usize / 4, "{soft} pixels are half ground");
    let tiled = set.draw(StillOptions { tile: 96, ..options(3) });
    assert!(tiled.tiles > 1);
    let differing = sixteen(&tiled).iter().zip(sixteen(&set.draw(options(3)))).filter(|(a, b)| a.abs_diff(**b) > 514).count();
    assert!(differing <= 4 * 3 * OUTLINE_PIXELS, "{differing} values differ");

    set.look.mode = Mode::Shaded;
    let mut headless = Headless::new(&context, (SIZE[0], SIZE[1])).unwrap();
    headless.render(&set.scene, &set.view, &set.cut, &set.look).unwrap();
    assert!(headless.pixels().unwrap() == eight(&set.draw(StillOptions::default())));
}

#[test]
fn a_transparent_picture_covers_what_it_shows() {
    let Some(context) = device_with(Some(1)) else { return };
    let set = Set::new(&context, 60_000.0, -60.0);
    let opaque = set.draw(StillOptions::default());
    let clear = set.draw(StillOptions { transparent: true, ..StillOptions::default() });
    let alphas: Vec<u8> = eight(&clear).chunks_exact(4).map(|p| p[3]).collect();
    let count = |of: fn(u8) -> bool| alphas.iter().filter(|&&a| of(a)).count();
    let (none, some, all) = (count(|a| a == 0), count(|a| a > 0 && a < 255), count(|a| a == 255));
    assert!(none > 500 && some > 50 && all > 500, "{none} pixels of space, {some} of air, {all} of ground");
    // Composited over black it equals the opaque picture.
    let before_black: Vec<u8> = eight(&clear)
        .chunks_exact(4)
        .flat_map(|p| [0, 1, 2].map(|k| (f32::from(p[k]) * f32::from(p[3]) / 255.0).round() as u8).into_iter().chain([255]))
        .collect();
    let differing = apart(&before_black, eight(&opaque));
    assert!(differing <= OUTLINE_PIXELS, "{differing} pixels differ");
    assert!(eight(&opaque).chunks_exact(4).all(|p| p[3] == 255));
}
