//! Editing the ground of a planet file: another recipe, and only the patches that can tell the difference built again.
//!
//! In: an open file, its planet, an edit. Out: the file with the edit at the end of its recipe. One transaction puts the new recipe in
//! place and removes the patches that the edit touches; the six whole faces come back within it, the others in a bake after it,
//! which can stop and go on at any time: a patch is of the recipe at hand or it is absent.

mod touched;

pub use touched::Touched;

use super::bake::{bake, build_and_encode, BakeError, BakePlan, BakeSummary, Progress};
use super::{Planet, PlanetError};
use crate::globe::patch::PatchId;
use crate::recipe::{Edit, EditRange, RecipeError};
use crate::store::{PlanetFile, StoreError};
use crate::terrain::edits::centre;
use glam::DVec3;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Samples along half of the square that a mean height is taken of.
const MEAN_SAMPLES: i32 = 24;

/// Why the ground cannot be edited. The file is as it was before, unless a patch could not be built or stored afterwards.
#[derive(Debug, Error)]
pub enum EditError {
    /// A number of the edit.
    #[error(transparent)]
    Range(#[from] EditRange),
    /// The edited recipe.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// The edited planet.
    #[error(transparent)]
    Planet(#[from] PlanetError),
    /// The file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Building.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// Nothing to undo.
    #[error("{file}: there is no edit to undo")]
    NoEdit {
        /// The planet file.
        file: PathBuf,
    },
    /// The last edit is part of the recipe that the file was baked from.
    #[error("{file}: the last edit ({edit}) was written into the recipe by hand; take it out of the recipe and bake that")]
    ByHand {
        /// The planet file.
        file: PathBuf,
        /// The edit.
        edit: Edit,
    },
}

/// What changing the ground of a file did so far.
pub struct Changed {
    /// The planet of the file from now on.
    pub planet: Planet,
    /// The edit that was made or undone.
    pub edit: Edit,
    /// Which patches may be others than before, in the file or not.
    pub reach: Touched,
    /// Patches of the file that it touches.
    pub touched: usize,
    /// Whole faces among them, built already.
    pub faces: usize,
}

/// Adds an edit at the end of a file's recipe. `planet` is the file's. [`finish`] builds what it touches.
///
/// # Errors
/// If the edit is out of range or leaves the planet's lattice, or the file cannot be read or written: then nothing has changed.
pub fn add(file: &mut PlanetFile, planet: &Planet, edit: Edit) -> Result<Changed, EditError> {
    edit.check(planet.recipe.radius)?;
    change(file, planet.edited(planet.recipe.with_edit(&edit)?)?, edit)
}

/// Takes the last edit away again: the recipe is to the letter what it was before.
///
/// # Errors
/// If there is none, or if it was not [`add`]ed, or the file cannot be read or written: then nothing has changed.
pub fn undo(file: &mut PlanetFile, planet: &Planet) -> Result<Changed, EditError> {
    let path = || file.path().to_owned();
    let last = *planet.recipe.edits.last().ok_or_else(|| EditError::NoEdit { file: path() })?;
    let before = planet.recipe.without_last_edit()?.ok_or_else(|| EditError::ByHand { file: path(), edit: last })?;
    change(file, planet.edited(before)?, last)
}

/// Builds the patches that edits removed and that are not back yet, as [`bake`] does.
///
/// # Errors
/// As [`bake`].
pub fn finish(
    file: &mut PlanetFile,
    planet: &Planet,
    threads: usize,
    progress: &dyn Fn(Progress),
    stop: &AtomicBool,
) -> Result<BakeSummary, EditError> {
    let plan = BakePlan { patches: file.pending()?, region: None };
    Ok(bake(file, &planet.terrain, &planet.terrain, &plan, threads, progress, stop)?)
}

/// Mean height of the ground within a radius, in whole millimetres: what a site is flattened to unless a height is given.
pub fn mean_height(planet: &Planet, latitude_deg: f64, longitude_deg: f64, radius_m: f64) -> f64 {
    let middle = centre(latitude_deg, longitude_deg);
    let (east, north) = middle.any_orthonormal_pair();
    let step = radius_m / planet.recipe.radius / f64::from(MEAN_SAMPLES);
    let steps = -MEAN_SAMPLES..=MEAN_SAMPLES;
    let square = steps.clone().flat_map(|a| steps.clone().map(move |b| (a, b)));
    let disc = square.filter(|(a, b)| a * a + b * b <= MEAN_SAMPLES * MEAN_SAMPLES);
    let site = |(a, b): (i32, i32)| (middle + (east * f64::from(a) + north * f64::from(b)) * step).normalize();
    let sites: Vec<DVec3> = disc.map(site).collect();
    let mut heights = vec![0.0; sites.len()];
    planet.terrain.heights(&sites, &mut heights);
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    (mean * 1e3).round() / 1e3
}

fn change(file: &mut PlanetFile, planet: Planet, edit: Edit) -> Result<Changed, EditError> {
    let reach = Touched::new(&edit, planet.recipe.radius, planet.cells);
    let faces: Vec<PatchId> = PatchId::roots().filter(|&id| reach.touches(id)).collect();
    let (mut built, mut around) = (Vec::new(), Vec::new());
    for &id in &faces {
        let (patch, surroundings, _) = build_and_encode(&planet.ground(), &planet.terrain, id)?;
        built.push(patch);
        around.push(surroundings);
    }
    let touched = [&|id| reach.touches(id), &|id| reach.touches_around(id)] as [&dyn Fn(PatchId) -> bool; 2];
    let touched = file.replace_ground(&planet.header(), touched, &built, &around)?;
    Ok(Changed { planet, edit, reach, touched, faces: faces.len() })
}
