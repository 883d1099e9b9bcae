//! Cameras and views: where the viewer is, and the numbers that selection derives from it.

use super::layout::FrameView;
use super::orientation::Orientation;
use crate::globe::lattice::{Lattice, EXTENT};
use crate::mesh::certificate::KAPPA;
use crate::mesh::wake::MORPH_REACH;
use glam::{DMat3, DVec3, IVec3, Mat4, Vec4};

/// Largest weight of the distance outside the frustum.
const MOST_FALLOFF: f64 = 3.0;

/// Share of what the scale leaves beyond the slope of a plain distance that goes to the orientation term; the rest stays with the
/// falloff. Measured on the descent: with more of it more vertices wake beside the frustum than fall asleep below the eye.
const ORIENTATION_SHARE: f64 = 0.25;

/// Steepest orientation term: rounding in single precision grows with it (see [`crate::mesh::wake::PROPAGATION_MARGIN`]).
const STEEPEST: f64 = 4.0;

/// Near plane in metres: nearer than any ground in view. Reversed floating-point depth is as precise with a small one as with a large one.
pub const NEAR: f32 = 0.1;

/// Least and most tolerance in pixels that a view accepts.
pub const TOLERANCE_RANGE: (f64, f64) = (0.05, 64.0);

/// A perspective camera in planet-fixed metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position from the planet's centre.
    pub position: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Unit vector to the top of the picture, perpendicular to `forward`.
    pub up: DVec3,
    /// Vertical field of view in radians.
    pub fov: f64,
    /// Picture size in pixels.
    pub size: [u32; 2],
}

impl Camera {
    /// A camera at `position` looking along `heading` (degrees, clockwise from north) and `pitch` (degrees above the
    /// horizontal).
    pub fn looking(position: DVec3, heading: f64, pitch: f64, fov: f64, size: [u32; 2]) -> Camera {
        let frame = local_frame(position);
        let (h, p) = (heading.to_radians(), pitch.to_radians());
        let level = frame.y_axis * h.cos() + frame.x_axis * h.sin();
        let forward = level * p.cos() + frame.z_axis * p.sin();
        let up = frame.z_axis * p.cos() - level * p.sin();
        Camera { position, forward: forward.normalize(), up: up.normalize(), fov, size }
    }

    /// Unit vector to the right of the picture.
    pub fn right(&self) -> DVec3 {
        self.forward.cross(self.up)
    }

    /// Radians that one pixel at the picture's middle subtends.
    pub fn pixel_angle(&self) -> f64 {
        2.0 * (self.fov / 2.0).tan() / f64::from(self.size[1])
    }

    /// tan of half the horizontal and of half the vertical field of view.
    pub fn half_extents(&self) -> (f64, f64) {
        let vertical = (self.fov / 2.0).tan();
        (vertical * f64::from(self.size[0]) / f64::from(self.size[1]), vertical)
    }
}

/// A rectangle of a picture, in pixels from its upper left corner; it may reach beyond the picture's right and lower edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its own upper left corner.
    pub origin: [u32; 2],
    /// Width and height, at least 1.
    pub size: [u32; 2],
}

impl Window {
    /// The whole picture of a size.
    pub fn whole(size: [u32; 2]) -> Window {
        Window { origin: [0; 2], size }
    }

    /// Its left and right (axis 0) or upper and lower (axis 1) edges where the picture's own are -1 and 1.
    fn edges(&self, picture: [u32; 2], axis: usize) -> [f64; 2] {
        let [near, length, whole] = [self.origin[axis], self.size[axis], picture[axis]].map(f64::from);
        [2.0 * near / whole - 1.0, 2.0 * (near + length) / whole - 1.0]
    }
}

/// East, north and up at a position (at the poles, longitude 0 decides).
pub fn local_frame(position: DVec3) -> DMat3 {
    let up = position.try_normalize().unwrap_or(DVec3::Z);
    let east = DVec3::Z.cross(up).try_normalize().unwrap_or(DVec3::Y);
    DMat3::from_cols(east, up.cross(east), up)
}

/// A camera with a tolerance, on a planet's lattice.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The part of its picture that is drawn.
    pub window: Window,
    /// Camera position in lattice units.
    pub eye: DVec3,
    /// Tolerance in pixels.
    pub tolerance: f64,
    /// s = κ₀/κ, at least 1: where the tolerance (in a wide field of view or a small picture) is coarser than meshes are certified for,
    /// they are drawn as fine as they are certified.
    pub scale: f64,
    /// Vertices are awake within this times their wake: farther than `scale` by [`MORPH_REACH`], to slide; `scale` without geomorphs.
    pub reach: f64,
    /// Weight of the distance outside the frustum.
    pub falloff: f64,
    /// Outward unit normals of the frustum's sides (left, right, bottom, top) and backwards; all planes pass through the eye.
    pub planes: [DVec3; 5],
    /// The orientation term, if it is wanted and changes anything.
    pub orientation: Option<Orientation>,
    /// Whether patches wholly below the horizon are left out.
    pub horizon: bool,
    /// Pixels drawn along a side for each pixel of the camera's picture: 1, but where a window draws fewer and enlarges them.
    pub density: f64,
    /// The same numbers as the GPU sees them.
    pub gpu: FrameView,
}

impl View {
    /// The view of a camera with a tolerance in pixels on a planet with patches of `cells` cells; with geomorphs.
    pub fn new(camera: Camera, lattice: &Lattice, cells: u32, tolerance: f64) -> View {
        let scale = (KAPPA / (tolerance * camera.pixel_angle())).max(1.0);
        let reach = MORPH_REACH * scale;
        let falloff = (scale - 1.0).min(MOST_FALLOFF);
        let window = Window::whole(camera.size);
        let planes = frustum(&camera, &window);
        let eye = camera.position / lattice.unit;
        let limit = f64::from(EXTENT - 1);
        let anchor: IVec3 = eye.round().clamp(DVec3::splat(-limit), DVec3::splat(limit)).as_ivec3();
        let offset = (eye - anchor.as_dvec3()).as_vec3();
        let gpu = FrameView {
            anchor: anchor.to_array(),
            culling: super::layout::CULL_FRUSTUM | super::layout::CULL_BACK,
            offset: offset.to_array(),
            scale: scale as f32,
            planes: planes.map(|p| p.as_vec3().to_array()),
            falloff: falloff as f32,
            up: [0.0; 3],
            height_weight: 0.0,
            side_weight: 0.0,
            reach: reach as f32,
            morph_rate: (1.0 / (reach - scale)) as f32,
            cells,
            shift: [0.0; 3],
            unit: lattice.unit as f32,
            near: NEAR,
            clip: clip_matrix(&camera, &window, NEAR).to_cols_array_2d(),
        };
        View {
            camera,
            window,
            eye,
            tolerance,
            scale,
            reach,
            falloff,
            planes,
            orientation: None,
            horizon: true,
            density: 1.0,
            gpu,
        }
    }

    /// The part of the same view that a window shows. Its frustum is that of the window, and so would be a mesh that was selected for
    /// it: parts of one picture are drawn from the whole picture's selection.
    pub fn through(mut self, window: Window) -> View {
        self.window = window;
        self.planes = frustum(&self.camera, &window);
        self.gpu.planes = self.planes.map(|p| p.as_vec3().to_array());
        self.gpu.clip = clip_matrix(&self.camera, &window, NEAR).to_cols_array_2d();
        self
    }

    /// The same view of the same mesh, drawn with so many pixels along a side for each of the camera's picture.
    pub fn with_density(self, density: f64) -> View {
        View { density, ..self }
    }

    /// The same view in which vertices out of sight are awake like others.
    pub fn without_falloff(self) -> View {
        self.with_falloff(0.0)
    }

    /// The same view with all patches in the frustum, those below the horizon too.
    pub fn without_horizon(mut self) -> View {
        self.horizon = false;
        self
    }

    /// The same view with the orientation term, on a planet whose ground is nowhere nearer to its centre than `ground` lattice units.
    /// Its errors are certified as seen, not as if each were seen from the side. Without effect from far up, and at a `scale` of 1.
    pub fn with_orientation(self, ground: f64) -> View {
        let slope = (1.0 + ORIENTATION_SHARE * (self.scale - 1.0)).min(STEEPEST);
        let Some(term) = Orientation::new(self.eye, ground, slope) else { return self };
        let mut view = self.with_falloff((self.scale - term.slope()).clamp(0.0, MOST_FALLOFF));
        view.orientation = Some(term);
        view.gpu.up = term.up.as_vec3().to_array();
        view.gpu.height_weight = term.height as f32;
        view.gpu.side_weight = term.side as f32;
        view
    }

    fn with_falloff(mut self, falloff: f64) -> View {
        self.falloff = falloff;
        self.gpu.falloff = falloff as f32;
        self
    }

    /// The same view drawing every triangle.
    pub fn without_culling(mut self) -> View {
        self.gpu.culling = 0;
        self
    }

    /// The same view with every awake vertex in its own position.
    pub fn without_geomorphs(mut self) -> View {
        self.reach = self.scale;
        self.gpu.reach = self.gpu.scale;
        self.gpu.morph_rate = 0.0;
        self
    }
}

fn frustum(camera: &Camera, window: &Window) -> [DVec3; 5] {
    let (h, v) = camera.half_extents();
    let (right, up, forward) = (camera.right(), camera.up, camera.forward);
    let ([left_edge, right_edge], [upper, lower]) = (window.edges(camera.size, 0), window.edges(camera.size, 1));
    // Outward is `across`; `edge` is how far in that direction the side lies, in units of `extent`.
    let side = |across: DVec3, edge: f64, extent: f64| (across - forward * (edge * extent)).normalize();
    [side(-right, -left_edge, h), side(right, right_edge, h), side(-up, lower, v), side(up, -upper, v), -forward]
}

/// Reversed-Z projection with an infinite far plane: depth is near / distance. Y points down in clip space. Off-centre where the window
/// is.
fn clip_matrix(camera: &Camera, window: &Window, near: f32) -> Mat4 {
    let (h, v) = camera.half_extents();
    let forward = camera.forward;
    let row =
        |axis: DVec3, [from, to]: [f64; 2]| ((axis - forward * (0.5 * (from + to))) / (0.5 * (to - from))).as_vec3().extend(0.0);
    let x = row(camera.right() / h, window.edges(camera.size, 0));
    let y = row(-camera.up / v, window.edges(camera.size, 1));
    Mat4::from_cols(x, y, Vec4::new(0.0, 0.0, 0.0, near), forward.as_vec3().extend(0.0)).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::looking(DVec3::new(6.4e6, 0.0, 0.0), 90.0, -10.0, 1.0, [1280, 720])
    }

    #[test]
    fn heading_and_pitch_follow_the_compass() {
        let c = Camera::looking(DVec3::new(6.4e6, 0.0, 0.0), 90.0, 0.0, 1.0, [100, 100]);
        assert!(c.forward.distance(DVec3::Y) < 1e-12 && c.up.distance(DVec3::X) < 1e-12);
        let down = Camera::looking(DVec3::new(6.4e6, 0.0, 0.0), 0.0, -90.0, 1.0, [100, 100]);
        assert!(down.forward.distance(-DVec3::X) < 1e-12 && down.up.distance(DVec3::Z) < 1e-12);
    }

    #[test]
    fn projection_is_reversed_and_centred() {
        let view = View::new(camera(), &Lattice::new(6.371e6, 9e3), 128, 1.0);
        let clip = Mat4::from_cols_array_2d(&view.gpu.clip);
        let ahead = clip * (view.camera.forward.as_vec3() * 50.0).extend(1.0);
        assert!(ahead.x.abs() < 1e-4 && ahead.y.abs() < 1e-4 && (ahead.w - 50.0).abs() < 1e-4);
        assert!((ahead.z - view.gpu.near).abs() < 1e-6);
        let above = clip * (view.camera.forward * 50.0 + view.camera.up * 5.0).as_vec3().extend(1.0);
        assert!(above.y < 0.0, "up is towards smaller y in Vulkan's clip space");
    }

    #[test]
    fn high_mountains_do_not_clip_the_ground_underfoot() {
        let lattice = Lattice::new(6.371e6, 3e4);
        for height in [0.0, 2.9e4] {
            let camera = Camera::looking(DVec3::new(0.0, 6.371e6 + height + 2.0, 0.0), 0.0, -90.0, 1.0, [1280, 720]);
            let view = View::new(camera, &lattice, 128, 1.0);
            let foot = Mat4::from_cols_array_2d(&view.gpu.clip) * (camera.forward.as_vec3() * 2.0).extend(1.0);
            assert!(foot.z / foot.w < 0.1, "depth {} of 1 on a mountain of {height} m", foot.z / foot.w);
        }
    }

    #[test]
    fn frustum_planes_hold_the_picture() {
        let view = View::new(camera(), &Lattice::new(6.371e6, 9e3), 128, 1.0);
        let (h, v) = view.camera.half_extents();
        for (x, y, inside) in [(0.0, 0.0, true), (0.99, 0.99, true), (1.01, 0.0, false), (0.0, -1.01, false)] {
            let ray = view.camera.forward + view.camera.right() * (h * x) + view.camera.up * (v * y);
            assert_eq!(view.planes.iter().all(|p| p.dot(ray) <= 0.0), inside);
        }
    }
    #[test]
    fn a_window_shows_the_same_points_where_the_whole_picture_has_them() {
        let view = View::new(camera(), &Lattice::new(6.371e6, 9e3), 128, 1.0);
        let window = Window { origin: [960, 90], size: [400, 200] };
        let part = view.through(window);
        let pixel = |view: &View, point: DVec3| {
            let clip = Mat4::from_cols_array_2d(&view.gpu.clip) * point.as_vec3().extend(1.0);
            let [x, y] = [clip.x / clip.w, clip.y / clip.w].map(|c| f64::from(0.5 + 0.5 * c));
            let at = |k: usize, share: f64| f64::from(view.window.origin[k]) + share * f64::from(view.window.size[k]);
            [at(0, x), at(1, y)]
        };
        let (h, v) = view.camera.half_extents();
        for (x, y, inside) in [(0.6, 0.4, true), (0.99, 0.7, true), (0.4, 0.4, false), (0.6, 0.8, false), (0.6, 0.1, false)] {
            let ray = view.camera.forward + view.camera.right() * (h * x) + view.camera.up * (v * y);
            let (whole, seen) = (pixel(&view, ray * 900.0), pixel(&part, ray * 900.0));
            assert!((whole[0] - seen[0]).abs() < 1e-2 && (whole[1] - seen[1]).abs() < 1e-2, "{whole:?} {seen:?}");
            assert_eq!(part.planes.iter().all(|p| p.dot(ray) <= 0.0), inside, "{x} {y}");
        }
        let same = view.through(Window::whole(view.camera.size));
        assert!(same.planes == view.planes && same.gpu == view.gpu);
    }
}
