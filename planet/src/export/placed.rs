//! A planet's welded surface, and the point that its coordinates start from.

use super::maps::atlas::Atlas;
use super::maps::check_map_side;
use super::maps::planet::{self, Projection};
use super::solid::Floor;
use super::{normals, obj, ExportError, Format, Model, Origin, Up, Welded};
use crate::globe::lattice::Lattice;
use crate::globe::patch::PatchId;
use crate::ground::texture::tangents;
use crate::ground::{Ground, GroundColour};
use glam::{DVec3, IVec3};
use serde_json::json;
use std::borrow::Cow;
use std::collections::HashMap;

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
            tangents: Vec::new(),
            uvs: Vec::new(),
            albedo: None,
            normal_map: None,
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

    /// The same with maps of the ground's albedo and normals, so many texels a side; its vertex normals point away from the planet's
    /// centre. Every patch has a tile of the maps, so that vertices on borders are there once a patch. Only GLB files hold maps.
    ///
    /// # Errors
    /// For a side that [`check_map_side`] refuses, and for more patches than such maps have tiles.
    pub fn model_with_maps(&self, ground: &Ground, colour: &dyn GroundColour, side: u32) -> Result<Model<'a>, ExportError> {
        check_map_side(side)?;
        let parts = &self.surface.parts;
        let atlas = Atlas::new(parts.len(), side)?;
        let ids: Vec<PatchId> = parts.iter().map(|part| part.id).collect();
        let [albedo, normals] = planet::maps(ground, colour, &ids, &atlas);
        let mut model = self.model();
        (model.positions, model.triangles) = (Vec::new(), Cow::Owned(Vec::with_capacity(self.surface.triangles.len())));
        for (number, part) in parts.iter().enumerate() {
            let projection = Projection::of(part.id);
            let mut known: HashMap<u32, u32> = HashMap::new();
            let mut add = |v: u32| {
                let next = model.positions.len() as u32;
                let number_of = *known.entry(v).or_insert(next);
                if number_of == next {
                    let position = self.surface.positions[v as usize];
                    let up = position.as_dvec3().normalize_or(DVec3::Z);
                    model.positions.push(self.metres(position));
                    model.normals.push(up);
                    model.tangents.push(tangents(part.id, up).0);
                    model.uvs.push(atlas.place(number, projection.place(up)));
                }
                number_of
            };
            let split = self.surface.triangles[part.triangles.clone()].iter().map(|t| t.map(&mut add));
            model.triangles.to_mut().extend(split);
        }
        (model.albedo, model.normal_map) = (Some(albedo.png()?), Some(normals.png()?));
        Ok(model)
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
