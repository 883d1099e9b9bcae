//! Clouds of the planet on the GPU: how much cloud there is in every direction, and finer detail.

use super::keeper::KeeperHandle;
use super::Scene;
use crate::vulkan::{vk, Context, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription, Upload};
use std::sync::mpsc::{channel, Receiver, RecvTimeoutError};
use std::sync::Arc;
use std::time::Duration;
use terrane_planet::maps::clouds::{cloud_detail, cloud_levels, CloudLevel, CLOUD_SIDE, DETAIL_SIDE};
use terrane_planet::planet::Planet;
use terrane_planet::store::Records;

/// Bytes staged at a time.
const CHUNK: u64 = 8 << 20;

/// The map of clouds where it takes long to come: everything else goes first.
pub(super) enum LateClouds {
    /// How to come by it.
    Waiting(Box<dyn FnOnce() -> Option<CloudLevel> + Send>),
    /// On its way.
    Coming(Receiver<Option<CloudLevel>>),
}

/// What finds the map of a planet's clouds in its files, or computes it.
pub(super) fn fetcher(
    files: Vec<Box<dyn Records>>,
    planet: Arc<Planet>,
    keeper: Option<KeeperHandle>,
) -> impl FnOnce() -> Option<CloudLevel> + Send {
    move || {
        let (map, is_new) = planet.clouds(files.iter().map(|file| &**file))?;
        if let Some(keeper) = keeper.filter(|_| is_new) {
            keeper.computed(map.clone());
        }
        Some(map)
    }
}

impl Scene {
    /// Takes in the clouds, if they are there before a limit.
    pub(super) fn take_clouds(&mut self, limit: Duration) -> Result<()> {
        if let Some(map) = self.late_clouds.as_ref().and_then(|clouds| clouds.wait(limit)) {
            self.clouds = CloudMaps::new(&self.context, self.planet.recipe.seed, map)?;
            self.late_clouds = None;
        }
        Ok(())
    }
}

impl LateClouds {
    /// Lets it come, if it does not yet.
    pub(super) fn start(self) -> LateClouds {
        match self {
            LateClouds::Waiting(fetch) => {
                let (sender, receiver) = channel();
                // Nobody waits for it when the scene is gone.
                std::thread::spawn(move || drop(sender.send(fetch())));
                LateClouds::Coming(receiver)
            }
            coming => coming,
        }
    }

    /// The map, if it is there before a limit. Without one it never is.
    pub(super) fn wait(&self, limit: Duration) -> Option<Option<CloudLevel>> {
        match self {
            LateClouds::Waiting(_) => None,
            LateClouds::Coming(receiver) => match receiver.recv_timeout(limit) {
                Ok(map) => Some(map),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => Some(None),
            },
        }
    }
}

/// The maps; of one black texel where the recipe has no clouds.
pub struct CloudMaps {
    map: Image,
    detail: Image,
    clamp: Sampler,
    repeat: Sampler,
}

impl CloudMaps {
    /// Uploads the `map` of a recipe's clouds, if there is one, and computes what is finer.
    pub(super) fn new(context: &Arc<Context>, seed: u64, map: Option<CloudLevel>) -> Result<CloudMaps> {
        let (levels, detail, side, detail_side) = match map {
            Some(map) => (cloud_levels(map, CLOUD_SIDE), cloud_detail(seed), CLOUD_SIDE, DETAIL_SIDE),
            None => (vec![vec![0]], vec![vec![[0.0]]], 1, 1),
        };
        let image = |name, side: usize, format| {
            let plain = ImageDescription::new(name, (side as u32, side as u32), format, vk::ImageUsageFlags::SAMPLED);
            Image::new(context, &ImageDescription { mips: side.ilog2() + 1, ..plain })
        };
        let map = image("clouds", side, vk::Format::R8_UNORM)?;
        let tile = image("cloud detail", detail_side, vk::Format::R16_SFLOAT)?;
        let mut upload = Upload::new(context, CHUNK);
        for (mip, texels) in levels.iter().enumerate() {
            upload.image(&map, 0, mip as u32, texels)?;
        }
        for (mip, texels) in detail.iter().enumerate() {
            let halves: Vec<u16> = texels.iter().map(|&[x]| half::f16::from_f32(x).to_bits()).collect();
            upload.image(&tile, 0, mip as u32, &halves)?;
        }
        upload.finish()?;
        let repeat = SamplerDescription { address: vk::SamplerAddressMode::REPEAT, ..SamplerDescription::default() };
        let (clamp, repeat) =
            (Sampler::new(context, "clouds", &SamplerDescription::default())?, Sampler::new(context, "cloud detail", &repeat)?);
        Ok(CloudMaps { map, detail: tile, clamp, repeat })
    }

    /// What `shared/clouds.glsl` binds.
    pub(crate) fn bound(&self) -> [(&'static str, Resource<'_>); 2] {
        [
            ("cloud_map", Resource::Sampled(self.map.view(), &self.clamp)),
            ("cloud_detail", Resource::Sampled(self.detail.view(), &self.repeat)),
        ]
    }
}
