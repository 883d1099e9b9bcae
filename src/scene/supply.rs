//! What a scene needs to start workers: for the planet that it opens with, and anew for each ground that an edit makes of it.

use super::keeper::Keeper;
use super::loader::Loader;
use super::options::{SceneOptions, Scope};
use super::source::{all_records, Source, Sun, Tally};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, RwLock};
use std::time::Duration;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::ground::surroundings::KnownSurroundings;
use terrane_planet::planet::Planet;
use terrane_planet::published::{Otherwise, PublishedPlanet, PublishedRecords};
use terrane_planet::store::slow::Line;
use terrane_planet::store::{PlanetFile, PlanetHeader, StoreError};

/// Requests that are under way at a time over a line: its latency is waited out by all of them together.
const IN_FLIGHT: usize = 16;

/// Where a scene's patches come from, whichever ground they are of.
#[derive(Clone)]
pub(super) struct Supply {
    /// The planet file.
    pub(super) path: PathBuf,
    /// What the scene may use.
    pub(super) options: SceneOptions,
    /// The line that the file is at the other end of, if it is.
    pub(super) line: Option<Arc<Line>>,
    /// Most patches under way to the GPU.
    pub(super) under_way: usize,
    pub(super) tally: Arc<Tally>,
    pub(super) sun: Arc<RwLock<Sun>>,
}

impl Supply {
    /// Of a scene that opens the planet file at a path.
    pub(super) fn new(path: &Path, options: &SceneOptions, line: Option<Arc<Line>>, under_way: usize) -> Supply {
        let (path, options) = (path.to_owned(), options.clone());
        Supply { path, options, line, under_way, tally: Arc::default(), sun: Arc::default() }
    }

    /// Where a planet is published, if that is this one with the ground that it has now.
    pub(super) fn published(&self, header: &PlanetHeader) -> Option<&Arc<PublishedPlanet>> {
        self.options.published.as_ref().filter(|published| published.is_of(header))
    }

    /// The records of a planet that is published; `stop` ends all waiting for them.
    pub(super) fn records_of(&self, published: &Arc<PublishedPlanet>, stop: &Arc<AtomicBool>) -> PublishedRecords {
        let otherwise = match (self.builds(), self.options.scope) {
            (true, _) => Otherwise::Build,
            // Whoever flies has a picture meanwhile.
            (false, Scope::Flight) => Otherwise::Wait { stop: stop.clone(), patience: Duration::MAX },
            (false, _) => Otherwise::wait(),
        };
        PublishedRecords::new(published.clone(), otherwise)
    }

    /// Whether what no file holds is built.
    pub(super) fn builds(&self) -> bool {
        self.options.on_demand.is_some()
    }

    /// The tree of a planet of which no patch is known yet.
    pub(super) fn bare_tree(&self, planet: &Planet) -> PatchTree {
        let tree = planet.tree([]);
        match &self.options.on_demand {
            Some(on_demand) => tree.built_to(planet.level_of_spacing(on_demand.spacing_m)),
            None => tree,
        }
    }

    /// Who keeps what is built of a planet, if anything is to be kept.
    pub(super) fn keeper(&self, header: &PlanetHeader) -> Option<Keeper> {
        let cache = self.options.on_demand.as_ref()?.cache.as_ref()?;
        Keeper::start(&self.path, header, cache)
    }

    /// Workers that read and build patches of a planet. Heights `around` patches are shared by them.
    ///
    /// # Errors
    /// If the files cannot be opened.
    pub(super) fn loader(
        &self,
        planet: &Arc<Planet>,
        keeper: Option<&Keeper>,
        around: &Arc<KnownSurroundings>,
    ) -> Result<Loader, StoreError> {
        // A planet's header has copies of all its images: it is made only where it is asked for, and once.
        let published = self.options.published.as_ref().and_then(|_| self.published(&planet.header()));
        let in_flight = if self.line.is_some() || published.is_some() { IN_FLIGHT } else { 0 };
        let side = keeper.and_then(|keeper| keeper.side.as_ref());
        let stop = Arc::new(AtomicBool::new(false));
        let records = || {
            let side = side.map(|side| PlanetFile::open(side)).transpose()?;
            let published = published.map(|published| self.records_of(published, &stop));
            Ok(all_records(PlanetFile::open(&self.path)?, self.line.as_ref(), side, published))
        };
        Loader::new(self.under_way, in_flight, stop.clone(), || {
            Ok(Source {
                files: records()?,
                planet: planet.clone(),
                builds: self.builds(),
                textures: self.options.textures,
                scope: self.options.scope,
                tree: self.bare_tree(planet),
                keeper: keeper.and_then(Keeper::handle),
                tally: self.tally.clone(),
                around: around.clone(),
                sun: self.sun.clone(),
            })
        })
    }
}
