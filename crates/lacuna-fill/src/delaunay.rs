//! Constrained Delaunay triangulation of simple rings.

use crate::FillError;
use crate::error::Crossing;
use crate::topology::{NONE, Topology};
use glam::DVec2;
use spade::handles::{FixedFaceHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};
use std::collections::VecDeque;

/// Triangulates what the rings enclose, every ring edge a constraint: faces reached from outside over an odd number of
/// constraints, so islands stay empty. No vertex is added.
///
/// `rings` hold indices into `points`; they must be simple and apart from each other but for vertices in which they
/// touch, which have one index in all rings, and properly nested. Triangles are counter-clockwise and sorted, so equal
/// input gives equal output; each ring edge has one triangle, on its left.
///
/// # Errors
/// [`FillError::CrossingRim`] if an edge is refused as a constraint, two vertices share a place, or rings cross in a
/// common vertex; [`FillError::Malformed`] for coordinates out of range.
pub(crate) fn triangulate(points: &[DVec2], rings: &[Vec<u32>]) -> Result<Topology, FillError> {
    let (used, edges) = number_through(points.len(), rings);
    let places: Vec<Point2<f64>> =
        used.iter().map(|&v| Point2::new(points[v as usize].x, points[v as usize].y)).collect();
    let mut cdt = Triangulated::new();
    let handles = insert_coarse_to_fine(&mut cdt, &places)?;
    if cdt.num_vertices() != used.len() {
        return Err(crossing(used[0]));
    }
    for [from, to] in &edges {
        if cdt.try_add_constraint(handles[*from], handles[*to]).is_empty() {
            return Err(crossing(used[*from]));
        }
    }
    if cdt.num_constraints() != edges.len() {
        return Err(crossing(used[0]));
    }
    let mut vertex = vec![0; used.len()];
    handles.iter().zip(&used).for_each(|(handle, &v)| vertex[handle.index()] = v);
    let topology = Topology::new(&inner_triangles(&cdt, &vertex));
    check_boundary(&topology, rings)?;
    Ok(topology)
}

type Triangulated = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Inserts every 2^k-th place first, then those half-way between, and so on, each with the place before it as a hint.
/// A ring's neighbours are near each other, so the walk to each place is short and few edges are flipped; insertion by
/// distance from the middle takes quadratic time on long rings.
fn insert_coarse_to_fine(
    cdt: &mut Triangulated,
    places: &[Point2<f64>],
) -> Result<Vec<FixedVertexHandle>, FillError> {
    let malformed = |e: InsertionError| FillError::Malformed { what: e.to_string() };
    let Some(&first) = places.first() else { return Ok(vec![]) };
    let mut handles = vec![cdt.insert(first).map_err(malformed)?; places.len()];
    let mut stride = places.len().next_power_of_two();
    while stride > 1 {
        let step = stride / 2;
        for i in (step..places.len()).step_by(stride) {
            handles[i] = cdt.insert_with_hint(places[i], handles[i - step]).map_err(malformed)?;
        }
        stride = step;
    }
    Ok(handles)
}

fn crossing(vertex: u32) -> FillError {
    FillError::crossing(vertex, Crossing::InVertex)
}

/// The vertices of the rings, each once, in the order in which rings meet them; ring edges as pairs of places there.
fn number_through(count: usize, rings: &[Vec<u32>]) -> (Vec<u32>, Vec<[usize; 2]>) {
    let (mut used, mut number) = (vec![], vec![NONE; count]);
    for &v in rings.iter().flatten() {
        if number[v as usize] == NONE {
            number[v as usize] = used.len() as u32;
            used.push(v);
        }
    }
    let edges = ring_edges(rings).map(|edge| edge.map(|v| number[v as usize] as usize)).collect();
    (used, edges)
}

fn ring_edges(rings: &[Vec<u32>]) -> impl Iterator<Item = [u32; 2]> + '_ {
    rings.iter().flat_map(|ring| (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]))
}

/// Rings that touch without crossing have the surface on their left all along.
fn check_boundary(topology: &Topology, rings: &[Vec<u32>]) -> Result<(), FillError> {
    let open = (0..topology.origin.len() as u32).filter(|&h| topology.twin(h).is_none());
    let mut found: Vec<[u32; 2]> = open.map(|h| [topology.start(h), topology.end(h)]).collect();
    let mut wanted: Vec<[u32; 2]> = ring_edges(rings).collect();
    found.sort_unstable();
    wanted.sort_unstable();
    match wanted.iter().zip(&found).find(|(wanted, found)| wanted != found) {
        Some((edge, _)) => Err(crossing(edge[0])),
        None if found.len() != wanted.len() => Err(crossing(wanted[0][0])),
        None => Ok(()),
    }
}

fn inner_triangles(cdt: &Triangulated, vertex: &[u32]) -> Vec<[u32; 3]> {
    let inside = parity_from_outside(cdt);
    let mut triangles: Vec<[u32; 3]> = cdt
        .inner_faces()
        .filter(|f| inside[f.fix().index()] == Some(true))
        .map(|f| smallest_first(f.vertices().map(|v| vertex[v.fix().index()])))
        .collect();
    triangles.sort_unstable();
    triangles
}

/// For each face whether an odd number of constraints lies between it and the outer face.
fn parity_from_outside(cdt: &Triangulated) -> Vec<Option<bool>> {
    let mut inside = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face().fix();
    inside[outer.index()] = Some(false);
    let mut queue: VecDeque<FixedFaceHandle<_>> = VecDeque::new();
    for edge in cdt.directed_edges().filter(|e| e.face().fix() == outer) {
        let face = edge.rev().face().fix();
        if inside[face.index()].is_none() {
            inside[face.index()] = Some(edge.is_constraint_edge());
            queue.push_back(face);
        }
    }
    while let Some(face) = queue.pop_front() {
        let here = inside[face.index()] == Some(true);
        let Some(inner) = cdt.face(face).as_inner() else { continue };
        for edge in inner.adjacent_edges() {
            let other = edge.rev().face().fix();
            if inside[other.index()].is_none() {
                inside[other.index()] = Some(here ^ edge.is_constraint_edge());
                queue.push_back(other);
            }
        }
    }
    inside
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn islands_stay_empty_and_crossings_are_refused() {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let mut points = vec![at(0., 0.), at(9., 0.), at(9., 9.), at(0., 9.)];
        points.extend([at(3., 3.), at(3., 6.), at(6., 6.), at(6., 3.)]);
        let done = triangulate(&points, &[vec![0, 1, 2, 3], vec![4, 5, 6, 7]]).unwrap();
        assert_eq!(done.triangle_count(), 8);
        let refused = triangulate(&points, &[vec![0, 2, 1, 3]]);
        assert!(matches!(refused, Err(FillError::CrossingRim { .. })));
    }
}
