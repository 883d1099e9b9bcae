//! Options that the rendering commands share: which GPU, where the camera is, which patches there are.

use super::at::{at, At, Stance};
use super::planets::PlanetPlace;
use anyhow::{bail, ensure};
use glam::DVec3;
use std::sync::Arc;
use terrane::scene::{CacheOptions, OnDemand, SceneOptions};
use terrane::vulkan::{Context, ContextOptions, GpuChoice, ValidationMessage};
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::draw::view::{Camera, View, TOLERANCE_RANGE};
pub(crate) use terrane_planet::draw::view_line::Exposure;
use terrane_planet::draw::view_line::{Stand, ViewLine};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::Planet;
use terrane_planet::published::PublishedPlanet;
use terrane_planet::recipe::Recipe;

/// Largest side of a picture in pixels (the smallest limit that Vulkan guarantees is 4,096; most devices allow this).
const LARGEST_SIDE: u32 = 16_384;

/// Latitude and longitude of the camera unless told otherwise.
const DEFAULT_SITE: [f64; 2] = [20.0, 0.0];

/// Its altitude then, in planet radii above ground or sea: the planet fills most of the picture.
const DEFAULT_ALTITUDE_RADII: f64 = 1.9;

/// Its field of view in degrees, its picture's size and its tolerance in pixels, unless told otherwise.
const DEFAULT_FOV: f64 = 50.0;
const DEFAULT_SIZE: [u32; 2] = [1280, 720];
const DEFAULT_ERROR: f64 = 1.0;

/// Metres between samples to which patches are built unless told otherwise.
const DEFAULT_SPACING: f64 = 1.0;

/// Megabytes of built patches to keep, of patches on the GPU, and of patches in main memory, unless told otherwise.
const CACHE_MB: u64 = 2000;
const GPU_MB: u64 = 3000;
const HOST_MB: u64 = 1000;

/// Which GPU to use.
#[derive(clap::Args, Clone)]
pub(crate) struct GpuOptions {
    /// GPU to use: its number, part of its name, or its UUID or the first eight digits or more of that, as `terrane gpus` lists them.
    #[arg(long, value_name = "N|NAME|UUID")]
    gpu: Option<String>,
    /// Run the Vulkan validation layer, with synchronization validation; any message is an error.
    #[arg(long)]
    validate: bool,
    /// Samples a pixel for smooth edges of the ground; 4 unless told otherwise, and 1 on software renderers.
    #[arg(long, value_name = "1|2|4|8", value_parser = samples)]
    msaa: Option<u32>,
    /// Invocations per subgroup of the compute stages, where the GPU can choose (`terrane gpus` lists the sizes): for checks.
    #[arg(long, value_name = "N")]
    subgroup: Option<u32>,
}

fn samples(text: &str) -> anyhow::Result<u32> {
    match text.parse() {
        Ok(samples @ (1 | 2 | 4 | 8)) => Ok(samples),
        _ => bail!("'{text}' is not 1, 2, 4 or 8"),
    }
}

impl GpuOptions {
    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        self.msaa = self.msaa.or(line.msaa);
    }

    /// Puts into a view what was given.
    pub(crate) fn note(&self, line: &mut ViewLine) {
        line.msaa = self.msaa;
    }

    /// The GPU as it was given, for another command.
    pub(crate) fn given(&self) -> Option<&str> {
        self.gpu.as_deref()
    }

    /// What to create a context with.
    pub(crate) fn options(&self) -> ContextOptions {
        let gpu = self.gpu.as_deref().map_or(GpuChoice::Auto, GpuChoice::parse);
        ContextOptions { gpu, validation: self.validate, samples: self.msaa, subgroup_size: self.subgroup }
    }

    /// A context without a window.
    pub(crate) fn context(&self) -> anyhow::Result<Arc<Context>> {
        Ok(Context::new(&self.options())?)
    }

    /// Fails if validation had anything to say.
    pub(crate) fn report_messages(&self, context: &Context) -> anyhow::Result<()> {
        report_messages(&context.messages())
    }
}

/// Prints validation's messages and fails if there are any.
pub(crate) fn report_messages(messages: &[ValidationMessage]) -> anyhow::Result<()> {
    for message in messages {
        eprintln!("validation: {message:?}");
    }
    ensure!(messages.is_empty(), "{} validation messages, see above", messages.len());
    Ok(())
}

/// Where the camera is and what it resolves.
#[derive(clap::Args, Clone, Default)]
pub(crate) struct CameraOptions {
    /// Latitude and longitude in degrees, and metres above the ground or the sea there; or a place of the planet, which `terrane info`
    /// lists; by default the whole planet from afar.
    #[arg(long, value_name = "LAT,LON,ALT_M|PLACE[,ALT_M]", value_parser = at, allow_hyphen_values = true)]
    at: Option<At>,
    /// Degrees clockwise from north, and degrees above the horizontal; by default as the place has it, else towards the horizon, or down
    /// from afar.
    #[arg(long, value_name = "HEADING,PITCH", value_parser = numbers::<2>, allow_hyphen_values = true)]
    look: Option<[f64; 2]>,
    /// Vertical field of view in degrees [default: 50].
    #[arg(long, value_name = "DEG")]
    fov: Option<f64>,
    /// Picture size in pixels [default: 1280x720].
    #[arg(long, value_name = "WxH", value_parser = picture_size)]
    size: Option<[u32; 2]>,
    /// Largest error of the mesh in pixels [default: 1].
    #[arg(long, value_name = "PX")]
    error: Option<f64>,
    /// Seconds that the waves of the sea have run [default: 0].
    #[arg(long, value_name = "SECONDS", value_parser = wave_time)]
    time: Option<f64>,
    /// Whether the third number of `at` is metres above the datum, as a view can have it.
    #[arg(skip)]
    above_datum: bool,
    /// Whether the sea is left out, so that the camera may be below its level.
    #[arg(skip)]
    without_sea: bool,
}

fn wave_time(text: &str) -> anyhow::Result<f64> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e9).contains(&seconds) => Ok(seconds),
        _ => bail!("'{text}' is not a number of seconds from 0 to 1e9"),
    }
}

impl CameraOptions {
    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        if self.at.is_none() {
            let ([latitude, longitude], stand) = (line.at, line.stand);
            self.above_datum = matches!(stand, Stand::Height(_));
            self.without_sea = line.no_sea;
            let (Stand::Altitude(metres) | Stand::Height(metres)) = stand;
            self.at = Some(At::Site([latitude, longitude, metres]));
        }
        self.look = self.look.or(line.look);
        self.fov = self.fov.or(line.fov);
        self.size = self.size.or(line.size);
        self.error = self.error.or(line.error);
        self.time = self.time.or(line.time);
    }

    /// The view of this camera, everything else as usual.
    pub(crate) fn line(&self, planet: &Planet) -> anyhow::Result<ViewLine> {
        let keyframe = self.keyframe(planet)?;
        let stand = match self.at {
            Some(At::Site([_, _, height])) if self.above_datum => Stand::Height(height),
            _ => keyframe.stand,
        };
        let mut line = ViewLine::from_site([keyframe.latitude, keyframe.longitude], stand);
        line.look = Some([keyframe.heading, keyframe.pitch]);
        line.fov = Some(keyframe.fov);
        line.size = Some(self.size());
        line.error = Some(self.error());
        line.time = self.time.filter(|seconds| *seconds > 0.0);
        Ok(line)
    }

    /// Largest error of the mesh in pixels.
    pub(crate) fn error(&self) -> f64 {
        self.error.unwrap_or(DEFAULT_ERROR)
    }

    /// The same without a place of its own: a whole planet from afar.
    pub(crate) fn of_whole_planet(&self) -> CameraOptions {
        CameraOptions { at: None, look: None, time: None, above_datum: false, without_sea: false, ..self.clone() }
    }

    /// Takes a tolerance where none was given.
    pub(crate) fn choose_error(&mut self, pixels: Option<f64>) {
        let (least, most) = TOLERANCE_RANGE;
        self.error = self.error.or(pixels.filter(|pixels| (least..=most).contains(pixels)));
    }

    /// Seconds that waves have run.
    pub(crate) fn time(&self) -> f64 {
        self.time.unwrap_or(0.0)
    }

    fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(DEFAULT_SIZE)
    }

    /// Where the camera stands on a planet.
    fn stance(&self, recipe: &Recipe) -> anyhow::Result<Stance> {
        let [latitude, longitude] = DEFAULT_SITE;
        let afar = ([latitude, longitude, DEFAULT_ALTITUDE_RADII * recipe.radius], None);
        self.at.as_ref().map_or(Ok(afar), |at| at.stance(recipe))
    }

    /// Unit vector to the site under the camera.
    pub(crate) fn site(&self, recipe: &Recipe) -> anyhow::Result<DVec3> {
        let ([latitude, longitude, _], _) = self.stance(recipe)?;
        Ok(direction_at(latitude, longitude))
    }

    /// The camera over a planet.
    pub(crate) fn camera(&self, planet: &Planet) -> anyhow::Result<Camera> {
        check_tolerance(self.error())?;
        let keyframe = self.keyframe(planet)?;
        let camera = planet.camera_at(&keyframe, self.size());
        match (&self.at, self.above_datum && self.without_sea) {
            (Some(At::Site([_, _, height])), true) => {
                let position = direction_at(keyframe.latitude, keyframe.longitude) * (planet.recipe.radius + height);
                Ok(Camera::looking(position, keyframe.heading, keyframe.pitch, camera.fov, camera.size))
            }
            _ => Ok(camera),
        }
    }

    /// Metres above the datum of what a view's camera has to be above.
    fn surface(&self, planet: &Planet, site: DVec3) -> f64 {
        if self.without_sea {
            planet.terrain.height(site)
        } else {
            planet.surface_height(site)
        }
    }

    fn keyframe(&self, planet: &Planet) -> anyhow::Result<Keyframe> {
        let (mut at, look) = self.stance(&planet.recipe)?;
        if self.above_datum {
            let surface = self.surface(planet, self.site(&planet.recipe)?);
            let height = at[2];
            at[2] -= surface;
            ensure!(
                at[2] >= 0.5,
                "the view's height is {height} m, expected {:.1} m or more: ground or sea there, and half a metre",
                surface + 0.5
            );
        }
        keyframe_at(at, self.look.or(look), self.fov.unwrap_or(DEFAULT_FOV), planet)
    }
}

/// What `--at`, `--look` and `--fov` say of a camera over a planet: latitude and longitude in degrees and metres above ground or sea;
/// heading and pitch in degrees, by default towards the horizon; the field of view in degrees.
pub(crate) fn keyframe_at(at: [f64; 3], look: Option<[f64; 2]>, fov: f64, planet: &Planet) -> anyhow::Result<Keyframe> {
    let [latitude, longitude, altitude_m] = at;
    ensure!((-90.0..=90.0).contains(&latitude), "--at: latitude {latitude} is not within -90 and 90 degrees");
    ensure!((-360.0..=360.0).contains(&longitude), "--at: longitude {longitude} is not within -360 and 360 degrees");
    ensure!((1.0..=20.0).contains(&(fov / 7.0)), "--fov: {fov} is not within 7 and 140 degrees");
    ensure!((0.5..=1e9).contains(&altitude_m), "--at: altitude {altitude_m} is not within 0.5 and 1e9 metres");
    let [heading, pitch] = look.unwrap_or([0.0, default_pitch(planet.recipe.radius, altitude_m, fov)]);
    ensure!((-90.0..=90.0).contains(&pitch), "--look: pitch {pitch} is not within -90 and 90 degrees");
    Ok(Keyframe { time_s: 0.0, latitude, longitude, stand: Stand::Altitude(altitude_m), heading, pitch, fov })
}

/// Refuses a tolerance, in pixels, that `--error` cannot have.
pub(crate) fn check_tolerance(error: f64) -> anyhow::Result<()> {
    let (least, most) = TOLERANCE_RANGE;
    ensure!((least..=most).contains(&error), "--error: {error} is not within {least} and {most} pixels");
    Ok(())
}

/// Pitch that puts the horizon into the upper third of the picture; straight down where the whole planet fits into it.
fn default_pitch(radius: f64, altitude_m: f64, fov: f64) -> f64 {
    let dip = (radius / (radius + altitude_m)).acos().to_degrees();
    let angular_radius = 90.0 - dip;
    if angular_radius < fov * 0.75 {
        -90.0
    } else {
        -(dip + fov * 0.2).min(90.0)
    }
}

/// How the mesh follows the view.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct MeshOptions {
    /// Let vertices jump into their positions when they wake, instead of sliding there.
    #[arg(long)]
    no_geomorphs: bool,
    /// Let vertices slide into their positions even where a view, or what was chosen in the last window, says otherwise.
    #[arg(long, conflicts_with = "no_geomorphs")]
    geomorphs: bool,
    /// Count errors as they are seen: fewer triangles where the ground is seen from above.
    #[arg(long)]
    orientation: bool,
}

impl MeshOptions {
    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        self.no_geomorphs |= line.no_geomorphs && !self.geomorphs;
        self.orientation |= line.orientation;
    }

    /// Whether vertices slide into their positions.
    pub(crate) fn geomorphs(self) -> bool {
        !self.no_geomorphs
    }

    /// Whether errors count as they are seen.
    pub(crate) fn orientation(self) -> bool {
        self.orientation
    }

    /// What differs from the usual, to be read after a list.
    pub(crate) fn describe(self) -> String {
        let parts = [(self.no_geomorphs, ", no geomorphs"), (self.orientation, ", orientation term")];
        parts.into_iter().filter(|(given, _)| *given).map(|(_, words)| words).collect()
    }

    /// A view as these options want it.
    pub(crate) fn apply(self, view: View, planet: &Planet) -> View {
        let view = if self.no_geomorphs { view.without_geomorphs() } else { view };
        if self.orientation {
            view.with_orientation(planet.ground_radius())
        } else {
            view
        }
    }
}

/// Which patches there are to draw, and how much room they may take.
#[derive(clap::Args, Clone)]
pub(crate) struct PatchOptions {
    /// Draw only patches that the planet file holds, or that are published; others are built when they are wanted.
    #[arg(long, visible_alias = "no-build")]
    stored_only: bool,
    /// Fetch no patches of a planet that is published: build all of them.
    #[arg(long, conflicts_with = "stored_only")]
    no_fetch: bool,
    /// Build patches until their samples are this far apart [default: 1].
    #[arg(long, value_name = "METRES")]
    spacing: Option<f64>,
    /// Most megabytes of built patches to keep in the planet file for another time, or in the user's cache folder if it cannot be
    /// written; 0 keeps none.
    #[arg(long, value_name = "MB", default_value_t = CACHE_MB)]
    cache: u64,
    /// Most megabytes of patches on the GPU; with fewer the picture is coarser.
    #[arg(long, value_name = "MB", default_value_t = GPU_MB)]
    gpu_memory: u64,
    /// Most megabytes of patches in main memory, on their way to the GPU and as the ground below the camera; with fewer the picture is
    /// coarser, or comes more slowly.
    #[arg(long, value_name = "MB", default_value_t = HOST_MB)]
    host_memory: u64,
}

impl PatchOptions {
    /// Those of a command that builds patches down to a spacing in metres, and asks for nothing else.
    pub(crate) fn to_spacing(spacing: f64) -> PatchOptions {
        PatchOptions {
            stored_only: false,
            no_fetch: false,
            spacing: Some(spacing),
            cache: CACHE_MB,
            gpu_memory: GPU_MB,
            host_memory: HOST_MB,
        }
    }

    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        self.spacing = self.spacing.or(line.spacing);
        self.stored_only |= line.stored_only;
    }

    /// Puts into a view what is not as usual.
    pub(crate) fn note(&self, line: &mut ViewLine) {
        line.spacing = self.spacing.filter(|spacing| *spacing != DEFAULT_SPACING);
        line.stored_only = self.stored_only;
    }

    /// Where to fetch what a planet's file lacks.
    pub(crate) fn published(&self, place: &PlanetPlace) -> Option<Arc<PublishedPlanet>> {
        place.published().filter(|_| !self.no_fetch).cloned()
    }

    /// What to open a scene with, whatever its planet.
    pub(crate) fn options(&self) -> anyhow::Result<SceneOptions> {
        let spacing_m = self.spacing.unwrap_or(DEFAULT_SPACING);
        ensure!((0.01..=1e9).contains(&spacing_m), "--spacing: {spacing_m} is not within 0.01 and 1e9 metres");
        let bytes = |megabytes: u64| megabytes.saturating_mul(1_000_000);
        let side = directories::ProjectDirs::from("", "", "terrane").map(|folders| folders.cache_dir().to_owned());
        let cache = (self.cache > 0).then(|| CacheOptions { bytes: bytes(self.cache), side });
        let on_demand = (!self.stored_only).then_some(OnDemand { spacing_m, cache });
        let (gpu_bytes, host_bytes) = (bytes(self.gpu_memory), bytes(self.host_memory));
        Ok(SceneOptions { gpu_bytes, host_bytes, on_demand, ..SceneOptions::default() })
    }
}

/// Parses numbers separated by commas.
pub(crate) fn numbers<const N: usize>(text: &str) -> anyhow::Result<[f64; N]> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    match parsed.ok().and_then(|v| <[f64; N]>::try_from(v).ok()).filter(|v| v.iter().all(|x| x.is_finite())) {
        Some(values) => Ok(values),
        None => bail!("'{text}' is not {N} numbers separated by commas"),
    }
}

/// Parses a size such as 1280x720.
pub(crate) fn picture_size(text: &str) -> anyhow::Result<[u32; 2]> {
    let sides: Option<Vec<u32>> = text.split(['x', 'X', '×']).map(|part| part.parse().ok()).collect();
    match sides.as_deref() {
        Some(&[width, height]) if (16..=LARGEST_SIDE).contains(&width) && (16..=LARGEST_SIDE).contains(&height) => {
            Ok([width, height])
        }
        _ => bail!("'{text}' is not a size such as 1280x720 with sides from 16 to {LARGEST_SIDE}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Given {
        #[command(flatten)]
        mesh: MeshOptions,
    }

    #[test]
    fn geomorphs_that_are_asked_for_go_before_what_a_view_says() {
        let mut view = ViewLine::from_site([0.0; 2], Stand::Height(0.0));
        for no_geomorphs in [false, true] {
            view.no_geomorphs = no_geomorphs;
            let slides = |options: &[&str]| {
                let mut given = Given::try_parse_from([&["terrane"], options].concat()).unwrap();
                given.mesh.take(&view);
                given.mesh.geomorphs()
            };
            assert_eq!([&[][..], &["--geomorphs"], &["--no-geomorphs"]].map(slides), [!no_geomorphs, true, false]);
        }
        assert!(Given::try_parse_from(["terrane", "--geomorphs", "--no-geomorphs"]).is_err());
    }
}
