//! Levels of a simplified heightfield: a surface of so many faces, or of so small an error, and its error measured at all
//! samples. In: a heightfield and a cost. Out: surfaces with what [`TriangleSurface::deviation`] says about them, never what
//! their builder thinks.

use super::{progressive_mesh, ClassicError, Cost, ProgressiveMesh};
use crate::plain;
use crate::plain::HalfEdgeCollapses;
use crate::{Deviation, Heightfield, Holes, TriangleSurface};

/// Vertices of the first surface that is tried for an error, besides the corners, and how many times more each next one has.
const FIRST_STEPS: usize = 16;
const GROWTH: usize = 4;

/// Share of the vertices that is left away first when a surface is known to be good enough.
const FIRST_STRIDE: usize = 64;

/// How many such shares coarser the search looks for surfaces that happen to be good enough too.
const LOOKS_BACK: usize = 8;

/// All surfaces between a heightfield's two coarsest triangles and all its samples, in the order of a cost.
pub struct Levels<'a> {
    field: &'a Heightfield,
    sequence: Sequence,
    polish: bool,
    /// What is cut out of every surface.
    holes: Option<Holes>,
}

/// Where surfaces come from. Collapses alone take a tenth of the memory of a progressive mesh.
enum Sequence {
    Collapses(HalfEdgeCollapses),
    Mesh { mesh: Box<ProgressiveMesh>, at: usize },
}

/// A surface and how far it is from the heightfield, in the heightfield's coordinates.
pub struct Level {
    /// The surface.
    pub surface: TriangleSurface,
    /// Its measured error.
    pub deviation: Deviation,
}

impl<'a> Levels<'a> {
    /// Simplifies a heightfield down to its corners. `progress` is told the collapses done.
    ///
    /// # Errors
    /// If samples have no finite height, or [`Cost::Certified`] finds the field too large.
    pub fn new(field: &'a Heightfield, cost: Cost, progress: &mut dyn FnMut(usize)) -> Result<Levels<'a>, ClassicError> {
        let sequence = match cost {
            Cost::Certified => Sequence::Collapses(plain::simplify_with(field, progress)?),
            Cost::Quadric | Cost::Spring => Sequence::Mesh { mesh: Box::new(progressive_mesh(field, cost, progress)?), at: 0 },
        };
        Ok(Levels { field, sequence, polish: false, holes: None })
    }

    /// Simplifies a filled heightfield around holes, which are cut out of every level; all samples on their borders stay. By
    /// [`Cost::Certified`].
    ///
    /// # Errors
    /// As [`Levels::new`].
    pub fn around(field: &'a Heightfield, holes: Holes, progress: &mut dyn FnMut(usize)) -> Result<Levels<'a>, ClassicError> {
        let sequence = Sequence::Collapses(plain::simplify_around(field, &holes.border(), progress)?);
        Ok(Levels { field, sequence, polish: false, holes: Some(holes) })
    }

    /// The same, with certified surfaces polished: vertices still stand on samples, but need not have their heights. Surfaces with
    /// holes stay as they are.
    pub fn with_polish(self) -> Self {
        Levels { polish: self.holes.is_none(), ..self }
    }

    /// The finest surface of at most so many faces; the coarsest, for fewer than that has.
    pub fn of_faces(&mut self, faces: usize) -> Level {
        let surface = match &mut self.sequence {
            Sequence::Collapses(collapses) if self.polish => collapses.polished(self.field, faces),
            Sequence::Collapses(collapses) => collapses.surface(self.field, collapses.collapses_to(faces)),
            Sequence::Mesh { mesh, at } => {
                let before = mesh.mesh().living_vertices().count();
                mesh.set_faces(faces);
                *at = *at + mesh.mesh().living_vertices().count() - before;
                mesh.mesh().surface()
            }
        };
        self.measured(surface)
    }

    /// A coarsest surface whose largest measured error is at most `error`: with one vertex less it is larger. Errors need not fall
    /// evenly, so somewhat coarser surfaces are tried too, and the coarsest that is found is taken.
    pub fn of_error(&mut self, error: f64) -> Level {
        if let (Sequence::Collapses(collapses), true) = (&self.sequence, self.polish) {
            return self.measured(collapses.polished_within(self.field, error));
        }
        let (open, holds, level) = match self.promised(error) {
            Some(promised) => self.coarsen_from(promised, error),
            None => self.refine_to(error),
        };
        let (holds, level) = self.bisect(open, holds, level, error);
        let stride = holds / FIRST_STRIDE + 1;
        for coarser in (1..=LOOKS_BACK).rev().filter_map(|k| holds.checked_sub(k * stride)) {
            let tried = self.at(coarser);
            if tried.deviation.max <= error {
                // The next coarser look failed, or is too far for another look.
                return self.bisect(coarser.saturating_sub(stride) + 1, coarser, tried, error).1;
            }
        }
        level
    }

    /// Narrows a crossing of `error` down to one vertex: fewer steps than `open` fail, `holds` steps hold.
    fn bisect(&mut self, mut open: usize, mut holds: usize, mut level: Level, error: f64) -> (usize, Level) {
        while holds > open {
            let middle = open + (holds - open) / 2;
            let tried = self.at(middle);
            if tried.deviation.max > error {
                open = middle + 1;
            } else {
                (holds, level) = (middle, tried);
            }
        }
        (holds, level)
    }

    /// Steps at which the builder's own errors promise that a surface is good enough; measuring finds it good with fewer.
    fn promised(&self, error: f64) -> Option<usize> {
        let Sequence::Collapses(collapses) = &self.sequence else { return None };
        Some(collapses.order.len() - collapses.collapses_within(error))
    }

    /// Ever coarser surfaces from one that holds, until one fails. Out: the fewest steps that are still open, steps that hold, and
    /// their level.
    fn coarsen_from(&mut self, promised: usize, error: f64) -> (usize, usize, Level) {
        let (mut holds, mut level) = (promised, self.at(promised));
        if level.deviation.max > error {
            // Rounding in the promise: go on from everything.
            let most = self.steps();
            (holds, level) = (most, self.at(most));
        }
        let mut stride = holds / FIRST_STRIDE + 1;
        while holds > 0 {
            let fewer = holds.saturating_sub(stride);
            let tried = self.at(fewer);
            if tried.deviation.max > error {
                return (fewer + 1, holds, level);
            }
            (holds, level) = (fewer, tried);
            stride *= 2;
        }
        (0, 0, level)
    }

    /// Ever finer surfaces from the coarsest, until one holds. Out: as [`Levels::coarsen_from`].
    fn refine_to(&mut self, error: f64) -> (usize, usize, Level) {
        let (most, mut open, mut steps) = (self.steps(), 0, 0);
        loop {
            let level = self.at(steps);
            if level.deviation.max <= error || steps == most {
                return (open, steps, level);
            }
            open = steps + 1;
            steps = (steps * GROWTH).max(FIRST_STEPS).min(most);
        }
    }

    /// Vertices that can be added to the coarsest surface.
    fn steps(&self) -> usize {
        match &self.sequence {
            Sequence::Collapses(collapses) => collapses.order.len(),
            Sequence::Mesh { mesh, .. } => mesh.splits().len(),
        }
    }

    /// The surface of so many vertices besides the coarsest one's.
    fn at(&mut self, steps: usize) -> Level {
        let surface = match &mut self.sequence {
            Sequence::Collapses(collapses) => collapses.surface(self.field, collapses.order.len() - steps),
            Sequence::Mesh { mesh, at } => {
                while *at < steps && mesh.next() {
                    *at += 1;
                }
                while *at > steps && mesh.prev() {
                    *at -= 1;
                }
                mesh.mesh().surface()
            }
        };
        self.measured(surface)
    }

    fn measured(&self, surface: TriangleSurface) -> Level {
        let surface = match &self.holes {
            Some(holes) => holes.cut(&surface),
            None => surface,
        };
        Level { deviation: surface.deviation(self.field), surface }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hills() -> Heightfield {
        let height = |k: usize| {
            let (x, y) = ((k % 41) as f32, (k / 41) as f32);
            (x * 0.7).sin() * 3.0 + (y * 0.45 + x * 0.2).cos() * 5.0 + (x * y * 0.05).sin()
        };
        Heightfield::new(41, 35, (0..41 * 35).map(height).collect()).unwrap()
    }

    #[test]
    fn the_coarsest_level_within_the_error_is_found() {
        let field = hills();
        for cost in Cost::ALL {
            let mut levels = Levels::new(&field, cost, &mut |_| ()).unwrap();
            for error in [0.3, 2.0, 5.0] {
                let level = levels.of_error(error);
                assert!(level.deviation.max <= error && level.deviation.uncovered == 0, "{}", cost.name());
                let steps = level.surface.positions.len() - 4;
                assert!(levels.at(steps - 1).deviation.max > error, "{} could do with less for {error}", cost.name());
            }
            assert!(levels.of_error(0.0).deviation.max == 0.0);
            assert_eq!(levels.of_error(1e9).surface.faces.len(), 2, "{}", cost.name());
        }
    }

    #[test]
    fn polish_lowers_errors_and_keeps_the_error_asked_for() {
        let field = hills();
        let mut plain = Levels::new(&field, Cost::Certified, &mut |_| ()).unwrap();
        let mut polished = Levels::new(&field, Cost::Certified, &mut |_| ()).unwrap().with_polish();
        assert!(polished.of_faces(500).deviation.max < 0.9 * plain.of_faces(500).deviation.max);
        let level = polished.of_error(1.0);
        assert!(level.deviation.max <= 1.0 && level.surface.faces.len() < plain.of_error(1.0).surface.faces.len());
    }

    #[test]
    fn levels_have_at_most_the_faces_asked_for() {
        let field = hills();
        for cost in Cost::ALL {
            let mut levels = Levels::new(&field, cost, &mut |_| ()).unwrap();
            for faces in [500, 2000, 60, 2, 1_000_000] {
                let level = levels.of_faces(faces);
                let found = level.surface.faces.len();
                assert!(found <= faces && (found + 2 > faces || found == 2 * 40 * 34), "{}: {found} for {faces}", cost.name());
                // A request for an error in between must not change what a later request for faces gives.
                let error = level.deviation.max;
                let again = levels.of_error(error).surface.faces.len();
                assert!(again <= found + found / 8 + 4, "{}: {again} faces for the error of {found}", cost.name());
            }
        }
    }
}
