//! Maps in GLB files, decoded as a viewer does it: their normals and colours are those of the ground at the vertices, also where patches
//! meet.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::export::Tiny;
use glam::{DVec3, IVec3};
use serde_json::Value;
use std::collections::HashMap;
use terrane_heightfield::plain::simplify;
use terrane_heightfield::Heightfield;
use terrane_planet::export::{ExportError, Format, Model, Up};
use terrane_planet::ground::{GroundPoint, NormalSite};

/// A picture, rows from the top.
struct Picture {
    size: [usize; 2],
    texels: Vec<[f64; 3]>,
}

impl Picture {
    /// Linearly filtered, as far as the edge.
    fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        let place = |share: f64, count: usize| {
            let texel = (share * count as f64 - 0.5).clamp(0.0, count as f64 - 1.0);
            let first = (texel as usize).min(count.saturating_sub(2));
            (first, texel - first as f64)
        };
        let ((column, right), (row, down)) = (place(u, self.size[0]), place(v, self.size[1]));
        let texel = |c: usize, r: usize| DVec3::from_array(self.texels[r * self.size[0] + c]);
        let line = |r: usize| texel(column, r).lerp(texel(column + 1, r), right);
        line(row).lerp(line(row + 1), down)
    }
}

/// What a viewer knows of a vertex, in glTF's axes.
struct Vertex {
    position: DVec3,
    normal: DVec3,
    tangent: DVec3,
    sign: f64,
    uv: [f64; 2],
}

struct Glb {
    vertices: Vec<Vertex>,
    albedo: Option<Picture>,
    normals: Picture,
}

impl Glb {
    fn read(bytes: &[u8]) -> Glb {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        let binary = &bytes[28 + word(12)..];
        let index = |value: &Value| value.as_u64().unwrap() as usize;
        let view = |number: &Value| {
            let view = &document["bufferViews"][index(number)];
            &binary[index(&view["byteOffset"])..][..index(&view["byteLength"])]
        };
        let primitive = &document["meshes"][0]["primitives"][0];
        let numbers = |name: &str, parts: usize| -> Vec<Vec<f64>> {
            let bytes = view(&document["accessors"][index(&primitive["attributes"][name])]["bufferView"]);
            let floats: Vec<f64> = bytes.chunks(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect();
            floats.chunks(parts).map(<[f64]>::to_vec).collect()
        };
        let [positions, normals, uvs] = [("POSITION", 3), ("NORMAL", 3), ("TEXCOORD_0", 2)].map(|(n, p)| numbers(n, p));
        let vector = |numbers: &[f64]| DVec3::from_slice(numbers);
        let vertex = |(k, tangent): (usize, Vec<f64>)| Vertex {
            position: vector(&positions[k]),
            normal: vector(&normals[k]),
            tangent: vector(&tangent),
            sign: tangent[3],
            uv: [uvs[k][0], uvs[k][1]],
        };
        let picture = |texture: &Value| {
            let image = &document["images"][index(&document["textures"][index(&texture["index"])]["source"])];
            assert_eq!(image["mimeType"], "image/png");
            let mut reader = png::Decoder::new(std::io::Cursor::new(view(&image["bufferView"]))).read_info().unwrap();
            let mut texels = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut texels).unwrap();
            assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
            let texels = texels.chunks(3).map(|t| [0, 1, 2].map(|k| f64::from(t[k])));
            Picture { size: [info.width as usize, info.height as usize], texels: texels.collect() }
        };
        let material = &document["materials"][index(&primitive["material"])];
        let colour = &material["pbrMetallicRoughness"]["baseColorTexture"];
        Glb {
            vertices: numbers("TANGENT", 4).into_iter().enumerate().map(vertex).collect(),
            albedo: (!colour.is_null()).then(|| picture(colour)),
            normals: picture(&material["normalTexture"]),
        }
    }

    /// The normal that a viewer lights a vertex with, if its map is read at some place.
    fn lit(&self, vertex: &Vertex, uv: [f64; 2]) -> DVec3 {
        let [x, y, z] = (self.normals.at(uv) / 127.5 - 1.0).to_array();
        let bitangent = vertex.normal.cross(vertex.tangent) * vertex.sign;
        (vertex.tangent * x + bitangent * y + vertex.normal * z).normalize()
    }
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = numbers.collect();
    all.iter().sum::<f64>() / all.len() as f64
}

#[test]
fn a_heightfields_map_has_its_normals_at_every_vertex() {
    let height = |x: f64, y: f64| (x * 0.2).sin() * 40.0 + (y * 0.15).cos() * 30.0 + x * y * 0.02;
    let field = (0..65 * 49).map(|k| height((k % 65) as f64, (48 - k / 65) as f64) as f32).collect();
    let field = Heightfield::new(65, 49, field).unwrap();
    let surface = simplify(&field).unwrap().polished(&field, 150);
    let scale = DVec3::new(30.0, 25.5, 1.5);
    let model = Model::of_heightfield(&surface, &field, scale).with_normal_map(&surface, &field, scale, 256).unwrap();
    let glb = Glb::read(&model.encode(Format::Glb, Up::Y).unwrap());
    assert_eq!((glb.normals.size, glb.albedo.is_some()), ([256, 256], false));
    let exact = |p: DVec3| {
        let step = 1e-3;
        let along = (height(p.x + step, p.y) - height(p.x - step, p.y)) / (2.0 * step) * scale.z / scale.x;
        let across = (height(p.x, p.y + step) - height(p.x, p.y - step)) / (2.0 * step) * scale.z / scale.y;
        DVec3::new(-along, 1.0, across).normalize()
    };
    let off = |turn: &dyn Fn([f64; 2]) -> [f64; 2]| -> Vec<f64> {
        let vertices = surface.positions.iter().zip(&glb.vertices);
        let inside = vertices.filter(|(p, _)| p.x > 0.0 && p.y > 0.0 && p.x < 64.0 && p.y < 48.0);
        inside.map(|(p, v)| glb.lit(v, turn(v.uv)).angle_between(exact(*p)).to_degrees()).collect()
    };
    let found = off(&|uv| uv);
    let worst = found.iter().copied().fold(0.0, f64::max);
    // A 255th of red or green is 0.45 degrees; differences over two samples are off by up to another half.
    assert!(found.len() > 40 && worst < 1.0, "{worst} degrees off");
    for wrong in [off(&|[u, v]| [u, 1.0 - v]), off(&|[u, v]| [v, u]), off(&|[u, v]| [u + 0.02, v])] {
        assert!(wrong.iter().any(|&degrees| degrees > 3.0), "the check sees a map that lies wrong");
    }
    assert!(glb.vertices.iter().all(|v| v.normal == DVec3::Y && v.tangent == DVec3::X && v.sign == 1.0));
}

#[test]
fn maps_of_a_planet_are_its_ground_at_every_vertex_and_agree_where_patches_meet() {
    let tiny = Tiny::new();
    let view = tiny.view(300.0);
    let surface = tiny.surface(&view, false);
    let placed = tiny.placed(&surface, IVec3::ZERO);
    let (ground, terrain) = (tiny.planet.ground(), &tiny.planet.terrain);
    let model = placed.model_with_maps(&ground, terrain, 2048).unwrap();
    let glb = Glb::read(&model.encode(Format::Glb, Up::Y).unwrap());
    assert_eq!(model.triangle_count(), surface.triangles.len());
    assert!(glb.vertices.len() > surface.positions.len(), "vertices on borders are there once a patch");
    let albedo = glb.albedo.as_ref().unwrap();
    assert_eq!(albedo.size, glb.normals.size);
    // What the map should say, from the vertex's own direction: the ground over some metres, which are those of a texel.
    let up = |v: &Vertex| DVec3::new(v.position.x, -v.position.z, v.position.y).normalize();
    let spacing = |level: u8| tiny.planet.lattice.sample_spacing(tiny.planet.cells, level) * tiny.planet.lattice.unit;
    let finest = surface.parts.iter().map(|part| part.id.level).max().unwrap();
    let sites: Vec<NormalSite> = glb.vertices.iter().map(|v| NormalSite { up: up(v), spacing: 0.25 * spacing(finest) }).collect();
    let exact = ground.normals(&sites);
    let in_gltf = |n: DVec3| DVec3::new(n.x, n.z, -n.y);
    let off = |shift: f64| -> Vec<f64> {
        let lit = glb.vertices.iter().map(|v| glb.lit(v, [v.uv[0] + shift, v.uv[1]]));
        lit.zip(&exact).map(|(n, &wanted)| n.angle_between(in_gltf(wanted)).to_degrees()).collect()
    };
    let (found, wrong) = (off(0.0), off(0.06));
    // Ground that is rough to the last texel, seen through linear filtering: 1.5 degrees in the mean, 4 degrees for nine in ten.
    let near = found.iter().filter(|&&degrees| degrees < 4.0).count();
    assert!(mean(found.iter().copied()) < 1.5, "{} degrees off", mean(found.iter().copied()));
    assert!(near as f64 > 0.9 * found.len() as f64, "{near} of {} within 4 degrees", found.len());
    assert!(mean(wrong.iter().copied()) > 5.0 * mean(found.iter().copied()), "the check sees maps that lie wrong");
    // Colours, against the terrain's own at the same places.
    let heights = ground.metres(&sites.iter().map(|site| site.up).collect::<Vec<_>>());
    let point = |((site, &height), &normal): ((&NormalSite, &f64), &DVec3)| {
        let slope = normal - site.up * normal.dot(site.up);
        let north = (DVec3::Z - site.up * site.up.z).normalize_or_zero();
        let rise = -slope / normal.dot(site.up);
        GroundPoint { direction: site.up, height, slope: rise.length(), north: rise.dot(north), spacing: site.spacing }
    };
    let points: Vec<GroundPoint> = sites.iter().zip(&heights).zip(&exact).map(point).collect();
    let mut colours = vec![[0; 3]; points.len()];
    terrain.albedo(&points, &mut colours);
    let far = |shift: usize| {
        let wanted = colours.iter().cycle().skip(shift).map(|c| DVec3::from_array(c.map(f64::from)));
        mean(glb.vertices.iter().zip(wanted).map(|(v, wanted)| (albedo.at(v.uv) - wanted).abs().max_element()))
    };
    assert!(far(0) < 3.0 && far(colours.len() / 2) > 10.0 * far(0), "{} levels of 255 off, {}", far(0), far(colours.len() / 2));
    // Where patches meet, both tiles say the same.
    let mut meeting: HashMap<[u64; 3], Vec<&Vertex>> = HashMap::new();
    for vertex in &glb.vertices {
        meeting.entry(vertex.position.to_array().map(f64::to_bits)).or_default().push(vertex);
    }
    let pairs: Vec<&Vec<&Vertex>> = meeting.values().filter(|vertices| vertices.len() > 1).collect();
    assert!(pairs.len() > 10, "{} vertices on borders", pairs.len());
    let apart = pairs.iter().map(|v| glb.lit(v[0], v[0].uv).angle_between(glb.lit(v[1], v[1].uv)).to_degrees());
    let step = pairs.iter().map(|v| (albedo.at(v[0].uv) - albedo.at(v[1].uv)).abs().max_element());
    assert!(mean(apart) < 0.5 && mean(step) < 1.0, "patches differ where they meet");
}

#[test]
fn maps_that_cannot_be_are_refused() {
    let tiny = Tiny::new();
    let surface = tiny.surface(&tiny.view(300.0), true);
    let placed = tiny.placed(&surface, IVec3::ZERO);
    let with = |side| placed.model_with_maps(&tiny.planet.ground(), &tiny.planet.terrain, side).err();
    assert_eq!(with(1000), Some(ExportError::MapSide { side: 1000 }));
    assert!(surface.parts.len() > 16 && matches!(with(64), Some(ExportError::MapTiles { most: 16, .. })));
}
