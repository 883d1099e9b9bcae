//! The maps of patches of a planet, tile by tile, from the terrain itself.
//!
//! Texels are even in the central projection of a patch onto its face of the cube, which keeps straight edges straight. A texel's normal
//! is that of the ground between its corners, in the frame of
//! [`crate::ground::texture::tangents`].

use super::atlas::Atlas;
use super::{encode_normal, Bitmap};
use crate::globe::patch::PatchId;
use crate::globe::sphere::{normalise, warp_component};
use crate::ground::texture::{albedo, shape};
use crate::ground::{strips, Ground, GroundColour, GroundPoint};
use glam::DVec3;
use rayon::prelude::*;

/// The central projection of a patch: where its sides lie in the warped coordinates of its face.
#[derive(Clone, Copy)]
pub(crate) struct Projection {
    id: PatchId,
    low: [f64; 2],
    size: [f64; 2],
}

impl Projection {
    /// That of a patch.
    pub(crate) fn of(id: PatchId) -> Projection {
        let (u, v) = id.face.grid_axes();
        let ends = |axis: usize| [id.point(0, 0, 1), id.point(1, 1, 1)].map(|point| warp_component(point[axis]));
        let [along, up] = [ends(u), ends(v)];
        Projection { id, low: [along[0], up[0]], size: [along[1] - along[0], up[1] - up[0]] }
    }

    /// Direction of a place in the patch, in shares of its sides.
    fn direction(&self, place: [f64; 2]) -> DVec3 {
        let (u, v) = self.id.face.grid_axes();
        let mut point = [f64::from(self.id.face.sign()); 3];
        point[u] = self.low[0] + place[0] * self.size[0];
        point[v] = self.low[1] + place[1] * self.size[1];
        normalise(point[0], point[1], point[2])
    }

    /// The place of a direction.
    pub(crate) fn place(&self, direction: DVec3) -> [f64; 2] {
        let (along, up) = self.id.face.project(direction);
        [(along - self.low[0]) / self.size[0], (up - self.low[1]) / self.size[1]]
    }
}

/// Albedo and normals of patches, each in the tile of its number.
pub(crate) fn maps(ground: &Ground, colour: &dyn GroundColour, patches: &[PatchId], atlas: &Atlas) -> [Bitmap; 2] {
    let mut maps = [Bitmap::filled(atlas.size, [0; 3]), Bitmap::filled(atlas.size, encode_normal([0.0; 2]))];
    // A few at a time, so that tiles do not take as much memory again as the maps.
    for (first, some) in patches.chunks(rayon::current_num_threads()).enumerate() {
        let tiles: Vec<[Vec<[u8; 3]>; 2]> = some.par_iter().map(|&id| tile(ground, colour, id, atlas)).collect();
        for (k, tile) in tiles.iter().enumerate() {
            let corner = atlas.corner(first * rayon::current_num_threads() + k);
            maps.iter_mut().zip(tile).for_each(|(map, texels)| map.put(corner, atlas.tile, texels));
        }
    }
    maps
}

/// Albedo and normals of one patch alone, `side` texels a side with a gutter, and where places in the patch lie in them.
pub(crate) fn maps_of(ground: &Ground, colour: &dyn GroundColour, id: PatchId, side: u32) -> PatchMaps {
    let atlas = Atlas { size: [side; 2], tile: side };
    let [albedo, normals] = tile(ground, colour, id, &atlas).map(|texels| Bitmap { size: [side; 2], texels });
    PatchMaps { albedo, normals, projection: Projection::of(id), atlas }
}

/// The maps of one patch.
pub(crate) struct PatchMaps {
    pub(crate) albedo: Bitmap,
    pub(crate) normals: Bitmap,
    projection: Projection,
    atlas: Atlas,
}

impl PatchMaps {
    /// The place of a direction in the maps.
    pub(crate) fn place(&self, direction: DVec3) -> [f32; 2] {
        self.atlas.place(0, self.projection.place(direction))
    }
}

/// Albedo and normals of a patch, rows from the top.
fn tile(ground: &Ground, colour: &dyn GroundColour, id: PatchId, atlas: &Atlas) -> [Vec<[u8; 3]>; 2] {
    let (projection, side) = (Projection::of(id), atlas.tile as usize);
    let corners = corners(ground, &projection, atlas);
    let datum = ground.lattice.radius * ground.lattice.unit;
    let spacing = ground.lattice.sample_spacing(atlas.inner(), id.level) * ground.lattice.unit;
    let axis = DVec3::AXES[id.face.grid_axes().0].to_array();
    let (mut points, mut normals) = (Vec::with_capacity(side * side), Vec::with_capacity(side * side));
    for row in 0..side {
        for column in 0..side {
            // The lower row of corners is the one further down in the picture.
            let four = [[0, 1], [1, 1], [0, 0], [1, 0]].map(|[right, down]| (row + down) * (side + 1) + column + right);
            let [p00, p10, p01, p11] = four.map(|k| (corners[k].0 * (datum + corners[k].1)).to_array());
            let (up, [along, across, north]) = shape([p00, p10, p01, p11], axis);
            normals.push(encode_normal([along, across]));
            let height = four.iter().map(|&k| corners[k].1).sum::<f64>() / 4.0;
            points.push(GroundPoint { direction: up.into(), height, slope: along.hypot(across), north, spacing });
        }
    }
    [albedo(colour, &points, side), normals]
}

/// Directions and heights in metres of the corners of a tile's texels, rows from the top.
fn corners(ground: &Ground, projection: &Projection, atlas: &Atlas) -> Vec<(DVec3, f64)> {
    let side = atlas.tile as usize + 1;
    let share = |texels: usize| (texels as f64 - f64::from(atlas.gutter())) / f64::from(atlas.inner());
    let order = strips(side);
    let directions: Vec<DVec3> = order.iter().map(|k| projection.direction([share(k % side), 1.0 - share(k / side)])).collect();
    let heights = ground.metres(&directions);
    let mut corners = vec![(DVec3::ZERO, 0.0); side * side];
    for ((&k, direction), height) in order.iter().zip(directions).zip(heights) {
        corners[k] = (direction, height);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::Face;

    #[test]
    fn places_and_directions_agree_inside_a_patch_and_beside_it() {
        for (face, level, x, y) in [(0, 0, 0, 0), (3, 2, 3, 1), (5, 9, 100, 511)] {
            let id = PatchId::new(Face::ALL[face], level, x, y).unwrap();
            let projection = Projection::of(id);
            for place in [[0.0, 0.0], [1.0, 1.0], [0.25, 0.75], [-0.05, 1.05]] {
                let back = projection.place(projection.direction(place));
                assert!((0..2).all(|k| (back[k] - place[k]).abs() < 1e-9), "{id}: {back:?}, expected {place:?}");
            }
            let corner = crate::globe::sphere::direction(id.point(0, 0, 1));
            assert!(projection.place(corner).iter().all(|share| share.abs() < 1e-9), "{id}");
        }
    }
}
