//! Which boundary edges lie on the border of the cell (algorithms note B.2).

use crate::{BorderFit, BorderMode, CellSurvey};
use lacuna_grid::{CellId, Domain, Side};

/// What a boundary edge is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    /// On a side of the domain.
    Border(Side),
    /// On a cut inside the tile whose two sides do not weld.
    Cut,
    /// On the rim of a hole, or the outline of a piece of surface.
    Rim,
}

/// Labels every boundary edge of a cell: border by distance (and direction where tiles are ragged), and what `closed` says
/// that another tile meets (sorted; empty where tiles are cut on a line); then short rim runs that never leave the border's
/// neighbourhood are absorbed.
pub(crate) fn label_edges(
    survey: &CellSurvey,
    domain: &Domain,
    fit: &BorderFit,
    closed: &[(CellId, u32)],
) -> Vec<Label> {
    let is_closed = |e: u32| closed.binary_search(&(survey.cell, e)).is_ok();
    let mut labels: Vec<Label> = (0..survey.boundary.edges.len() as u32)
        .map(|e| match border_side(survey, domain, fit, e) {
            Some(side) => Label::Border(side),
            None if is_closed(e) => Label::Border(nearer(survey, domain, e, &Side::ALL)),
            None => Label::Rim,
        })
        .collect();
    for l in &survey.loops {
        absorb(survey, domain, fit, &l.edges, &mut labels);
    }
    labels
}

/// The side of its cell that a boundary edge lies on by distance and direction; the nearest of several.
pub(crate) fn border_side(survey: &CellSurvey, domain: &Domain, fit: &BorderFit, edge: u32) -> Option<Side> {
    let (a, b) = (survey.from(edge).truncate(), survey.to(edge).truncate());
    let far = |side: Side| {
        let offsets = [domain.outside_m(side, a), domain.outside_m(side, b)];
        // Beyond the line counts as on it where tiles reach into their neighbours.
        let beyond = fit.mode == BorderMode::Overlap;
        offsets.map(|o| if beyond { (-o).max(0.0) } else { o.abs() }).into_iter().fold(0.0, f64::max)
    };
    let exact = matches!(fit.mode, BorderMode::Exact | BorderMode::Overrun);
    let direction = (b - a).normalize_or_zero();
    // At a corner an edge is near to two sides: the one that it runs along counts.
    let runs_along = |side: Side| exact || direction.perp_dot(side.outward()).abs() >= 0.7;
    Side::ALL
        .into_iter()
        .filter(|&s| far(s) <= fit.tolerance_m && runs_along(s))
        .min_by(|x, y| far(*x).total_cmp(&far(*y)))
}

/// Rim runs between border runs become border if they never leave the line, or if they stay near to it and are shorter
/// than three edges, or begin and end so close together (on one side) that the gap counts as covered.
fn absorb(survey: &CellSurvey, domain: &Domain, fit: &BorderFit, edges: &[u32], labels: &mut [Label]) {
    let n = edges.len();
    let Some(first) = edges.iter().position(|&e| matches!(labels[e as usize], Label::Border(_))) else {
        return;
    };
    let mut k = 0;
    while k < n {
        let at = |i: usize| edges[(first + i) % n];
        let Label::Border(before) = labels[at(k) as usize] else {
            k += 1;
            continue;
        };
        let run = (k + 1..=n).take_while(|&i| labels[at(i) as usize] == Label::Rim).count();
        let run_edges: Vec<u32> = (k + 1..=k + run).map(at).collect();
        if run > 0
            && let Label::Border(after) = labels[at(k + run + 1) as usize]
            && is_noise(survey, domain, fit, &run_edges, [before, after])
        {
            for e in run_edges {
                labels[e as usize] = Label::Border(nearer(survey, domain, e, &[before, after]));
            }
        }
        k += run + 1;
    }
}

/// True if a run of rim edges between border runs of two sides (mostly the same) is roughness of the cut.
fn is_noise(
    survey: &CellSurvey,
    domain: &Domain,
    fit: &BorderFit,
    run: &[u32],
    [before, after]: [Side; 2],
) -> bool {
    let off = |e: u32, side: Side| domain.outside_m(side, survey.to(e).truncate()).abs();
    let farthest = run.iter().map(|&e| off(e, before).min(off(e, after))).fold(0.0, f64::max);
    let length: f64 = run.iter().map(|&e| survey.from(e).distance(survey.to(e))).sum();
    let is_short = length < 3.0 * fit.edge_m.max(survey.median_edge_m);
    let (Some(&first), Some(&last)) = (run.first(), run.last()) else { return false };
    let [start, end] = [survey.from(first), survey.to(last)].map(|p| before.along(p.truncate()));
    let is_narrow = before == after && (end - start).abs() <= fit.gap_m;
    // Borders run clockwise; what runs back is the rim of a remnant of surface on the border.
    let forward = if before.runs_upward() { start - end } else { end - start };
    if before == after && forward < -fit.gap_m {
        return false;
    }
    // Teeth across the line are no rim however many there are.
    farthest <= fit.tolerance_m || farthest <= fit.absorb_m && (is_short || is_narrow)
}

/// Of some sides the one that an edge's ends are nearest to; the first if equally near.
fn nearer(survey: &CellSurvey, domain: &Domain, edge: u32, sides: &[Side]) -> Side {
    let far = |side: Side| {
        let ends = [survey.from(edge), survey.to(edge)];
        ends.map(|p| domain.outside_m(side, p.truncate()).abs()).into_iter().fold(0.0, f64::max)
    };
    let nearest = sides.iter().copied().min_by(|a, b| far(*a).total_cmp(&far(*b)));
    nearest.unwrap_or(Side::South)
}
