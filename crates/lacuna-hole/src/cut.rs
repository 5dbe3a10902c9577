//! Cuts inside a tile: its sub-blocks end on common axis-parallel planes and do not weld (algorithms note B.1, formats
//! note section 3). Their edges are no rims.

use crate::box_tree::BoxTree;
use crate::label::Label;
use crate::{BorderFit, CellSurvey};
use glam::DVec3;
use lacuna_mesh::Bounds;
use std::collections::BTreeMap;

/// A coordinate of this precision is "in a plane", metres.
const PLANE_M: f64 = 0.002;
/// Least number of edges in a plane that make it a cut.
const LEAST_EDGES: usize = 3;

/// One boundary edge in an axis-parallel plane.
struct PlanarEdge {
    edge: u32,
    /// The plane's number: its coordinate in units of `PLANE_M`.
    plane: i64,
    from: DVec3,
    to: DVec3,
}

/// Relabels rim edges that lie on a cut inside the tile.
///
/// Steps: group rim edges by axis and plane; a group of at least three edges is a cut where edges of another group of
/// the same axis, or of the same plane, lie within `cut_gap_m` and the triangles behind lie on the other side.
pub(crate) fn mark_cuts(survey: &CellSurvey, fit: &BorderFit, labels: &mut [Label]) {
    for axis in 0..3 {
        let edges = planar_edges(survey, labels, axis);
        for edge in facing_edges(survey, &edges, axis, cut_gap(survey, fit)) {
            labels[edge as usize] = Label::Cut;
        }
    }
}

/// How far the two sides of a cut lie apart at most: sub-blocks overrun their plane as tiles overrun their cell.
fn cut_gap(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (3.0 * fit.margin_m).max(0.4 * survey.median_edge_m)
}

/// How far two rim ends may lie apart to be joined over a cut.
pub(crate) fn bridge_reach(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (6.0 * fit.margin_m).max(survey.median_edge_m)
}

/// Rim edges that lie in a plane across `axis` with others, by plane.
fn planar_edges(survey: &CellSurvey, labels: &[Label], axis: usize) -> Vec<PlanarEdge> {
    let mut planes: BTreeMap<i64, Vec<PlanarEdge>> = BTreeMap::new();
    for edge in (0..labels.len() as u32).filter(|&e| labels[e as usize] == Label::Rim) {
        let (from, to) = (survey.from(edge), survey.to(edge));
        if (from[axis] - to[axis]).abs() <= PLANE_M {
            let plane = (from[axis] / PLANE_M).round() as i64;
            planes.entry(plane).or_default().push(PlanarEdge { edge, plane, from, to });
        }
    }
    planes.into_values().filter(|edges| edges.len() >= LEAST_EDGES).flatten().collect()
}

/// The edges that face others in a plane within the gap: near in the other two axes, surface on the other side.
fn facing_edges(survey: &CellSurvey, edges: &[PlanarEdge], axis: usize, gap_m: f64) -> Vec<u32> {
    let reach = (gap_m / PLANE_M).ceil() as i64;
    let slack_m = gap_m.max(0.5 * survey.median_edge_m);
    let tree = BoxTree::new(edges.iter().map(PlanarEdge::bounds));
    let side = |e: &PlanarEdge| {
        let apex = survey.boundary.edges[e.edge as usize].apex;
        (apex[axis] - e.from[axis]).signum()
    };
    let faces = |e: &PlanarEdge, o: &PlanarEdge| {
        let is_near = e.plane.saturating_sub(o.plane).saturating_abs() <= reach;
        let opposite = side(e) * side(o) < 0.0;
        let against = (e.to - e.from).dot(o.to - o.from) < 0.0;
        is_near && opposite && against && run_side_by_side(e, o, axis, slack_m)
    };
    // Numbers of planes are rounded, and an edge leaves its plane by up to as much.
    let around_m = slack_m + 4.0 * PLANE_M;
    let is_cut = |e: &&PlanarEdge| {
        let box_m = e.bounds();
        let around = Bounds { min: box_m.min - around_m, max: box_m.max + around_m };
        tree.touching(&around).into_iter().any(|k| edges[k].edge != e.edge && faces(e, &edges[k]))
    };
    edges.iter().filter(is_cut).map(|e| e.edge).collect()
}

impl PlanarEdge {
    fn bounds(&self) -> Bounds {
        Bounds { min: self.from.min(self.to), max: self.from.max(self.to) }
    }
}

/// True if two edges run side by side within the plane: along their longer direction they share a quarter of the shorter
/// one, across it they lie within `slack_m`.
fn run_side_by_side(a: &PlanarEdge, b: &PlanarEdge, axis: usize, slack_m: f64) -> bool {
    let span = |e: &PlanarEdge, k: usize| (e.from[k].min(e.to[k]), e.from[k].max(e.to[k]));
    let length = |e: &PlanarEdge, k: usize| span(e, k).1 - span(e, k).0;
    let shared = |k: usize| span(a, k).1.min(span(b, k).1) - span(a, k).0.max(span(b, k).0);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (along, across) =
        if length(a, u) + length(b, u) >= length(a, v) + length(b, v) { (u, v) } else { (v, u) };
    shared(along) >= 0.25 * length(a, along).min(length(b, along)).max(PLANE_M) && shared(across) >= -slack_m
}
