//! The exact stage: counts the candidates' edges and says which half-edges are on the boundary.

use super::flagged::{Candidate, UNFLAGGED};
use super::{BoundaryEdge, BoundaryKind, Defects};
use crate::{FaceId, PointId, TriMesh};
use glam::DVec3;

/// Above this many pairs of triangles on one edge the best pairs aren't searched any more: they are matched by id.
const MOST_PAIRS: usize = 4096;

/// One triangle's use of an undirected edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeUse {
    low: u32,
    high: u32,
    /// The triangle runs from the higher to the lower place.
    is_downward: bool,
    face: u32,
    /// The corner opposite to the edge, 0..3.
    apex: u8,
}

/// The boundary edges of the candidates (without those numbered in `left_out`, sorted), ends as place numbers.
/// An undirected edge gives as many as its two directions differ.
pub(super) fn boundary_edges(
    mesh: &TriMesh,
    candidates: &[Candidate],
    left_out: &[usize],
    defects: &mut Defects,
) -> Vec<BoundaryEdge> {
    let mut uses = edge_uses(candidates, left_out);
    uses.sort_unstable();
    let mut edges = Vec::new();
    for edge in uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
        let (up, down) = edge.split_at(edge.partition_point(|u| !u.is_downward));
        let (more, fewer) = if up.len() > down.len() { (up, down) } else { (down, up) };
        let kind = match (more.len(), fewer.len()) {
            (m, f) if m == f => continue,
            (1, 0) => BoundaryKind::Simple,
            (2, 0) => BoundaryKind::Conflict,
            _ => BoundaryKind::NonManifold,
        };
        defects.conflict_edges += u64::from(kind == BoundaryKind::Conflict);
        defects.non_manifold_edges += u64::from(kind == BoundaryKind::NonManifold);
        edges.extend(unmatched(mesh, more, fewer).into_iter().map(|u| u.boundary_edge(mesh, kind)));
    }
    edges
}

/// All uses of edges between two flagged places.
fn edge_uses(candidates: &[Candidate], left_out: &[usize]) -> Vec<EdgeUse> {
    let mut uses = Vec::with_capacity(candidates.len() * 2);
    let kept = candidates.iter().enumerate().filter(|(c, _)| left_out.binary_search(c).is_err());
    for (_, candidate) in kept {
        for i in 0..3u8 {
            let from = candidate.places[usize::from(i)];
            let to = candidate.places[usize::from(i + 1) % 3];
            if from != UNFLAGGED && to != UNFLAGGED {
                let (low, high) = (from.min(to), from.max(to));
                uses.push(EdgeUse {
                    low,
                    high,
                    is_downward: from > to,
                    face: candidate.face,
                    apex: (i + 2) % 3,
                });
            }
        }
    }
    uses
}

/// The uses in `more` that find no partner in `fewer`: partners are taken in the order of least bend, then of id.
fn unmatched(mesh: &TriMesh, more: &[EdgeUse], fewer: &[EdgeUse]) -> Vec<EdgeUse> {
    if fewer.is_empty() {
        return more.to_vec();
    }
    if more.len() * fewer.len() > MOST_PAIRS {
        return more[fewer.len()..].to_vec();
    }
    let mut pairs = Vec::new();
    for (i, m) in more.iter().enumerate() {
        for (j, f) in fewer.iter().enumerate() {
            pairs.push((-flatness(mesh, m.face, f.face), i, j));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut is_taken, mut is_served) = (vec![false; more.len()], vec![false; fewer.len()]);
    for (_, i, j) in pairs {
        if !is_taken[i] && !is_served[j] {
            (is_taken[i], is_served[j]) = (true, true);
        }
    }
    more.iter().zip(is_taken).filter(|&(_, taken)| !taken).map(|(&u, _)| u).collect()
}

/// Cosine of the angle between the normals of two triangles that run opposite along their edge: 1 = flat, -1 = folded.
fn flatness(mesh: &TriMesh, face: u32, other: u32) -> f64 {
    unit_normal(mesh, face).dot(unit_normal(mesh, other))
}

/// Unit normal, zero for a triangle without area.
fn unit_normal(mesh: &TriMesh, face: u32) -> DVec3 {
    let [a, b, c] = mesh.corners(face as usize);
    (b - a).cross(c - a).normalize_or_zero()
}

impl EdgeUse {
    /// The boundary edge of this use: against the direction of its triangle.
    fn boundary_edge(self, mesh: &TriMesh, kind: BoundaryKind) -> BoundaryEdge {
        let (from, to) = if self.is_downward { (self.low, self.high) } else { (self.high, self.low) };
        let apex = mesh.corners(self.face as usize)[usize::from(self.apex)];
        BoundaryEdge { from: PointId(from), to: PointId(to), face: FaceId(self.face), apex, kind }
    }
}
