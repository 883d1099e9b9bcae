//! GPU time by zone.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use crate::vulkan::error::{api, Result};
use crate::vulkan::Context;

/// Zones timed in one submission; later ones are labels only.
pub const MAX_ZONES: usize = 64;

/// The GPU time of one zone.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    /// Name of the zone.
    pub name: String,
    /// Zones around it.
    pub depth: u32,
    /// Milliseconds on the GPU.
    pub ms: f64,
}

/// GPU times of one submission, in the order in which the zones began. Software renderers do not count vertex work here:
/// report the wall time too.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timestamps {
    /// The zones; empty if the device has no timestamps.
    pub zones: Vec<Zone>,
    /// Milliseconds from submission to the end of the wait, however late the wait began.
    pub wall_ms: f64,
}

impl Timestamps {
    /// Milliseconds of all zones of this name, if there is one.
    pub fn ms(&self, name: &str) -> Option<f64> {
        let mut times = self.zones.iter().filter(|zone| zone.name == name).map(|zone| zone.ms);
        let first = times.next()?;
        Some(first + times.sum::<f64>())
    }
}

/// The query pool of some commands: two timestamps per zone.
pub(crate) struct Queries {
    context: Arc<Context>,
    pool: vk::QueryPool,
    zones: Vec<(String, u32)>,
    /// Of the last zone, timed or not.
    last: String,
    depth: u32,
}

impl Queries {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self> {
        let mut pool = vk::QueryPool::null();
        if context.gpu().timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_ZONES as u32);
            // SAFETY: the device is alive.
            pool = unsafe { context.device().create_query_pool(&info, None) }.map_err(api("vkCreateQueryPool"))?;
        }
        Ok(Self { context: context.clone(), pool, zones: Vec::new(), last: String::new(), depth: 0 })
    }

    /// Forgets all zones; `commands` is recording.
    pub(crate) fn reset(&mut self, commands: vk::CommandBuffer) {
        self.zones.clear();
        self.last = "none".to_owned();
        self.depth = 0;
        if self.pool != vk::QueryPool::null() {
            let count = 2 * MAX_ZONES as u32;
            // SAFETY: the commands are recording, and earlier ones that used the pool are done.
            unsafe { self.context.device().cmd_reset_query_pool(commands, self.pool, 0, count) };
        }
    }

    /// Begins a zone; its number, if it is timed.
    pub(crate) fn begin(&mut self, commands: vk::CommandBuffer, name: &str) -> Option<u32> {
        name.clone_into(&mut self.last);
        let depth = self.depth;
        self.depth += 1;
        if self.pool == vk::QueryPool::null() || self.zones.len() >= MAX_ZONES {
            return None;
        }
        let number = self.zones.len() as u32;
        self.zones.push((name.to_owned(), depth));
        self.stamp(commands, 2 * number);
        Some(number)
    }

    pub(crate) fn end(&mut self, commands: vk::CommandBuffer, number: Option<u32>) {
        self.depth = self.depth.saturating_sub(1);
        if let Some(number) = number {
            self.stamp(commands, 2 * number + 1);
        }
    }

    fn stamp(&self, commands: vk::CommandBuffer, query: u32) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: the commands are recording, and the query was reset by `reset` and is written once.
        unsafe { self.context.device().cmd_write_timestamp2(commands, all, self.pool, query) };
    }

    /// The zones that have begun, as far as the device tells after a failure.
    pub(crate) fn last_begun(&self) -> String {
        let begun = self.read().ok().and_then(|values| {
            let reached = values.iter().step_by(2).take_while(|value| value[1] != 0).count();
            self.zones.get(reached.checked_sub(1)?)
        });
        begun.map_or_else(|| self.last.clone(), |(name, _)| name.clone())
    }

    /// The times of all zones; the commands are done.
    pub(crate) fn resolve(&self, wall: Duration) -> Result<Timestamps> {
        let values = self.read()?;
        let mask = match self.context.gpu().timestamp_bits {
            64.. => u64::MAX,
            bits => (1 << bits) - 1,
        };
        let period = f64::from(self.context.limits().timestamp_period);
        let ms = |pair: &[[u64; 2]]| {
            let ticks = pair[1][0].wrapping_sub(pair[0][0]) & mask;
            ticks as f64 * period * 1e-6
        };
        let zone = |((name, depth), pair): (&(String, u32), &[[u64; 2]])| {
            // The second of each pair of values says whether the timestamp was written.
            let written = pair.iter().all(|value| value[1] != 0);
            written.then(|| Zone { name: name.clone(), depth: *depth, ms: ms(pair) })
        };
        let zones: Vec<Zone> = self.zones.iter().zip(values.chunks_exact(2)).filter_map(zone).collect();
        for Zone { name, ms, .. } in &zones {
            tracing::trace!(target: "terrane::gpu", "{name} {ms:.3} ms");
        }
        Ok(Timestamps { zones, wall_ms: wall.as_secs_f64() * 1e3 })
    }

    /// Value and availability of every timestamp of the zones.
    fn read(&self) -> Result<Vec<[u64; 2]>> {
        let mut values = vec![[0u64; 2]; 2 * self.zones.len()];
        if values.is_empty() {
            return Ok(values);
        }
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
        // SAFETY: the queries exist.
        let read = unsafe { self.context.device().get_query_pool_results(self.pool, 0, &mut values, flags) };
        match read {
            Ok(()) | Err(vk::Result::NOT_READY) => Ok(values),
            Err(result) => Err(api("vkGetQueryPoolResults")(result)),
        }
    }
}

impl Drop for Queries {
    fn drop(&mut self) {
        // SAFETY: the commands that used the pool are done; a null handle is ignored.
        unsafe { self.context.device().destroy_query_pool(self.pool, None) };
    }
}
