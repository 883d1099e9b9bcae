//! Negative controls: mistakes that validation must report, or a silent test means nothing.

use super::device;
use crate::shaders::test::BALLOT_COMP;
use crate::vulkan::{Access, Buffer, Commands, ComputePipeline, Memory, Resource, Severity, Usage};

/// What stands between two uses of a buffer.
#[derive(Clone, Copy, PartialEq)]
enum Between {
    Nothing,
    Barrier,
    /// The commands are told of both uses, and find the barrier.
    Uses,
}

/// Fills a buffer and counts into it.
fn fill_and_count(between: Between) -> Option<Vec<crate::vulkan::ValidationMessage>> {
    let context = device()?;
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 64)]).unwrap();
    let storage = Usage::STORAGE_BUFFER;
    let counts = Buffer::new(&context, "counts", 8, storage, Memory::Device).unwrap();
    Commands::once(&context, "hazard", |commands| {
        if between == Between::Uses {
            commands.ready(&[counts.to(Access::TransferWrite)])?;
        }
        commands.fill_buffer(&counts, 0, 8, 0)?;
        match between {
            Between::Nothing => {}
            Between::Barrier => commands.barrier(&[Access::TransferWrite], &[Access::ComputeWrite])?,
            Between::Uses => commands.ready(&[counts.to(Access::ComputeWrite)])?,
        }
        commands.bind(&pipeline, &[("counts", Resource::Storage(&counts))])?;
        commands.push_constants(&[0u32; 3])?;
        commands.dispatch(1, 1, 1)
    })
    .unwrap();
    assert_eq!(context.messages().len(), context.message_log().all().len());
    Some(context.message_log().take())
}

#[test]
fn a_missing_barrier_is_reported() {
    let Some(messages) = fill_and_count(Between::Nothing) else {
        return;
    };
    let hazard = messages.iter().find(|m| m.id.starts_with("SYNC-HAZARD")).expect("a hazard");
    assert_eq!(hazard.severity, Severity::Error);
    assert!(hazard.text.contains("counts"), "names are passed on: {}", hazard.text);
}

#[test]
fn the_same_commands_with_the_barrier_are_clean() {
    for between in [Between::Barrier, Between::Uses] {
        let Some(messages) = fill_and_count(between) else {
            return;
        };
        assert!(messages.is_empty(), "{messages:?}");
    }
}
