//! Cameras at extreme positions: over poles, face edges and corners, inside a mountain, at the planet's centre, a million kilometres
//! away. Nothing panics, every number is finite, and the picture shows the planet.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

use crate::common::TestField;
use crate::whole_planet::{planet, Planet};
use glam::{DVec3, IVec3, Mat4, Vec3};
use terrane_planet::draw::cut::{cut, is_visible};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::{direction, ONE};
use terrane_planet::query::rays::Ray;
use terrane_planet::query::{KnownGround, PatchGrid};
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};
use terrane_planet::verify::SurfaceCheck;

const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };
const CELLS: u32 = 16;

/// What a camera sees of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sight {
    /// Some of it.
    Ground,
    /// Only the back faces of triangles, which are not drawn.
    Nothing,
    /// Back faces of the near ground, and front faces of the ground beyond a valley.
    Through,
}

/// Cameras by name. `ground` gives the height of what is drawn, in metres.
fn cameras(ground: &KnownGround) -> Vec<(&'static str, Camera, Sight)> {
    let above = |site: DVec3, metres: f64, pitch: f64| {
        let position = site * (FIELD.radius + ground.height_at(site).unwrap().height + metres);
        Camera::looking(position, 30.0, pitch, 0.9, [640, 360])
    };
    let mountain = highest();
    let mut all = vec![
        ("inside a mountain, level", above(mountain, -200.0, 0.0), Sight::Through),
        ("inside a mountain, up", above(mountain, -200.0, 90.0), Sight::Nothing),
        ("inside a mountain, down", above(mountain, -200.0, -90.0), Sight::Nothing),
        ("the centre", Camera::looking(DVec3::ZERO, 0.0, 0.0, 0.9, [640, 360]), Sight::Nothing),
        ("beside the centre", Camera::looking(DVec3::splat(1e-7), 0.0, 30.0, 0.9, [640, 360]), Sight::Nothing),
        ("far away, away", above(DVec3::Z, 1e9, 90.0), Sight::Nothing),
        ("up", above(mountain, 3.0, 90.0), Sight::Nothing),
    ];
    let sites = [
        ("north pole", DVec3::Z),
        ("south pole", -DVec3::Z),
        ("beside a pole", DVec3::new(1e-12, 0.0, 1.0).normalize()),
        ("face edge", direction(IVec3::new(ONE, ONE, ONE / 7))),
        ("face corner", direction(IVec3::new(ONE, ONE, ONE))),
        ("opposite corner", direction(IVec3::new(-ONE, -ONE, -ONE))),
        ("patch corner", PatchId::containing(DVec3::ONE, 4).centre()),
        ("mountain top", mountain),
    ];
    for (name, site) in sites {
        for (metres, pitch) in [(2.0, -60.0), (5e3, -40.0), (6e4, -90.0), (1e9, -90.0)] {
            all.push((name, above(site, metres, pitch), Sight::Ground));
        }
    }
    all
}

/// The ground of all patches.
fn known(planet: &Planet) -> KnownGround {
    let mut known = KnownGround::new(planet.tree.lattice, CELLS);
    for (patch, _) in planet.patches.values() {
        assert!(known.insert(PatchGrid::of_mesh(&patch.mesh, &planet.tree.lattice)));
    }
    known
}

fn highest() -> DVec3 {
    let sites = (0..4000)
        .map(|k| DVec3::new(f64::from(k % 20) - 9.5, f64::from(k / 20 % 20) - 9.5, f64::from(k / 400) - 4.5).normalize());
    sites.max_by(|a, b| FIELD.at(*a).total_cmp(&FIELD.at(*b))).unwrap()
}

fn all_finite(view: &View) -> bool {
    let words: &[f32] = bytemuck::cast_slice(std::slice::from_ref(&view.gpu.clip));
    let vectors = [view.camera.position, view.camera.forward, view.camera.up, view.eye].into_iter().chain(view.planes);
    let numbers = [view.gpu.scale, view.gpu.reach, view.gpu.morph_rate, view.gpu.falloff, view.gpu.unit, view.gpu.near];
    vectors.into_iter().all(|v| v.is_finite())
        && words.iter().chain(&numbers).chain(&view.gpu.offset).chain(view.gpu.planes.iter().flatten()).all(|x| x.is_finite())
}

/// Rays through points all over the picture, the middle among them.
fn pixels(camera: &Camera) -> Vec<Ray> {
    let (h, v) = camera.half_extents();
    let through = |x: f64, y: f64| (camera.forward + camera.right() * (h * x) + camera.up * (v * y)).normalize();
    let steps = || (-3..=3).map(|k| 0.3 * f64::from(k));
    steps().flat_map(|x| steps().map(move |y| Ray { origin: DVec3::ZERO, direction: through(x, y) })).collect()
}

/// Draws the view on the CPU; the surface without culling must have no fault. Returns how many of some pixels show ground, and whether the
/// middle one does.
fn draw(planet: &Planet, view: &View, name: &str) -> (usize, bool) {
    let cut = cut(&planet.tree, view, &|_| true);
    let whole = view.without_culling();
    let pixels = pixels(&view.camera);
    let (mut check, mut covered) = (SurfaceCheck::default(), vec![false; pixels.len()]);
    let clip = Mat4::from_cols_array_2d(&view.gpu.clip);
    for leaf in &cut.leaves {
        let patch = &planet.patches[&leaf.id].0;
        let work = patch.reach.work(view);
        let vertices = &patch.vertices[..work.vertices as usize];
        let Selected { awake, drawn_positions } = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
        let resolved = resolve(vertices, &awake);
        check.add(vertices, &drawn_positions, &emit(&whole.gpu, &patch.triangles(&work), &resolved, &drawn_positions));
        if !is_visible(&planet.tree, view, &planet.tree.get(leaf.id).unwrap().space) {
            continue;
        }
        for triangle in emit(&view.gpu, &patch.triangles(&work), &resolved, &drawn_positions) {
            let corners = triangle.map(|v| Vec3::from_array(drawn_positions[v as usize].position) * view.gpu.unit);
            assert!(corners.iter().all(|&c| (clip * c.extend(1.0)).is_finite()), "{name}: {corners:?}");
            let meets = |ray: &Ray| ray.distance_to(corners.map(|c| c.as_dvec3()), 0.0).is_some();
            covered.iter_mut().zip(&pixels).for_each(|(covered, ray)| *covered |= meets(ray));
        }
    }
    let report = check.finish();
    assert_eq!(report.cracks, 0, "{name}: {:?}", view.camera);
    assert_eq!(report.degenerate + report.flipped, 0, "{name}: {report:?} of {:?}", view.camera);
    assert!(report.triangles >= 12, "{name}: {} triangles", report.triangles);
    (covered.iter().filter(|&&c| c).count(), covered[covered.len() / 2])
}

#[test]
fn cameras_at_extremes_draw_the_planet_and_nothing_else() {
    let planet = planet(&FIELD, CELLS);
    for (name, camera, sight) in cameras(&known(&planet)) {
        for tolerance in [0.3, 1.0, 16.0] {
            let view = View::new(camera, &planet.tree.lattice, CELLS, tolerance);
            assert!(all_finite(&view), "{name}: {view:?}");
            let (count, middle) = draw(&planet, &view, name);
            match sight {
                Sight::Ground => assert!(middle, "{name}: no ground in the middle of the picture: {camera:?}"),
                Sight::Nothing => assert_eq!(count, 0, "{name}: {camera:?}"),
                Sight::Through => {}
            }
        }
    }
}

#[test]
fn a_camera_at_no_position_is_noticed() {
    let planet = planet(&FIELD, CELLS);
    let camera = Camera::looking(DVec3::NAN, 0.0, 0.0, 0.9, [640, 360]);
    assert!(!all_finite(&View::new(camera, &planet.tree.lattice, CELLS, 1.0)));
}

#[test]
fn what_lies_behind_the_horizon_is_not_drawn() {
    let planet = planet(&FIELD, CELLS);
    let known = known(&planet);
    // The finest patches lie around one face corner. For a camera above the opposite corner they are on the far side.
    let site = direction(IVec3::new(-ONE, -ONE, -ONE));
    let far: Vec<PatchId> = planet.tree.ids().filter(|id| id.centre().dot(site) < -0.8).collect();
    assert!(far.len() > 50, "{} patches prove little", far.len());
    for metres in [2.0, 3e3, 1e5, 1e9] {
        let radius = FIELD.radius + known.height_at(site).unwrap().height + metres;
        let sees = |camera: Camera| {
            let view = View::new(camera, &planet.tree.lattice, CELLS, 0.1);
            far.iter().filter(|id| is_visible(&planet.tree, &view, &planet.tree.get(**id).unwrap().space)).count()
        };
        let looking_down = |site: DVec3| Camera::looking(site * radius, 0.0, -90.0, 0.9, [640, 360]);
        assert_eq!(sees(looking_down(site)), 0, "from {metres} m");
        assert!(sees(looking_down(-site)) > 0, "from {metres} m above them nothing is seen either");
    }
}

#[test]
fn the_ground_is_found_under_and_ahead_of_every_camera() {
    let planet = planet(&FIELD, CELLS);
    let known = known(&planet);
    for (name, camera, sight) in cameras(&known) {
        if let Some(up) = camera.position.try_normalize() {
            let found = known.height_at(camera.position).unwrap();
            assert!((found.height - FIELD.at(up)).abs() < 0.5 * found.spacing, "{name}: {found:?}");
        }
        let hit = known.raycast(camera.position, camera.forward);
        assert!(hit.is_none_or(|hit| hit.position.is_finite() && hit.distance.is_finite() && hit.height.is_finite()), "{name}");
        if sight == Sight::Ground && camera.forward.dot(camera.position) < -0.99 * camera.position.length() {
            let hit = hit.unwrap_or_else(|| panic!("{name}: {camera:?}"));
            assert!((hit.height - known.height_at(camera.position).unwrap().height).abs() < 1.0, "{name}: {hit:?}");
        }
        if name.starts_with("inside") {
            assert!(hit.is_some_and(|hit| hit.distance == 0.0), "{name}: {hit:?}");
        }
    }
}
