//! A planet's welded surface, and the point that its coordinates start from.

use super::solid::Floor;
use super::{normals, obj, ExportError, Format, Model, Origin, Up, Welded};
use crate::globe::lattice::Lattice;
use crate::ground::Ground;
use glam::{DVec3, IVec3};
use serde_json::json;
use std::borrow::Cow;

/// A welded surface and the point that its coordinates start from.
pub struct Placed<'a> {
    /// Triangles and lattice positions.
    pub surface: &'a Welded,
    /// Lattice point that becomes 0, 0, 0: zero for planet-centred coordinates.
    pub origin: IVec3,
    /// The planet's lattice.
    pub lattice: Lattice,
}

impl<'a> Placed<'a> {
    /// A vertex in metres from the origin. Exact: differences have 32 bits, and the unit is a power of two.
    pub fn metres(&self, position: IVec3) -> DVec3 {
        (position.as_dvec3() - self.origin.as_dvec3()) * self.lattice.unit
    }

    /// Where the origin lies on the planet.
    pub fn origin(&self) -> Origin {
        Origin::of_planet(self.lattice.radius * self.lattice.unit, self.origin.as_dvec3() * self.lattice.unit)
    }

    /// Largest coordinate in metres, by magnitude.
    pub fn largest_coordinate(&self) -> f64 {
        self.surface.positions.iter().map(|&p| self.metres(p).abs().max_element()).fold(0.0, f64::max)
    }

    /// The bytes of a file without normals.
    ///
    /// # Errors
    /// As [`Model::encode`].
    pub fn encode(&self, format: Format, up: Up) -> Result<Vec<u8>, ExportError> {
        self.model().encode(format, up)
    }

    /// What encoders need of it, without normals.
    pub fn model(&self) -> Model<'a> {
        let [x, y, z] = self.origin.to_array();
        let unit = self.lattice.unit;
        Model {
            positions: self.surface.positions.iter().map(|&p| self.metres(p)).collect(),
            normals: Vec::new(),
            triangles: Cow::Borrowed(&self.surface.triangles),
            uvs: Vec::new(),
            albedo: None,
            quantized: false,
            axes: [
                "planet-fixed metres, +Y north, +X longitude 0, -Z 90 degrees east",
                "planet-fixed metres, +Z north, +X longitude 0",
            ],
            provenance: format!("origin at lattice {x} {y} {z} from the planet's centre, lattice unit {unit} m"),
            origin: Some(self.origin()),
            decimals: Some(obj::decimals(unit)),
            translation: self.origin.as_dvec3() * unit,
            extras: json!({ "origin_lattice": [x, y, z], "unit_m": unit, "axes": "planet (x, y, z) is glTF (x, z, -y)" }),
        }
    }

    /// The same with the normals of the heights, as far apart as the samples of the finest patch at each vertex.
    pub fn model_with_normals(&self, ground: &Ground) -> Model<'a> {
        Model { normals: normals::of_planet(self.surface, ground), ..self.model() }
    }

    /// The solid below it: walls towards the planet's centre, and a floor `below` metres under the lowest vertex.
    pub fn solid(&self, below: f64) -> Model<'a> {
        let centre = self.metres(IVec3::ZERO);
        let lowest = self.surface.positions.iter().map(|&p| self.metres(p).distance(centre)).fold(f64::INFINITY, f64::min);
        let floor = (lowest - below).max(0.0);
        self.model().closed(&|p| centre + (p - centre).normalize_or_zero() * floor, Floor::Curved)
    }
}

/// The lattice point near a view's anchor to measure from: a multiple of 64 units, which makes its coordinates in metres exact
/// in single precision too (they have 30 bits, of which the last 6 are 0).
pub fn origin_near(anchor: [i32; 3]) -> IVec3 {
    IVec3::from_array(anchor.map(|c| c & !63))
}
