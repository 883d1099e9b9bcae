//! One tile: its patch measured, and its GLB.

use super::bounds::TileBox;
use super::certify::{promises, Measured, Promise};
use super::frame::Frame;
use super::grid::Grid;
use super::sea::Sea;
use super::sheet::Sheet;
use super::{TilesError, Watch};
use crate::export::glb::{MeshCodec, Tile, TileMaterial, TilePart};
use crate::export::{check_map_side, maps_of, PatchMaps, Picture};
use crate::globe::patch::PatchId;
use crate::ground::texture::tangents;
use crate::mesh::progressive::PatchMesh;
use crate::planet::Planet;
use crate::store::StoreError;
use glam::DVec3;
use std::collections::HashMap;

/// How many times coarser the drawn ground may be than the patch's own grid is than the next level's.
const THINNING_SHARE: f64 = 0.25;

/// Encodes pictures. Failures are what the encoder says of them.
pub trait PictureCodec: Sync {
    /// A JPEG of texels from the upper left one.
    ///
    /// # Errors
    /// If they cannot be encoded.
    fn jpeg(&self, size: [u32; 2], texels: &[[u8; 3]]) -> Result<Vec<u8>, String>;
}

/// Reads the mesh of a patch, if it is there.
pub type Source<'a> = &'a (dyn Fn(PatchId) -> Result<Option<PatchMesh>, StoreError> + Sync);

/// Makes the tiles of a planet.
pub struct TileMaker<'a> {
    /// The planet.
    pub planet: &'a Planet,
    /// Where its patches are read from; those that are not there are built.
    pub source: Source<'a>,
    /// Texels a side of the maps of a tile, a power of two.
    pub map_side: u32,
    /// Packs numbers.
    pub codec: Option<&'a (dyn MeshCodec + Sync)>,
    /// Encodes maps.
    pub pictures: &'a dyn PictureCodec,
    /// Whether there are walls where tiles end. Only a check of checks leaves them out.
    pub skirts: bool,
}

/// What is known of all tiles before they are made.
pub struct Certified {
    pub(super) tiles: HashMap<PatchId, (Measured, Promise)>,
}

impl Certified {
    /// What is promised of a tile.
    pub fn promise(&self, id: PatchId) -> Option<Promise> {
        self.tiles.get(&id).map(|(_, promise)| *promise)
    }
}

/// A tile's file.
pub(super) struct Content {
    pub(super) bytes: Vec<u8>,
    pub(super) bounds: TileBox,
    pub(super) triangles: usize,
}

/// The triangles of a tile.
struct Shape {
    grid: Grid,
    ground: Sheet,
    sea: Option<Sea>,
}

impl TileMaker<'_> {
    /// Measures all patches of a plan and certifies their tiles; `None` if it was stopped.
    ///
    /// # Errors
    /// If the file cannot be read, or the maps cannot be that large.
    pub fn certify(&self, patches: &[PatchId], watch: &Watch) -> Result<Option<Certified>, TilesError> {
        check_map_side(self.map_side).map_err(TilesError::Maps)?;
        let Some(found) = watch.all(patches, |&id| self.measure(id, 0.0))? else { return Ok(None) };
        let mut measured: HashMap<PatchId, Measured> = patches.iter().copied().zip(found).collect();
        loop {
            let promises = promises(&measured);
            // Deep skirts may need longer steps, which round more, which needs deeper skirts. Steps double, so that this ends.
            let longer: Vec<(PatchId, f64)> = patches
                .iter()
                .map(|&id| (id, promises[&id].skirts.into_iter().fold(0.0, f64::max)))
                .filter(|(id, depth)| Frame::new(*id, measured[id].bounds, *depth).step > measured[id].step)
                .collect();
            if longer.is_empty() {
                let of = |(id, measured)| (id, (measured, promises[&id]));
                return Ok(Some(Certified { tiles: measured.into_iter().map(of).collect() }));
            }
            let Some(found) = watch.all(&longer, |&(id, depth)| self.measure(id, depth))? else { return Ok(None) };
            measured.extend(longer.iter().map(|(id, _)| *id).zip(found));
        }
    }

    fn mesh(&self, id: PatchId) -> Result<PatchMesh, TilesError> {
        let read = (self.source)(id)?;
        Ok(read.unwrap_or_else(|| {
            let ground = self.planet.ground();
            self.planet.survey(id).mesh(&ground).0
        }))
    }

    /// What is to be known of a patch whose skirts are so deep.
    fn measure(&self, id: PatchId, depth: f64) -> Result<Measured, TilesError> {
        let _span = tracing::debug_span!("measure tile", patch = %id).entered();
        let (mesh, lattice) = (self.mesh(id)?, &self.planet.lattice);
        let bounds = [mesh.facts.bounds.low, mesh.facts.bounds.high].map(|corner| corner.as_dvec3() * lattice.unit);
        let grid = Grid::of(&mesh, lattice);
        let (asleep, thinned) = Sheet::asleep_within(&mesh, lattice, &grid, self.tolerance(&mesh));
        let shape = self.shape(&mesh, grid, asleep, thinned);
        let sea = shape.sea.iter().flat_map(|sea| &sea.sheet.positions);
        let bounds = sea.fold(bounds, |[low, high], &p| [low.min(p), high.max(p)]);
        let frame = Frame::new(id, bounds, depth);
        Ok(Measured {
            quarters: mesh.facts.quarters.map(|quarter| quarter.deviation * lattice.unit),
            ground: shape.ground.rounded_deviation(id, &shape.grid, &frame),
            sea: shape.sea.as_ref().map_or(0.0, |sea| sea.error(&frame)),
            step: frame.step,
            bounds,
            asleep,
            thinned,
        })
    }

    /// How far a tile's triangles may lie off its full grid, and off the sea's sphere, before rounding, in metres. What rounding spoils anyway is no
    /// reason for more triangles.
    fn tolerance(&self, mesh: &PatchMesh) -> f64 {
        let lattice = &self.planet.lattice;
        let corners = [mesh.facts.bounds.low, mesh.facts.bounds.high].map(|corner| corner.as_dvec3() * lattice.unit);
        let step = Frame::new(mesh.id, corners, 0.0).step;
        (THINNING_SHARE * mesh.facts.deviation() * lattice.unit).max(step)
    }

    fn shape(&self, mesh: &PatchMesh, grid: Grid, asleep: crate::mesh::wake::Wake, thinned: f64) -> Shape {
        let ground = Sheet::of_ground(mesh, &self.planet.lattice, asleep);
        let sea = Sea::over(self.planet, mesh, &grid, self.tolerance(mesh), thinned);
        Shape { grid, ground, sea }
    }

    /// The file of a certified tile.
    pub(super) fn content(&self, certified: &Certified, id: PatchId) -> Result<Content, TilesError> {
        let _span = tracing::debug_span!("make tile", patch = %id).entered();
        let (measured, promise) = &certified.tiles[&id];
        let mesh = self.mesh(id)?;
        let grid = Grid::of(&mesh, &self.planet.lattice);
        let Shape { ground, sea, .. } = self.shape(&mesh, grid, measured.asleep, measured.thinned);
        let depth = promise.skirts.into_iter().fold(0.0, f64::max);
        let frame = Frame::new(id, measured.bounds, depth);
        let maps = maps_of(&self.planet.ground(), &self.planet.terrain, id, self.map_side);
        let mut bounds = TileBox::empty(id);
        let mut part = |sheet, maps: Option<&PatchMaps>| {
            let part = self.part(id, sheet, &frame, promise, maps)?;
            part.positions.iter().for_each(|&steps| bounds.include(frame.metres(steps)));
            Ok::<TilePart, TilesError>(part)
        };
        let mut parts = vec![part(ground, Some(&maps))?];
        if let Some(sea) = sea {
            parts.push(part(sea.sheet, None)?);
        }
        let triangles = parts.iter().map(|part| part.triangles.len()).sum();
        let tile = Tile { anchor: frame.anchor, step: frame.step, parts };
        let codec = self.codec.map(|codec| codec as &dyn MeshCodec);
        let bytes = tile.encode(codec).map_err(|source| TilesError::Export { id, source })?;
        Ok(Content { bytes, bounds, triangles })
    }

    /// Triangles with skirts and all that a file says of their vertices.
    fn part(
        &self,
        id: PatchId,
        mut sheet: Sheet,
        frame: &Frame,
        promise: &Promise,
        maps: Option<&PatchMaps>,
    ) -> Result<TilePart, TilesError> {
        let above = match self.skirts {
            true => sheet.add_skirts(promise.skirts),
            false => (0..sheet.positions.len() as u32).collect(),
        };
        // A wall is lit and coloured as the ground at its top.
        let ups: Vec<DVec3> = above.iter().map(|&v| sheet.positions[v as usize].normalize_or(DVec3::Z)).collect();
        let jpeg = |map: &crate::export::Bitmap| {
            let bytes = self.pictures.jpeg(map.size, &map.texels).map_err(|problem| TilesError::Picture { id, problem })?;
            Ok::<Picture, TilesError>(Picture { mime: "image/jpeg", bytes })
        };
        let material = match maps {
            Some(maps) => TileMaterial::Ground { albedo: jpeg(&maps.albedo)?, normals: jpeg(&maps.normals)? },
            None => TileMaterial::Water,
        };
        Ok(TilePart {
            positions: sheet.steps(frame),
            tangents: maps.map_or_else(Vec::new, |_| ups.iter().map(|&up| tangents(id, up).0).collect()),
            uvs: maps.map_or_else(Vec::new, |maps| ups.iter().map(|&up| maps.place(up)).collect()),
            normals: ups,
            triangles: sheet.triangles,
            material,
        })
    }
}
