//! Edits of the ground while it is drawn. Nothing waits for one: the planet file is changed beside the frames, these go on with the ground of
//! before, and when what takes its place is on the GPU, one frame is the last of the old ground and the next the first of the new.
//!
//! In: an edit, or the wish to take one back. Out: how far it is, and another ground.

use super::edit_worker::{bring_back, Change, Failure, Finishing, Job, NextGround};
use super::keeper::Keeper;
use super::loader::Loader;
use super::supply::Supply;
use super::{Scene, SceneError};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{channel, Receiver, RecvTimeoutError, TryRecvError};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use terrane_planet::planet::edits::EditError;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Edit;
use terrane_planet::store::{PlanetFile, StoreError};

/// What is to become of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditRequest {
    /// An edit more, at the end of the planet's recipe. What was undone before can no longer be done again.
    Apply(Edit),
    /// Without the last edit.
    Undo,
    /// With the edit again that was undone last.
    Redo,
}

/// How far an edit is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EditState {
    /// There is none under way: what is drawn is the planet file's ground.
    Idle,
    /// The planet file is being changed.
    Storing,
    /// The file is changed, and its new ground being loaded: so many patches of as many as the picture needs are there.
    Loading {
        /// Patches that are there.
        there: usize,
        /// Patches that are needed.
        needed: usize,
    },
    /// The ground is drawn. What the file is to hold of it comes back beside everything else; another edit need not wait for this.
    Finishing {
        /// Patches built.
        built: usize,
        /// Patches to build.
        total: usize,
    },
    /// The latest one failed.
    Failed {
        /// Why, and what to do.
        message: String,
    },
}

/// The edits of a scene's ground.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EditStatus {
    /// How far the latest one is.
    pub state: EditState,
    /// Edits that can be undone, one after the other.
    pub undoable: usize,
    /// Edits that were undone and can be done again.
    pub redoable: usize,
    /// Time from the latest request to the frame that drew it.
    pub latest: Option<Duration>,
}

impl EditStatus {
    /// Whether another edit has to wait.
    pub fn is_busy(&self) -> bool {
        matches!(self.state, EditState::Storing | EditState::Loading { .. })
    }
}

/// A change of the file that is under way.
struct Storing {
    request: EditRequest,
    news: Receiver<Result<NextGround, Failure>>,
    has_news: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

/// The building of what the file is to hold.
struct Finisher {
    file: PathBuf,
    progress: Arc<Finishing>,
    news: Receiver<Result<(), EditError>>,
    thread: JoinHandle<()>,
}

/// What is under way of edits, and what was undone.
#[derive(Default)]
pub(super) struct Edits {
    storing: Option<Storing>,
    finisher: Option<Finisher>,
    stop: Arc<AtomicBool>,
    undone: Vec<Edit>,
    failed: Option<String>,
    /// The file's ground is another than what is drawn, and is not going to be drawn.
    is_left_behind: bool,
    /// Whether edits of other programs are borne, and whether there was one.
    bears_others: bool,
    is_overtaken: bool,
    begun: Option<Instant>,
    latest: Option<Duration>,
    /// Threads that end by themselves soon.
    retired: Vec<JoinHandle<()>>,
}

impl Edits {
    /// Whether the file may be of another ground than what is drawn.
    pub(super) fn may_be_ahead(&self) -> bool {
        self.storing.is_some() || self.is_left_behind
    }

    /// Whether a file is being changed.
    pub(super) fn is_storing(&self) -> bool {
        self.storing.is_some()
    }

    /// Whether there is something to take in.
    pub(super) fn has_news(&self) -> bool {
        self.storing.as_ref().is_some_and(|storing| storing.has_news.load(Ordering::Relaxed))
    }

    /// Lets the workers of before end without waiting for them.
    pub(super) fn retire(&mut self, before: (Loader, Option<Keeper>)) {
        self.retired.retain(|thread| !thread.is_finished());
        self.retired.push(std::thread::spawn(move || drop(before)));
    }

    /// Notes that the ground of the latest request is drawn, and begins to bring back what the file is to hold.
    pub(super) fn is_drawn(&mut self, supply: &Supply, planet: &Arc<Planet>) {
        self.latest = self.begun.take().map(|begun| begun.elapsed());
        if !supply.builds() {
            return;
        }
        let (sender, news) = channel();
        let progress = Arc::new(Finishing::default());
        let (file, path) = (supply.path.clone(), supply.path.clone());
        let (scope, planet) = (supply.options.scope, planet.clone());
        let (stop, shown) = (self.stop.clone(), progress.clone());
        let thread = std::thread::spawn(move || drop(sender.send(bring_back(&path, &planet, scope, &shown, &stop))));
        self.finisher = Some(Finisher { file, progress, news, thread });
    }

    fn state(&self) -> EditState {
        match (&self.storing, &self.failed, &self.finisher) {
            (Some(_), ..) => EditState::Storing,
            (_, Some(message), _) => EditState::Failed { message: message.clone() },
            (.., Some(Finisher { progress, .. })) => {
                let [built, total] = [&progress.built, &progress.total].map(|n| n.load(Ordering::Relaxed));
                EditState::Finishing { built, total }
            }
            _ => EditState::Idle,
        }
    }

    /// Takes in what became of the patches that the file is to get back.
    fn take_finished(&mut self) {
        let finished = match self.finisher.as_ref().map(|finisher| finisher.news.try_recv()) {
            None | Some(Err(TryRecvError::Empty)) => return,
            Some(Ok(finished)) => finished.map_err(|error| error.to_string()),
            Some(Err(TryRecvError::Disconnected)) => {
                Err("the thread that builds patches has stopped; please report this".to_owned())
            }
        };
        let Some(Finisher { file, thread, .. }) = self.finisher.take() else { return };
        self.retired.push(thread);
        if let Err(error) = finished {
            let how = format!("'terrane edit {} resume' builds what is left", file.display());
            self.failed = Some(format!("{error}; the edit is made, and {how}"));
        }
    }
}

impl Drop for Edits {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let storing = self.storing.take().map(|storing| storing.thread);
        let finishing = self.finisher.take().map(|finisher| finisher.thread);
        // One that panicked has nothing left to clean up.
        storing.into_iter().chain(finishing).chain(self.retired.drain(..)).for_each(|thread| drop(thread.join()));
    }
}

impl Scene {
    /// Begins to change the ground. Frames go on with that of before until the other is there; [`Scene::edits`] says how far it is.
    ///
    /// # Errors
    /// If another edit is under way, if the edit is out of range, or if there is nothing to undo or to do again. What else may go wrong is
    /// said by [`Scene::edits`] later.
    pub fn edit(&mut self, request: EditRequest) -> Result<(), SceneError> {
        if self.edits.is_storing() || self.renewal.is_some() {
            return Err(SceneError::EditUnderWay);
        }
        let change = self.change(request)?;
        let edits = &mut self.edits;
        edits.stop.store(true, Ordering::Relaxed);
        edits.stop = Arc::default();
        let job = Job {
            supply: self.supply.clone(),
            planet: self.planet.clone(),
            around: self.around.clone(),
            change,
            before: edits.finisher.take().map(|finisher| finisher.thread),
            stop: edits.stop.clone(),
        };
        let (sender, news) = channel();
        let has_news = Arc::new(AtomicBool::new(false));
        let told = has_news.clone();
        let thread = std::thread::spawn(move || {
            let _ = sender.send(job.run());
            told.store(true, Ordering::Relaxed);
        });
        edits.storing = Some(Storing { request, news, has_news, thread });
        (edits.begun, edits.latest, edits.failed) = (Some(Instant::now()), None, None);
        self.settled = false;
        Ok(())
    }

    fn change(&self, request: EditRequest) -> Result<Change, SceneError> {
        let edit = match request {
            EditRequest::Apply(edit) => edit,
            EditRequest::Redo => *self.edits.undone.last().ok_or(SceneError::NothingToRedo)?,
            EditRequest::Undo if self.planet.recipe.undoable_edits() > 0 => return Ok(Change::Undo),
            EditRequest::Undo => {
                let file = self.supply.path.clone();
                let by_hand = self.planet.recipe.edits.last();
                return Err(by_hand
                    .map_or(EditError::NoEdit { file: file.clone() }, |&edit| EditError::ByHand { file, edit })
                    .into());
            }
        };
        edit.check(self.planet.recipe.radius).map_err(EditError::from)?;
        Ok(Change::Add(edit))
    }

    /// How far the latest edit is, and how many can be undone and done again.
    pub fn edits(&self) -> EditStatus {
        let state = match &self.renewal {
            Some(renewal) => {
                let there = renewal.fresh.len();
                EditState::Loading { there, needed: there + renewal.lacking }
            }
            None => self.edits.state(),
        };
        let recipe = &self.planet.recipe;
        let (undoable, redoable) = (recipe.undoable_edits(), self.edits.undone.len());
        EditStatus { state, undoable, redoable, latest: self.edits.latest }
    }

    /// Takes in what became of a change of the file, if that is known before a limit.
    pub(super) fn take_edit(&mut self, limit: Duration) {
        self.edits.take_finished();
        let Some(storing) = &self.edits.storing else { return };
        let news = match storing.news.recv_timeout(limit) {
            Err(RecvTimeoutError::Timeout) => return,
            Ok(news) => news,
            Err(RecvTimeoutError::Disconnected) => {
                let message = "the thread that edits the planet file has stopped; please report this".to_owned();
                Err(Failure { message, has_changed: true })
            }
        };
        let Some(Storing { request, thread, .. }) = self.edits.storing.take() else { return };
        self.edits.retired.push(thread);
        match news {
            Ok(next) => {
                match request {
                    EditRequest::Apply(_) => self.edits.undone.clear(),
                    EditRequest::Undo => self.edits.undone.push(next.edit),
                    EditRequest::Redo => drop(self.edits.undone.pop()),
                }
                self.begin_renewal(next);
            }
            Err(Failure { message, has_changed }) => {
                (self.edits.failed, self.edits.is_left_behind) = (Some(message), has_changed || self.edits.is_left_behind);
            }
        }
    }

    /// Goes on with what is there, from now on, if another program edits the planet file: [`Scene::is_overtaken`] tells of it. Otherwise that
    /// is an error.
    pub fn bear_edits_of_others(&mut self) {
        self.edits.bears_others = true;
    }

    /// Whether patches are lacking because another program has edited the planet file: it has to be opened again.
    pub fn is_overtaken(&self) -> bool {
        self.edits.is_overtaken
    }

    /// What arrived, but for patches that the file no longer has because its ground is changing.
    pub(super) fn unless_behind<T: Default>(&mut self, arrived: Result<T, SceneError>) -> Result<T, SceneError> {
        match arrived {
            Err(SceneError::Store(StoreError::Absent { .. } | StoreError::Changed { .. })) if self.is_behind() => {
                Ok(T::default())
            }
            arrived => arrived,
        }
    }

    fn is_behind(&mut self) -> bool {
        let may_be_ahead = self.edits.may_be_ahead() || self.edits.is_overtaken;
        if !may_be_ahead && self.edits.bears_others {
            let now = PlanetFile::open(&self.supply.path);
            self.edits.is_overtaken = now.is_ok_and(|file| *file.header() != self.planet.header());
        }
        may_be_ahead || self.edits.is_overtaken
    }
}
