//! Which cell, and which of its holes, an outline of open edges and cuts belongs to.

use crate::faces::{Cut, Face, Step};
use crate::open_edges::OpenEdges;
use crate::plan::{Hole, Piece};
use crate::shared::CellView;
use lacuna_grid::{CellId, SideLabel};
use std::collections::{BTreeMap, BTreeSet};

/// The open edges of rims.
pub(crate) struct Rims {
    /// The hole of each, if the plan has one.
    of_edge: BTreeMap<usize, Option<usize>>,
    /// The hole of a cell without any rim.
    hollow: BTreeMap<CellId, usize>,
    /// Open edges on borders to such cells, and the cell beyond.
    facing: BTreeMap<usize, CellId>,
}

impl Rims {
    pub(crate) fn new(open: &OpenEdges, holes: &[Hole], views: &BTreeMap<CellId, CellView<'_>>) -> Self {
        let mut rims = Self { of_edge: BTreeMap::new(), hollow: BTreeMap::new(), facing: BTreeMap::new() };
        for (&cell, view) in views {
            let edges = view.coverage.chains.iter().flat_map(|c| &c.edges);
            rims.of_edge.extend(edges.filter_map(|&e| Some((open.find(cell, e)?, None))));
        }
        for (h, hole) in holes.iter().enumerate() {
            let Some(view) = views.get(&hole.cell) else { continue };
            let edges = hole.rim_edges(view.survey).filter_map(|e| open.find(hole.cell, e));
            rims.of_edge.extend(edges.map(|e| (e, Some(h))));
            if !hole.outer.iter().any(|p| matches!(p, Piece::Rim(_))) {
                rims.hollow.insert(hole.cell, h);
            }
        }
        for (&cell, view) in views {
            for run in &view.coverage.runs {
                let SideLabel::Neighbour(beyond) = view.domain.side(run.side).label else { continue };
                if rims.hollow.contains_key(&beyond) {
                    let edges = run.edges.iter().filter_map(|&e| open.find(cell, e));
                    rims.facing.extend(edges.map(|e| (e, beyond)));
                }
            }
        }
        rims
    }

    /// Where walks start beside the cuts: a cell without surface among tiles that are whole has neither cuts nor rims.
    pub(crate) fn starts(&self) -> impl Iterator<Item = usize> + '_ {
        self.of_edge.keys().chain(self.facing.keys()).copied()
    }

    /// The cell without surface that all boundary edges of a face are the border of.
    fn surrounded(&self, open: &OpenEdges, face: &Face) -> Option<CellId> {
        let delivered = face.steps.iter().filter_map(edge_of).filter(|&e| open.list[e].of.is_some());
        let beyond: BTreeSet<Option<CellId>> = delivered.map(|e| self.facing.get(&e).copied()).collect();
        if beyond.len() == 1 { beyond.into_iter().next().flatten() } else { None }
    }

    /// True if a face has an edge of its cell, or its cell has no surface.
    pub(crate) fn has_own(&self, open: &OpenEdges, cell: CellId, face: &Face) -> bool {
        self.hollow.contains_key(&cell)
            || face.steps.iter().filter_map(edge_of).any(|e| open.list[e].cell() == Some(cell))
    }

    /// The holes of a face's cell whose rims it has, or the one of a cell without rims.
    pub(crate) fn holes(&self, open: &OpenEdges, cell: CellId, face: &Face) -> BTreeSet<usize> {
        let own = face.steps.iter().filter_map(edge_of).filter(|e| open.list[*e].cell() == Some(cell));
        let holes: BTreeSet<usize> = own.filter_map(|e| *self.of_edge.get(&e)?).collect();
        if holes.is_empty() { self.hollow.get(&cell).copied().into_iter().collect() } else { holes }
    }
}

/// The cell of a face: that on whose side it sees its cuts, else the one without surface that its edges surround, else that
/// of its edges. `None` if its cuts differ.
pub(crate) fn cell_of(open: &OpenEdges, cuts: &[Cut], rims: &Rims, face: &Face) -> Option<CellId> {
    let of_cuts: BTreeSet<CellId> = face
        .steps
        .iter()
        .filter_map(|s| match s {
            Step::Cut(c, way) => cuts[*c].cells[*way].map(|side| side.0),
            Step::Edge(_) => None,
        })
        .collect();
    let edges = || {
        face.steps.iter().filter_map(|s| match s {
            Step::Edge(e) => open.list[*e].cell(),
            Step::Cut(..) => None,
        })
    };
    // Of several tiles the one that has most of the edges, then the first.
    let most_edges = || {
        let mut counts: BTreeMap<CellId, usize> = BTreeMap::new();
        edges().for_each(|c| *counts.entry(c).or_default() += 1);
        counts.into_iter().max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(&a.0))).map(|c| c.0)
    };
    match of_cuts.len() {
        0 => rims.surrounded(open, face).or_else(most_edges),
        1 => of_cuts.first().copied(),
        _ => None,
    }
}

/// The open edge of a step along one.
pub(crate) fn edge_of(step: &Step) -> Option<usize> {
    match step {
        Step::Edge(e) => Some(*e),
        Step::Cut(..) => None,
    }
}
