//! Exported meshes, read back from their bytes: exact, welded, closed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::convert::Infallible;
use std::path::Path;
use terrane_planet::draw::cut::{cut, is_visible};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::tree::PatchTree;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::export::{origin_near, view_surface, ExportError, Format, Placed, Up, Welded};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::bake::BakePlan;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::select;
use terrane_planet::store::Region;

pub(crate) struct Tiny {
    pub(crate) planet: Planet,
    tree: PatchTree,
    meshes: HashMap<PatchId, PatchMesh>,
}

impl Tiny {
    pub(crate) fn new() -> Tiny {
        let recipe = Recipe::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/recipes/tiny.toml"))).unwrap();
        let planet = Planet::from_recipe(recipe, 16).unwrap();
        let region = Region { direction: direction_at(20.0, 30.0), radius_m: 0.0, to_level: 4 };
        let plan = BakePlan::new(planet.recipe.radius, 1, Some(region)).unwrap();
        let meshes: HashMap<_, _> = plan.patches.iter().map(|&id| (id, planet.build(id).0)).collect();
        let facts = meshes.values().map(|m| (m.id, m.facts));
        let tree = planet.tree(facts);
        Tiny { planet, tree, meshes }
    }

    /// A view over the finest patches, towards the horizon.
    pub(crate) fn view(&self, altitude: f64) -> View {
        let site = direction_at(20.0, 30.0);
        let position = self.planet.position_above(site, altitude);
        let camera = Camera::looking(position, 40.0, -25.0, 0.9, [640, 360]);
        View::new(camera, &self.planet.lattice, self.planet.cells, 1.0).without_geomorphs()
    }

    fn load(&self, id: PatchId) -> LoadedPatch {
        LoadedPatch::new(self.meshes[&id].clone(), &self.planet.lattice)
    }

    pub(crate) fn surface(&self, view: &View, whole: bool) -> Welded {
        view_surface(&self.tree, view, whole, |id| Ok::<_, Infallible>(self.load(id))).unwrap()
    }

    pub(crate) fn placed<'a>(&self, surface: &'a Welded, origin: IVec3) -> Placed<'a> {
        Placed { surface, origin, lattice: self.planet.lattice }
    }
}

/// What a reader makes of a file: vertices in metres from the planet's centre, and triangles.
struct Read {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

type Reader = fn(&[u8]) -> Read;

impl Read {
    /// Directed edges without their opposites, counted without the library's help.
    fn open_edges(&self) -> usize {
        let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
        }
        edges.values().map(|n| n.unsigned_abs() as usize).sum()
    }
}

fn read_obj(bytes: &[u8]) -> Read {
    let mut read = Read { vertices: Vec::new(), triangles: Vec::new() };
    for line in std::str::from_utf8(bytes).unwrap().lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[0] {
            "v" => read.vertices.push(DVec3::from_slice(&words[1..].iter().map(|w| w.parse().unwrap()).collect::<Vec<f64>>())),
            "f" => read.triangles.push([1, 2, 3].map(|k| words[k].parse::<u32>().unwrap() - 1)),
            "#" | "o" => {}
            other => panic!("a line that begins with {other}"),
        }
    }
    read
}

fn read_ply(bytes: &[u8]) -> Read {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
    let count = |what: &str| -> usize { header.lines().find_map(|l| l.strip_prefix(what)).unwrap().trim().parse().unwrap() };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let (points, lists) = bytes[end..].split_at(24 * vertices);
    assert_eq!(lists.len(), 13 * faces);
    let number = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap());
    let corner = |l: &[u8], k: usize| u32::from_le_bytes(l[1 + 4 * k..5 + 4 * k].try_into().unwrap());
    assert!(lists.chunks(13).all(|l| l[0] == 3));
    Read {
        vertices: points.chunks(24).map(|p| DVec3::new(number(&p[..8]), number(&p[8..16]), number(&p[16..]))).collect(),
        triangles: lists.chunks(13).map(|l| [0, 1, 2].map(|k| corner(l, k))).collect(),
    }
}

fn read_glb(bytes: &[u8]) -> Read {
    use gltf_json::validation::Validate;
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let (document, rest) = bytes[20..].split_at(word(12));
    assert_eq!((&bytes[16..20], &rest[4..8]), (&b"JSON"[..], &b"BIN\0"[..]));
    let binary = &rest[8..];
    assert_eq!(word(20 + document.len()), binary.len());
    let root: gltf_json::Root = gltf_json::deserialize::from_slice(document).unwrap();
    let mut faults = Vec::new();
    root.validate(&root, gltf_json::Path::new, &mut |path, error| faults.push(format!("{}: {error:?}", path())));
    assert_eq!(faults, Vec::<String>::new());
    let part = |accessor: usize| {
        let view = &root.buffer_views[root.accessors[accessor].buffer_view.unwrap().value()];
        let start = view.byte_offset.unwrap().0 as usize;
        &binary[start..start + view.byte_length.0 as usize]
    };
    let floats: Vec<f32> = part(0).chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let indices: Vec<u32> = part(1).chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(3 * root.accessors[0].count.0 as usize, floats.len());
    assert_eq!(root.accessors[1].count.0 as usize, indices.len());
    let node = &root.nodes[0];
    let extras: serde_json::Value = serde_json::from_str(node.extras.as_ref().unwrap().get()).unwrap();
    let unit = extras["unit_m"].as_f64().unwrap();
    let offset = DVec3::from_array([0, 1, 2].map(|k| extras["origin_lattice"][k].as_f64().unwrap() * unit));
    let translation = node.translation.unwrap();
    assert_eq!(translation.map(f64::from), [offset.x, offset.z, -offset.y], "the translation is exact");
    Read {
        vertices: floats.chunks(3).map(|p| offset + DVec3::new(f64::from(p[0]), -f64::from(p[2]), f64::from(p[1]))).collect(),
        triangles: indices.chunks(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[test]
fn whole_planets_are_closed_in_every_format() {
    let tiny = Tiny::new();
    let view = tiny.view(300.0);
    let surface = tiny.surface(&view, true);
    assert!(surface.triangles.len() > 2000 && surface.open_edges() == 0);
    // A closed surface around a ball, without vertices that no triangle uses.
    assert_eq!(surface.positions.len() as i64 - surface.triangles.len() as i64 / 2, 2, "Euler characteristic");
    let placed = tiny.placed(&surface, IVec3::ZERO);
    let exact: Vec<DVec3> = surface.positions.iter().map(|p| p.as_dvec3() * tiny.planet.lattice.unit).collect();
    let formats: [(Format, Reader); 3] = [(Format::Obj, read_obj), (Format::Ply, read_ply), (Format::Glb, read_glb)];
    for (format, reader) in formats {
        let up = if format == Format::Glb { Up::Y } else { Up::Z };
        let mut read = reader(&placed.encode(format, up).unwrap());
        assert_eq!(read.triangles, surface.triangles, "{format:?}");
        assert_eq!(read.open_edges(), 0, "{format:?}");
        if format == Format::Glb {
            let error = read.vertices.iter().zip(&exact).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
            assert!(error <= placed.largest_coordinate() * 2f64.powi(-24), "{error}");
        } else {
            assert!(read.vertices == exact, "{format:?} is not exact");
        }
        read.triangles.pop();
        assert_eq!(read.open_edges(), 3, "{format:?}: the check sees a hole");
    }
}

#[test]
fn a_view_has_the_triangles_of_the_twins() {
    let tiny = Tiny::new();
    for altitude in [20.0, 400.0, 1500.0] {
        let view = tiny.view(altitude);
        let mut corners = Vec::new();
        for leaf in cut(&tiny.tree, &view, &|_| true).leaves {
            if !is_visible(&tiny.tree, &view, &tiny.tree.get(leaf.id).unwrap().space) {
                continue;
            }
            let patch = tiny.load(leaf.id);
            let work = patch.reach.work(&view);
            let vertices = &patch.vertices[..work.vertices as usize];
            let selected = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
            let resolved = resolve(vertices, &selected.awake);
            let drawn = emit(&view.gpu, &patch.triangles(&work), &resolved, &selected.drawn_positions);
            corners.extend(drawn.iter().map(|t| t.map(|v| vertices[v as usize].position)));
        }
        let surface = tiny.surface(&view, false);
        let found: Vec<_> = surface.triangles.iter().map(|t| t.map(|v| surface.positions[v as usize].to_array())).collect();
        assert!(found == corners, "{} triangles, expected {}", found.len(), corners.len());
        assert!(found.len() > 50 && surface.triangles.len() < tiny.surface(&view, true).triangles.len());
        assert!(surface.open_edges() > 0, "a view ends somewhere");
    }
}

#[test]
fn origins_near_the_view_make_glb_precise() {
    let tiny = Tiny::new();
    let view = tiny.view(5.0);
    let surface = tiny.surface(&view, false);
    let worst = |origin: IVec3| {
        let read = read_glb(&tiny.placed(&surface, origin).encode(Format::Glb, Up::Y).unwrap());
        let near = |p: &DVec3| p.distance(view.camera.position) < 100.0;
        let exact = surface.positions.iter().map(|p| p.as_dvec3() * tiny.planet.lattice.unit);
        read.vertices.iter().zip(exact).filter(|(_, e)| near(e)).map(|(a, e)| a.distance(e)).fold(0.0, f64::max)
    };
    let (near, far) = (worst(origin_near(view.gpu.anchor)), worst(IVec3::ZERO));
    assert!(near < 1e-5 && far > 10.0 * near, "{near} {far}");
}

#[test]
fn normals_are_those_of_the_ground_and_solids_of_a_view_are_closed() {
    let tiny = Tiny::new();
    let view = tiny.view(300.0);
    let surface = tiny.surface(&view, false);
    let placed = tiny.placed(&surface, origin_near(view.gpu.anchor));
    let ply = placed.model_with_normals(&tiny.planet.ground()).encode(Format::Ply, Up::Z).unwrap();
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let normal = |k: usize| {
        let float = |at: usize| f64::from(f32::from_le_bytes(ply[at..at + 4].try_into().unwrap()));
        DVec3::from_array([24, 28, 32].map(|offset| float(end + 36 * k + offset)))
    };
    // Against the faces around each vertex, which a fine mesh makes nearly the same; upside down they are not.
    let mut faces = vec![DVec3::ZERO; surface.positions.len()];
    for t in &surface.triangles {
        let [a, b, c] = t.map(|v| placed.metres(surface.positions[v as usize]));
        t.iter().for_each(|&v| faces[v as usize] += (b - a).cross(c - a));
    }
    let likeness: Vec<f64> = faces.iter().enumerate().map(|(k, f)| f.normalize().dot(normal(k))).collect();
    let near = likeness.iter().filter(|&&cosine| cosine > 0.95).count();
    assert!(near as f64 > 0.9 * likeness.len() as f64, "{near} of {}", likeness.len());
    assert!((0..faces.len()).all(|k| (normal(k).length() - 1.0).abs() < 1e-6));

    let solid = placed.solid(250.0);
    assert!(surface.open_edges() > 0 && solid.open_edges() == 0);
    let area: f64 = surface
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| placed.metres(surface.positions[v as usize]));
            (b - a).cross(c - a).length() / 2.0
        })
        .sum();
    assert!(solid.volume() > 0.5 * 250.0 * area, "{} m³ under {area} m²", solid.volume());
}

#[test]
fn a_crack_of_one_lattice_unit_is_found() {
    let tiny = Tiny::new();
    let surface = tiny.surface(&tiny.view(300.0), true);
    // The same triangles, one corner moved by one lattice unit in one of them: a crack that no tolerance would find.
    let mut cracked = surface.clone();
    cracked.positions.push(surface.positions[0] + IVec3::X);
    let torn = cracked.triangles.iter_mut().find(|t| t[0] == 0).unwrap();
    torn[0] = surface.positions.len() as u32;
    assert_eq!(cracked.open_edges(), 4);
    let read = read_ply(&tiny.placed(&cracked, IVec3::ZERO).encode(Format::Ply, Up::Z).unwrap());
    assert_eq!(read.open_edges(), 4);
}

#[test]
fn formats_follow_extensions_and_an_empty_mesh_is_an_error() {
    assert_eq!(Format::of(Path::new("a/b.GLB")), Ok(Format::Glb));
    assert_eq!(Format::of(Path::new("b.stl")), Ok(Format::Stl));
    assert_eq!(Format::of(Path::new("b.dae")), Err(ExportError::UnknownFormat { file: "b.dae".into() }));
    assert!(Format::of(Path::new("glb")).is_err());
    let tiny = Tiny::new();
    let nothing = Welded::default();
    assert_eq!(tiny.placed(&nothing, IVec3::ZERO).encode(Format::Obj, Up::Y), Err(ExportError::Empty));
}
