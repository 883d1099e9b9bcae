//! Meshes for other programs, as OBJ, PLY or GLB: exactly the triangles that a view draws, or a surface over a heightfield.
//!
//! In: stored patches and a view, or a triangle surface. Out: the bytes of a file. The CPU twins decide the triangles of a view,
//! so that no GPU is needed; the vertices of all patches are welded by their lattice positions.
//!
//! OBJ and PLY hold metres without any rounding. On a planet a lattice unit is a power of two, so every position is a finite
//! decimal (OBJ) and a double (PLY); the axes are the planet's: +Z north, +X towards longitude 0, +Y towards 90° east. Over a
//! heightfield +X is east, +Y north and +Z up. GLB holds single precision only and is Y-up, see [`glb`].

pub mod glb;
pub mod obj;
pub mod ply;
mod surface;

pub use surface::{view_surface, Welded};

use crate::globe::lattice::Lattice;
use glam::{DVec3, IVec3};
use serde_json::json;
use std::path::Path;
use terrane_heightfield::TriangleSurface;
use thiserror::Error;

/// Why a mesh cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ExportError {
    /// A file name that says nothing, or something else.
    #[error("'{file}': its extension names no mesh format; expected {EXTENSIONS}")]
    UnknownFormat {
        /// The file name.
        file: String,
    },
    /// Nothing to write.
    #[error("the view draws no triangle; point the camera at the ground, or ask for the whole planet")]
    Empty,
    /// More than a format can count.
    #[error("{what} of {found}, but {format} files hold at most {most}; ask for a coarser mesh or write another format")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much there is.
        found: u64,
        /// The format.
        format: &'static str,
        /// How much fits.
        most: u64,
    },
}

/// A mesh format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// Binary PLY 1.0.
    Ply,
}

/// The extensions of all formats, for messages and help texts.
pub const EXTENSIONS: &str = ".glb, .obj or .ply";

impl Format {
    /// All formats.
    pub const ALL: [Format; 3] = [Format::Glb, Format::Obj, Format::Ply];

    /// The format that a file name's extension asks for.
    ///
    /// # Errors
    /// For any but one of [`EXTENSIONS`], in whatever case.
    pub fn of(path: &Path) -> Result<Format, ExportError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_uppercase());
        let found = Format::ALL.into_iter().find(|format| extension.as_deref() == Some(format.name()));
        found.ok_or_else(|| ExportError::UnknownFormat { file: path.display().to_string() })
    }

    /// Its name in messages, which is its extension in capitals.
    pub fn name(self) -> &'static str {
        match self {
            Format::Glb => "GLB",
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
        }
    }
}

/// A welded surface and the point that its coordinates start from.
pub struct Placed<'a> {
    /// Triangles and lattice positions.
    pub surface: &'a Welded,
    /// Lattice point that becomes 0, 0, 0: zero for planet-centred coordinates.
    pub origin: IVec3,
    /// The planet's lattice.
    pub lattice: Lattice,
}

impl Placed<'_> {
    /// A vertex in metres from the origin. Exact: differences have 32 bits, and the unit is a power of two.
    pub fn metres(&self, position: IVec3) -> DVec3 {
        (position.as_dvec3() - self.origin.as_dvec3()) * self.lattice.unit
    }

    /// Largest coordinate in metres, by magnitude.
    pub fn largest_coordinate(&self) -> f64 {
        self.surface.positions.iter().map(|&p| self.metres(p).abs().max_element()).fold(0.0, f64::max)
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// For a surface without triangles, or one that is too large for the format.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>, ExportError> {
        self.model().encode(format)
    }

    /// What encoders need of it.
    fn model(&self) -> Model<'_> {
        let [x, y, z] = self.origin.to_array();
        let unit = self.lattice.unit;
        Model {
            positions: self.surface.positions.iter().map(|&p| self.metres(p)).collect(),
            triangles: &self.surface.triangles,
            axes: "planet-fixed metres, +Z north, +X longitude 0",
            provenance: format!("origin at lattice {x} {y} {z} from the planet's centre, lattice unit {unit} m"),
            decimals: Some(obj::decimals(unit)),
            translation: self.origin.as_dvec3() * unit,
            extras: json!({ "origin_lattice": [x, y, z], "unit_m": unit, "axes": "planet (x, y, z) is glTF (x, z, -y)" }),
        }
    }
}

/// Triangles in metres and what a file says about them: all that the encoders know.
pub struct Model<'a> {
    positions: Vec<DVec3>,
    triangles: &'a [[u32; 3]],
    /// Unit and axes of the positions.
    axes: &'static str,
    /// Where the origin is, for people.
    provenance: String,
    /// Decimals that every coordinate fits into; without it as many as it takes to read the same number back.
    decimals: Option<usize>,
    /// Where GLB files put the origin.
    translation: DVec3,
    /// What GLB files say about the node.
    extras: serde_json::Value,
}

impl<'a> Model<'a> {
    /// A surface over a heightfield, from the south-west sample. `scale` is metres a sample spacing east, metres a sample
    /// spacing north and metres a unit of height.
    pub fn of_heightfield(surface: &'a TriangleSurface, scale: DVec3) -> Model<'a> {
        Model {
            positions: surface.positions.iter().map(|&p| p * scale).collect(),
            triangles: &surface.faces,
            axes: "metres, +X east, +Y north, +Z up",
            provenance: format!("origin at the south-west sample, samples {} m apart east and {} m north", scale.x, scale.y),
            decimals: None,
            translation: DVec3::ZERO,
            extras: json!({ "axes": "east, north, up (x, y, z) is glTF (x, z, -y)" }),
        }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// For a surface without triangles, or one that is too large for the format.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>, ExportError> {
        if self.triangles.is_empty() {
            return Err(ExportError::Empty);
        }
        match format {
            Format::Glb => glb::encode(self),
            Format::Obj => Ok(obj::encode(self)),
            Format::Ply => ply::encode(self),
        }
    }
}

/// The lattice point near a view's anchor to measure from: a multiple of 64 units, which makes its coordinates in metres exact
/// in single precision too (they have 30 bits, of which the last 6 are 0).
pub fn origin_near(anchor: [i32; 3]) -> IVec3 {
    IVec3::from_array(anchor.map(|c| c & !63))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_is_known_by_its_extension_and_listed() {
        for format in Format::ALL {
            let extension = format!(".{}", format.name().to_lowercase());
            assert_eq!(Format::of(Path::new(&format!("a{extension}"))), Ok(format));
            assert!(EXTENSIONS.contains(&extension), "{EXTENSIONS} lacks {extension}");
        }
        assert_eq!(EXTENSIONS.matches('.').count(), Format::ALL.len());
    }
}
