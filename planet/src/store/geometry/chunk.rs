//! One chunk of a geometry record: vertices that follow each other in wake order, as streams, one a field and byte.
//!
//! The larger wake goes as falling steps, parents by regions ([`super::falls`]). The two wakes of a vertex differ on a patch's border only;
//! what the smaller one lacks is a stream of nearly all zeros. Heights are differences from the parent's, but in the last chunk, which
//! fills the grid: there they go by grid, coarse to fine, as differences from the mean of their neighbours.

use super::super::error::RecordError;
use super::super::predict::{mean, merge_plane, midpoint_order, plane, unzigzag, zigzag};
use super::super::record::{add_packed, add_stream, RecordReader};
use super::falls::{Regions, NONE};
use crate::globe::lattice::EXTENT;
use crate::mesh::progressive::mesh_prefix::falls;
use crate::mesh::progressive::{PatchMesh, Vertex};
use crate::mesh::wake::Wake;
use std::ops::Range;

/// Names of the streams that have a number for each vertex, and how many byte planes each has, in file order.
pub(super) const STREAMS: [(&str, u32); 6] = [
    ("wake steps", 2),
    ("grid positions", 2),
    ("parents", 2),
    ("wake deficits", 2),
    ("coarser wake deficits", 2),
    ("heights", 4),
];

/// What follows them in all chunks but the last: at most a number for each grid position.
pub(super) const FALLS: (&str, u32) = ("falls", 2);

/// The numbers of a chunk's streams, in the order of [`STREAMS`].
#[derive(Clone, Default)]
pub(super) struct Numbers {
    pub(super) of_vertices: [Vec<u32>; STREAMS.len()],
    /// None in the last chunk.
    pub(super) falls: Option<Vec<u32>>,
}

impl Numbers {
    /// The bytes of a chunk.
    pub(super) fn write(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for ((_, planes), numbers) in STREAMS.into_iter().zip(&self.of_vertices) {
            (0..planes).for_each(|p| add_stream(&mut bytes, &plane(numbers, p)));
        }
        if let Some(falls) = &self.falls {
            add_packed(&mut bytes, &plane(falls, 0));
            (1..FALLS.1).for_each(|p| add_stream(&mut bytes, &plane(falls, p)));
        }
        bytes
    }

    /// The numbers of a chunk of so many vertices of a grid of `samples`.
    pub(super) fn read(
        reader: &mut RecordReader<'_>,
        vertices: usize,
        samples: usize,
        is_last: bool,
    ) -> Result<Numbers, RecordError> {
        let mut numbers = Numbers::default();
        for ((name, planes), numbers) in STREAMS.into_iter().zip(&mut numbers.of_vertices) {
            *numbers = vec![0; vertices];
            for p in 0..planes {
                merge_plane(numbers, &reader.stream(name, vertices)?, p);
            }
        }
        if !is_last {
            let lowest = reader.stream_within(FALLS.0, samples)?;
            let mut falls: Vec<u32> = lowest.iter().copied().map(u32::from).collect();
            for p in 1..FALLS.1 {
                merge_plane(&mut falls, &reader.stream(FALLS.0, lowest.len())?, p);
            }
            numbers.falls = Some(falls);
        }
        reader.finish()?;
        Ok(numbers)
    }
}

/// The numbers of a mesh's chunks, which end after so many vertices each.
pub(super) fn numbers(mesh: &PatchMesh, ends: &[usize]) -> Vec<Numbers> {
    let (vertices, side) = (&mesh.vertices, mesh.cells as usize + 1);
    let mut index_of = vec![NONE; vertices.len()];
    let mut wake = Wake::ALWAYS.code();
    let mut first = 0;
    let chunk = |&end: &usize| {
        let range = first..end;
        let mut numbers = Numbers::default();
        let [steps, positions, parents, deficits, coarser_deficits, heights] = &mut numbers.of_vertices;
        *heights = height_differences(mesh, &range, &index_of);
        let mut regions = if first == 0 { Regions::new(side) } else { Regions::of(side, falls(vertices, first), first) };
        for (k, vertex) in vertices.iter().enumerate().skip(first).take(range.len()) {
            let largest = vertex.largest_wake().code();
            let (region, rank) = regions.add(usize::from(vertex.grid), k as u16);
            index_of[usize::from(vertex.grid)] = k as u16;
            steps.push(u32::from(wake - largest));
            positions.push(pack(vertex.grid, side));
            parents.push(rank - regions.rank(region, vertex.parent));
            deficits.push(u32::from(largest - vertex.wake.code()));
            coarser_deficits.push(u32::from(largest - vertex.coarser_wake.code()));
            wake = largest;
        }
        if end < vertices.len() {
            numbers.falls = Some(regions.codes(&index_of, &falls(vertices, end)));
        }
        first = end;
        numbers
    };
    ends.iter().map(chunk).collect()
}

/// Row in the high byte, column in the low one: both at most 128.
fn pack(grid: u16, side: usize) -> u32 {
    let (row, column) = (usize::from(grid) / side, usize::from(grid) % side);
    (row << 8 | column) as u32
}

fn height_differences(mesh: &PatchMesh, range: &Range<usize>, index_of: &[u16]) -> Vec<u32> {
    let vertices = &mesh.vertices;
    if range.end < vertices.len() {
        let parent = |v: &Vertex| &vertices[usize::from(v.parent)];
        let difference = |v: &Vertex| if parent(v).grid == v.grid { v.height } else { v.height.wrapping_sub(parent(v).height) };
        return vertices[range.clone()].iter().map(|v| zigzag(difference(v))).collect();
    }
    let mut heights = vec![0i32; vertices.len()];
    vertices.iter().for_each(|v| heights[usize::from(v.grid)] = v.height);
    let mut differences = Vec::with_capacity(range.len());
    midpoint_order(mesh.cells as usize, |v, around| {
        if index_of[v] == NONE {
            differences.push(zigzag(heights[v].wrapping_sub(mean(&heights, around))));
        }
    });
    differences
}

/// The vertices of a record's chunks as far as they were read.
pub(super) struct Vertices {
    cells: u32,
    pub(super) vertices: Vec<Vertex>,
    /// By grid position.
    index_of: Vec<u16>,
    heights: Vec<i32>,
    /// For every grid position the vertex index that it falls to.
    pub(super) falls: Vec<u16>,
    /// Code of the last vertex's larger wake.
    wake: u32,
}

impl Vertices {
    /// None yet, of a grid of `cells` cells a side.
    pub(super) fn new(cells: u32) -> Vertices {
        let samples = (cells as usize + 1).pow(2);
        Vertices {
            cells,
            vertices: Vec::with_capacity(samples),
            index_of: vec![NONE; samples],
            heights: vec![0; samples],
            falls: Vec::new(),
            wake: Wake::ALWAYS.code().into(),
        }
    }

    fn side(&self) -> usize {
        self.cells as usize + 1
    }

    /// Adds the vertices of the next chunk. Whatever the numbers, the vertices keep all that readers of a mesh rely on.
    pub(super) fn add(&mut self, numbers: &Numbers) -> Result<(), RecordError> {
        let (first, count) = (self.vertices.len(), numbers.of_vertices[0].len());
        let is_last = first + count == self.index_of.len();
        let heights = &numbers.of_vertices[5];
        if is_last {
            self.fill(heights);
        }
        let mut regions = match first {
            0 => Regions::new(self.side()),
            _ => Regions::of(self.side(), std::mem::take(&mut self.falls), first),
        };
        for (k, &difference) in heights.iter().enumerate() {
            let mut vertex = self.vertex(numbers, k, &mut regions)?;
            let height = &mut self.heights[usize::from(vertex.grid)];
            if !is_last {
                let parent = self.vertices.get(usize::from(vertex.parent)).map_or(0, |parent| parent.height);
                *height = parent.wrapping_add(unzigzag(difference));
            }
            vertex.height = *height;
            if vertex.height.unsigned_abs() > EXTENT.unsigned_abs() {
                return Err(RecordError::Vertex { index: first + k, reason: "its height is outside the lattice" });
            }
            self.vertices.push(vertex);
        }
        if is_last {
            self.falls.clone_from(&self.index_of);
            return Ok(());
        }
        let mut codes = numbers.falls.iter().flatten();
        let refined = regions.refined(&self.index_of, |_| codes.next().copied());
        let falls = refined.ok_or(RecordError::Measure("a sample falls to no vertex of its region"))?;
        match codes.count() {
            0 => self.falls = falls,
            left => return Err(RecordError::Trailing(left)),
        }
        Ok(())
    }

    /// Fills the grid with the heights that are missing in it.
    fn fill(&mut self, differences: &[u32]) {
        let mut next = differences.iter();
        let (heights, index_of) = (&mut self.heights, &self.index_of);
        midpoint_order(self.cells as usize, |v, around| {
            if index_of[v] == NONE {
                heights[v] = mean(heights, around).wrapping_add(unzigzag(next.next().copied().unwrap_or(0)));
            }
        });
    }

    /// The next vertex, the k-th of its chunk, still without its height.
    fn vertex(&mut self, numbers: &Numbers, k: usize, regions: &mut Regions) -> Result<Vertex, RecordError> {
        let [steps, positions, parents, deficits, coarser_deficits, _] = &numbers.of_vertices;
        let index = self.vertices.len();
        let wrong = |reason| RecordError::Vertex { index, reason };
        let (row, column) = ((positions[k] >> 8) as usize, (positions[k] & 0xff) as usize);
        if row >= self.side() || column >= self.side() {
            return Err(wrong("its grid position is outside the grid"));
        }
        let grid = row * self.side() + column;
        if self.index_of[grid] != NONE {
            return Err(wrong("its grid position is taken"));
        }
        self.index_of[grid] = index as u16;
        let (region, rank) = regions.add(grid, index as u16);
        let parent = rank.checked_sub(parents[k]).and_then(|rank| regions.member(region, rank));
        let parent = parent.ok_or(wrong("its parent is no vertex of its region"))?;
        if usize::from(parent) == index && region > 0 {
            return Err(wrong("it never collapses, and falls to another"));
        }
        self.wake = self.wake.checked_sub(steps[k]).ok_or(wrong("its wake falls below zero"))?;
        let lacks = |deficit: u32| {
            self.wake.checked_sub(deficit).map(|code| Wake::from_code(code as u16)).ok_or(wrong("its wake falls below zero"))
        };
        if deficits[k] != 0 && coarser_deficits[k] != 0 {
            return Err(wrong("neither of its wakes is the larger one"));
        }
        Ok(Vertex { grid: grid as u16, height: 0, wake: lacks(deficits[k])?, coarser_wake: lacks(coarser_deficits[k])?, parent })
    }
}
