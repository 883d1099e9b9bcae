//! The stages of a frame: one name each, for timestamp zones, tables, JSON keys and plots.

use crate::vulkan::{Commands, Result, Timestamps};
use std::ops::Index;

/// A stage of a frame, in the order of recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Awake bits and drawn positions of the vertices.
    Select,
    /// The vertex that each vertex is drawn as.
    Resolve,
    /// The triangles to draw.
    Emit,
    /// The air's lasting tables, only where the medium is new.
    AirTables,
    /// The air's tables of the eye.
    Air,
    /// The ground.
    Draw,
    /// Pixels that show several surfaces.
    Edges,
    /// The sea.
    Ocean,
    /// The mesh's edges, only in wire mode.
    Lines,
    /// The air in front of everything, and the clouds.
    Sky,
    /// Points of light behind everything.
    Stars,
    /// The picture's luminance, only where exposure is metered.
    Meter,
    /// From radiance to 8 bits a channel.
    Tonemap,
    /// From fewer pixels to all of the picture's, only where fewer are drawn.
    Upscale,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Stage; 14] = [
        Stage::Select,
        Stage::Resolve,
        Stage::Emit,
        Stage::AirTables,
        Stage::Air,
        Stage::Draw,
        Stage::Edges,
        Stage::Ocean,
        Stage::Lines,
        Stage::Sky,
        Stage::Stars,
        Stage::Meter,
        Stage::Tonemap,
        Stage::Upscale,
    ];

    /// How many there are.
    pub const COUNT: usize = Stage::ALL.len();

    /// The stages that make the mesh.
    pub const MESH: [Stage; 3] = [Stage::Select, Stage::Resolve, Stage::Emit];

    /// Whether its time grows with the pixels that are drawn.
    pub fn works_on_pixels(self) -> bool {
        use Stage::{Draw, Edges, Lines, Meter, Ocean, Sky, Stars, Tonemap};
        matches!(self, Draw | Edges | Ocean | Lines | Sky | Stars | Meter | Tonemap)
    }

    /// The name in timestamp zones, tables and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Stage::Select => "select",
            Stage::Resolve => "resolve",
            Stage::Emit => "emit",
            Stage::AirTables => "air tables",
            Stage::Air => "air",
            Stage::Draw => "draw",
            Stage::Edges => "edges",
            Stage::Ocean => "ocean",
            Stage::Lines => "lines",
            Stage::Sky => "sky",
            Stage::Stars => "stars",
            Stage::Meter => "meter",
            Stage::Tonemap => "tonemap",
            Stage::Upscale => "upscale",
        }
    }

    /// Records the stage with `body`, in its timestamp zone.
    pub(super) fn record<R>(self, commands: &mut Commands, body: impl FnOnce(&mut Commands) -> Result<R>) -> Result<R> {
        commands.zone(self.name(), body)
    }
}

/// A value for each stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerStage<T>([T; Stage::COUNT]);

impl<T> PerStage<T> {
    /// The values that `value` gives.
    pub fn from_fn(value: impl FnMut(Stage) -> T) -> PerStage<T> {
        PerStage(Stage::ALL.map(value))
    }

    /// The stages in order, each with its value.
    pub fn iter(&self) -> impl Iterator<Item = (Stage, &T)> {
        Stage::ALL.into_iter().zip(&self.0)
    }
}

impl PerStage<Option<f64>> {
    /// GPU milliseconds of each stage; `None` for stages that did not run, or without timestamps.
    pub fn gpu_ms(times: &Timestamps) -> PerStage<Option<f64>> {
        PerStage::from_fn(|stage| times.ms(stage.name()))
    }
}

impl<T> Index<Stage> for PerStage<T> {
    type Output = T;

    fn index(&self, stage: Stage) -> &T {
        &self.0[stage as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::{PerStage, Stage};

    #[test]
    fn every_stage_stands_at_its_index_under_a_name_of_its_own() {
        let per_stage = PerStage::from_fn(|stage| stage);
        for (k, stage) in Stage::ALL.into_iter().enumerate() {
            assert_eq!((stage as usize, per_stage[stage]), (k, stage));
            assert_eq!(Stage::ALL.iter().filter(|other| other.name() == stage.name()).count(), 1);
        }
    }
}
