//! The scene: which patches of a planet are on the GPU. Nothing here blocks a frame: patches are read, or built where no file holds
//! them, by background workers, uploaded under a budget, and a patch splits only when all that replaces it in sight is there.
//!
//! In: a planet file and a view. Out: the cut, and the resident patches that it draws.

mod clouds;
mod drawn_ground;
mod edit_worker;
mod edits;
mod intake;
mod keeper;
mod loader;
mod options;
mod renewal;
mod resident;
mod source;
mod stock;
mod supply;
mod textures;
mod wants;

pub use clouds::CloudMaps;
pub use drawn_ground::DrawnGround;
pub use edits::{EditRequest, EditState, EditStatus};
pub use keeper::CacheOptions;
pub use options::{uploads_within, OnDemand, SceneOptions, Scope};
pub use resident::{ResidentMesh, ResidentPatch};
pub use textures::TexturePool;

use crate::vulkan::{Commands, Context, VulkanError};
use clouds::LateClouds;
use edits::Edits;
use glam::DVec3;
use keeper::Keeper;
use loader::{Loader, Parts, Request};
use options::Budget;
use renewal::Renewal;
use source::{all_records, Sun, Tally};
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;
use supply::Supply;
use terrane_planet::draw::cut::Cut;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::View;
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::globe::patch::{PatchId, MIN_CELLS};
use terrane_planet::ground::surroundings::KnownSurroundings;
use terrane_planet::mesh::progressive::PatchFacts;
use terrane_planet::planet::edits::EditError;
use terrane_planet::planet::{Planet, PlanetError};
use terrane_planet::query::KnownGround;
use terrane_planet::store::slow::Line;
use terrane_planet::store::{PatchRecord, PlanetFile, StoreError};
use thiserror::Error;

/// Longest time to wait for the next patch before looking again.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

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
    /// The edit.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// One edit at a time.
    #[error("an edit of the ground is under way; wait until it is drawn")]
    EditUnderWay,
    /// Nothing was undone.
    #[error("there is no edit to do again; what was undone can be done again until another edit is made")]
    NothingToRedo,
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
    /// Patches sampled, those that were then built included.
    pub surveyed: u64,
    /// Patches built.
    pub built: u64,
    /// Seconds that building took, all threads together.
    pub build_s: f64,
}

/// The textures that a patch is drawn with.
#[derive(Clone, Copy, Debug)]
pub struct PatchTextures {
    /// Whose they are: its own or an ancestor's.
    pub patch: PatchId,
    /// Their slot.
    pub slot: u32,
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
    late_clouds: Option<LateClouds>,
    loader: Loader,
    // Dropped after the loader, whose workers hand it what they built.
    keeper: Option<Keeper>,
    /// What an edit is about to put in place of the ground that is drawn.
    renewal: Option<Renewal>,
    // Dropped after the clouds that are on their way, which an earlier keeper waits for.
    edits: Edits,
    supply: Supply,
    /// Heights around patches, as the workers know them.
    around: Arc<KnownSurroundings>,
    tally: Arc<Tally>,
    sun: Arc<RwLock<Sun>>,
    capacity: usize,
    mesh_bytes: u64,
    most_mesh_bytes: u64,
    has_textures: bool,
    scope: Scope,
    /// Whether it takes time to come by what is stored.
    is_far: bool,
    frame: u64,
    settled: bool,
    /// Whether a patch was turned away since the cut was last chosen, because all resident ones were in use.
    full: bool,
    /// Share of the distances at which patches should split within which they do: 1 as long as all that views want fits.
    share: f64,
}

impl Scene {
    /// Opens a planet file and loads the six whole faces.
    pub fn open(context: &Arc<Context>, path: &Path, options: SceneOptions) -> Result<Scene, SceneError> {
        let file = PlanetFile::open(path)?;
        let line = options.delay.map(Line::new);
        let planet = Arc::new(Planet::from_header(file.header())?);
        // Over a line patches are looked up as they are wanted.
        let looks_up = line.is_some() && options.on_demand.is_some();
        let mut records = if looks_up { Vec::new() } else { file.index()? };
        if let Some(line) = &line {
            line.carry(file.header().bytes() + size_of_val(&*records));
        }
        if options.on_demand.is_none() {
            records.retain(PatchRecord::has_mesh);
        }
        let mut known: HashMap<PatchId, PatchFacts> = HashMap::new();
        if options.on_demand.is_none() {
            // Of a planet that is published all must be known that there is.
            let published = options.published.iter().filter(|published| published.is_of(file.header()));
            published.map(|published| published.index(&|_| ())).try_for_each(|index| index.map(|index| known.extend(index)))?;
        }
        known.extend(records.iter().map(|record| (record.id, record.facts)));
        let missing = PatchId::roots().filter(|root| !known.contains_key(root)).count();
        if missing > 0 && options.on_demand.is_none() {
            return Err(SceneError::NoRoots { file: path.display().to_string(), missing });
        }
        // An edit loads patches beside those that they replace.
        let stored = u32::try_from(2 * known.len()).unwrap_or(u32::MAX);
        let most_patches = if options.on_demand.is_some() { u32::MAX } else { stored };
        let Budget { capacity, mesh_bytes: most_mesh_bytes, under_way } =
            Budget::new(&options, planet.cells, most_patches, context.limits().max_image_array_layers);
        let supply = Supply::new(path, &options, line.clone(), under_way);
        let mut tree = supply.bare_tree(&planet);
        known.iter().for_each(|(id, facts)| tree.insert(*id, facts));
        let keeper = supply.keeper(file.header());
        let side_file = keeper.as_ref().and_then(|keeper| keeper.side.as_ref()).map(|path| PlanetFile::open(path)).transpose()?;
        if let Some(file) = &side_file {
            file.index()?.iter().for_each(|record| tree.insert(record.id, &record.facts));
        }
        let (cells, slots) = if options.textures { (planet.cells, capacity) } else { (MIN_CELLS, 1) };
        let textures = TexturePool::new(context, cells, slots)?;
        let around = Arc::new(KnownSurroundings::default());
        let scope = options.scope;
        let loader = supply.loader(&planet, keeper.as_ref(), &around)?;
        // The workers read the first patches while the clouds are made.
        let published = supply.published(file.header());
        let is_far = line.is_some() || published.is_some();
        let parts = Parts { mesh: true, texture: options.textures && !is_far };
        loader.request(PatchId::roots().map(|id| (id, Request::Load(parts, None), 0.0)).collect());
        let published = published.map(|published| supply.records_of(published, &Arc::default()));
        let files = all_records(file, line.as_ref(), side_file, published);
        let fetch = clouds::fetcher(files, planet.clone(), keeper.as_ref().and_then(Keeper::handle));
        let (map, late_clouds) = match options.textures {
            true if is_far => (None, Some(LateClouds::Waiting(Box::new(fetch)))),
            true => (fetch(), None),
            false => (None, None),
        };
        let clouds = CloudMaps::new(context, planet.recipe.seed, map)?;
        let mut scene = Scene {
            context: context.clone(),
            ground: DrawnGround::new(KnownGround::new(planet.lattice, planet.cells)),
            planet,
            tree,
            resident: HashMap::new(),
            textures,
            clouds,
            late_clouds,
            loader,
            keeper,
            renewal: None,
            edits: Edits::default(),
            around,
            tally: supply.tally.clone(),
            sun: supply.sun.clone(),
            supply,
            capacity: capacity as usize,
            mesh_bytes: 0,
            most_mesh_bytes,
            has_textures: options.textures,
            scope,
            is_far,
            frame: 0,
            settled: false,
            full: false,
            share: 1.0,
        };
        while scene.resident.len() < 6 {
            let arrived = scene.loader.wait(LONGEST_WAIT)?;
            scene.upload(arrived)?;
        }
        // From the first picture on frames go before what is built for the next.
        if scope == Scope::Flight {
            scene.loader.step_back();
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

    /// The mesh of a patch on the GPU.
    pub fn mesh(&self, id: PatchId) -> Option<&ResidentMesh> {
        self.now().mesh(id)
    }

    /// Slot of a patch's textures.
    pub fn slot(&self, id: PatchId) -> Option<u32> {
        self.now().slot(id)
    }

    /// The textures that a view draws a patch with: of the level that is fine enough, or coarser as long as those are not there.
    pub fn textures_of(&self, view: &View, id: PatchId) -> PatchTextures {
        self.now().textures_of(view, id)
    }

    /// Number of patches on the GPU, those included of which only the textures are.
    pub fn resident_count(&self) -> usize {
        self.resident.len() + self.renewal.as_ref().map_or(0, |renewal| renewal.fresh.len())
    }

    /// The ground of the resident patches.
    pub fn ground(&self) -> &DrawnGround {
        &self.ground
    }

    /// Bytes that the patches on the GPU take, with the whole texture arrays, and the most they may take.
    pub fn gpu_bytes(&self) -> (u64, u64) {
        let (textures, most_textures) = self.textures.bytes();
        (self.mesh_bytes + textures, self.most_mesh_bytes.saturating_add(most_textures))
    }

    /// Bytes of main memory that patches take at most while so many are on the GPU and under way, and the most they may take.
    pub fn host_bytes(&self) -> (u64, u64) {
        let ground = drawn_ground::bytes_of_patch(self.planet.cells, self.scope);
        let under_way = loader::bytes_under_way(self.planet.cells);
        let [now, most] = [(self.resident_count(), self.loader.under_way()), (self.capacity, self.loader.most_under_way)];
        let bytes = |(resident, moving): (usize, usize)| resident as u64 * ground + moving as u64 * under_way;
        (bytes(now), bytes(most))
    }

    /// Patches asked for, and not yet on the GPU; one more while an edit waits to be drawn.
    pub fn pending(&self) -> usize {
        self.loader.pending() + usize::from(self.edits.is_storing() || self.renewal.is_some())
    }

    /// Whether patches have arrived that the next frame may take in, or another ground that it may draw.
    pub fn has_arrived(&self) -> bool {
        self.loader.has_arrived() || self.edits.has_news() || self.renewal.as_ref().is_some_and(Renewal::is_ready)
    }

    /// How the patches were come by.
    pub fn tally(&self) -> SceneTally {
        let Tally { read, surveyed, built, build_us } = &*self.tally;
        let [read, surveyed, built, build_us] = [read, surveyed, built, build_us].map(|n| n.load(Ordering::Relaxed));
        SceneTally { read, surveyed, built, build_s: build_us as f64 * 1e-6 }
    }

    /// Whether a cut of a view is a whole picture, however coarse: all that it draws is on the GPU, textures of some level with it.
    pub fn is_whole(&self, view: &View, cut: &Cut) -> bool {
        cut.leaves.iter().all(|leaf| self.now().is_drawable(view, leaf.id))
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

    /// Computes the cut of a view from what is resident, and asks for what it lacks.
    pub fn choose(&mut self, view: &View) -> Cut {
        let _span = tracing::trace_span!("choose").entered();
        self.keep_within_budget();
        let now = self.now();
        let cut = tracing::trace_span!("cut").in_scope(|| now.cut(view));
        let shown = now.textures_shown(view, &cut);
        self.ground.follow(&cut);
        self.mark_used(&cut, &shown);
        self.settled = false;
        if self.renewal.is_some() {
            self.renew(view, &cut, &shown);
        } else {
            self.ask_for(view, &cut, &shown);
        }
        cut
    }

    /// Asks for what a view lacks beside a cut.
    fn ask_for(&mut self, view: &View, cut: &Cut, shown: &HashSet<PatchId>) {
        let stale = self.stale(shown);
        let complete = cut.wanted.is_empty() && shown.iter().all(|id| self.slot(*id).is_some());
        let is_rest_there = stale.is_empty() && complete;
        if is_rest_there {
            self.late_clouds = self.late_clouds.take().map(LateClouds::start);
        }
        self.settled = is_rest_there && self.late_clouds.is_none() && !self.edits.is_storing();
        let mut orders = self.now().orders(view, cut, shown);
        // Shape before light.
        orders.extend(stale.into_iter().map(|id| (id, Request::Horizon, f64::MAX)));
        if self.scope == Scope::Flight && complete && orders.is_empty() && self.is_roomy() {
            self.look_around(view);
        } else {
            self.loader.request(orders);
        }
        self.forget_unused(cut);
    }

    /// Updates until everything the view wants is resident (or nothing more fits), and returns the final cut.
    pub fn settle(&mut self, view: &View) -> Result<Cut, SceneError> {
        self.settle_showing(view, &mut |_, _| ())
    }

    /// [`Scene::settle`], telling now and then how many patches are on the GPU, and how many more are pending so far.
    pub fn settle_showing(&mut self, view: &View, show: &mut dyn FnMut(usize, usize)) -> Result<Cut, SceneError> {
        (self.full, self.share) = (false, 1.0);
        loop {
            let cut = self.update(view, usize::MAX)?;
            if self.settled {
                if self.is_limited() {
                    tracing::warn!(capacity = self.capacity, "the view wants more patches than fit: the picture is coarser");
                }
                return Ok(cut);
            }
            show(self.resident_count(), self.loader.pending());
            if self.loader.pending() == 0 {
                self.take_edit(LONGEST_WAIT);
                self.take_clouds(LONGEST_WAIT)?;
            }
            let arrived = self.unless_behind(self.loader.wait(LONGEST_WAIT))?;
            self.upload(arrived)?;
        }
    }
}
