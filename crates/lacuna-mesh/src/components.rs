//! Connected components of a mesh.

use crate::{Boundary, FaceId, TriMesh};
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
    /// Sum of their areas in space, square metres; of a component of [`SMALL_TRIANGLES`] or more, where nobody takes it for
    /// debris, infinite: adding it up would read every position.
    pub area_m2: f64,
}

/// From this many triangles on a component's area is not added up.
pub const SMALL_TRIANGLES: usize = 64;

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
/// path halving), 8 bytes a vertex.
///
/// Source: algorithm note, section A.4.
#[must_use]
pub fn components(mesh: &TriMesh, boundary: &Boundary) -> Components {
    let roots = joined_vertices(mesh, boundary);
    let is_counted = counted(mesh, boundary);
    let mut number_of_root = vec![NONE; roots.len()];
    let mut list: Vec<Component> = Vec::new();
    for (face, triangle) in mesh.triangles.iter().enumerate().filter(|(face, _)| is_counted(*face)) {
        let number = &mut number_of_root[roots[triangle[0] as usize] as usize];
        if *number == NONE {
            *number = list.len() as u32;
            list.push(Component { first_face: FaceId(face as u32), triangles: 0, area_m2: 0.0 });
        }
        list[*number as usize].triangles += 1;
    }
    let vertex_component: Vec<u32> = roots.iter().map(|&root| number_of_root[root as usize]).collect();
    add_areas(mesh, &vertex_component, is_counted, &mut list);
    Components { list, vertex_component }
}

/// Adds up the areas of small components.
fn add_areas(
    mesh: &TriMesh,
    vertex_component: &[u32],
    is_counted: impl Fn(usize) -> bool,
    list: &mut [Component],
) {
    let is_small = |c: &Component| c.triangles < SMALL_TRIANGLES;
    list.iter_mut().filter(|c| !is_small(c)).for_each(|c| c.area_m2 = f64::INFINITY);
    if !list.iter().any(is_small) {
        return;
    }
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let component = list.get_mut(vertex_component[triangle[0] as usize] as usize);
        if let Some(component) = component.filter(|c| is_small(c) && is_counted(face)) {
            let [a, b, c] = mesh.corners(face);
            component.area_m2 += (b - a).cross(c - a).length() / 2.0;
        }
    }
}

/// What tells if a triangle counts. Reading every corner's position is what would cost most here: only where the boundary
/// ignored some does it do so.
fn counted<'a>(mesh: &'a TriMesh, boundary: &Boundary) -> impl Fn(usize) -> bool + Copy + 'a {
    let may_be_ignored = boundary.defects.non_finite + boundary.defects.degenerate > 0;
    move |face| !may_be_ignored || is_counted(mesh, face)
}

/// True unless the boundary ignores the triangle too: a corner is not finite, or two are at the same place.
fn is_counted(mesh: &TriMesh, face: usize) -> bool {
    let [a, b, c] = mesh.corners(face);
    // Equal numbers are the same place: -0 equals 0, and NaN is not finite.
    a.is_finite() && b.is_finite() && c.is_finite() && a != b && b != c && c != a
}

/// Union-find over the vertices: for each the smallest vertex of its component.
fn joined_vertices(mesh: &TriMesh, boundary: &Boundary) -> Vec<u32> {
    let is_counted = counted(mesh, boundary);
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for (face, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if is_counted(face) {
            join(&mut parents, a, b);
            join(&mut parents, b, c);
        }
    }
    for [copy, representative] in &boundary.copies {
        join(&mut parents, copy.0, representative.0);
    }
    // No parent is larger than its vertex.
    for v in 0..parents.len() {
        parents[v] = parents[parents[v] as usize];
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
