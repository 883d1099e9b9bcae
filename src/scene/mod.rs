//! The scene: which patches of a planet are on the GPU. Nothing here blocks a frame: patches are read and decoded by
//! background workers, uploaded under a budget, and a patch splits only when all four children are there.
//!
//! In: a planet file and a view. Out: the cut, and the resident patches that it draws.

mod drawn_ground;
mod loader;
mod resident;
mod textures;

pub use drawn_ground::DrawnGround;
pub use resident::ResidentPatch;
pub use textures::TexturePool;

use crate::vulkan::{Commands, Context, Upload, VulkanError};
use loader::{Loaded, Loader};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use terrane_planet::lattice::Lattice;
use terrane_planet::patch::PatchId;
use terrane_planet::planet::{Planet, PlanetError};
use terrane_planet::query::KnownGround;
use terrane_planet::reference::cut::{cut, Cut};
use terrane_planet::store::{PlanetFile, StoreError};
use terrane_planet::tree::{PatchFacts, PatchTree};
use terrane_planet::view::View;
use thiserror::Error;

/// Bytes staged at a time.
const UPLOAD_CHUNK: u64 = 8 << 20;

/// Updates for which nothing is asked for after a patch was turned away.
const PATIENCE: u64 = 60;

/// Why a scene cannot be opened or kept up to date.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The planet file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Its recipe.
    #[error(transparent)]
    Planet(#[from] PlanetError),
    /// The GPU.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The threads that read patches are gone.
    #[error("the threads that read the planet file have stopped; please report this")]
    LoaderStopped,
    /// A file without the six whole faces.
    #[error("{file}: {missing} of the 6 whole-face patches are missing: the bake stopped early; run `terrane bake` again to finish it")]
    NoRoots {
        /// The file.
        file: String,
        /// How many are missing.
        missing: usize,
    },
}

/// What a scene may use.
#[derive(Clone, Copy, Debug)]
pub struct SceneOptions {
    /// Most patches on the GPU at a time, at least 64; with textures also at most the device's limit of image layers.
    pub capacity: u32,
    /// Whether to load textures (checks of the mesh do without).
    pub textures: bool,
}

impl SceneOptions {
    /// Every patch that a view asks for, without textures: for checks of the mesh.
    pub fn whole_mesh() -> Self {
        SceneOptions { capacity: u32::MAX, textures: false }
    }
}

impl Default for SceneOptions {
    fn default() -> Self {
        SceneOptions { capacity: 1280, textures: true }
    }
}

/// A planet and its patches on the GPU.
pub struct Scene {
    context: Arc<Context>,
    planet: Planet,
    tree: PatchTree,
    resident: HashMap<PatchId, ResidentPatch>,
    ground: DrawnGround,
    textures: TexturePool,
    loader: Loader,
    capacity: usize,
    frame: u64,
    /// The update in which a patch was last turned away, because all resident ones were in use.
    full_at: Option<u64>,
}

impl Scene {
    /// Opens a planet file and loads the six whole faces.
    pub fn open(context: &Arc<Context>, path: &Path, options: SceneOptions) -> Result<Scene, SceneError> {
        let file = PlanetFile::open(path)?;
        let planet = Planet::from_header(file.header())?;
        let records = file.index()?;
        let missing = PatchId::roots().filter(|root| !records.iter().any(|r| r.id == *root)).count();
        if missing > 0 {
            return Err(SceneError::NoRoots { file: path.display().to_string(), missing });
        }
        let tree = PatchTree::new(planet.lattice, planet.cells, records.iter().map(PatchFacts::from));
        // Only textures need a layer for each patch.
        let most = if options.textures { context.limits().max_image_array_layers } else { u32::MAX };
        let capacity = options.capacity.clamp(64, most).min(records.len() as u32);
        let layers = if options.textures { capacity } else { 1 };
        let textures = TexturePool::new(context, planet.cells, layers)?;
        let loader = Loader::new(path, planet.lattice, options.textures)?;
        let mut scene = Scene {
            context: context.clone(),
            ground: DrawnGround::new(KnownGround::new(planet.lattice, planet.cells)),
            planet,
            tree,
            resident: HashMap::new(),
            textures,
            loader,
            capacity: capacity as usize,
            frame: 0,
            full_at: None,
        };
        scene.loader.request(PatchId::roots().map(|id| (id, 0.0)).collect());
        while scene.resident.len() < 6 {
            let arrived = scene.loader.wait(Duration::from_secs(60))?;
            scene.upload(arrived)?;
        }
        Ok(scene)
    }

    /// The planet that the file was baked from.
    pub fn planet(&self) -> &Planet {
        &self.planet
    }

    /// Its lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.planet.lattice
    }

    /// All stored patches.
    pub fn tree(&self) -> &PatchTree {
        &self.tree
    }

    /// A patch on the GPU.
    pub fn resident(&self, id: PatchId) -> Option<&ResidentPatch> {
        self.resident.get(&id)
    }

    /// Number of patches on the GPU.
    pub fn resident_count(&self) -> usize {
        self.resident.len()
    }

    /// The ground of the resident patches.
    pub fn ground(&self) -> &DrawnGround {
        &self.ground
    }

    /// Textures of the resident patches.
    pub fn textures(&self) -> &TexturePool {
        &self.textures
    }

    /// Computes the cut of a view from what is resident, asks for what it lacks, and takes in up to `uploads` patches that have
    /// arrived.
    pub fn update(&mut self, view: &View, uploads: usize) -> Result<Cut, SceneError> {
        self.stage_arrived(uploads)?.finish()?;
        Ok(self.choose(view))
    }

    /// The first half of [`Scene::update`] for a window: the uploads become part of the frame that `commands` records, and nothing is
    /// waited for. The ground may have changed then: [`Scene::choose`] the cut once the viewer is above it.
    pub fn receive(&mut self, uploads: usize, commands: &mut Commands) -> Result<(), SceneError> {
        Ok(self.stage_arrived(uploads)?.record(commands)?)
    }

    fn stage_arrived(&mut self, uploads: usize) -> Result<Upload, SceneError> {
        self.frame += 1;
        let arrived = self.loader.take(uploads)?;
        self.stage(arrived)
    }

    /// Computes the cut of a view from what is resident, and asks for what it lacks.
    pub fn choose(&mut self, view: &View) -> Cut {
        let resident = &self.resident;
        let cut = cut(&self.tree, view, &|id| resident.contains_key(&id));
        self.ground.follow(&cut);
        self.mark_used(&cut);
        self.request(&cut);
        cut
    }

    /// Updates until everything the view wants is resident (or nothing more fits), and returns the final cut.
    pub fn settle(&mut self, view: &View) -> Result<Cut, SceneError> {
        self.full_at = None;
        loop {
            let cut = self.update(view, usize::MAX)?;
            if cut.wanted.is_empty() {
                return Ok(cut);
            }
            if self.full_at.is_some() {
                tracing::warn!(capacity = self.capacity, "the view wants more patches than fit: the picture is coarser");
                return Ok(cut);
            }
            tracing::debug!(wanted = cut.wanted.len(), resident = self.resident.len(), "settling");
            let arrived = self.loader.wait(Duration::from_secs(60))?;
            self.upload(arrived)?;
        }
    }

    fn mark_used(&mut self, cut: &Cut) {
        for leaf in &cut.leaves {
            let mut at = Some(leaf.id);
            while let Some(id) = at {
                match self.resident.get_mut(&id) {
                    Some(patch) if patch.last_used != self.frame => patch.last_used = self.frame,
                    _ => break,
                }
                at = id.parent();
            }
        }
    }

    fn request(&mut self, cut: &Cut) {
        let children = |&(id, urgency): &(PatchId, f64)| id.children().into_iter().flatten().map(move |child| (child, urgency));
        // What was just turned away would be again: it is not read and decoded anew for every frame.
        if self.full_at.is_some_and(|at| self.frame < at + PATIENCE) {
            return self.loader.request(Vec::new());
        }
        let missing = cut.wanted.iter().flat_map(children).filter(|(id, _)| !self.resident.contains_key(id)).collect();
        self.loader.request(missing);
    }

    fn upload(&mut self, arrived: Vec<Loaded>) -> Result<(), SceneError> {
        Ok(self.stage(arrived)?.finish()?)
    }

    fn stage(&mut self, arrived: Vec<Loaded>) -> Result<Upload, SceneError> {
        let mut upload = Upload::new(&self.context, UPLOAD_CHUNK);
        for loaded in arrived {
            if self.resident.contains_key(&loaded.patch.mesh.id) {
                continue;
            }
            if self.resident.len() >= self.capacity && !self.evict() {
                self.full_at = Some(self.frame);
                continue;
            }
            let layer = loaded.texture.as_ref().and_then(|_| self.textures.claim());
            if let (Some(layer), Some(mips)) = (layer, &loaded.texture) {
                self.textures.upload(&mut upload, layer, mips)?;
            }
            let patch = ResidentPatch::new(&self.context, &mut upload, &loaded.patch, layer, self.frame)?;
            self.resident.insert(loaded.patch.mesh.id, patch);
            self.ground.known.insert(loaded.grid);
        }
        Ok(upload)
    }

    /// Frees the least recently used patch that no resident child stands on and the latest frame did not use.
    fn evict(&mut self) -> bool {
        let has_children = |id: PatchId| id.children().into_iter().flatten().any(|c| self.resident.contains_key(&c));
        let idle = self.resident.iter().filter(|(id, p)| id.level > 0 && p.last_used + 1 < self.frame && !has_children(**id));
        let Some(oldest) = idle.min_by_key(|(id, p)| (p.last_used, **id)).map(|(id, _)| *id) else { return false };
        self.ground.known.remove(oldest);
        if let Some(layer) = self.resident.remove(&oldest).and_then(|p| p.layer) {
            self.textures.release(layer);
        }
        true
    }
}
