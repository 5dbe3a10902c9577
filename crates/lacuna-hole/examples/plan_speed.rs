//! Prints how fast tiles with many holes are surveyed and planned, and a digest of each plan: a change that should only be
//! faster leaves it as it was.
//!
//! `cargo run --release -p lacuna-hole --example plan_speed [holes]`
#![allow(clippy::print_stdout)] // it is what an example is for

use glam::{DVec2, DVec3};
use lacuna_grid::{Area, CellId, Grid};
use lacuna_hole::{ClusterRule, PlanOptions, Surveys, fit_borders, plan, survey};
use lacuna_mesh::TriMesh;
use std::collections::BTreeSet;
use std::time::Instant;

/// Quads from one hole to the next.
const PERIOD: usize = 8;

/// Where tiles have surface.
struct Pattern {
    name: &'static str,
    /// How far vertices move in the quad, in quads.
    jitter: f64,
    /// True where surface is left, by column and row in a period of holes; the tile has `count` periods a side.
    is_left: fn(x: usize, y: usize, count: usize) -> bool,
    /// Cells in a row.
    cells: i32,
}

fn main() {
    let holes: f64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(1e4);
    let patterns = [
        Pattern {
            name: "closed holes on a raster",
            jitter: 0.0,
            is_left: |x, y, _| !(holds(x, 3, 5) && holds(y, 3, 5)),
            cells: 1,
        },
        Pattern {
            name: "closed holes",
            jitter: 0.2,
            is_left: |x, y, _| !(holds(x, 3, 5) && holds(y, 3, 5)),
            cells: 1,
        },
        Pattern {
            name: "holes with islands",
            jitter: 0.2,
            is_left: |x, y, _| !(holds(x, 1, 7) && holds(y, 1, 7)) || (holds(x, 3, 5) && holds(y, 3, 5)),
            cells: 1,
        },
        Pattern {
            name: "bays along the border of two cells",
            jitter: 0.2,
            is_left: |x, y, count| {
                let near = x < 3 || x + 3 >= count * PERIOD;
                !(near && holds(y, 3, 6))
            },
            cells: 2,
        },
    ];
    for pattern in &patterns {
        report(pattern, holes);
    }
}

fn holds(x: usize, low: usize, high: usize) -> bool {
    (low..high).contains(&(x % PERIOD))
}

fn report(pattern: &Pattern, holes: f64) {
    let count = (holes / f64::from(pattern.cells)).sqrt().round().max(1.0) as usize;
    let size_m = (count * PERIOD) as f64;
    let grid = Grid { origin: DVec2::ZERO, cell_size_m: size_m };
    let cells: Vec<CellId> = (0..pattern.cells).map(|i| CellId::new(i, 0)).collect();
    let tiles: Vec<TriMesh> = cells.iter().map(|&c| tile(pattern, count, c)).collect();
    let start = Instant::now();
    let surveys: Surveys = cells.iter().zip(&tiles).map(|(&c, mesh)| (c, survey(c, mesh))).collect();
    let surveyed = start.elapsed();
    let fit = fit_borders(&surveys, &grid);
    let options = PlanOptions {
        grid,
        area: Area::of_cells(&cells.into_iter().collect()),
        fit,
        rule: ClusterRule::Interval,
        unreadable: BTreeSet::new(),
    };
    let start = Instant::now();
    let plan = plan(&surveys, &options);
    println!(
        "{}: {} holes; survey {:.2} s, plan {:.2} s; digest {:016x}",
        pattern.name,
        plan.holes.len(),
        surveyed.as_secs_f64(),
        start.elapsed().as_secs_f64(),
        digest(&format!("{plan:?}")),
    );
}

/// FNV-1a.
fn digest(text: &str) -> u64 {
    text.bytes().fold(0xCBF2_9CE4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01B3))
}

fn tile(pattern: &Pattern, count: usize, cell: CellId) -> TriMesh {
    let side = count * PERIOD;
    let mut mesh = TriMesh::default();
    let mut numbers = vec![u32::MAX; (side + 1) * (side + 1)];
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        if !(pattern.is_left)(x, y, count) {
            continue;
        }
        let [a, b, c, d] = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|corner| {
            let number = &mut numbers[corner.1 * (side + 1) + corner.0];
            if *number == u32::MAX {
                *number = mesh.positions.len() as u32;
                mesh.positions.push(place(pattern.jitter, cell, corner, side));
            }
            *number
        });
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

fn place(jitter: f64, cell: CellId, (x, y): (usize, usize), side: usize) -> DVec3 {
    let inside = |k: usize| if (1..side).contains(&k) { jitter } else { 0.0 };
    let moved_x = x as f64 + inside(x) * scatter(x, y);
    let moved_y = y as f64 + inside(y) * scatter(y, x);
    DVec3::new(moved_x + f64::from(cell.i) * side as f64, moved_y, 0.01 * moved_y)
}

/// A number in [-1, 1) that looks random, the same on every machine.
fn scatter(x: usize, y: usize) -> f64 {
    let mixed = (x as u64 * 0x9E37_79B9 + y as u64 * 0x85EB_CA6B + 1).wrapping_mul(0x2545_F491_4F6C_DD1D);
    (mixed >> 40) as f64 / f64::from(1 << 23) - 1.0
}
