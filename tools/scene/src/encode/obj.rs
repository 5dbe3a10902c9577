//! OBJ: positions and faces.

use super::{Origin, metres};
use crate::tile::Tile;
use std::fmt::Write;

/// Text with the shortest decimals that give back the same f64.
pub(super) fn text(tile: &Tile, origin: &Origin) -> Vec<u8> {
    let mut text = String::from("# synthetic scene\n");
    for &vertex in &tile.vertices {
        let [x, y, z] = metres(vertex, origin.shift_m);
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for triangle in &tile.triangles {
        let [a, b, c] = triangle.map(|v| v + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}
