//! The band of triangles round chosen boundary points.

use crate::{Boundary, FaceId, PointId, TriMesh, VertexId};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A place in the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BandVertex {
    /// Position, metres.
    pub position: DVec3,
    /// The vertex that stands for all vertices at this place ([`Boundary::representative`]).
    pub vertex: VertexId,
    /// The boundary point it is, if it is one.
    pub point: Option<PointId>,
}

/// Triangles within some rings of boundary points, with texture seams closed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Places, sorted by `vertex`.
    pub vertices: Vec<BandVertex>,
    /// Corners as indices into `vertices`, in the mesh's orientation.
    pub triangles: Vec<[u32; 3]>,
    /// The mesh's triangle behind each of `triangles`, ascending.
    pub faces: Vec<FaceId>,
}

/// The triangles round the boundary points of `mesh`: `rings[p]` rings of them round point `p`, none for 0. A triangle
/// belongs to it if one of its vertices is less than `rings[p]` edges away from some point `p`.
///
/// Steps: (1) the points' vertices, all copies, start with their number of rings left; (2) for each number from the
/// largest down, one pass over the triangles: a vertex with that many rings left gives the others of its triangle one
/// less; (3) the triangles with a vertex that has rings left are collected. Left out are those that the boundary ignores
/// too: not finite, two corners at one place, repeated. Time: one read of the triangles more than the largest number;
/// memory: a byte a vertex.
///
/// Source: algorithm note, section A.3.
#[must_use]
pub fn band(mesh: &TriMesh, boundary: &Boundary, rings: &[u8]) -> Band {
    let mut left = vec![0u8; mesh.positions.len()];
    for (point, &rings) in boundary.points.iter().zip(rings) {
        left[point.vertex.index()] = rings;
    }
    share_with_copies(boundary, &mut left);
    let most = rings.iter().copied().max().unwrap_or(0);
    for pass in (2..=most).rev() {
        grow(mesh, boundary, &mut left, pass);
    }
    collect(mesh, boundary, &left)
}

/// Gives one ring less than `pass` to the vertices of triangles that touch a vertex with `pass` rings left.
fn grow(mesh: &TriMesh, boundary: &Boundary, left: &mut [u8], pass: u8) {
    for (face, &triangle) in mesh.triangles.iter().enumerate() {
        let rings = triangle.map(|v| left[v as usize]);
        let most = rings[0].max(rings[1]).max(rings[2]);
        let least = rings[0].min(rings[1]).min(rings[2]);
        if most == pass && least + 1 < pass && is_counted(mesh, boundary, face) {
            for v in triangle {
                left[v as usize] = left[v as usize].max(pass - 1);
            }
        }
    }
    share_with_copies(boundary, left);
}

/// Gives all copies of a place the largest number among them.
fn share_with_copies(boundary: &Boundary, left: &mut [u8]) {
    for [copy, representative] in &boundary.copies {
        left[representative.index()] = left[representative.index()].max(left[copy.index()]);
    }
    for [copy, representative] in &boundary.copies {
        left[copy.index()] = left[representative.index()];
    }
}

/// True if the triangle is finite, has three places and repeats no earlier one that the boundary knows.
fn is_counted(mesh: &TriMesh, boundary: &Boundary, face: usize) -> bool {
    mesh.corners(face).iter().all(|p| p.is_finite())
        && boundary.duplicates.binary_search(&FaceId(face as u32)).is_err()
}

/// The triangles with a vertex that has rings left, with the places they use.
fn collect(mesh: &TriMesh, boundary: &Boundary, left: &[u8]) -> Band {
    let mut faces = Vec::new();
    let mut triangles = Vec::new();
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        if triangle.iter().any(|&v| left[v as usize] > 0) && is_counted(mesh, boundary, face) {
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
    let vertices = used.iter().map(|&v| band_vertex(mesh, boundary, v)).collect();
    Band { vertices, triangles, faces }
}

fn band_vertex(mesh: &TriMesh, boundary: &Boundary, vertex: VertexId) -> BandVertex {
    BandVertex { position: mesh.positions[vertex.index()], vertex, point: boundary.point_of(vertex) }
}

impl Band {
    /// Place of a vertex in `vertices`, by the vertex that stands for it.
    #[must_use]
    pub fn find(&self, vertex: VertexId) -> Option<u32> {
        self.vertices.binary_search_by_key(&vertex, |v| v.vertex).ok().map(|k| k as u32)
    }
}
