//! What a scene may use, and how much that is in patches.

use super::keeper::CacheOptions;
use super::{drawn_ground, loader, resident, textures};
use std::sync::Arc;
use terrane_planet::published::PublishedPlanet;
use terrane_planet::store::slow::Delay;

/// Fewest patches on the GPU: the six whole faces, and the children of one.
const LEAST_PATCHES: u32 = 10;

/// Patches taken in by each frame, of a megabyte and a half each: the first for frames that keep up with the screen; slow frames take
/// more, so that a slow device does not stay coarse for minutes.
const UPLOADS_PER_FRAME: (usize, usize) = (6, 36);

/// Patches taken in during a second, between these limits.
const UPLOADS_PER_SECOND: f64 = 120.0;

/// Most patches under way to the GPU at a time.
const MOST_UNDER_WAY: usize = 64;

/// One in so many bytes of the host's budget is for patches under way.
const HOST_SHARE_UNDER_WAY: u64 = 4;

/// Building what the planet file lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct OnDemand {
    /// Spacing of samples in metres at which there is nothing finer to be built.
    pub spacing_m: f64,
    /// Where built patches are kept for another time; nowhere if `None`.
    pub cache: Option<CacheOptions>,
}

/// Which patches a scene loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// What a picture shows, and nothing else.
    #[default]
    Still,
    /// What a moving camera needs: first what is in sight, coarse to fine, so that there is always a picture, and the ground below; then
    /// what surrounds it.
    Flight,
    /// All of the planet that a view asks for, out of sight too: for checks of the mesh.
    Whole,
}

/// What a scene may use.
#[derive(Clone, Debug)]
pub struct SceneOptions {
    /// Most bytes of patches on the GPU: their vertices, triangle lists and textures. Room for the six whole faces and one set of
    /// children is always taken. Nothing is allocated before it is needed. With textures there are at most 49 times as many patches as
    /// the device has image layers.
    pub gpu_bytes: u64,
    /// Most bytes of main memory for patches: the ground of those on the GPU, for cameras, and those on their way there. Room for as
    /// many patches as with the least on the GPU, and for one under way, is always taken.
    pub host_bytes: u64,
    /// Whether to load textures (checks of the mesh do without).
    pub textures: bool,
    /// Whether and how to build what the file lacks.
    pub on_demand: Option<OnDemand>,
    /// Which patches are loaded.
    pub scope: Scope,
    /// Reads the planet file as over a line that is so slow, for measurements.
    pub delay: Option<Delay>,
    /// Where the planet is published: patches that the file lacks are fetched from there or built, whatever is sooner. Of another planet
    /// than the file's, or one whose ground is another by now, nothing is fetched.
    pub published: Option<Arc<PublishedPlanet>>,
}

impl SceneOptions {
    /// Every patch that a view asks for, without textures: for checks of the mesh.
    pub fn whole_mesh() -> Self {
        SceneOptions {
            gpu_bytes: u64::MAX,
            host_bytes: u64::MAX,
            textures: false,
            on_demand: None,
            scope: Scope::Whole,
            delay: None,
            published: None,
        }
    }
}

impl Default for SceneOptions {
    fn default() -> Self {
        SceneOptions {
            gpu_bytes: 3 << 30,
            host_bytes: 1 << 30,
            textures: true,
            on_demand: None,
            scope: Scope::Still,
            delay: None,
            published: None,
        }
    }
}

/// Patches that a frame may take in if the one before took so many seconds.
pub fn uploads_within(seconds: f64) -> usize {
    ((seconds * UPLOADS_PER_SECOND) as usize).clamp(UPLOADS_PER_FRAME.0, UPLOADS_PER_FRAME.1)
}

/// One in so many bytes of a mesh is what a still's view can wake of it, at most on average over the patches that it draws (measured: a twelfth).
const STILL_SHARE: u64 = 4;

/// A scene's budgets.
pub(super) struct Budget {
    /// Most patches on the GPU.
    pub(super) capacity: u32,
    /// Most bytes of their meshes.
    pub(super) mesh_bytes: u64,
    /// Most under way to it.
    pub(super) under_way: usize,
}

impl Budget {
    /// The budgets of options, for patches of `cells` cells a side. There are `most_patches` at most, and textures have as
    /// many `layers`.
    pub(super) fn new(options: &SceneOptions, cells: u32, most_patches: u32, layers: u32) -> Budget {
        // Only textures need slots, and come in whole layers.
        let most = if options.textures { layers.saturating_mul(textures::SLOTS_PER_LAYER) } else { u32::MAX };
        let tile = if options.textures { textures::bytes_of_tile(cells) } else { 0 };
        // The six whole faces are always whole.
        let whole = resident::bytes_of_patch(cells);
        let mesh = if options.scope == Scope::Still { whole / STILL_SHARE } else { whole };
        let faces = 6 * (whole - mesh);
        let gpu_bytes = options.gpu_bytes.saturating_sub(tile * u64::from(textures::SLOTS_PER_LAYER - 1) + faces);
        let under_way = usize::try_from(options.host_bytes / HOST_SHARE_UNDER_WAY / loader::bytes_under_way(cells));
        let host_bytes = options.host_bytes - options.host_bytes / HOST_SHARE_UNDER_WAY;
        let room = (gpu_bytes / (mesh + tile)).min(host_bytes / drawn_ground::bytes_of_patch(cells, options.scope));
        let capacity = u32::try_from(room).unwrap_or(u32::MAX).clamp(LEAST_PATCHES, most).min(most_patches);
        Budget {
            capacity,
            // All that textures leave.
            mesh_bytes: gpu_bytes
                .saturating_sub(u64::from(capacity) * tile)
                .max(u64::from(capacity) * mesh)
                .saturating_add(faces),
            under_way: under_way.unwrap_or(MOST_UNDER_WAY).clamp(1, MOST_UNDER_WAY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_hold_whole_layers_and_more_patches_than_the_device_has_layers() {
        let layers = 2048;
        for cells in [8, 32, 128] {
            let tile = textures::bytes_of_tile(cells);
            for gpu_bytes in [100 << 20, 1 << 30, 3 << 30, 20 << 30, 1 << 40] {
                let options = SceneOptions { gpu_bytes, host_bytes: u64::MAX, ..SceneOptions::default() };
                let Budget { capacity, mesh_bytes, .. } = Budget::new(&options, cells, u32::MAX, layers);
                let slots = u64::from(capacity.next_multiple_of(textures::SLOTS_PER_LAYER));
                let bytes = mesh_bytes + slots * tile;
                assert!(bytes <= gpu_bytes, "{cells} cells, {gpu_bytes} bytes: {capacity} patches take {bytes}");
                assert!(capacity <= textures::SLOTS_PER_LAYER * layers);
                let next = bytes + u64::from(textures::SLOTS_PER_LAYER) * tile + resident::bytes_of_patch(cells);
                assert!(
                    next > gpu_bytes || capacity == textures::SLOTS_PER_LAYER * layers,
                    "{cells} cells, {gpu_bytes} bytes: more than {capacity} fit"
                );
            }
        }
        let all = SceneOptions { gpu_bytes: u64::MAX, host_bytes: u64::MAX, ..SceneOptions::default() };
        assert_eq!(Budget::new(&all, 128, u32::MAX, layers).capacity, textures::SLOTS_PER_LAYER * layers);
        // Where there are few patches, all of each fits.
        let few = Budget::new(&SceneOptions::default(), 32, 30, layers);
        assert!(few.capacity == 30 && few.mesh_bytes >= 30 * resident::bytes_of_patch(32));
        let mesh = SceneOptions::whole_mesh();
        assert_eq!(Budget::new(&mesh, 128, 70_000, layers).capacity, 70_000);
    }
}
