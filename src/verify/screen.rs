//! The screen error of whole planets, measured with rays: natural cuts, cuts of what is in sight alone, as pictures are drawn, cuts that
//! split more than they must, and cuts with patches missing.
//!
//! Drawn by the CPU's stages, which [`super::Verifier::check`] compares with the GPU's bit by bit in the same views.

use super::twins::Twin;
use super::{MeshFaults, Verifier};
use terrane_planet::draw::cut::{cut, cut_by, cut_in_sight, urgency, Cut};
use terrane_planet::draw::tree::{PatchNode, PatchTree};
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::store::StoreError;
use terrane_planet::verify::{measure, Drawn, Effort, FinestSurface, ScreenError, SurfaceCheck};

/// Share of the tolerance that the error may reach.
pub const PROMISED_SHARE: f64 = 1.0;

/// Which patches a view is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Perturbation {
    /// Those that the view asks for, of the whole planet.
    None,
    /// Those of them that are in sight.
    InSight,
    /// A third of the patches split at five times their distance.
    OverSplit,
    /// A fifth of the patches are not resident, never the whole faces.
    Missing,
}

impl Perturbation {
    /// The ways in which view number `k` is measured: whole, and in one of the other ways.
    pub fn of_view(k: usize) -> impl Iterator<Item = Perturbation> {
        let also = [Perturbation::InSight, Perturbation::OverSplit, Perturbation::Missing][k % 3];
        [Perturbation::None, also].into_iter()
    }

    /// Its name, for people and for JSON.
    pub fn name(self) -> &'static str {
        match self {
            Perturbation::None => "natural",
            Perturbation::InSight => "in sight",
            Perturbation::OverSplit => "over-split",
            Perturbation::Missing => "patches missing",
        }
    }

    fn is_resident(self, tree: &PatchTree, id: PatchId, k: usize) -> bool {
        tree.get(id).is_some() && (self != Perturbation::Missing || id.level == 0 || !dice(id, k).is_multiple_of(5))
    }

    fn cut(self, tree: &PatchTree, view: &View, k: usize) -> Cut {
        let resident = |id| self.is_resident(tree, id, k);
        match self {
            Perturbation::None | Perturbation::Missing => return cut(tree, view, &resident),
            Perturbation::InSight => return cut_in_sight(tree, view, false, 1.0, &resident),
            Perturbation::OverSplit => {}
        }
        let eager = |id: PatchId, node: &PatchNode| {
            let hurry = if dice(id, k).is_multiple_of(3) { 0.2 } else { 1.0 };
            urgency(tree, view, id.level, node) * hurry
        };
        cut_by(tree, &eager, &resident)
    }
}

/// A number that differs from patch to patch and from view to view.
fn dice(id: PatchId, k: usize) -> u64 {
    let name = u64::from(id.x) << 32 | u64::from(id.y) << 8 | u64::from(id.level) << 3 | u64::from(id.face.index());
    terrane_planet::globe::random::Random::new(name ^ (k as u64) << 48).bits()
}

/// What one drawing of a view showed.
#[derive(Clone, Debug, Default)]
pub struct ScreenReport {
    /// The errors.
    pub error: ScreenError,
    /// Directed edges that nothing cancels.
    pub cracks: usize,
    /// Flipped and degenerate triangles.
    pub faults: MeshFaults,
}

impl Verifier {
    /// Measures view number `k` as drawn with a perturbation.
    ///
    /// # Errors
    /// If patches cannot be read.
    pub fn screen_error(
        &mut self,
        tree: &PatchTree,
        view: &View,
        k: usize,
        perturbation: Perturbation,
        rays: usize,
    ) -> Result<ScreenReport, StoreError> {
        let cut = perturbation.cut(tree, view, k);
        for leaf in &cut.leaves {
            self.patch_mut(leaf.id)?;
        }
        let twins: Vec<Twin> =
            cut.leaves.iter().filter_map(|leaf| Some(Twin::new(view, leaf, self.patches.get(&leaf.id)?))).collect();
        let triangles: Vec<Vec<[u32; 3]>> = twins.iter().map(|twin| twin.emit(None)).collect();
        let mut surface = SurfaceCheck::default();
        let mut drawn = Vec::with_capacity(twins.len());
        for (twin, triangles) in twins.iter().zip(&triangles) {
            let vertices = &twin.known.loaded.vertices;
            surface.add(vertices, twin.drawn_positions(), triangles);
            drawn.push(Drawn { leaf: twin.leaf, vertices, drawn_positions: twin.drawn_positions(), triangles });
        }
        let finest = FinestSurface::new(tree, &|id| perturbation.is_resident(tree, id, k), &self.grids);
        // A patch that could be built, and was not asked for, is not missing.
        let excused = |id| finest.ends_at(id) && (perturbation == Perturbation::Missing || !tree.can_split(id));
        let effort = Effort { pixels: rays, finer_samples: rays, seed: k as u64 };
        let error = measure(view, tree, &drawn, &finest, &excused, effort)?;
        let surface = match perturbation {
            Perturbation::InSight => surface.finish_in_sight(view, tree.hidden_radius),
            _ => surface.finish(),
        };
        let faults = MeshFaults { flipped: surface.flipped, degenerate: surface.degenerate, closure_violations: 0 };
        Ok(ScreenReport { error, cracks: surface.cracks, faults })
    }
}

/// The errors of all views with one tolerance.
#[derive(Clone, Debug)]
pub struct ToleranceErrors {
    /// The tolerance in pixels.
    pub tolerance: f64,
    /// Views with it.
    pub views: usize,
    /// What they showed.
    pub error: ScreenError,
    /// Number of the view with the largest error, and how it was drawn.
    pub worst_view: Option<(usize, Perturbation)>,
}

impl ToleranceErrors {
    fn new(tolerance: f64) -> ToleranceErrors {
        ToleranceErrors { tolerance, views: 0, error: ScreenError::default(), worst_view: None }
    }

    /// Largest error over the tolerance.
    pub fn share(&self) -> f64 {
        self.error.readings.max() / self.tolerance
    }
}

/// The errors of all views.
#[derive(Clone, Debug, Default)]
pub struct ScreenErrors {
    /// One for each tolerance, rising.
    pub by_tolerance: Vec<ToleranceErrors>,
    /// Directed edges that nothing cancels, in perturbed cuts.
    pub cracks: usize,
    /// Flipped triangles in perturbed cuts.
    pub flipped: usize,
}

impl ScreenErrors {
    /// Adds what view number `k` showed.
    pub fn add(&mut self, k: usize, view: &View, perturbation: Perturbation, report: &ScreenReport) {
        let at = self.by_tolerance.partition_point(|known| known.tolerance < view.tolerance);
        if self.by_tolerance.get(at).is_none_or(|known| known.tolerance != view.tolerance) {
            self.by_tolerance.insert(at, ToleranceErrors::new(view.tolerance));
        }
        let known = &mut self.by_tolerance[at];
        let first = usize::from(perturbation == Perturbation::None);
        self.cracks += report.cracks;
        self.flipped += report.faults.flipped;
        known.views += first;
        if report.error.readings.max() > known.error.readings.max() {
            known.worst_view = Some((k, perturbation));
        }
        known.error.merge(&report.error);
    }

    /// The tolerance that was kept least.
    pub fn worst(&self) -> Option<&ToleranceErrors> {
        self.by_tolerance.iter().max_by(|a, b| a.share().total_cmp(&b.share()))
    }

    /// What breaks a promise, in words; nothing if all is well.
    pub fn broken_promises(&self) -> Vec<String> {
        let mut broken = Vec::new();
        for t in self.by_tolerance.iter().filter(|t| t.share() > PROMISED_SHARE) {
            broken.push(format!("screen errors of {:.3} px at a tolerance of {} px", t.error.readings.max(), t.tolerance));
        }
        let missed: usize = self.by_tolerance.iter().map(|t| t.error.missed).sum();
        for (count, what) in [
            (self.cracks, "cracks in perturbed cuts"),
            (self.flipped, "flipped triangles in perturbed cuts"),
            (missed, "points where a surface has a hole"),
        ] {
            if count > 0 {
                broken.push(format!("{count} {what}"));
            }
        }
        broken
    }
}
