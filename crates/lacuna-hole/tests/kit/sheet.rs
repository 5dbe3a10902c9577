//! Pieces of surface that are no part of a lattice.

use glam::{DVec2, DVec3};
use lacuna_mesh::TriMesh;
use std::collections::BTreeMap;

/// A number in [-1, 1) that depends on three others alone.
pub(crate) fn scatter(a: i32, b: i32, salt: u64) -> f64 {
    let mut h = (a as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (b as u64).rotate_left(32) ^ (salt << 17);
    for _ in 0..3 {
        h = (h ^ (h >> 31)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    }
    (h >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A flat rectangle of `nx` x `ny` quads.
pub(crate) fn sheet(low: DVec2, high: DVec2, z: f64, nx: usize, ny: usize) -> TriMesh {
    let steps = |from: f64, to: f64, n: usize| -> Vec<f64> {
        (0..=n).map(|k| if k == n { to } else { from + (to - from) * k as f64 / n as f64 }).collect()
    };
    let rows: Vec<(f64, f64)> = steps(low.y, high.y, ny).into_iter().map(|y| (y, z)).collect();
    block(&steps(low.x, high.x, nx), &rows, |_, _| true)
}

/// A grid of quads over columns `xs` and rows `(y, z)`, without those that `keep(column, row)` refuses. Two rows of one
/// y make a vertical wall.
pub(crate) fn block(xs: &[f64], rows: &[(f64, f64)], keep: impl Fn(usize, usize) -> bool) -> TriMesh {
    let width = xs.len() as u32;
    let positions = rows.iter().flat_map(|&(y, z)| xs.iter().map(move |&x| DVec3::new(x, y, z))).collect();
    let mut triangles = Vec::new();
    for (row, column) in (0..rows.len() - 1).flat_map(|r| (0..xs.len() - 1).map(move |c| (r, c))) {
        if keep(column, row) {
            let v = row as u32 * width + column as u32;
            triangles.extend([[v, v + 1, v + width + 1], [v, v + width + 1, v + width]]);
        }
    }
    TriMesh { positions, triangles }
}

/// Walls below a ring of places that runs counter-clockwise, `depth_m` deep and open at the bottom; they face inward.
pub(crate) fn tube(ring: &[DVec3], depth_m: f64) -> TriMesh {
    let n = ring.len() as u32;
    let mut positions = ring.to_vec();
    positions.extend(ring.iter().map(|p| *p - DVec3::Z * depth_m));
    let triangles = (0..n).flat_map(|k| {
        let next = (k + 1) % n;
        [[k, next, n + next], [k, n + next, n + k]]
    });
    TriMesh { positions, triangles: triangles.collect() }
}

/// Opens a slit in the middle cell of a lattice of 3 x 3: doubles the vertices near (10..14, 11) and moves the upper triangles' ones up.
pub(crate) fn open_slit(mesh: &mut TriMesh, width_m: f64) {
    let is_on_slit = |p: DVec3| (p.y - 11.0).abs() < 0.45 && (9.5..14.5).contains(&p.x);
    let mut doubles: BTreeMap<u32, u32> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let above = corners.iter().any(|p| p.y > 11.5);
        if !above || !(8.0..16.0).contains(&middle.x) {
            continue;
        }
        for k in 0..3 {
            let v = mesh.triangles[t][k];
            if is_on_slit(mesh.positions[v as usize]) && (v as usize) < 81 {
                let new = *doubles.entry(v).or_insert_with(|| {
                    mesh.positions.push(mesh.positions[v as usize] + DVec3::Y * width_m);
                    mesh.positions.len() as u32 - 1
                });
                mesh.triangles[t][k] = new;
            }
        }
    }
}
