//! `--compress`: GLB files that unpack to the bytes of those without it, by meshoptimizer's own decoders.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use crate::mesh_and_bench::planet_in;
use serde_json::{json, Value};
use std::path::Path;

const EXTENSION: &str = "EXT_meshopt_compression";

/// A GLB file.
struct Glb {
    length: usize,
    document: Value,
    binary: Vec<u8>,
}

fn index(value: &Value) -> usize {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number")) as usize
}

impl Glb {
    fn read(path: &Path) -> Glb {
        let bytes = std::fs::read(path).unwrap();
        let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let document = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
        Glb { length: bytes.len(), document, binary: bytes[28 + json..].to_vec() }
    }

    /// The bytes of a view, unpacked as its extension says.
    fn view(&self, number: usize) -> Result<Vec<u8>, String> {
        let view = &self.document["bufferViews"][number];
        let part = |of: &Value| self.binary[index(&of["byteOffset"])..][..index(&of["byteLength"])].to_vec();
        let Some(packed) = view.get("extensions").map(|extensions| &extensions[EXTENSION]) else {
            assert_eq!(view["buffer"], 0);
            return Ok(part(view));
        };
        assert_eq!((&view["buffer"], &packed["buffer"]), (&json!(1), &json!(0)));
        let (bytes, count, stride) = (part(packed), index(&packed["count"]), index(&packed["byteStride"]));
        assert_eq!(count * stride, index(&view["byteLength"]));
        let flat = |unpacked: meshopt::Result<Vec<u8>>| unpacked.map_err(|error| error.to_string());
        match (packed["mode"].as_str().unwrap(), stride) {
            ("ATTRIBUTES", stride) => {
                assert_eq!((bytes[0], &view["byteStride"]), (0xa0, &json!(stride)), "version 0 is what the extension allows");
                flat(match stride {
                    4 => meshopt::decode_vertex_buffer::<[u8; 4]>(&bytes, count).map(|v| v.concat()),
                    8 => meshopt::decode_vertex_buffer::<[u8; 8]>(&bytes, count).map(|v| v.concat()),
                    12 => meshopt::decode_vertex_buffer::<[u8; 12]>(&bytes, count).map(|v| v.concat()),
                    16 => meshopt::decode_vertex_buffer::<[u8; 16]>(&bytes, count).map(|v| v.concat()),
                    other => panic!("a stride of {other}"),
                })
            }
            ("TRIANGLES", 2) => {
                assert_eq!(bytes[0], 0xe1);
                flat(meshopt::decode_index_buffer::<u16>(&bytes, count).map(|v| v.iter().flat_map(|c| c.to_le_bytes()).collect()))
            }
            ("TRIANGLES", 4) => {
                assert_eq!(bytes[0], 0xe1);
                flat(meshopt::decode_index_buffer::<u32>(&bytes, count).map(|v| v.iter().flat_map(|c| c.to_le_bytes()).collect()))
            }
            other => panic!("{other:?}"),
        }
    }

    /// All triangles in an order of their own: of each corner all bytes of all attributes, the least corner first.
    fn triangles(&self) -> Result<Vec<[Vec<u8>; 3]>, String> {
        let primitive = &self.document["meshes"][0]["primitives"][0];
        let accessor = |number: &Value| &self.document["accessors"][index(number)];
        let mut attributes = Vec::new();
        for (name, number) in primitive["attributes"].as_object().unwrap() {
            let view = index(&accessor(number)["bufferView"]);
            let stride = index(&self.document["bufferViews"][view]["byteStride"]);
            attributes.push((name, stride, self.view(view)?));
        }
        let corners = accessor(&primitive["indices"]);
        let bytes = self.view(index(&corners["bufferView"]))?;
        let numbers: Vec<usize> = match corners["componentType"].as_u64() {
            Some(5123) => bytes.chunks(2).map(|b| usize::from(u16::from_le_bytes(b.try_into().unwrap()))).collect(),
            _ => bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()) as usize).collect(),
        };
        let vertex =
            |v: usize| attributes.iter().flat_map(|(_, stride, bytes)| &bytes[v * stride..][..*stride]).copied().collect();
        let mut triangles: Vec<[Vec<u8>; 3]> = numbers
            .chunks(3)
            .map(|t| {
                let mut corners: [Vec<u8>; 3] = [vertex(t[0]), vertex(t[1]), vertex(t[2])];
                let least = (0..3).min_by_key(|&k| &corners[k]).unwrap();
                corners.rotate_left(least);
                corners
            })
            .collect();
        triangles.sort_unstable();
        Ok(triangles)
    }
}

#[test]
fn packed_meshes_unpack_to_the_same_bytes_and_take_less_room() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let dem = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/jacksboro_fault_dem.tif");
    let simplify = ["simplify", dem.to_str().unwrap(), "--faces", "3000"];
    let mesh = ["mesh", "tiny.planet", "--at", "10,20,500", "--look", "30,-20"];
    let kinds: [&[&str]; 4] = [&[], &["--quantize"], &["--maps", "256"], &["--maps", "256", "--quantize"]];
    for (command, kind) in [&simplify[..], &mesh].into_iter().flat_map(|command| kinds.map(|kind| (command, kind))) {
        let written = |name: &str, more: &[&str]| {
            let output = terrane(&[command, kind, more, &["--out", name]].concat(), folder.path());
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            Glb::read(&folder.path().join(name))
        };
        let (plain, mut packed) = (written("plain.glb", &[]), written("packed.glb", &["--compress"]));
        let wanted = plain.triangles().unwrap();
        assert!(wanted.len() > 50 && packed.triangles().as_ref() == Ok(&wanted), "{command:?} {kind:?}");
        assert_eq!(packed.document["materials"], plain.document["materials"]);
        if kind.is_empty() {
            assert!(packed.length < plain.length * 3 / 4, "{} of {} bytes", packed.length, plain.length);
        }
        // Readers must know it, and one buffer stands for what is packed.
        assert!(packed.document["extensionsRequired"].as_array().unwrap().contains(&json!(EXTENSION)));
        let fallback = &packed.document["buffers"][1];
        assert_eq!((&fallback["extensions"][EXTENSION]["fallback"], fallback.get("uri")), (&json!(true), None));
        assert_eq!(packed.document["buffers"].as_array().unwrap().len(), 2);
        // A byte of the packed positions that is another gives other triangles, or none.
        let positions = &packed.document["bufferViews"][0]["extensions"][EXTENSION];
        let middle = index(&positions["byteOffset"]) + index(&positions["byteLength"]) / 2;
        packed.binary[middle] ^= 0x55;
        assert!(packed.triangles().as_ref() != Ok(&wanted), "the check sees a byte");
    }
    let output = terrane(&[&simplify[..], &["--compress", "--out", "x.ply"]].concat(), folder.path());
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("--compress: PLY files cannot hold it"));
}
