//! Where patches come from: the planet file, what was cached beside it, or the builder. Whoever asks cannot tell: the bytes are the
//! same.

use super::keeper::KeeperHandle;
use super::loader::{Loaded, LoadedMesh, LoadedTexture, Parts};
use super::options::Scope;
use super::textures::{Relief, TextureMips};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use terrane_planet::draw::cut::{shows_textures, urgency};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::draw::work::sleeps;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::horizon::HorizonMap;
use terrane_planet::ground::surroundings::{sample_surroundings, KnownSurroundings, Surroundings};
use terrane_planet::ground::texture::PatchTexture;
use terrane_planet::ground::Ground;
use terrane_planet::mesh::progressive::{MeshPrefix, PatchFacts};
use terrane_planet::mesh::survey::Survey;
use terrane_planet::mesh::wake::Wake;
use terrane_planet::planet::Planet;
use terrane_planet::published::PublishedRecords;
use terrane_planet::query::PatchGrid;
use terrane_planet::store::slow::{Line, SlowFile};
use terrane_planet::store::{records, surroundings, BakedPatch, PlanetFile, Records, StoreError};

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
    pub(super) files: Vec<Box<dyn Records>>,
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
    pub(super) around: Arc<KnownSurroundings>,
    /// Where the sun stands.
    pub(super) sun: Arc<RwLock<Sun>>,
    /// Takes what was built, to keep it.
    pub(super) keeper: Option<KeeperHandle>,
    pub(super) tally: Arc<Tally>,
}

/// Where records of a scene's planet come from, first to last: the planet file, over a line if there is one; the one beside it; and where
/// the planet is published.
pub(super) fn all_records(
    file: PlanetFile,
    line: Option<&Arc<Line>>,
    side: Option<PlanetFile>,
    published: Option<PublishedRecords>,
) -> Vec<Box<dyn Records>> {
    let file: Box<dyn Records> = match line {
        Some(line) => Box::new(SlowFile::new(file, line.clone())),
        None => Box::new(file),
    };
    let side = side.map(|side| Box::new(side) as Box<dyn Records>);
    let published = published.map(|published| Box::new(published) as Box<dyn Records>);
    std::iter::once(file).chain(side).chain(published).collect()
}

impl Source {
    /// Finds out what is known of a patch, and loads of it what the view draws.
    pub(super) fn explore(&self, id: PatchId, view: &View) -> Result<Loaded, StoreError> {
        let mut stored = None;
        for file in &self.files {
            stored = stored.or(file.facts(id)?);
        }
        let (facts, survey) = match stored {
            Some(facts) => (facts, None),
            None => {
                let survey = self.survey(id);
                (survey.facts, Some(survey))
            }
        };
        let node = self.tree.node(id, &facts);
        let is_drawn = !self.tree.can_split(id) || urgency(&self.tree, view, id.level, &node) >= 1.0;
        let shown = shows_textures(&self.tree, view, id, &node.space, is_drawn);
        let found = Found { facts: Some(facts), survey, ..Found::default() };
        let parts = Parts { mesh: is_drawn || self.scope != Scope::Still, texture: self.textures && shown };
        self.load_into(found, id, parts, Some(view))
    }

    /// Reads parts of a patch, or builds them. For a still's view a mesh is as fine as that can wake; else it is whole.
    pub(super) fn load(&self, id: PatchId, parts: Parts, view: Option<&View>) -> Result<Loaded, StoreError> {
        self.load_into(Found::default(), id, parts, view)
    }

    fn load_into(&self, mut found: Found, id: PatchId, parts: Parts, view: Option<&View>) -> Result<Loaded, StoreError> {
        let view = view.filter(|_| self.scope == Scope::Still);
        self.read(&mut found, id, parts, view)?;
        let lacks = Parts { mesh: parts.mesh && found.mesh.is_none(), texture: parts.texture && found.texture.is_none() };
        if lacks.mesh && !self.builds {
            return Err(StoreError::Absent { file: self.files.first().map_or_else(PathBuf::new, |f| f.path().to_owned()), id });
        }
        if found.facts.is_none() || lacks != Parts::default() {
            let survey = found.survey.take().unwrap_or_else(|| self.survey(id));
            self.build(&mut found, &survey, lacks);
            found.survey = Some(survey);
        }
        if let (Some(keeper), Some(survey)) = (&self.keeper, &found.survey) {
            let built = found.mesh.as_ref().filter(|_| lacks.mesh).map(|prefix| &prefix.mesh);
            let (mesh, texture) = (built, found.texture.as_ref().filter(|_| lacks.texture));
            match BakedPatch::in_part(id, &survey.facts, self.planet.cells, mesh, texture) {
                Ok(baked) => keeper.built(baked),
                Err(reason) => {
                    tracing::warn!(patch = %id, %reason, "a patch cannot be cached; please report this with the recipe")
                }
            }
        }
        Ok(self.prepare(id, found, view))
    }

    /// Reads what the files hold of the parts of a patch; for a still's view as many chunks of the mesh as that can wake, and without a
    /// view the first.
    fn read(&self, found: &mut Found, id: PatchId, parts: Parts, view: Option<&View>) -> Result<(), StoreError> {
        let _span = tracing::debug_span!("read", patch = %id).entered();
        let enough = |facts: &PatchFacts, beyond: Wake| match view {
            Some(view) => sleeps(view, &facts.bounds, beyond),
            None => self.scope == Scope::Still,
        };
        for file in self.files.iter().map(|file| &**file) {
            if parts.mesh && found.mesh.is_none() {
                found.mesh = records::mesh(file, id, &enough)?;
                found.facts = found.mesh.as_ref().map(|prefix| prefix.mesh.facts).or(found.facts);
                self.tally.read.fetch_add(u64::from(found.mesh.is_some()), Ordering::Relaxed);
            }
            if parts.texture && found.texture.is_none() {
                found.texture = records::texture(file, id)?;
                if let (Some(_), None) = (&found.texture, found.facts) {
                    found.facts = file.facts(id)?;
                }
            }
        }
        if let (Some(keeper), Some(_)) = (&self.keeper, found.facts) {
            keeper.used(id);
        }
        Ok(())
    }

    fn survey(&self, id: PatchId) -> Survey {
        self.tally.surveyed.fetch_add(1, Ordering::Relaxed);
        self.timed(|| self.planet.survey(id))
    }

    /// Builds what is lacking of a surveyed patch.
    fn build(&self, found: &mut Found, survey: &Survey, lacks: Parts) {
        found.facts = Some(survey.facts);
        if lacks.mesh {
            let (mesh, faults) = self.timed(|| survey.mesh(&self.planet.ground()));
            if faults != Default::default() {
                tracing::warn!(patch = %survey.grid.id, ?faults, "the builder broke its own rules");
            }
            self.tally.built.fetch_add(1, Ordering::Relaxed);
            found.mesh = Some(mesh.into());
        }
        if lacks.texture {
            found.texture = Some(self.timed(|| survey.texture(&self.planet.ground(), &self.planet.terrain)));
        }
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
        let _span = tracing::debug_span!("relief", patch = %id).entered();
        let sun = *self.sun.read().unwrap_or_else(PoisonError::into_inner);
        let direction = sun.direction.unwrap_or_else(|| id.centre());
        let ground = self.planet.ground();
        let mut around = |id| self.around.get(id, || Surroundings::new(&ground, id, &self.heights_around(&ground, id)));
        let mut map = HorizonMap::new(&ground, id, direction, &mut around);
        if sun.direction.is_none() {
            map.horizon.fill(-1.0);
        }
        Relief::new(&map, sun.number)
    }

    /// Heights around a patch, from a file or else from the terrain.
    fn heights_around(&self, ground: &Ground, id: PatchId) -> Vec<i32> {
        for file in &self.files {
            match records::surroundings(&**file, id) {
                Ok(Some(heights)) => return heights,
                Ok(None) => {}
                Err(error) => tracing::warn!(%error, "heights around a patch are sampled again"),
            }
        }
        let heights = sample_surroundings(ground, id);
        if let Some(keeper) = &self.keeper {
            match surroundings::encode(&heights, id, self.planet.cells) {
                Ok(record) => keeper.sampled((id, record)),
                Err(reason) => tracing::warn!(patch = %id, %reason, "heights around a patch cannot be kept; please report this"),
            }
        }
        heights
    }

    fn prepare(&self, id: PatchId, found: Found, view: Option<&View>) -> Loaded {
        let texture = found
            .texture
            .map(|texture| LoadedTexture { mips: TextureMips::new(&texture, self.planet.cells), relief: self.relief(id) });
        let Planet { cells, lattice, .. } = &*self.planet;
        let mut grid = found.survey.map(|survey| PatchGrid::of_survey(&survey.grid, *cells, lattice));
        let mesh = found.mesh.map(|prefix| {
            let patch = LoadedPatch::new(prefix, lattice);
            grid = Some(PatchGrid::of_loaded(&patch, lattice));
            LoadedMesh { finest: view.map_or(0, |view| patch.reach.finest(view)), patch, view: view.copied() }
        });
        Loaded { id, facts: found.facts, mesh, texture, grid }
    }
}

/// What was read or built of a patch so far.
#[derive(Default)]
struct Found {
    facts: Option<PatchFacts>,
    survey: Option<Survey>,
    mesh: Option<MeshPrefix>,
    texture: Option<PatchTexture>,
}
