//! Loops: simple, complete, the same however the mesh is written; bow-ties and pinched holes fall apart as they should.

mod common;

use common::{grid, grid_with_holes, mesh, moved, rewritings};
use glam::DVec3;
use lacuna_mesh::{Boundary, BoundaryLoops, PointId, TriMesh, boundary, loops, position_bits, signed_area};
use proptest::prelude::*;

fn check(boundary: &Boundary, found: &BoundaryLoops) {
    assert_eq!((found.open_edges, found.cracks), (0, 0));
    let mut used: Vec<u32> = found.loops.iter().flat_map(|l| l.edges.clone()).collect();
    used.sort_unstable();
    assert!(used.iter().copied().eq(0..boundary.edges.len() as u32), "every edge exactly once");
    for walk in &found.loops {
        for (i, &edge) in walk.edges.iter().enumerate() {
            let next = walk.edges[(i + 1) % walk.edges.len()];
            assert_eq!(boundary.edges[edge as usize].to, boundary.edges[next as usize].from, "consecutive");
        }
        let mut points: Vec<PointId> = walk.points(boundary).collect();
        assert!(points.iter().all(|p| *p >= points[0]), "starts at its smallest point");
        points.sort_unstable();
        points.dedup();
        assert_eq!(points.len(), walk.edges.len(), "no point twice");
    }
    assert!(found.loops.is_sorted_by(|a, b| a.edges < b.edges));
}

fn loops_of(mesh: &TriMesh) -> (Boundary, BoundaryLoops) {
    let boundary = boundary(mesh);
    let found = loops(&boundary);
    check(&boundary, &found);
    (boundary, found)
}

/// Signed plan areas in quads, in loop order.
fn areas(mesh: &TriMesh) -> Vec<f64> {
    let (boundary, found) = loops_of(mesh);
    let ring = |l: &lacuna_mesh::BoundaryLoop| {
        l.positions(&boundary).iter().map(|p| p.truncate()).collect::<Vec<_>>()
    };
    found.loops.iter().map(|l| signed_area(&ring(l)) * 16.0).collect()
}

/// Loops as sorted lists of positions, each list starting at its smallest.
fn canonical(mesh: &TriMesh) -> Vec<Vec<[u64; 3]>> {
    let (boundary, found) = loops_of(mesh);
    let mut all: Vec<Vec<[u64; 3]>> = Vec::new();
    for walk in &found.loops {
        let mut places: Vec<_> = walk.positions(&boundary).into_iter().map(position_bits).collect();
        let first = (0..places.len()).min_by_key(|&i| places[i]).unwrap();
        places.rotate_left(first);
        all.push(places);
    }
    all.sort();
    all
}

#[test]
fn holes_run_counter_clockwise_and_the_outline_clockwise() {
    assert_eq!(areas(&grid_with_holes()), [-320.0, 1.0, 6.0, 12.0, 1.0, 1.0]);
}

#[test]
fn holes_that_touch_in_a_point_stay_two() {
    for (name, is_hole) in [
        ("rising", (|x, y| (x, y) == (2, 2) || (x, y) == (3, 3)) as fn(u32, u32) -> bool),
        ("falling", |x, y| (x, y) == (3, 2) || (x, y) == (2, 3)),
    ] {
        assert_eq!(areas(&grid(6, 6, is_hole)), [-36.0, 1.0, 1.0], "{name}");
    }
}

#[test]
fn pieces_that_touch_in_a_point_stay_two() {
    // Two quads meet in one point: the outline falls into two.
    assert_eq!(areas(&grid(2, 2, |x, y| x != y)), [-1.0, -1.0]);
}

#[test]
fn a_hole_pinched_by_two_pieces_falls_into_simple_loops() {
    // A ring of eight missing quads round one that touches nothing: outline, hole, island.
    let ring = areas(&grid(5, 5, |x, y| (1..4).contains(&x) && (1..4).contains(&y) && (x, y) != (2, 2)));
    assert_eq!(ring, [-25.0, 9.0, -1.0]);
    // The island's corner pinches the hole: without (1, 1) missing it touches the surface there.
    let pinched = areas(&grid(5, 5, |x, y| {
        (1..4).contains(&x) && (1..4).contains(&y) && (x, y) != (2, 2) && (x, y) != (1, 1)
    }));
    assert_eq!(pinched.iter().sum::<f64>(), -25.0 + 7.0);
    assert_eq!(pinched.len(), 3);
}

#[test]
fn a_checkerboard_gives_one_loop_for_each_missing_quad() {
    let found = areas(&grid(7, 7, |x, y| (1..6).contains(&x) && (1..6).contains(&y) && (x + y) % 2 == 0));
    assert_eq!(found.iter().filter(|&&a| a == 1.0).count(), 13);
    assert_eq!(found.len(), 14);
}

#[test]
fn bow_ties_stay_with_their_hole_on_walls_and_undersides() {
    let flat = grid(6, 6, |x, y| (x, y) == (2, 2) || (x, y) == (3, 3));
    let level = moved(&flat, |p| DVec3::new(p.x, p.y, 0.0));
    let maps: [(&str, fn(DVec3) -> DVec3); 4] = [
        ("wall", |p| DVec3::new(p.z, p.x, p.y)),
        ("other wall", |p| DVec3::new(p.x, p.z, -p.y)),
        ("underside", |p| DVec3::new(p.x, -p.y, -p.z)),
        ("far away", |p| p + DVec3::new(5e5, 5e5, 0.0)),
    ];
    let sizes = |mesh: &TriMesh| loops_of(mesh).1.loops.iter().map(|l| l.edges.len()).collect::<Vec<_>>();
    assert_eq!(sizes(&level), [24, 4, 4]);
    for (name, map) in maps {
        assert_eq!(sizes(&moved(&level, map)), [24, 4, 4], "{name}");
    }
}

#[test]
fn loops_do_not_depend_on_how_the_mesh_is_written() {
    let original = grid_with_holes();
    let expected = canonical(&original);
    for (name, other) in rewritings(&original) {
        assert_eq!(canonical(&other), expected, "{name}");
    }
}

#[test]
fn loops_know_what_must_not_be_filled() {
    let places = [
        [0.0, 0.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [1.0, 0.0, 1.0],
    ];
    let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    let third = mesh(&places, &[&fan[..], &[[0, 1, 5]]].concat());
    let (found, all) = loops_of(&third);
    let marked: Vec<bool> = all.loops.iter().map(|l| l.has_non_manifold(&found)).collect();
    assert!(marked.contains(&true), "{marked:?}");
    let flipped = mesh(&places, &[fan[0], fan[1], fan[2], [0, 1, 4]]);
    let (found, all) = loops_of(&flipped);
    assert!(all.loops.iter().any(|l| l.has_conflict(&found)));
    let (found, all) = loops_of(&mesh(&places, &fan));
    assert!(!all.loops[0].has_non_manifold(&found) && !all.loops[0].has_conflict(&found));
}

#[test]
fn a_boundary_that_is_not_closed_is_counted_not_walked_for_ever() {
    let mut found = boundary(&grid(3, 3, |x, y| (x, y) == (1, 1)));
    found.edges.remove(2);
    let all = loops(&found);
    assert_eq!(all.loops.iter().map(|l| l.edges.len()).sum::<usize>() + all.open_edges, found.edges.len());
    assert!(all.open_edges > 0);
}

proptest! {
    #![proptest_config(common::fixed_cases())]

    #[test]
    fn any_pattern_of_holes_gives_simple_loops(holes in prop::collection::vec(any::<bool>(), 64)) {
        let mesh = grid(8, 8, |x, y| holes[(y * 8 + x) as usize]);
        let sum: f64 = areas(&mesh).iter().sum();
        prop_assert_eq!(sum, -(mesh.triangles.len() as f64) / 2.0);
    }

    #[test]
    fn any_triangles_give_simple_loops(triangles in prop::collection::vec([0..9u32, 0..9u32, 0..9u32], 0..40)) {
        let place = |v: u32| DVec3::new(f64::from(v % 3), f64::from(v / 3), f64::from(v * v % 5));
        loops_of(&TriMesh { positions: (0..9).map(place).collect(), triangles });
    }
}
