//! Every structure that the GPU sees and every number that shaders and Rust share, declared once. The GLSL in
//! `shaders/shared/layout.glsl` is generated from here; a test regenerates and compares it, and a device test reads every member back.
//!
//! All members are 32-bit words and blocks use the scalar layout, so Rust's `repr(C)` and GLSL agree without padding.

mod constants;
mod glsl;

use crate::globe::lattice::Lattice;
use crate::ground::WarpedGrid;
use crate::mesh::progressive::PatchMesh;
use crate::mesh::wake::Wake;
use bytemuck::{Pod, Zeroable};
use glsl::GlslMember;
use terrane_heightfield::decimate::star::LEAST_AREA;

pub use constants::*;
pub use glsl::{glsl, probe_glsl, probe_words};

macro_rules! gpu_structs {
    ($($(#[$meta:meta])* $name:ident { $($(#[$member_meta:meta])* $member:ident: $ty:ty,)* })*) => {
        $($(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
        pub struct $name {
            $($(#[$member_meta])* pub $member: $ty,)*
        })*

        /// Name, members as GLSL declarations, and the words of every member, of every structure.
        fn structures() -> Vec<(&'static str, Vec<String>, Vec<String>)> {
            vec![$((
                stringify!($name),
                vec![$(<$ty as GlslMember>::declare(stringify!($member))),*],
                [$(<$ty as GlslMember>::words(stringify!($member))),*].concat(),
            )),*]
        }
    };
}

gpu_structs! {
    /// One vertex of a patch, in wake order.
    PatchVertex {
        /// Lattice position.
        position: [i32; 3],
        /// Grid number (low half) and wake (high half).
        grid_wake: u32,
        /// Parent's vertex index (low half) and coarser wake, for beside a coarser neighbour (high half).
        parent_coarser_wake: u32,
    }

    /// One patch to select, emit and draw this frame.
    PatchDraw {
        /// Device address of its vertices.
        vertices: [u32; 2],
        /// Device address of its triangles, those of all index levels.
        triangles: [u32; 2],
        /// Vertices to select and resolve: the prefix that the view looks at.
        vertex_count: u32,
        /// First word of its awake bits.
        awake_offset: u32,
        /// First entry of its resolved and of its drawn vertices.
        resolve_offset: u32,
        /// Sides with a coarser neighbour, bits in order left, right, bottom, top.
        coarser_sides: u32,
        /// Quadtree level.
        level: u32,
        /// Slot of the textures that it is drawn with: its own, or an ancestor's.
        slot: u32,
        /// Slot of those of that patch's parent, or NO_SLOT.
        parent_slot: u32,
        /// Which quarter of its parent the patch with the textures is, as column and row.
        quarter: [u32; 2],
        /// Where its own first corner lies in the patch with the textures, in cells of that patch.
        texture_corner: [f32; 2],
        /// How long its own cells are in that patch's.
        texture_cell: f32,
        /// Distance in metres at which its own texture begins to fade in over the parent's.
        fade_distance: f32,
        /// Distance in metres at which one of its texels covers one pixel.
        texel_distance: f32,
        /// Cube axis that the face's first grid coordinate follows.
        grid_axis: [f32; 3],
        /// Distance in metres, at a scale of 1, from nearer than which the grid of each quarter deviates too much from finer levels.
        deviations: [f32; 4],
    }

    /// Where a vertex is drawn. One that sleeps is not, and has its own position and a weight of 1 here.
    DrawnVertex {
        /// Lattice units from the eye of the view that it was selected in.
        position: [f32; 3],
        /// Morph weight: 0 in its own position, up to 1 in its parent's.
        weight: f32,
    }

    /// A star in this frame's picture.
    Star {
        /// Where in the picture: -1 to 1 from left to right and from top to bottom; far outside if it is hidden or behind.
        at: [f32; 2],
        /// Radiance, if it were as wide as a pixel.
        radiance: [f32; 3],
    }

    /// A corner of a triangle of the user interface.
    GuiCorner {
        /// Points from the window's upper left corner, to the right and down.
        position: [f32; 2],
        /// Where in its image, from 0 to 1.
        texel: [f32; 2],
        /// Red, green, blue and alpha, 8 bits each from the lowest; encoded as the display takes them and multiplied by alpha.
        color: u32,
    }

    /// A run of work of one workgroup: a patch, and which of its vertices or triangles.
    Task {
        /// Number of the patch in the table of draws.
        patch_number: u32,
        /// First vertex or triangle.
        first: u32,
        /// One past the last.
        end: u32,
    }

    /// The view, as selection and drawing see it. Lengths in lattice units unless said otherwise.
    FrameView {
        /// Lattice point near the camera.
        anchor: [i32; 3],
        /// Bits of the CULL_ flags.
        culling: u32,
        /// Camera minus anchor.
        offset: [f32; 3],
        /// s = κ₀ / κ: a vertex is in its own position within this times its wake.
        scale: f32,
        /// Outward normals of the frustum's four sides and of the plane through the camera, facing backwards.
        planes: [[f32; 3]; 5],
        /// Weight of the distance outside the frustum (G).
        falloff: f32,
        /// The eye's vertical.
        up: [f32; 3],
        /// Weight of how far below the eye a point lies, in the orientation term; 0 without the term.
        height_weight: f32,
        /// Weight of how far aside it lies.
        side_weight: f32,
        /// A vertex is awake within this times its wake: `scale`, or MORPH_REACH times that with geomorphs.
        reach: f32,
        /// 1 / (reach - scale): how fast a vertex slides to its parent's position beyond `scale`. 0 without geomorphs.
        morph_rate: f32,
        /// Grid cells along a patch side.
        cells: u32,
        /// From the eye to the eye of the view that the drawn mesh was selected in; 0 unless the selection is frozen.
        shift: [f32; 3],
        /// Metres in a lattice unit.
        unit: f32,
        /// Near plane in metres.
        near: f32,
        /// Camera-relative metres to clip space.
        clip: [[f32; 4]; 4],
    }

    /// Everything shading needs. Metres; directions are planet-fixed.
    Shading {
        /// Camera from the planet's centre.
        camera: [f32; 3],
        /// One of the MODE_ constants.
        mode: u32,
        /// Towards the sun.
        sun: [f32; 3],
        /// Camera's height above the datum, with more precision than `camera` holds.
        height_m: f32,
        /// Right, in units of tan(half the horizontal field of view).
        right: [f32; 3],
        /// Planet radius (datum).
        radius: f32,
        /// Up, in units of tan(half the vertical field of view).
        up: [f32; 3],
        /// Sea level above the datum; NO_SEA without a sea.
        sea_level: f32,
        /// View direction.
        forward: [f32; 3],
        /// Scale height of the air; 0 without an atmosphere.
        scale_height: f32,
        /// Rayleigh scattering at the datum, per metre.
        rayleigh: [f32; 3],
        /// Scale height of haze.
        mie_scale_height: f32,
        /// Mie scattering at the datum, per metre.
        mie: [f32; 3],
        /// Asymmetry of Mie scattering.
        mie_g: f32,
        /// Mie scattering and absorption at the datum, per metre.
        mie_extinction: [f32; 3],
        /// Height above the datum of the middle of the ozone layer.
        ozone_height: f32,
        /// Absorption in the middle of the ozone layer, per metre.
        ozone: [f32; 3],
        /// Height in metres from the middle of the ozone layer to its edge.
        ozone_reach: f32,
        /// Colour of shallow water, linear.
        shallow: [f32; 3],
        /// Height above the datum of the lowest surface that air lies on.
        air_bottom: f32,
        /// Colour of deep water, linear.
        deep: [f32; 3],
        /// Height in metres of the atmosphere's upper edge above the datum.
        air_top: f32,
        /// The eye's vertical.
        vertical: [f32; 3],
        /// Latitude in radians at which the eye, or from outside the point where a ray enters the air, sees the horizon of
        /// `air_bottom`.
        horizon: f32,
        /// Horizontally towards the sun from the eye; any horizontal direction where the sun is overhead.
        sunward: [f32; 3],
        /// Picture size in pixels.
        size: [f32; 2],
        /// The part of the picture that is drawn: left, top, width and height in pixels.
        window: [f32; 4],
        /// Reflectance of the ground, for light that is scattered more than once.
        ground_albedo: f32,
        /// Factor from radiance to what the tone curve takes; where the picture is metered, a factor on that.
        exposure: f32,
        /// One of the TONE_ constants that name curves.
        tone: u32,
        /// What middle grey becomes, what the tone curve adds to the slope just above it, and over how many powers of e that goes on.
        bend: [f32; 3],
        /// How far the metered factor goes to its goal in this frame, from 0 to 1; negative where exposure is fixed.
        adaptation: f32,
        /// Seconds, for things that move by themselves; 0 in still pictures.
        time: f32,
        /// The camera's position in metres, less whole periods of REPEAT_M: what repeats stays where it is.
        anchor: [f32; 3],
        /// Variance of all slopes of the sea.
        sea_variance: f32,
        /// Height of the clouds above the datum in metres.
        cloud_height: f32,
        /// Optical depth of clouds where they are thickest; 0: there are none.
        cloud_depth: f32,
        /// What is taken from the sines of the horizons' elevation: 0, or so much that nothing casts shadows.
        horizon_drop: f32,
    }

    /// Counters that emission appends with, and the indirect draw they become.
    EmitState {
        /// Triangles wanted, whether they fitted or not.
        wanted: u32,
        /// Triangles the index buffer holds.
        capacity: u32,
        /// Awake vertices of all patches (border vertices count once for each patch).
        awake: u32,
        /// `VkDrawIndexedIndirectCommand`.
        index_count: u32,
        /// Always 1.
        instance_count: u32,
        /// Always 0.
        first_index: u32,
        /// Always 0.
        vertex_offset: i32,
        /// Always 0.
        first_instance: u32,
    }
}

/// Two 16-bit numbers in a word, as `shaders/shared/codings.glsl` takes them apart.
pub(crate) fn pair(low: u16, high: u16) -> u32 {
    u32::from(low) | u32::from(high) << 16
}

/// The first number of a [`pair`].
pub(crate) fn low16(pair: u32) -> u32 {
    pair & 0xffff
}

/// The second number of a [`pair`].
pub(crate) fn high16(pair: u32) -> u32 {
    pair >> 16
}

impl PatchVertex {
    /// The vertices of a patch as the GPU sees them.
    pub fn of_patch(mesh: &PatchMesh, lattice: &Lattice) -> Vec<PatchVertex> {
        let row = mesh.cells as usize + 1;
        let grid = WarpedGrid::new(mesh.id, 0..=mesh.cells as i32, mesh.cells);
        let convert = |v: &crate::mesh::progressive::Vertex| PatchVertex {
            position: lattice.position(grid.direction(usize::from(v.grid) % row, usize::from(v.grid) / row), v.height).to_array(),
            grid_wake: pair(v.grid, v.wake.code()),
            parent_coarser_wake: pair(v.parent, v.coarser_wake.code()),
        };
        mesh.vertices.iter().map(convert).collect()
    }

    /// Grid number.
    pub fn grid(&self) -> u32 {
        low16(self.grid_wake)
    }

    /// Vertex index of the vertex it collapses into.
    pub fn parent(&self) -> u32 {
        low16(self.parent_coarser_wake)
    }

    /// Its wake beside a coarser neighbour, or beside others.
    pub fn wake_beside(&self, coarser: bool) -> Wake {
        Wake::from_code(high16(if coarser { self.parent_coarser_wake } else { self.grid_wake }) as u16)
    }

    /// The larger of its two wakes.
    pub fn largest_wake(&self) -> Wake {
        Wake::from_code(high16(self.grid_wake.max(self.parent_coarser_wake)) as u16)
    }
}

// Grid numbers and emitted vertices must fit their bits.
const _: () = assert!((crate::globe::patch::MAX_CELLS + 1) * (crate::globe::patch::MAX_CELLS + 1) <= 1 << VERTEX_BITS);
const _: () = assert!(LEAST_AREA > 0.0);
