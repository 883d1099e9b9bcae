//! The scene: which patches of a planet are on the GPU. Nothing here blocks a frame: patches are read, or built where no file holds
//! them, by background workers, uploaded under a budget, and a patch splits only when all four children are there.
//!
//! In: a planet file and a view. Out: the cut, and the resident patches that it draws.

mod clouds;
mod drawn_ground;
mod keeper;
mod loader;
mod options;
mod resident;
mod source;
mod textures;

pub use clouds::CloudMaps;
pub use drawn_ground::DrawnGround;
pub use keeper::CacheOptions;
pub use options::{uploads_within, OnDemand, SceneOptions};
pub use resident::ResidentPatch;
pub use textures::TexturePool;

use crate::vulkan::{Commands, Context, Upload, VulkanError};
use glam::DVec3;
use keeper::Keeper;
use loader::{Loaded, Loader, Request, Response};
use options::Budget;
use source::{Source, Sun, Tally};
use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;
use terrane_planet::draw::cut::{cut, Cut};
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::horizon::WideGrids;
use terrane_planet::planet::{Planet, PlanetError};
use terrane_planet::query::KnownGround;
use terrane_planet::store::{PlanetFile, StoreError};
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

/// How a scene came by its patches, since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneTally {
    /// Patches read from a file.
    pub read: u64,
    /// Patches built.
    pub built: u64,
    /// Seconds that building took, all threads together.
    pub build_s: f64,
}

/// A planet and its patches on the GPU.
pub struct Scene {
    context: Arc<Context>,
    planet: Arc<Planet>,
    tree: PatchTree,
    resident: HashMap<PatchId, ResidentPatch>,
    ground: DrawnGround,
    textures: TexturePool,
    clouds: CloudMaps,
    loader: Loader,
    // Dropped after the loader, whose workers hand it what they built.
    _keeper: Option<Keeper>,
    tally: Arc<Tally>,
    sun: Arc<RwLock<Sun>>,
    capacity: usize,
    has_textures: bool,
    frame: u64,
    settled: bool,
    /// The update in which a patch was last turned away, because all resident ones were in use.
    full_at: Option<u64>,
}

impl Scene {
    /// Opens a planet file and loads the six whole faces.
    pub fn open(context: &Arc<Context>, path: &Path, options: SceneOptions) -> Result<Scene, SceneError> {
        let file = PlanetFile::open(path)?;
        let planet = Arc::new(Planet::from_header(file.header())?);
        let records = file.index()?;
        let missing = PatchId::roots().filter(|root| !records.iter().any(|r| r.id == *root)).count();
        if missing > 0 && options.on_demand.is_none() {
            return Err(SceneError::NoRoots { file: path.display().to_string(), missing });
        }
        let mut tree = planet.tree(records.iter().map(|r| (r.id, r.facts)));
        let mut most_patches = u32::try_from(records.len()).unwrap_or(u32::MAX);
        let mut keeper = None;
        if let Some(on_demand) = &options.on_demand {
            tree = tree.built_to(planet.level_of_spacing(on_demand.spacing_m));
            most_patches = u32::MAX;
            keeper = on_demand.cache.as_ref().and_then(|cache| Keeper::start(path, file.header(), cache));
        }
        let Budget { capacity, under_way } =
            Budget::new(&options, planet.cells, most_patches, context.limits().max_image_array_layers);
        let layers = if options.textures { capacity } else { 1 };
        let textures = TexturePool::new(context, planet.cells, layers)?;
        let tally = Arc::new(Tally::default());
        let (grids, sun) = (Arc::new(WideGrids::default()), Arc::new(RwLock::new(Sun::default())));
        let loader = Loader::new(under_way, || {
            let mut files = vec![PlanetFile::open(path)?];
            if let Some(side) = keeper.as_ref().and_then(|k| k.side.as_ref()) {
                files.push(PlanetFile::open(side)?);
            }
            Ok(Source {
                files,
                planet: planet.clone(),
                builds: options.on_demand.is_some(),
                textures: options.textures,
                keeper: keeper.as_ref().and_then(Keeper::handle),
                tally: tally.clone(),
                grids: grids.clone(),
                sun: sun.clone(),
            })
        })?;
        // The workers read the first patches while the clouds are made.
        loader.request(PatchId::roots().map(|id| (id, Request::Patch, 0.0)).collect());
        let clouds = CloudMaps::new(context, &planet.recipe, options.textures)?;
        let mut scene = Scene {
            context: context.clone(),
            ground: DrawnGround::new(KnownGround::new(planet.lattice, planet.cells)),
            planet,
            tree,
            resident: HashMap::new(),
            textures,
            clouds,
            loader,
            _keeper: keeper,
            tally,
            sun,
            capacity: capacity as usize,
            has_textures: options.textures,
            frame: 0,
            settled: false,
            full_at: None,
        };
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

    /// The same, to be kept.
    pub fn shared_planet(&self) -> Arc<Planet> {
        self.planet.clone()
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

    /// Bytes that the patches on the GPU take, textures of absent ones included, and the most they may take.
    pub fn gpu_bytes(&self) -> (u64, u64) {
        let meshes: u64 = self.resident.values().map(|patch| patch.buffer().bytes()).sum();
        let layers = if self.has_textures { self.capacity as u64 * textures::bytes_of_layer(self.planet.cells) } else { 0 };
        (meshes + layers, self.capacity as u64 * resident::bytes_of_patch(self.planet.cells) + layers)
    }

    /// Bytes of main memory that patches take at most while so many are on the GPU and under way, and the most they may take.
    pub fn host_bytes(&self) -> (u64, u64) {
        let ground = drawn_ground::bytes_of_patch(self.planet.cells);
        let under_way = loader::bytes_under_way(self.planet.cells);
        let [now, most] = [(self.resident.len(), self.loader.under_way()), (self.capacity, self.loader.most_under_way)];
        let bytes = |(resident, moving): (usize, usize)| resident as u64 * ground + moving as u64 * under_way;
        (bytes(now), bytes(most))
    }

    /// Patches asked for, and not yet on the GPU.
    pub fn pending(&self) -> usize {
        self.loader.pending()
    }

    /// How the patches were come by.
    pub fn tally(&self) -> SceneTally {
        let [read, built, build_us] =
            [&self.tally.read, &self.tally.built, &self.tally.build_us].map(|n| n.load(Ordering::Relaxed));
        SceneTally { read, built, build_s: build_us as f64 * 1e-6 }
    }

    /// Whether the latest cut lacks nothing that could still be had: another picture of the same view would be the same.
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Says where the sun stands (a unit vector): shadows follow it as soon as the workers find time, and a scene is not settled before.
    pub fn set_sun(&mut self, direction: DVec3) {
        let mut sun = self.sun.write().unwrap_or_else(PoisonError::into_inner);
        if self.has_textures && sun.direction != Some(direction) {
            *sun = Sun { direction: Some(direction), number: sun.number + 1 };
        }
    }

    /// Drawn patches, and those that show through them, whose light is that of an earlier sun.
    fn stale(&self, cut: &Cut) -> Vec<PatchId> {
        let number = self.sun.read().unwrap_or_else(PoisonError::into_inner).number;
        let drawn = cut.leaves.iter().flat_map(|leaf| [Some(leaf.id), leaf.id.parent()]).flatten();
        let mut stale: Vec<PatchId> =
            drawn.filter(|id| self.resident.get(id).is_some_and(|patch| patch.layer.is_some() && patch.sun != number)).collect();
        stale.sort_unstable();
        stale.dedup();
        stale
    }

    /// Textures of the resident patches.
    pub fn textures(&self) -> &TexturePool {
        &self.textures
    }

    /// Its clouds.
    pub fn clouds(&self) -> &CloudMaps {
        &self.clouds
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
        let stale = self.stale(&cut);
        self.settled = stale.is_empty() && (cut.wanted.is_empty() || self.full_at.is_some());
        self.mark_used(&cut);
        self.request(&cut, &stale);
        cut
    }

    /// Updates until everything the view wants is resident (or nothing more fits), and returns the final cut.
    pub fn settle(&mut self, view: &View) -> Result<Cut, SceneError> {
        self.settle_showing(view, &mut |_, _| ())
    }

    /// [`Scene::settle`], telling now and then how many patches are on the GPU, and how many more are pending so far.
    pub fn settle_showing(&mut self, view: &View, show: &mut dyn FnMut(usize, usize)) -> Result<Cut, SceneError> {
        self.full_at = None;
        loop {
            let cut = self.update(view, usize::MAX)?;
            if self.settled {
                if self.full_at.is_some() {
                    tracing::warn!(capacity = self.capacity, "the view wants more patches than fit: the picture is coarser");
                }
                return Ok(cut);
            }
            show(self.resident.len(), self.loader.pending());
            let arrived = self.loader.wait(Duration::from_secs(60))?;
            self.upload(arrived)?;
        }
    }

    fn mark_used(&mut self, cut: &Cut) {
        // Those that wait for others count as used: taken out to make room for these, they would be asked for for ever.
        for id in cut.ideal.iter().copied().chain(cut.above.iter().map(|(id, _)| *id)) {
            if let Some(patch) = self.resident.get_mut(&id) {
                patch.last_used = self.frame;
            }
        }
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

    fn request(&mut self, cut: &Cut, stale: &[PatchId]) {
        // What was just turned away would be again: it is not read and decoded anew for every frame.
        let turned_away = self.full_at.is_some_and(|at| self.frame < at + PATIENCE);
        let wanted: &[_] = if turned_away { &[] } else { &cut.wanted };
        let missing = wanted.iter().map(|&(id, urgency)| (id, Request::Patch, urgency));
        // Shape before light.
        self.loader.request(missing.chain(stale.iter().map(|&id| (id, Request::Horizon, f64::MAX))).collect());
    }

    fn upload(&mut self, arrived: Vec<Response>) -> Result<(), SceneError> {
        Ok(self.stage(arrived)?.finish()?)
    }

    fn stage(&mut self, arrived: Vec<Response>) -> Result<Upload, SceneError> {
        let mut upload = Upload::new(&self.context, UPLOAD_CHUNK);
        for response in arrived {
            match response {
                Response::Patch(loaded) => self.stage_patch(*loaded, &mut upload)?,
                Response::Horizon(id, relief) => {
                    let Some(patch) = self.resident.get_mut(&id) else { continue };
                    let Some(layer) = patch.layer else { continue };
                    patch.sun = relief.sun;
                    self.textures.upload_relief(&mut upload, layer, &relief)?;
                }
            }
        }
        Ok(upload)
    }

    fn stage_patch(&mut self, loaded: Loaded, upload: &mut Upload) -> Result<(), SceneError> {
        let id = loaded.patch.mesh.id;
        if self.resident.contains_key(&id) {
            return Ok(());
        }
        self.tree.insert(loaded.patch.mesh.id, &loaded.patch.mesh.facts);
        if self.resident.len() >= self.capacity && !self.evict() {
            self.full_at = Some(self.frame);
            return Ok(());
        }
        let layer = loaded.texture.as_ref().and_then(|_| self.textures.claim());
        let mut patch = ResidentPatch::new(&self.context, upload, &loaded.patch, layer, self.frame)?;
        if let (Some(layer), Some(mips), Some(relief)) = (layer, &loaded.texture, &loaded.relief) {
            self.textures.upload(upload, layer, mips)?;
            self.textures.upload_relief(upload, layer, relief)?;
            patch.sun = relief.sun;
        }
        self.resident.insert(id, patch);
        self.ground.known.insert(loaded.grid);
        Ok(())
    }

    /// Frees the least recently used patch that no resident child stands on and the latest frame did not use.
    fn evict(&mut self) -> bool {
        let has_children = |id: PatchId| id.children().into_iter().flatten().any(|c| self.resident.contains_key(&c));
        let idle = self.resident.iter().filter(|(id, p)| id.level > 0 && p.last_used + 1 < self.frame && !has_children(**id));
        let Some(oldest) = idle.min_by_key(|(id, p)| (p.last_used, **id)).map(|(id, _)| *id) else { return false };
        self.ground.known.remove(oldest);
        self.tree.forget(oldest);
        if let Some(layer) = self.resident.remove(&oldest).and_then(|p| p.layer) {
            self.textures.release(layer);
        }
        true
    }
}
