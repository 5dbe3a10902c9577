//! Connected components of a mesh.

use crate::{Boundary, Bounds, FaceId, TriMesh};
use serde::{Deserialize, Serialize};

/// Label of a vertex that no triangle uses.
const NONE: u32 = u32::MAX;

/// A connected piece of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Its smallest triangle.
    pub first_face: FaceId,
    /// How many triangles it has.
    pub triangles: usize,
    /// Sum of their areas in space, square metres.
    pub area_m2: f64,
    /// Box of their corners, metres.
    pub bounds: Bounds,
}

/// The components of a mesh, numbered by smallest triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Components {
    /// Components in the order of their numbers.
    pub list: Vec<Component>,
    vertex_component: Vec<u32>,
}

impl Components {
    /// The component (index into `list`) of a triangle of the mesh; `None` if it was ignored and its corners don't
    /// belong to one component.
    #[must_use]
    pub fn of_face(&self, mesh: &TriMesh, face: FaceId) -> Option<usize> {
        let [a, b, c] = mesh.triangles[face.index()].map(|v| self.vertex_component[v as usize]);
        (a != NONE && a == b && b == c).then_some(a as usize)
    }
}

/// The connected components of `mesh`, whose boundary is `boundary`.
///
/// Triangles are connected if they share a vertex, or two vertices that `boundary.copies` joins. That covers every edge
/// that two triangles share across a texture seam: each of the two uses a copy that the other does not, so both copies
/// have an unbalanced edge and stand in the list. Two closed sheets that only touch in a place, each with vertices of
/// its own, stay two components. Triangles with a corner that is not finite, or two corners at one place, are ignored:
/// they join nothing and are not counted. Areas are summed in the order of triangles. Takes O(n) in practice (union-find with
/// path halving), 4 bytes a vertex.
///
/// Source: algorithm note, section A.4.
#[must_use]
pub fn components(mesh: &TriMesh, boundary: &Boundary) -> Components {
    let mut parents = join_vertices(mesh, boundary);
    let mut number_of_root = vec![NONE; parents.len()];
    let mut list: Vec<Component> = Vec::new();
    for (face, &triangle) in mesh.triangles.iter().enumerate() {
        if !is_counted(mesh, face) {
            continue;
        }
        let root = root(&mut parents, triangle[0]) as usize;
        if number_of_root[root] == NONE {
            number_of_root[root] = list.len() as u32;
            list.push(Component::starting_at(FaceId(face as u32)));
        }
        list[number_of_root[root] as usize].add(mesh, face);
    }
    let vertices = 0..parents.len() as u32;
    let vertex_component = vertices.map(|v| number_of_root[root(&mut parents, v) as usize]).collect();
    Components { list, vertex_component }
}

impl Component {
    fn starting_at(first_face: FaceId) -> Self {
        Self { first_face, triangles: 0, area_m2: 0.0, bounds: Bounds::EMPTY }
    }

    fn add(&mut self, mesh: &TriMesh, face: usize) {
        let [a, b, c] = mesh.corners(face);
        self.triangles += 1;
        self.area_m2 += (b - a).cross(c - a).length() / 2.0;
        [a, b, c].into_iter().for_each(|p| self.bounds.add(p));
    }
}

/// True unless the boundary ignores the triangle too: a corner is not finite, or two are at the same place.
fn is_counted(mesh: &TriMesh, face: usize) -> bool {
    let [a, b, c] = mesh.corners(face);
    // Equal numbers are the same place: -0 equals 0, and NaN is not finite.
    a.is_finite() && b.is_finite() && c.is_finite() && a != b && b != c && c != a
}

/// Union-find over the vertices; the smallest vertex of a component becomes its root.
fn join_vertices(mesh: &TriMesh, boundary: &Boundary) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    // Reading every corner's position is what would cost most here.
    let may_be_ignored = boundary.defects.non_finite + boundary.defects.degenerate > 0;
    for (face, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if !may_be_ignored || is_counted(mesh, face) {
            join(&mut parents, a, b);
            join(&mut parents, b, c);
        }
    }
    for [copy, representative] in &boundary.copies {
        join(&mut parents, copy.0, representative.0);
    }
    parents
}

#[inline]
fn join(parents: &mut [u32], a: u32, b: u32) {
    if parents[a as usize] == parents[b as usize] {
        return; // nearly always so: saves looking up both roots
    }
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// The root of `v`; halves the path on its way.
#[inline]
fn root(parents: &mut [u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        let above = parents[parents[v as usize] as usize];
        parents[v as usize] = above;
        v = above;
    }
    v
}
