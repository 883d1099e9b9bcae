//! Textures of patches: the arrays grow with what is resident, and hold what the file holds, in the slots that frames are told.

use crate::harness::{device, planet_file};
use glam::DVec3;
use std::sync::Arc;
use terrane::scene::{Scene, SceneOptions};
use terrane::vulkan::{capture, Access, Context};
use terrane_planet::draw::layout::TILES_PER_SIDE;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::ground::texture::texture_side;
use terrane_planet::store::PlanetFile;

fn view(scene: &Scene, direction: DVec3, altitude: f64) -> View {
    let position = scene.planet().position_above(direction.normalize(), altitude);
    let camera = Camera::looking(position, 30.0, -30.0, 0.9, [1280, 720]);
    View::new(camera, scene.lattice(), scene.planet().cells, 1.0)
}

/// Albedo and shore of a patch, as its slot holds them.
fn drawn_albedo(context: &Arc<Context>, scene: &Scene, id: PatchId) -> Vec<[u8; 4]> {
    let slot = scene.slot(id).unwrap();
    let (side, per_layer) = (texture_side(scene.planet().cells) as usize, TILES_PER_SIDE * TILES_PER_SIDE);
    let layer = capture(context, &scene.textures().albedo, (slot / per_layer, 0), Access::Sampled).unwrap();
    let [column, row] = [slot % per_layer % TILES_PER_SIDE, slot % per_layer / TILES_PER_SIDE].map(|n| n as usize);
    let texels: &[[u8; 4]] = bytemuck::cast_slice(&layer.bytes);
    let line = |y: usize| &texels[(row * side + y) * layer.width as usize + column * side..][..side];
    (0..side).flat_map(line).copied().collect()
}

#[test]
fn slots_hold_the_textures_of_their_patches_after_growth() {
    let Some(context) = device() else { return };
    let mut scene = Scene::open(&context, planet_file(), SceneOptions::default()).unwrap();
    let file = PlanetFile::open(planet_file()).unwrap();
    let stored = |id: PatchId| -> Vec<[u8; 4]> {
        let texture = file.texture(id).unwrap();
        texture.albedo.iter().zip(&texture.shore).map(|(&[r, g, b], &shore)| [r, g, b, shore]).collect()
    };
    let (few, most) = scene.gpu_bytes();
    assert_eq!((scene.resident_count(), scene.textures().albedo.layers()), (6, 1));
    let views = [(DVec3::ONE, 300.0), (DVec3::X, 20_000.0), (-DVec3::ONE, 20_000.0)];
    for (direction, altitude) in views {
        scene.settle(&view(&scene, direction, altitude)).unwrap();
    }
    let layers = scene.textures().albedo.layers();
    assert!(layers >= 3 && scene.resident_count() > 32, "{} patches, {layers} layers: two growths", scene.resident_count());
    let (many, same) = scene.gpu_bytes();
    assert!(few < many && many <= most && same == most, "{few}, then {many} of {most} bytes");
    let resident: Vec<PatchId> = file.index().unwrap().iter().map(|r| r.id).filter(|id| scene.slot(*id).is_some()).collect();
    assert!(resident.len() > 48, "only {} patches have textures", resident.len());
    for &id in &resident {
        assert!(drawn_albedo(&context, &scene, id) == stored(id), "{id}");
    }
    // The control: the textures of other patches are others.
    assert!(resident.windows(2).any(|pair| drawn_albedo(&context, &scene, pair[0]) != stored(pair[1])));
}
