//! What all commands share that draw with a GPU: how the mesh follows the view, which patches there are, how the picture looks, which GPU.

use super::look_options::LookOptions;
use super::planets::PlanetPlace;
use super::viewing::{Exposure, GpuOptions, MeshOptions, PatchOptions};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use terrane::frame::Look;
use terrane::scene::{Scene, SceneError, SceneOptions, Scope};
use terrane::vulkan::Context;
use terrane_planet::draw::camera_path::{CameraPath, Carried};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;

/// How a command draws.
#[derive(clap::Args, Clone)]
pub(crate) struct DrawOptions {
    #[command(flatten)]
    pub(crate) mesh: MeshOptions,
    #[command(flatten)]
    pub(crate) patches: PatchOptions,
    #[command(flatten)]
    pub(crate) look: LookOptions,
    #[command(flatten)]
    pub(crate) gpu: GpuOptions,
}

impl DrawOptions {
    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        self.mesh.take(line);
        self.patches.take(line);
        self.look.take(line);
        self.gpu.take(line);
    }

    /// Puts into a view what decides its picture; `usual` is the exposure that was not given.
    pub(crate) fn note(&self, line: &mut ViewLine, usual: Exposure) {
        line.no_geomorphs = !self.mesh.geomorphs();
        line.orientation = self.mesh.orientation();
        self.patches.note(line);
        self.look.note(line, usual);
        self.gpu.note(line);
    }

    /// A context without a window, and a planet file as a scene on it, for single pictures.
    pub(crate) fn open(&self, place: &PlanetPlace) -> anyhow::Result<(Arc<Context>, Scene)> {
        self.open_for(place, Scope::Still)
    }

    /// A context without a window, and a planet file as a scene on it.
    pub(crate) fn open_for(&self, place: &PlanetPlace, scope: Scope) -> anyhow::Result<(Arc<Context>, Scene)> {
        self.open_with(place.path(), SceneOptions { scope, published: self.patches.published(place), ..self.patches.options()? })
    }

    /// A context without a window, and a planet file as a scene on it.
    pub(crate) fn open_with(&self, file: &Path, options: SceneOptions) -> anyhow::Result<(Arc<Context>, Scene)> {
        let context = self.gpu.context()?;
        let scene = Scene::open(&context, file, options)?;
        Ok((context, scene))
    }

    /// What a camera over a planet sees, with errors of at most `tolerance` pixels.
    pub(crate) fn view(&self, camera: Camera, planet: &Planet, tolerance: f64) -> View {
        self.mesh.apply(View::new(camera, &planet.lattice, planet.cells, tolerance), planet)
    }

    /// The look of a whole path: the sun stands still, as seen from where the path ends. Along a path that leads so far from there that
    /// the sun would set, it goes with the camera, if no date says where it is.
    pub(crate) fn look_along(&self, recipe: &Recipe, path: &CameraPath) -> PathLook {
        let look = self.look.look(recipe, path.at(path.span().1).up, Exposure::Fixed(1.0));
        let goes = !self.look.has_date() && path.leads_round();
        PathLook { look, sun: goes.then(|| path.carry(look.sun)) }
    }
}

/// What frames along a path look like.
pub(crate) struct PathLook {
    look: Look,
    /// Where the sun does not stand still.
    sun: Option<Carried>,
}

impl PathLook {
    /// At a time of the path.
    pub(crate) fn at(&self, time_s: f64) -> Look {
        Look { sun: self.sun.as_ref().map_or(self.look.sun, |sun| sun.at(time_s)), ..self.look }
    }
}

/// Updates a scene until it can draw a whole picture of a view, however coarse: all that its cut draws is on the GPU.
pub(crate) fn first_picture(scene: &mut Scene, view: &View) -> Result<(), SceneError> {
    loop {
        let cut = scene.update(view, usize::MAX)?;
        if scene.is_whole(view, &cut) {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
