//! Cells cut from one lattice: neighbours share their border vertices bit for bit.

use super::scene::Scene;
use super::{CELL, CELL_M};
use glam::{DVec2, DVec3};
use lacuna_grid::{CellId, Grid};
use lacuna_mesh::TriMesh;
use std::collections::BTreeMap;

/// What is done to the full lattice, in turn. Places are lattice places, metres, whatever the jitter does to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// Triangles with their middle in this rectangle go: west, south, east, north.
    Cut([f64; 4]),
    /// Triangles with their middle in this rectangle come back.
    Keep([f64; 4]),
    /// Triangles with their middle in this disc go: centre and radius.
    CutDisc(f64, f64, f64),
    /// Triangles with their middle in this disc come back.
    KeepDisc(f64, f64, f64),
    /// The cell of this column and row has no tile.
    Missing(i32, i32),
    /// The tile of this cell has no triangle.
    Empty(i32, i32),
}

/// `columns` x `rows` cells of a lattice of one-metre quads whose vertices are moved by up to `jitter_m` (along the
/// border only where they lie on one), after `steps`.
pub(crate) fn lattice(columns: i32, rows: i32, jitter_m: f64, steps: &[Step]) -> Scene {
    lattice_of(columns, rows, steps, &|gx, gy| place(gx, gy, jitter_m))
}

/// As [`lattice`], with the place of every lattice vertex given.
pub(crate) fn lattice_of(
    columns: i32,
    rows: i32,
    steps: &[Step],
    place: &dyn Fn(i32, i32) -> DVec3,
) -> Scene {
    let mut tiles = BTreeMap::new();
    let mut removed_m2 = 0.0;
    for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let is_named = |s: &Step| *s == Step::Missing(i, j) || *s == Step::Empty(i, j);
        let (mut mesh, removed) = cell_mesh(i, j, steps, place);
        if steps.iter().any(is_named) {
            removed_m2 += CELL_M * CELL_M;
            mesh = TriMesh::default();
        } else {
            removed_m2 += removed;
        }
        if !steps.contains(&Step::Missing(i, j)) {
            tiles.insert(CellId::new(i, j), mesh);
        }
    }
    let grid = Grid { origin: DVec2::ZERO, cell_size_m: CELL_M };
    Scene { removed_m2, ..Scene::new(grid, tiles) }
}

/// A gentle slope with a bow, metres.
pub(crate) fn height(p: DVec2) -> f64 {
    5.0 + 0.03 * p.x - 0.02 * p.y + 0.002 * (p.x - 11.0) * (p.y - 7.0)
}

fn place(gx: i32, gy: i32, jitter_m: f64) -> DVec3 {
    let moved = |g: i32, salt: u64| {
        let on_border = g.rem_euclid(CELL) == 0;
        let along = super::scatter(gx, gy, salt);
        f64::from(g) + if on_border { 0.0 } else { jitter_m * along }
    };
    let p = DVec2::new(moved(gx, 1), moved(gy, 2));
    p.extend(height(p))
}

/// The triangles of one cell that are left, and the plan area of those that are not.
fn cell_mesh(i: i32, j: i32, steps: &[Step], place: &dyn Fn(i32, i32) -> DVec3) -> (TriMesh, f64) {
    let mut mesh = TriMesh::default();
    let mut numbers: BTreeMap<(i32, i32), u32> = BTreeMap::new();
    let mut removed_m2 = 0.0;
    for (gx, gy) in (0..CELL).flat_map(|y| (0..CELL).map(move |x| (i * CELL + x, j * CELL + y))) {
        for corners in quad(gx, gy) {
            let places = corners.map(|(x, y)| place(x, y));
            if is_left(steps, corners) {
                let triangle = corners.map(|c| {
                    *numbers.entry(c).or_insert_with(|| {
                        mesh.positions.push(place(c.0, c.1));
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.triangles.push(triangle);
            } else {
                let [a, b, c] = places.map(|p| p.truncate());
                removed_m2 += (b - a).perp_dot(c - a) / 2.0;
            }
        }
    }
    (mesh, removed_m2)
}

/// The two triangles of a quad; the diagonals change direction from quad to quad.
fn quad(x: i32, y: i32) -> [[(i32, i32); 3]; 2] {
    let [a, b, c, d] = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
    if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

fn is_left(steps: &[Step], corners: [(i32, i32); 3]) -> bool {
    let sum = corners.iter().fold(DVec2::ZERO, |s, c| s + DVec2::new(f64::from(c.0), f64::from(c.1)));
    let middle = sum / 3.0;
    let inside = |[x0, y0, x1, y1]: [f64; 4]| (x0..x1).contains(&middle.x) && (y0..y1).contains(&middle.y);
    let near = |x: f64, y: f64, radius: f64| middle.distance(DVec2::new(x, y)) < radius;
    steps.iter().fold(true, |left, step| match *step {
        Step::Cut(r) => left && !inside(r),
        Step::Keep(r) => left || inside(r),
        Step::CutDisc(x, y, r) => left && !near(x, y, r),
        Step::KeepDisc(x, y, r) => left || near(x, y, r),
        Step::Missing(..) | Step::Empty(..) => left,
    })
}
