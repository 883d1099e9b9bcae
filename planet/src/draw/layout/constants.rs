//! Numbers that both the shaders and Rust know, each declared here or where it belongs (then [`elsewhere`] names it), and their GLSL.

use super::glsl::GlslConstant;
use crate::draw::cut::FADE_FROM;
use crate::globe::patch::Side;
use crate::ground::texture::SHORE_RANGE;
use crate::ground::GUTTER;
use crate::maps::clouds::CLOUD_EDGE;
use crate::maps::grain::{CROWN_LAYER, GROUND_LAYER};
use crate::maps::waves::{CASCADES, REPEAT_M};
use crate::mesh::certificate::DEVIATION_SHARE;
use crate::mesh::wake::{Wake, MANTISSA_BITS};

macro_rules! shared_constants {
    ($($(#[$meta:meta])* $name:ident: $ty:ty = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: $ty = $value;)*

        /// GLSL of the constants that are declared in this file.
        fn declared_here() -> Vec<String> {
            vec![$($name.declare(stringify!($name))),*]
        }
    };
}

shared_constants! {
    /// Triangles outside one frustum plane are not emitted.
    CULL_FRUSTUM: u32 = 1;
    /// Triangles that face away from the camera are not emitted.
    CULL_BACK: u32 = 2;
    /// Relative rounding error below which a triangle seen edge-on still counts as facing the eye.
    BACK_SLACK: f32 = 1e-5;
    /// Texture slot of a patch without one.
    NO_SLOT: u32 = u32::MAX;
    /// Texture tiles along a side of an image layer: slot s is tile s mod T² of layer s / T², row by row.
    TILES_PER_SIDE: u32 = 7;
    /// Sea level of a planet without a sea.
    NO_SEA: f32 = -1e30;
    /// Bits of an emitted index that name the vertex; the rest name the patch.
    VERTEX_BITS: u32 = 15;
    /// Vertices a workgroup selects.
    SELECT_CHUNK: u32 = 1024;
    /// Vertices a workgroup resolves.
    RESOLVE_CHUNK: u32 = 256;

    /// Irradiance of the sun outside the air, in the units that exposure maps to the display.
    SUN: f64 = 10.0;
    /// The sun's angular radius.
    SUN_RADIUS: f64 = 0.00465;
    /// Share of the sun's light that lenses and eyes spread over a steradian, times the cube of the angle (Vos 1984).
    GLARE: f64 = 1.7e-6;
    /// Irradiance of the night sky on level ground: airglow, and earthshine of a kind. Brighter than true, so that nights are dark and
    /// not black at the exposure of days.
    NIGHT: [f64; 3] = [0.014, 0.018, 0.024];
    /// Directions in which multiple scattering is looked for: so many in a round, and so many rounds from nadir to zenith.
    MULTIPLE_ROUND: i32 = 8;
    /// See [`MULTIPLE_ROUND`].
    MULTIPLE_LAYERS: i32 = 8;
    /// Steps of each of these rays.
    MULTIPLE_STEPS: i32 = 32;

    /// Stars in the sky; their magnitudes are spread accordingly.
    STARS: u32 = 9000;

    /// Bins of the histogram of luminance.
    METER_BINS: u32 = 128;
    /// Of both directions of a picture, the meter counts every so many-th pixel.
    METER_STRIDE: u32 = 4;

    /// Luminance of the primaries.
    LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
    /// Middle grey.
    TONE_GREY: f32 = 0.18;
    /// What the curve adds to the slope of the logarithm of light just below grey, and over how many powers of e that goes on: then
    /// shadows run parallel to what they were, so that nights keep their detail.
    TONE_SHADOWS: [f32; 2] = [0.72, 1.25];
    /// What is added to the power of channels over luminance where it is dark; half as much at middle grey, and little in the light.
    TONE_SATURATION: f32 = 0.42;
    /// Where the shoulder begins that leads to 1, of the brightest channel (as in PBR Neutral, Khronos 2024).
    TONE_SHOULDER: f32 = 0.76;
    /// How fast what lies beyond it pales.
    TONE_PALING: f32 = 0.5;
    /// Factor on light before the curve of AgX: with it a level card of middle grey comes out at about the same code as by the other.
    AGX_EXPOSURE: f32 = 1.5;
    /// How channels are mixed before the curve of AgX (Sobotka 2022, in Wrensch's fit), by columns.
    AGX_MIX: [f32; 9] = [0.936992, 0.016931, 0.016950, 0.031373, 0.951387, 0.031373, 0.031689, 0.031666, 0.951657];
    /// How they are unmixed after it.
    AGX_UNMIX: [f32; 9] = [1.068485, -0.018402, -0.018424, -0.034099, 1.052838, -0.034102, -0.034445, -0.034420, 1.052547];
    /// Powers of two that the curve maps to black and white.
    AGX_RANGE: [f32; 2] = [-12.47393, 4.026069];
    /// The curve's polynomial, from the sixth power down to the constant.
    AGX_CURVE: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
    /// Exponent of what the curve gives.
    AGX_CONTRAST: f32 = 1.4;
    /// Factor on differences from grey.
    AGX_SATURATION: f32 = 1.35;
    /// Interleaved gradient noise (Jimenez 2014): weights of column and row, and the factor on what they give.
    DITHER: [f32; 3] = [0.067_110_56, 0.005_837_15, 52.982_918];

    /// Most pixels along an edge, each way, after which its ends are looked for no more.
    EDGE_REACH: i32 = 128;
    /// Rows of pixels between which an invocation looks for edges.
    EDGE_ROWS: i32 = 4;
}

/// Most patches a frame can draw, 131,071: the rest of an emitted index, short of the restart value.
pub const MAX_PATCHES: u32 = (1 << (32 - VERTEX_BITS)) - 1;
/// Triangles a workgroup emits.
pub const EMIT_CHUNK: u32 = 256;

macro_rules! modes {
    ($($(#[$meta:meta])* $mode:ident = $name:literal,)*) => {
        /// How ground is drawn.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum Mode {
            $($(#[$meta])* $mode,)*
        }

        impl Mode {
            /// All modes.
            pub const ALL: &'static [Mode] = &[$(Mode::$mode),*];

            /// Its name, as on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Mode::$mode => $name,)*
                }
            }
        }
    };
}

modes! {
    /// Lit ground.
    Shaded = "shaded",
    /// Lit ground under the mesh's edges.
    Wire = "wire",
    /// Patch levels by colour, lit.
    Levels = "levels",
    /// Normals as colour.
    Normals = "normals",
    /// Albedo, unlit.
    Albedo = "albedo",
    /// Distance on a logarithmic grey scale.
    Depth = "depth",
    /// How long a vertex of each triangle has been awake, lit.
    Wake = "wake",
    /// What share of the tolerance the certified error of the mesh takes, lit.
    Error = "error",
}

impl Mode {
    /// Whether the picture shows numbers as colours, not light.
    pub fn is_diagram(self) -> bool {
        matches!(self, Mode::Normals | Mode::Albedo | Mode::Depth)
    }

    /// Whether these numbers are shown as they are, neither encoded nor dithered.
    pub fn is_plain(self) -> bool {
        matches!(self, Mode::Normals | Mode::Depth)
    }
}

/// How exposed light becomes the light of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Tone {
    /// An S about middle grey, then straight, then a shoulder in which colours pale.
    #[default]
    Neutral,
    /// The filmic curve of AgX.
    Agx,
}

impl Tone {
    /// All curves.
    pub const ALL: [Tone; 2] = [Tone::Neutral, Tone::Agx];

    /// Its name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Tone::Neutral => "neutral",
            Tone::Agx => "agx",
        }
    }
}

/// GLSL of a function that asks whether a mode is one of several, without `||`: that would be a condition on its own (`decided_late`).
fn mode_test(name: &str, holds: impl Fn(Mode) -> bool) -> String {
    let tests: Vec<String> = Mode::ALL.iter().filter(|m| holds(**m)).map(|m| format!("mode == {}", mode_constant(*m))).collect();
    format!("bool {name}(uint mode) {{ return any(bvec{}({})); }}", tests.len(), tests.join(", "))
}

fn mode_constant(mode: Mode) -> String {
    format!("MODE_{}", mode.name().to_uppercase())
}

/// GLSL of the constants whose home is elsewhere.
fn elsewhere() -> Vec<String> {
    let wave_copies = CASCADES.map(|cascade| format!("{:?}", f64::from(cascade.copies)));
    let wave_count = wave_copies.len();
    let mut lines: Vec<String> =
        Side::ALL.iter().map(|side| u32::from(side.bit()).declare(&format!("SIDE_{side:?}").to_uppercase())).collect();
    lines.extend(Mode::ALL.iter().map(|mode| (*mode as u32).declare(&mode_constant(*mode))));
    lines.extend(Tone::ALL.iter().map(|tone| (*tone as u32).declare(&format!("TONE_{}", tone.name().to_uppercase()))));
    lines.extend([
        mode_test("is_diagram", Mode::is_diagram),
        mode_test("is_plain", Mode::is_plain),
        (GUTTER as u32).declare("TEXTURE_GUTTER"),
        SHORE_RANGE.declare("SHORE_RANGE"),
        FADE_FROM.declare("FADE_FROM"),
        (DEVIATION_SHARE as f32).declare("DEVIATION_SHARE"),
        u32::from(Wake::ASLEEP.code()).declare("WAKE_ASLEEP"),
        u32::from(Wake::ALWAYS.code()).declare("WAKE_ALWAYS"),
        MANTISSA_BITS.declare("WAKE_MANTISSA_BITS"),
        REPEAT_M.declare("REPEAT_M"),
        format!("const float WAVE_COPIES[{wave_count}] = float[]({});", wave_copies.join(", ")),
        f64::from(GROUND_LAYER).declare("GROUND_LAYER"),
        f64::from(CROWN_LAYER).declare("CROWN_LAYER"),
        CLOUD_EDGE.declare("CLOUD_EDGE"),
    ]);
    lines
}

/// GLSL of all shared constants, a line each.
pub(super) fn declarations() -> Vec<String> {
    [declared_here(), elsewhere()].concat()
}
