//! Support, forbidden edges, and heights, on meshes small enough to count by hand; and tiles that share no vertices.

mod closing;
#[path = "../../lacuna-hole/tests/kit/mod.rs"]
mod kit;

use closing::{close, plan_rings};
use glam::{DVec2, DVec3};
use kit::{CELL_M, Scene, Step, block, cut, lattice, lattice_of, scatter};
use lacuna_close::{LayeredOptions, contour, project};
use lacuna_grid::{CellId, Grid};
use lacuna_hole::{BorderMode, CurveKind};
use lacuna_mesh::{find_crossings, signed_area};
use std::collections::BTreeMap;

/// The index of a lattice place in the only contour.
fn index_of(closing: &closing::Closing<'_>, x: f64, y: f64) -> u32 {
    let positions = closing.contours[0].contour.positions();
    let at = positions.iter().position(|p| p.truncate() == DVec2::new(x, y));
    at.unwrap_or_else(|| panic!("{x}, {y} is not on the contour")) as u32
}

#[test]
fn support_of_one_quad() {
    // Lattice diagonals: quads with an even sum of places run from south-west to north-east.
    let scene = lattice(1, 1, 0.0, &[cut(3.0, 3.0, 4.0, 4.0)]);
    let closing = close(&scene, 0.0);
    let contour = &closing.contours[0].contour;
    assert_eq!(contour.len(), 4);
    // Of the eight quads round it the four beside it bring both triangles. Of the four at its corners, with an even sum,
    // those in the south-west and north-east have their diagonal at the hole and bring two, the others one.
    assert_eq!(contour.support.triangles.len(), 8 + 2 + 2 + 1 + 1);
    // Of the twelve places round it, the two outer ones of the corner quads that bring one triangle are not reached.
    assert_eq!(contour.support.vertices.len(), 10);
    assert!(contour.forbidden_edges.is_empty());
}

#[test]
fn an_inner_edge_between_rim_vertices_is_forbidden() {
    // An L of three quads. The quad in its elbow has an odd sum: its diagonal joins two vertices of the rim.
    for (steps, from, to) in [
        ([cut(3.0, 2.0, 5.0, 3.0), cut(3.0, 2.0, 4.0, 4.0)], (5.0, 3.0), (4.0, 4.0)),
        ([cut(2.0, 2.0, 4.0, 3.0), cut(3.0, 2.0, 4.0, 4.0)], (2.0, 3.0), (3.0, 4.0)),
    ] {
        let scene = lattice(1, 1, 0.0, &steps);
        let closing = close(&scene, 0.0);
        let ends = [index_of(&closing, from.0, from.1), index_of(&closing, to.0, to.1)];
        let joined = has_edge(&scene, from, to);
        let expected: Vec<[u32; 2]> =
            if joined { vec![[ends[0].min(ends[1]), ends[0].max(ends[1])]] } else { vec![] };
        assert_eq!(closing.contours[0].contour.forbidden_edges, expected, "{from:?} {to:?}");
    }
    assert!(has_edge(&lattice(1, 1, 0.0, &[]), (5.0, 3.0), (4.0, 4.0)), "one of the cases has such an edge");
}

fn has_edge(scene: &Scene, a: (f64, f64), b: (f64, f64)) -> bool {
    let ends: Vec<DVec2> = vec![a.into(), b.into()];
    let mesh = &scene.tiles[&CellId::new(0, 0)];
    let joins = |t: usize| {
        let corners = mesh.corners(t).map(DVec3::truncate);
        ends.iter().all(|e| corners.contains(e))
    };
    (0..mesh.triangles.len()).any(joins)
}

#[test]
fn an_edge_of_the_neighbour_is_not_forbidden_but_supports() {
    let scene = lattice(2, 1, 0.0, &[cut(6.0, 2.0, 8.0, 4.0)]);
    let closing = close(&scene, 0.0);
    let contour = &closing.contours[0].contour;
    let mut places = contour.positions();
    places.extend(&contour.support.vertices);
    let beyond = contour.support.triangles.iter().filter(|t| t.iter().any(|&v| places[v as usize].x > 8.0));
    assert!(beyond.count() >= 4, "the neighbour's triangles at the adopted vertices");
}

#[test]
fn heights_of_a_strip_by_hand() {
    // A ditch runs north through both cells; the ground west of it lies at 2 m, east of it at 4 m. The border between the
    // cells crosses it: its curve leads from one height to the other.
    let place = |x: i32, y: i32| DVec3::new(f64::from(x), f64::from(y), if x <= 2 { 2.0 } else { 4.0 });
    let scene = lattice_of(1, 2, &[cut(2.0, 5.0, 6.0, 11.0)], &place);
    let closing = close(&scene, 0.0);
    closing.check("ditch");
    let curve = &closing.planned.plan.curves[0];
    assert_eq!((curve.low_m, curve.high_m, curve.line), (2.0, 6.0, 8.0));
    let heights: Vec<f64> = closing.curves.curves[0].inner.iter().map(|p| p.z).collect();
    assert_eq!(heights.len(), 3);
    assert!(heights.iter().all(|z| (2.0..=4.0).contains(z)), "{heights:?}");
    assert!(heights.windows(2).all(|w| w[0] <= w[1] + 1e-12), "{heights:?}");
}

/// Tiles that run 0.1 m past their cells, each with a lattice of its own, on a slope.
fn overrun(is_cut: impl Fn(CellId, f64, f64) -> bool) -> Scene {
    let margin_m = 0.1;
    let mut tiles = BTreeMap::new();
    for (i, j) in (0..3).flat_map(|j| (0..3).map(move |i| (i, j))) {
        let steps = |index: i32, count: i32, salt: u64| -> Vec<f64> {
            let low = f64::from(index) * CELL_M - margin_m;
            let high = f64::from(index + 1) * CELL_M + margin_m;
            let at = |k: i32| {
                let jitter = if k == 0 { 0.0 } else { 0.2 * scatter(k, index, salt) };
                low + (high - low) * (f64::from(k) + jitter) / f64::from(count)
            };
            (0..=count).map(|k| if k == count { high } else { at(k) }).collect()
        };
        let cell = CellId::new(i, j);
        let xs = steps(i, 14 + (i + j) % 3, 7 + j as u64);
        let ys = steps(j, 15 + (i + 2 * j) % 4, 70 + i as u64);
        let rows: Vec<(f64, f64)> = ys.iter().map(|&y| (y, 5.0 + 0.25 * y)).collect();
        let middle = |v: &[f64], k: usize| (v[k] + v[k + 1]) / 2.0;
        tiles.insert(cell, block(&xs, &rows, |c, r| !is_cut(cell, middle(&xs, c), middle(&ys, r))));
    }
    Scene::new(Grid { origin: DVec2::ZERO, cell_size_m: CELL_M }, tiles)
}

#[test]
fn overrunning_tiles_close_on_their_own_lines() {
    let disc = |x: f64, y: f64, cx: f64, cy: f64, r: f64| DVec2::new(x, y).distance(DVec2::new(cx, cy)) < r;
    let scenes = [
        ("across a border", overrun(|_, x, y| disc(x, y, 16.0, 12.0, 3.0)), 2),
        ("over a corner", overrun(|_, x, y| disc(x, y, 16.0, 16.0, 3.0)), 4),
        ("the neighbour covers", overrun(|c, x, y| c == CellId::new(1, 1) && disc(x, y, 16.0, 12.0, 3.0)), 1),
        ("hollow", overrun(|c, _, _| c == CellId::new(1, 1)), 1),
        ("at the area's edge", overrun(|_, x, y| disc(x, y, 24.0, 12.0, 3.0)), 1),
    ];
    for (name, scene, count) in scenes {
        let planned = scene.plan();
        assert_eq!(planned.plan.fit.mode, BorderMode::Overrun, "{name}");
        assert_eq!(planned.plan.holes.len(), count, "{name}: {:?}", kit::lines(&planned.plan));
        let options = LayeredOptions { growth: 0.0, spacing_m: None };
        let curves = project(&planned.surveys, &planned.plan, &|_| options);
        for hole in &planned.plan.holes {
            let made = contour(&planned.surveys, &planned.plan, hole, &curves, &|p| p);
            let made = made.unwrap_or_else(|e| panic!("{name}, {}: {e}", hole.cell)).contour;
            let rings = plan_rings(&made);
            assert!(signed_area(&rings[0]) > 0.0, "{name}, {}", hole.cell);
            let slices: Vec<&[DVec2]> = rings.iter().map(Vec::as_slice).collect();
            assert_eq!(find_crossings(&slices), [], "{name}, {}", hole.cell);
            let domain = &planned.plan.domains[&hole.cell];
            for p in made.positions() {
                let inside = p.truncate().cmpge(domain.low - 1e-9).all()
                    && p.truncate().cmple(domain.high + 1e-9).all();
                assert!(inside, "{name}, {}: {p}", hole.cell);
                // Along the plane 5 + y / 4, but where heights come from projected rims.
                assert!((p.z - 5.0 - 0.25 * p.y).abs() < 1.0, "{name}, {}: {p}", hole.cell);
            }
        }
        for (curve, made) in planned.plan.curves.iter().zip(&curves.curves) {
            let over = matches!(curve.kind, CurveKind::OverNeighbour(_));
            let off = made.inner.iter().map(|p| (p.z - 5.0 - 0.25 * p.y).abs()).fold(0.0, f64::max);
            assert!(!over || off < 1e-6, "{name}: a curve over the neighbour's surface lies {off} m off it");
        }
    }
}

#[test]
fn no_contour_where_nothing_is_known() {
    let scene = lattice(1, 1, 0.0, &[Step::Empty(0, 0)]);
    let planned = scene.plan();
    let options = LayeredOptions { growth: 0.0, spacing_m: None };
    let curves = project(&planned.surveys, &planned.plan, &|_| options);
    let made = contour(&planned.surveys, &planned.plan, &planned.plan.holes[0], &curves, &|p| p);
    assert!(made.is_err());
}
