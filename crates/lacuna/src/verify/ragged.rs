//! Promise 4 where tiles are ragged: every edge on which a patch ends is met by exactly one edge of another tile, or lies on
//! the area's border, or (where the tiles share no vertices) leads from one tile's border to the other's without a crack.

use super::patches::place;
use super::seams::{BorderEdge, CellBorder};
use super::verdict::Findings;
use glam::{DVec2, DVec3};
use lacuna_grid::CellId;
use lacuna_hole::is_cracked_stub;
use lacuna_mesh::position_bits;
use std::collections::BTreeMap;

/// Checks the boundaries of all cells against each other. `is_outer` tells what lies on the area's border; `stub_reach_m`
/// how far tiles that share no vertices stray, if they do not.
pub(super) fn check_ragged(
    cells: &BTreeMap<CellId, CellBorder>,
    stub_reach_m: Option<f64>,
    is_outer: impl Fn(CellId, DVec2) -> bool,
) -> Findings {
    let mut findings = Findings::default();
    let mut uses: Uses = BTreeMap::new();
    for edge in cells.values().flat_map(|c| &c.edges) {
        *uses.entry(key(edge.from, edge.to)).or_default() += 1;
    }
    if stub_reach_m.is_some() {
        findings.note("the tiles share no vertices along their borders: what they delivered is open there");
    }
    let stubs = stub_reach_m.map(|reach_m| Stubs::new(cells, &uses, reach_m));
    let count = |from: DVec3, to: DVec3| uses.get(&key(from, to)).copied().unwrap_or(0);
    for (&cell, border) in cells {
        for edge in border.edges.iter().filter(|e| e.is_patch) {
            let what = match (count(edge.from, edge.to), count(edge.to, edge.from)) {
                (1, 1) => {
                    findings.count("border edges", 1);
                    continue;
                }
                (_, 0) if [edge.from, edge.to].iter().all(|p| is_outer(cell, p.truncate())) => continue,
                (_, 0) => match &stubs {
                    Some(stubs) if stubs.joins(edge) => match stubs.is_cracked(cell, edge) {
                        true => "a crack beside the edge that joins two tiles",
                        false => {
                            findings.count("stubs between tiles", 1);
                            continue;
                        }
                    },
                    _ => "a patch edge that no other tile meets",
                },
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

/// What edges between two tiles that share no vertices are judged by.
struct Stubs {
    /// Delivered vertices that are left on boundaries, and their cells.
    vertices: BTreeMap<[u64; 3], CellId>,
    /// Edges that nothing meets, the missing surface on their left, and their cells.
    free: Vec<(CellId, [DVec3; 2])>,
    reach_m: f64,
}

impl Stubs {
    fn new(cells: &BTreeMap<CellId, CellBorder>, uses: &Uses, reach_m: f64) -> Self {
        let mut stubs = Self { vertices: BTreeMap::new(), free: Vec::new(), reach_m };
        for (&cell, edge) in cells.iter().flat_map(|(c, b)| b.edges.iter().map(move |e| (c, e))) {
            if !edge.is_patch {
                stubs.vertices.extend([edge.from, edge.to].map(|p| (position_bits(p), cell)));
            }
            if !uses.contains_key(&key(edge.to, edge.from)) {
                stubs.free.push((cell, [edge.from, edge.to]));
            }
        }
        stubs
    }

    /// True if an edge leads from a vertex that one tile was delivered with to one of another's.
    fn joins(&self, edge: &BorderEdge) -> bool {
        let cells = [edge.from, edge.to].map(|p| self.vertices.get(&position_bits(p)));
        matches!(cells, [Some(a), Some(b)] if a != b)
    }

    fn is_cracked(&self, cell: CellId, edge: &BorderEdge) -> bool {
        // A boundary edge has its patch on the right.
        is_cracked_stub([edge.to, edge.from], cell, &self.free, self.reach_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let found = check_ragged(&cells, None, |_, _| false).into_result(4, "", true);
            assert_eq!(found.offenders, expected, "{name}: {:?}", found.details);
            let outer = check_ragged(&cells, None, |_, _| true).into_result(4, "", true);
            assert!(outer.offenders <= found.offenders, "{name}");
        }
    }

    #[test]
    fn stubs_join_two_tiles_without_a_crack() {
        // The west tile ends north of y = 5, the east tile north of `end`; the stub belongs to the west tile's patch.
        for (name, end, width, expected) in [
            ("to where the other one ends", 4.0, 0.2, 0),
            ("beside the other one", 7.0, 0.2, 1),
            ("over the other one", 7.0, -0.2, 0),
            ("across the border", 5.2, 0.6, 0),
        ] {
            let west = border(&[(10.0, 5.0), (10.0, 1.0)], false);
            let mut with_stub = west.clone();
            with_stub.edges.extend(border(&[(10.0 + width, end), (10.0, 5.0)], true).edges);
            let east = border(&[(10.0 + width, 1.0), (10.0 + width, end)], false);
            let cells = [(CellId::new(0, 0), with_stub), (CellId::new(1, 0), east)].into();
            let found = check_ragged(&cells, Some(3.0), |_, _| false).into_result(4, "", true);
            assert_eq!(found.offenders, expected, "{name}: {:?}", found.details);
            let met = check_ragged(&cells, None, |_, _| false).into_result(4, "", true);
            assert_eq!(met.offenders, 1, "{name}: where tiles share vertices no stub stays open");
        }
    }
}
