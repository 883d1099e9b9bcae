//! Every member of every structure that the GPU sees, read by a shader and back.

use crate::harness::device;
use std::sync::Arc;
use terrane::shaders::LAYOUT_PROBE_COMP;
use terrane::vulkan::{Buffer, Commands, ComputePipeline, Context, Memory, Resource, Usage};
use terrane_planet::draw::layout::probe_words;

/// A distinct value for every word: floats from 1.0 on, because a NaN may change its bits on the way.
fn distinct(word: usize) -> u32 {
    1.0f32.to_bits() + word as u32
}

/// The words of all structures, one list each.
fn structures() -> Vec<Vec<u32>> {
    let mut next = 0;
    let mut words = |(_, count): (&str, usize)| {
        next += count;
        (next - count..next).map(distinct).collect()
    };
    probe_words().into_iter().map(&mut words).collect()
}

/// The words of all members in the order of their declaration, as the shader finds them.
fn probe(context: &Arc<Context>, structures: &[Vec<u32>]) -> Vec<u32> {
    let storage = Usage::STORAGE_BUFFER;
    let count: usize = structures.iter().map(Vec::len).sum();
    let names: Vec<String> = probe_words().iter().map(|(name, _)| format!("{name}Block")).collect();
    let upload = |words: &Vec<u32>| Buffer::from_slice(context, "structure", storage, words).unwrap();
    let buffers: Vec<Buffer> = structures.iter().map(upload).collect();
    let output = Buffer::new(context, "words", 4 * count as u64, storage, Memory::Readback).unwrap();
    let mut resources: Vec<_> = names.iter().zip(&buffers).map(|(name, b)| (name.as_str(), Resource::Storage(b))).collect();
    resources.push(("Words", Resource::Storage(&output)));
    let pipeline = ComputePipeline::new(context, &LAYOUT_PROBE_COMP, &[]).unwrap();
    Commands::once(context, "probe", |commands| {
        commands.bind(&pipeline, &resources)?;
        commands.dispatch(1, 1, 1)
    })
    .unwrap();
    output.read(0, count).unwrap()
}

#[test]
fn every_member_is_where_the_gpu_looks_for_it() {
    let Some(context) = device() else { return };
    let structures = structures();
    let found = probe(&context, &structures);
    assert_eq!(found, structures.concat());
    assert!(found.len() > 100 && found.is_sorted_by(|a, b| a < b), "the words are not distinct");
}

#[test]
fn a_changed_word_is_noticed() {
    let Some(context) = device() else { return };
    let expected = structures().concat();
    let mut first = 0;
    for (k, (name, count)) in probe_words().into_iter().enumerate() {
        let mut changed = structures();
        changed[k].swap(0, count - 1);
        let found = probe(&context, &changed);
        let differing: Vec<usize> = (0..expected.len()).filter(|&i| found[i] != expected[i]).collect();
        assert_eq!(differing, [first, first + count - 1], "{name}");
        first += count;
    }
}
