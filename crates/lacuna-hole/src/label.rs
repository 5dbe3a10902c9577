//! Which boundary edges lie on the border of the cell (algorithms note B.2).

use crate::{BorderFit, BorderMode, CellSurvey};
use lacuna_grid::{Domain, Side};

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

/// Labels every boundary edge of a cell: border by distance (and direction where tiles are ragged), then short rim runs
/// that never leave the border's neighbourhood are absorbed.
pub(crate) fn label_edges(survey: &CellSurvey, domain: &Domain, fit: &BorderFit) -> Vec<Label> {
    let mut labels: Vec<Label> = (0..survey.boundary.edges.len() as u32)
        .map(|e| border_side(survey, domain, fit, e).map_or(Label::Rim, Label::Border))
        .collect();
    for l in &survey.loops {
        absorb(survey, domain, fit, &l.edges, &mut labels);
    }
    labels
}

fn border_side(survey: &CellSurvey, domain: &Domain, fit: &BorderFit, edge: u32) -> Option<Side> {
    let (a, b) = (survey.from(edge).truncate(), survey.to(edge).truncate());
    let far = |side: Side| {
        let offsets = [domain.outside_m(side, a), domain.outside_m(side, b)];
        // Beyond the line counts as on it where tiles reach into their neighbours.
        let beyond = fit.mode == BorderMode::Overlap;
        offsets.map(|o| if beyond { (-o).max(0.0) } else { o.abs() }).into_iter().fold(0.0, f64::max)
    };
    let nearest = Side::ALL.into_iter().min_by(|x, y| far(*x).total_cmp(&far(*y)))?;
    if far(nearest) > fit.tolerance_m {
        return None;
    }
    let exact = matches!(fit.mode, BorderMode::Exact | BorderMode::Overrun);
    let direction = (b - a).normalize_or_zero();
    let runs_along = direction.dot(nearest.outward()).abs() <= 0.7;
    (exact || runs_along).then_some(nearest)
}

/// Rim runs shorter than three edges' length between border runs of one side, near to its line, become border.
fn absorb(survey: &CellSurvey, domain: &Domain, fit: &BorderFit, edges: &[u32], labels: &mut [Label]) {
    let n = edges.len();
    let Some(first) = edges.iter().position(|&e| matches!(labels[e as usize], Label::Border(_))) else {
        return;
    };
    let mut k = 0;
    while k < n {
        let at = |i: usize| edges[(first + i) % n];
        let Label::Border(side) = labels[at(k) as usize] else {
            k += 1;
            continue;
        };
        let run = (k + 1..=n).take_while(|&i| labels[at(i) as usize] == Label::Rim).count();
        let closes = labels[at(k + run + 1) as usize] == Label::Border(side);
        let run_edges = || (k + 1..=k + run).map(at);
        let length: f64 = run_edges().map(|e| survey.from(e).distance(survey.to(e))).sum();
        let near = run_edges().all(|e| domain.outside_m(side, survey.to(e).truncate()).abs() <= fit.absorb_m);
        if run > 0 && closes && near && length < 3.0 * fit.edge_m.max(survey.median_edge_m) {
            run_edges().for_each(|e| labels[e as usize] = Label::Border(side));
        }
        k += run + 1;
    }
}
