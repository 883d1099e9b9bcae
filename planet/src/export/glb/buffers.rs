//! The binary chunk of a GLB file while it grows: views of it, one an attribute, and the accessors that give them types.

use serde_json::{json, Value};

/// Component types and buffer targets, as OpenGL numbers them.
pub(super) const FLOAT: u32 = 5126;
pub(super) const UNSIGNED_INT: u32 = 5125;
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
pub(super) struct Buffers {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Buffers {
    /// Adds an attribute of vertices; elements begin at multiples of four bytes. Out: the number of its accessor.
    pub(super) fn attribute(&mut self, numbers: &Numbers, count: usize, bytes: &[u8], bounds: Option<[Value; 2]>) -> usize {
        let stride = bytes.len() / count.max(1);
        let offset = self.append(bytes);
        let view = json!({
            "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "byteStride": stride, "target": ARRAY_BUFFER,
        });
        self.accessor(view, numbers, count, bounds)
    }

    /// Adds the corners of triangles. Out: the number of their accessor.
    pub(super) fn indices(&mut self, component: u32, count: usize, bytes: &[u8]) -> usize {
        let offset = self.append(bytes);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": ELEMENT_ARRAY_BUFFER });
        self.accessor(view, &Numbers { component, parts: 1, normalized: false }, count, None)
    }

    /// Adds the file of a picture. Out: the number of its view.
    pub(super) fn picture(&mut self, bytes: &[u8]) -> usize {
        let offset = self.append(bytes);
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }));
        self.views.len() - 1
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
