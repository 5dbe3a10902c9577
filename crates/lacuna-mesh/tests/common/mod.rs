//! Meshes to try things on, and ways to write the same mesh differently.
#![allow(dead_code, unreachable_pub)] // each test file uses its own part

use glam::DVec3;
use lacuna_mesh::{Boundary, BoundaryKind, TriMesh, position_bits};
use proptest::test_runner::{Config, RngSeed};
use std::collections::BTreeMap;

/// Position bits of a place.
pub type Place = [u64; 3];

/// A mesh from corners.
pub fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
    TriMesh { positions: positions.iter().map(|&p| p.into()).collect(), triangles: triangles.to_vec() }
}

/// A hilly grid of `width` x `height` quads of 0.25 m, two triangles each, without the quads that `is_hole` names.
pub fn grid(width: u32, height: u32, is_hole: impl Fn(u32, u32) -> bool) -> TriMesh {
    let place =
        |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), f64::from((x * 7 + y * 5) % 11)) * 0.25;
    let row = width + 1;
    let positions = (0..=height).flat_map(|y| (0..=width).map(move |x| place(x, y))).collect();
    let quads = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let triangles = quads.filter(|&(x, y)| !is_hole(x, y)).flat_map(|(x, y)| {
        let v = y * row + x;
        [[v, v + 1, v + row + 1], [v, v + row + 1, v + row]]
    });
    TriMesh { positions, triangles: triangles.collect() }
}

/// A 20 x 16 grid with three holes of 2 x 3, 1 and 12 quads and one bow-tie pair.
pub fn grid_with_holes() -> TriMesh {
    grid(20, 16, |x, y| {
        let a = (3..5).contains(&x) && (4..7).contains(&y);
        let b = (x, y) == (10, 3);
        let c = (12..16).contains(&x) && (9..12).contains(&y);
        let bow_tie = (x, y) == (4, 11) || (x, y) == (5, 12);
        a || b || c || bow_tie
    })
}

/// The same cases in every run; nothing is written beside the sources.
pub fn fixed_cases() -> Config {
    Config { cases: 400, rng_seed: RngSeed::Fixed(17), failure_persistence: None, ..Config::default() }
}

/// A fixed sequence of pseudo-random numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % bound as u64) as usize
    }

    pub fn permutation(&mut self, len: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..len).collect();
        (1..len).rev().for_each(|i| order.swap(i, self.below(i + 1)));
        order
    }
}

/// The same triangles in another order.
pub fn shuffled_triangles(mesh: &TriMesh, seed: u64) -> TriMesh {
    let order = Random(seed).permutation(mesh.triangles.len());
    TriMesh {
        positions: mesh.positions.clone(),
        triangles: order.iter().map(|&t| mesh.triangles[t]).collect(),
    }
}

/// The same vertices under other numbers.
pub fn renumbered(mesh: &TriMesh, seed: u64) -> TriMesh {
    let number = Random(seed).permutation(mesh.positions.len());
    let mut positions = mesh.positions.clone();
    mesh.positions.iter().zip(&number).for_each(|(&p, &n)| positions[n] = p);
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| number[v as usize] as u32)).collect();
    TriMesh { positions, triangles }
}

/// Texture charts: triangles in runs of `chart` get vertices of their own.
pub fn split_into_charts(mesh: &TriMesh, chart: usize) -> TriMesh {
    let mut split = TriMesh::default();
    for run in mesh.triangles.chunks(chart) {
        let mut copy = BTreeMap::new();
        for triangle in run {
            split.triangles.push(triangle.map(|v| {
                *copy.entry(v).or_insert_with(|| {
                    split.positions.push(mesh.positions[v as usize]);
                    split.positions.len() as u32 - 1
                })
            }));
        }
    }
    split
}

/// The same mesh elsewhere: every position mapped.
pub fn moved(mesh: &TriMesh, map: impl Fn(DVec3) -> DVec3) -> TriMesh {
    TriMesh { positions: mesh.positions.iter().map(|&p| map(p)).collect(), triangles: mesh.triangles.clone() }
}

/// Ways to write the same mesh.
pub fn rewritings(mesh: &TriMesh) -> Vec<(&'static str, TriMesh)> {
    vec![
        ("triangles shuffled", shuffled_triangles(mesh, 1)),
        ("vertices renumbered", renumbered(mesh, 2)),
        ("charts of 40 triangles", split_into_charts(mesh, 40)),
        ("charts of 7 triangles", split_into_charts(mesh, 7)),
        ("triangle soup", split_into_charts(mesh, 1)),
        ("soup, shuffled, renumbered", renumbered(&shuffled_triangles(&split_into_charts(mesh, 1), 3), 4)),
    ]
}

/// Boundary edges as (from, to, apex, kind), whatever the numbering; sorted.
pub fn canonical(boundary: &Boundary) -> Vec<(Place, Place, Place, String)> {
    let place = |p| position_bits(boundary.position(p));
    let edges = boundary.edges.iter();
    let mut all: Vec<_> =
        edges.map(|e| (place(e.from), place(e.to), position_bits(e.apex), format!("{:?}", e.kind))).collect();
    all.sort();
    all
}

/// How many edges of a kind there are.
pub fn count_kind(boundary: &Boundary, kind: BoundaryKind) -> usize {
    boundary.edges.iter().filter(|e| e.kind == kind).count()
}

/// Net use of each undirected edge between places, counted one by one: `(lower, higher)` -> uses upward - downward.
/// Triangles named in `left_out`, degenerate and non-finite ones are left out.
pub fn brute_net(mesh: &TriMesh, left_out: &[u32]) -> BTreeMap<(Place, Place), i64> {
    let mut net = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let [a, b, c] = corners.map(position_bits);
        let is_sound = corners.iter().all(|p| p.is_finite()) && a != b && b != c && c != a;
        if is_sound && !left_out.contains(&(t as u32)) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *net.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
    }
    net.retain(|_, n| *n != 0);
    net
}

/// Net use that the boundary's edges stand for: each is there once against its triangle.
pub fn boundary_net(boundary: &Boundary) -> BTreeMap<(Place, Place), i64> {
    let mut net = BTreeMap::new();
    for edge in &boundary.edges {
        let (from, to) =
            (position_bits(boundary.position(edge.from)), position_bits(boundary.position(edge.to)));
        *net.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { -1 } else { 1 };
    }
    net
}
