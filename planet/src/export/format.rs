//! The mesh formats, the axes that their files are in, and why one cannot be written.

use super::MAP_SIDES;
use std::path::Path;
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
    /// A surface with a rim in a format for solids.
    #[error("{format} files are for printing and hold solids, but this surface has {open_edges} open edges; add --solid METRES")]
    Open {
        /// The format.
        format: &'static str,
        /// Edges with a triangle on one side only.
        open_edges: usize,
    },
    /// glTF with another axis up.
    #[error("glTF is Y-up by its specification; leave out --up z, or write OBJ or PLY")]
    GltfUp,
    /// A size that maps cannot have.
    #[error("maps of {side} texels a side, expected a power of two from {} to {}", MAP_SIDES.start(), MAP_SIDES.end())]
    MapSide {
        /// Texels of the longer side.
        side: u32,
    },
    /// More patches than maps have room for.
    #[error("{patches} patches are too many for maps of {side} texels a side, which hold {most}; ask for larger maps, or for a coarser mesh")]
    MapTiles {
        /// Patches of the mesh.
        patches: usize,
        /// Texels of the longer side.
        side: u32,
        /// How many patches fit.
        most: usize,
    },
    /// A map that cannot be encoded.
    #[error("cannot encode a map as PNG: {problem}; please report this")]
    Map {
        /// What its writer said.
        problem: String,
    },
    /// Numbers that a codec cannot pack.
    #[error("cannot pack the mesh: {problem}; write it unpacked, and please report this")]
    Codec {
        /// What the codec said.
        problem: String,
    },
    /// An archive that cannot be made.
    #[error("cannot pack the 3MF archive: {problem}; please report this")]
    Archive {
        /// What its writer said.
        problem: String,
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
    /// Binary STL, for solids.
    Stl,
    /// 3D Manufacturing Format, for solids.
    ThreeMf,
}

/// The extensions of all formats, for messages and help texts.
pub const EXTENSIONS: &str = ".glb, .obj, .ply, .stl or .3mf";

impl Format {
    /// All formats.
    pub const ALL: [Format; 5] = [Format::Glb, Format::Obj, Format::Ply, Format::Stl, Format::ThreeMf];

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
            Format::Stl => "STL",
            Format::ThreeMf => "3MF",
        }
    }

    /// The axis that programs take to point up when they open a file with their own defaults.
    pub fn usual_up(self) -> Up {
        match self {
            Format::Glb | Format::Obj => Up::Y,
            Format::Ply | Format::Stl | Format::ThreeMf => Up::Z,
        }
    }

    /// Whether its files are for printers, which need solids.
    pub fn is_for_solids(self) -> bool {
        matches!(self, Format::Stl | Format::ThreeMf)
    }
}

/// The axis of a file that points up; on a planet in planet-fixed axes, north.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// (x, y, z) becomes (x, z, -y), a turn by -90° about X.
    Y,
    /// Positions as they are here.
    Z,
}

impl Up {
    /// A vector in the axes of a file. No negative zero, which some validators dislike.
    pub fn turn(self, v: glam::DVec3) -> glam::DVec3 {
        match self {
            Up::Y => glam::DVec3::new(v.x, v.z, 0.0 - v.y),
            Up::Z => v,
        }
    }
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
