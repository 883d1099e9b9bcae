//! The geometry record: a [`PatchMesh`] as streams, one a field and byte.
//!
//! Vertices go by wake order: the larger wake as falling steps, the grid position, the way to the parent on the grid. Heights
//! go by grid, coarse to fine, as differences from the mean of their neighbours. The two wakes of a vertex differ on a
//! patch's border only; what the smaller one lacks is a stream of nearly all zeros.

use super::error::RecordError;
use super::facts;
use super::predict::{mean, merge_plane, midpoint_order, plane, unzigzag, zigzag};
use super::record::{RecordReader, RecordWriter};
use crate::globe::lattice::EXTENT;
use crate::globe::patch::{PatchId, MAX_CELLS, MIN_CELLS};
use crate::mesh::progressive::{PatchMesh, Vertex};
use crate::mesh::wake::Wake;

/// First bytes of a geometry record.
pub const MAGIC: [u8; 4] = *b"TRPG";

/// Names of the streams and how many byte planes each has, in file order.
const STREAMS: [(&str, u32); 6] = [
    ("wake steps", 2),
    ("grid positions", 2),
    ("parents", 2),
    ("wake deficits", 2),
    ("coarser wake deficits", 2),
    ("heights", 4),
];

/// Whether patches of so many cells a side exist.
pub(super) fn cells_are_valid(cells: u32) -> bool {
    cells.is_power_of_two() && (MIN_CELLS..=MAX_CELLS).contains(&cells)
}

/// The record of a mesh, or which of the builder's promises it breaks (nothing is stored that could not be read back).
pub fn encode(mesh: &PatchMesh) -> Result<Vec<u8>, RecordError> {
    validate(mesh)?;
    Ok(write(mesh, &streams(mesh)))
}

/// The numbers of a mesh's streams, in the order of [`STREAMS`].
fn streams(mesh: &PatchMesh) -> [Vec<u32>; STREAMS.len()] {
    [
        wake_steps(mesh),
        grid_positions(mesh),
        parents(mesh),
        deficits(mesh, |v| v.wake),
        deficits(mesh, |v| v.coarser_wake),
        residuals(mesh),
    ]
}

/// The record of a mesh's facts and of the numbers of its streams.
fn write(mesh: &PatchMesh, numbers: &[Vec<u32>; STREAMS.len()]) -> Vec<u8> {
    let mut record = RecordWriter::new(MAGIC, mesh.id, mesh.cells);
    record.plain(&facts::bytes(&mesh.facts));
    for ((_, planes), numbers) in STREAMS.into_iter().zip(numbers) {
        (0..planes).for_each(|p| record.stream(&plane(numbers, p)));
    }
    record.finish()
}

/// The mesh of a record, after every check that keeps a reader of it safe.
pub fn decode(bytes: &[u8], id: PatchId, cells: u32) -> Result<PatchMesh, RecordError> {
    if !cells_are_valid(cells) {
        return Err(RecordError::Measure("the grid's cells are not a power of two in range"));
    }
    let count = ((cells + 1) * (cells + 1)) as usize;
    let mut record = RecordReader::open(bytes, MAGIC, id, cells)?;
    let raw = facts::BYTES + count * STREAMS.iter().map(|s| s.1 as usize).sum::<usize>();
    if record.raw != raw {
        return Err(RecordError::Short { what: "raw record", found: record.raw, expected: raw });
    }
    let facts = facts::read(&mut record)?;
    let mut streams = Vec::with_capacity(STREAMS.len());
    for (name, planes) in STREAMS {
        let mut numbers = vec![0u32; count];
        for p in 0..planes {
            merge_plane(&mut numbers, &record.stream(name, count)?, p);
        }
        streams.push(numbers);
    }
    record.finish()?;
    let vertices = vertices(&streams, cells)?;
    let mesh = PatchMesh { id, cells, vertices, facts };
    validate(&mesh)?;
    Ok(mesh)
}

/// Everything that readers of a mesh rely on.
fn validate(mesh: &PatchMesh) -> Result<(), RecordError> {
    let count = ((mesh.cells + 1) * (mesh.cells + 1)) as usize;
    if !cells_are_valid(mesh.cells) || mesh.vertices.len() != count {
        return Err(RecordError::Short { what: "vertex list", found: mesh.vertices.len(), expected: count });
    }
    let mut seen = vec![false; count];
    let mut previous = Wake::ALWAYS;
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        let wrong = |reason| Err(RecordError::Vertex { index, reason });
        match seen.get_mut(usize::from(vertex.grid)) {
            Some(slot) if !*slot => *slot = true,
            _ => return wrong("its grid position is taken or outside the grid"),
        }
        if usize::from(vertex.parent) > index {
            return wrong("its parent comes after it");
        }
        if vertex.largest_wake() > previous {
            return wrong("its wake is larger than the one before");
        }
        if vertex.height.unsigned_abs() > EXTENT.unsigned_abs() {
            return wrong("its height is outside the lattice");
        }
        previous = vertex.largest_wake();
        (low, high) = (low.min(vertex.height), high.max(vertex.height));
    }
    if mesh.facts.heights != [low, high] {
        return Err(RecordError::Measure("the height range is not that of the vertices"));
    }
    facts::check(&mesh.facts).map_err(RecordError::Measure)
}

fn wake_steps(mesh: &PatchMesh) -> Vec<u32> {
    let mut previous = Wake::ALWAYS.code();
    let step = |v: &Vertex| {
        let code = v.largest_wake().code();
        u32::from(std::mem::replace(&mut previous, code) - code)
    };
    mesh.vertices.iter().map(step).collect()
}

/// Row in the high byte, column in the low one: both at most 128.
fn row_and_column(grid: u16, cells: u32) -> (u32, u32) {
    (u32::from(grid) / (cells + 1), u32::from(grid) % (cells + 1))
}

fn grid_positions(mesh: &PatchMesh) -> Vec<u32> {
    let pack = |v: &Vertex| {
        let (row, column) = row_and_column(v.grid, mesh.cells);
        row << 8 | column
    };
    mesh.vertices.iter().map(pack).collect()
}

/// Steps on the grid to the parent, modulo the side: one byte each.
fn parents(mesh: &PatchMesh) -> Vec<u32> {
    let side = mesh.cells + 1;
    let pack = |v: &Vertex| {
        let (row, column) = row_and_column(v.grid, mesh.cells);
        let (to_row, to_column) = row_and_column(mesh.vertices[usize::from(v.parent)].grid, mesh.cells);
        ((to_row + side - row) % side) << 8 | ((to_column + side - column) % side)
    };
    mesh.vertices.iter().map(pack).collect()
}

fn deficits(mesh: &PatchMesh, wake: impl Fn(&Vertex) -> Wake) -> Vec<u32> {
    mesh.vertices.iter().map(|v| u32::from(v.largest_wake().code() - wake(v).code())).collect()
}

fn residuals(mesh: &PatchMesh) -> Vec<u32> {
    let mut heights = vec![0i32; mesh.vertices.len()];
    for v in &mesh.vertices {
        heights[usize::from(v.grid)] = v.height;
    }
    let mut residuals = Vec::with_capacity(heights.len());
    midpoint_order(mesh.cells as usize, |v, around| residuals.push(zigzag(heights[v].wrapping_sub(mean(&heights, around)))));
    residuals
}

/// Vertices from their streams; a grid position or parent that is not there is an error, the rest is left to [`validate`].
fn vertices(streams: &[Vec<u32>], cells: u32) -> Result<Vec<Vertex>, RecordError> {
    let [steps, positions, ways, deficits, coarser_deficits, residuals] = streams else {
        return Err(RecordError::Measure("streams are missing"));
    };
    let side = cells + 1;
    let mut index_of = vec![u16::MAX; positions.len()];
    let mut heights = vec![0i32; positions.len()];
    let mut next = residuals.iter();
    midpoint_order(cells as usize, |v, around| {
        let residual = next.next().copied().unwrap_or(0);
        heights[v] = mean(&heights, around).wrapping_add(unzigzag(residual));
    });
    let mut largest = u32::from(Wake::ALWAYS.code());
    let mut vertices = Vec::with_capacity(positions.len());
    for (index, &position) in positions.iter().enumerate() {
        let wrong = |reason| RecordError::Vertex { index, reason };
        let (row, column) = (position >> 8, position & 0xff);
        if row >= side || column >= side {
            return Err(wrong("its grid position is outside the grid"));
        }
        let grid = row * side + column;
        index_of[grid as usize] = index as u16;
        let (down, across) = (ways[index] >> 8, ways[index] & 0xff);
        let parent = index_of[((row + down) % side * side + (column + across) % side) as usize];
        if usize::from(parent) > index {
            return Err(wrong("its parent comes after it"));
        }
        largest = largest.checked_sub(steps[index]).ok_or(wrong("its wake falls below zero"))?;
        let lacks = |deficit: u32| {
            largest.checked_sub(deficit).map(|code| Wake::from_code(code as u16)).ok_or(wrong("its wake falls below zero"))
        };
        if deficits[index] != 0 && coarser_deficits[index] != 0 {
            return Err(wrong("neither of its wakes is the larger one"));
        }
        vertices.push(Vertex {
            grid: grid as u16,
            height: heights[grid as usize],
            wake: lacks(deficits[index])?,
            coarser_wake: lacks(coarser_deficits[index])?,
            parent,
        });
    }
    Ok(vertices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::lattice::LatticeBox;
    use crate::mesh::progressive::{PatchFacts, Quarter};
    use glam::IVec3;

    /// A mesh that satisfies every rule: all vertices are asleep but the first, which is the parent of all.
    fn flat(cells: u32) -> PatchMesh {
        let vertex = |grid: u32| {
            let wake = if grid == 0 { Wake::ALWAYS } else { Wake::ASLEEP };
            Vertex { grid: grid as u16, height: -7, wake, coarser_wake: wake, parent: 0 }
        };
        PatchMesh {
            id: PatchId::new(crate::globe::sphere::Face::ALL[2], 3, 1, 6).unwrap(),
            cells,
            vertices: (0..(cells + 1) * (cells + 1)).map(vertex).collect(),
            facts: PatchFacts {
                bounds: LatticeBox { low: IVec3::splat(-5), high: IVec3::splat(5) },
                heights: [-7, -7],
                child_wake: f64::INFINITY,
                quarters: [Quarter { heights: [-7, -7], deviation: 0.5 }; 4],
            },
        }
    }

    /// Decodes a record with a valid header and checksum around streams of which one was changed.
    fn decode_changed(change: impl Fn(&mut [Vec<u32>; STREAMS.len()])) -> Result<PatchMesh, RecordError> {
        let mesh = flat(8);
        let mut numbers = streams(&mesh);
        change(&mut numbers);
        decode(&write(&mesh, &numbers), mesh.id, mesh.cells)
    }

    #[test]
    fn sound_streams_decode() {
        assert_eq!(decode_changed(|_| ()), Ok(flat(8)));
    }

    #[test]
    fn streams_that_break_a_rule_are_refused_by_name() {
        type Change = fn(&mut [Vec<u32>; STREAMS.len()]);
        let cases: [(&str, Change); 9] = [
            ("falls below zero", |s| s[0][5] = 9),
            ("taken or outside", |s| (s[1][7], s[2][7]) = (s[1][6], s[2][6])),
            ("outside the grid", |s| s[1][7] = 9 << 8),
            ("parent comes after", |s| s[2][3] = 1),
            ("falls below zero", |s| s[3][3] = 1),
            ("neither of its wakes", |s| (s[3][0], s[4][0]) = (1, 1)),
            ("height range", |s| s[5][8] = 2),
            ("outside the lattice", |s| s[5][80] = u32::MAX),
            ("outside the grid", |s| s[1][0] = 0xffff),
        ];
        for (reason, change) in cases {
            let error = decode_changed(change).unwrap_err().to_string();
            assert!(error.contains(reason), "expected '{reason}', found '{error}'");
        }
    }

    #[test]
    fn meshes_that_break_a_rule_are_not_encoded() {
        let cases: [fn(&mut PatchMesh); 7] = [
            |m| m.vertices[4].parent = 9,
            |m| m.vertices[4].grid = 5,
            |m| m.vertices[4].wake = Wake::ALWAYS,
            |m| m.facts.quarters[2].deviation = f64::NAN,
            |m| m.facts.heights = [0, 0],
            |m| m.facts.bounds = LatticeBox::EMPTY,
            |m| m.cells = 16,
        ];
        for (k, change) in cases.into_iter().enumerate() {
            let mut mesh = flat(8);
            change(&mut mesh);
            assert!(encode(&mesh).is_err(), "case {k}");
        }
    }
}
