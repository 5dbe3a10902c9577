//! GLB: one mesh, one node, y up.

use super::{Origin, metres};
use crate::tile::Tile;
use serde_json::json;

/// Binary glTF: (x, y, z) is stored as (x, z, -y); positions count from the cell's corner, which is the node's
/// translation.
pub(super) fn binary(tile: &Tile, origin: &Origin) -> Vec<u8> {
    let local: Vec<[f32; 3]> = tile.vertices.iter().map(|&v| y_up(v, origin.corner)).collect();
    let mut buffer: Vec<u8> = tile.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let index_bytes = buffer.len();
    buffer.extend(local.iter().flatten().flat_map(|k| k.to_le_bytes()));
    let json = document(tile, &local, origin, index_bytes, buffer.len());
    container(json.to_string().into_bytes(), buffer)
}

fn y_up([x, y, z]: [i64; 3], corner: [i64; 2]) -> [f32; 3] {
    let [x, y, z] = metres([x - corner[0], y - corner[1], z], [0.0; 2]);
    // 0 - y, since -0 would be another bit pattern than 0.
    [x as f32, z as f32, (0.0 - y) as f32]
}

fn document(
    tile: &Tile,
    local: &[[f32; 3]],
    origin: &Origin,
    index_bytes: usize,
    bytes: usize,
) -> serde_json::Value {
    let bound = |pick: fn(f32, f32) -> f32| {
        let start = local.first().copied().unwrap_or_default();
        local.iter().fold(start, |a, b| [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])])
    };
    let [x, y, _] = metres([origin.corner[0], origin.corner[1], 0], [0.0; 2]);
    json!({
        "asset": {"version": "2.0", "generator": "scene"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [x, 0.0, 0.0 - y]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5125, "count": 3 * tile.triangles.len(), "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": local.len(), "type": "VEC3",
             "min": bound(f32::min), "max": bound(f32::max)}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": index_bytes, "target": 34963},
            {"buffer": 0, "byteOffset": index_bytes, "byteLength": bytes - index_bytes, "target": 34962}
        ],
        "buffers": [{"byteLength": bytes}]
    })
}

fn container(mut json: Vec<u8>, buffer: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + buffer.len();
    let mut bytes = Vec::with_capacity(total);
    bytes.extend(b"glTF");
    bytes.extend([2, total as u32, json.len() as u32].iter().flat_map(|k| k.to_le_bytes()));
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}
