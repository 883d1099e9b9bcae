//! A published planet as a source of records: bytes are asked for as they are wanted, and checked before anybody sees them.

use super::directory::{root_of, Directory, Segment};
use super::manifest::{Manifest, ManifestError, Reference};
use super::name::ObjectName;
use super::objects::{FetchError, Freshness, Objects};
use crate::globe::patch::PatchId;
use crate::mesh::progressive::PatchFacts;
use crate::recipe::Asset;
use crate::store::{geometry, Part, PlanetHeader, Records, StoreError};
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most directories that are remembered, of a few kilobytes each.
const MOST_DIRECTORIES: usize = 20_000;

/// Most bytes of an object that is fetched whole: a recipe, an image of it, a map; and bytes of each request for it.
const MOST_WHOLE: u32 = 1 << 28;
const PIECE: u64 = 1 << 20;

/// How often bytes that are not those that were published are asked for anew.
const TRIES: usize = 3;

/// How long nothing is asked for after a fault: the first time, and at most.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(20);

/// How long a reader that has nothing else waits for bytes that do not come, unless it says otherwise.
const PATIENCE: Duration = Duration::from_secs(60);

/// How often it looks whether it is still wanted.
const MOMENT: Duration = Duration::from_millis(50);

/// What came of a published planet so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fetched {
    /// Bytes of records and directories that were good.
    pub bytes: u64,
    /// Stretches of them.
    pub segments: u64,
    /// Bytes of the whole meshes and textures of which something came.
    pub whole_bytes: u64,
    /// Stretches that were not what was published, and were asked for again.
    pub refused: u64,
    /// Questions without an answer.
    pub failed: u64,
    /// Requests that went over a network, and bytes that came by them.
    pub traffic: (u64, u64),
}

#[derive(Default)]
struct Tally {
    bytes: AtomicU64,
    segments: AtomicU64,
    refused: AtomicU64,
    failed: AtomicU64,
    /// What came in part, and the bytes of all of it.
    whole: Mutex<(HashSet<(PatchId, Part)>, u64)>,
}

/// A slot for a directory: locked while it is fetched, so that it is fetched once.
type Slot = Arc<Mutex<Option<Arc<Directory>>>>;

/// A planet that was published, wherever that is.
pub struct PublishedPlanet {
    objects: Box<dyn Objects>,
    manifest: Manifest,
    header: PlanetHeader,
    directories: Mutex<HashMap<PatchId, Slot>>,
    tally: Tally,
    /// Until when nothing is asked for, and how long that was the last time.
    pause: Mutex<Option<(Instant, Duration)>>,
}

impl PublishedPlanet {
    /// Reads what a published planet is: `planet.json`, its recipe and the files that this names.
    ///
    /// # Errors
    /// If they do not come, or are not what was published.
    pub fn open(objects: Box<dyn Objects>) -> Result<PublishedPlanet, StoreError> {
        let file = objects.place().to_owned();
        let failed = |what: &str, reason: String| StoreError::Remote { file: file.clone(), what: what.to_owned(), reason };
        let bytes = objects.manifest().map_err(|error| failed("planet.json", error.to_string()))?;
        let manifest = Manifest::parse(&bytes).map_err(|error: ManifestError| failed("planet.json", error.to_string()))?;
        let header = PlanetHeader {
            name: manifest.name.clone(),
            recipe: String::new(),
            assets: Vec::new(),
            cells: manifest.cells,
            lattice: manifest.lattice(),
            height_range: manifest.height_range_m,
        };
        let mut planet = PublishedPlanet {
            objects,
            manifest,
            header,
            directories: Mutex::default(),
            tally: Tally::default(),
            pause: Mutex::new(None),
        };
        let wait = Otherwise::wait();
        let recipe = planet.whole(planet.manifest.recipe, "its recipe", &wait)?;
        let recipe = String::from_utf8(recipe).map_err(|_| failed("its recipe", "it is not UTF-8".to_owned()))?;
        let assets = planet.manifest.assets.iter().map(|asset| {
            let bytes = planet.whole(asset.reference, &asset.name, &wait)?;
            Ok(Asset { name: asset.name.clone(), bytes })
        });
        let assets = assets.collect::<Result<_, StoreError>>()?;
        (planet.header.recipe, planet.header.assets) = (recipe, assets);
        Ok(planet)
    }

    /// What a planet file of it says.
    pub fn header(&self) -> &PlanetHeader {
        &self.header
    }

    /// Whether it is the planet of a header, with the ground that this has now.
    pub fn is_of(&self, header: &PlanetHeader) -> bool {
        self.header.checksum() == header.checksum()
    }

    /// What its `planet.json` says.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Where it is, for messages.
    pub fn place(&self) -> &Path {
        self.objects.place()
    }

    /// What came of it so far.
    pub fn fetched(&self) -> Fetched {
        let Tally { bytes, segments, refused, failed, whole } = &self.tally;
        let whole_bytes = lock(whole).1;
        let [bytes, segments, refused, failed] = [bytes, segments, refused, failed].map(|n| n.load(Ordering::Relaxed));
        Fetched { bytes, segments, whole_bytes, refused, failed, traffic: self.objects.traffic() }
    }

    /// What is known of all its patches: every directory is read.
    ///
    /// # Errors
    /// If one does not come, or is damaged.
    pub fn index(&self, progress: &dyn Fn(usize)) -> Result<Vec<(PatchId, PatchFacts)>, StoreError> {
        let wait = Otherwise::wait();
        let mut index = Vec::new();
        let mut open: Vec<PatchId> = PatchId::roots().collect();
        while let Some(root) = open.pop() {
            if let Some(directory) = self.patiently(&wait, || self.directory(root, &wait))? {
                let whole = directory.patches.iter().filter(|patch| !patch.geometry.is_empty());
                index.extend(whole.map(|patch| (patch.id, patch.facts)));
                open.extend(directory.below.iter().map(|(root, _)| *root));
                progress(index.len());
            }
        }
        index.sort_by_key(|(id, _)| (id.level, id.face, id.y, id.x));
        Ok(index)
    }

    /// An object as a whole, by pieces.
    fn whole(&self, reference: Reference, what: &str, otherwise: &Otherwise) -> Result<Vec<u8>, StoreError> {
        let Reference { object, bytes } = reference;
        if bytes > MOST_WHOLE {
            let reason = format!("{bytes} bytes, expected at most {MOST_WHOLE}");
            return Err(StoreError::Remote { file: self.place().to_owned(), what: what.to_owned(), reason });
        }
        let pieces: Vec<Range<u64>> =
            (0..u64::from(bytes)).step_by(PIECE as usize).map(|start| start..(start + PIECE).min(u64::from(bytes))).collect();
        let holds = |found: &[u8]| found.len() == bytes as usize && ObjectName::of(found) == object;
        self.patiently(otherwise, || self.checked(object, &pieces, &holds, what, otherwise))
    }

    /// The directory of the shard with this root, if there is one.
    fn directory(&self, root: PatchId, otherwise: &Otherwise) -> Result<Option<Arc<Directory>>, Fault> {
        let slot = {
            let mut directories = lock(&self.directories);
            if directories.len() >= MOST_DIRECTORIES {
                directories.clear();
            }
            directories.entry(root).or_default().clone()
        };
        // Directories above are taken while this one is locked, and none below: nobody waits for whom he keeps waiting. Who builds does not
        // wait at all.
        let mut there = match otherwise {
            Otherwise::Build => slot.try_lock().map_err(|_| Fault::NotNow)?,
            Otherwise::Wait { .. } => lock(&slot),
        };
        if there.is_none() {
            let reference = match root.parent() {
                None => Some(self.manifest.faces[usize::from(root.face.index())]),
                Some(parent) => {
                    let above = self.directory(root_of(parent), otherwise)?;
                    above.and_then(|above| above.towards(root)).map(|(_, reference)| reference)
                }
            };
            let Some(Reference { object, bytes }) = reference else { return Ok(None) };
            let what = format!("the directory of {root}");
            let holds = |found: &[u8]| found.len() == bytes as usize && ObjectName::of(found) == object;
            let all = 0..u64::from(bytes);
            let found = self.checked(object, std::slice::from_ref(&all), &holds, &what, otherwise)?;
            let directory =
                Directory::decode(&found, root).map_err(|reason| Fault::Final(self.error(&what, reason.to_string())))?;
            *there = Some(Arc::new(directory));
        }
        Ok(there.clone())
    }

    /// Bytes of a record, as far as it has them: the segments that hold them.
    fn bytes(&self, id: PatchId, part: Part, range: &Range<usize>, otherwise: &Otherwise) -> Result<Option<Vec<u8>>, Fault> {
        let Some(directory) = self.directory(root_of(id), otherwise)? else { return Ok(None) };
        let segments = directory.patch(id).map_or(&[] as &[Segment], |patch| patch.segments(part));
        if segments.is_empty() {
            return Ok(None);
        }
        let (mut bytes, mut at) = (Vec::new(), 0);
        for (number, segment) in segments.iter().enumerate() {
            let (start, end) = (at, at + segment.length() as usize);
            at = end;
            if end <= range.start || start >= range.end {
                continue;
            }
            let what = format!("segment {} of {} of the {} of patch {id}", number + 1, segments.len(), part.name());
            let stretch = std::slice::from_ref(&segment.data);
            let found = self.checked(directory.data, stretch, &|found| segment.holds(found), &what, otherwise)?;
            // To its end: it was paid for.
            bytes.extend_from_slice(&found[range.start.saturating_sub(start)..]);
        }
        let mut whole = lock(&self.tally.whole);
        if whole.0.insert((id, part)) {
            whole.1 += segments.iter().map(Segment::length).sum::<u64>();
        }
        Ok(Some(bytes))
    }

    /// Stretches of an object that are what was published: those that were kept, or fetched.
    fn checked(
        &self,
        object: ObjectName,
        stretches: &[Range<u64>],
        holds: &dyn Fn(&[u8]) -> bool,
        what: &str,
        otherwise: &Otherwise,
    ) -> Result<Vec<u8>, Fault> {
        let kept: Option<Vec<Vec<u8>>> = stretches.iter().map(|range| self.objects.kept(object, range)).collect();
        if let Some(bytes) = kept.map(|kept| kept.concat()).filter(|bytes| holds(bytes)) {
            self.count(&bytes);
            return Ok(bytes);
        }
        if self.pauses() || (matches!(otherwise, Otherwise::Build) && self.objects.is_busy()) {
            return Err(Fault::NotNow);
        }
        for attempt in 0..TRIES {
            let from = if attempt == 0 { Freshness::Any } else { Freshness::Origin };
            let read = |range: &Range<u64>| self.objects.read(object, range.clone(), from);
            match stretches.iter().map(read).collect::<Result<Vec<Vec<u8>>, FetchError>>() {
                Ok(found) => {
                    let bytes = found.concat();
                    if holds(&bytes) {
                        stretches.iter().zip(&found).for_each(|(range, bytes)| self.objects.keep(object, range, bytes));
                        self.count(&bytes);
                        *lock(&self.pause) = None;
                        return Ok(bytes);
                    }
                    self.tally.refused.fetch_add(1, Ordering::Relaxed);
                    let (place, count, path) = (self.place().display(), bytes.len(), object.path());
                    tracing::warn!(
                        "{place}: {what} ({path}, bytes {stretches:?}): {count} bytes that are not those that were published; asked for again"
                    );
                }
                Err(FetchError::Missing(reason)) => return Err(Fault::Final(self.error(what, reason))),
                Err(FetchError::Unreachable(reason)) => {
                    self.tally.failed.fetch_add(1, Ordering::Relaxed);
                    return Err(Fault::Passing(self.error(what, reason)));
                }
            }
        }
        Err(Fault::Final(
            self.error(what, format!("{} gave {TRIES} times bytes that are not those that were published", object.path())),
        ))
    }

    fn count(&self, bytes: &[u8]) {
        self.tally.segments.fetch_add(1, Ordering::Relaxed);
        self.tally.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
    }

    fn error(&self, what: &str, reason: String) -> StoreError {
        StoreError::Remote { file: self.place().to_owned(), what: what.to_owned(), reason }
    }

    /// Whether nothing is asked for at the moment.
    fn pauses(&self) -> bool {
        lock(&self.pause).is_some_and(|(until, _)| Instant::now() < until)
    }

    /// Asks for nothing for a while; says so, the first time.
    fn pause(&self, error: &StoreError) {
        let mut pause = lock(&self.pause);
        let now = Instant::now();
        if pause.is_some_and(|(until, _)| now < until) {
            return;
        }
        let length = pause.map_or(FIRST_PAUSE, |(_, length)| (2 * length).min(LONGEST_PAUSE));
        if pause.is_none() {
            tracing::warn!("{error}; it is asked for again later");
        }
        *pause = Some((now + length, length));
    }

    /// Asks until an answer comes, patience ends or nobody waits any more. Who builds has no patience.
    fn patiently<T>(&self, otherwise: &Otherwise, mut ask: impl FnMut() -> Result<T, Fault>) -> Result<T, StoreError> {
        let begun = Instant::now();
        let (stop, patience) = match otherwise {
            Otherwise::Build => (None, Duration::ZERO),
            Otherwise::Wait { stop, patience } => (Some(stop), *patience),
        };
        let is_over = || begun.elapsed() >= patience || stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
        loop {
            match ask() {
                Ok(answer) => return Ok(answer),
                Err(Fault::Final(error)) => return Err(error),
                Err(Fault::Passing(error)) if is_over() => return Err(error),
                Err(Fault::Passing(error)) => self.pause(&error),
                Err(Fault::NotNow) if is_over() => return Err(self.error("it", "it could not be reached before".to_owned())),
                Err(Fault::NotNow) => std::thread::sleep(MOMENT),
            }
            while self.pauses() && !is_over() {
                std::thread::sleep(MOMENT);
            }
        }
    }
}

/// Why an answer did not come.
enum Fault {
    /// It may come later.
    Passing(StoreError),
    /// It will not.
    Final(StoreError),
    /// Nobody was asked: after a fault, or because enough is under way.
    NotNow,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl fmt::Debug for PublishedPlanet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PublishedPlanet").field("place", &self.place()).finish_non_exhaustive()
    }
}

/// What a reader does while bytes do not come.
#[derive(Clone, Debug)]
pub enum Otherwise {
    /// It builds: there is nothing for it then, nor while more is asked for than can be on its way.
    Build,
    /// It waits, and goes on when the planet can be reached again.
    Wait {
        /// Raised when it is not wanted any more.
        stop: Arc<AtomicBool>,
        /// How long at most.
        patience: Duration,
    },
}

impl Otherwise {
    /// It waits for a minute.
    pub fn wait() -> Otherwise {
        Otherwise::Wait { stop: Arc::default(), patience: PATIENCE }
    }
}

/// The records of a published planet.
#[derive(Clone, Debug)]
pub struct PublishedRecords {
    planet: Arc<PublishedPlanet>,
    otherwise: Otherwise,
}

impl PublishedRecords {
    /// For a reader.
    pub fn new(planet: Arc<PublishedPlanet>, otherwise: Otherwise) -> PublishedRecords {
        PublishedRecords { planet, otherwise }
    }

    fn ask<T>(&self, ask: impl Fn() -> Result<Option<T>, Fault>) -> Result<Option<T>, StoreError> {
        match &self.otherwise {
            Otherwise::Wait { .. } => self.planet.patiently(&self.otherwise, ask),
            Otherwise::Build => ask().or_else(|fault| {
                match fault {
                    Fault::Passing(error) => self.planet.pause(&error),
                    Fault::Final(error) => tracing::warn!("{error}; it is built"),
                    Fault::NotNow => {}
                }
                Ok(None)
            }),
        }
    }
}

impl Records for PublishedRecords {
    fn path(&self) -> &Path {
        self.planet.place()
    }

    fn cells(&self) -> u32 {
        self.planet.manifest.cells
    }

    fn facts(&self, id: PatchId) -> Result<Option<PatchFacts>, StoreError> {
        self.ask(|| {
            Ok(self
                .planet
                .directory(root_of(id), &self.otherwise)?
                .and_then(|directory| directory.patch(id).map(|patch| patch.facts)))
        })
    }

    fn bytes(&self, id: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError> {
        if part == Part::Surroundings {
            return Ok(None);
        }
        self.ask(|| self.planet.bytes(id, part, &range, &self.otherwise))
    }

    fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError> {
        // They take less time to compute than to fetch.
        let is_built = matches!(self.otherwise, Otherwise::Build);
        let Some(reference) = self.planet.manifest.clouds.filter(|_| !is_built) else { return Ok(None) };
        self.planet.whole(reference, "the map of clouds", &self.otherwise).map(Some)
    }

    fn first_bytes(&self) -> usize {
        // The head: its segment holds the first chunk as well.
        geometry::head_bytes(self.planet.manifest.cells)
    }
}
