//! The band of triangles round chosen boundary points.

use crate::{Boundary, FaceId, PointId, TriMesh, VertexId};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Ring of a vertex that no pass has reached.
const FAR: u8 = u8::MAX;

/// A place in the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BandVertex {
    /// Position, metres.
    pub position: DVec3,
    /// The vertex that stands for all vertices at this place ([`Boundary::representative`]).
    pub vertex: VertexId,
    /// How many edges it is away from the nearest seed point (0 = seed point).
    pub ring: u8,
    /// The boundary point it is, if it is one.
    pub point: Option<PointId>,
}

/// Triangles within some rings of chosen boundary points, with texture seams closed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Places, sorted by `vertex`.
    pub vertices: Vec<BandVertex>,
    /// Corners as indices into `vertices`, in the mesh's orientation.
    pub triangles: Vec<[u32; 3]>,
    /// The mesh's triangle behind each of `triangles`, ascending.
    pub faces: Vec<FaceId>,
}

/// The triangles of `mesh` with a vertex less than `rings` edges away from a seed point; empty for 0 rings.
///
/// `seeds` has a flag for each point of `boundary`. Steps: (1) the seed points' vertices, all copies, are ring 0;
/// (2) `rings` passes over the triangles: one that touches ring k - 1 gives its other vertices ring k, and copies of one
/// place share the smallest ring; (3) the triangles that touch a ring below `rings` are collected. Left out are those
/// that the boundary ignores too: not finite, two corners at one place, repeated. Time: `rings + 1` reads of the
/// triangles; memory: a byte a vertex. At most 254 rings.
///
/// Source: algorithm note, section A.3.
#[must_use]
pub fn band(mesh: &TriMesh, boundary: &Boundary, seeds: &[bool], rings: u8) -> Band {
    let rings = rings.min(FAR - 1);
    let mut ring = seed_rings(mesh, boundary, seeds);
    for pass in 1..=rings {
        grow(mesh, boundary, &mut ring, pass);
    }
    collect(mesh, boundary, &ring, rings)
}

/// Ring 0 for all copies of the seed points, `FAR` for all other vertices.
fn seed_rings(mesh: &TriMesh, boundary: &Boundary, seeds: &[bool]) -> Vec<u8> {
    let mut ring = vec![FAR; mesh.positions.len()];
    for (point, _) in boundary.points.iter().zip(seeds).filter(|(_, seed)| **seed) {
        ring[point.vertex.index()] = 0;
    }
    share_with_copies(boundary, &mut ring);
    ring
}

/// Gives ring `pass` to the vertices of triangles that touch the ring before.
fn grow(mesh: &TriMesh, boundary: &Boundary, ring: &mut [u8], pass: u8) {
    for (face, &triangle) in mesh.triangles.iter().enumerate() {
        let rings = triangle.map(|v| ring[v as usize]);
        let nearest = rings[0].min(rings[1]).min(rings[2]);
        if nearest < pass && rings.contains(&FAR) && is_counted(mesh, boundary, face) {
            for v in triangle {
                ring[v as usize] = ring[v as usize].min(pass);
            }
        }
    }
    share_with_copies(boundary, ring);
}

/// Gives all copies of a place the smallest ring among them.
fn share_with_copies(boundary: &Boundary, ring: &mut [u8]) {
    for [copy, representative] in &boundary.copies {
        ring[representative.index()] = ring[representative.index()].min(ring[copy.index()]);
    }
    for [copy, representative] in &boundary.copies {
        ring[copy.index()] = ring[representative.index()];
    }
}

/// True if the triangle is finite, has three places and repeats no earlier one that the boundary knows.
fn is_counted(mesh: &TriMesh, boundary: &Boundary, face: usize) -> bool {
    mesh.corners(face).iter().all(|p| p.is_finite())
        && boundary.duplicates.binary_search(&FaceId(face as u32)).is_err()
}

/// The triangles with a vertex below ring `rings`, with the places they use.
fn collect(mesh: &TriMesh, boundary: &Boundary, ring: &[u8], rings: u8) -> Band {
    let mut faces = Vec::new();
    let mut triangles = Vec::new();
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        if triangle.iter().any(|&v| ring[v as usize] < rings) && is_counted(mesh, boundary, face) {
            let [a, b, c] = triangle.map(|v| boundary.representative(VertexId(v)));
            if a != b && b != c && c != a {
                faces.push(FaceId(face as u32));
                triangles.push([a, b, c]);
            }
        }
    }
    let mut used: Vec<VertexId> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: VertexId| used.binary_search(&v).map_or(0, |i| i as u32);
    let triangles = triangles.iter().map(|t| t.map(number)).collect();
    let vertices = used.iter().map(|&v| band_vertex(mesh, boundary, ring, v)).collect();
    Band { vertices, triangles, faces }
}

fn band_vertex(mesh: &TriMesh, boundary: &Boundary, ring: &[u8], vertex: VertexId) -> BandVertex {
    BandVertex {
        position: mesh.positions[vertex.index()],
        vertex,
        ring: ring[vertex.index()],
        point: boundary.point_of(vertex),
    }
}
