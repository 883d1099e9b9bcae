//! A patch of a planet as it arrives: after each chunk of its record, drawn from what is there. What Hoppe (1996) called progressive
//! transmission, on our data.

use super::canvas::Canvas;
use super::relief::Frame;
use anyhow::Context as _;
use glam::{DVec3, Vec3};
use terrane_heightfield::decimate::mesh::grid_triangles;
use terrane_heightfield::{Heightfield, TriangleSurface};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::mesh::progressive::{MeshPrefix, PatchMesh, Vertex};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;
use terrane_planet::store::geometry::{self, Head};

/// The planet, and the patch: among the mountains of Terra, 20 km across.
const PLANET: &str = "terra";
const SITE: [f64; 2] = [44.78, 54.17];
const LEVEL: u8 = 9;

/// Size of one picture, room below it, and around all.
const CELL: [usize; 2] = [420, 290];
const CAPTION: usize = 64;
const MARGIN: usize = 16;

const PAPER: Vec3 = Vec3::ONE;
const INK: Vec3 = Vec3::new(0.13, 0.15, 0.19);
const FAINT: Vec3 = Vec3::new(0.42, 0.44, 0.48);

/// What there is after a chunk.
pub(crate) struct Moment {
    /// Bytes so far.
    pub(crate) bytes: usize,
    /// Of all.
    pub(crate) of: usize,
    /// Vertices so far.
    pub(crate) vertices: usize,
    /// Triangles that they span.
    pub(crate) triangles: usize,
    /// Largest error at a sample of the whole patch, metres.
    pub(crate) error_m: f64,
    surface: TriangleSurface,
}

/// Builds the patch, and decodes its record after each chunk.
pub(crate) fn arrive() -> anyhow::Result<(PatchMesh, Vec<Moment>)> {
    let recipe = shipped::load(PLANET)?;
    let planet = Planet::from_recipe(recipe, 64)?;
    let id = PatchId::containing(direction_at(SITE[0], SITE[1]), LEVEL);
    let (mesh, ..) = planet.build(id);
    let record = geometry::encode(&mesh)?;
    let head = Head::read(&record, id, mesh.cells)?;
    let (unit, spacing) = (planet.lattice.unit, planet.lattice.sample_spacing(mesh.cells, LEVEL));
    let whole = MeshPrefix::from(mesh.clone());
    let field = field(&surface(&whole, spacing), mesh.cells)?;
    let moment = |chunks: usize| {
        let bytes = head.bytes_of(chunks);
        // Nothing that follows is there yet.
        let prefix = geometry::decode_chunks(&head, &record[..bytes], id, mesh.cells, chunks)?;
        let surface = surface(&prefix, spacing);
        let error_m = surface.deviation(&field).max * spacing * unit;
        Ok(Moment {
            bytes,
            of: record.len(),
            vertices: prefix.mesh.vertices.len(),
            triangles: surface.faces.len(),
            error_m,
            surface,
        })
    };
    let moments = (1..=head.chunks.len()).map(moment).collect::<anyhow::Result<_>>()?;
    Ok((mesh, moments))
}

/// All that is there, awake: every vertex that is not falls to its first ancestor that is. In sample spacings.
fn surface(prefix: &MeshPrefix, spacing: f64) -> TriangleSurface {
    let side = prefix.mesh.cells as usize + 1;
    let position = |vertex: &Vertex| {
        let grid = usize::from(vertex.grid);
        DVec3::new((grid % side) as f64, (grid / side) as f64, f64::from(vertex.height) / spacing)
    };
    let fall = |triangle: [u32; 3]| triangle.map(|corner| u32::from(prefix.falls[corner as usize]));
    let faces = grid_triangles(prefix.mesh.cells).into_iter().map(fall).filter(|[a, b, c]| a != b && b != c && c != a);
    TriangleSurface { positions: prefix.mesh.vertices.iter().map(position).collect(), faces: faces.collect() }
}

/// The samples of a whole patch, by rows from the north.
fn field(whole: &TriangleSurface, cells: u32) -> anyhow::Result<Heightfield> {
    let side = cells as usize + 1;
    let mut heights = vec![0.0; side * side];
    whole.positions.iter().for_each(|p| heights[(side - 1 - p.y as usize) * side + p.x as usize] = p.z as f32);
    Heightfield::new(side, side, heights).context("a patch is a grid")
}

/// Draws what there is after each chunk, side by side.
pub(crate) fn draw(mesh: &PatchMesh, moments: &[Moment]) -> Canvas {
    let mut canvas = Canvas::new([2 * MARGIN + moments.len() * CELL[0], 2 * MARGIN + CELL[1] + CAPTION], PAPER);
    let heights = moments.last().map_or([0.0; 2], |whole| {
        let z = || whole.surface.positions.iter().map(|p| p.z);
        [z().fold(f64::INFINITY, f64::min), z().fold(f64::NEG_INFINITY, f64::max)]
    });
    for (k, moment) in moments.iter().enumerate() {
        let corner = [(MARGIN + k * CELL[0]) as f64, MARGIN as f64];
        let frame = Frame { corner, size: CELL.map(|s| s as f64), width: f64::from(mesh.cells), heights };
        frame.draw(&mut canvas, &moment.surface);
        let share = 100.0 * moment.bytes as f64 / moment.of as f64;
        let at = [corner[0] + 16.0, corner[1] + CELL[1] as f64];
        let lines = [
            (INK, format!("{} bytes ({share:.0} %)", moment.bytes)),
            (INK, format!("{} triangles", moment.triangles)),
            (FAINT, format!("at most {:.1} m off", moment.error_m)),
        ];
        for (line, (ink, text)) in lines.iter().enumerate() {
            canvas.text([at[0], at[1] + 20.0 * line as f64], 2.0, text, *ink);
        }
    }
    canvas
}
