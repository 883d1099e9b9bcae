//! How smooth skylines are at one sample a pixel: a Markdown table with a line for each view of `tools/gallery.toml` and one of a desert.
//!
//! `cargo run --release -p terrane-tools --example skyline -- FOLDER [--size WxH] [NAME…]`
//!
//! FOLDER holds the planets, as `terrane gallery --work FOLDER` leaves them there. Counted are:
//!
//! * *Columns on slopes.* The skyline of a column is its uppermost pixel of ground under sky. Columns side by side with the same row are a
//!   run; a run is on a slope if the skyline goes down at one end and up at the other. Runs that end outside of the picture do not count.
//! * *Blended*: the share of these columns in which the pixel above or below the skyline shows something of the other; the longest row of
//!   columns of one run that are not; and the longest run.
//! * *Error*: root mean square of the ground's share in these pixels against a picture with sixteen times the pixels; and what it is
//!   without edges.
//! * *Alone*: pixels that differ in depth by a twentieth from three of their neighbours, all nearer or all farther, or that are ground
//!   between sky or sky between ground, and of which less than a quarter is blended away; and all such pixels.
//! * Milliseconds of the stage `edges`, the median of seven frames.

mod gallery;

use anyhow::{bail, Context as _};
use gallery::Entry;
use glam::{DVec3, IVec2};
use std::path::Path;
use std::sync::Arc;
use terrane::frame::{sun_over, Look, Stage};
use terrane::headless::{Edge, Headless};
use terrane::scene::{OnDemand, Scene, SceneOptions};
use terrane::vulkan::{Context, ContextOptions};
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::Stand;
use terrane_planet::globe::sphere::direction_at;

/// A view of a desert whose skyline is nearly level.
const DESERT: (&str, &str, &str) = ("desert", "terra", "--at 30.1,-48.2,300 --look 90,-4 --sun 60,25");

/// Frames whose median is told.
const FRAMES: usize = 7;

/// How many times as wide and high the picture is that errors are measured against.
const FINER: u32 = 4;

/// What the options of `terrane shot` say, as far as the list uses them.
struct Options {
    at: [f64; 3],
    look: [f64; 2],
    sun: [f64; 2],
    clouds: bool,
}

/// One picture: what each pixel shows.
struct Picture {
    size: [u32; 2],
    depth: Vec<f32>,
    edges: Vec<Option<Edge>>,
    /// Whether a pixel shows sky alone.
    sky: Vec<bool>,
}

#[derive(Default)]
struct Row {
    columns: usize,
    blended: usize,
    longest_level: usize,
    longest_run: usize,
    squares: [f64; 2],
    alone: usize,
    narrow: usize,
    edges_ms: f64,
}

fn main() -> anyhow::Result<()> {
    let (mut names, mut size, mut folder) = (Vec::new(), [1280, 720], None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--size" {
            let text = arguments.next().context("--size needs WxH")?;
            let (width, height) = text.split_once('x').context("--size needs WxH")?;
            size = [width.parse()?, height.parse()?];
        } else if folder.is_none() {
            folder = Some(argument);
        } else {
            names.push(argument);
        }
    }
    let folder = folder.context("usage: skyline FOLDER [--size WxH] [NAME…]")?;
    let desert = [DESERT].map(|(name, recipe, options)| [name, recipe, options].map(str::to_owned));
    let desert = desert.map(|[name, recipe, options]| Entry { name, recipe, options });
    let views = gallery::views()?;
    let context = Context::new(&ContextOptions { samples: Some(1), ..ContextOptions::default() })?;
    println!("| view | columns on slopes | blended % | longest run without | longest run | error | without edges | alone | of | edges ms |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for entry in views.iter().chain(&desert).filter(|entry| names.is_empty() || names.contains(&entry.name)) {
        let file = Path::new(&folder).join(&entry.recipe).with_extension("planet");
        let row = measure(&context, &file, &options(&entry.options)?, size)?;
        let share = |part: f64| if row.columns == 0 { 0.0 } else { part / row.columns as f64 };
        let [error, without] = row.squares.map(|squares| share(squares).sqrt());
        println!(
            "| {} | {} | {:.0} | {} | {} | {error:.3} | {without:.3} | {} | {} | {:.1} |",
            entry.name,
            row.columns,
            100.0 * share(row.blended as f64),
            row.longest_level,
            row.longest_run,
            row.alone,
            row.narrow,
            row.edges_ms,
        );
    }
    Ok(())
}

/// Reads the options of a view.
fn options(text: &str) -> anyhow::Result<Options> {
    let mut options = Options { at: [0.0; 3], look: [0.0; 2], sun: [135.0, 35.0], clouds: true };
    let mut words = text.split_whitespace();
    while let Some(word) = words.next() {
        match word {
            "--at" => options.at = numbers(words.next())?,
            "--look" => options.look = numbers(words.next())?,
            "--sun" => options.sun = numbers(words.next())?,
            "--clear-sky" => options.clouds = false,
            other => bail!("unexpected {other}"),
        }
    }
    Ok(options)
}

fn numbers<const N: usize>(word: Option<&str>) -> anyhow::Result<[f64; N]> {
    let found: Vec<f64> = word.unwrap_or_default().split(',').map(str::parse).collect::<Result<_, _>>()?;
    found.try_into().ok().context("another count of numbers")
}

/// Draws a view and counts.
fn measure(context: &Arc<Context>, file: &Path, options: &Options, size: [u32; 2]) -> anyhow::Result<Row> {
    let on_demand = Some(OnDemand { spacing_m: 1.0, cache: None });
    let scene = Scene::open(context, file, SceneOptions { on_demand, ..SceneOptions::default() });
    let mut scene = scene.with_context(|| format!("{}; bake it first", file.display()))?;
    let [latitude, longitude, altitude_m] = options.at;
    let [heading, pitch] = options.look;
    let keyframe = Keyframe { time_s: 0.0, latitude, longitude, stand: Stand::Altitude(altitude_m), heading, pitch, fov: 50.0 };
    let site: DVec3 = direction_at(latitude, longitude);
    let look = Look { clouds: options.clouds, ..Look::daylight(sun_over(site, options.sun[0], options.sun[1])) };
    scene.set_sun(look.sun);
    let view_of = |scene: &Scene, finer: u32| {
        let camera = scene.planet().camera_at(&keyframe, size.map(|side| finer * side));
        View::new(camera, scene.lattice(), scene.planet().cells, f64::from(finer))
    };
    let view = view_of(&scene, 1);
    let cut = scene.settle(&view)?;
    let mut headless = Headless::new(context, (size[0], size[1]))?;
    let mut times = Vec::new();
    for _ in 0..FRAMES {
        let report = headless.render(&scene, &view, &cut, &look)?;
        times.push(report.times.ms(Stage::Edges.name()).unwrap_or(0.0));
    }
    times.sort_by(f64::total_cmp);
    let picture = read(&headless, &scene, &view)?;
    let mut row = Row { edges_ms: times[FRAMES / 2], ..Row::default() };
    let shares = finer_shares(context, &scene, (&view_of(&scene, FINER), &cut), &look, size)?;
    slopes(&picture, &shares, &mut row);
    alone(&picture, &mut row);
    Ok(row)
}

fn read(headless: &Headless, scene: &Scene, view: &View) -> anyhow::Result<Picture> {
    let (depth, size) = (headless.depth()?, view.camera.size);
    let sky = depth.iter().enumerate().map(|(k, &depth)| depth <= 0.0 && !meets_sea(scene, view, k)).collect();
    Ok(Picture { size, depth, edges: headless.edges()?, sky })
}

/// Whether the ray through a pixel meets the sphere of the sea.
fn meets_sea(scene: &Scene, view: &View, pixel: usize) -> bool {
    let (camera, recipe) = (&view.camera, &scene.planet().recipe);
    let Some(sea) = &recipe.sea else { return false };
    let [width, height] = camera.size;
    let (h, v) = camera.half_extents();
    let x = (2.0 * f64::from(pixel as u32 % width) + 1.0) / f64::from(width) - 1.0;
    let y = 1.0 - (2.0 * f64::from(pixel as u32 / width) + 1.0) / f64::from(height);
    let ray = (camera.forward + camera.right() * (h * x) + camera.up * (v * y)).normalize();
    let along = camera.position.dot(ray);
    along < 0.0 && camera.position.length_squared() - along * along < (recipe.radius + sea.level_m).powi(2)
}

/// The share of each pixel that is not sky, from a finer picture of the same mesh.
fn finer_shares(
    context: &Arc<Context>,
    scene: &Scene,
    (view, cut): (&View, &Cut),
    look: &Look,
    size: [u32; 2],
) -> anyhow::Result<Vec<f32>> {
    let mut headless = Headless::new(context, (FINER * size[0], FINER * size[1]))?;
    headless.render(scene, view, cut, look)?;
    let finer = read(&headless, scene, view)?;
    let mut shares = vec![0.0; (size[0] * size[1]) as usize];
    for (k, sky) in finer.sky.iter().enumerate() {
        let (x, y) = (k as u32 % finer.size[0] / FINER, k as u32 / finer.size[0] / FINER);
        shares[(y * size[0] + x) as usize] += if *sky { 0.0 } else { 1.0 / (FINER * FINER) as f32 };
    }
    Ok(shares)
}

impl Picture {
    fn index(&self, at: IVec2) -> Option<usize> {
        let [width, height] = self.size.map(|side| side as i32);
        let inside = (0..width).contains(&at.x) && (0..height).contains(&at.y);
        inside.then(|| (at.y * width + at.x) as usize)
    }

    /// How much of a pixel shows what its neighbours show.
    fn blended(&self, at: usize) -> f32 {
        self.edges[at].map_or(0.0, |edge| edge.share)
    }

    /// The share of a pixel that is not sky.
    fn ground_share(&self, at: IVec2) -> f32 {
        let Some(own) = self.index(at) else { return 0.0 };
        let is_ground = |k: usize| if self.sky[k] { 0.0 } else { 1.0 };
        let Some(edge) = self.edges[own] else { return is_ground(own) };
        let other = self.index(at + IVec2::from_array(edge.neighbour)).unwrap_or(own);
        is_ground(own) * (1.0 - edge.share) + is_ground(other) * edge.share
    }
}

/// Counts columns on slopes, and compares what they show with the shares of a finer picture.
fn slopes(picture: &Picture, shares: &[f32], row: &mut Row) {
    let [width, height] = picture.size.map(|side| side as i32);
    let at = |x: i32, y: i32| (y * width + x) as usize;
    let skyline: Vec<Option<i32>> =
        (0..width).map(|x| (0..height).find(|&y| !picture.sky[at(x, y)]).filter(|&y| y > 0)).collect();
    let mut from = 0;
    while from < width {
        let y = skyline[from as usize];
        let to = (from..width).find(|&x| skyline[x as usize] != y).unwrap_or(width);
        let beside = |x: i32| skyline.get(usize::try_from(x).ok()?).copied().flatten();
        if let (Some(y), Some(before), Some(after)) = (y, beside(from - 1), beside(to)) {
            if (before < y) != (after < y) {
                count(picture, shares, (from..to, y), row);
            }
        }
        from = to;
    }
}

fn count(picture: &Picture, shares: &[f32], (run, y): (std::ops::Range<i32>, i32), row: &mut Row) {
    let mut level = 0;
    row.longest_run = row.longest_run.max(run.len());
    row.columns += run.len();
    for x in run {
        let pixels = [IVec2::new(x, y - 1), IVec2::new(x, y)];
        let indices = pixels.map(|pixel| picture.index(pixel).unwrap_or(0));
        let blended = indices.iter().any(|&k| picture.blended(k) > 0.0);
        row.blended += usize::from(blended);
        level = if blended { 0 } else { level + 1 };
        row.longest_level = row.longest_level.max(level);
        let sums = [
            pixels.iter().map(|&pixel| picture.ground_share(pixel)).sum::<f32>(),
            indices.iter().map(|&k| if picture.sky[k] { 0.0 } else { 1.0 }).sum(),
        ];
        let true_sum: f32 = indices.iter().map(|&k| shares[k]).sum();
        for (squares, sum) in row.squares.iter_mut().zip(sums) {
            *squares += f64::from(sum - true_sum).powi(2);
        }
    }
}

/// Counts pixels that stand alone.
fn alone(picture: &Picture, row: &mut Row) {
    for (k, &own) in picture.depth.iter().enumerate() {
        let at = IVec2::new(k as i32 % picture.size[0] as i32, k as i32 / picture.size[0] as i32);
        let neighbours = [IVec2::X, IVec2::NEG_X, IVec2::Y, IVec2::NEG_Y].map(|by| picture.index(at + by));
        if neighbours.contains(&None) {
            continue;
        }
        let count = |is: &dyn Fn(f32) -> bool| neighbours.iter().flatten().filter(|&&n| is(picture.depth[n])).count();
        let (nearer, farther) = (count(&|other| other > 1.05 * own), count(&|other| own > 1.05 * other));
        if nearer.max(farther) >= 3 {
            row.narrow += 1;
            row.alone += usize::from(picture.blended(k) < 0.25);
        }
    }
}
