//! What only looks like a hole is counted by kind and left alone.

mod kit;

use glam::{DVec2, DVec3};
use kit::{CELL_M, Scene, append, block, cut, lattice, lines, open_slit, sheet, tube};
use lacuna_grid::{CellId, Grid};
use lacuna_hole::{BorderMode, NotHole};
use lacuna_mesh::TriMesh;
use std::collections::BTreeMap;

fn count(scene: &Scene, what: NotHole) -> u32 {
    scene.plan().plan.not_holes.get(&what).copied().unwrap_or(0)
}

#[test]
fn debris_in_a_hole_is_no_island() {
    for (name, steps, expected) in [
        ("closed", cut(9.0, 9.0, 15.0, 15.0), "1,1 closed L1 #0 36"),
        ("open", cut(9.0, 9.0, 16.0, 15.0), "1,1 I-B L1 #0 42"),
        ("hollow", cut(8.0, 8.0, 16.0, 16.0), "1,1 I-A L1 #0 64"),
    ] {
        let mut scene = lattice(3, 3, 0.0, &[steps]);
        append(scene.tile(1, 1), sheet(DVec2::splat(11.1), DVec2::splat(11.9), 5.0, 1, 1));
        assert_eq!(lines(&scene.plan().plan), [expected], "{name}");
        assert_eq!(count(&scene, NotHole::Floater), 1, "{name}");
    }
}

#[test]
fn a_floater_above_ground() {
    for (name, z) in [("above", 30.0), ("below", -10.0)] {
        let mut scene = lattice(3, 3, 0.2, &[]);
        append(scene.tile(1, 1), sheet(DVec2::splat(10.1), DVec2::splat(14.3), z, 5, 5));
        assert!(lines(&scene.plan().plan).is_empty(), "{name}");
        assert_eq!(count(&scene, NotHole::Floater), 1, "{name}");
    }
}

#[test]
fn a_shaft_open_at_its_bottom() {
    let mut scene = lattice(3, 3, 0.0, &[cut(10.0, 10.0, 13.0, 12.0)]);
    let rim: Vec<DVec3> = {
        let planned = scene.plan();
        let survey = &planned.surveys[&CellId::new(1, 1)];
        let hole = survey.loops.iter().find(|l| l.vector_area.z > 0.0).unwrap();
        hole.edges.iter().map(|&e| survey.from(e)).collect()
    };
    append(scene.tile(1, 1), tube(&rim, 6.0));
    assert!(lines(&scene.plan().plan).is_empty());
    assert_eq!(count(&scene, NotHole::Passage), 1);
}

#[test]
fn a_slit_of_a_millimetre() {
    // Rows of a tile that were meant to meet at y = 11.
    for (name, jitter_m) in [("straight", 0.0), ("crooked", 0.3)] {
        let mut scene = lattice(3, 3, jitter_m, &[]);
        open_slit(scene.tile(1, 1), 0.001);
        let planned = scene.plan();
        assert_eq!(planned.surveys[&CellId::new(1, 1)].loops.len(), 2, "{name}: there is a slit");
        assert!(lines(&planned.plan).is_empty(), "{name}");
    }
}

#[test]
fn a_crack_of_a_decimetre_is_a_hole() {
    let mut scene = lattice(3, 3, 0.3, &[]);
    open_slit(scene.tile(1, 1), 0.1);
    let plan = scene.plan().plan;
    assert_eq!(plan.holes.len(), 1);
    assert_eq!(plan.holes[0].class.to_string(), "closed");
}

/// A sub-block of a tile: x and y from and to, columns and rows.
type Block = ([f64; 4], [usize; 2]);

/// One cell of sub-blocks that overlap, each with a lattice of its own, in a ring of full cells. Quads that `is_cut` names
/// by their block and their middle are left out.
fn with_blocks(blocks: &[Block], is_cut: impl Fn(usize, f64, f64) -> bool) -> Scene {
    let mut scene = lattice(3, 3, 0.0, &[]);
    let steps = |low: f64, high: f64, n: usize| -> Vec<f64> {
        (0..=n).map(|k| if k == n { high } else { low + (high - low) * k as f64 / n as f64 }).collect()
    };
    let mut mesh = TriMesh::default();
    for (b, &([x_low, x_high, y_low, y_high], [columns, rows])) in blocks.iter().enumerate() {
        let xs = steps(x_low, x_high, columns);
        let ys = steps(y_low, y_high, rows);
        let middle = |v: &[f64], k: usize| (v[k] + v[k + 1]) / 2.0;
        let keep = |c: usize, r: usize| !is_cut(b, middle(&xs, c), middle(&ys, r));
        let flat: Vec<(f64, f64)> = ys.iter().map(|&y| (y, 5.0)).collect();
        append(&mut mesh, block(&xs, &flat, keep));
    }
    *scene.tile(1, 1) = mesh;
    scene
}

/// Two sub-blocks that overlap by 0.1 m.
fn with_inner_cut(is_cut: impl Fn(f64, f64) -> bool) -> Scene {
    let blocks = [([8.0, 12.05, 8.0, 16.0], [5, 8]), ([11.95, 16.0, 8.0, 16.0], [4, 11])];
    with_blocks(&blocks, |_, x, y| is_cut(x, y))
}

#[test]
fn a_cut_inside_a_tile_is_no_hole() {
    let planned = with_inner_cut(|_, _| false).plan();
    assert_eq!(planned.plan.fit.mode, BorderMode::Exact);
    assert!(lines(&planned.plan).is_empty(), "{:?}", lines(&planned.plan));
}

#[test]
fn a_hole_across_a_cut_inside_a_tile() {
    let planned = with_inner_cut(|x, y| (x - 12.0).abs() < 2.2 && (y - 12.0).abs() < 2.2).plan();
    let found = lines(&planned.plan);
    assert_eq!(planned.plan.holes.len(), 1, "{found:?}");
    assert_eq!(planned.plan.holes[0].class.to_string(), "closed");
    assert!((14.0..21.0).contains(&planned.plan.holes[0].area_m2), "{found:?}");
}

#[test]
fn a_hole_beside_a_cut_inside_a_tile() {
    let planned = with_inner_cut(|x, y| (9.0..11.0).contains(&x) && (y - 12.0).abs() < 1.2).plan();
    assert_eq!(planned.plan.holes.len(), 1, "{:?}", lines(&planned.plan));
    assert_eq!(planned.plan.holes[0].class.to_string(), "closed");
}

#[test]
fn a_hole_across_a_cut_that_reaches_the_border() {
    let planned = with_inner_cut(|x, y| (x - 12.0).abs() < 2.2 && y > 12.0).plan();
    let found = lines(&planned.plan);
    assert_eq!(planned.plan.holes.len(), 1, "{found:?}");
    assert_eq!(planned.plan.holes[0].class.to_string(), "I-B", "{found:?}");
}

#[test]
fn a_hole_where_staggered_cuts_meet() {
    // The cut along x is lower on the left than on the right; the upper left block is whole, and its corner stands beside
    // the hole. Long edges beside short ones: the rims end far from each other.
    let blocks = [
        ([8.0, 12.05, 8.0, 11.55], [5, 4]),
        ([8.0, 12.05, 11.45, 16.0], [6, 2]),
        ([11.95, 16.0, 8.0, 12.55], [8, 9]),
        ([11.95, 16.0, 12.45, 16.0], [5, 7]),
    ];
    let in_hole = |x: f64, y: f64| (10.3..13.3).contains(&x) && (9.4..13.7).contains(&y);
    let planned = with_blocks(&blocks, |b, x, y| b != 1 && in_hole(x, y)).plan();
    let found = lines(&planned.plan);
    assert_eq!(planned.plan.holes.len(), 1, "{found:?}");
    assert_eq!(planned.plan.holes[0].class.to_string(), "closed");
    assert!((8.0..11.0).contains(&planned.plan.holes[0].area_m2), "{found:?}");
}

#[test]
fn a_fragment_beside_a_straight_rim_is_no_cut() {
    // A hole whose rim runs along axes; fragments with edges of their own a decimetre beside it.
    for (name, low, size_m, quads, rise_m, expected) in [
        ("one side, an island", (9.1, 10.5), 3.0, 3, 0.0, "1,1 closed L1 #0 27 +1"),
        ("one side, higher", (9.1, 10.5), 3.0, 3, 0.3, "1,1 closed L1 #0 27 +1"),
        ("one side, debris", (9.1, 10.5), 1.8, 4, 0.0, "1,1 closed L1 #0 36"),
        ("in the corner, an island", (9.1, 9.1), 3.0, 3, 0.0, "1,1 closed L1 #0 27 +1"),
        ("in the corner, debris", (9.1, 9.1), 1.8, 4, 0.0, "1,1 closed L1 #0 36"),
    ] {
        let mut scene = kit::lattice_of(3, 3, &[cut(9.0, 9.0, 15.0, 15.0)], &|x, y| {
            DVec3::new(f64::from(x), f64::from(y), 5.0)
        });
        let low = DVec2::from(low);
        append(scene.tile(1, 1), sheet(low, low + size_m, 5.0 + rise_m, quads, quads));
        assert_eq!(lines(&scene.plan().plan), [expected], "{name}");
    }
}

#[test]
fn a_balcony_over_the_border() {
    // A sheet above the ground that ends on the border: its outline opens nothing.
    let mut scene = lattice(3, 3, 0.2, &[]);
    append(scene.tile(1, 1), sheet(DVec2::new(13.0, 10.0), DVec2::new(16.0, 14.0), 12.0, 4, 4));
    let plan = scene.plan().plan;
    assert!(lines(&plan).is_empty(), "{:?}", lines(&plan));
    assert_eq!(plan.not_holes.get(&NotHole::Overhang), Some(&1));
}

#[test]
fn a_bridge_over_the_border_of_two_cells() {
    let mut scene = lattice(3, 3, 0.2, &[]);
    append(scene.tile(1, 1), sheet(DVec2::new(13.0, 10.0), DVec2::new(16.0, 14.0), 12.0, 4, 4));
    append(scene.tile(2, 1), sheet(DVec2::new(16.0, 10.0), DVec2::new(19.0, 14.0), 12.0, 4, 4));
    let plan = scene.plan().plan;
    assert!(lines(&plan).is_empty(), "{:?}", lines(&plan));
}

#[test]
fn a_bridge_over_a_lake_across_the_border() {
    let mut scene = lattice(3, 3, 0.2, &[cut(12.0, 9.0, 20.0, 15.0)]);
    append(scene.tile(1, 1), sheet(DVec2::new(13.0, 11.0), DVec2::new(16.0, 13.0), 12.0, 6, 4));
    append(scene.tile(2, 1), sheet(DVec2::new(16.0, 11.0), DVec2::new(19.0, 13.0), 12.0, 6, 4));
    let plan = scene.plan().plan;
    // Seen from above the bridge parts the lake's stretch of the border: as an island on it would.
    assert_eq!(plan.clusters.len(), 1, "{:?}", lines(&plan));
    assert_eq!(plan.unclear_stretches, 0);
}

#[test]
fn broken_input_is_no_panic() {
    let corner = |x: f64, y: f64| DVec3::new(x, y, 1.0);
    let odd = TriMesh {
        positions: vec![
            corner(0.0, 0.0),
            corner(8.0, 0.0),
            corner(8.0, 8.0),
            DVec3::NAN,
            DVec3::INFINITY,
            corner(0.0, 8.0),
        ],
        triangles: vec![
            [0, 1, 2],
            [0, 2, 3],
            [0, 4, 5],
            [1, 1, 2],
            [0, 1, 2],
            [2, 1, 0],
            [5, 2, 0],
            [0, 1, 5],
        ],
    };
    let grid = Grid { origin: DVec2::ZERO, cell_size_m: CELL_M };
    for k in 0..odd.triangles.len() {
        let mesh = TriMesh { triangles: odd.triangles[k..].to_vec(), ..odd.clone() };
        let scene = Scene::new(grid, BTreeMap::from([(CellId::new(0, 0), mesh)]));
        let plan = scene.plan().plan;
        assert!(plan.holes.iter().all(|h| h.area_m2.is_finite()));
    }
    let nothing = Scene::new(grid, BTreeMap::new());
    assert!(nothing.plan().plan.holes.is_empty());
}
