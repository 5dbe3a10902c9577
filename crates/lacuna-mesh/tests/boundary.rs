//! Boundaries: every case of the balance, against counting edge by edge, and unchanged by other ways to write a mesh.

mod common;

use common::{
    boundary_net, brute_net, canonical, count_kind, grid, grid_with_holes, mesh, moved, rewritings,
};
use glam::DVec3;
use lacuna_mesh::{Boundary, BoundaryKind, Defects, TriMesh, VertexId, boundary, position_bits};
use proptest::prelude::*;

/// Five places: a flat square round its middle (0), and one above it.
const PLACES: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
];
const FAN: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];

/// What must hold for every boundary of every mesh.
fn check(mesh: &TriMesh, found: &Boundary) {
    let left_out: Vec<u32> = found.duplicates.iter().map(|f| f.0).collect();
    assert_eq!(boundary_net(found), brute_net(mesh, &left_out), "edges differ from those counted one by one");
    assert!(found.points.is_sorted_by(|a, b| a.vertex < b.vertex));
    assert!(found.edges.is_sorted_by_key(|e| (e.from, e.to, e.face)));
    assert!(found.copies.is_sorted());
    for edge in &found.edges {
        assert!(!found.duplicates.contains(&edge.face));
        let corners = mesh.corners(edge.face.index()).map(position_bits);
        let ends = [edge.to, edge.from].map(|p| position_bits(found.position(p)));
        let runs = (0..3).any(|i| {
            [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]]
                == [ends[0], ends[1], position_bits(edge.apex)]
        });
        assert!(runs, "{edge:?} is not against an edge of its triangle");
    }
    let mut balance = vec![0i32; found.points.len()];
    for edge in &found.edges {
        balance[edge.from.index()] += 1;
        balance[edge.to.index()] -= 1;
    }
    assert!(balance.iter().all(|&b| b == 0), "a point has more starts than ends");
    for (i, point) in found.points.iter().enumerate() {
        assert_eq!(found.point_of(point.vertex).map(|p| p.index()), Some(i));
    }
}

#[test]
fn every_case_is_treated_as_the_table_says() {
    let closed: &[[u32; 3]] = &[[1, 3, 2], [1, 4, 3]];
    let with = |more: &[[u32; 3]]| [&FAN, more].concat();
    // name, triangles, boundary edges: simple, conflict, non-manifold; defects: duplicate, degenerate
    let cases: [(&str, Vec<[u32; 3]>, [usize; 3], [u64; 2]); 14] = [
        ("a fan", FAN.to_vec(), [4, 0, 0], [0, 0]),
        ("one triangle of the fan is missing", FAN[..3].to_vec(), [5, 0, 0], [0, 0]),
        ("one triangle of the fan is flipped", vec![FAN[0], FAN[1], FAN[2], [0, 1, 4]], [4, 4, 0], [0, 0]),
        ("three triangles on an edge", with(&[[0, 1, 5]]), [6, 0, 1], [0, 0]),
        ("four triangles on an edge, two each way", with(&[[0, 1, 5], [1, 0, 5]]), [4, 0, 0], [0, 0]),
        ("a triangle twice", with(&[FAN[1]]), [4, 0, 0], [1, 0]),
        ("a triangle three times, rotated", with(&[[2, 3, 0], [3, 0, 2]]), [4, 0, 0], [2, 0]),
        ("a triangle twice and its reverse", with(&[[2, 0, 1], [0, 2, 1]]), [3, 0, 1], [0, 0]),
        ("a triangle three times and its reverse", with(&[FAN[0], FAN[0], [0, 2, 1]]), [3, 0, 1], [1, 0]),
        ("a triangle and its reverse", with(&[[0, 2, 1]]), [3, 0, 2], [0, 0]),
        (
            "an inner sheet of no thickness",
            [&FAN, closed, &[[0, 5, 2], [2, 5, 0]]].concat(),
            [0, 0, 0],
            [0, 0],
        ),
        ("closed", [&FAN, closed].concat(), [0, 0, 0], [0, 0]),
        ("a degenerate triangle", with(&[[1, 1, 3]]), [4, 0, 0], [0, 1]),
        ("nothing", vec![], [0, 0, 0], [0, 0]),
    ];
    for (name, triangles, edges, [duplicate, degenerate]) in cases {
        let mesh = mesh(&PLACES, &triangles);
        let found = boundary(&mesh);
        check(&mesh, &found);
        let kinds = [BoundaryKind::Simple, BoundaryKind::Conflict, BoundaryKind::NonManifold];
        assert_eq!(kinds.map(|k| count_kind(&found, k)), edges, "{name}");
        assert_eq!((found.defects.duplicate, found.defects.degenerate), (duplicate, degenerate), "{name}");
    }
}

#[test]
fn the_pair_that_bends_least_stays() {
    // On edge 0-1 meet two flat triangles and one that stands upright, wherever it comes in the list.
    for at in 0..=4 {
        let mut triangles = FAN.to_vec();
        triangles.insert(at, [0, 1, 5]);
        let found = boundary(&mesh(&PLACES, &triangles));
        let cut: Vec<_> = found.edges.iter().filter(|e| e.kind == BoundaryKind::NonManifold).collect();
        assert_eq!(cut.iter().map(|e| e.face.index()).collect::<Vec<_>>(), [at]);
        assert_eq!((found.defects.non_manifold_edges, cut[0].apex), (1, DVec3::from(PLACES[5])));
    }
}

#[test]
fn a_flipped_triangle_gives_two_edges_for_each_conflict() {
    let found = boundary(&mesh(&PLACES, &[FAN[0], FAN[1], FAN[2], [0, 1, 4]]));
    assert_eq!(found.defects, Defects { conflict_edges: 2, ..Defects::default() });
    let conflicts = found.edges.iter().filter(|e| e.kind == BoundaryKind::Conflict);
    let mut faces: Vec<u32> = conflicts.map(|e| e.face.0).collect();
    faces.sort_unstable();
    assert_eq!(faces, [0, 2, 3, 3]);
}

#[test]
fn vertices_without_sound_triangles_are_ignored() {
    let mut mesh = mesh(&PLACES, &FAN);
    let clean = canonical(&boundary(&mesh));
    mesh.positions.extend([
        DVec3::from(PLACES[1]),
        DVec3::NAN,
        DVec3::new(0.0, f64::INFINITY, 0.0),
        DVec3::ONE,
    ]);
    mesh.triangles.extend([[0, 1, 7], [8, 2, 3], [7, 7, 7]]);
    let found = boundary(&mesh);
    check(&mesh, &found);
    assert_eq!(canonical(&found), clean);
    assert_eq!((found.defects.non_finite, found.points.len()), (3, 4));
    assert!(
        found.copies.contains(&[VertexId(6), VertexId(1)]),
        "the isolated copy is known: {:?}",
        found.copies
    );
}

#[test]
fn minus_zero_is_zero() {
    let mut mesh = common::split_into_charts(&mesh(&PLACES, &FAN), 1);
    for (i, p) in mesh.positions.iter_mut().enumerate().filter(|(_, p)| p.z == 0.0) {
        *p = if i % 2 == 0 { DVec3::new(p.x, p.y, -0.0) } else { *p };
    }
    assert_eq!(boundary(&mesh).edges.len(), 4);
}

#[test]
fn a_surface_that_is_there_twice_counts_once() {
    let once = grid_with_holes();
    let twice =
        TriMesh { triangles: [once.triangles.clone(), once.triangles.clone()].concat(), ..once.clone() };
    let found = boundary(&twice);
    check(&twice, &found);
    assert_eq!(canonical(&found), canonical(&boundary(&once)));
    assert_eq!(found.defects.duplicate, once.triangles.len() as u64);
    for (name, other) in rewritings(&twice) {
        let found = boundary(&other);
        assert_eq!(canonical(&found), canonical(&boundary(&once)), "{name}");
    }
}

#[test]
fn the_boundary_does_not_depend_on_how_the_mesh_is_written() {
    let original = grid_with_holes();
    let expected = canonical(&boundary(&original));
    assert_eq!(expected.len(), 72 + 10 + 4 + 14 + 8);
    for (name, other) in rewritings(&original) {
        let found = boundary(&other);
        check(&other, &found);
        assert_eq!(canonical(&found), expected, "{name}");
        assert_eq!(found.defects, Defects::default(), "{name}");
    }
}

#[test]
fn the_boundary_moves_with_the_mesh() {
    let original = grid_with_holes();
    let plain = boundary(&original);
    let maps: [(&str, fn(DVec3) -> DVec3); 4] = [
        ("shifted", |p| p + DVec3::new(5e5, -5e5, 128.0)),
        ("turned", |p| DVec3::new(-p.y, p.x, p.z)),
        ("mirrored", |p| DVec3::new(-p.x, p.y, p.z)),
        ("stood up", |p| DVec3::new(p.z, p.x, p.y)),
    ];
    for (name, map) in maps {
        let found = boundary(&moved(&original, map));
        let pairs = found.edges.iter().zip(&plain.edges);
        assert!(
            pairs.clone().all(|(a, b)| (a.from, a.to, a.face, a.kind) == (b.from, b.to, b.face, b.kind)),
            "{name}"
        );
        assert!(pairs.clone().all(|(a, b)| a.apex == map(b.apex)), "{name}");
        assert_eq!(found.edges.len(), plain.edges.len(), "{name}");
    }
}

#[test]
fn the_missing_surface_is_on_the_left() {
    let found = boundary(&grid(5, 5, |x, y| (x, y) == (2, 2)));
    let middle = DVec3::new(0.625, 0.625, 0.0);
    let is_hole_edge = |p: DVec3| p.truncate().distance(middle.truncate()) < 0.3;
    let hole: Vec<_> = found.edges.iter().filter(|e| is_hole_edge(found.position(e.from))).collect();
    assert_eq!(hole.len(), 4);
    for edge in hole {
        let (a, b) = (found.position(edge.from).truncate(), found.position(edge.to).truncate());
        assert!((b - a).perp_dot(middle.truncate() - a) > 0.0);
        assert!((b - a).perp_dot(edge.apex.truncate() - a) < 0.0);
    }
}

/// Triangles between eight places, each place with three vertices: seams, flips, duplicates, non-manifold edges.
fn wild_mesh() -> impl Strategy<Value = TriMesh> {
    let corner = (0..8u32, 0..3u32).prop_map(|(place, copy)| place * 3 + copy);
    prop::collection::vec([corner.clone(), corner.clone(), corner], 0..40).prop_map(|triangles| {
        let place = |v: u32| DVec3::new(f64::from(v & 1), f64::from(v >> 1 & 1), f64::from(v >> 2));
        TriMesh { positions: (0..24).map(|v| place(v / 3)).collect(), triangles }
    })
}

proptest! {
    #![proptest_config(common::fixed_cases())]

    #[test]
    fn wild_meshes_agree_with_counting(mesh in wild_mesh()) {
        let found = boundary(&mesh);
        check(&mesh, &found);
        for duplicate in &found.duplicates {
            let cycle = |t: usize| {
                let mut corners = mesh.corners(t).map(position_bits);
                let first = (0..3).min_by_key(|&i| corners[i]).unwrap();
                corners.rotate_left(first);
                corners
            };
            let is_kept = |t: usize| !found.duplicates.iter().any(|f| f.index() == t);
            prop_assert!((0..duplicate.index()).any(|t| is_kept(t) && cycle(t) == cycle(duplicate.index())));
        }
    }

    #[test]
    fn grids_with_random_holes_agree_with_counting(holes in prop::collection::vec(any::<bool>(), 64), chart in 1..50usize) {
        let mesh = common::split_into_charts(&grid(8, 8, |x, y| holes[(y * 8 + x) as usize]), chart);
        let found = boundary(&mesh);
        check(&mesh, &found);
        prop_assert_eq!(found.defects, Defects::default());
    }
}
