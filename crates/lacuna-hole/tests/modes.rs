//! Scenes whose tiles overrun their cells, or are cut along triangles.

mod kit;

use glam::DVec2;
use kit::{CELL_M, Motion, Scene, assert_same, block, lines, scatter, signature};
use lacuna_grid::{CellId, Grid};
use lacuna_hole::{Anchor, BorderMode, CurveKind, HoleClass, Span};
use lacuna_mesh::TriMesh;
use std::collections::BTreeMap;

/// Three by three tiles that each run `margin_m` past their cell on all sides, each with a lattice of its own. Quads
/// that `is_cut` names by their middle are left out.
fn overrun(margin_m: f64, is_cut: impl Fn(f64, f64) -> bool) -> Scene {
    let mut tiles = BTreeMap::new();
    for (i, j) in (0..3).flat_map(|j| (0..3).map(move |i| (i, j))) {
        let steps = |index: i32, count: i32, salt: u64| -> Vec<f64> {
            let (low, high) =
                (f64::from(index) * CELL_M - margin_m, f64::from(index + 1) * CELL_M + margin_m);
            let at = |k: i32| {
                let jitter = if k == 0 || k == count { 0.0 } else { 0.2 * scatter(k, index, salt) };
                low + (high - low) * (f64::from(k) + jitter) / f64::from(count)
            };
            (0..=count).map(|k| if k == count { high } else { at(k) }).collect()
        };
        let xs = steps(i, 14 + (i + j) % 3, 7 + j as u64);
        let ys = steps(j, 15 + (i + 2 * j) % 4, 70 + i as u64);
        let rows: Vec<(f64, f64)> = ys.iter().map(|&y| (y, 5.0 + 0.1 * y)).collect();
        let middle = |v: &[f64], k: usize| (v[k] + v[k + 1]) / 2.0;
        let mesh = block(&xs, &rows, |c, r| !is_cut(middle(&xs, c), middle(&ys, r)));
        tiles.insert(CellId::new(i, j), mesh);
    }
    Scene::new(Grid { origin: DVec2::ZERO, cell_size_m: CELL_M }, tiles)
}

/// Three by three tiles of one lattice that ignores the cells: each triangle goes to the cell of its middle. Jitter is in
/// edges; without it the tiles would all end on lines.
fn ragged(jitter_m: f64, is_cut: impl Fn(f64, f64) -> bool) -> Scene {
    let step = 0.1; // a cell has 80 edges along a side: the tolerance is tied to both
    let count = (3.0 * CELL_M / step) as i32 + 1;
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
            let middle = ((places[0] + places[1] + places[2]) / 3.0).truncate();
            let cell = grid.cell_at(middle);
            let inside = (0..3).contains(&cell.i) && (0..3).contains(&cell.j);
            // By lattice places, so that jitter leaves no triangle alone at the rim.
            let sum = corners.iter().fold((0, 0), |s, c| (s.0 + c.0, s.1 + c.1));
            let plain = [sum.0, sum.1].map(|g| step * f64::from(g) / 3.0 - 0.03);
            if inside && !is_cut(plain[0], plain[1]) {
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

fn in_disc(x: f64, y: f64, centre: (f64, f64), radius: f64) -> bool {
    DVec2::new(x, y).distance(centre.into()) < radius
}

#[test]
fn overrun_is_measured_and_opens_nothing() {
    for margin_m in [0.01, 0.05, 0.1, 0.15] {
        let plan = overrun(margin_m, |_, _| false).plan().plan;
        assert_eq!(plan.fit.mode, BorderMode::Overrun, "{margin_m}");
        assert!((plan.fit.margin_m - margin_m).abs() < 1e-3, "{margin_m}: {:?}", plan.fit);
        assert!(plan.holes.is_empty(), "{margin_m}: {:?}", lines(&plan));
    }
}

#[test]
fn overrun_and_a_hole_across_a_border() {
    for margin_m in [0.05, 0.1] {
        let plan = overrun(margin_m, |x, y| in_disc(x, y, (16.0, 12.0), 3.0)).plan().plan;
        let classes: Vec<String> = plan.holes.iter().map(|h| h.class.to_string()).collect();
        assert_eq!(classes, ["I-B", "I-B"], "{margin_m}: {:?}", lines(&plan));
        assert_eq!(plan.clusters.len(), 1);
        assert_eq!(plan.holes.iter().map(|h| h.leave).collect::<Vec<_>>(), [None, None]);
        let shared = plan.curves.iter().filter(|c| c.kind == CurveKind::Shared).count();
        assert_eq!(shared, 1, "{margin_m}: {:?}", plan.curves);
        let expected = std::f64::consts::PI * 9.0;
        // Both tiles count the strip of the overlap, and a rim of quads is not round.
        assert!((plan.clusters[0].area_m2 - expected).abs() < 6.0, "{:?}", lines(&plan));
    }
}

#[test]
fn overrun_and_holes_inside_and_at_the_edge() {
    let plan =
        overrun(0.1, |x, y| in_disc(x, y, (12.0, 12.0), 2.0) || in_disc(x, y, (24.0, 4.0), 2.0)).plan().plan;
    let classes: Vec<HoleClass> = plan.holes.iter().map(|h| h.class).collect();
    assert_eq!(plan.clusters.len(), 2, "{:?}", lines(&plan));
    assert!(classes.contains(&HoleClass::Closed) && plan.clusters.iter().any(|c| c.is_external));
}

#[test]
fn overrun_and_a_hole_over_a_corner() {
    let plan = overrun(0.1, |x, y| in_disc(x, y, (16.0, 16.0), 3.0)).plan().plan;
    let classes: Vec<String> = plan.holes.iter().map(|h| h.class.to_string()).collect();
    assert_eq!(classes, ["I-B"; 4], "{:?}", lines(&plan));
    assert_eq!(plan.clusters.len(), 1);
    assert!(plan.clusters[0].leave.is_none());
    let corners =
        plan.curves.iter().flat_map(|c| [c.low, c.high]).filter(|a| matches!(a, Anchor::Corner(_))).count();
    assert_eq!(corners, 4);
}

#[test]
fn overrun_and_a_hole_that_the_neighbour_covers() {
    // Only the west tile lacks the surface.
    let mut scene = overrun(0.1, |_, _| false);
    let cut = overrun(0.1, |x, y| x > 13.0 && x < 17.0 && (y - 12.0).abs() < 2.0);
    let west = CellId::new(1, 1);
    scene.tiles.insert(west, cut.tiles[&west].clone());
    let plan = scene.plan().plan;
    assert_eq!(plan.holes.len(), 1, "{:?}", lines(&plan));
    assert_eq!(plan.holes[0].class.to_string(), "I-B");
    assert_eq!(plan.holes[0].leave, None);
    let kinds: Vec<CurveKind> = plan.curves.iter().map(|c| c.kind).collect();
    assert_eq!(kinds, [CurveKind::OverNeighbour(CellId::new(2, 1))]);
    assert!(!plan.curves[0].over.is_empty());
}

#[test]
fn overrun_and_a_hollow_cell() {
    let mut scene = overrun(0.1, |_, _| false);
    scene.tiles.remove(&CellId::new(1, 1));
    let plan = scene.plan().plan;
    assert_eq!(plan.holes.len(), 1, "{:?}", lines(&plan));
    assert_eq!((plan.holes[0].class.to_string(), plan.holes[0].layer), ("I-A".to_owned(), 1));
    assert_eq!(plan.holes[0].leave, None);
    assert_eq!(plan.clusters[0].leave, None, "the neighbours' surface lies under the whole outline");
}

#[test]
fn overrun_whatever_the_frame() {
    let scene = overrun(0.1, |x, y| in_disc(x, y, (16.0, 12.0), 3.0) || in_disc(x, y, (4.0, 20.0), 2.0));
    for motions in [
        vec![Motion::Turn],
        vec![Motion::Mirror],
        vec![Motion::Shift(5e5, 5e5)],
        vec![Motion::Renumber(-7, 3)],
        vec![Motion::ShuffleTriangles, Motion::ShuffleVertices],
    ] {
        let expected = signature(&scene.plan(), |cell| motions.iter().fold(cell, |c, m| m.cell(c)));
        let moved = motions.iter().fold(scene.clone(), |s, m| m.of(&s));
        assert_same(&expected, &signature(&moved.plan(), |c| c), &format!("{motions:?}"));
    }
}

#[test]
fn ragged_borders_open_nothing() {
    for jitter_m in [0.1, 0.2, 0.3] {
        let plan = ragged(jitter_m, |_, _| false).plan().plan;
        assert_eq!(plan.fit.mode, BorderMode::Ragged, "{jitter_m}: {:?}", plan.fit);
        assert!(plan.holes.is_empty(), "{jitter_m}: {:?}", lines(&plan));
    }
}

#[test]
fn ragged_borders_and_a_hole_across_one() {
    for jitter_m in [0.1, 0.2, 0.3] {
        let plan = ragged(jitter_m, |x, y| in_disc(x, y, (16.0, 12.0), 2.7)).plan().plan;
        let classes: Vec<String> = plan.holes.iter().map(|h| h.class.to_string()).collect();
        assert_eq!(classes, ["I-B", "I-B"], "{jitter_m}: {:?}", lines(&plan));
        assert_eq!(plan.clusters.len(), 1, "{jitter_m}");
        let area = std::f64::consts::PI * 2.7 * 2.7;
        assert!((plan.clusters[0].area_m2 / area - 1.0).abs() < 0.15, "{jitter_m}: {:?}", lines(&plan));
    }
}

#[test]
fn ragged_borders_and_other_holes() {
    for jitter_m in [0.15, 0.3] {
        let is_cut = |x: f64, y: f64| {
            in_disc(x, y, (4.0, 4.0), 1.5)
                || in_disc(x, y, (16.0, 16.0), 3.0)
                || x > 21.5 && (y - 5.0).abs() < 2.0
        };
        let plan = ragged(jitter_m, is_cut).plan().plan;
        let mut found: Vec<String> =
            plan.holes.iter().map(|h| format!("{},{} {}", h.cell.i, h.cell.j, h.class)).collect();
        found.sort();
        let expected = ["0,0 closed", "1,1 I-B", "1,2 I-B", "2,0 II-B", "2,1 I-B", "2,2 I-B"];
        assert_eq!(found, expected, "{jitter_m}: {:?}", lines(&plan));
        assert_eq!(plan.clusters.len(), 3, "{jitter_m}: {:?}", lines(&plan));
    }
}

#[test]
fn ragged_borders_adopt_the_neighbours_edges() {
    let full = ragged(0.2, |_, _| false);
    let mut scene = full.clone();
    let west = CellId::new(1, 1);
    let cut = ragged(0.2, |x, y| x > 12.5 && (y - 12.0).abs() < 2.0);
    scene.tiles.insert(west, cut.tiles[&west].clone());
    let plan = scene.plan().plan;
    assert_eq!(plan.holes.len(), 1, "{:?}", lines(&plan));
    let adopted: usize = plan.holes[0]
        .outer
        .iter()
        .filter_map(|p| match p {
            lacuna_hole::Piece::Side { spans, .. } => Some(spans),
            _ => None,
        })
        .flatten()
        .map(|s| if let Span::Adopted { edges, .. } = s { edges.len() } else { 0 })
        .sum();
    // Four metres of a border whose edges are about 0.1 m long and zigzag.
    assert!((36..120).contains(&adopted), "{adopted}");
    assert_eq!(plan.holes[0].leave, None);
}

#[test]
fn small_holes_beside_the_borders_do_not_make_an_exact_tile_ragged() {
    // Of the second row of quads from each side every other one is out: half of what runs along a side is far rim.
    let count = 80;
    let tile = |i: i32| {
        let step = |k: i32| CELL_M * f64::from(k) / f64::from(count);
        let xs: Vec<f64> = (0..=count).map(|k| f64::from(i) * CELL_M + step(k)).collect();
        let rows: Vec<(f64, f64)> = (0..=count).map(|k| (step(k), 5.0)).collect();
        let is_second = |k: usize| k == 1 || k == count as usize - 2;
        block(&xs, &rows, |c, r| !((is_second(c) || is_second(r)) && (c + r) % 2 == 0))
    };
    let tiles = (0..2).map(|i| (CellId::new(i, 0), tile(i))).collect();
    let plan = Scene::new(Grid { origin: DVec2::ZERO, cell_size_m: CELL_M }, tiles).plan().plan;
    assert_eq!(plan.fit.mode, BorderMode::Exact, "{:?}", plan.fit);
    assert!(plan.holes.iter().any(|h| h.class == HoleClass::Closed));
}
