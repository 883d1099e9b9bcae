//! Where patches come from: the planet file, what was cached beside it, or the builder. Whoever asks cannot tell: the bytes are the
//! same.

use super::keeper::KeeperHandle;
use super::loader::{Loaded, LoadedMesh, LoadedTexture};
use super::options::Scope;
use super::textures::{Relief, TextureMips};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use terrane_planet::draw::cut::{shows_through, urgency};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::horizon::{HorizonMap, WideGrids};
use terrane_planet::ground::texture::PatchTexture;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::mesh::survey::Survey;
use terrane_planet::planet::Planet;
use terrane_planet::query::PatchGrid;
use terrane_planet::store::{BakedPatch, PlanetFile, StoreError};

/// How patches were come by, since the scene was opened.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Read from a file.
    pub(super) read: AtomicU64,
    /// Sampled because no file held them, those that were then built included.
    pub(super) surveyed: AtomicU64,
    /// Built because no file held them.
    pub(super) built: AtomicU64,
    /// Microseconds that building took, all threads together.
    pub(super) build_us: AtomicU64,
}

/// The sun, and how many there were before: what is computed for one is stale under the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sun {
    /// Unit vector; shadows are left out as long as there is none.
    pub(super) direction: Option<DVec3>,
    pub(super) number: u64,
}

/// What every worker has for itself.
pub(super) struct Source {
    /// Files to look into, in this order.
    pub(super) files: Vec<PlanetFile>,
    /// The planet, to build what no file holds.
    pub(super) planet: Arc<Planet>,
    /// Whether to build at all.
    pub(super) builds: bool,
    /// Whether textures are wanted.
    pub(super) textures: bool,
    /// Which patches are.
    pub(super) scope: Scope,
    /// How the planet's patches split; none of them is in it.
    pub(super) tree: PatchTree,
    /// Heights around patches, shared by all workers.
    pub(super) grids: Arc<WideGrids>,
    /// Where the sun stands.
    pub(super) sun: Arc<RwLock<Sun>>,
    /// Takes what was built, to keep it.
    pub(super) keeper: Option<KeeperHandle>,
    pub(super) tally: Arc<Tally>,
}

impl Source {
    /// Finds out what is known of a patch. What no file holds is surveyed, and built at once if the view draws it.
    pub(super) fn explore(&self, id: PatchId, view: &View) -> Result<Loaded, StoreError> {
        if let Some(loaded) = self.read(id)? {
            return Ok(loaded);
        }
        let survey = self.survey(id)?;
        let node = self.tree.node(id, &survey.facts);
        let splits = self.tree.can_split(id) && urgency(&self.tree, view, id.level, &node) < 1.0;
        if !splits || self.scope != Scope::Still {
            return Ok(self.build(&survey));
        }
        let textured = self.textures && shows_through(&self.tree, view, id.level, &node.space);
        let texture = textured.then(|| self.texture(&survey));
        Ok(Loaded { id, facts: survey.facts, mesh: None, texture })
    }

    /// Reads or builds a patch.
    pub(super) fn load(&self, id: PatchId) -> Result<Loaded, StoreError> {
        if let Some(loaded) = self.read(id)? {
            return Ok(loaded);
        }
        let survey = self.survey(id)?;
        Ok(self.build(&survey))
    }

    /// Reads a patch's textures, or makes them.
    pub(super) fn load_texture(&self, id: PatchId) -> Result<Loaded, StoreError> {
        for file in &self.files {
            if file.contains(id)? {
                let facts = file.mesh(id)?.facts;
                let texture = Some(self.prepare_texture(id, &file.texture(id)?));
                return Ok(Loaded { id, facts, mesh: None, texture });
            }
        }
        let survey = self.survey(id)?;
        Ok(Loaded { id, facts: survey.facts, mesh: None, texture: Some(self.texture(&survey)) })
    }

    /// Reads a patch from the first file that holds it.
    fn read(&self, id: PatchId) -> Result<Option<Loaded>, StoreError> {
        for file in &self.files {
            if file.contains(id)? {
                let mesh = file.mesh(id)?;
                let texture = if self.textures { Some(self.prepare_texture(id, &file.texture(id)?)) } else { None };
                self.tally.read.fetch_add(1, Ordering::Relaxed);
                if let Some(keeper) = &self.keeper {
                    keeper.used(id);
                }
                return Ok(Some(self.prepare(mesh, texture)));
            }
        }
        Ok(None)
    }

    /// Surveys a patch, if it may be built at all.
    fn survey(&self, id: PatchId) -> Result<Survey, StoreError> {
        if !self.builds {
            return Err(StoreError::Absent { file: self.files.first().map_or_else(PathBuf::new, |f| f.path().to_owned()), id });
        }
        self.tally.surveyed.fetch_add(1, Ordering::Relaxed);
        Ok(self.timed(|| self.planet.survey(id)))
    }

    /// Builds a surveyed patch, and hands it to be kept.
    fn build(&self, survey: &Survey) -> Loaded {
        let id = survey.id;
        let (mesh, faults) = self.timed(|| survey.mesh(&self.planet.ground()));
        if faults != Default::default() {
            tracing::warn!(patch = %id, ?faults, "the builder broke its own rules");
        }
        self.tally.built.fetch_add(1, Ordering::Relaxed);
        let keeps = self.textures || self.keeper.is_some();
        let texture = keeps.then(|| self.timed(|| survey.texture(&self.planet.ground(), &self.planet.terrain)));
        if let (Some(keeper), Some(texture)) = (&self.keeper, &texture) {
            match BakedPatch::new(&mesh, texture) {
                Ok(baked) => keeper.built(baked),
                Err(reason) => {
                    tracing::warn!(patch = %id, %reason, "a patch cannot be cached; please report this with the recipe")
                }
            }
        }
        let texture = texture.filter(|_| self.textures).map(|texture| self.prepare_texture(id, &texture));
        self.prepare(mesh, texture)
    }

    fn texture(&self, survey: &Survey) -> LoadedTexture {
        let texture = self.timed(|| survey.texture(&self.planet.ground(), &self.planet.terrain));
        self.prepare_texture(survey.id, &texture)
    }

    /// Counts the time that building takes.
    fn timed<T>(&self, work: impl FnOnce() -> T) -> T {
        let begun = std::time::Instant::now();
        let result = work();
        self.tally.build_us.fetch_add(begun.elapsed().as_micros() as u64, Ordering::Relaxed);
        result
    }

    /// Horizon angles of a patch towards the sun as it stands now, and its ambient occlusion.
    pub(super) fn relief(&self, id: PatchId) -> Relief {
        let sun = *self.sun.read().unwrap_or_else(PoisonError::into_inner);
        let direction = sun.direction.unwrap_or_else(|| id.centre());
        let mut map = HorizonMap::new(&self.planet.ground(), &self.grids, id, direction);
        if sun.direction.is_none() {
            map.horizon.fill(-1.0);
        }
        Relief::new(&map, sun.number)
    }

    fn prepare_texture(&self, id: PatchId, texture: &PatchTexture) -> LoadedTexture {
        LoadedTexture { mips: TextureMips::new(texture, self.planet.cells), relief: self.relief(id) }
    }

    fn prepare(&self, mesh: PatchMesh, texture: Option<LoadedTexture>) -> Loaded {
        let grid = PatchGrid::of_mesh(&mesh, &self.planet.lattice);
        let (id, facts) = (mesh.id, mesh.facts);
        let mesh = LoadedMesh { patch: LoadedPatch::new(mesh, &self.planet.lattice), grid };
        Loaded { id, facts, mesh: Some(mesh), texture }
    }
}
