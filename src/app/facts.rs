//! What the interface says of the frame before: a snapshot, so that laying out asks nothing of the scene.

use super::inspection::Inspected;
use super::outlines::Line;
use super::viewer::Manner;
use crate::frame::PerStage;
use crate::scene::EditStatus;
use terrane_planet::draw::layout::EmitState;
use terrane_planet::recipe::Place;

/// Numbers of a frame.
pub(super) struct Facts {
    /// Name of the planet.
    pub(super) planet: String,
    /// Its radius in metres.
    pub(super) radius_m: f64,
    /// Its axial tilt in degrees.
    pub(super) tilt: f64,
    /// Degrees north and east.
    pub(super) site: [f64; 2],
    /// Metres of the eye above the datum.
    pub(super) height_m: f64,
    /// Metres of the eye above ground or sea.
    pub(super) altitude_m: f64,
    /// Metres of the ground below above the datum, where it is known.
    pub(super) ground_m: Option<f64>,
    /// Degrees clockwise from north, and above the horizontal.
    pub(super) look: [f64; 2],
    /// Degrees.
    pub(super) fov: f64,
    /// Which camera moves the viewer, and at which factor of its usual speed.
    pub(super) manner: Manner,
    pub(super) speed: f64,
    /// Whether there are places to go back to, and forward to.
    pub(super) places: [bool; 2],
    /// Places of the recipe.
    pub(super) named: Vec<Place>,
    /// Whether a path is played.
    pub(super) plays: bool,
    /// Whether the planet has air, a sea and clouds.
    pub(super) has: [bool; 3],
    /// Counters of a frame that is done.
    pub(super) counters: EmitState,
    /// Vertices that selection looked at.
    pub(super) prefix_vertices: u32,
    /// Patches drawn, by level.
    pub(super) levels: Vec<u32>,
    /// Patches asked for that are not there yet.
    pub(super) pending: usize,
    /// Patches read and built since the planet was opened.
    pub(super) read: u64,
    pub(super) built: u64,
    /// Bytes that patches take on the GPU, and in main memory; of each also the most they may take.
    pub(super) bytes: [(u64, u64); 2],
    /// Bytes of everything on the GPU.
    pub(super) allocated: u64,
    /// GPU milliseconds of the stages of a frame that is done.
    pub(super) stages: PerStage<Option<f64>>,
    /// Pixels drawn along a side for each of the window's.
    pub(super) density: f64,
    /// Name of the device.
    pub(super) device: String,
    /// Whether the selection is frozen.
    pub(super) frozen: bool,
    /// How far the latest edit of the ground is.
    pub(super) edits: EditStatus,
    /// What was picked.
    pub(super) picked: Option<Inspected>,
    /// Lines over the picture.
    pub(super) lines: Vec<Line>,
}

impl Facts {
    /// Patches drawn.
    pub(super) fn patches(&self) -> u32 {
        self.levels.iter().sum()
    }
}
