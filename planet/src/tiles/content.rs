//! One tile: its patch measured, and its GLB.

use super::bounds::TileBox;
use super::certify::{promises, Measured, Promise};
use super::frame::Frame;
use super::grid::Grid;
use super::sea::Sea;
use super::sheet::{Sheet, Skirts};
use super::{TilesError, Watch};
use crate::export::glb::{MeshCodec, Tile, TileMaterial, TilePart};
use crate::export::{check_map_side, maps_of, PatchMaps, Picture};
use crate::globe::patch::PatchId;
use crate::ground::texture::tangents;
use crate::mesh::progressive::PatchMesh;
use crate::mesh::wake::Wake;
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
                .map(|&id| (id, promises[&id].reach()))
                .filter(|(id, reach)| {
                    let needed = measured[id].bounds.map(|bounds| frame(*id, bounds, *reach).step);
                    needed.iter().zip(measured[id].steps).any(|(needed, step)| *needed > step)
                })
                .collect();
            if longer.is_empty() {
                let of = |(id, measured)| (id, (measured, promises[&id]));
                return Ok(Some(Certified { tiles: measured.into_iter().map(of).collect() }));
            }
            let Some(found) = watch.all(&longer, |&(id, reach)| self.measure(id, reach))? else { return Ok(None) };
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

    /// What is to be known of a patch whose skirts reach so far.
    fn measure(&self, id: PatchId, reach: f64) -> Result<Measured, TilesError> {
        let _span = tracing::debug_span!("measure tile", patch = %id).entered();
        let (mesh, lattice) = (self.mesh(id)?, &self.planet.lattice);
        let grid = Grid::of(&mesh, lattice);
        let asleep = Sheet::asleep_within(&mesh, lattice, &grid, self.tolerance(&mesh));
        let shape = self.shape(&mesh, grid, asleep);
        let ground = shape.ground.bounds();
        let bounds = [ground, shape.sea.as_ref().map_or(ground, |sea| sea.sheet.bounds())];
        let frames = bounds.map(|bounds| frame(id, bounds, reach));
        Ok(Measured {
            quarters: mesh.facts.quarters.map(|quarter| quarter.deviation * lattice.unit),
            ground: shape.ground.rounded_deviation(id, &shape.grid, &frames[0]),
            sea: shape.sea.as_ref().map_or(0.0, |sea| sea.error(&frames[1])),
            steps: frames.map(|frame| frame.step),
            bounds,
            asleep,
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

    fn shape(&self, mesh: &PatchMesh, grid: Grid, asleep: Wake) -> Shape {
        let ground = Sheet::of_ground(mesh, &self.planet.lattice, asleep);
        let sea = Sea::over(self.planet, mesh, &grid, self.tolerance(mesh));
        Shape { grid, ground, sea }
    }

    /// The file of a certified tile.
    pub(super) fn content(&self, certified: &Certified, id: PatchId) -> Result<Content, TilesError> {
        let _span = tracing::debug_span!("make tile", patch = %id).entered();
        let (measured, promise) = &certified.tiles[&id];
        let mesh = self.mesh(id)?;
        let grid = Grid::of(&mesh, &self.planet.lattice);
        let Shape { ground, sea, .. } = self.shape(&mesh, grid, measured.asleep);
        let maps = maps_of(&self.planet.ground(), &self.planet.terrain, id, self.map_side);
        let parts = self.parts(id, [Some(ground), sea.map(|sea| sea.sheet)], measured, promise, &maps);
        let mut bounds = TileBox::empty(id);
        parts.iter().for_each(|part| part.positions.iter().for_each(|p| bounds.include(part.anchor + p.as_dvec3() * part.step)));
        let triangles = parts.iter().map(|part| part.triangles.len()).sum();
        let jpeg = |map: &crate::export::Bitmap| {
            let bytes = self.pictures.jpeg(map.size, &map.texels).map_err(|problem| TilesError::Picture { id, problem })?;
            Ok::<Picture, TilesError>(Picture { mime: "image/jpeg", bytes })
        };
        let tile = Tile { parts, maps: [jpeg(&maps.albedo)?, jpeg(&maps.normals)?] };
        let codec = self.codec.map(|codec| codec as &dyn MeshCodec);
        let bytes = tile.encode(codec).map_err(|source| TilesError::Export { id, source })?;
        Ok(Content { bytes, bounds, triangles })
    }

    /// Ground and sea with their skirts, and the walls of the ground that go deeper than their numbers reach.
    fn parts(
        &self,
        id: PatchId,
        sheets: [Option<Sheet>; 2],
        measured: &Measured,
        promise: &Promise,
        maps: &PatchMaps,
    ) -> Vec<TilePart> {
        let skirts = Skirts { depths: promise.skirts, flare: promise.flare() };
        let part = |sheet: Sheet, above: &[u32], tops: &[DVec3], frame: &Frame, maps: Option<&PatchMaps>| {
            // A wall is lit and coloured as the ground at its top.
            let ups: Vec<DVec3> = above.iter().map(|&v| tops[v as usize].normalize_or(DVec3::Z)).collect();
            TilePart {
                anchor: frame.anchor,
                step: frame.step,
                positions: sheet.steps(frame),
                tangents: maps.map_or_else(Vec::new, |_| ups.iter().map(|&up| tangents(id, up).0).collect()),
                uvs: maps.map_or_else(Vec::new, |maps| ups.iter().map(|&up| maps.place(up)).collect()),
                normals: ups,
                triangles: sheet.triangles,
                material: if maps.is_some() { TileMaterial::Ground } else { TileMaterial::Water },
            }
        };
        let mut parts = Vec::new();
        for (sheet, (bounds, maps)) in sheets.into_iter().zip(measured.bounds.into_iter().zip([Some(maps), None])) {
            let Some(mut sheet) = sheet else { continue };
            let near = frame(id, bounds, promise.reach());
            let shallow = skirts.within(shallow(bounds, promise.reach()));
            let far = Frame::new(id, bounds, 1.01 * promise.reach());
            let deeper = Skirts { depths: skirts.depths.map(|depth| depth + 4.0 * far.step), ..skirts };
            let is_deep = self.skirts && maps.is_some() && shallow != skirts;
            let walls = is_deep.then(|| sheet.deep_skirts(&shallow, &deeper, &far));
            let above = match self.skirts {
                true => sheet.add_skirts(&shallow, &near),
                false => (0..sheet.positions.len() as u32).collect(),
            };
            let tops = sheet.positions.clone();
            parts.push(part(sheet, &above, &tops, &near, maps));
            if let Some((walls, above)) = walls.filter(|(walls, _)| !walls.triangles.is_empty()) {
                parts.push(part(walls, &above, &tops, &far, maps));
            }
        }
        parts
    }
}

/// Half of the longest side of a box.
fn half(bounds: [DVec3; 2]) -> f64 {
    (bounds[1] - bounds[0]).max_element() / 2.0
}

/// The frame of a tile's ground and sea whose skirts reach so far. Deep skirts have numbers of their own: theirs would be too coarse for the ground.
fn frame(id: PatchId, bounds: [DVec3; 2], reach: f64) -> Frame {
    Frame::new(id, bounds, reach.min(half(bounds)))
}

/// How deep skirts in that frame may be.
fn shallow(bounds: [DVec3; 2], reach: f64) -> f64 {
    if reach <= half(bounds) {
        f64::INFINITY
    } else {
        half(bounds) / 2.0
    }
}
