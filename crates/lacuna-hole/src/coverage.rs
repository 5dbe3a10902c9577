//! Border runs, rim chains and the part of the perimeter that a cell's own surface covers (algorithms note B.3, B.4).

use crate::label::Label;
use crate::{BorderFit, BorderMode, CellSurvey};
use lacuna_grid::{Domain, Side};
use lacuna_mesh::PointId;

/// Consecutive border edges of one loop on one side. They run clockwise: the perimeter parameter falls.
#[derive(Clone, Debug)]
pub(crate) struct BorderRun {
    pub(crate) side: Side,
    /// Boundary edges in loop order.
    pub(crate) edges: Vec<u32>,
    /// Lower and upper perimeter parameter.
    pub(crate) low_m: f64,
    pub(crate) high_m: f64,
    /// Number of edges of the whole loop: the outline of the cell is the longest.
    pub(crate) loop_edges: usize,
}

/// Where a rim chain begins or ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// On the border, at this perimeter parameter of this side.
    Border(Side, f64),
    /// At a cut inside the tile: its boundary edge next to the rim.
    Cut(u32),
}

/// A maximal run of rim edges of a loop that also has border or cut edges; the hole lies to its left.
#[derive(Clone, Debug)]
pub(crate) struct RimChain {
    pub(crate) edges: Vec<u32>,
    pub(crate) start: End,
    pub(crate) end: End,
    pub(crate) loop_edges: usize,
}

/// What the loops of one cell are made of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage {
    pub(crate) runs: Vec<BorderRun>,
    pub(crate) chains: Vec<RimChain>,
    /// Loops of rim edges alone.
    pub(crate) closed: Vec<u32>,
    /// Perimeter parameters where a rim touches the border in a single vertex.
    pub(crate) touches: Vec<f64>,
    /// Merged covered intervals of the perimeter, ascending; the last one may pass beyond the perimeter's end when it
    /// joins the first over the south-west corner.
    pub(crate) covered: Vec<(f64, f64)>,
}

/// Splits the loops of a cell into border runs, rim chains and closed loops, and merges the covered intervals.
pub(crate) fn coverage(survey: &CellSurvey, domain: &Domain, fit: &BorderFit, labels: &[Label]) -> Coverage {
    let mut result = Coverage::default();
    for (index, l) in survey.loops.iter().enumerate() {
        let label = |e: &u32| labels[*e as usize];
        if l.edges.iter().all(|e| label(e) == Label::Rim) {
            result.closed.push(index as u32);
            continue;
        }
        for run in runs_of(&l.edges, |e| label(&e)) {
            add_run(survey, domain, fit, labels, &l.edges, run, &mut result);
        }
    }
    result.covered = merge(&result.runs, &result.touches, domain.perimeter_m(), fit.gap_m);
    result
}

/// Maximal runs of equal labels on a cyclic list: (start, length).
fn runs_of(edges: &[u32], label: impl Fn(u32) -> Label) -> Vec<(usize, usize)> {
    let n = edges.len();
    let starts: Vec<usize> = (0..n).filter(|&k| label(edges[k]) != label(edges[(k + n - 1) % n])).collect();
    if starts.is_empty() {
        return vec![(0, n)];
    }
    (0..starts.len())
        .map(|k| (starts[k], (starts[(k + 1) % starts.len()] + n - starts[k] - 1) % n + 1))
        .collect()
}

fn add_run(
    survey: &CellSurvey,
    domain: &Domain,
    fit: &BorderFit,
    labels: &[Label],
    all: &[u32],
    (start, length): (usize, usize),
    result: &mut Coverage,
) {
    let n = all.len();
    let edges: Vec<u32> = (0..length).map(|k| all[(start + k) % n]).collect();
    match labels[edges[0] as usize] {
        Label::Border(side) => {
            let ends = [survey.from(edges[0]), survey.to(edges[length - 1])];
            let [a, b] = ends.map(|p| domain.parameter(side, p.truncate()));
            let inner = edges.iter().map(|&e| domain.parameter(side, survey.to(e).truncate()));
            let (low_m, high_m) = inner.fold((a.min(b), a.max(b)), |(l, h), s| (l.min(s), h.max(s)));
            result.runs.push(BorderRun { side, edges, low_m, high_m, loop_edges: n });
        }
        Label::Rim => {
            let end_at = |neighbour: usize, point: PointId| {
                let beyond = all[neighbour % n];
                match labels[beyond as usize] {
                    Label::Border(side) => {
                        End::Border(side, domain.parameter(side, survey.position(point).truncate()))
                    }
                    _ => End::Cut(beyond),
                }
            };
            let begin = survey.boundary.edges[edges[0] as usize].from;
            let finish = survey.boundary.edges[edges[length - 1] as usize].to;
            let whole = RimChain {
                start: end_at(start + n - 1, begin),
                end: end_at(start + length, finish),
                edges,
                loop_edges: n,
            };
            split_at_touches(survey, domain, fit, whole, result);
        }
        Label::Cut => {}
    }
}

/// Where a rim touches the border in a single vertex, nothing is open there: the hole ends on one side of the vertex and
/// another begins (algorithms note D.2, case 3). Only where tiles are cut on a line is a touch to be told from nearness.
fn split_at_touches(
    survey: &CellSurvey,
    domain: &Domain,
    fit: &BorderFit,
    mut chain: RimChain,
    result: &mut Coverage,
) {
    let on_line = matches!(fit.mode, BorderMode::Exact | BorderMode::Overrun);
    let touch = |edge: u32| {
        let place = survey.to(edge).truncate();
        let side = Side::ALL.into_iter().find(|&s| domain.outside_m(s, place).abs() <= fit.tolerance_m)?;
        Some((side, domain.parameter(side, place)))
    };
    let inner = chain.edges.len().saturating_sub(1);
    let touches: Vec<(usize, Side, f64)> = (0..inner)
        .filter(|_| on_line)
        .filter_map(|k| touch(chain.edges[k]).map(|(side, s)| (k + 1, side, s)))
        .collect();
    for (at, side, s) in touches.into_iter().rev() {
        let edges = chain.edges.split_off(at);
        let start = End::Border(side, s);
        result.chains.push(RimChain { edges, start, end: chain.end, loop_edges: chain.loop_edges });
        chain.end = start;
        result.touches.push(s);
    }
    result.chains.push(chain);
}

/// Union of the runs' intervals on the circle, gaps up to `gap_m` closed.
fn merge(runs: &[BorderRun], touches: &[f64], perimeter_m: f64, gap_m: f64) -> Vec<(f64, f64)> {
    let mut intervals: Vec<(f64, f64)> = runs.iter().map(|r| (r.low_m, r.high_m)).collect();
    intervals.extend(touches.iter().map(|&s| (s, s)));
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (low, high) in intervals {
        match merged.last_mut() {
            Some(last) if low <= last.1 + gap_m => last.1 = last.1.max(high),
            _ => merged.push((low, high)),
        }
    }
    // Over the south-west corner: the first interval continues the last one.
    if merged.len() > 1 {
        let first = merged[0];
        if let Some(last) = merged.last_mut()
            && first.0 + perimeter_m <= last.1 + gap_m
        {
            last.1 = last.1.max(first.1 + perimeter_m);
            merged.remove(0);
        }
    }
    merged
}

/// The uncovered intervals of the perimeter, each from a chain's end to the next chain's start, counter-clockwise:
/// `(from, to)` with `to > from`, possibly beyond the perimeter's end.
pub(crate) fn uncovered(covered: &[(f64, f64)], perimeter_m: f64, gap_m: f64) -> Vec<(f64, f64)> {
    let n = covered.len();
    let mut gaps = Vec::new();
    for k in 0..n {
        let from = covered[k].1;
        let to = if k + 1 < n { covered[k + 1].0 } else { covered[0].0 + perimeter_m };
        if to - from > gap_m {
            gaps.push((from, to));
        }
    }
    gaps
}
