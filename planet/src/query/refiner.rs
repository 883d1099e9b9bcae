//! Makes ground known to a wanted spacing, in the background.
//!
//! In: directions and spacings. Out: finer patches in a shared [`KnownGround`], coarse ones first, so that answers improve step by
//! step. Only heights are sampled, some 2 ms a patch; a request whose handle is dropped is dropped too.

use super::known_ground::KnownGround;
use super::patch_grid::PatchGrid;
use crate::globe::patch::PatchId;
use crate::planet::Planet;
use glam::DVec3;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

/// A background thread that samples patches.
pub struct Refiner {
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

/// A request; dropping it takes it back.
pub struct Refinement {
    request: Arc<Request>,
    shared: Arc<Shared>,
}

struct Request {
    direction: DVec3,
    level: u8,
}

#[derive(Default)]
struct Queue {
    waiting: VecDeque<Weak<Request>>,
    closed: bool,
}

struct Shared {
    planet: Arc<Planet>,
    known: Arc<RwLock<KnownGround>>,
    queue: Mutex<Queue>,
    /// Requests came, ground became known, or the end is near.
    changed: Condvar,
}

impl Refiner {
    /// Starts a thread that refines `known`, the ground of `planet`. Whoever fills it forgets patches again: it does not.
    pub fn new(planet: Arc<Planet>, known: Arc<RwLock<KnownGround>>) -> Refiner {
        let shared = Arc::new(Shared { planet, known, queue: Mutex::default(), changed: Condvar::new() });
        let worker = Worker { shared: shared.clone() };
        Refiner { shared, worker: Some(std::thread::spawn(move || worker.run())) }
    }

    /// Asks for ground in a direction (of any length but zero) whose samples are at most `spacing` metres apart, or as near as patches
    /// get. Requests are served in turn.
    pub fn refine(&self, direction: DVec3, spacing: f64) -> Refinement {
        let level = self.shared.planet.level_of_spacing(spacing);
        let request = Arc::new(Request { direction: direction.normalize_or(DVec3::X), level });
        self.shared.lock().waiting.push_back(Arc::downgrade(&request));
        self.shared.changed.notify_all();
        Refinement { request, shared: self.shared.clone() }
    }
}

impl Drop for Refiner {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.changed.notify_all();
        // A worker that panicked has nothing left to clean up.
        let _ = self.worker.take().map(JoinHandle::join);
    }
}

impl Refinement {
    /// Whether the ground is known as finely as was asked.
    pub fn is_done(&self) -> bool {
        self.shared.next_patches(&self.request).is_none()
    }

    /// Waits until it is, at most for `limit`. Returns whether it is.
    pub fn wait(&self, limit: Duration) -> bool {
        let queue = self.shared.lock();
        let unfinished = |queue: &mut Queue| !queue.closed && !self.is_done();
        drop(self.shared.changed.wait_timeout_while(queue, limit, unfinished).unwrap_or_else(PoisonError::into_inner));
        self.is_done()
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The patches to sample next for a request: a whole face, or four siblings. None once it is done.
    fn next_patches(&self, request: &Request) -> Option<Vec<PatchId>> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let leaf = known.leaf(request.direction, request.level);
        if !known.contains(leaf) {
            return Some(vec![leaf]);
        }
        let children = leaf.children().filter(|_| leaf.level < request.level)?;
        Some(children.into_iter().filter(|&child| !known.contains(child)).collect())
    }

    /// Waits for the next request; `None` at the end.
    fn next_request(&self) -> Option<Weak<Request>> {
        let mut queue = self.lock();
        while !queue.closed {
            if let Some(request) = queue.waiting.pop_front() {
                return Some(request);
            }
            queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        None
    }
}

struct Worker {
    shared: Arc<Shared>,
}

impl Worker {
    fn run(self) {
        while let Some(wanted) = self.shared.next_request() {
            while let Some(request) = wanted.upgrade() {
                if self.shared.lock().closed || !self.step(&request) {
                    break;
                }
            }
        }
    }

    /// Makes the next patches of a request known; false if there are none, or none that the ground takes.
    fn step(&self, request: &Request) -> bool {
        let Some(patches) = self.shared.next_patches(request) else { return false };
        let ground = self.shared.planet.ground();
        let grids: Vec<PatchGrid> = patches.into_iter().map(|id| PatchGrid::sample(&ground, id)).collect();
        let mut known = self.shared.known.write().unwrap_or_else(PoisonError::into_inner);
        let taken = grids.into_iter().all(|grid| known.insert(grid));
        drop(known);
        // Under the lock, so that nobody misses it between looking and waiting.
        let _queue = self.shared.lock();
        self.shared.changed.notify_all();
        taken
    }
}
