//! Promise 4 where tiles overrun their cell: the patches of two neighbours agree within 1 mm over the strip that both cover.

use super::patches::place;
use super::plan_index::PlanIndex;
use super::verdict::Findings;
use glam::{DVec2, DVec3};
use lacuna_grid::{CellId, Grid, Side};
use std::collections::BTreeMap;

/// Largest difference in height, metres.
const AGREEMENT_M: f64 = 0.001;
/// Samples nearer than so many rim edges to a rim are left out: there each patch joins its own rim (decisions 8).
const RIM_EDGES: f64 = 2.0;

/// What the check of an overlap needs to know of one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct CellStrips {
    pub(super) tile: String,
    /// Patch triangles within the cell's strips.
    pub(super) triangles: Vec<[DVec3; 3]>,
    /// Vertices of the rims of its patches.
    pub(super) rim: Vec<DVec2>,
    /// Median length of the rims' edges, metres.
    pub(super) rim_edge_m: f64,
}

/// Compares the patches of neighbouring cells at the vertices and edge midpoints that lie in the common strip.
pub(super) fn check_overlaps(
    cells: &BTreeMap<CellId, CellStrips>,
    grid: &Grid,
    margin_m: f64,
    tolerance_m: f64,
) -> Findings {
    let mut findings = Findings::default();
    for (&cell, own) in cells {
        for side in [Side::East, Side::North] {
            let Some(other) = cells.get(&cell.neighbour(side)) else { continue };
            let line = side.across(grid.corner(cell.corner_after(side)));
            check_strip([own, other], side, line, margin_m + tolerance_m, &mut findings);
        }
    }
    findings
}

fn check_strip(cells: [&CellStrips; 2], side: Side, line: f64, reach_m: f64, findings: &mut Findings) {
    let distance = |p: DVec3| side.across(p.truncate()) - line;
    let touches = |t: &&[DVec3; 3]| {
        t.iter().any(|p| distance(*p) <= reach_m) && t.iter().any(|p| distance(*p) >= -reach_m)
    };
    let strips = cells.map(|c| c.triangles.iter().filter(touches).copied().collect::<Vec<_>>());
    if strips.iter().any(Vec::is_empty) {
        return;
    }
    findings.count("overlaps", 1);
    let mut samples: Vec<DVec2> = strips
        .iter()
        .flatten()
        .flat_map(|[a, b, c]| [*a, *b, *c, a.midpoint(*b), b.midpoint(*c), c.midpoint(*a)])
        .filter(|p| distance(*p).abs() <= reach_m)
        .map(|p| p.truncate())
        .collect();
    samples.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    samples.dedup();
    let surfaces = strips.map(PlanIndex::new);
    for sample in samples {
        compare(cells, &surfaces, sample, findings);
    }
}

fn compare(cells: [&CellStrips; 2], surfaces: &[PlanIndex; 2], sample: DVec2, findings: &mut Findings) {
    let heights = |k: usize| surfaces[k].over(sample).map(|(_, z)| z).collect::<Vec<f64>>();
    let (own, other) = (heights(0), heights(1));
    let gaps = own.iter().flat_map(|a| other.iter().map(move |b| (a - b).abs()));
    let gap = gaps.fold(f64::INFINITY, f64::min);
    if !gap.is_finite() {
        return;
    }
    let is_near_rim = |c: &CellStrips| {
        let near = RIM_EDGES * c.rim_edge_m;
        c.rim.iter().any(|p| p.distance_squared(sample) < near * near)
    };
    if cells.iter().any(|c| is_near_rim(c)) {
        findings.count("samples left out near a rim", 1);
        return;
    }
    findings.count("samples", 1);
    if gap > AGREEMENT_M {
        let what = format!("the surfaces are {:.4} m apart", gap);
        findings.offend(format!("{} | {}: {what} {}", cells[0].tile, cells[1].tile, place(sample)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(low: f64, high: f64, height: f64) -> CellStrips {
        let p = |x: f64, y: f64| DVec3::new(x, y, height + 0.1 * y);
        let square = |y: f64| {
            [[p(low, y), p(high, y), p(high, y + 1.0)], [p(low, y), p(high, y + 1.0), p(low, y + 1.0)]]
        };
        CellStrips {
            tile: format!("from {low}"),
            triangles: (0..9).flat_map(|k| square(f64::from(k))).collect(),
            rim: vec![DVec2::new(10.0, 0.0)],
            rim_edge_m: 1.0,
        }
    }

    #[test]
    fn surfaces_agree_away_from_rims() {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 10.0 };
        for (lift, expected) in [(0.0, false), (0.0009, false), (0.002, true), (-0.5, true)] {
            let west = strip(9.0, 10.1, 1.0);
            let east = strip(9.9, 11.0, 1.0 + lift);
            let cells = [(CellId::new(0, 0), west), (CellId::new(1, 0), east)].into();
            let found = check_overlaps(&cells, &grid, 0.1, 0.002);
            assert!(found.counted("samples") > 20 && found.counted("samples left out near a rim") > 3);
            assert_eq!(found.into_result(4, "", true).offenders > 0, expected, "lift {lift}");
        }
    }
}
