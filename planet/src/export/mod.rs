//! Meshes for other programs, as GLB, OBJ, PLY, STL or 3MF: exactly the triangles that a view draws, or a surface over a heightfield.
//!
//! In: stored patches and a view, or a triangle surface. Out: the bytes of a file. The CPU twins decide the triangles of a view,
//! so that no GPU is needed; the vertices of all patches are welded by their lattice positions.
//!
//! OBJ, PLY and 3MF hold metres without any rounding. On a planet a lattice unit is a power of two, so every position is a finite
//! decimal (OBJ) and a double (PLY); the axes are the planet's: +Z north, +X towards longitude 0, +Y towards 90° east. Over a
//! heightfield +X is east, +Y north and +Z up. GLB and STL hold single precision. Files may be turned to Y-up ([`Up`]), as GLB always
//! is. Normals are those of the heights, so that they do not depend on the triangles; GLB files may hold them as a map instead, and the
//! albedo of a planet with it.

mod format;
pub mod glb;
mod maps;
mod model;
mod normals;
pub mod obj;
mod origin;
mod placed;
pub mod ply;
pub mod raster;
mod solid;
pub mod stl;
mod surface;
pub mod three_mf;

pub use format::{ExportError, Format, Up, EXTENSIONS};
pub(crate) use maps::planet::{maps_of, PatchMaps};
pub(crate) use maps::Bitmap;
pub use maps::{check_map_side, MAP_SIDES};
pub use model::{Model, Picture};
pub use origin::{Origin, Sidecar};
pub use placed::{origin_near, Placed};
pub use surface::{view_surface, Part, Welded};
