//! What the pictures of the gallery look like in numbers: the table of `docs/picture.md`.
//!
//! ```sh
//! cargo build --release -p terrane-tools && cargo run --release -p terrane-tools --example picture_numbers
//! ```
//!
//! Every view is drawn by the command beside this program as OpenEXR, which holds the radiance and what the picture was exposed with; the
//! codes are those of the twin of the tone curve. The cards are level ones on the ground below the camera, in sun and skylight.

mod gallery;

use anyhow::{bail, ensure, Context as _};
use exr::prelude::{attribute::AttributeValue, read_first_rgba_layer_from_file, LayerAttributes};
use gallery::Entry;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use terrane_planet::draw::layout::{Mode, Tone, LUMINANCE};
use terrane_planet::draw::meter;
use terrane_planet::draw::tone::Curve;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::recipe::{shipped, Recipe};
use terrane_planet::reference::tonemap::display;

/// Pictures, planets and radiance go there.
const WORK: &str = "out";
const SIZE: [usize; 2] = [1280, 720];
/// Codes of luminance that count as the planet: above what space and its stars come to.
const SPACE: f32 = 8.0;

/// Radiance, and what it was taken with.
struct Shot {
    radiance: Vec<Vec3>,
    exposure: f32,
    curve: Curve,
    /// Sine of the sun's elevation over the site below the camera.
    sine: f64,
}

fn main() -> anyhow::Result<()> {
    std::fs::create_dir_all(WORK)?;
    println!("| view | sun | 18 % card | white | 5 % | median | 95 % | 99 % | at 255 |\n|---|---|---|---|---|---|---|---|---|");
    let mut sea = None;
    for entry in &gallery::views()? {
        let recipe = shipped::load(&entry.recipe)?;
        let shot = draw(entry)?;
        println!("{}", row(&entry.name, &recipe, &shot));
        if entry.name == "terra-orbit" {
            sea = sea_colour(&shot);
        }
    }
    if let Some([r, g, b]) = sea {
        println!("\nThe sea from orbit (median of what is blue in the middle of `terra-orbit`): ({r}, {g}, {b}).");
    }
    Ok(())
}

/// Draws a view of the gallery as radiance.
fn draw(entry: &Entry) -> anyhow::Result<Shot> {
    let planet = format!("{WORK}/{}.planet", entry.recipe);
    run(&["bake", &entry.recipe, "--levels", "1", "--out", &planet])?;
    let picture = format!("{WORK}/{}.exr", entry.name);
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let options: Vec<&str> = entry.options.split_whitespace().collect();
    run(&[&["shot", &planet][..], &options, &["--size", &size, "--out", &picture]].concat())?;
    read(Path::new(&picture))
}

/// Runs the command that is beside this program's folder.
fn run(arguments: &[&str]) -> anyhow::Result<()> {
    let program: PathBuf = std::env::current_exe()?.with_file_name("../terrane");
    let status = Command::new(&program).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).status();
    let status = status.with_context(|| format!("cannot run {}: build it first", program.display()))?;
    ensure!(status.success(), "terrane {} failed", arguments.join(" "));
    Ok(())
}

fn read(path: &Path) -> anyhow::Result<Shot> {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| vec![Vec3::ZERO; size.area()],
        |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * SIZE[0] + at.x()] = Vec3::new(r, g, b),
    )?;
    let attributes = &image.layer_data.attributes;
    let (latitude, longitude) = (attributes.latitude.unwrap_or_default(), attributes.longitude.unwrap_or_default());
    let AttributeValue::FloatVec3(sun) = attribute(attributes, "sunDirection")? else { bail!("a sun without direction") };
    let AttributeValue::F32(exposure) = *attribute(attributes, "displayExposure")? else { bail!("no exposure") };
    let AttributeValue::F32(white) = *attribute(attributes, "displayWhite")? else { bail!("no white") };
    let sun = DVec3::new(sun.0.into(), sun.1.into(), sun.2.into());
    Ok(Shot {
        radiance: image.layer_data.channel_data.pixels,
        exposure,
        curve: Curve::new(Tone::Neutral, white.into()),
        sine: direction_at(latitude.into(), longitude.into()).dot(sun),
    })
}

fn attribute<'a>(attributes: &'a LayerAttributes, name: &str) -> anyhow::Result<&'a AttributeValue> {
    let found = attributes.other.iter().find(|(key, _)| **key == *name);
    found.map(|(_, value)| value).with_context(|| format!("no {name} in the header"))
}

impl Shot {
    fn codes(&self, radiance: Vec3) -> Vec3 {
        255.0 * display(Mode::Shaded, &self.curve, self.exposure, radiance)
    }

    /// Code of a level card below the camera.
    fn card(&self, recipe: &Recipe, reflectance: f64) -> f32 {
        self.codes(Vec3::splat((reflectance / PI * meter::irradiance(recipe, self.sine)) as f32)).x
    }
}

fn row(name: &str, recipe: &Recipe, shot: &Shot) -> String {
    let codes: Vec<Vec3> = shot.radiance.iter().map(|&radiance| shot.codes(radiance)).collect();
    let mut luminance: Vec<f32> = codes.iter().map(|c| c.dot(Vec3::from_array(LUMINANCE))).filter(|&l| l > SPACE).collect();
    luminance.sort_by(f32::total_cmp);
    let [low, median, high, top] = [5, 50, 95, 99].map(|percent| luminance[(luminance.len() - 1) * percent / 100]);
    let full = codes.iter().filter(|c| c.max_element() >= 254.5).count() as f64 / codes.len() as f64;
    let [grey, white] = [0.18, recipe.white].map(|reflectance| shot.card(recipe, reflectance));
    format!(
        "| {name} | {:.0}° | {grey:.0} | {white:.0} | {low:.0} | {median:.0} | {high:.0} | {top:.0} | {:.2} % |",
        shot.sine.asin().to_degrees(),
        100.0 * full
    )
}

/// Median code of each channel of what is sea in the middle of a picture: four times as blue as red in linear light.
fn sea_colour(shot: &Shot) -> Option<[u8; 3]> {
    let [width, height] = SIZE;
    let middle = |k: usize| (k % width).abs_diff(width / 2) < height / 3 && (k / width).abs_diff(height / 2) < height / 3;
    let seen = shot.radiance.iter().enumerate().filter(|(k, c)| middle(*k) && c.z > 4.0 * c.x);
    let sea: Vec<Vec3> = seen.map(|(_, &c)| shot.codes(c)).collect();
    (!sea.is_empty()).then(|| {
        [0, 1, 2].map(|channel| {
            let mut values: Vec<f32> = sea.iter().map(|c| c[channel]).collect();
            values.sort_by(f32::total_cmp);
            values[values.len() / 2].round() as u8
        })
    })
}
