//! Records made of any bytes, for tests and fuzzing: past the checksums, and past the compression.

use super::super::facts;
use super::super::record::{self, add_packed, add_stream};
use super::chunk::{FALLS, STREAMS};
use super::{assemble, chunk_ends, head_bytes, samples, CHUNK_BYTES, MAGIC};
use crate::globe::patch::PatchId;
use crate::mesh::wake::Wake;

/// Gives bytes the header and the checksums that a record of this patch has, and chunks the lengths that they have room for. False for
/// fewer bytes than a head has.
pub fn seal(bytes: &mut [u8], id: PatchId, cells: u32) -> bool {
    let (head, count) = (head_bytes(cells), chunk_ends(cells).len());
    if bytes.len() < head {
        return false;
    }
    let (head, mut rest) = bytes.split_at_mut(head);
    let directory = head.len() - count * CHUNK_BYTES;
    for (k, entry) in head[directory..].chunks_exact_mut(CHUNK_BYTES).enumerate() {
        let stated = u32::from_le_bytes([entry[0], entry[1], entry[2], entry[3]]) as usize;
        let length = if k + 1 == count { rest.len() } else { stated.min(rest.len()) };
        let (chunk, left) = rest.split_at_mut(length);
        entry[..4].copy_from_slice(&(length as u32).to_le_bytes());
        entry[4..8].copy_from_slice(&crc32fast::hash(chunk).to_le_bytes());
        rest = left;
    }
    record::seal(head, MAGIC, id, cells)
}

/// The record whose facts are the first bytes, and whose streams decompress to the others, followed by zeros.
pub fn of_raw(bytes: &[u8], id: PatchId, cells: u32) -> Vec<u8> {
    let mut bytes = bytes.iter().copied().chain(std::iter::repeat(0));
    let mut take = |count: usize| -> Vec<u8> { bytes.by_ref().take(count).collect() };
    let facts = take(facts::BYTES);
    let (all, mut first) = (samples(cells), 0);
    let chunk = |end: usize| {
        let beyond = take(2);
        let mut streams = Vec::new();
        for _ in 0..STREAMS.iter().map(|(_, planes)| planes).sum() {
            add_stream(&mut streams, &take(end - first));
        }
        first = end;
        if end < all {
            let length = take(2);
            let length = usize::from(u16::from_le_bytes([length[0], length[1]])).min(all);
            add_packed(&mut streams, &take(length));
            (1..FALLS.1).for_each(|_| add_stream(&mut streams, &take(length)));
        }
        (Wake::from_code(u16::from_le_bytes([beyond[0], beyond[1]])), streams)
    };
    assemble(id, cells, &facts, &chunk_ends(cells).into_iter().map(chunk).collect::<Vec<_>>())
}
