//! The binary chunk of a GLB file while it grows: views of it, one an attribute, and the accessors that give them
//! types; as they are, or packed by a codec.

use super::super::ExportError;
use super::packing::{failed, MeshCodec, EXTENSION};
use serde_json::{json, Value};

/// Component types and buffer targets, as OpenGL numbers them.
pub(super) const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
pub(super) const UNSIGNED_SHORT: u32 = 5123;
pub(super) const SHORT: u32 = 5122;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;

/// What an accessor says about its numbers.
pub(super) struct Numbers {
    /// Component type.
    pub component: u32,
    /// Components of an element.
    pub parts: usize,
    /// Whether whole numbers stand for shares of their largest.
    pub normalized: bool,
}

/// Bytes, and what lies where.
#[derive(Default)]
pub(super) struct Buffers<'a> {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    /// What packs numbers.
    codec: Option<&'a dyn MeshCodec>,
    /// Bytes of the numbers that are there packed alone: those of a second buffer that no file holds.
    unpacked: usize,
}

/// Numbers as they are in a file.
enum Stored {
    Plain,
    Packed { bytes: Vec<u8>, stride: usize, mode: &'static str },
}

impl<'a> Buffers<'a> {
    /// Nothing yet, to be packed by a codec if there is one.
    pub(super) fn packed_by(codec: Option<&'a dyn MeshCodec>) -> Buffers<'a> {
        Buffers { codec, ..Buffers::default() }
    }

    /// Adds an attribute of vertices; elements begin at multiples of four bytes. Out: the number of its accessor.
    pub(super) fn attribute(
        &mut self,
        numbers: &Numbers,
        count: usize,
        bytes: &[u8],
        bounds: Option<[Value; 2]>,
    ) -> Result<usize, ExportError> {
        let stride = bytes.len() / count.max(1);
        let packed = self.codec.map(|codec| codec.attributes(bytes, stride)).transpose().map_err(failed)?;
        let stored = packed.map_or(Stored::Plain, |bytes| Stored::Packed { bytes, stride, mode: "ATTRIBUTES" });
        let mut view = self.view(bytes, stored);
        (view["byteStride"], view["target"]) = (stride.into(), ARRAY_BUFFER.into());
        Ok(self.accessor(view, numbers, count, bounds))
    }

    /// Adds triangles, in 16 bits or in 32. Out: the number of the accessor of their corners.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]], vertices: usize, short: bool) -> Result<usize, ExportError> {
        let corners = triangles.as_flattened();
        let (component, stride, bytes): (u32, usize, Vec<u8>) = if short {
            (UNSIGNED_SHORT, 2, corners.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect())
        } else {
            (UNSIGNED_INT, 4, corners.iter().flat_map(|v| v.to_le_bytes()).collect())
        };
        let packed = self.codec.map(|codec| codec.triangles(triangles, vertices)).transpose().map_err(failed)?;
        let stored = packed.map_or(Stored::Plain, |bytes| Stored::Packed { bytes, stride, mode: "TRIANGLES" });
        let mut view = self.view(&bytes, stored);
        view["target"] = ELEMENT_ARRAY_BUFFER.into();
        Ok(self.accessor(view, &Numbers { component, parts: 1, normalized: false }, corners.len(), None))
    }

    /// Adds the file of a picture. Out: the number of its view.
    pub(super) fn picture(&mut self, bytes: &[u8]) -> usize {
        let view = self.view(bytes, Stored::Plain);
        self.views.push(view);
        self.views.len() - 1
    }

    /// What the document says about its buffers: the file's own, and one that only stands for what is packed.
    pub(super) fn described(&self) -> Value {
        let own = json!({ "byteLength": self.bytes.len() });
        if self.unpacked == 0 {
            return json!([own]);
        }
        json!([own, { "byteLength": self.unpacked, "extensions": { EXTENSION: { "fallback": true } } }])
    }

    /// Adds bytes. Out: a view of them, or of what they are once they are unpacked.
    fn view(&mut self, bytes: &[u8], stored: Stored) -> Value {
        let Stored::Packed { bytes: packed, stride, mode } = stored else {
            return json!({ "buffer": 0, "byteOffset": self.append(bytes), "byteLength": bytes.len() });
        };
        let offset = self.unpacked;
        self.unpacked += bytes.len().next_multiple_of(4);
        let count = bytes.len() / stride.max(1);
        let extension = json!({
            "buffer": 0, "byteOffset": self.append(&packed), "byteLength": packed.len(), "byteStride": stride, "count": count, "mode": mode,
        });
        json!({ "buffer": 1, "byteOffset": offset, "byteLength": bytes.len(), "extensions": { EXTENSION: extension } })
    }

    fn accessor(&mut self, view: Value, numbers: &Numbers, count: usize, bounds: Option<[Value; 2]>) -> usize {
        self.views.push(view);
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][numbers.parts - 1];
        let mut accessor = json!({
            "bufferView": self.views.len() - 1, "componentType": numbers.component, "count": count, "type": kind,
        });
        if numbers.normalized {
            accessor["normalized"] = true.into();
        }
        if let Some([low, high]) = bounds {
            accessor["min"] = low;
            accessor["max"] = high;
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Where bytes begin that are added after a whole word.
    fn append(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        offset
    }
}
