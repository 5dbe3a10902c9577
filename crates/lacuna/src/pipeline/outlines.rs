//! Outlines of clusters for the map: the rims of all their holes, joined over the borders that they share.

use super::scan::Scanned;
use glam::DVec2;
use lacuna_grid::Domain;
use lacuna_hole::{CellSurvey, CurveKind, Hole, HoleCluster, Piece, Plan, Span};

/// Closed rings round a cluster: pieces of rim, adopted border and outer edge, each followed by the one that starts
/// nearest to its end. For a picture, so small gaps are drawn straight.
pub(crate) fn cluster_outline(plan: &Plan, scanned: &Scanned, cluster: &HoleCluster) -> Vec<Vec<[f64; 2]>> {
    let mut lines: Vec<Vec<DVec2>> = Vec::new();
    for &h in &cluster.holes {
        let hole = &plan.holes[h as usize];
        hole.outer.iter().for_each(|piece| add_piece(plan, scanned, hole, piece, &mut lines));
    }
    join(lines).into_iter().map(|ring| ring.iter().map(|p| p.to_array()).collect()).collect()
}

fn add_piece(plan: &Plan, scanned: &Scanned, hole: &Hole, piece: &Piece, lines: &mut Vec<Vec<DVec2>>) {
    match piece {
        Piece::Rim(edges) => add_edges(scanned.surveys.get(&hole.cell), edges, lines),
        Piece::Bridge => {}
        Piece::Side { side, spans, .. } => {
            for span in spans {
                match span {
                    Span::Adopted { neighbour, edges } => {
                        add_edges(scanned.surveys.get(neighbour), edges, lines);
                    }
                    Span::Curve(c) => {
                        let curve = &plan.curves[*c as usize];
                        if curve.kind != CurveKind::Shared {
                            let line = plan
                                .domains
                                .get(&hole.cell)
                                .map_or(curve.line, |d: &Domain| d.side(*side).line);
                            let ends = [curve.low_m, curve.high_m].map(|t| side.point(t, line));
                            let [a, b] = ends;
                            lines.push(if side.runs_upward() { vec![a, b] } else { vec![b, a] });
                        }
                    }
                }
            }
        }
    }
}

fn add_edges(survey: Option<&CellSurvey>, edges: &[u32], lines: &mut Vec<Vec<DVec2>>) {
    if let (Some(survey), Some(&first)) = (survey, edges.first()) {
        let mut line = vec![survey.from(first).truncate()];
        line.extend(edges.iter().map(|&e| survey.to(e).truncate()));
        lines.push(line);
    }
}

/// Chains polylines end to start, nearest first by the order of the list, until each ring is closed.
fn join(lines: Vec<Vec<DVec2>>) -> Vec<Vec<DVec2>> {
    let ends = |line: &[DVec2]| Some((*line.first()?, *line.last()?));
    let mut left: Vec<Option<Vec<DVec2>>> = lines.into_iter().map(Some).collect();
    let mut rings = Vec::new();
    for start in 0..left.len() {
        let Some(mut ring) = left[start].take() else { continue };
        while let Some((first, last)) = ends(&ring) {
            let to_start = last.distance_squared(first);
            let next = (0..left.len())
                .filter_map(|k| Some((k, last.distance_squared(*left[k].as_ref()?.first()?))))
                .filter(|(_, d)| *d < to_start)
                .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let Some(more) = next.and_then(|(k, _)| left[k].take()) else { break };
            ring.extend(more);
        }
        ring.dedup();
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_of_a_square_become_one_ring() {
        let p = |x: f64, y: f64| DVec2::new(x, y);
        let halves = vec![
            vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.5)],
            vec![p(1.0, 0.5), p(1.0, 1.0), p(0.0, 1.0), p(0.0, 0.0)],
        ];
        let rings = join(halves);
        assert_eq!(rings.len(), 1);
        assert_eq!(rings[0].len(), 6);
    }
}
