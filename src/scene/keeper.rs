//! Keeps patches that were built while flying: one thread that writes them into the planet file or, where that cannot be written, into a
//! cache file of the same kind elsewhere. Nothing waits for it: what it cannot take at once is built again another time.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{sync_channel, Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::maps::clouds::{CloudLevel, CLOUD_SIDE};
use terrane_planet::store::surroundings::SurroundingsRecord;
use terrane_planet::store::{BakedPatch, PlanetFile, PlanetHeader, StoreError};

/// Patches, or heights around patches, waiting to be written, of some 100 kB each.
const WAITING: usize = 192;

/// Patches a transaction.
const BATCH: usize = 16;

/// Longest time between two transactions while patches arrive.
const BATCH_TIME: Duration = Duration::from_secs(2);

/// Where and how much to keep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheOptions {
    /// Most bytes of patches; those unused for longest go first.
    pub bytes: u64,
    /// Folder for cache files of planet files that cannot be written.
    pub side: Option<PathBuf>,
}

enum Note {
    Built(Box<BakedPatch>),
    Around(SurroundingsRecord),
    Clouds(CloudLevel),
    Used(PatchId),
}

/// Hands patches to the keeper.
#[derive(Clone)]
pub(super) struct KeeperHandle(SyncSender<Note>);

impl KeeperHandle {
    /// A patch was built.
    pub(super) fn built(&self, patch: BakedPatch) {
        // A full queue or a keeper that gave up: the patch is not kept, that is all.
        let _ = self.0.try_send(Note::Built(Box::new(patch)));
    }

    /// The surroundings of a patch were sampled.
    pub(super) fn sampled(&self, record: SurroundingsRecord) {
        let _ = self.0.try_send(Note::Around(record));
    }

    /// The map of the planet's clouds was computed.
    pub(super) fn computed(&self, clouds: CloudLevel) {
        let _ = self.0.try_send(Note::Clouds(clouds));
    }

    /// A stored patch was used.
    pub(super) fn used(&self, id: PatchId) {
        let _ = self.0.try_send(Note::Used(id));
    }
}

/// The thread. Ends, with everything written, once it and all its handles are dropped.
pub(super) struct Keeper {
    handle: Option<KeeperHandle>,
    /// The file it writes to, if that is not the planet file.
    pub(super) side: Option<PathBuf>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    /// Starts a keeper for a planet file; `None` if there is nowhere to keep anything, which is logged.
    pub(super) fn start(path: &Path, header: &PlanetHeader, options: &CacheOptions) -> Option<Keeper> {
        let (file, side) = match writable(path, header) {
            Ok(file) => (file, None),
            Err(refused) => {
                let side = options.side.as_ref().map(|folder| folder.join(header.file_name()));
                let opened = side.as_ref().map(|side| {
                    if let Some(folder) = side.parent() {
                        // If this fails, so does what follows, with a better message.
                        let _ = std::fs::create_dir_all(folder);
                    }
                    writable(side, header)
                });
                match opened {
                    Some(Ok(file)) => (file, side),
                    Some(Err(error)) => {
                        tracing::warn!(%refused, %error, "patches built while flying are not kept");
                        return None;
                    }
                    None => {
                        tracing::warn!(%refused, "patches built while flying are not kept");
                        return None;
                    }
                }
            }
        };
        let (sender, notes) = sync_channel(WAITING);
        let budget = options.bytes;
        let thread = std::thread::spawn(move || keep(file, &notes, budget));
        Some(Keeper { handle: Some(KeeperHandle(sender)), side, thread: Some(thread) })
    }

    /// A handle for a worker.
    pub(super) fn handle(&self) -> Option<KeeperHandle> {
        self.handle.clone()
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.handle = None;
        if let Some(thread) = self.thread.take() {
            // A keeper that panicked has nothing left to write.
            let _ = thread.join();
        }
    }
}

/// Opens a file that can really be written: SQLite opens others too, and refuses only the first change.
fn writable(path: &Path, header: &PlanetHeader) -> Result<PlanetFile, StoreError> {
    let mut file = PlanetFile::create_or_resume(path, header)?;
    file.cache(&[], &[], &[], 0, u64::MAX)?;
    Ok(file)
}

fn keep(mut file: PlanetFile, notes: &Receiver<Note>, budget: u64) {
    let (mut built, mut around, mut used) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        let note = notes.recv_timeout(BATCH_TIME);
        let ended = matches!(note, Err(RecvTimeoutError::Disconnected));
        let idle = note.is_err();
        match note {
            Ok(Note::Built(patch)) => built.push(*patch),
            Ok(Note::Around(record)) => around.push(record),
            Ok(Note::Used(id)) => used.push(id),
            Ok(Note::Clouds(map)) => {
                if let Err(error) = file.keep_cloud_map(&map, CLOUD_SIDE) {
                    tracing::warn!(%error, "the map of clouds is not kept");
                }
            }
            Err(_) => {}
        }
        let full = built.len() >= BATCH || around.len() >= 4 * BATCH || used.len() >= 64 * BATCH;
        if (full || idle) && !(built.is_empty() && around.is_empty() && used.is_empty()) {
            let _span = tracing::debug_span!("keep", meshes = built.len()).entered();
            let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() as i64);
            if let Err(error) = file.cache(&built, &around, &used, now, budget) {
                // What is built from now on is of another ground, and has a keeper of its own.
                if matches!(error, StoreError::Changed { .. }) {
                    tracing::debug!(%error, "patches of the ground before are not kept");
                    return;
                }
                // A full disk or a lock held for long: the flight goes on without a cache.
                tracing::warn!(%error, "patches built while flying are no longer kept");
                return;
            }
            built.clear();
            around.clear();
            used.clear();
        }
        if ended {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::planet::Planet;
    use terrane_planet::recipe::Recipe;

    #[test]
    fn patches_of_a_file_that_cannot_be_written_are_kept_beside_it() {
        let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("planet/recipes/tiny.toml");
        let planet = Planet::from_recipe(Recipe::load(&recipe).expect("a shipped recipe"), 16).expect("a shipped recipe");
        let folder = tempfile::tempdir().expect("a folder");
        let side = folder.path().join("cache");
        let options = CacheOptions { bytes: u64::MAX, side: Some(side) };
        let nowhere = folder.path().join("not there/a.planet");
        let keeper = Keeper::start(&nowhere, &planet.header(), &options).expect("a cache file beside it");
        let id = PatchId::roots().next().expect("six roots");
        let (mesh, texture, _) = planet.build(id);
        keeper.handle().expect("a handle").built(BakedPatch::new(&mesh, &texture).expect("a sound patch"));
        let side = keeper.side.clone().expect("a cache file");
        drop(keeper);
        assert!(PlanetFile::open(&side).and_then(|file| file.mesh(id)).is_ok_and(|kept| kept == mesh));
        assert!(Keeper::start(&nowhere, &planet.header(), &CacheOptions { side: None, ..options }).is_none());
    }
}
