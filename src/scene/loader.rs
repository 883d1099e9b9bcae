//! Background workers that read or build patches, most urgent first. Requests that are no longer wanted are dropped.

use super::resident::{bytes_of_patch, ResidentMesh};
use super::source::Source;
use super::textures::{bytes_of_tile, Relief, TextureMips};
use super::SceneError;
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{channel, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::progressive::PatchFacts;
use terrane_planet::query::PatchGrid;
use terrane_planet::store::StoreError;
use thread_priority::ThreadPriority;

/// Least number of workers: reading and decoding alone keeps two busy.
const LEAST_WORKERS: usize = 2;

/// How long arrivals are gathered before the cut is chosen anew.
const MOMENT: Duration = Duration::from_millis(20);

/// Bytes of main memory that a patch under way takes, about: as it is on the GPU, and half as much again while it is read or built.
pub(super) fn bytes_under_way(cells: u32) -> u64 {
    (bytes_of_patch(cells) + bytes_of_tile(cells)) * 3 / 2
}

/// What a worker found out about a patch, and what of it is ready for upload.
pub(super) struct Loaded {
    pub(super) id: PatchId,
    pub(super) facts: Option<PatchFacts>,
    pub(super) mesh: Option<LoadedMesh>,
    pub(super) texture: Option<LoadedTexture>,
    /// The ground of its mesh, or else of its samples, if it was sampled.
    pub(super) grid: Option<PatchGrid>,
}

/// A mesh ready for upload.
pub(super) struct LoadedMesh {
    pub(super) patch: LoadedPatch,
    /// The finest index level that is wanted.
    pub(super) finest: usize,
    /// The view that it is for, if it need not be whole.
    pub(super) view: Option<View>,
}

impl LoadedMesh {
    /// Whether it is of use beside what is on the GPU already.
    pub(super) fn improves(&self, there: &ResidentMesh) -> bool {
        match &self.view {
            Some(view) => !there.suffices(view),
            None => !there.is_whole(),
        }
    }
}

/// Textures ready for upload.
pub(super) struct LoadedTexture {
    pub(super) mips: TextureMips,
    pub(super) relief: Relief,
}

/// What a worker is asked for.
#[derive(Clone, Debug)]
pub(super) enum Request {
    /// To find out what is known of a patch, and to load of it what the view draws.
    Explore(Arc<View>),
    /// Parts of a patch, for a view if there is one; without any only what is known of it.
    Load(Parts, Option<Arc<View>>),
    /// Only its horizon angles and ambient occlusion, for a patch whose textures are on the GPU.
    Horizon,
}

/// Parts of a patch that are loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Parts {
    pub(super) mesh: bool,
    pub(super) texture: bool,
}

/// A patch, what is asked for of it, and how urgent it is (smaller is more urgent).
pub(super) type Order = (PatchId, Request, f64);

/// What a worker answers.
pub(super) enum Response {
    Patch(Box<Loaded>),
    Horizon(PatchId, Relief),
}

type Arrival = (PatchId, Result<Response, StoreError>);

#[derive(Default)]
struct Queue {
    /// Requests that no worker has taken, the most urgent last.
    requests: Vec<Order>,
    /// Taken by a worker, or arrived and not yet fetched.
    under_way: HashSet<PatchId>,
    closed: bool,
}

struct Shared {
    queue: Mutex<Queue>,
    /// Answers that nobody has fetched.
    arrived: AtomicUsize,
    changed: Condvar,
    most_under_way: usize,
    /// Whether frames go before what the workers do.
    steps_back: AtomicBool,
}

/// The workers and their queue.
pub(super) struct Loader {
    shared: Arc<Shared>,
    arrivals: Receiver<Arrival>,
    workers: Vec<std::thread::JoinHandle<()>>,
    stop: Arc<AtomicBool>,
    /// Most patches that workers have taken and nobody has fetched: past it they wait.
    pub(super) most_under_way: usize,
}

impl Loader {
    /// Starts the workers, one a processor or `in_flight` if that is more, each with a source of its own. `stop` is raised when what they
    /// wait for is no longer wanted.
    pub(super) fn new(
        most_under_way: usize,
        in_flight: usize,
        stop: Arc<AtomicBool>,
        source: impl Fn() -> Result<Source, StoreError>,
    ) -> Result<Loader, StoreError> {
        let shared = Arc::new(Shared {
            queue: Mutex::default(),
            arrived: AtomicUsize::new(0),
            changed: Condvar::new(),
            most_under_way,
            steps_back: AtomicBool::new(false),
        });
        let (sender, arrivals) = channel();
        let least = in_flight.max(LEAST_WORKERS);
        let count = std::thread::available_parallelism().map_or(least, usize::from).max(least);
        let mut workers = Vec::new();
        for _ in 0..count {
            let worker = Worker { source: source()?, shared: shared.clone(), sender: sender.clone() };
            workers.push(std::thread::spawn(move || worker.run()));
        }
        Ok(Loader { shared, arrivals, workers, stop, most_under_way })
    }

    /// Lets frames go first from now on.
    pub(super) fn step_back(&self) {
        self.shared.steps_back.store(true, Ordering::Relaxed);
    }

    /// Replaces the requests (each with its urgency, smaller is more urgent).
    pub(super) fn request(&self, mut requests: Vec<Order>) {
        let mut queue = self.shared.lock();
        requests.sort_unstable_by(|a, b| b.2.total_cmp(&a.2).then(b.0.cmp(&a.0)));
        requests.dedup_by_key(|request| request.0);
        requests.retain(|request| !queue.under_way.contains(&request.0));
        queue.requests = requests;
        self.shared.changed.notify_all();
    }

    /// Whether there is anything to take.
    pub(super) fn has_arrived(&self) -> bool {
        self.shared.arrived.load(Ordering::Relaxed) > 0
    }

    /// Up to `most` patches that have arrived, without waiting.
    pub(super) fn take(&self, most: usize) -> Result<Vec<Response>, SceneError> {
        self.arrivals.try_iter().take(most).map(|arrival| self.accept(arrival)).collect()
    }

    /// Waits until something arrives and returns all that has, and what arrives while the workers have enough to do for a moment more;
    /// nothing after `limit`, or if nothing is under way.
    pub(super) fn wait(&self, limit: Duration) -> Result<Vec<Response>, SceneError> {
        let idle = {
            let queue = self.shared.lock();
            queue.requests.is_empty() && queue.under_way.is_empty()
        };
        if idle {
            return Ok(Vec::new());
        }
        match self.arrivals.recv_timeout(limit) {
            Ok(first) => {
                let mut loaded = vec![self.accept(first)?];
                let end = Instant::now() + MOMENT;
                while self.queued() > self.workers.len() {
                    let Ok(next) = self.arrivals.recv_timeout(end.saturating_duration_since(Instant::now())) else { break };
                    loaded.push(self.accept(next)?);
                }
                loaded.extend(self.take(usize::MAX)?);
                Ok(loaded)
            }
            Err(RecvTimeoutError::Timeout) => Ok(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => Err(SceneError::LoaderStopped),
        }
    }

    /// Requests that no worker has taken.
    fn queued(&self) -> usize {
        self.shared.lock().requests.len()
    }

    /// Patches that workers have taken and nobody has fetched.
    pub(super) fn under_way(&self) -> usize {
        self.shared.lock().under_way.len()
    }

    /// Patches that are asked for or under way.
    pub(super) fn pending(&self) -> usize {
        let queue = self.shared.lock();
        queue.requests.len() + queue.under_way.len()
    }

    fn accept(&self, (id, result): Arrival) -> Result<Response, SceneError> {
        self.shared.arrived.fetch_sub(1, Ordering::Relaxed);
        self.shared.lock().under_way.remove(&id);
        self.shared.changed.notify_one();
        Ok(result?)
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.stop.store(true, Ordering::Relaxed);
        self.shared.changed.notify_all();
        for worker in self.workers.drain(..) {
            // A worker that panicked has nothing left to clean up.
            let _ = worker.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> std::sync::MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next patch to load; `None` when the loader is gone.
    fn next(&self) -> Option<(PatchId, Request)> {
        let mut queue = self.lock();
        loop {
            if queue.closed {
                return None;
            }
            if queue.under_way.len() < self.most_under_way {
                if let Some((id, request, _)) = queue.requests.pop() {
                    queue.under_way.insert(id);
                    return Some((id, request));
                }
            }
            queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Lets frames go before what this thread does, where a software renderer draws them on the same processors: the lowest priority still
/// runs in the gaps that every frame leaves. Without effect where the system does not allow it.
pub(super) fn step_back() {
    if let Err(error) = ThreadPriority::Min.set_for_current() {
        tracing::debug!("workers keep their priority: {error:?}");
    }
}

struct Worker {
    source: Source,
    shared: Arc<Shared>,
    sender: Sender<Arrival>,
}

impl Worker {
    fn run(self) {
        let mut stepped_back = false;
        while let Some((id, request)) = self.shared.next() {
            if !stepped_back && self.shared.steps_back.load(Ordering::Relaxed) {
                step_back();
                stepped_back = true;
            }
            let response = match request {
                Request::Explore(view) => self.source.explore(id, &view).map(|loaded| Response::Patch(Box::new(loaded))),
                Request::Load(parts, view) => {
                    self.source.load(id, parts, view.as_deref()).map(|loaded| Response::Patch(Box::new(loaded)))
                }
                Request::Horizon => Ok(Response::Horizon(id, self.source.relief(id))),
            };
            self.shared.arrived.fetch_add(1, Ordering::Relaxed);
            if self.sender.send((id, response)).is_err() {
                return;
            }
        }
    }
}
