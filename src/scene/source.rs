//! Where patches come from: the planet file, what was cached beside it, or the builder. Whoever asks cannot tell: the bytes are the
//! same.

use super::keeper::KeeperHandle;
use super::loader::Loaded;
use super::textures::{Relief, TextureMips};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::horizon::{HorizonMap, WideGrids};
use terrane_planet::ground::texture::PatchTexture;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::Planet;
use terrane_planet::query::PatchGrid;
use terrane_planet::store::{BakedPatch, PlanetFile, StoreError};

/// How patches were come by, since the scene was opened.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Read from a file.
    pub(super) read: AtomicU64,
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
    /// Heights around patches, shared by all workers.
    pub(super) grids: Arc<WideGrids>,
    /// Where the sun stands.
    pub(super) sun: Arc<RwLock<Sun>>,
    /// Takes what was built, to keep it.
    pub(super) keeper: Option<KeeperHandle>,
    pub(super) tally: Arc<Tally>,
}

impl Source {
    /// Reads or builds a patch.
    pub(super) fn load(&self, id: PatchId) -> Result<Loaded, StoreError> {
        for file in &self.files {
            if file.contains(id)? {
                let mesh = file.mesh(id)?;
                let texture = if self.textures { Some(file.texture(id)?) } else { None };
                self.tally.read.fetch_add(1, Ordering::Relaxed);
                if let Some(keeper) = &self.keeper {
                    keeper.used(id);
                }
                return Ok(self.prepare(mesh, texture));
            }
        }
        if !self.builds {
            return Err(StoreError::Absent { file: self.files.first().map_or_else(PathBuf::new, |f| f.path().to_owned()), id });
        }
        let begun = std::time::Instant::now();
        let (mesh, texture, faults) = self.planet.build(id);
        if faults != Default::default() {
            tracing::warn!(patch = %id, ?faults, "the builder broke its own rules");
        }
        self.tally.built.fetch_add(1, Ordering::Relaxed);
        self.tally.build_us.fetch_add(begun.elapsed().as_micros() as u64, Ordering::Relaxed);
        if let Some(keeper) = &self.keeper {
            match BakedPatch::new(&mesh, &texture) {
                Ok(baked) => keeper.built(baked),
                Err(reason) => {
                    tracing::warn!(patch = %id, %reason, "a patch cannot be cached; please report this with the recipe")
                }
            }
        }
        let texture = self.textures.then_some(texture);
        Ok(self.prepare(mesh, texture))
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

    fn prepare(&self, mesh: PatchMesh, texture: Option<PatchTexture>) -> Loaded {
        let relief = texture.as_ref().map(|_| self.relief(mesh.id));
        let texture = texture.map(|texture| TextureMips::new(&texture, self.planet.cells));
        let grid = PatchGrid::of_mesh(&mesh, &self.planet.lattice);
        Loaded { patch: LoadedPatch::new(mesh, &self.planet.lattice), texture, relief, grid }
    }
}
