//! A site that patches share has the same position bits in each: on sides, over cube edges and corners, in parents and children.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its patch has failed")]

use crate::common::TestField;
use glam::IVec3;
use proptest::prelude::*;
use std::collections::HashSet;
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::Face;
use terrane_planet::ground::HeightGrid;
use terrane_planet::mesh::border_rules::vertex_on_side;
use terrane_planet::mesh::progressive::PatchMesh;

const CELLS: u32 = 16;

fn field() -> TestField {
    TestField { radius: 6_371_000.0, roughness: 0.002, ridged: true, seed: 11 }
}

/// Lattice positions of a patch's whole grid, by vertex number.
fn grid_positions(field: &TestField, id: PatchId) -> Vec<IVec3> {
    let ground = field.ground(CELLS);
    let grid = HeightGrid::sample(&ground, id);
    let n = CELLS as i32;
    (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| grid.position(&ground.lattice, 2 * i, 2 * j)).collect()
}

fn side_positions(positions: &[IVec3], side: Side) -> Vec<IVec3> {
    (0..=CELLS as usize).map(|k| positions[vertex_on_side(side, k, CELLS as usize)]).collect()
}

/// Patches of any level; half of them touch a face edge or corner.
fn any_patch() -> impl Strategy<Value = PatchId> {
    (0u8..6, 0u8..=18, any::<u32>(), any::<u32>(), 0u8..8).prop_map(|(face, level, x, y, pull)| {
        let last = (1u32 << level) - 1;
        let at = |value: u32, low: u8, high: u8| match pull {
            p if p & low != 0 => 0,
            p if p & high != 0 => last,
            _ => value & last,
        };
        PatchId::new(Face::new(face).unwrap(), level, at(x, 1, 2), at(y, 4, 2)).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn neighbours_hold_the_same_bits_along_their_side(id in any_patch()) {
        let field = field();
        let ours = grid_positions(&field, id);
        for side in Side::ALL {
            let line = side_positions(&ours, side);
            let theirs = grid_positions(&field, id.neighbour(side));
            let matching = Side::ALL.into_iter().filter(|&s| side_positions(&theirs, s) == line).count();
            prop_assert_eq!(matching, 1, "{} {:?}", id, side);
        }
    }

    #[test]
    fn children_hold_their_parents_samples(id in any_patch()) {
        let field = field();
        let ours = grid_positions(&field, id);
        let row = CELLS as usize + 1;
        for (k, child) in id.children().unwrap().into_iter().enumerate() {
            let theirs = grid_positions(&field, child);
            let (ox, oy) = (k % 2 * CELLS as usize / 2, k / 2 * CELLS as usize / 2);
            for j in 0..=CELLS as usize / 2 {
                for i in 0..=CELLS as usize / 2 {
                    prop_assert_eq!(theirs[2 * j * row + 2 * i], ours[(oy + j) * row + ox + i]);
                }
            }
        }
    }
}

#[test]
fn the_eight_cube_corners_are_one_point_for_three_faces() {
    let field = field();
    let mut corners = HashSet::new();
    for root in PatchId::roots() {
        let positions = grid_positions(&field, root);
        corners.extend([Side::Bottom, Side::Top].into_iter().flat_map(|side| {
            let line = side_positions(&positions, side);
            [line[0], line[CELLS as usize]]
        }));
    }
    assert_eq!(corners.len(), 8);
}

#[test]
fn what_the_gpu_gets_is_what_the_builder_measured() {
    let field = field();
    let ground = field.ground(CELLS);
    for id in PatchId::roots().filter_map(|root| root.children()).flatten() {
        let grid = HeightGrid::sample(&ground, id);
        let (mesh, _) = PatchMesh::build(&ground, &grid);
        let positions = grid_positions(&field, id);
        for vertex in PatchVertex::of_patch(&mesh, &ground.lattice) {
            assert_eq!(IVec3::from_array(vertex.position), positions[vertex.grid() as usize]);
        }
    }
}
