//! What is added to a document: bytes, views, accessors, primitives.

use super::patch::{Colours, LocalPatch};
use crate::types::HolePatch;
use serde_json::{Map, Value, json};

/// Name of the material, mesh and node that patches get.
pub(super) const NAME: &str = "lacuna_patch";
/// From this number of vertices on indices are 32 bit: 65,535 restarts a primitive.
const WIDE_FROM: usize = 65_535;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;

/// Additions, numbered from where the document's own arrays end.
#[derive(Debug, Default)]
pub(super) struct Draft {
    /// New bytes; the first one lies at `first_byte` of `buffer`.
    pub(super) bytes: Vec<u8>,
    /// New elements of `bufferViews`.
    pub(super) views: Vec<Value>,
    /// New elements of `accessors`.
    pub(super) accessors: Vec<Value>,
    /// True if a patch has colours.
    pub(super) coloured: bool,
    base: Base,
}

/// Where the document's own arrays end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Base {
    /// Buffer that takes the bytes.
    pub(super) buffer: usize,
    /// Offset of the first new byte in it, a multiple of four.
    pub(super) first_byte: usize,
    /// Number of buffer views.
    pub(super) views: usize,
    /// Number of accessors.
    pub(super) accessors: usize,
    /// Index that the patch material gets.
    pub(super) material: usize,
}

impl Draft {
    /// An empty draft behind the document's own arrays.
    pub(super) fn new(base: Base) -> Self {
        Self { base, ..Self::default() }
    }

    /// Adds a patch; returns its primitive.
    pub(super) fn primitive(&mut self, patch: &HolePatch, local: &LocalPatch) -> Value {
        let (min, max) = bounds(&local.positions);
        let count = local.positions.len();
        let position =
            self.vectors(floats(&local.positions), "VEC3", json!({ "min": min, "max": max }), count);
        let normal = self.vectors(floats(&local.normals), "VEC3", json!({}), count);
        let mut attributes =
            Map::from_iter([("POSITION".to_owned(), position), ("NORMAL".to_owned(), normal)]);
        if let Some(colours) = &local.colours {
            self.coloured = true;
            attributes.insert("COLOR_0".to_owned(), self.colours(colours));
        }
        let indices = self.indices(&local.triangles, count);
        json!({
            "attributes": attributes,
            "indices": indices,
            "material": self.base.material,
            "mode": 4,
            "extras": { "lacuna": mark(patch) },
        })
    }

    /// The patch material: unlit where the document is.
    pub(super) fn material(&self, unlit: bool) -> Value {
        let base = if self.coloured { [1.0, 1.0, 1.0, 1.0] } else { [0.6, 0.6, 0.6, 1.0] };
        let shading = json!({ "baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 1.0 });
        let mut material = json!({ "name": NAME, "pbrMetallicRoughness": shading });
        if unlit {
            material["extensions"] = json!({ "KHR_materials_unlit": {} });
        }
        material
    }

    fn colours(&mut self, colours: &Colours) -> Value {
        match colours {
            Colours::Bytes(values) => {
                let more = json!({ "componentType": 5121, "normalized": true });
                self.vectors(values.concat(), "VEC4", more, values.len())
            }
            Colours::Floats(values) => self.vectors(floats(values), "VEC4", json!({}), values.len()),
        }
    }

    /// Adds an attribute of floats (or what `more` says); returns its accessor.
    fn vectors(&mut self, bytes: Vec<u8>, kind: &str, more: Value, count: usize) -> Value {
        let view = self.view(bytes, ARRAY_BUFFER);
        let mut accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        if let (Value::Object(accessor), Value::Object(more)) = (&mut accessor, more) {
            accessor.extend(more);
        }
        self.accessor(accessor)
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> Value {
        let corners = triangles.iter().flatten();
        let (bytes, component): (Vec<u8>, u32) = if vertices >= WIDE_FROM {
            (corners.flat_map(|v| v.to_le_bytes()).collect(), 5125)
        } else {
            (corners.flat_map(|v| (*v as u16).to_le_bytes()).collect(), 5123)
        };
        let view = self.view(bytes, ELEMENT_ARRAY_BUFFER);
        let count = triangles.len() * 3;
        self.accessor(
            json!({ "bufferView": view, "componentType": component, "count": count, "type": "SCALAR" }),
        )
    }

    /// Adds bytes at the next multiple of four; returns the index of their view.
    fn view(&mut self, bytes: Vec<u8>, target: u32) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({
            "buffer": self.base.buffer,
            "byteOffset": self.base.first_byte + self.bytes.len(),
            "byteLength": bytes.len(),
            "target": target,
        }));
        self.bytes.extend(bytes);
        self.base.views + self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> Value {
        self.accessors.push(accessor);
        json!(self.base.accessors + self.accessors.len() - 1)
    }
}

/// What tells a patch apart: `extras.lacuna` of its primitive.
fn mark(patch: &HolePatch) -> Value {
    json!({
        "hole": patch.hole,
        "cluster": patch.cluster,
        "class": patch.class,
        "shape": patch.shape,
        "method": patch.method,
        "area_m2": patch.area_m2,
    })
}

fn floats<const N: usize>(vectors: &[[f32; N]]) -> Vec<u8> {
    vectors.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    positions.iter().fold(start, |(min, max), p| {
        (std::array::from_fn(|k| min[k].min(p[k])), std::array::from_fn(|k| max[k].max(p[k])))
    })
}
