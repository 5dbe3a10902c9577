//! Contours of tiles that are cut along triangles.

mod closing;
#[path = "../../lacuna-hole/tests/kit/mod.rs"]
mod kit;

use closing::{close, plan_rings};
use glam::DVec2;
use kit::{CELL_M, Scene, scatter};
use lacuna_grid::{CellId, Grid};
use lacuna_hole::BorderMode;
use lacuna_mesh::{TriMesh, find_crossings, signed_area};
use std::collections::BTreeMap;

/// Two by two tiles of one jittered lattice that ignores the cells: each triangle goes to the cell of its middle.
/// Triangles that `is_cut` names by their cell and lattice middle are left out.
fn ragged(jitter_m: f64, is_cut: impl Fn(CellId, f64, f64) -> bool) -> Scene {
    let step = 0.1;
    let count = (2.0 * CELL_M / step) as i32 + 1;
    let place = |x: i32, y: i32| {
        let moved = |g: i32, salt: u64| step * (f64::from(g) + jitter_m * scatter(x, y, salt)) - 0.03;
        let p = DVec2::new(moved(x, 1), moved(y, 2));
        p.extend(4.0 + 0.05 * p.x)
    };
    let grid = Grid { origin: DVec2::ZERO, cell_size_m: CELL_M };
    let mut tiles: BTreeMap<CellId, (TriMesh, BTreeMap<(i32, i32), u32>)> = BTreeMap::new();
    for (x, y) in (0..count).flat_map(|y| (0..count).map(move |x| (x, y))) {
        let [a, b, c, d] = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        for corners in [[a, b, c], [a, c, d]] {
            let places = corners.map(|(x, y)| place(x, y));
            let cell = grid.cell_at(((places[0] + places[1] + places[2]) / 3.0).truncate());
            let sum = corners.iter().fold((0, 0), |s, c| (s.0 + c.0, s.1 + c.1));
            let plain = [sum.0, sum.1].map(|g| step * f64::from(g) / 3.0 - 0.03);
            let inside = (0..2).contains(&cell.i) && (0..2).contains(&cell.j);
            if inside && !is_cut(cell, plain[0], plain[1]) {
                let (mesh, numbers) = tiles.entry(cell).or_default();
                let triangle = std::array::from_fn(|k| {
                    *numbers.entry(corners[k]).or_insert_with(|| {
                        mesh.positions.push(places[k]);
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.triangles.push(triangle);
            }
        }
    }
    Scene::new(grid, tiles.into_iter().map(|(c, t)| (c, t.0)).collect())
}

#[test]
fn ragged_tiles_close() {
    let disc = |x: f64, y: f64, cx: f64, cy: f64| DVec2::new(x, y).distance(DVec2::new(cx, cy)) < 2.2;
    for jitter_m in [0.15, 0.3] {
        let scenes = [
            ("across a border", ragged(jitter_m, |_, x, y| disc(x, y, 8.0, 4.0)), 2),
            ("over a corner", ragged(jitter_m, |_, x, y| disc(x, y, 8.0, 8.0)), 4),
            (
                "the neighbour covers",
                ragged(jitter_m, |c, x, y| c == CellId::new(0, 0) && disc(x, y, 8.0, 4.0)),
                1,
            ),
        ];
        for (name, scene, count) in scenes {
            let what = format!("{name}, jitter {jitter_m}");
            let closing = close(&scene, 0.0);
            let plan = &closing.planned.plan;
            assert_eq!(plan.fit.mode, BorderMode::Ragged, "{what}");
            assert_eq!(plan.holes.len(), count, "{what}: {:?}", kit::lines(plan));
            for (hole, made) in plan.holes.iter().zip(&closing.contours) {
                let rings = plan_rings(&made.contour);
                assert!(signed_area(&rings[0]) > 0.0, "{what}, {}", hole.cell);
                let slices: Vec<&[DVec2]> = rings.iter().map(Vec::as_slice).collect();
                assert_eq!(find_crossings(&slices), [], "{what}, {}", hole.cell);
            }
            check_closed(&closing, &what);
        }
    }
}

/// No edge stays open.
fn check_closed(closing: &closing::Closing<'_>, what: &str) {
    let open = closing.open_edges();
    assert!(open.is_empty(), "{what}: {} open edges, such as {:?}", open.len(), open.first());
}

#[test]
fn rims_that_run_along_the_border_close() {
    let scenes: [(&str, fn(f64, f64) -> bool); 4] = [
        ("a river along the border", |x, y| {
            (y - 8.0 - 0.3 * (2.0 * x).sin()).abs() < 0.4 && (x - 8.0).abs() < 6.0
        }),
        ("a shore on the border", |x, y| y > 8.0 && y < 11.0 && (x - 8.0).abs() < 5.0),
        ("a spit over the border", |x, y| {
            DVec2::new(x, y).distance(DVec2::new(8.0, 4.0)) < 3.0 && !((y - 4.0).abs() < 0.25 && x < 8.2)
        }),
        ("a small one on the corner", |x, y| DVec2::new(x, y).distance(DVec2::new(8.05, 7.95)) < 0.5),
    ];
    for jitter_m in [0.15, 0.3, 0.45] {
        for (name, is_cut) in scenes {
            let what = format!("{name}, jitter {jitter_m}");
            let scene = ragged(jitter_m, |_, x, y| is_cut(x, y));
            let closing = close(&scene, 0.0);
            let plan = &closing.planned.plan;
            assert!(plan.holes.iter().all(|h| h.leave.is_none()), "{what}: {:?}", kit::lines(plan));
            check_closed(&closing, &what);
        }
    }
}

#[test]
fn strips_belong_to_the_cell_that_comes_first() {
    for jitter_m in [0.15, 0.3] {
        let scene = ragged(jitter_m, |_, x, y| (y - 8.0).abs() < 0.1 && (x - 4.0).abs() < 2.0);
        let closing = close(&scene, 0.0);
        let plan = &closing.planned.plan;
        assert!(!plan.holes.is_empty() && plan.curves.is_empty(), "{jitter_m}: {:?}", kit::lines(plan));
        assert!(plan.holes.iter().all(|h| h.cell == CellId::new(0, 0)), "{jitter_m}: {:?}", kit::lines(plan));
        check_closed(&closing, &format!("jitter {jitter_m}"));
    }
}
