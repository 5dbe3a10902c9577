//! Cuts inside a tile: its sub-blocks end on common axis-parallel planes and do not weld (algorithms note B.1, formats
//! note section 3). Their edges are no rims.

use crate::box_tree::BoxTree;
use crate::closed::{LoopKind, judge_loop};
use crate::label::Label;
use crate::{BorderFit, CellSurvey, LoopSurvey};
use glam::DVec3;
use lacuna_mesh::Bounds;
use std::collections::BTreeMap;

/// A coordinate of this precision is "in a plane", metres.
const PLANE_M: f64 = 0.002;
/// Least number of edges that make a plane, or what a loop has of it, a cut.
const LEAST_EDGES: usize = 3;
/// Cosine of the angle up to which two triangles face the same way: 60 degrees, blocks are simplified each on its own.
const SAME_WAY: f64 = 0.5;
/// Cosine from which two edges run against each other: the sides of a cut follow one line.
const AGAINST: f64 = -0.5;
/// The same for edges with a common vertex: there a cut ends in a tip, or a rim just turns.
const TIP: f64 = -0.9;

/// One boundary edge in an axis-parallel plane.
struct PlanarEdge {
    edge: u32,
    /// The plane's number: its coordinate in units of `PLANE_M`.
    plane: i64,
    from: DVec3,
    to: DVec3,
}

/// An edge that runs beside another one as the two sides of a cut do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacingEdge {
    /// The boundary edge on one side.
    pub(crate) edge: u32,
    /// The one on the other side.
    pub(crate) other: u32,
    /// True if both sides could be one sheet: their triangles face the same way.
    is_one_sheet: bool,
}

/// Relabels rim edges that lie on a cut inside the tile, and returns which face each other over it.
///
/// Steps: (1) group rim edges by axis and plane; edges of groups of three or more face each other where they run side by
/// side within `cut_gap`, the triangles behind on the two sides; (2) keep the edges whose run along their loop looks like
/// a cut, see `is_cut_run`; (3) drop those whose opposite edges are gone, until nothing changes.
pub(crate) fn mark_cuts(survey: &CellSurvey, fit: &BorderFit, labels: &mut [Label]) -> Vec<FacingEdge> {
    let mut facing: Vec<FacingEdge> = (0..3)
        .flat_map(|axis| {
            facing_edges(survey, &planar_edges(survey, labels, axis), axis, cut_gap(survey, fit))
        })
        .collect();
    loop {
        let before = facing.len();
        let is_kept = edges_of_cut_runs(survey, labels, &facing);
        facing.retain(|f| is_kept[f.edge as usize] && is_kept[f.other as usize]);
        if facing.len() == before {
            break;
        }
    }
    for f in &facing {
        labels[f.edge as usize] = Label::Cut;
    }
    facing
}

/// Least share of a run's length whose two sides are one sheet.
const LEAST_ONE_SHEET: f64 = 0.5;
/// Least share of a block's outline that runs along cuts where it reaches no border: more than two sides of a square.
const LEAST_OF_OUTLINE: f64 = 0.6;

/// For each boundary edge, true if it faces another one and is part of a run that may be a side of a cut.
fn edges_of_cut_runs(survey: &CellSurvey, labels: &[Label], facing: &[FacingEdge]) -> Vec<bool> {
    let mut is_facing = vec![false; labels.len()];
    let mut is_one_sheet = vec![false; labels.len()];
    for f in facing {
        is_facing[f.edge as usize] = true;
        is_one_sheet[f.edge as usize] |= f.is_one_sheet;
    }
    let mut is_kept = vec![false; labels.len()];
    for l in &survey.loops {
        let count = l.edges.iter().filter(|&&e| is_facing[e as usize]).count();
        if count < LEAST_EDGES || is_beside_by_chance(survey, labels, l, &is_facing) {
            continue;
        }
        for run in facing_runs(&l.edges, &is_facing) {
            let same = length_m(survey, run.iter().filter(|&&e| is_one_sheet[e as usize]));
            if same >= LEAST_ONE_SHEET * length_m(survey, &run) {
                run.iter().for_each(|&e| is_kept[e as usize] = true);
            }
        }
    }
    is_kept
}

/// True if a loop that does not touch the border faces others along too little of its length: the outline of a block
/// runs along cuts wherever it is not a rim, a fragment of surface beside a straight rim shows it one side.
fn is_beside_by_chance(survey: &CellSurvey, labels: &[Label], l: &LoopSurvey, is_facing: &[bool]) -> bool {
    let touches_border = l.edges.iter().any(|&e| matches!(labels[e as usize], Label::Border(_)));
    let facing_m = length_m(survey, l.edges.iter().filter(|&&e| is_facing[e as usize]));
    !touches_border && judge_loop(l) == LoopKind::Outline && facing_m < LEAST_OF_OUTLINE * l.length_m
}

fn length_m<'e>(survey: &CellSurvey, edges: impl IntoIterator<Item = &'e u32>) -> f64 {
    edges.into_iter().map(|&e| survey.from(e).distance(survey.to(e))).sum()
}

/// Maximal runs of facing edges on a loop.
fn facing_runs(edges: &[u32], is_facing: &[bool]) -> Vec<Vec<u32>> {
    let n = edges.len();
    let is = |k: usize| is_facing[edges[k % n] as usize];
    if (0..n).all(is) {
        return vec![edges.to_vec()];
    }
    let starts = (0..n).filter(|&k| is(k) && !is(k + n - 1));
    starts.map(|k| (k..k + n).take_while(|&i| is(i)).map(|i| edges[i % n]).collect()).collect()
}

/// How far the two sides of a cut lie apart at most: sub-blocks overrun their plane as tiles overrun their cell.
fn cut_gap(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (3.0 * fit.margin_m).max(0.4 * survey.median_edge_m)
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

/// Pairs of edges that face each other in planes within the gap: near in the other two axes, surface on the other side.
fn facing_edges(survey: &CellSurvey, edges: &[PlanarEdge], axis: usize, gap_m: f64) -> Vec<FacingEdge> {
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
        is_near && opposite && run_against(e, o) && run_side_by_side(e, o, axis, slack_m)
    };
    // Numbers of planes are rounded, and an edge leaves its plane by up to as much.
    let around_m = slack_m + 4.0 * PLANE_M;
    let mut found = Vec::new();
    for e in edges {
        let own = e.bounds();
        let around = Bounds { min: own.min - around_m, max: own.max + around_m };
        let others = tree.touching(&around).into_iter().map(|k| &edges[k]);
        found.extend(others.filter(|o| o.edge != e.edge && faces(e, o)).map(|o| FacingEdge {
            edge: e.edge,
            other: o.edge,
            is_one_sheet: is_one_sheet(survey, e.edge, o.edge),
        }));
    }
    found
}

/// True if the triangles behind two edges face the same way; those without area may.
fn is_one_sheet(survey: &CellSurvey, a: u32, b: u32) -> bool {
    let [m, n] = [a, b].map(|e| survey.normal_behind(e));
    m.dot(n) >= SAME_WAY || m == DVec3::ZERO || n == DVec3::ZERO
}

impl PlanarEdge {
    fn bounds(&self) -> Bounds {
        Bounds { min: self.from.min(self.to), max: self.from.max(self.to) }
    }
}

/// True if two edges have opposite directions, as the two sides of one line.
fn run_against(a: &PlanarEdge, b: &PlanarEdge) -> bool {
    let (along_a, along_b) = (a.to - a.from, b.to - b.from);
    let limit = if a.to == b.from || b.to == a.from { TIP } else { AGAINST };
    along_a.dot(along_b) < limit * along_a.length() * along_b.length()
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
