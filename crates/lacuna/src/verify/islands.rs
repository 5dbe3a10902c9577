//! Promise 5 for islands: each is joined all round, or the report says that the patch passes beneath it, and it does.

use super::patch_mesh::{CellMesh, ORIGINAL};
use super::patches::place;
use super::plan_index::PlanIndex;
use super::records::IslandOutlines;
use super::verdict::Findings;
use glam::DVec2;
use lacuna_mesh::{Boundary, BoundaryEdge};
use std::collections::HashMap;

/// Outlines are rounded to millimetres.
const ROUNDING_M: f64 = 0.001;

/// Judges the islands of a cell's filled holes on its final mesh: (1) no edge of a joined one is open; (2) each one that
/// the report says the patch passes beneath is open, and the patch lies below its rim.
pub(super) fn check_islands(
    tile: &str,
    holes: &[(&str, &IslandOutlines)],
    cell: &CellMesh,
    boundary: &Boundary,
) -> Findings {
    let mut findings = Findings::default();
    if holes.iter().all(|(_, islands)| islands.joined.is_empty() && islands.passed_under.is_empty()) {
        return findings;
    }
    let joined = Rims::new(holes, |islands| &islands.joined);
    let passed = Rims::new(holes, |islands| &islands.passed_under);
    let patches = patch_index(cell);
    let mut open_edges = vec![0_usize; passed.holes.len()];
    for edge in &boundary.edges {
        if let Some(island) = joined.find(boundary, edge) {
            let at = boundary.position(edge.from).truncate();
            findings.offend(format!(
                "{tile} ({}): an island is not joined {}",
                joined.holes[island],
                place(at)
            ));
        }
        let Some(island) = passed.find(boundary, edge) else { continue };
        open_edges[island] += 1;
        let p = boundary.position(edge.from);
        let is_beneath = patches.over(p.truncate()).all(|(_, z)| z < p.z);
        if !is_beneath || patches.over(p.truncate()).next().is_none() {
            findings.offend(format!(
                "{tile} ({}): the patch does not pass beneath an island {}",
                passed.holes[island],
                place(p.truncate())
            ));
        }
    }
    findings.count("islands joined", joined.holes.len() as u64);
    findings.count("islands passed under", passed.holes.len() as u64);
    for (island, _) in open_edges.iter().enumerate().filter(|(_, count)| **count == 0) {
        let hole = passed.holes[island];
        findings.offend(format!("{tile} ({hole}): an island that the patch passes beneath has no open rim"));
    }
    findings
}

fn patch_index(cell: &CellMesh) -> PlanIndex {
    let patches = (0..cell.owner.len()).filter(|&t| cell.owner[t] != ORIGINAL).map(|t| cell.mesh.corners(t));
    PlanIndex::new(patches.filter(|t| t.iter().all(|p| p.is_finite())).collect())
}

/// Rims of islands, to be found by their vertices.
struct Rims<'a> {
    /// Hole of each island.
    holes: Vec<&'a str>,
    /// Islands and their vertices by the centimetre squares that these lie in.
    squares: HashMap<(i64, i64), Vec<(usize, DVec2)>>,
}

impl<'a> Rims<'a> {
    fn new(
        holes: &[(&'a str, &IslandOutlines)],
        of_hole: impl Fn(&IslandOutlines) -> &Vec<Vec<DVec2>>,
    ) -> Self {
        let mut rims = Self { holes: Vec::new(), squares: HashMap::new() };
        for (id, islands) in holes {
            for ring in of_hole(islands) {
                for &p in ring {
                    rims.squares.entry(square(p)).or_default().push((rims.holes.len(), p));
                }
                rims.holes.push(id);
            }
        }
        rims
    }

    /// The island whose rim an edge belongs to: both its ends do.
    fn find(&self, boundary: &Boundary, edge: &BoundaryEdge) -> Option<usize> {
        if self.squares.is_empty() {
            return None;
        }
        let at = |p: DVec2| {
            let (i, j) = square(p);
            let near = (-1..=1).flat_map(move |di| (-1..=1).map(move |dj| (i + di, j + dj)));
            let vertices = near.filter_map(|key| self.squares.get(&key)).flatten();
            vertices
                .filter(|(_, q)| q.distance(p) <= 2.0 * ROUNDING_M)
                .map(|(island, _)| *island)
                .collect::<Vec<_>>()
        };
        let ends = at(boundary.position(edge.to).truncate());
        at(boundary.position(edge.from).truncate()).into_iter().find(|island| ends.contains(island))
    }
}

fn square(p: DVec2) -> (i64, i64) {
    let key = (p / (10.0 * ROUNDING_M)).floor();
    (key.x as i64, key.y as i64)
}
