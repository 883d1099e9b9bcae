//! Compute: push descriptors, ballots, addresses, specialization, timestamps, wrong bindings.

use std::sync::Arc;

use super::device;
use crate::shaders::test::BALLOT_COMP;
use crate::vulkan::{Access, Buffer, Commands, ComputePipeline, Context, Memory, Resource, Result, Upload, Usage, VulkanError};

/// The push constants: address (low word first) and length of the table.
fn push(table: &Buffer, count: u32) -> [u32; 3] {
    let address = table.device_address();
    [address as u32, (address >> 32) as u32, count]
}

struct Count {
    table: Buffer,
    counts: Buffer,
    values: u32,
}

impl Count {
    fn new(context: &Arc<Context>, values: u32) -> Self {
        let numbers: Vec<u32> = (0..values).map(|i| i.wrapping_mul(2_654_435_761) >> 7).collect();
        let storage = Usage::STORAGE_BUFFER;
        let bytes = u64::from(values) * 4;
        let table = Buffer::new(context, "table", bytes, storage, Memory::Device).unwrap();
        let counts = Buffer::new(context, "counts", 8, storage, Memory::Readback).unwrap();
        let mut upload = Upload::new(context, 1 << 16);
        upload.buffer(&table, 0, &numbers).unwrap();
        upload.finish().unwrap();
        Self { table, counts, values }
    }

    fn record(&self, commands: &mut Commands, pipeline: &ComputePipeline) -> Result<()> {
        commands.fill_buffer(&self.counts, 0, 8, 0)?;
        commands.barrier(&[Access::TransferWrite], &[Access::ComputeWrite])?;
        commands.bind(pipeline, &[("counts", Resource::Storage(&self.counts))])?;
        commands.keep(&self.table);
        commands.push_constants(&push(&self.table, self.values))?;
        commands.zone("count", |c| c.dispatch_rows(pipeline.workgroups(self.values)))
    }

    fn expected(&self) -> Vec<u32> {
        let odd = (0..self.values).filter(|i| (i.wrapping_mul(2_654_435_761) >> 7) & 1 == 1);
        vec![odd.count() as u32, self.values]
    }
}

#[test]
fn ballots_over_a_table_read_by_address_count_right() {
    let Some(context) = device() else { return };
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 64)]).unwrap();
    assert_eq!(pipeline.workgroup_size(), [64, 1, 1]);
    let count = Count::new(&context, 100_003);
    let mut commands = Commands::new(&context, "count").unwrap();
    // Twice, to see that commands can be used again.
    for _ in 0..2 {
        commands.begin().unwrap();
        count.record(&mut commands, &pipeline).unwrap();
        let times = commands.submit_and_wait().unwrap();
        assert_eq!(count.counts.read::<u32>(0, 2).unwrap(), count.expected());
        let ms = times.ms("count").unwrap();
        assert!(ms > 0.0 && ms < times.wall_ms, "{ms} ms on the GPU, {} in all", times.wall_ms);
    }
}

#[test]
fn more_workgroups_than_one_dimension_holds_all_run() {
    let Some(context) = device() else { return };
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 8)]).unwrap();
    let count = Count::new(&context, 70_000 * 8 - 3);
    assert!(pipeline.workgroups(count.values) > 65_535);
    Commands::once(&context, "rows", |commands| count.record(commands, &pipeline)).unwrap();
    assert_eq!(count.counts.read::<u32>(0, 2).unwrap(), count.expected());
}

#[test]
fn zones_nest_and_add_up() {
    let Some(context) = device() else { return };
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 64)]).unwrap();
    let count = Count::new(&context, 200_000);
    let times = Commands::once(&context, "zones", |commands| {
        commands.zone("frame", |commands| {
            commands.zone("empty", |_| Ok(()))?;
            count.record(commands, &pipeline)?;
            commands.barrier(&[Access::ComputeWrite], &[Access::TransferWrite])?;
            count.record(commands, &pipeline)
        })
    })
    .unwrap();
    let names: Vec<_> = times.zones.iter().map(|z| (z.name.as_str(), z.depth)).collect();
    assert_eq!(names, [("frame", 0), ("empty", 1), ("count", 1), ("count", 1)]);
    let ms = |name| times.ms(name).unwrap();
    // A timestamp that slips past its dispatch would give the time to the wrong zone.
    assert!(ms("empty") < ms("count") && ms("count") <= ms("frame"), "{times:?}");
}

#[test]
fn wrong_bindings_are_errors() {
    type Case<'a> = (&'a str, &'a [(&'a str, Resource<'a>)], &'a str);
    let Some(context) = device() else { return };
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 64)]).unwrap();
    let usage = Usage::STORAGE_BUFFER | Usage::UNIFORM_BUFFER;
    let buffer = Buffer::new(&context, "counts", 8, usage, Memory::Device).unwrap();
    let plain = Buffer::new(&context, "plain", 8, Usage::empty(), Memory::Device).unwrap();
    let good = ("counts", Resource::Storage(&buffer));
    let cases: &[Case<'_>] = &[
        ("missing", &[], "no resource was given"),
        ("unknown", &[good, ("count", Resource::Storage(&buffer))], "there is none"),
        ("kind", &[("counts", Resource::Uniform(&buffer))], "takes Storage"),
        ("twice", &[good, good], "twice"),
        ("usage", &[("counts", Resource::Storage(&plain))], "was not created for"),
    ];
    let mut commands = Commands::new(&context, "wrong").unwrap();
    commands.begin().unwrap();
    for (case, resources, text) in cases {
        let error = commands.bind(&pipeline, resources).unwrap_err();
        assert!(matches!(error, VulkanError::Binding { .. }), "{case}: {error:?}");
        assert!(error.to_string().contains(text), "{case}: {error}");
    }
    commands.bind(&pipeline, &[good]).unwrap();
    let error = commands.push_constants(&1u32).unwrap_err().to_string();
    assert!(error.contains("4 bytes were given, it takes 12"), "{error}");
}

#[test]
fn commands_in_the_wrong_order_are_errors() {
    let Some(context) = device() else { return };
    let pipeline = ComputePipeline::new(&context, &BALLOT_COMP, &[(0, 64)]).unwrap();
    let mut commands = Commands::new(&context, "order").unwrap();
    assert!(commands.dispatch(1, 1, 1).is_err(), "recorded before begin");
    assert!(commands.wait().is_err(), "waited for nothing");
    commands.begin().unwrap();
    assert!(commands.dispatch(1, 1, 1).is_err(), "nothing bound");
    assert!(commands.end_rendering().is_err(), "not rendering");
    assert!(commands.draw(3, 1).is_err(), "not rendering");
    assert!(commands.dispatch(70_000, 1, 1).is_err());
    let count = Count::new(&context, 100);
    commands.bind(&pipeline, &[("counts", Resource::Storage(&count.counts))]).unwrap();
    let most = context.limits().max_compute_work_group_count[0];
    if most < u32::MAX {
        let error = commands.dispatch(most + 1, 1, 1).unwrap_err();
        assert!(error.to_string().contains("the limits are"), "{error}");
    }
}

#[test]
fn buffers_check_their_ranges_and_memory() {
    let Some(context) = device() else { return };
    let storage = Usage::STORAGE_BUFFER;
    let mut host = Buffer::from_slice(&context, "host", storage, &[1u32, 2, 3]).unwrap();
    assert_eq!(host.read::<u32>(4, 2).unwrap(), [2, 3]);
    host.write(8, &[9u32]).unwrap();
    assert_eq!(host.read::<u32>(0, 3).unwrap(), [1, 2, 9]);
    assert!(host.read::<u32>(8, 2).is_err());
    assert!(host.read::<u32>(u64::MAX, 2).is_err());
    assert!(host.write(12, &[0u8]).is_err());
    assert!(Buffer::new(&context, "empty", 0, storage, Memory::Device).is_err());
    let device = Buffer::new(&context, "device", 8, storage, Memory::Device).unwrap();
    // Software renderers map all memory: what matters is that there is an answer, not a crash.
    let _ = device.read::<u32>(0, 2);
    assert_ne!(device.device_address(), 0);
    let mut upload = Upload::new(&context, 1024);
    assert!(upload.buffer(&device, 4, &[1u32, 2]).is_err());
}
