//! Meshes in chunks by wake: each is read with those before it and nothing else, and draws what the whole mesh would.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::TestField;
use crate::whole_planet::{planet, views};
use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use terrane_planet::draw::cut::{cut, Leaf};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::draw::work::sleeps;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::HeightGrid;
use terrane_planet::mesh::progressive::{MeshPrefix, PatchFacts, PatchMesh};
use terrane_planet::mesh::wake::Wake;
use terrane_planet::query::PatchGrid;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::store::geometry::{self, chunk_ends, head_bytes, Head};
use terrane_planet::store::{records, Part, RecordError, Records, StoreError};

const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };

/// Built patches of several levels.
fn meshes(cells: u32) -> Vec<PatchMesh> {
    let ground = FIELD.ground(cells);
    let root = PatchId::roots().nth(2).unwrap();
    let child = root.children().unwrap()[1];
    let below = child.children().unwrap()[2].children().unwrap()[3];
    [root, child, below].map(|id| PatchMesh::build(&ground, &HeightGrid::sample(&ground, id)).0).to_vec()
}

fn read(record: &[u8], mesh: &PatchMesh, chunks: usize) -> Result<MeshPrefix, RecordError> {
    let head = Head::read(record, mesh.id, mesh.cells)?;
    geometry::decode_chunks(&head, record, mesh.id, mesh.cells, chunks)
}

#[test]
fn each_number_of_chunks_is_a_prefix_of_the_mesh() {
    for cells in [16, 32, 64, 128] {
        for mesh in meshes(cells) {
            let record = geometry::encode(&mesh).unwrap();
            assert!(geometry::decode(&record, mesh.id, cells).unwrap() == mesh);
            let head = Head::read(&record[..head_bytes(cells)], mesh.id, cells).unwrap();
            assert!(head.facts == mesh.facts && head.chunks.len() == chunk_ends(cells).len());
            for (k, end) in chunk_ends(cells).into_iter().enumerate() {
                let prefix = read(&record[..head.bytes_of(k + 1)], &mesh, k + 1).unwrap();
                assert!(prefix == MeshPrefix::of(&mesh, end), "{} of {cells} cells: {end} vertices", mesh.id);
                let short = read(&record[..head.bytes_of(k + 1) - 1], &mesh, k + 1).unwrap_err();
                assert!(matches!(short, RecordError::Chunk { number, .. } if number == k + 1), "{short}");
            }
        }
    }
}

/// Vertices that never collapse and do not fit into the first chunk: no view does without the next one.
#[test]
fn vertices_that_never_collapse_may_be_in_any_chunk() {
    let mut mesh = meshes(32).remove(1);
    for (k, vertex) in mesh.vertices.iter_mut().enumerate().take(500) {
        (vertex.wake, vertex.coarser_wake) = (Wake::ALWAYS, Wake::ALWAYS);
        vertex.parent = k as u16;
    }
    let record = geometry::encode(&mesh).unwrap();
    assert!(geometry::decode(&record, mesh.id, 32).unwrap() == mesh);
    let prefix = read(&record, &mesh, 1).unwrap();
    assert!(prefix == MeshPrefix::of(&mesh, 272) && prefix.beyond == Wake::ALWAYS);
}

#[test]
fn a_damaged_chunk_is_named_and_those_before_it_are_read() {
    let mesh = meshes(64).remove(1);
    let record = geometry::encode(&mesh).unwrap();
    let head = Head::read(&record, mesh.id, 64).unwrap();
    for (k, chunk) in head.chunks.iter().enumerate() {
        let mut damaged = record.clone();
        damaged[chunk.bytes.start + chunk.bytes.len() / 2] ^= 4;
        for chunks in 1..=head.chunks.len() {
            match read(&damaged, &mesh, chunks) {
                Ok(prefix) => assert!(chunks <= k && prefix == MeshPrefix::of(&mesh, head.chunks[chunks - 1].end)),
                Err(error) => {
                    assert!(chunks > k && error.to_string().starts_with(&format!("chunk {} of 3: checksum", k + 1)), "{error}");
                }
            }
        }
    }
    let mut damaged = record;
    damaged[head_bytes(64) - 1] ^= 4;
    assert!(matches!(read(&damaged, &mesh, 1), Err(RecordError::Checksum { .. })));
}

/// A record, and which of its bytes were asked for.
struct Watched {
    record: Vec<u8>,
    asked: RefCell<Vec<Range<usize>>>,
}

impl Records for Watched {
    fn path(&self) -> &Path {
        Path::new("watched")
    }

    fn cells(&self) -> u32 {
        64
    }

    fn facts(&self, _: PatchId) -> Result<Option<PatchFacts>, StoreError> {
        Ok(None)
    }

    fn bytes(&self, _: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError> {
        assert_eq!(part, Part::Geometry);
        self.asked.borrow_mut().push(range.clone());
        Ok(Some(self.record[range.start..range.end.min(self.record.len())].to_vec()))
    }

    fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError> {
        Ok(None)
    }
}

#[test]
fn no_more_is_read_than_the_view_can_wake() {
    let mesh = meshes(64).remove(1);
    let record = geometry::encode(&mesh).unwrap();
    let head = Head::read(&record, mesh.id, 64).unwrap();
    for (k, chunk) in head.chunks.iter().enumerate() {
        let watched = Watched { record: record.clone(), asked: RefCell::default() };
        let prefix = records::mesh(&watched, mesh.id, &|_, beyond| beyond <= chunk.beyond).unwrap().unwrap();
        assert!(prefix == MeshPrefix::of(&mesh, chunk.end));
        let asked = watched.asked.into_inner();
        let end = asked.iter().map(|range| range.end).max().unwrap();
        assert!(asked.len() <= 2 && end <= head.bytes_of(k + 1).max(4096), "{asked:?} for {} bytes", head.bytes_of(k + 1));
    }
}

/// What a view draws of a patch.
fn drawn(view: &View, leaf: &Leaf, patch: &LoadedPatch) -> Vec<[u32; 3]> {
    let work = patch.reach.work(view);
    let vertices = &patch.vertices[..work.vertices as usize];
    let Selected { awake, drawn_positions } = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
    emit(&view.gpu, &patch.triangles(&work), &resolve(vertices, &awake), &drawn_positions)
}

#[test]
fn a_prefix_that_suffices_draws_what_the_whole_mesh_does() {
    let planet = planet(&FIELD, 32);
    let lattice = planet.tree.lattice;
    let (mut prefixes, mut lacking, mut differing) = (0, 0, 0);
    for view in views(&planet, &FIELD, 30) {
        for leaf in cut(&planet.tree, &view, &|_| true).leaves {
            let whole = &planet.patches[&leaf.id].0;
            let prefix = MeshPrefix::of(&whole.mesh, chunk_ends(32)[0]);
            let suffices = sleeps(&view, &whole.mesh.facts.bounds, prefix.beyond);
            let part = LoadedPatch::new(prefix, &lattice);
            assert_eq!(part.reach.suffices(&view), suffices);
            let same = drawn(&view, &leaf, &part) == drawn(&view, &leaf, whole);
            assert!(same || !suffices, "{}", leaf.id);
            prefixes += usize::from(suffices);
            lacking += usize::from(!suffices);
            differing += usize::from(!same);
        }
    }
    assert!(
        prefixes > 100 && lacking > 100 && differing > 0,
        "{prefixes} prefixes suffice, {lacking} do not, {differing} differ"
    );
}

#[test]
fn the_ground_of_a_prefix_lies_on_its_triangles() {
    let lattice = FIELD.ground(32).lattice;
    let mesh = meshes(32).remove(1);
    let whole = PatchGrid::of_loaded(&LoadedPatch::new(mesh.clone(), &lattice), &lattice);
    let part = PatchGrid::of_loaded(&LoadedPatch::new(MeshPrefix::of(&mesh, 272), &lattice), &lattice);
    let expected = PatchGrid::of_mesh(&mesh, &lattice);
    let directions = (1..16).flat_map(|i| (1..16).map(move |j| (i, j)));
    let mut apart: f64 = 0.0;
    for (i, j) in directions {
        let direction = terrane_planet::globe::sphere::direction(mesh.id.point(i, j, 16));
        let radius = |grid: &PatchGrid| grid.radius(direction).unwrap();
        assert_eq!(radius(&whole), radius(&expected));
        apart = apart.max((radius(&part) - radius(&expected)).abs());
    }
    let [low, high] = mesh.facts.heights;
    assert!(apart > 0.0 && apart < 0.2 * f64::from(high - low), "{apart} of {}", high - low);
}
