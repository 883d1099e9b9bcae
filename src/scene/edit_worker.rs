//! What goes on beside a scene while its planet file is edited: the change of the file, and then workers that know the ground of after.
//!
//! The change is the file's own transaction, so the file is whole at any moment, also if this never comes to its end.

use super::keeper::Keeper;
use super::loader::{step_back, Loader};
use super::supply::Supply;
use super::Scope;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::surroundings::KnownSurroundings;
use terrane_planet::mesh::progressive::PatchFacts;
use terrane_planet::planet::edits::{add, finish, undo, Changed, EditError, Touched};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Edit;
use terrane_planet::store::{PlanetFile, StoreError};

/// Threads that bring back what a file is to hold: one, beside those that build what is in sight.
const FINISHERS: usize = 1;

/// A change of a file.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    Add(Edit),
    Undo,
}

/// A file's ground of after a change, ready to be drawn as soon as its patches are there.
pub(super) struct NextGround {
    pub(super) planet: Arc<Planet>,
    pub(super) edit: Edit,
    pub(super) reach: Touched,
    /// What is known of touched patches already.
    pub(super) facts: Vec<(PatchId, PatchFacts)>,
    /// Heights around patches.
    pub(super) around: Arc<KnownSurroundings>,
    pub(super) loader: Loader,
    pub(super) keeper: Option<Keeper>,
}

/// Why there is no ground of after.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) message: String,
    /// Whether the file's ground is another nevertheless.
    pub(super) has_changed: bool,
}

/// How far the patches are that the file is to get back.
#[derive(Debug, Default)]
pub(super) struct Finishing {
    pub(super) built: AtomicUsize,
    pub(super) total: AtomicUsize,
}

/// What the worker of a change needs.
pub(super) struct Job {
    pub(super) supply: Supply,
    /// The planet that the scene draws.
    pub(super) planet: Arc<Planet>,
    /// Heights around its patches.
    pub(super) around: Arc<KnownSurroundings>,
    pub(super) change: Change,
    /// What else writes the file for an edit before; it was asked to stop.
    pub(super) before: Option<JoinHandle<()>>,
    /// Ends the building of what is only stored.
    pub(super) stop: Arc<AtomicBool>,
}

impl Job {
    /// Changes the file.
    pub(super) fn run(self) -> Result<NextGround, Failure> {
        // One that panicked writes no more.
        let _ = self.before.map(JoinHandle::join);
        let failed = |has_changed| {
            move |error: EditError| {
                // Somebody else may have changed it.
                let has_changed = has_changed || matches!(error, EditError::Store(StoreError::Changed { .. }));
                Failure { message: error.to_string(), has_changed }
            }
        };
        let mut file = PlanetFile::open_to_edit(&self.supply.path).map_err(EditError::from).map_err(failed(false))?;
        let changed = change(&mut file, &self.planet, self.change).map_err(failed(false))?;
        reopened(&self.supply, &mut file, changed, &self.around, &self.stop).map_err(failed(true))
    }
}

fn change(file: &mut PlanetFile, planet: &Planet, change: Change) -> Result<Changed, EditError> {
    if *file.header() != planet.header() {
        return Err(StoreError::Changed { file: file.path().to_owned() }.into());
    }
    match change {
        Change::Add(edit) => add(file, planet, edit),
        Change::Undo => undo(file, planet),
    }
}

/// What is needed to draw the ground of after.
fn reopened(
    supply: &Supply,
    file: &mut PlanetFile,
    changed: Changed,
    around: &KnownSurroundings,
    stop: &AtomicBool,
) -> Result<NextGround, EditError> {
    let Changed { planet, edit, reach, .. } = changed;
    let known = if supply.builds() {
        // All else is built as it is wanted, what is in sight first.
        PatchId::roots().collect()
    } else {
        finish(file, &planet, FINISHERS, &|_| (), stop)?;
        file.index()?.into_iter().filter(|record| record.has_mesh()).map(|record| record.id).collect::<Vec<PatchId>>()
    };
    let facts = |id| Ok(file.facts(id)?.map(|facts| (id, facts)));
    let touched = known.into_iter().filter(|&id| reach.touches(id));
    let facts = touched.filter_map(|id| facts(id).transpose()).collect::<Result<Vec<_>, StoreError>>()?;
    let planet = Arc::new(planet);
    let keeper = supply.keeper(file.header());
    let around = Arc::new(around.of_those(|id| !reach.touches_around(id)));
    let loader = supply.loader(&planet, keeper.as_ref(), &around)?;
    Ok(NextGround { planet, edit, reach, facts, around, loader, keeper })
}

/// Builds what the file is to hold and edits took out of it.
pub(super) fn bring_back(
    path: &Path,
    planet: &Planet,
    scope: Scope,
    progress: &Finishing,
    stop: &AtomicBool,
) -> Result<(), EditError> {
    if scope == Scope::Flight {
        step_back();
    }
    let mut file = PlanetFile::open_to_edit(path)?;
    if *file.header() != planet.header() {
        return Err(StoreError::Changed { file: path.to_owned() }.into());
    }
    let show = |p: terrane_planet::planet::bake::Progress| {
        progress.total.store(p.total, Ordering::Relaxed);
        progress.built.store(p.built, Ordering::Relaxed);
    };
    finish(&mut file, planet, FINISHERS, &show, stop).map(drop)
}
