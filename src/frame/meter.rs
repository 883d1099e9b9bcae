//! Stage `meter`: how bright the picture is, and the exposure that follows from it. In: the radiance. Out: a factor on exposure that
//! `tonemap` reads. Shaders: `meter.comp`, `expose.comp`.
//!
//! Counts are whole numbers: the same picture gives the same exposure, in whatever order the GPU counts.

use super::passed::Shared;
use crate::shaders;
use crate::vulkan::{Access, Buffer, Commands, ComputePipeline, Context, ImageView, Memory, Resource, Result, Usage};
use std::sync::Arc;
use terrane_planet::draw::layout::{METER_BINS, METER_STRIDE};

/// The stage's pipelines, histogram and result.
pub(super) struct Meter {
    meter: ComputePipeline,
    expose: ComputePipeline,
    zeros: Buffer,
    histogram: Buffer,
    factor: Buffer,
}

impl Meter {
    /// Builds the pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Meter> {
        let bytes = u64::from(4 * METER_BINS);
        let mut zeros = Buffer::new(context, "zeros", bytes, Usage::TRANSFER_SRC, Memory::Upload)?;
        zeros.write(0, &[0u32; METER_BINS as usize])?;
        Ok(Meter {
            meter: ComputePipeline::new(context, &shaders::METER_COMP, &[])?,
            expose: ComputePipeline::new(context, &shaders::EXPOSE_COMP, &[])?,
            zeros,
            histogram: Buffer::new(context, "histogram", bytes, Usage::STORAGE_BUFFER, Memory::Device)?,
            factor: Buffer::new(context, "exposure", 4, Usage::STORAGE_BUFFER | Usage::UNIFORM_BUFFER, Memory::Device)?,
        })
    }

    /// Records the stage: the factor on exposure that `radiance` asks for.
    pub(super) fn record<'a>(
        &'a self,
        commands: &mut Commands,
        shared: &Shared<'a>,
        radiance: &'a ImageView,
    ) -> Result<&'a Buffer> {
        commands.ready(&[self.histogram.to(Access::TransferWrite)])?;
        commands.copy_buffer((&self.zeros, 0), (&self.histogram, 0), self.zeros.bytes())?;
        commands.ready(&[self.histogram.to(Access::ComputeWrite), radiance.to(Access::Sampled)])?;
        let histogram = ("Histogram", Resource::Storage(&self.histogram));
        commands.bind(&self.meter, &[shared.pixels("radiance", radiance), histogram])?;
        let [x, y, _] = self.meter.workgroup_size();
        let (width, height) = radiance.size();
        commands.dispatch(width.div_ceil(METER_STRIDE * x), height.div_ceil(METER_STRIDE * y), 1)?;
        commands.ready(&[self.histogram.to(Access::ComputeRead), self.factor.to(Access::ComputeWrite)])?;
        commands.bind(&self.expose, &[shared.shading(), histogram, ("Exposure", Resource::Storage(&self.factor))])?;
        commands.dispatch(1, 1, 1)?;
        Ok(&self.factor)
    }

    /// The factor on exposure; undefined before the first metered frame.
    pub(super) fn factor(&self) -> &Buffer {
        &self.factor
    }
}
