//! Baking: which patches a planet file is to hold, and building them on all cores.
//!
//! In: terrain, a [`BakePlan`] and an open file. Out: the file with every patch of the plan. Workers build and encode; the
//! calling thread alone writes, in transactions of a few tens of patches. At most a few patches a worker wait in between.

mod plan;

pub use plan::{whole_planet, BakePlan, PlanError, FUNNEL, MOST_PATCHES};

use crate::globe::patch::PatchId;
use crate::ground::surroundings::sample_surroundings;
use crate::ground::{Elevation, Ground, GroundColour, KeptHeights};
use crate::mesh::build_patch;
use crate::mesh::builder::Faults;
use crate::store::surroundings::{self, SurroundingsRecord};
use crate::store::{BakedPatch, PlanetFile, RecordError, StoreError};
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Patches a transaction. A kill loses at most so many, or what [`BATCH_TIME`] built.
const BATCH_PATCHES: usize = 32;

/// Longest time between two transactions while patches arrive.
const BATCH_TIME: Duration = Duration::from_secs(5);

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
    /// Patches in the plan, and those that were pending.
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

type Outcome = Result<(BakedPatch, SurroundingsRecord, Faults), BakeError>;

/// Builds every patch of the plan that the file lacks, and those that an edit of the ground has left pending, on `threads` threads (at least one). `progress` is called on the calling
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
    let kept = KeptHeights::new(file.header().cells);
    let ground = Ground { elevation, lattice: file.header().lattice, cells: file.header().cells, kept: Some(&kept) };
    let stored = file.ids()?;
    let mut wanted = file.pending()?;
    let planned: HashSet<PatchId> = plan.patches.iter().copied().collect();
    wanted.retain(|id| !planned.contains(id));
    wanted.extend_from_slice(&plan.patches);
    let missing: Vec<PatchId> = wanted.iter().copied().filter(|id| !stored.contains(id)).collect();
    if let Some(region) = &plan.region {
        file.note_region(region)?;
    }
    let there: Vec<PatchId> = wanted.iter().copied().filter(|id| stored.contains(id)).collect();
    file.keep(&there)?;
    let skipped = there.len();
    let mut summary = BakeSummary { planned: wanted.len(), skipped, ..BakeSummary::default() };
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
        let (mut batch, mut around) = (Vec::with_capacity(BATCH_PATCHES), Vec::with_capacity(BATCH_PATCHES));
        let mut written = Instant::now();
        let outcome = receiver.iter().try_for_each(|outcome| {
            let (patch, surroundings, faults) = outcome?;
            summary.add(&patch, faults, vertices);
            if faults != Faults::default() {
                tracing::warn!(patch = %patch.record.id, ?faults, "the builder broke its own rules");
            }
            batch.push(patch);
            around.push(surroundings);
            if batch.len() >= BATCH_PATCHES || written.elapsed() >= BATCH_TIME {
                file.put_with(&batch, &around)?;
                batch.clear();
                around.clear();
                written = Instant::now();
            }
            let elapsed = start.elapsed();
            progress(Progress { built: summary.built, total: missing.len(), skipped, vertices: summary.vertices, elapsed });
            Ok(())
        });
        failed.store(outcome.is_err(), Ordering::Relaxed);
        // Dropping the receiver lets workers that wait to send go home.
        drop(receiver);
        outcome.and_then(|()| file.put_with(&batch, &around).map_err(BakeError::from))
    });
    result?;
    summary.elapsed = start.elapsed();
    summary.interrupted = summary.built < missing.len();
    Ok(summary)
}

/// Builds a patch for the file.
pub(super) fn build_and_encode(ground: &Ground, colour: &dyn GroundColour, id: PatchId) -> Outcome {
    let (mesh, texture, faults) = build_patch(ground, colour, id);
    let refused = |source| BakeError::Patch { id, source };
    let patch = BakedPatch::new(&mesh, &texture).map_err(refused)?;
    let around = surroundings::encode(&sample_surroundings(ground, id), id, ground.cells).map_err(refused)?;
    Ok((patch, (id, around), faults))
}
