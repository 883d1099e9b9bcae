//! Edge collapses, vertex splits and the progressive mesh of half-edge collapses.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use glam::DVec3;
use proptest::prelude::*;
use terrane_heightfield::classic::{euler_characteristic, ClassicError, FaceMesh, ProgressiveMesh, Refusal, VertexSplit, NONE};
use terrane_heightfield::Heightfield;

fn grid(columns: usize, rows: usize) -> FaceMesh {
    FaceMesh::from_heightfield(&bumpy(columns, rows))
}

/// A field on which no two heights are equal.
fn bumpy(columns: usize, rows: usize) -> Heightfield {
    let heights = (0..columns * rows).map(|i| (i as u32).wrapping_mul(2_654_435_761) as f32 / 1e9).collect();
    Heightfield::new(columns, rows, heights).unwrap()
}

fn split_of(mesh: &FaceMesh, vt: u32, vu: u32) -> Result<VertexSplit, Refusal> {
    VertexSplit::of_edge(mesh, vt, vu, mesh.positions[vt as usize])
}

/// Collapses an edge, checks the result and splits it again.
fn there_and_back(mesh: &FaceMesh, vt: u32, vu: u32) -> VertexSplit {
    let split = split_of(mesh, vt, vu).unwrap();
    let mut work = mesh.clone();
    let sides = |mesh: &FaceMesh, face: u32| (face != NONE).then(|| mesh.faces[face as usize]);
    let third = |face: u32| sides(mesh, face).map_or(NONE, |f| f.into_iter().find(|v| ![vt, vu].contains(v)).unwrap());
    split.ecol(&mut work);
    assert_eq!(work.validate(), Ok(()));
    assert_eq!(euler_characteristic(&work), 1);
    assert_eq!(work.living_faces().count(), mesh.living_faces().count() - split.new_faces());
    assert_eq!(split.side_vertices(&work), [third(split.fl), third(split.fr)], "vl and vr are inferred");
    split.vsplit(&mut work);
    assert_eq!(work.validate(), Ok(()));
    assert_eq!(work.positions, mesh.positions);
    let turned = |face: &[u32; 3]| {
        let mut face = *face;
        let lowest = (0..3).min_by_key(|&k| face[k]).unwrap();
        face.rotate_left(lowest);
        face
    };
    assert!(work.faces.iter().map(turned).eq(mesh.faces.iter().map(turned)));
    split
}

#[test]
fn an_inner_split_has_all_of_its_neighbour_faces() {
    let split = there_and_back(&grid(5, 5), 12, 13);
    assert!(![split.fl, split.fr].contains(&NONE) && !split.f.contains(&NONE));
}

#[test]
fn a_border_edge_has_only_one_of_fl_and_fr() {
    let mesh = grid(4, 4);
    let east = there_and_back(&mesh, 1, 2);
    assert!(east.fl == NONE && east.fr != NONE, "north of the northern side is nothing");
    let west = there_and_back(&mesh, 2, 1);
    assert!(west.fl != NONE && west.fr == NONE);
    assert_eq!((east.fr, &east.f[..2], &west.f[2..]), (west.fl, &[NONE; 2][..], &[NONE; 2][..]));
}

#[test]
fn any_edge_may_collapse_either_way_and_come_back() {
    let mesh = grid(5, 5);
    let edges = (0..25).flat_map(|a| (0..25).map(move |b| (a, b)));
    let possible: Vec<_> = edges.filter(|&(vt, vu)| split_of(&mesh, vt, vu).is_ok()).collect();
    assert!(possible.len() > 80, "{}", possible.len());
    possible.into_iter().for_each(|(vt, vu)| {
        there_and_back(&mesh, vt, vu);
    });
}

#[test]
fn a_split_that_names_a_wrong_neighbour_face_leaves_a_mesh_that_is_refused() {
    let mesh = grid(5, 5);
    let split = split_of(&mesh, 12, 13).unwrap();
    for (a, b) in [(0, 1), (1, 3), (2, 3)] {
        let (mut work, mut wrong) = (mesh.clone(), split);
        split.ecol(&mut work);
        wrong.f.swap(a, b);
        wrong.vsplit(&mut work);
        assert!(work.validate().is_err(), "f{a} and f{b} taken for one another");
    }
}

#[test]
fn each_of_f0_to_f3_may_be_missing() {
    // The ends of these edges lie next to sides of the grid, so that fl or fr lies on a side.
    let mesh = grid(3, 3);
    let mut missing = [false; 4];
    for vt in 0..9 {
        for vu in 0..9 {
            if let Ok(split) = split_of(&mesh, vt, vu) {
                there_and_back(&mesh, vt, vu);
                let beside = [split.fl, split.fl, split.fr, split.fr];
                for (seen, (face, neighbour)) in missing.iter_mut().zip(beside.into_iter().zip(split.f)) {
                    *seen |= face != NONE && neighbour == NONE;
                }
            }
        }
    }
    assert_eq!(missing, [true; 4]);
}

#[test]
fn missing_edges_and_edges_across_the_surface_are_refused() {
    let mesh = grid(4, 4);
    assert_eq!(split_of(&mesh, 0, 15), Err(Refusal::NoEdge));
    // The diagonal of a corner cell, from side to side.
    let strip = grid(4, 2);
    assert_eq!(split_of(&strip, 1, 5), Err(Refusal::AcrossBorders));
}

#[test]
fn a_face_that_hangs_on_nothing_else_is_refused() {
    let ear = FaceMesh::new(vec![DVec3::ZERO; 4], vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    assert_eq!(split_of(&ear, 0, 2), Err(Refusal::LastFace));
    assert!(split_of(&ear, 0, 1).is_ok());
    let single = FaceMesh::new(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]).unwrap();
    assert_eq!(split_of(&single, 0, 1), Err(Refusal::LastFace));
}

#[test]
fn neighbours_that_are_already_adjacent_are_refused() {
    // Around 0 and 1, whose edge has the faces with 2 and 3, goes the vertex 4, adjacent to both.
    let faces = vec![[0, 1, 2], [1, 0, 3], [1, 4, 2], [2, 4, 0], [3, 4, 1], [0, 4, 3]];
    let closed = FaceMesh::new(vec![DVec3::ZERO; 5], faces).unwrap();
    assert_eq!(split_of(&closed, 0, 1), Err(Refusal::AlreadyAdjacent));
    let tetrahedron = FaceMesh::new(vec![DVec3::ZERO; 4], vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
    assert_eq!(split_of(&tetrahedron, 0, 1), Err(Refusal::AlreadyAdjacent));
}

#[test]
fn inversions_are_seen_and_harmless_collapses_are_not_taken_for_one() {
    let mesh = grid(4, 4);
    let far = VertexSplit::of_edge(&mesh, 5, 6, DVec3::new(3.5, 3.5, 0.0)).unwrap();
    assert!(far.inverts(&mesh, 0.0));
    let middle = VertexSplit::of_edge(&mesh, 5, 6, DVec3::new(1.5, 2.0, 0.0)).unwrap();
    assert!(!middle.inverts(&mesh, 0.0));
    assert!(middle.inverts(&mesh, 10.0), "no triangle about it has ten cells");
}

/// Order and parents of half-edge collapses in the order of hashes, each into a neighbour that allows it, until none is left.
fn scrambled(field: &Heightfield, seed: u32) -> (Vec<u32>, Vec<u32>) {
    let mut mesh = FaceMesh::from_heightfield(field);
    let (columns, rows) = (field.columns() as u32, field.rows() as u32);
    let sides = |v: u32| ([0, columns - 1].contains(&(v % columns)), [0, rows - 1].contains(&(v / columns)));
    let fits = |v: u32, p: u32| {
        let (a, b) = (sides(v), sides(p));
        a != (true, true) && (!a.0 || b.0) && (!a.1 || b.1)
    };
    let (mut order, mut parent) = (Vec::new(), vec![NONE; field.heights().len()]);
    let mut ring = Vec::new();
    loop {
        let mut vertices: Vec<u32> = mesh.living_vertices().collect();
        vertices.sort_by_key(|v| (v ^ seed).wrapping_mul(2_654_435_761).rotate_left(7).wrapping_mul(seed | 1));
        let before = order.len();
        for v in vertices {
            mesh.ring(v, &mut ring);
            let legal = |&p: &u32| fits(v, p) && split_of(&mesh, p, v).is_ok_and(|split| !split.inverts(&mesh, 0.0));
            if let Some(p) = ring.iter().copied().find(legal) {
                split_of(&mesh, p, v).unwrap().ecol(&mut mesh);
                order.push(v);
                parent[v as usize] = p;
            }
        }
        if order.len() == before {
            return (order, parent);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_mesh_of_a_sequence_is_valid_and_comes_back_to_the_bit(columns in 2usize..9, rows in 2usize..9, seed: u32) {
        let field = bumpy(columns, rows);
        let (order, parent) = scrambled(&field, seed);
        let mut progressive = ProgressiveMesh::from_half_edge_collapses(&field, &order, &parent).unwrap();
        prop_assert_eq!(progressive.faces(), 2);
        let mut meshes = vec![progressive.mesh().clone()];
        while progressive.next() {
            prop_assert_eq!(progressive.mesh().validate(), Ok(()));
            prop_assert_eq!(euler_characteristic(progressive.mesh()), 1);
            meshes.push(progressive.mesh().clone());
        }
        prop_assert_eq!(meshes.len(), order.len() + 1);
        let full = progressive.mesh().surface();
        prop_assert_eq!(full.deviation(&field).max, 0.0);
        prop_assert_eq!(full.faces.len(), 2 * (columns - 1) * (rows - 1));
        for mesh in meshes.iter().rev().skip(1) {
            prop_assert!(progressive.prev());
            prop_assert!(progressive.mesh() == mesh);
        }
        prop_assert!(!progressive.prev());
        for (at, mesh) in meshes.iter().enumerate().step_by(3) {
            let faces = progressive.set_faces(mesh.faces.len());
            prop_assert_eq!(faces, mesh.faces.len());
            prop_assert!(at == 0 || progressive.mesh() == mesh);
        }
    }
}

#[test]
fn set_faces_stays_at_or_below_what_is_asked_and_at_the_ends() {
    let field = bumpy(6, 5);
    let (order, parent) = scrambled(&field, 7);
    let mut progressive = ProgressiveMesh::from_half_edge_collapses(&field, &order, &parent).unwrap();
    assert_eq!(progressive.set_faces(1000), 40);
    assert_eq!(progressive.set_faces(0), 2);
    for faces in (2..=40).chain((2..=40).rev()) {
        let got = progressive.set_faces(faces);
        assert!(got == faces || got + 1 == faces, "asked for {faces}, got {got}");
    }
}

#[test]
fn corners_gaps_and_wrong_orders_are_refused_with_the_step() {
    let field = bumpy(4, 4);
    let one = |sample: u32, into: u32| {
        let mut parent = vec![NONE; 16];
        parent[sample as usize] = into;
        ProgressiveMesh::from_half_edge_collapses(&field, &[sample], &parent).map(|_| ())
    };
    let refused = |sample, into, reason| Err(ClassicError::Collapse { step: 0, sample, into, reason });
    assert_eq!(one(5, 6), Ok(()));
    assert_eq!(one(0, 1), refused(0, 1, Refusal::Outline));
    assert_eq!(one(1, 5), refused(1, 5, Refusal::Outline));
    assert_eq!(one(5, 15), refused(5, 15, Refusal::NoEdge));
    assert_eq!(one(5, NONE), refused(5, NONE, Refusal::NoEdge));
    let short = ProgressiveMesh::from_half_edge_collapses(&field, &[5], &[0; 3]);
    assert_eq!(short.unwrap_err(), ClassicError::Parents { found: 3, expected: 16 });
    let mut heights = field.heights().to_vec();
    heights[6] = f32::NAN;
    let gappy = Heightfield::new(4, 4, heights).unwrap();
    let refusal = ProgressiveMesh::from_half_edge_collapses(&gappy, &[], &[NONE; 16]).unwrap_err();
    assert_eq!(refusal, ClassicError::Gaps { count: 1, column: 2, row: 1 });
}
