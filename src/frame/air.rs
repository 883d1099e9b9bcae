//! Stage `air`: look-up tables of the atmosphere (Hillaire 2020). In: the medium, the sun and the eye, in the shading block. Out: two
//! sets of tables that `draw`, `ocean`, `sky` and `stars` look up.
//!
//! What depends on the medium alone (transmittance, multiple scattering, the sky's irradiance) is computed when the medium changes;
//! what depends on eye and sun, every frame. Shaders: `transmittance.comp`, `multiple.comp`, `irradiance.comp`; `columns.comp`,
//! `aerial.comp`. Twin: `reference/air.rs`, by brute force.

use super::buffers::FrameBuffers;
use super::stage::Stage;
use crate::shaders;
use crate::vulkan::{
    vk, Access, Commands, ComputePipeline, Context, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription,
    Shader, Use,
};
use std::sync::Arc;
use terrane_planet::draw::layout::Shading;
use terrane_planet::reference::air::MULTIPLE_TABLE;

/// Transmittance: directions and heights.
const TRANSMITTANCE: (u32, u32) = (256, 64);
/// Multiple scattering and irradiance: elevations of the sun and heights.
const BY_SUN: (u32, u32) = MULTIPLE_TABLE;
/// Latitudes of the eye's rays, half of them below the horizon.
const LATITUDES: u32 = 128;
/// Azimuths from the sun's to the opposite one; the other half of the sky is the mirror image.
const AZIMUTHS: u32 = 40;
/// Shares of the way at which optical depths are kept.
const SHARES: u32 = 48;
/// Parts of a ray at which scattered light is kept.
const SLICES: u32 = 16;
/// Points of a ray at which scattering is sampled: four to a slice (parabolas go through two and two).
const NODES: u32 = 4 * (SLICES - 1) + 1;

/// Format of the tables.
const TABLE_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipelines and tables.
pub(super) struct Air {
    pipelines: Pipelines,
    transmittance: Image,
    multiple: Image,
    irradiance: Image,
    columns: Image,
    /// What the lights of a row's nodes share: light that passes, levels, densities.
    nodes: [Image; 3],
    scattered: Image,
    haze: Image,
    linear: Sampler,
    /// What the tables that last were computed for.
    medium: Option<[u32; MEDIUM_WORDS]>,
}

struct Pipelines {
    transmittance: ComputePipeline,
    multiple: ComputePipeline,
    irradiance: ComputePipeline,
    columns: ComputePipeline,
    aerial: ComputePipeline,
}

/// Words of the shading block that the lasting tables depend on.
const MEDIUM_WORDS: usize = 21;

impl Air {
    /// Builds pipelines and tables.
    pub(super) fn new(context: &Arc<Context>) -> Result<Air> {
        let pipeline = |shader: &Shader<'_>| ComputePipeline::new(context, shader, &[]);
        let table = |name, size, layers, format| {
            let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED;
            Image::new(context, &ImageDescription { layers, ..ImageDescription::new(name, size, format, usage) })
        };
        let node_table = |name| table(name, (NODES, LATITUDES), 1, vk::Format::R32G32B32A32_SFLOAT);
        let air = Air {
            pipelines: Pipelines {
                transmittance: pipeline(&shaders::TRANSMITTANCE_COMP)?,
                multiple: pipeline(&shaders::MULTIPLE_COMP)?,
                irradiance: pipeline(&shaders::IRRADIANCE_COMP)?,
                columns: pipeline(&shaders::COLUMNS_COMP)?,
                aerial: pipeline(&shaders::AERIAL_COMP)?,
            },
            transmittance: table("transmittance", TRANSMITTANCE, 1, TABLE_FORMAT)?,
            multiple: table("multiple scattering", BY_SUN, 1, TABLE_FORMAT)?,
            irradiance: table("irradiance", BY_SUN, 1, TABLE_FORMAT)?,
            columns: table("columns", (SHARES, LATITUDES), 1, TABLE_FORMAT)?,
            nodes: [node_table("nodes")?, node_table("levels")?, node_table("densities")?],
            scattered: table("scattered light", (AZIMUTHS, LATITUDES), SLICES, TABLE_FORMAT)?,
            haze: table("haze", (AZIMUTHS, LATITUDES), SLICES, TABLE_FORMAT)?,
            linear: Sampler::new(context, "tables", &SamplerDescription::default())?,
            medium: None,
        };
        Commands::once(context, "table layouts", |commands| {
            commands.ready(&air.tables().map(|table| table.view().anew(Access::Sampled)))
        })?;
        Ok(air)
    }

    fn tables(&self) -> [&Image; 9] {
        let [nodes, levels, densities] = &self.nodes;
        let Air { transmittance, multiple, irradiance, .. } = self;
        [transmittance, multiple, irradiance, &self.columns, nodes, levels, densities, &self.scattered, &self.haze]
    }

    /// Records what this frame needs: nothing on planets without air, the lasting tables where the medium is new.
    pub(super) fn record(&mut self, commands: &mut Commands, buffers: &FrameBuffers, shading: &Shading) -> Result<()> {
        if shading.scale_height <= 0.0 {
            return Ok(());
        }
        let medium = medium_words(shading);
        if self.medium != Some(medium) {
            Stage::AirTables.record(commands, |c| self.record_lasting(c, buffers))?;
            self.medium = Some(medium);
        }
        Stage::Air.record(commands, |c| self.record_eye(c, buffers))
    }

    fn record_lasting(&self, commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
        let shading = ("ShadingBlock", Resource::Uniform(buffers.shading()));
        let pipelines = &self.pipelines;
        self.fill(commands, &pipelines.transmittance, &[("table", &self.transmittance)], &[shading])?;
        let [transmittance, _] = self.light();
        self.fill(commands, &pipelines.multiple, &[("table", &self.multiple)], &[shading, transmittance])?;
        let multiple = self.sampled("multiple", &self.multiple);
        self.fill(commands, &pipelines.irradiance, &[("table", &self.irradiance)], &[shading, transmittance, multiple])
    }

    fn record_eye(&self, commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
        let shading = ("ShadingBlock", Resource::Uniform(buffers.shading()));
        let pipelines = &self.pipelines;
        let [nodes, levels, densities] = &self.nodes;
        let by_row = [("columns", &self.columns), ("nodes", nodes), ("levels", levels), ("densities", densities)];
        self.fill(commands, &pipelines.columns, &by_row, &[shading])?;
        let written = [("scattered_table", &self.scattered), ("haze_table", &self.haze)];
        let [transmittance, _] = self.light();
        let multiple = self.sampled("multiple", &self.multiple);
        let [nodes, levels, densities] = [by_row[1], by_row[2], by_row[3]].map(|(name, table)| self.sampled(name, table));
        let read = [shading, transmittance, multiple, nodes, levels, densities];
        self.fill(commands, &pipelines.aerial, &written, &read)
    }

    /// Runs a pipeline with an invocation for each texel of the first table that it writes.
    fn fill(
        &self,
        commands: &mut Commands,
        pipeline: &ComputePipeline,
        written: &[(&'static str, &Image)],
        read: &[(&'static str, Resource<'_>)],
    ) -> Result<()> {
        let uses = |each: fn(&Image) -> Use<'_>| written.iter().map(|(_, table)| each(table)).collect::<Vec<_>>();
        commands.ready(&uses(|table| table.view().anew(Access::ComputeWrite)))?;
        let outputs = written.iter().map(|(name, table)| (*name, Resource::StorageImage(table.view())));
        commands.bind(pipeline, &outputs.chain(read.iter().copied()).collect::<Vec<_>>())?;
        let [x, y, _] = pipeline.workgroup_size();
        let (width, height) = written[0].1.size();
        // A pipeline of rows has one invocation a row.
        if y == 1 {
            commands.dispatch(height.div_ceil(x), 1, 1)?;
        } else {
            commands.dispatch(width.div_ceil(x), height.div_ceil(y), 1)?;
        }
        commands.ready(&uses(|table| table.view().to(Access::Sampled)))
    }

    fn sampled<'a>(&'a self, name: &'static str, table: &'a Image) -> (&'static str, Resource<'a>) {
        (name, Resource::Sampled(table.view(), &self.linear))
    }

    /// What `shared/skylight.glsl` binds.
    pub(super) fn light(&self) -> [(&'static str, Resource<'_>); 2] {
        [self.sampled("transmittance", &self.transmittance), self.sampled("irradiance", &self.irradiance)]
    }

    /// What `shared/eye_air.glsl` binds.
    pub(super) fn eye(&self) -> [(&'static str, Resource<'_>); 3] {
        [
            self.sampled("columns", &self.columns),
            self.sampled("scattered_table", &self.scattered),
            self.sampled("haze_table", &self.haze),
        ]
    }
}

fn medium_words(s: &Shading) -> [u32; MEDIUM_WORDS] {
    let single = [
        s.radius,
        s.scale_height,
        s.mie_scale_height,
        s.mie_g,
        s.ozone_height,
        s.ozone_reach,
        s.air_bottom,
        s.air_top,
        s.ground_albedo,
    ];
    let mut words = [0; MEDIUM_WORDS];
    let all = single.into_iter().chain(s.rayleigh).chain(s.mie).chain(s.mie_extinction).chain(s.ozone);
    words.iter_mut().zip(all).for_each(|(word, value)| *word = value.to_bits());
    words
}
