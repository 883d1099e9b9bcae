//! What encoders know of a mesh: triangles in metres, and what a file says about them.

use super::maps::check_map_side;
use super::maps::heightfield::normal_map;
use super::origin::sidecar;
use super::solid::{self, Floor};
use super::{glb, normals, obj, ply, stl, three_mf, ExportError, Format, Origin, Sidecar, Up};
use glam::DVec3;
use serde_json::json;
use std::borrow::Cow;
use terrane_heightfield::{Heightfield, TriangleSurface};

/// A picture in a GLB file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Its media type, `image/png` or `image/jpeg`.
    pub mime: &'static str,
    /// Its file.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// The picture of a PNG or JPEG file; `None` for the bytes of any other.
    pub fn of_file(bytes: Vec<u8>) -> Option<Picture> {
        let mime = match bytes.as_slice() {
            [0x89, b'P', b'N', b'G', ..] => "image/png",
            [0xff, 0xd8, 0xff, ..] => "image/jpeg",
            _ => return None,
        };
        Some(Picture { mime, bytes })
    }
}

/// Places of vertices in a picture whose corners lie on the corner samples.
fn uvs_over(surface: &TriangleSurface, [columns, rows]: [usize; 2]) -> Vec<[f32; 2]> {
    let last = [columns - 1, rows - 1].map(|count| count as f64);
    let place = |p: &DVec3| [(p.x / last[0]) as f32, (1.0 - p.y / last[1]) as f32];
    surface.positions.iter().map(place).collect()
}

/// Triangles in metres and what a file says about them.
pub struct Model<'a> {
    /// Metres from the origin.
    pub(super) positions: Vec<DVec3>,
    /// A unit vector a vertex, or none at all: flat triangles.
    pub(super) normals: Vec<DVec3>,
    /// A unit vector a vertex, along which the red of a normal map leans, or none. The green leans along normal × tangent.
    pub(super) tangents: Vec<DVec3>,
    /// Places in the pictures, from their upper left corner, or none.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Colour of the ground.
    pub(super) albedo: Option<Picture>,
    /// Normals of the ground, in the frame of normal and tangent.
    pub(super) normal_map: Option<Picture>,
    /// Whether GLB files hold numbers of 16 bits.
    pub(super) quantized: bool,
    /// Corners, counter-clockwise from outside.
    pub(super) triangles: Cow<'a, [[u32; 3]]>,
    /// Unit and axes of the positions, if they are Y-up and if they are Z-up.
    pub(super) axes: [&'static str; 2],
    /// Where the origin is, for people.
    pub(super) provenance: String,
    /// Where it is in a coordinate system.
    pub(super) origin: Option<Origin>,
    /// Decimals that every coordinate fits into; without it as many as it takes to read the same number back.
    pub(super) decimals: Option<usize>,
    /// Where GLB files put the origin.
    pub(super) translation: DVec3,
    /// What GLB files say about the node.
    pub(super) extras: serde_json::Value,
}

impl<'a> Model<'a> {
    /// A surface over a heightfield, from the south-west sample, with the normals of the field. `scale` is metres a sample spacing
    /// east, metres a sample spacing north and metres a unit of height.
    pub fn of_heightfield(surface: &'a TriangleSurface, field: &Heightfield, scale: DVec3) -> Model<'a> {
        Model {
            positions: surface.positions.iter().map(|&p| p * scale).collect(),
            normals: normals::of_heightfield(surface, field, scale),
            triangles: Cow::Borrowed(&surface.faces),
            tangents: Vec::new(),
            uvs: Vec::new(),
            albedo: None,
            normal_map: None,
            quantized: false,
            axes: ["metres, +X east, +Y up, -Z north", "metres, +X east, +Y north, +Z up"],
            provenance: format!("origin at the south-west sample, samples {} m apart east and {} m north", scale.x, scale.y),
            origin: None,
            decimals: None,
            translation: DVec3::ZERO,
            extras: json!({ "axes": "east, north, up (x, y, z) is glTF (x, z, -y)" }),
        }
    }

    /// The solid below a surface over a heightfield: walls, and a floor `below` metres under the lowest vertex. Its triangles are flat.
    pub fn solid(self, below: f64) -> Model<'a> {
        let lowest = self.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        self.closed(&|p| DVec3::new(p.x, p.y, lowest - below), Floor::Flat)
    }

    /// The same with walls, and a floor where `down` puts each vertex.
    pub(super) fn closed(mut self, down: &dyn Fn(DVec3) -> DVec3, floor: Floor) -> Model<'a> {
        solid::close(&mut self.positions, self.triangles.to_mut(), down, floor);
        self.normals.clear();
        self.tangents.clear();
        self.uvs.clear();
        (self.albedo, self.normal_map) = (None, None);
        self.decimals = None;
        self.provenance.push_str(", closed by walls and a floor");
        self
    }

    /// The same surface over a heightfield of so many columns and rows under a picture, the corners of which lie on its corner samples.
    /// Only GLB files hold it.
    pub fn with_picture(mut self, surface: &TriangleSurface, [columns, rows]: [usize; 2], picture: Picture) -> Model<'a> {
        self.uvs = uvs_over(surface, [columns, rows]);
        self.albedo = Some(picture);
        self
    }

    /// The same surface over a heightfield with the normals of the heights as a map, so many texels along its longer side; the vertex
    /// normals then point straight up. Only GLB files hold it. `scale` is that of [`Model::of_heightfield`].
    ///
    /// # Errors
    /// For a side that [`super::check_map_side`] refuses.
    pub fn with_normal_map(
        mut self,
        surface: &TriangleSurface,
        field: &Heightfield,
        scale: DVec3,
        side: u32,
    ) -> Result<Model<'a>, ExportError> {
        check_map_side(side)?;
        self.normal_map = Some(normal_map(field, scale, side).png()?);
        self.uvs = uvs_over(surface, [field.columns(), field.rows()]);
        self.normals = vec![DVec3::Z; self.positions.len()];
        self.tangents = vec![DVec3::X; self.positions.len()];
        Ok(self)
    }

    /// The same with its place in a coordinate system, which every file but STL states.
    pub fn with_origin(mut self, origin: Origin) -> Model<'a> {
        self.provenance = format!("{}, at {}", self.provenance, origin.words());
        self.origin = Some(origin);
        self
    }

    /// What the files beside a mesh say.
    pub fn sidecar(&self, format: Format, up: Up) -> Sidecar {
        let is_moved = format == Format::Glb && self.translation != DVec3::ZERO;
        sidecar(self.origin.as_ref(), self.axes(up), up, is_moved)
    }

    /// The same with 16 bits a number in GLB files.
    pub fn quantized(self) -> Model<'a> {
        Model { quantized: true, ..self }
    }

    /// Cubic metres within a closed mesh: the sum of the tetrahedra between its triangles and one point.
    pub fn volume(&self) -> f64 {
        let from = self.positions.first().copied().unwrap_or_default();
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize] - from);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Directed edges that no opposite edge cancels: 0 for a closed surface.
    pub fn open_edges(&self) -> usize {
        solid::rim(&self.triangles).len()
    }

    /// The bytes of a GLB whose numbers a codec packs.
    ///
    /// # Errors
    /// For a surface without triangles or one that is too large, and where the codec fails.
    pub fn encode_packed(&self, codec: &dyn glb::MeshCodec) -> Result<Vec<u8>, ExportError> {
        if self.triangles.is_empty() {
            return Err(ExportError::Empty);
        }
        glb::encode(self, Some(codec))
    }

    /// Unit and axes of a file.
    pub(super) fn axes(&self, up: Up) -> &'static str {
        match up {
            Up::Y => self.axes[0],
            Up::Z => self.axes[1],
        }
    }

    /// The bytes of a file with an axis up.
    ///
    /// # Errors
    /// For a surface without triangles, one that is too large for the format, one that is open in a format for solids, and a GLB that
    /// is not Y-up.
    pub fn encode(&self, format: Format, up: Up) -> Result<Vec<u8>, ExportError> {
        if self.triangles.is_empty() {
            return Err(ExportError::Empty);
        }
        let open_edges = if format.is_for_solids() { self.open_edges() } else { 0 };
        if open_edges > 0 {
            return Err(ExportError::Open { format: format.name(), open_edges });
        }
        match format {
            Format::Glb if up == Up::Z => Err(ExportError::GltfUp),
            Format::Glb => glb::encode(self, None),
            Format::Obj => Ok(obj::encode(self, up)),
            Format::Ply => ply::encode(self, up),
            Format::Stl => stl::encode(self, up),
            Format::ThreeMf => three_mf::encode(self, up),
        }
    }
}
