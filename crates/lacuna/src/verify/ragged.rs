//! Promise 4 where tiles are ragged: every edge on which a patch ends is met by exactly one edge of another tile, or lies on
//! the area's border.

use super::patches::place;
use super::seams::CellBorder;
use super::verdict::Findings;
use glam::{DVec2, DVec3};
use lacuna_grid::CellId;
use lacuna_mesh::position_bits;
use std::collections::BTreeMap;

/// Checks the boundaries of all cells against each other. `is_outer` tells what lies on the area's border.
pub(super) fn check_ragged(
    cells: &BTreeMap<CellId, CellBorder>,
    is_outer: impl Fn(CellId, DVec2) -> bool,
) -> Findings {
    let mut findings = Findings::default();
    let mut uses: Uses = BTreeMap::new();
    for edge in cells.values().flat_map(|c| &c.edges) {
        *uses.entry(key(edge.from, edge.to)).or_default() += 1;
    }
    if !tiles_meet(cells, &uses) {
        findings.note("the tiles share no vertices along their borders, so that patches have none to meet");
        return findings;
    }
    let count = |from: DVec3, to: DVec3| uses.get(&key(from, to)).copied().unwrap_or(0);
    for (&cell, border) in cells {
        for edge in border.edges.iter().filter(|e| e.is_patch) {
            let what = match (count(edge.from, edge.to), count(edge.to, edge.from)) {
                (1, 1) => {
                    findings.count("border edges", 1);
                    continue;
                }
                (_, 0) if [edge.from, edge.to].iter().all(|p| is_outer(cell, p.truncate())) => continue,
                (_, 0) => "a patch edge that no other tile meets",
                _ => "more than two surfaces meet in an edge",
            };
            let middle = edge.from.midpoint(edge.to).truncate();
            findings.offend(format!("{}: {what} {}", border.tile, place(middle)));
        }
    }
    findings
}

/// How often each directed edge is used, by the bits of its ends.
type Uses = BTreeMap<[[u64; 3]; 2], u32>;

fn key(from: DVec3, to: DVec3) -> [[u64; 3]; 2] {
    [position_bits(from), position_bits(to)]
}

/// Of the delivered boundary that is left one edge in eight is met by another tile's.
const MET_PART: u64 = 8;

/// True if tiles share the vertices along their borders.
fn tiles_meet(cells: &BTreeMap<CellId, CellBorder>, uses: &Uses) -> bool {
    let (mut all, mut met) = (0, 0);
    for edge in cells.values().flat_map(|c| &c.edges).filter(|e| !e.is_patch) {
        all += 1;
        met += u64::from(uses.contains_key(&key(edge.to, edge.from)));
    }
    met * MET_PART >= all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::seams::BorderEdge;

    fn border(points: &[(f64, f64)], is_patch: bool) -> CellBorder {
        let at = |&(x, y): &(f64, f64)| DVec3::new(x, y, 0.0);
        let edges =
            points.windows(2).map(|w| BorderEdge { from: at(&w[0]), to: at(&w[1]), is_patch }).collect();
        CellBorder { tile: "tile".to_owned(), edges, last_place_m: 0.0 }
    }

    #[test]
    fn patch_edges_need_exactly_one_partner() {
        let line = [(10.2, 1.0), (9.7, 3.0), (10.1, 5.0)];
        let back: Vec<(f64, f64)> = line.iter().rev().copied().collect();
        for (name, others, expected) in [
            ("met", vec![back.clone()], 0),
            ("open", vec![], 2),
            ("half", vec![back[..2].to_vec()], 1),
            ("met twice", vec![back.clone(), back.clone()], 2),
            ("the same way", vec![line.to_vec()], 2),
        ] {
            let mut cells: BTreeMap<CellId, CellBorder> = [(CellId::new(0, 0), border(&line, true))].into();
            let others = (1..).zip(others).map(|(k, points)| (CellId::new(k, 0), border(&points, false)));
            cells.extend(others);
            // Elsewhere the tiles meet.
            let far = [(90.0, 1.0), (90.0, 3.0), (90.0, 5.0)];
            let far_back: Vec<(f64, f64)> = far.iter().rev().copied().collect();
            cells.insert(CellId::new(8, 0), border(&far, false));
            cells.insert(CellId::new(9, 0), border(&far_back, false));
            let found = check_ragged(&cells, |_, _| false).into_result(4, "", true);
            assert_eq!(found.offenders, expected, "{name}: {:?}", found.details);
            let outer = check_ragged(&cells, |_, _| true).into_result(4, "", true);
            assert!(outer.offenders <= found.offenders, "{name}");
        }
    }
}
