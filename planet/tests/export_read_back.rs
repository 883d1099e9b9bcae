//! Exported heightfields, read back by readers of others: `tobj`, `ply-rs-bw` and `stl_io`, and 3MF by `zip` and
//! `roxmltree`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use glam::{DVec3, Vec3};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use std::collections::HashMap;
use std::io::{Cursor, Read as _};
use terrane_heightfield::plain::simplify;
use terrane_heightfield::{Heightfield, TriangleSurface};
use terrane_planet::export::{ExportError, Format, Model, Up};

const SCALE: DVec3 = DVec3::new(30.0, 25.5, 0.5);

/// Hills, and a surface of few triangles over them.
fn hills() -> (Heightfield, TriangleSurface) {
    let height = |k: usize| ((k % 21) as f32 * 0.4).sin() * 40.0 + ((k / 21) as f32 * 0.3).cos() * 30.0;
    let field = Heightfield::new(21, 17, (0..21 * 17).map(height).collect()).unwrap();
    let surface = simplify(&field).unwrap().polished(&field, 120);
    (field, surface)
}

/// What a reader found.
struct Found {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

type Reader = fn(&[u8]) -> Found;

fn read_obj(bytes: &[u8]) -> Found {
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| Err(tobj::LoadError::OpenFileFailed)).unwrap();
    let mesh = &models[0].mesh;
    let triples = |numbers: &[f32]| numbers.chunks(3).map(Vec3::from_slice).collect::<Vec<_>>();
    Found {
        positions: triples(&mesh.positions).iter().map(|p| p.as_dvec3()).collect(),
        normals: triples(&mesh.normals),
        triangles: mesh.indices.chunks(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

fn read_ply(bytes: &[u8]) -> Found {
    let ply = Parser::<DefaultElement>::new().read_ply(&mut Cursor::new(bytes)).unwrap();
    let number = |element: &DefaultElement, name: &str| match element.get(name) {
        Some(Property::Double(x)) => *x,
        Some(Property::Float(x)) => f64::from(*x),
        other => panic!("{name}: {other:?}"),
    };
    let vector = |element: &DefaultElement, names: [&str; 3]| DVec3::from_array(names.map(|name| number(element, name)));
    let corners = |face: &DefaultElement| match face.get("vertex_indices") {
        Some(Property::ListInt(v)) => [v[0] as u32, v[1] as u32, v[2] as u32],
        other => panic!("{other:?}"),
    };
    let vertices = &ply.payload["vertex"];
    let normals = vertices.iter().filter(|v| v.contains_key("nx")).map(|v| vector(v, ["nx", "ny", "nz"]).as_vec3());
    Found {
        positions: vertices.iter().map(|v| vector(v, ["x", "y", "z"])).collect(),
        normals: normals.collect(),
        triangles: ply.payload["face"].iter().map(corners).collect(),
    }
}

/// The reader welds corners of the same bits.
fn read_stl(bytes: &[u8]) -> Found {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).unwrap();
    Found {
        positions: mesh.vertices.iter().map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect(),
        normals: mesh.faces.iter().map(|f| Vec3::new(f.normal[0], f.normal[1], f.normal[2])).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect(),
    }
}

fn read_3mf(bytes: &[u8]) -> Found {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut text = |name: &str| {
        let mut text = String::new();
        archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
        text
    };
    // From the package to the model, as a reader goes.
    let (types, relations) = (text("[Content_Types].xml"), text("_rels/.rels"));
    let relations = roxmltree::Document::parse(&relations).unwrap();
    let relation = relations.descendants().find(|n| n.tag_name().name() == "Relationship");
    let target = relation.unwrap().attribute("Target").unwrap();
    assert!(roxmltree::Document::parse(&types).unwrap().descendants().any(|n| n.attribute("Extension") == Some("model")));
    let model = text(target.trim_start_matches('/'));
    let model = roxmltree::Document::parse(&model).unwrap();
    let root = model.root_element();
    assert_eq!(root.tag_name().namespace(), Some("http://schemas.microsoft.com/3dmanufacturing/core/2015/02"));
    assert_eq!(root.attribute("unit"), Some("meter"));
    let all = |name: &'static str| model.descendants().filter(move |n| n.tag_name().name() == name);
    let numbers =
        |node: roxmltree::Node, names: [&str; 3]| names.map(|name| node.attribute(name).unwrap().parse::<f64>().unwrap());
    let object = all("object").next().unwrap().attribute("id");
    assert!(all("item").map(|item| item.attribute("objectid")).eq([object]), "one object is built");
    Found {
        positions: all("vertex").map(|n| DVec3::from_array(numbers(n, ["x", "y", "z"]))).collect(),
        normals: Vec::new(),
        triangles: all("triangle").map(|n| numbers(n, ["v1", "v2", "v3"]).map(|v| v as u32)).collect(),
    }
}

fn turned(v: DVec3, up: Up) -> DVec3 {
    match up {
        Up::Y => DVec3::new(v.x, v.z, -v.y),
        Up::Z => v,
    }
}

#[test]
fn surfaces_come_back_upright_with_the_normals_of_the_heights() {
    let (field, surface) = hills();
    let readers: [(Format, Reader); 2] = [(Format::Obj, read_obj), (Format::Ply, read_ply)];
    for ((format, reader), up) in readers.into_iter().flat_map(|r| [(r, Up::Y), (r, Up::Z)]) {
        let bytes = Model::of_heightfield(&surface, &field, SCALE).encode(format, up).unwrap();
        let header = String::from_utf8_lossy(&bytes[..bytes.len().min(300)]).into_owned();
        let axes = if up == Up::Y { "metres, +X east, +Y up, -Z north" } else { "metres, +X east, +Y north, +Z up" };
        assert!(header.contains(axes), "{format:?}: {header}");
        let found = reader(&bytes);
        assert_eq!((found.positions.len(), found.normals.len()), (surface.positions.len(), surface.positions.len()));
        assert_eq!(found.triangles, surface.faces, "{format:?}");
        let exact = if format == Format::Ply { 0.0 } else { 1e-4 };
        for (k, (p, n)) in surface.positions.iter().zip(&found.normals).enumerate() {
            assert!((found.positions[k] - turned(*p * SCALE, up)).length() <= exact, "{format:?}, vertex {k}");
            let slope = |at: &dyn Fn(f64) -> f64, here: f64| (at(here + 0.5) - at(here - 0.5)) * SCALE.z;
            let inside = p.x > 0.0 && p.y > 0.0 && p.x < 20.0 && p.y < 16.0;
            // The slopes of the hills themselves, which differences over two samples meet to a few percent.
            let along = slope(&|x: f64| (x * 0.4).sin() * 40.0, p.x) / SCALE.x;
            let across = slope(&|y: f64| ((16.0 - y) * 0.3).cos() * 30.0, p.y) / SCALE.y;
            let wanted = turned(DVec3::new(-along, -across, 1.0).normalize(), up).as_vec3();
            assert!(!inside || n.angle_between(wanted) < 0.02, "{format:?}, vertex {k}: {n}, expected {wanted}");
        }
    }
}

/// Directed edges without their opposites.
fn open_edges(triangles: &[[u32; 3]]) -> usize {
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    edges.values().map(|n| n.unsigned_abs() as usize).sum()
}

#[test]
fn solids_come_back_closed_with_the_volume_of_the_heights() {
    let (field, surface) = hills();
    let lowest = surface.positions.iter().map(|p| p.z).fold(f64::MAX, f64::min) * SCALE.z;
    let prism = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| surface.positions[v as usize] * SCALE);
        (b - a).truncate().perp_dot((c - a).truncate()) / 2.0 * ((a.z + b.z + c.z) / 3.0 - lowest + 7.0)
    };
    let wanted: f64 = surface.faces.iter().map(prism).sum();
    let readers: [(Format, Reader); 4] =
        [(Format::Obj, read_obj), (Format::Ply, read_ply), (Format::Stl, read_stl), (Format::ThreeMf, read_3mf)];
    for ((format, reader), up) in readers.into_iter().flat_map(|r| [(r, Up::Y), (r, Up::Z)]) {
        let solid = Model::of_heightfield(&surface, &field, SCALE).solid(7.0);
        assert!((solid.volume() / wanted - 1.0).abs() < 1e-9);
        let mut found = reader(&solid.encode(format, up).unwrap());
        assert_eq!(open_edges(&found.triangles), 0, "{format:?}");
        let tetrahedron = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| found.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        let volume: f64 = found.triangles.iter().map(tetrahedron).sum();
        assert!((volume / wanted - 1.0).abs() < 1e-5, "{format:?}: {volume} m³ of {wanted}");
        if format == Format::Stl {
            for (t, n) in found.triangles.iter().zip(&found.normals) {
                let [a, b, c] = t.map(|v| found.positions[v as usize]);
                assert!((b - a).cross(c - a).normalize().as_vec3().distance(*n) < 1e-5);
            }
        }
        found.triangles.pop();
        assert_eq!(open_edges(&found.triangles), 3, "the check sees a hole");
    }
}

#[test]
fn files_for_printers_say_their_unit_and_take_no_open_surface() {
    let (field, surface) = hills();
    for format in [Format::Stl, Format::ThreeMf] {
        let refused = Model::of_heightfield(&surface, &field, SCALE).encode(format, Up::Z);
        assert!(matches!(&refused, Err(ExportError::Open { open_edges, .. }) if *open_edges > 10), "{refused:?}");
        let again = || Model::of_heightfield(&surface, &field, SCALE).solid(1.0).encode(format, Up::Z).unwrap();
        assert!(again() == again(), "{format:?}: the same mesh gives other bytes");
    }
    let stl = Model::of_heightfield(&surface, &field, SCALE).solid(1.0).encode(Format::Stl, Up::Z).unwrap();
    assert!(stl.starts_with(b"Terrane: metres, +X east, +Y north, +Z up "), "{:?}", String::from_utf8_lossy(&stl[..80]));
    let glb = Model::of_heightfield(&surface, &field, SCALE).encode(Format::Glb, Up::Z);
    assert_eq!(glb, Err(ExportError::GltfUp));
}
