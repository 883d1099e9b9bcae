//! Baking: which patches a planet file is to hold, and building them on all cores.
//!
//! In: terrain, a [`BakePlan`] and an open file. Out: the file with every patch of the plan. Workers build and encode; the
//! calling thread alone writes, in transactions of a few tens of patches. At most a few patches a worker wait in between.

use crate::ground::{Elevation, Ground, GroundColour, HeightGrid};
use crate::patch::{PatchId, Side, MAX_LEVEL};
use crate::progressive::PatchMesh;
use crate::simplify::builder::Faults;
use crate::store::{BakedPatch, PlanetFile, RecordError, StoreError};
use crate::texture::PatchTexture;
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};
use thiserror::Error;

/// How far beyond a region, in patch sizes of the level above, patches are still refined. A viewer inside the region splits
/// patches that are nearer than about one and a half of their sizes at the default tolerance; beyond that they are not drawn.
pub const FUNNEL: f64 = 1.5;

/// Most patches in a plan; more would take weeks and terabytes.
pub const MOST_PATCHES: usize = 4_000_000;

/// Patches a transaction. A kill loses at most so many, or what [`BATCH_TIME`] built.
const BATCH_PATCHES: usize = 32;

/// Longest time between two transactions while patches arrive.
const BATCH_TIME: Duration = Duration::from_secs(5);

/// Part of a planet that is baked finer than the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Unit direction of the centre.
    pub direction: DVec3,
    /// Radius along the ground, in metres.
    pub radius_m: f64,
    /// Finest level inside.
    pub to_level: u8,
}

/// A plan that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlanError {
    /// A level past the deepest.
    #[error("level {found} is too deep, expected at most {MAX_LEVEL}")]
    TooDeep {
        /// Level asked for.
        found: u8,
    },
    /// A region whose finest level is not below that of the whole planet.
    #[error(
        "the region's level {found} is not finer than the planet's level {levels}; ask for a deeper one or leave the region out"
    )]
    RegionNotFiner {
        /// Level of the region.
        found: u8,
        /// Level of the whole planet.
        levels: u8,
    },
    /// A centre or radius that is no place.
    #[error("a region of {found} m about {direction}, expected a finite radius of 0 or more about a unit direction")]
    NoPlace {
        /// Radius asked for.
        found: f64,
        /// Direction asked for.
        direction: DVec3,
    },
    /// More patches than can be baked.
    #[error("more than {MOST_PATCHES} patches; ask for fewer levels or a smaller region")]
    TooMany,
}

/// The patches to bake, coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct BakePlan {
    /// Ids by level, then face, row and column.
    pub patches: Vec<PatchId>,
    /// The region, if one is finer.
    pub region: Option<Region>,
}

impl BakePlan {
    /// All patches of levels 0 to `levels`, and inside a region down to its level, 2:1 balanced across patch edges. `radius_m` is
    /// the planet's.
    ///
    /// # Errors
    /// For levels too deep, regions that are no place or not finer, and more than [`MOST_PATCHES`] patches.
    pub fn new(radius_m: f64, levels: u8, region: Option<Region>) -> Result<BakePlan, PlanError> {
        let deepest = region.map_or(levels, |r| r.to_level);
        if levels.max(deepest) > MAX_LEVEL {
            return Err(PlanError::TooDeep { found: levels.max(deepest) });
        }
        if whole_planet(levels) > MOST_PATCHES as u64 {
            return Err(PlanError::TooMany);
        }
        let mut wanted: Vec<BTreeSet<PatchId>> = vec![PatchId::roots().collect()];
        for level in 1..=levels {
            let children = wanted[usize::from(level) - 1].iter().filter_map(|id| id.children()).flatten().collect();
            wanted.push(children);
        }
        if let Some(region) = region {
            check_region(&region, levels)?;
            for level in levels + 1..=region.to_level {
                let parents = wanted[usize::from(level) - 1].iter().filter(|&&id| in_funnel(id, &region, radius_m));
                wanted.push(parents.filter_map(|id| id.children()).flatten().collect());
                if wanted.iter().map(BTreeSet::len).sum::<usize>() > MOST_PATCHES {
                    return Err(PlanError::TooMany);
                }
            }
            for level in (levels + 1..=region.to_level).rev() {
                balance(&mut wanted, usize::from(level));
            }
        }
        let mut patches: Vec<PatchId> = wanted.into_iter().flatten().collect();
        patches.sort_by_key(|id| (id.level, id.face, id.y, id.x));
        Ok(BakePlan { patches, region })
    }
}

/// Patches of levels 0 to `levels` of a whole planet.
pub fn whole_planet(levels: u8) -> u64 {
    (0..=levels.min(MAX_LEVEL)).map(|level| 6 << (2 * level)).sum()
}

fn check_region(region: &Region, levels: u8) -> Result<(), PlanError> {
    if region.to_level <= levels {
        return Err(PlanError::RegionNotFiner { found: region.to_level, levels });
    }
    let unit = (region.direction.length() - 1.0).abs() < 1e-6;
    if unit && region.radius_m >= 0.0 && region.radius_m.is_finite() {
        Ok(())
    } else {
        Err(PlanError::NoPlace { found: region.radius_m, direction: region.direction })
    }
}

/// Whether the children of a patch belong to a region: its nearest point, about, lies within the region's radius and funnel.
fn in_funnel(id: PatchId, region: &Region, radius_m: f64) -> bool {
    let centre = id.centre();
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| crate::sphere::direction(id.point(a, b, 1)));
    let half_diagonal = corners.iter().map(|c| c.angle_between(centre)).fold(0.0, f64::max);
    let size = std::f64::consts::FRAC_PI_2 / f64::from(1u32 << id.level);
    let nearest = region.direction.angle_between(centre) - half_diagonal;
    nearest * radius_m <= region.radius_m + FUNNEL * size * radius_m
}

/// Adds to the level above what the patches of `level` need: their parents' four neighbours, always with all siblings.
fn balance(wanted: &mut [BTreeSet<PatchId>], level: usize) {
    let parents: BTreeSet<PatchId> = wanted[level].iter().filter_map(|id| id.parent()).collect();
    for parent in parents {
        for needed in Side::ALL.map(|side| parent.neighbour(side)).into_iter().chain([parent]) {
            match needed.parent().and_then(PatchId::children) {
                Some(siblings) => wanted[level - 1].extend(siblings),
                None => wanted[level - 1].extend([needed]),
            }
        }
    }
}

/// How far a bake has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Patches built so far.
    pub built: usize,
    /// Patches to build: those of the plan that the file did not hold.
    pub total: usize,
    /// Patches that the file held already.
    pub skipped: usize,
    /// Vertices built so far.
    pub vertices: u64,
    /// Since the start.
    pub elapsed: Duration,
}

/// What a bake did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeSummary {
    /// Patches in the plan.
    pub planned: usize,
    /// Patches built and stored.
    pub built: usize,
    /// Patches that the file held already.
    pub skipped: usize,
    /// Vertices built.
    pub vertices: u64,
    /// Time it took.
    pub elapsed: Duration,
    /// Bytes of the geometry records built.
    pub geometry_bytes: u64,
    /// Bytes of the texture records built.
    pub texture_bytes: u64,
    /// Vertices built that never sleep.
    pub always_awake: u64,
    /// What went wrong in building; all zero unless there is a bug.
    pub faults: Faults,
    /// Whether it was stopped before the end.
    pub interrupted: bool,
}

impl BakeSummary {
    /// Vertices built a second; 0 if none were.
    pub fn vertices_per_second(&self) -> f64 {
        self.vertices as f64 / self.elapsed.as_secs_f64().max(1e-9)
    }

    /// Geometry bytes a vertex; 0 if none were built.
    pub fn bytes_per_vertex(&self) -> f64 {
        self.geometry_bytes as f64 / self.vertices.max(1) as f64
    }

    fn add(&mut self, patch: &BakedPatch, faults: Faults, vertices: u64) {
        self.built += 1;
        self.vertices += vertices;
        self.geometry_bytes += patch.geometry.len() as u64;
        self.texture_bytes += patch.texture.len() as u64;
        self.always_awake += u64::from(patch.record.always_awake);
        self.faults.stuck_border += faults.stuck_border;
        self.faults.stuck_interior += faults.stuck_interior;
        self.faults.uncertified += faults.uncertified;
    }
}

/// Why a bake failed.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The builder made something that cannot be stored.
    #[error("patch {id} cannot be stored: {source}; this is a bug in the builder, please report it with the recipe")]
    Patch {
        /// The patch.
        id: PatchId,
        /// What is wrong.
        source: RecordError,
    },
}

/// Samples, builds and textures one patch.
pub fn build_patch(ground: &Ground, colour: &dyn GroundColour, id: PatchId) -> (PatchMesh, PatchTexture, Faults) {
    let grid = HeightGrid::sample(ground, id);
    let (mesh, faults) = PatchMesh::build(ground, id, &grid);
    let texture = PatchTexture::new(ground, colour, id, &grid);
    (mesh, texture, faults)
}

type Outcome = Result<(BakedPatch, Faults), BakeError>;

/// Builds every patch of the plan that the file lacks, on `threads` threads (at least one). `progress` is called on the calling
/// thread after every patch. Setting `stop` ends the bake soon; finished patches are kept.
///
/// # Errors
/// If the file cannot be read or written; patches stored before stay.
pub fn bake(
    file: &mut PlanetFile,
    elevation: &dyn Elevation,
    colour: &dyn GroundColour,
    plan: &BakePlan,
    threads: usize,
    progress: &dyn Fn(Progress),
    stop: &AtomicBool,
) -> Result<BakeSummary, BakeError> {
    let start = Instant::now();
    let ground = Ground { elevation, lattice: file.header().lattice, cells: file.header().cells };
    let stored = file.ids()?;
    let missing: Vec<PatchId> = plan.patches.iter().copied().filter(|id| !stored.contains(id)).collect();
    if let Some(region) = &plan.region {
        file.note_region(region)?;
    }
    let skipped = plan.patches.len() - missing.len();
    let mut summary = BakeSummary { planned: plan.patches.len(), skipped, ..BakeSummary::default() };
    let vertices = u64::from(ground.cells + 1).pow(2);
    let next = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let threads = threads.max(1);
    let result = std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel::<Outcome>(2 * threads);
        for _ in 0..threads {
            let sender = sender.clone();
            let (missing, next, failed, ground) = (&missing, &next, &failed, &ground);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
                    let Some(&id) = missing.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                    // The receiver is gone only after a failure to write.
                    if sender.send(build_and_encode(ground, colour, id)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut batch = Vec::with_capacity(BATCH_PATCHES);
        let mut written = Instant::now();
        let outcome = receiver.iter().try_for_each(|outcome| {
            let (patch, faults) = outcome?;
            summary.add(&patch, faults, vertices);
            batch.push(patch);
            if batch.len() >= BATCH_PATCHES || written.elapsed() >= BATCH_TIME {
                file.put(&batch)?;
                batch.clear();
                written = Instant::now();
            }
            let elapsed = start.elapsed();
            progress(Progress { built: summary.built, total: missing.len(), skipped, vertices: summary.vertices, elapsed });
            Ok(())
        });
        failed.store(outcome.is_err(), Ordering::Relaxed);
        // Dropping the receiver lets workers that wait to send go home.
        drop(receiver);
        outcome.and_then(|()| file.put(&batch).map_err(BakeError::from))
    });
    result?;
    summary.elapsed = start.elapsed();
    summary.interrupted = summary.built < missing.len();
    Ok(summary)
}

fn build_and_encode(ground: &Ground, colour: &dyn GroundColour, id: PatchId) -> Outcome {
    let (mesh, texture, faults) = build_patch(ground, colour, id);
    let patch = BakedPatch::new(&mesh, &texture).map_err(|source| BakeError::Patch { id, source })?;
    Ok((patch, faults))
}
