//! The classic experiment: one small heightfield, coarsened with every cost to a row of face counts, with the error of each
//! mesh measured at all samples. In: a heightfield. Out: a table, a contact sheet of the meshes and a plot of their errors.

pub(crate) mod arrival;
pub(crate) mod canvas;
pub(crate) mod plot;
pub(crate) mod relief;
pub(crate) mod sheet;
pub(crate) mod terrain;

use terrane_heightfield::classic::{progressive_mesh, ClassicError, Cost};
use terrane_heightfield::{Deviation, Heightfield, TriangleSurface};

/// Face counts of the pictures, coarsest first.
pub(crate) const PICTURED: [usize; 6] = [35, 100, 250, 600, 1500, 3000];

/// Points of every line of the plot.
const PLOTTED: usize = 60;

/// One mesh.
pub(crate) struct Sample {
    /// Faces that were asked for.
    pub(crate) asked: usize,
    /// The mesh, which may have fewer.
    pub(crate) surface: TriangleSurface,
    /// How far it is from the field.
    pub(crate) deviation: Deviation,
}

/// All meshes of one cost.
pub(crate) struct Series {
    /// The cost that chose the collapses.
    pub(crate) cost: Cost,
    /// One mesh for each of [`PICTURED`].
    pub(crate) pictured: Vec<Sample>,
    /// Faces and error from the coarsest mesh to the full one, for lines.
    pub(crate) line: Vec<(usize, Deviation)>,
}

/// Repeats the experiment with all costs.
pub(crate) fn repeat(field: &Heightfield) -> Result<Vec<Series>, ClassicError> {
    Cost::ALL.into_iter().map(|cost| series(field, cost)).collect()
}

fn series(field: &Heightfield, cost: Cost) -> Result<Series, ClassicError> {
    let mut mesh = progressive_mesh(field, cost, &mut |_| ())?;
    let mut at = |asked: usize| {
        mesh.set_faces(asked);
        let surface = mesh.mesh().surface();
        Sample { asked, deviation: surface.deviation(field), surface }
    };
    let pictured = PICTURED.into_iter().map(&mut at).collect();
    let full = 2 * (field.columns() - 1) * (field.rows() - 1);
    let mut counts: Vec<usize> = (0..PLOTTED).map(|k| geometric(8.0, full as f64, k)).chain(PICTURED).collect();
    counts.sort_unstable();
    counts.dedup();
    let line = counts.into_iter().map(&mut at).map(|sample| (sample.surface.faces.len(), sample.deviation)).collect();
    Ok(Series { cost, pictured, line })
}

/// Term `k` of [`PLOTTED`] with equal ratios from `first` to `last`.
fn geometric(first: f64, last: f64, k: usize) -> usize {
    (first * (last / first).powf(k as f64 / (PLOTTED - 1) as f64)).round() as usize
}
