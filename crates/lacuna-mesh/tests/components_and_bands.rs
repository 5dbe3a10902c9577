//! Components and bands: the same however the mesh is written, seams closed, against plain breadth-first search.

mod common;

use common::{grid, grid_with_holes, mesh, rewritings, split_into_charts};
use glam::DVec3;
use lacuna_mesh::{
    Band, Boundary, BoundaryPoint, FaceId, TriMesh, band, boundary, components, position_bits,
};
use std::collections::{BTreeMap, BTreeSet};

/// Two grids of 18 and 8 quads, 10 m apart, the second split from the first in the list by its own vertices.
fn two_pieces() -> TriMesh {
    let (mut both, other) = (grid(6, 3, |_, _| false), grid(4, 2, |_, _| false));
    let first = both.positions.len() as u32;
    both.positions.extend(other.positions.iter().map(|&p| p + DVec3::X * 10.0));
    both.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    both
}

#[test]
fn pieces_are_counted_however_the_mesh_is_written() {
    let original = two_pieces();
    for (name, mesh) in [("as it is", original.clone())].into_iter().chain(rewritings(&original)) {
        let found = components(&mesh, &boundary(&mesh));
        let mut sizes: Vec<usize> = found.list.iter().map(|c| c.triangles).collect();
        assert!(found.list.is_sorted_by_key(|c| c.first_face), "{name}");
        assert_eq!(found.list[0].first_face, FaceId(0), "{name}");
        sizes.sort_unstable();
        assert_eq!(sizes, [16, 36], "{name}");
        for face in 0..mesh.triangles.len() {
            let component = found.of_face(&mesh, FaceId(face as u32)).expect("every corner is finite");
            assert_eq!(found.list[component].triangles == 16, mesh.corners(face)[0].x >= 10.0, "{name}");
        }
    }
}

#[test]
fn areas_of_small_components_are_those_of_their_triangles() {
    let flat = common::moved(&two_pieces(), |p| DVec3::new(p.x + 5e5, p.y, 3.0));
    let found = components(&flat, &boundary(&flat));
    assert_eq!(found.list.iter().map(|c| c.area_m2).collect::<Vec<_>>(), [18.0 / 16.0, 8.0 / 16.0]);
    let large = common::grid(6, 6, |_, _| false);
    assert_eq!(components(&large, &boundary(&large)).list[0].area_m2, f64::INFINITY);
}

#[test]
fn triangles_that_are_not_finite_join_nothing() {
    let mut both = two_pieces();
    both.positions.push(DVec3::NAN);
    let last = both.positions.len() as u32 - 1;
    both.triangles.push([0, last - 1, last]);
    let found = components(&both, &boundary(&both));
    assert_eq!(found.list.len(), 2);
    assert_eq!(found.of_face(&both, FaceId(both.triangles.len() as u32 - 1)), None);
    assert_eq!(components(&TriMesh::default(), &Boundary::default()).list.len(), 0);
}

/// Distance of each place from the seeds in edges, by breadth-first search over a map of places.
fn brute_rings(mesh: &TriMesh, seeds: &BTreeSet<[u64; 3]>) -> BTreeMap<[u64; 3], u32> {
    let mut rings: BTreeMap<[u64; 3], u32> = seeds.iter().map(|&p| (p, 0)).collect();
    for pass in 1.. {
        let known = rings.clone();
        for t in 0..mesh.triangles.len() {
            let places = mesh.corners(t).map(position_bits);
            if places.iter().any(|p| known.contains_key(p)) {
                places.into_iter().for_each(|p| _ = rings.entry(p).or_insert(pass));
            }
        }
        if rings.len() == known.len() {
            return rings;
        }
    }
    rings
}

/// Band round the boundary points in the left half of the mesh.
fn left_band(mesh: &TriMesh, rings: u8) -> (Band, BTreeSet<[u64; 3]>) {
    let found = boundary(mesh);
    let is_seed = |p: &&BoundaryPoint| p.position.x < 2.0 && p.position.y > 0.5;
    let wanted: Vec<u8> = found.points.iter().map(|p| if is_seed(&p) { rings } else { 0 }).collect();
    let places = found.points.iter().filter(is_seed).map(|p| position_bits(p.position)).collect();
    (band(mesh, &found, &wanted), places)
}

fn check_band(mesh: &TriMesh, rings: u8) -> BTreeSet<[[u64; 3]; 3]> {
    let (found, seeds) = left_band(mesh, rings);
    let expected = brute_rings(mesh, &seeds);
    let is_near = |t: usize| mesh.corners(t).iter().any(|&p| expected[&position_bits(p)] < u32::from(rings));
    let near: Vec<u32> = (0..mesh.triangles.len()).filter(|&t| is_near(t)).map(|t| t as u32).collect();
    assert_eq!(found.faces.iter().map(|f| f.0).collect::<Vec<_>>(), near, "{rings} rings");
    let places: BTreeSet<_> = found.vertices.iter().map(|v| position_bits(v.position)).collect();
    assert_eq!(places.len(), found.vertices.len(), "each place once");
    for (triangle, face) in found.triangles.iter().zip(&found.faces) {
        assert_eq!(triangle.map(|v| found.vertices[v as usize].position), mesh.corners(face.index()));
    }
    let corners =
        found.triangles.iter().map(|t| t.map(|v| position_bits(found.vertices[v as usize].position)));
    corners
        .map(|mut c| {
            let first = (0..3).min_by_key(|&i| c[i]).unwrap_or(0);
            c.rotate_left(first);
            c
        })
        .collect()
}

#[test]
fn bands_have_the_rings_that_a_search_finds_however_the_mesh_is_written() {
    let original = grid_with_holes();
    for rings in [0, 1, 2, 4, 30] {
        let expected = check_band(&original, rings);
        assert_eq!(expected.is_empty(), rings == 0);
        for (name, mesh) in rewritings(&original) {
            assert_eq!(check_band(&mesh, rings), expected, "{name}, {rings} rings");
        }
    }
}

#[test]
fn band_vertices_know_their_boundary_points() {
    let mesh = split_into_charts(&grid_with_holes(), 9);
    let found = boundary(&mesh);
    let all = band(&mesh, &found, &vec![2; found.points.len()]);
    let named: Vec<_> =
        all.vertices.iter().filter_map(|v| v.point.map(|p| (found.position(p), v.position))).collect();
    assert!(named.iter().all(|(a, b)| a == b));
    assert_eq!(named.len(), found.points.len());
    assert!(all.vertices.iter().all(|v| all.find(v.vertex).map(|k| all.vertices[k as usize]) == Some(*v)));
}

#[test]
fn each_boundary_point_has_its_own_number_of_rings() {
    let mesh = grid_with_holes();
    let found = boundary(&mesh);
    let of = |number: &dyn Fn(usize) -> u8| {
        let rings: Vec<u8> = (0..found.points.len()).map(number).collect();
        band(&mesh, &found, &rings).faces.into_iter().collect::<BTreeSet<_>>()
    };
    let mixed = of(&|p| if p % 3 == 0 { 3 } else { u8::from(p % 3 == 1) });
    let [three, one] = [of(&|p| 3 * u8::from(p % 3 == 0)), of(&|p| u8::from(p % 3 == 1))];
    assert_eq!(mixed, three.union(&one).copied().collect());
    assert!(one.len() < mixed.len());
}

#[test]
fn repeated_and_flat_triangles_are_not_in_the_band() {
    let places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
    let mesh = mesh(&places, &[[0, 1, 2], [2, 3, 1], [0, 1, 2], [0, 3, 1]]);
    let found = boundary(&mesh);
    let all = band(&mesh, &found, &vec![1; found.points.len()]);
    assert_eq!(all.faces, [FaceId(0)], "{:?}", found.defects);
}
