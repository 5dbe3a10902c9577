//! Contours of tiles that are cut along triangles.

mod closing;
#[path = "../../lacuna-hole/tests/kit/mod.rs"]
mod kit;

use closing::{close, plan_rings};
use glam::DVec2;
use kit::{CELL_M, Scene, scatter};
use lacuna_grid::{CellId, Grid};
use lacuna_hole::{BorderMode, Piece};
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
            check_cracks(&closing, &what);
        }
    }
}

/// Only at the ends of rims may a crack of a few triangles stay: there an edge that is near to the border counts as on
/// it, so that both tiles' rims end at different vertices.
fn check_cracks(closing: &closing::Closing<'_>, what: &str) {
    let plan = &closing.planned.plan;
    let mut ends = Vec::new();
    for hole in &plan.holes {
        for piece in &hole.outer {
            if let Piece::Rim(edges) = piece {
                let survey = &closing.planned.surveys[&hole.cell];
                ends.extend([survey.from(edges[0]), survey.to(edges[edges.len() - 1])]);
            }
        }
    }
    let open = closing.open_edges();
    assert!(open.len() <= 8 * ends.len(), "{what}: {} open edges", open.len());
    for p in open.iter().flatten() {
        let nearest = ends.iter().map(|e| e.distance(*p)).fold(f64::INFINITY, f64::min);
        assert!(nearest <= plan.fit.absorb_m, "{what}: a crack {nearest} m from any end, at {p}");
    }
}
