//! Triangles at equal measured screen error: our surfaces against the classic ways to draw terrain.
//!
//! In: one planet's stored patches and cameras along a path. Out: for each method the knob with which its largest measured error (or the
//! 99.9th percentile) over all frames is the target, and the triangles that it then takes. All methods draw the same data from the
//! same cameras and are measured at the same probes by the same judge ([`sheet`]); each has one knob, tuned alike ([`tuning`]). Every
//! family enters with several variants; on a few frames the one that takes the fewest triangles is found, and measured on all.

mod cdlod;
mod clusters;
mod ours;
mod probes;
mod rtin;
mod setting;
mod sheet;
mod tuning;

#[cfg(test)]
mod tests;

use cdlod::{Cdlod, LEAST_CELLS};
use clusters::{Clusters, Errors};
use ours::Ours;
use probes::{Chooser, Probes};
use rayon::prelude::*;
use rtin::Rtin;
use setting::CutRule;
use sheet::Sheet;
use terrane_planet::draw::view::Camera;
use terrane_planet::store::StoreError;

pub(crate) use probes::Effort;
pub(crate) use setting::Setting;
pub(crate) use tuning::{best, Equal, Measured};

/// A way to draw the planet.
pub(crate) trait Method: Sync {
    /// Which method it is.
    fn family(&self) -> &'static str;

    /// Which variant of it.
    fn variant(&self) -> String;

    /// Draws what may be in view of a camera. The larger the knob, the coarser; about its error in pixels.
    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError>;
}

/// A camera and where the error of its picture is measured.
pub(crate) struct Viewpoint {
    camera: Camera,
    probes: Probes,
}

/// The viewpoints of cameras whose pictures are meant to be drawn within `target` pixels.
pub(crate) fn viewpoints(
    setting: &Setting,
    cameras: &[Camera],
    target: f64,
    effort: Effort,
) -> Result<Vec<Viewpoint>, StoreError> {
    let chooser = Chooser::new(setting, target, effort);
    let viewpoint = |(k, &camera)| Ok(Viewpoint { camera, probes: Probes::new(&chooser, &camera, k as u64)? });
    cameras.par_iter().enumerate().map(viewpoint).collect()
}

/// Probes of all viewpoints together.
pub(crate) fn count_probes(viewpoints: &[Viewpoint]) -> usize {
    viewpoints.iter().map(|viewpoint| viewpoint.probes.len()).sum()
}

/// Makes the variants of a family.
pub(crate) type Family = fn(&Setting) -> Result<Vec<Box<dyn Method>>, StoreError>;

/// All families, what we draw first.
pub(crate) const FAMILIES: [Family; 6] = [ours, ours_still, ours_finer, cdlod, rtin, clusters];

fn boxed<M: Method + 'static>(methods: Vec<M>) -> Vec<Box<dyn Method>> {
    methods.into_iter().map(|method| Box::new(method) as Box<dyn Method>).collect()
}

fn ours(_: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    Ok(boxed(vec![Ours::new()]))
}

fn ours_still(_: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    Ok(boxed(vec![Ours::new().without_geomorphs()]))
}

/// Not how the run time cuts: what we would need with the freedom that the baselines have.
fn ours_finer(_: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    let ours = Ours::new();
    Ok(boxed([0.5, 0.25].map(|cut| ours.with_cut(cut)).into()))
}

fn cdlod(setting: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    let mut variants = Vec::new();
    for cells in [16, 8, 4, 2].map(|share| setting.tree.cells / share) {
        if cells >= LEAST_CELLS {
            variants.extend(boxed(Cdlod::family(setting, cells)?));
        }
    }
    Ok(variants)
}

fn rtin(setting: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    let cuts = [(CutRule::AsDrawn, 1.0), (CutRule::Detail, 1.0), (CutRule::Detail, 0.5), (CutRule::Detail, 0.25)];
    Ok(boxed(Rtin::family(setting, &cuts)))
}

fn clusters(_: &Setting) -> Result<Vec<Box<dyn Method>>, StoreError> {
    let cuts = [(CutRule::AsDrawn, 1.0), (CutRule::Detail, 1.0), (CutRule::Detail, 2.0)];
    let variants = [Errors::Measured, Errors::Reported].into_iter().flat_map(|e| cuts.map(|(rule, cut)| (e, rule, cut)));
    let variants: Vec<_> = variants.collect();
    Ok([128, 64].into_iter().flat_map(|most| boxed(Clusters::family(most, &variants))).collect())
}
