//! PLY in its three dialects.

use super::{Origin, metres};
use crate::tile::Tile;
use std::fmt::Write;

/// Binary, f32; exact as long as coordinates stay below 2^24 lattice units.
pub(super) fn single(tile: &Tile) -> Vec<u8> {
    let mut bytes = header("binary_little_endian", "float", tile).into_bytes();
    for &vertex in &tile.vertices {
        bytes.extend(metres(vertex, [0.0; 2]).iter().flat_map(|&k| (k as f32).to_le_bytes()));
    }
    push_faces(&mut bytes, tile);
    bytes
}

/// Binary, f64.
pub(super) fn double(tile: &Tile, origin: &Origin) -> Vec<u8> {
    let mut bytes = header("binary_little_endian", "double", tile).into_bytes();
    for &vertex in &tile.vertices {
        bytes.extend(metres(vertex, origin.shift_m).iter().flat_map(|k| k.to_le_bytes()));
    }
    push_faces(&mut bytes, tile);
    bytes
}

/// Text; numbers are written in full.
pub(super) fn ascii(tile: &Tile) -> Vec<u8> {
    let mut text = header("ascii", "float", tile);
    for &vertex in &tile.vertices {
        let [x, y, z] = metres(vertex, [0.0; 2]);
        let _ = writeln!(text, "{x} {y} {z}");
    }
    for [a, b, c] in &tile.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text.into_bytes()
}

fn header(encoding: &str, number: &str, tile: &Tile) -> String {
    let (vertices, faces) = (tile.vertices.len(), tile.triangles.len());
    format!(
        "ply\nformat {encoding} 1.0\ncomment synthetic scene\nelement vertex {vertices}\n\
         property {number} x\nproperty {number} y\nproperty {number} z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn push_faces(bytes: &mut Vec<u8>, tile: &Tile) {
    bytes.reserve(13 * tile.triangles.len());
    for triangle in &tile.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
}
