//! Borders seen from both cells: where a hole meets the neighbour's surface, the neighbour's hole, or the area's edge
//! (algorithms note B.3).

use crate::CellSurvey;
use crate::box_tree::BoxTree;
use crate::coverage::{BorderRun, Coverage};
use crate::fit::{BorderFit, BorderMode};
use crate::plan::{Anchor, Curve, CurveKind, Leave, Span};
use glam::DVec3;
use lacuna_grid::{CellId, Domain, Side, SideLabel};
use lacuna_mesh::Bounds;
use std::collections::BTreeMap;

/// A hole's stretch of one side, counter-clockwise.
#[derive(Clone, Debug)]
pub(crate) struct SidePiece {
    pub(crate) hole: usize,
    pub(crate) cell: CellId,
    pub(crate) side: Side,
    /// Coordinate along the side, low < high.
    pub(crate) low_m: f64,
    pub(crate) high_m: f64,
    /// What stands at the low and at the high end.
    pub(crate) low: Anchor,
    pub(crate) high: Anchor,
    /// Positions of the rim vertices at the ends, where there are any.
    pub(crate) end_positions: Vec<DVec3>,
}

/// What the shared pass may read of a cell.
pub(crate) struct CellView<'a> {
    pub(crate) survey: &'a CellSurvey,
    pub(crate) domain: &'a Domain,
    pub(crate) coverage: &'a Coverage,
    /// Border runs of each side, and the intervals that they cover.
    sides: [(Vec<&'a BorderRun>, BoxTree); 4],
}

impl<'a> CellView<'a> {
    pub(crate) fn new(survey: &'a CellSurvey, domain: &'a Domain, coverage: &'a Coverage) -> Self {
        let sides = Side::ALL.map(|side| {
            let runs: Vec<&BorderRun> = coverage.runs.iter().filter(|r| r.side == side).collect();
            let tree = BoxTree::new(runs.iter().map(|r| interval(along_interval(domain, r))));
            (runs, tree)
        });
        Self { survey, domain, coverage, sides }
    }

    /// The border runs of a side that reach to within `slack_m` of a stretch, in the order of the coverage.
    fn runs_near(&self, side: Side, low_m: f64, high_m: f64, slack_m: f64) -> Vec<&'a BorderRun> {
        let (runs, tree) = &self.sides[side.index()];
        let near = tree.touching(&interval((low_m - slack_m, high_m + slack_m)));
        near.into_iter().map(|k| runs[k]).collect()
    }
}

/// An interval as a box.
fn interval((low_m, high_m): (f64, f64)) -> Bounds {
    Bounds { min: DVec3::X * low_m, max: DVec3::X * high_m }
}

/// Spans of every side piece (in the order of `pieces`), the curves, and why a piece can't be closed.
#[derive(Default)]
pub(crate) struct Shared {
    pub(crate) spans: Vec<Vec<Span>>,
    pub(crate) curves: Vec<Curve>,
    pub(crate) leaves: Vec<Option<Leave>>,
    /// Pairs of holes that share an open stretch.
    pub(crate) joined: Vec<(usize, usize)>,
}

/// Splits every side piece into adopted stretches and closing curves; both cells of a border name the same curve.
pub(crate) fn share(pieces: &[SidePiece], cells: &BTreeMap<CellId, CellView<'_>>, fit: &BorderFit) -> Shared {
    let mut result = Shared::default();
    let mut by_side: BTreeMap<(CellId, Side), Vec<usize>> = BTreeMap::new();
    for (k, p) in pieces.iter().enumerate() {
        by_side.entry((p.cell, p.side)).or_default().push(k);
    }
    let by_side: BTreeMap<(CellId, Side), (Vec<usize>, BoxTree)> = by_side
        .into_iter()
        .map(|(side, list)| {
            let tree = BoxTree::new(list.iter().map(|&k| interval((pieces[k].low_m, pieces[k].high_m))));
            (side, (list, tree))
        })
        .collect();
    // (piece, piece of the neighbour) -> curve
    let mut both_open: BTreeMap<(usize, usize), u32> = BTreeMap::new();
    for (k, p) in pieces.iter().enumerate() {
        let domain = cells[&p.cell].domain;
        let (spans, leave) = match domain.side(p.side).label {
            SideLabel::External => {
                let curve = push_curve(&mut result.curves, external_curve(domain, p));
                (vec![Span::Curve(curve)], None)
            }
            SideLabel::Neighbour(other) => {
                let facing =
                    by_side.get(&(other, p.side.opposite())).map_or_else(Vec::new, |(list, tree)| {
                        tree.touching(&interval((p.low_m, p.high_m))).into_iter().map(|f| list[f]).collect()
                    });
                let opens = open_stretches(k, &facing, pieces, fit, domain, &mut both_open, &mut result);
                closed_and_open(
                    p,
                    &opens,
                    domain.side(p.side).line,
                    cells.get(&other),
                    fit,
                    &mut result.curves,
                )
            }
        };
        result.spans.push(spans);
        result.leaves.push(leave);
    }
    result
}

fn push_curve(curves: &mut Vec<Curve>, curve: Curve) -> u32 {
    curves.push(curve);
    (curves.len() - 1) as u32
}

fn external_curve(domain: &Domain, p: &SidePiece) -> Curve {
    Curve {
        border: domain.border(p.side),
        kind: CurveKind::External,
        line: domain.side(p.side).line,
        low_m: p.low_m,
        high_m: p.high_m,
        low: p.low,
        high: p.high,
        holes: vec![p.hole as u32],
        over: Vec::new(),
    }
}

/// The stretches of piece `k` where the neighbour is open too: (low, high, curve), ascending.
fn open_stretches(
    k: usize,
    facing: &[usize],
    pieces: &[SidePiece],
    fit: &BorderFit,
    domain: &Domain,
    both_open: &mut BTreeMap<(usize, usize), u32>,
    result: &mut Shared,
) -> Vec<(f64, f64, u32)> {
    let p = &pieces[k];
    let mut opens = Vec::new();
    for &f in facing {
        let q = &pieces[f];
        let (low_m, high_m) = (p.low_m.max(q.low_m), p.high_m.min(q.high_m));
        if high_m - low_m <= fit.tolerance_m.max(1e-9) {
            continue;
        }
        let curve = *both_open.entry((k.min(f), k.max(f))).or_insert_with(|| {
            result.joined.push((p.hole.min(q.hole), p.hole.max(q.hole)));
            let curve = Curve {
                border: domain.border(p.side),
                kind: CurveKind::Shared,
                line: domain.side(p.side).line,
                low_m,
                high_m,
                low: inner_anchor(p.low_m, p.low, q.low_m, q.low, fit),
                high: inner_anchor(-p.high_m, p.high, -q.high_m, q.high, fit),
                holes: vec![p.hole as u32, q.hole as u32],
                over: Vec::new(),
            };
            push_curve(&mut result.curves, curve)
        });
        opens.push((low_m, high_m, curve));
    }
    opens.sort_by(|a, b| a.0.total_cmp(&b.0));
    opens
}

/// Of two ends of one stretch the one farther in; where both lie together a vertex goes before a bare corner. Where tiles
/// are not cut on the line, two vertices are never at one place: from the outer one the contour of the other cell would
/// run back over its own surface.
fn inner_anchor(a_m: f64, a: Anchor, b_m: f64, b: Anchor, fit: &BorderFit) -> Anchor {
    let is_cut_on_line = matches!(fit.mode, BorderMode::Exact | BorderMode::Overrun);
    let are_vertices = matches!((a, b), (Anchor::Point(..), Anchor::Point(..)));
    let together_m = if are_vertices && !is_cut_on_line { 0.0 } else { fit.tolerance_m };
    if a_m > b_m + together_m {
        return a;
    }
    if b_m > a_m + together_m {
        return b;
    }
    // The same for both cells of the border: vertices by cell, then number.
    match (a, b) {
        (Anchor::Corner(_), _) => b,
        (_, Anchor::Corner(_)) => a,
        _ => a.min(b),
    }
}

/// The spans of a piece in walking order: its open stretches, and between them what the neighbour covers.
fn closed_and_open(
    p: &SidePiece,
    opens: &[(f64, f64, u32)],
    line: f64,
    other: Option<&CellView<'_>>,
    fit: &BorderFit,
    curves: &mut Vec<Curve>,
) -> (Vec<Span>, Option<Leave>) {
    let mut spans = Vec::new();
    let mut leave = None;
    let mut at = p.low_m;
    let stops = opens.iter().map(|o| (o.0, Some(*o))).chain([(p.high_m, None)]);
    for (until, open) in stops {
        if until - at > fit.tolerance_m {
            match cover(p, at, until, line, other, fit, curves) {
                Ok(span) => spans.push(span),
                Err(reason) => leave = Some(reason),
            }
        }
        if let Some((_, high_m, curve)) = open {
            spans.push(Span::Curve(curve));
            at = high_m;
        }
    }
    if !p.side.runs_upward() {
        spans.reverse();
    }
    (spans, leave)
}

/// What closes the hole where the neighbour has surface: its border vertices, or (where tiles do not share vertices) a
/// curve over its surface.
fn cover(
    p: &SidePiece,
    low_m: f64,
    high_m: f64,
    line: f64,
    other: Option<&CellView<'_>>,
    fit: &BorderFit,
    curves: &mut Vec<Curve>,
) -> Result<Span, Leave> {
    let Some(other) = other else { return Err(Leave::BadNeighbour) };
    let side = p.side.opposite();
    let reach = covered_length(other, side, low_m, high_m);
    if high_m - low_m - reach > (3.0 * fit.gap_m).max(3.0 * fit.edge_m).min(0.5 * (high_m - low_m)) {
        return Err(Leave::UnmatchedBorder);
    }
    if fit.mode == BorderMode::Exact || fit.mode == BorderMode::Ragged {
        let start = if p.side.runs_upward() { (low_m, high_m) } else { (high_m, low_m) };
        return Ok(Span::Adopted { neighbour: other.domain.cell, edges: adopt(p, start, other, fit) });
    }
    let end = |m: f64, own_m: f64, own: Anchor| {
        if (m - own_m).abs() <= fit.tolerance_m { own } else { Anchor::Free }
    };
    let curve = Curve {
        border: other.domain.border(side),
        kind: CurveKind::OverNeighbour(other.domain.cell),
        line,
        low_m,
        high_m,
        low: end(low_m, p.low_m, p.low),
        high: end(high_m, p.high_m, p.high),
        holes: vec![p.hole as u32],
        over: edges_under(other, side, low_m, high_m, fit),
    };
    Ok(Span::Curve(push_curve(curves, curve)))
}

/// Length of `[low_m, high_m]` that border runs of the neighbour's side cover.
fn covered_length(other: &CellView<'_>, side: Side, low_m: f64, high_m: f64) -> f64 {
    let runs = other.runs_near(side, low_m, high_m, 0.0);
    let mut intervals: Vec<(f64, f64)> = runs.iter().map(|r| along_interval(other.domain, r)).collect();
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut at, mut sum) = (low_m, 0.0);
    for (low, high) in intervals {
        let (a, b) = (low.max(at), high.min(high_m));
        if b > a {
            sum += b - a;
            at = b;
        }
    }
    sum
}

/// Boundary edges of a side that reach into a stretch.
fn edges_under(other: &CellView<'_>, side: Side, low_m: f64, high_m: f64, fit: &BorderFit) -> Vec<u32> {
    let reaches = |e: &u32| {
        let [a, b] = [other.survey.from(*e), other.survey.to(*e)].map(|p| side.along(p.truncate()));
        a.min(b) <= high_m && a.max(b) >= low_m
    };
    let runs = other.runs_near(side, low_m, high_m, fit.gap_m);
    runs.iter().flat_map(|r| r.edges.iter().copied()).filter(reaches).collect()
}

/// Interval of a run in the coordinate along its side.
fn along_interval(domain: &Domain, run: &BorderRun) -> (f64, f64) {
    let ends = [run.low_m, run.high_m].map(|s| run.side.along(domain.point(run.side, s)));
    (ends[0].min(ends[1]), ends[0].max(ends[1]))
}

/// The neighbour's boundary edges along a stretch, in the hole's walking direction (which is the neighbour's own).
fn adopt(p: &SidePiece, (from_m, to_m): (f64, f64), other: &CellView<'_>, fit: &BorderFit) -> Vec<u32> {
    let direction = (to_m - from_m).signum();
    let along = |point: DVec3| direction * p.side.along(point.truncate());
    let (from, to) = (direction * from_m, direction * to_m);
    let slack_m = fit.gap_m + fit.tolerance_m;
    let mut runs = other.runs_near(p.side.opposite(), from_m.min(to_m), from_m.max(to_m), slack_m);
    runs.sort_by(|a, b| b.loop_edges.cmp(&a.loop_edges).then(a.low_m.total_cmp(&b.low_m)));
    let mut chosen: Vec<(f64, f64, Vec<u32>)> = Vec::new();
    for run in runs {
        let edges = trim(&run.edges, other.survey, along, from, to, fit.tolerance_m, p);
        let (Some(&first), Some(&last)) = (edges.first(), edges.last()) else { continue };
        let (a, b) = (along(other.survey.from(first)), along(other.survey.to(last)));
        let overlaps = chosen.iter().any(|c| b.min(c.1) - a.max(c.0) > fit.tolerance_m);
        if !overlaps {
            chosen.push((a, b, edges));
        }
    }
    chosen.sort_by(|x, y| x.0.total_cmp(&y.0));
    chosen.into_iter().flat_map(|c| c.2).collect()
}

/// The part of a run between two parameters. Where it reaches beyond, it starts (ends) at the vertex that stands at the
/// same place as the piece's own end, else at the first (last) one inside.
fn trim(
    edges: &[u32],
    survey: &CellSurvey,
    along: impl Fn(DVec3) -> f64,
    from: f64,
    to: f64,
    tolerance_m: f64,
    p: &SidePiece,
) -> Vec<u32> {
    let mut points: Vec<DVec3> = vec![survey.from(edges[0])];
    points.extend(edges.iter().map(|&e| survey.to(e)));
    let own = &p.end_positions;
    let inside = |u: f64| u > from + tolerance_m && u < to - tolerance_m;
    let near = |u: f64, end: f64| (u - end).abs() <= tolerance_m;
    let usable = |k: usize| {
        let u = along(points[k]);
        let at_end = near(u, from) || near(u, to);
        // At an end of the piece only the vertex that both cells have counts, or any if the cell has none there.
        inside(u)
            || (at_end
                && (own.is_empty() || own.iter().any(|o| *o == points[k]) || is_extreme(k, points.len())))
    };
    let first = (0..points.len()).find(|&k| usable(k));
    let last = (0..points.len()).rev().find(|&k| usable(k));
    match (first, last) {
        (Some(a), Some(b)) if b > a => edges[a..b].to_vec(),
        _ => Vec::new(),
    }
}

/// The run's own first and last vertices stand where its surface ends.
fn is_extreme(k: usize, count: usize) -> bool {
    k == 0 || k + 1 == count
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_grid::CornerId;

    #[test]
    fn the_inner_end_counts_where_tiles_are_not_cut_on_the_line() {
        let [first, second] =
            [1, 2].map(|point| Anchor::Point(CellId::new(0, 0), lacuna_mesh::PointId(point)));
        let corner = Anchor::Corner(CornerId { j: 0, i: 0 });
        for (name, mode, a, b, expected) in [
            ("ragged, the second farther in", BorderMode::Ragged, (0.0, first), (0.4, second), second),
            ("ragged, the first farther in", BorderMode::Ragged, (0.4, first), (0.0, second), first),
            ("ragged, a corner is no vertex", BorderMode::Ragged, (0.4, corner), (0.0, second), second),
            ("exact, at one place", BorderMode::Exact, (0.0, first), (0.4, second), first),
            ("exact, apart", BorderMode::Exact, (0.0, first), (2.0, second), second),
        ] {
            let fit =
                BorderFit { mode, margin_m: 0.0, tolerance_m: 1.0, gap_m: 2.0, absorb_m: 2.0, edge_m: 1.0 };
            assert_eq!(inner_anchor(a.0, a.1, b.0, b.1, &fit), expected, "{name}");
        }
    }
}
