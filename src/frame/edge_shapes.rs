//! Edges at one sample a pixel, from their shapes. In: depth, and how high the ground lies above the sea. Out: the image of edges.
//! Shaders: `edge_kinds.comp` tells sky, sea and ground apart, `edge_bits.comp` finds edges, `edge_shares.comp` measures them.

use crate::shaders;
use crate::vulkan::{
    Access, Buffer, Commands, ComputePipeline, Context, Image, ImageView, Memory, Resource, Result, Sampler, Usage,
};
use std::sync::Arc;
use terrane_planet::draw::layout::EDGE_ROWS;

/// Pixels of a row in a word of bits. Images of edges that are written by words are whole words wide.
pub(super) const WORD: u32 = 32;

/// Bits a pixel, as in `edge_planes.glsl`.
const PLANES: u64 = 10;

/// The pipelines.
pub(super) struct EdgeShapes {
    kinds: ComputePipeline,
    bits: ComputePipeline,
    shares: ComputePipeline,
}

/// What is kept for pictures of one size.
pub(super) struct EdgeBuffers {
    /// [`PLANES`] bits a pixel.
    bits: Buffer,
    /// The image of edges, before it is copied there.
    notes: Buffer,
}

/// What the edges are those of.
pub(super) struct Surfaces<'a> {
    /// The shading block.
    pub(super) shading: &'a Buffer,
    /// Depth.
    pub(super) depth: &'a ImageView,
    /// Alpha is the height above the sea.
    pub(super) ground: &'a ImageView,
    /// Unfiltered sampling of both.
    pub(super) nearest: &'a Sampler,
}

impl EdgeBuffers {
    /// Buffers for an image of edges.
    pub(super) fn new(context: &Arc<Context>, edges: &Image) -> Result<EdgeBuffers> {
        let (width, height) = edges.size();
        let words = u64::from(width / WORD) * u64::from(height);
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER, Memory::Device);
        Ok(EdgeBuffers { bits: buffer("edge bits", 4 * PLANES * words)?, notes: buffer("edge notes", u64::from(WORD) * words)? })
    }
}

impl EdgeShapes {
    /// Builds the pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<EdgeShapes> {
        let pipeline = |shader| ComputePipeline::new(context, shader, &[]);
        Ok(EdgeShapes {
            kinds: pipeline(&shaders::EDGE_KINDS_COMP)?,
            bits: pipeline(&shaders::EDGE_BITS_COMP)?,
            shares: pipeline(&shaders::EDGE_SHARES_COMP)?,
        })
    }

    /// Records what fills an image of edges. The surfaces are ready to be sampled.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        surfaces: &Surfaces<'_>,
        buffers: &EdgeBuffers,
        edges: &Image,
    ) -> Result<()> {
        let EdgeBuffers { bits, notes } = buffers;
        let (words, height) = (edges.size().0 / WORD, edges.size().1);
        let shading = ("ShadingBlock", Resource::Uniform(surfaces.shading));
        let depth = ("depth", Resource::Sampled(surfaces.depth, surfaces.nearest));
        let ground = ("ground", Resource::Sampled(surfaces.ground, surfaces.nearest));
        let found = ("EdgeBits", Resource::Storage(bits));

        commands.ready(&[bits.to(Access::ComputeWrite), notes.to(Access::TransferWrite)])?;
        commands.fill_buffer(notes, 0, notes.bytes(), 0)?;
        commands.bind(&self.kinds, &[shading, depth, ground, found])?;
        commands.dispatch_rows(self.kinds.workgroups(words * height))?;

        commands.ready(&[bits.to(Access::ComputeWrite)])?;
        commands.bind(&self.bits, &[shading, depth, found])?;
        commands.dispatch_rows(self.bits.workgroups(words * height.div_ceil(EDGE_ROWS as u32)))?;

        commands.ready(&[bits.to(Access::ComputeRead), notes.to(Access::ComputeWrite)])?;
        commands.bind(&self.shares, &[shading, ground, found, ("EdgeNotes", Resource::Storage(notes))])?;
        commands.dispatch_rows(self.shares.workgroups(words * height))?;

        commands.ready(&[notes.to(Access::TransferRead), edges.view().anew(Access::TransferWrite)])?;
        commands.copy_buffer_to_image((notes, 0), edges, &edges.whole(0, 0)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::edges::Edge;
    use crate::frame::targets::EDGE_FORMAT;
    use crate::vulkan::tests::checked::{device, Checked};
    use crate::vulkan::{capture, vk, ImageDescription, SamplerDescription, Upload};
    use half::f16;
    use terrane_planet::draw::layout::{Shading, EDGE_REACH, NO_SEA};

    /// Depth of near ground.
    const NEAR: f32 = 1e-3;

    /// A device and what runs on it.
    struct Rig {
        shapes: EdgeShapes,
        // Dropped last.
        context: Checked,
    }

    fn rig() -> Option<Rig> {
        let context = device()?;
        Some(Rig { shapes: EdgeShapes::new(&context).unwrap(), context })
    }

    /// A picture: depth and height above the sea at its pixels.
    struct Scene<'a> {
        size: [u32; 2],
        depth: &'a dyn Fn(i32, i32) -> f32,
        height: &'a dyn Fn(i32, i32) -> f32,
        sea: bool,
    }

    impl Scene<'_> {
        fn dry(size: [u32; 2], depth: &dyn Fn(i32, i32) -> f32) -> Scene<'_> {
            Scene { size, depth, height: &|_, _| 1.0, sea: false }
        }

        fn edges(&self, rig: &Rig) -> Vec<Option<Edge>> {
            self.edges_through(rig, [0; 2], self.size)
        }

        /// The edges in a window of the picture, row by row.
        fn edges_through(&self, rig: &Rig, origin: [u32; 2], size: [u32; 2]) -> Vec<Option<Edge>> {
            let context = &rig.context;
            let (width, height) = (size[0], size[1]);
            let image = |name, width, format| {
                let usage = vk::ImageUsageFlags::SAMPLED;
                Image::new(context, &ImageDescription::new(name, (width, height), format, usage)).unwrap()
            };
            let depth = image("depth", width, vk::Format::R32_SFLOAT);
            let ground = image("ground", width, vk::Format::R16G16B16A16_SFLOAT);
            let edges = image("edges", width.next_multiple_of(WORD), EDGE_FORMAT);
            let pixels = || {
                let [left, top] = origin.map(|n| n as i32);
                (0..height as i32).flat_map(move |y| (0..width as i32).map(move |x| (left + x, top + y)))
            };
            let heights = pixels().map(|(x, y)| [0, 0, 0, f16::from_f32((self.height)(x, y)).to_bits()]);
            let mut upload = Upload::new(context, 1 << 20);
            upload.image(&depth, 0, 0, &pixels().map(|(x, y)| (self.depth)(x, y)).collect::<Vec<_>>()).unwrap();
            upload.image(&ground, 0, 0, &heights.collect::<Vec<[u16; 4]>>()).unwrap();
            upload.finish().unwrap();
            let [x, y, w, h] = [origin[0], origin[1], width, height].map(|n| n as f32);
            // The sea, if any, is 100 m below, and nowhere to be seen where there is no ground.
            let shading = Shading {
                size: self.size.map(|side| side as f32),
                window: [x, y, w, h],
                height_m: 100.0,
                sea_level: if self.sea { 0.0 } else { NO_SEA },
                radius: 1e6,
                camera: [0.0, 0.0, 1e6],
                vertical: [0.0, 0.0, 1.0],
                forward: [0.0, 0.0, 1.0],
                right: [0.1, 0.0, 0.0],
                up: [0.0, 0.1, 0.0],
                ..Shading::default()
            };
            let mut block =
                Buffer::new(context, "shading", size_of::<Shading>() as u64, Usage::UNIFORM_BUFFER, Memory::Upload).unwrap();
            block.write(0, &[shading]).unwrap();
            let nearest = SamplerDescription { filter: vk::Filter::NEAREST, ..SamplerDescription::default() };
            let nearest = Sampler::new(context, "nearest", &nearest).unwrap();
            let buffers = EdgeBuffers::new(context, &edges).unwrap();
            let surfaces = Surfaces { shading: &block, depth: depth.view(), ground: ground.view(), nearest: &nearest };
            Commands::once(context, "edges", |commands| {
                rig.shapes.record(commands, &surfaces, &buffers, &edges)?;
                commands.ready(&[edges.view().to(Access::Sampled)])
            })
            .unwrap();
            let captured = capture(context, &edges, (0, 0), Access::Sampled).unwrap();
            let rows = captured.bytes.chunks_exact(captured.width as usize);
            rows.flat_map(|row| row[..width as usize].iter().map(|&code| Edge::decode(code))).collect()
        }
    }

    /// How much of a pixel is covered by what `covers` says of points, as drawn with one sample and edges.
    fn shown(size: [u32; 2], edges: &[Option<Edge>], covers: &dyn Fn(f64, f64) -> bool, at: [i32; 2]) -> f64 {
        let sample = |at: [i32; 2]| f64::from(u8::from(covers(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5)));
        let Some(edge) = edges[(at[1] * size[0] as i32 + at[0]) as usize] else { return sample(at) };
        let other = [0, 1].map(|k| at[k] + edge.neighbour[k]);
        sample(at) + f64::from(edge.share) * (sample(other) - sample(at))
    }

    /// Root mean square of the error of the coverage of pixels that a half-plane's side passes, with edges and without. Columns, or rows
    /// of upright pictures, that are nearer to the picture's ends than `margin` do not count.
    fn errors(size: [u32; 2], margin: i32, edges: &[Option<Edge>], covers: &dyn Fn(f64, f64) -> bool) -> [f64; 2] {
        const FINE: i32 = 16;
        let (mut sums, mut count, none) = ([0.0; 2], 0.0, vec![None; edges.len()]);
        let [width, height] = size.map(|side| side as i32);
        let (left, top) = if width > height { (margin, 0) } else { (0, margin) };
        for (x, y) in (top..height - top).flat_map(|y| (left..width - left).map(move |x| (x, y))) {
            let corner = |k: i32| covers(f64::from(x + k % 2), f64::from(y + k / 2));
            let exact = if (1..4).all(|k| corner(k) == corner(0)) {
                f64::from(u8::from(corner(0)))
            } else {
                let points = (0..FINE * FINE).map(|k| [k % FINE, k / FINE].map(|n| (f64::from(n) + 0.5) / f64::from(FINE)));
                let covered = points.filter(|[u, v]| covers(f64::from(x) + u, f64::from(y) + v)).count();
                covered as f64 / f64::from(FINE * FINE)
            };
            let found = [shown(size, edges, covers, [x, y]), shown(size, &none, covers, [x, y])];
            if (exact > 0.0 && exact < 1.0) || found[0] != found[1] {
                count += 1.0;
                (0..2).for_each(|k| sums[k] += (found[k] - exact).powi(2));
            }
        }
        sums.map(|sum: f64| (sum / count).sqrt())
    }

    #[test]
    fn ramps_are_covered_within_a_sixteenth() {
        let Some(rig) = rig() else { return };
        let size = [640, 96];
        for slope in [10.0, 17.3, 35.0, 64.0, 90.0, 130.0, 200.0] {
            for (falls, over, upright) in [(false, false, false), (true, true, false), (false, true, true), (true, false, true)] {
                let covers = |x: f64, y: f64| {
                    let (x, y) = if upright { (y, x) } else { (x, y) };
                    let line = 3.3 + x / slope;
                    (if falls { 80.0 - y } else { y } > line) != over
                };
                let size = if upright { [size[1], size[0]] } else { size };
                let depth = |x: i32, y: i32| if covers(f64::from(x) + 0.5, f64::from(y) + 0.5) { NEAR } else { 0.3 * NEAR };
                let edges = Scene::dry(size, &depth).edges(&rig);
                let [with, without] = errors(size, slope as i32, &edges, &covers);
                assert!(with < 1.0 / 16.0 && without > 0.2, "1:{slope} {falls} {over} {upright}: {with}, {without} without");
                // Between its steps nothing of the line is level for long.
                let mixed = edges.iter().filter(|edge| edge.is_some()).count();
                assert!(mixed * 10 > 640 * 8, "1:{slope}: {mixed} pixels are mixed");
            }
        }
    }

    #[test]
    fn grazing_ground_has_no_edges_but_its_horizon() {
        let Some(rig) = rig() else { return };
        let size = [200, 100];
        let mixed = |depth: &dyn Fn(i32, i32) -> f32| {
            let edges = Scene::dry(size, depth).edges(&rig);
            (0..edges.len()).filter(|&k| edges[k].is_some()).map(|k| (k % 200, k / 200)).collect::<Vec<_>>()
        };
        // Depth is affine over a plane, and 0 beyond its horizon.
        let plane = |x: i32, y: i32| (1e-4 * (y as f32 - 30.3 - x as f32 / 40.0)).max(0.0);
        let horizon = mixed(&plane);
        assert!(horizon.len() > 150 && horizon.iter().all(|&(_, y)| y < 37), "{horizon:?}");
        // Grazing both ways: depth changes by tenths from pixel to pixel, and nothing but the horizon is an edge.
        let slanting = |x: i32, y: i32| (1e-4 * (y as f32 - 20.3 - 0.7 * x as f32)).max(0.0);
        let found = mixed(&slanting);
        assert!(found.len() > 100 && found.iter().all(|&(x, y)| (y as f32 - 20.3 - 0.7 * x as f32).abs() < 3.0), "{found:?}");
        let foot_of_a_wall = |x: i32, y: i32| plane(x, y).max(1e-3 + 2e-6 * x as f32);
        assert_eq!(mixed(&foot_of_a_wall), []);
        let crest = |x: i32, y: i32| 1e-3 * (1.0 + 0.02 * y as f32 + 0.5 * (x as f32 / 30.0).sin().abs());
        assert_eq!(mixed(&crest), []);
        let step = |x: i32, y: i32| foot_of_a_wall(x, y) * if 2 * y > 100 + x { 1.3 } else { 1.0 };
        assert!(mixed(&step).len() > 60);
    }

    #[test]
    fn single_pixels_are_half_blended_away() {
        let Some(rig) = rig() else { return };
        let size = [64, 40];
        // A skyline with a spike and a notch, and ground alone in the sky.
        let ground = |x: i32, y: i32| (y >= 20 || (x, y) == (10, 19) || (x, y) == (50, 5)) && (x, y) != (30, 20);
        let depth = |x: i32, y: i32| if ground(x, y) { NEAR } else { 0.0 };
        let edges = Scene::dry(size, &depth).edges(&rig);
        let at = |x: usize, y: usize| edges[64 * y + x];
        assert_eq!(at(10, 19), Some(Edge { share: 0.5, neighbour: [0, -1] }));
        assert_eq!(at(30, 20), Some(Edge { share: 0.5, neighbour: [0, 1] }));
        assert_eq!(at(50, 5), Some(Edge { share: 0.5, neighbour: [0, -1] }));
        assert_eq!(at(20, 20), at(20, 19));
    }

    #[test]
    fn a_window_has_the_edges_of_the_whole_picture() {
        let Some(rig) = rig() else { return };
        let (size, margin) = ([901, 61], EDGE_REACH as u32 + 4);
        let noise = |n: i32| (n.wrapping_mul(747_796_405).wrapping_add(277_803_737) as u32 >> 9) as f32 / (1 << 23) as f32;
        let ridge = |x: i32, seed: i32, length: i32| {
            let (cell, share) = (x.div_euclid(length), x.rem_euclid(length) as f32 / length as f32);
            (1.0 - share) * noise(cell + seed) + share * noise(cell + 1 + seed)
        };
        let depth = |x: i32, y: i32| {
            let spike = if noise(x * 31 + y) > 0.995 { 1.5 } else { 0.0 };
            let y = y as f32 + spike;
            if y > 35.0 + 8.0 * ridge(x, 7, 70) {
                2.0 * NEAR
            } else if y > 10.0 + 5.0 * ridge(x, 99, 400) {
                NEAR
            } else {
                0.0
            }
        };
        let height = |x: i32, y: i32| y as f32 - 48.0 - x as f32 / 33.0 + 9.0 * ridge(x, 1234, 70);
        let scene = Scene { size, depth: &depth, height: &height, sea: true };
        let whole = scene.edges(&rig);
        assert!(whole.iter().flatten().count() > 1000);
        // How many pixels from `from` to `to` differ in a window that begins and ends so many pixels beside them.
        let differing = |margin: u32, from: u32, to: u32| {
            let (left, right) = (from.saturating_sub(margin), (to + margin).min(size[0] + 1));
            let part = scene.edges_through(&rig, [left, 0], [right - left, size[1]]);
            let columns = || (from..to.min(size[0])).flat_map(|x| (0..size[1]).map(move |y| (x, y)));
            columns()
                .filter(|&(x, y)| part[(y * (right - left) + x - left) as usize] != whole[(y * size[0] + x) as usize])
                .count()
        };
        for (from, to) in [(0, 300), (300, 600), (310, 420), (600, 902)] {
            assert_eq!(differing(margin, from, to), 0, "{from} to {to}");
        }
        assert!(differing(0, 300, 600) > 0);
    }

    #[test]
    fn the_waterline_is_covered_by_height_over_its_gradient() {
        let Some(rig) = rig() else { return };
        let size = [160, 90];
        for (dx, dy) in [(0.02, 0.1), (-0.1, 0.03), (0.003, 0.2), (0.1, 0.1)] {
            let dry = |x: f64, y: f64| dx * (x - 80.3) + dy * (y - 45.1);
            let height = |x: i32, y: i32| dry(f64::from(x) + 0.5, f64::from(y) + 0.5) as f32;
            let scene = Scene { size, depth: &|_, _| NEAR, height: &height, sea: true };
            let [with, without] = errors(size, 0, &scene.edges(&rig), &|x, y| dry(x, y) >= 0.0);
            assert!(with < 1.0 / 16.0 && without > 0.1, "{dx} {dy}: {with}, {without} without");
            let without_sea = Scene { sea: false, ..scene };
            assert!(without_sea.edges(&rig).iter().all(Option::is_none));
        }
    }
}
