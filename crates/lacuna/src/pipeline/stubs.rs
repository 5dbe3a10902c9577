//! Stubs between tiles that share no vertices along their borders: the edges on which patches end there.

use super::solve::FilledHole;
use super::watertight::{Edge, Place, Watertight, cells_of, edge};
use glam::DVec3;
use lacuna_close::Source;
use lacuna_grid::CellId;
use lacuna_hole::{Hole, is_cracked_stub};
use lacuna_mesh::position_bits;
use std::collections::{BTreeMap, BTreeSet};

/// What the stubs of a cluster are judged by.
pub(super) struct Stubs<'a> {
    /// The tile whose vertex is at a place, and the place itself.
    vertices: BTreeMap<Place, (CellId, DVec3)>,
    /// The cell whose outline has an edge.
    owners: BTreeMap<Edge, CellId>,
    /// Boundary edges of the tiles that no patch meets, the missing surface on their left.
    free: Vec<(CellId, [DVec3; 2])>,
    all: &'a Watertight<'a>,
}

impl<'a> Stubs<'a> {
    /// Collects vertices and edges of the patches of a cluster and the tiles round them.
    pub(super) fn new(
        all: &'a Watertight<'a>,
        filled: &[(&Hole, &FilledHole)],
        outlines: &BTreeMap<Edge, DVec3>,
    ) -> Self {
        let mut stubs = Self { vertices: BTreeMap::new(), owners: BTreeMap::new(), free: Vec::new(), all };
        for (hole, fill) in filled {
            stubs.add(hole, fill);
        }
        let cells: BTreeSet<CellId> = filled.iter().flat_map(|(hole, _)| cells_of(hole)).collect();
        for survey in cells.iter().filter_map(|c| all.surveys.get(c)) {
            let edges = (0..survey.boundary.edges.len() as u32)
                .filter(|&e| !outlines.contains_key(&edge(survey, e)))
                .map(|e| (survey.cell, [survey.from(e), survey.to(e)]));
            stubs.free.extend(edges);
        }
        stubs
    }

    fn add(&mut self, hole: &Hole, fill: &FilledHole) {
        let mut first = 0;
        for &length in &fill.ring_lengths {
            for k in 0..length {
                let (a, b) = (first + k, first + (k + 1) % length);
                let ends = [a, b].map(|v| position_bits(fill.rim[v]));
                self.owners.insert(ends, hole.cell);
                let cell = match fill.sources[a] {
                    Source::Original(_) => hole.cell,
                    Source::Adopted(cell, _) => cell,
                    Source::Closing(_) | Source::Corner(_) | Source::Square(_) => continue,
                };
                self.vertices.insert(ends[0], (cell, fill.rim[a]));
            }
            first += length;
        }
    }

    /// Why an edge of the outlines may not stay free, if so.
    pub(super) fn defect(&self, stub: Edge) -> Option<&'static str> {
        let ends = stub.map(|place| self.vertices.get(&place));
        let (Some(from), Some(to), Some(&owner)) = (ends[0], ends[1], self.owners.get(&stub)) else {
            return Some("an edge stays open: the tiles do not meet there");
        };
        let reach_m = 2.0 * self.all.plan.fit.tolerance_m;
        is_cracked_stub([from.1, to.1], owner, &self.free, reach_m)
            .then_some("the tiles overlap where the rim ends, and no edge joins them without a crack")
    }
}
