//! The boundary edges of all tiles that no neighbour closes, where tiles share the vertices along their ragged borders.

use crate::CellSurvey;
use crate::box_tree::BoxTree;
use crate::plan::Hole;
use crate::shared::CellView;
use glam::{DVec2, DVec3};
use lacuna_grid::{CellId, SideLabel};
use lacuna_mesh::{Bounds, PointId, position_bits};
use std::collections::BTreeMap;

/// Tiles share their borders if at least this part of the edges on them is met by the neighbour's.
const SHARED_PART: f64 = 0.25;

/// The bits of a position.
pub(crate) type Place = [u64; 3];

/// A boundary edge of a tile, the missing surface on its left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenEdge {
    pub(crate) cell: CellId,
    /// Index into the boundary of the cell's survey.
    pub(crate) edge: u32,
    pub(crate) ends: [DVec3; 2],
    pub(crate) points: [PointId; 2],
}

/// All open edges, by cell and number.
pub(crate) struct OpenEdges {
    pub(crate) list: Vec<OpenEdge>,
    /// Where each edge starts, with its place in the list; sorted.
    starts: Vec<(Place, usize)>,
    tree: BoxTree,
}

impl OpenEdges {
    /// The edges of rims, islands and borders that are not `closed`: that no edge of another tile meets in the other
    /// direction. `None` if the tiles share no borders, so that nothing can be said.
    pub(crate) fn new(
        holes: &[Hole],
        views: &BTreeMap<CellId, CellView<'_>>,
        closed: &[(CellId, u32)],
    ) -> Option<Self> {
        let is_closed = |key: &(CellId, u32)| closed.binary_search(key).is_ok();
        let on_borders = border_edges(views);
        let met = on_borders.iter().filter(|key| is_closed(key)).count();
        if (met as f64) < SHARED_PART * on_borders.len() as f64 {
            return None;
        }
        let mut keys: Vec<(CellId, u32)> = Vec::new();
        for hole in holes {
            if let Some(view) = views.get(&hole.cell) {
                keys.extend(hole.rim_edges(view.survey).map(|e| (hole.cell, e)));
            }
        }
        for (&cell, view) in views {
            let coverage = view.coverage;
            let runs = coverage.runs.iter().flat_map(|r| &r.edges);
            let chains = coverage.chains.iter().flat_map(|c| &c.edges);
            keys.extend(runs.chain(chains).map(|&e| (cell, e)));
        }
        keys.sort_unstable();
        keys.dedup();
        keys.retain(|key| !is_closed(key));
        let list: Vec<OpenEdge> = keys.into_iter().map(|(cell, e)| open_edge(&views[&cell], e)).collect();
        let mut starts: Vec<(Place, usize)> =
            list.iter().enumerate().map(|(k, e)| (position_bits(e.ends[0]), k)).collect();
        starts.sort_unstable();
        let tree = BoxTree::new(list.iter().map(|e| flat_box(e.ends[0].truncate(), e.ends[1].truncate())));
        Some(Self { list, starts, tree })
    }

    /// The edges that start at a place.
    pub(crate) fn starting_at(&self, place: Place) -> impl Iterator<Item = usize> + '_ {
        let first = self.starts.partition_point(|s| s.0 < place);
        self.starts[first..].iter().take_while(move |s| s.0 == place).map(|s| s.1)
    }

    /// The edges whose boxes touch that of a segment in plan, ascending.
    pub(crate) fn near(&self, a: DVec2, b: DVec2) -> Vec<usize> {
        self.tree.touching(&flat_box(a, b))
    }

    /// The place in the list of a cell's boundary edge, if it is open.
    pub(crate) fn find(&self, cell: CellId, edge: u32) -> Option<usize> {
        self.list.binary_search_by_key(&(cell, edge), |e| (e.cell, e.edge)).ok()
    }
}

fn open_edge(view: &CellView<'_>, edge: u32) -> OpenEdge {
    let record = &view.survey.boundary.edges[edge as usize];
    OpenEdge {
        cell: view.survey.cell,
        edge,
        ends: [view.survey.from(edge), view.survey.to(edge)],
        points: [record.from, record.to],
    }
}

/// A box in plan.
fn flat_box(a: DVec2, b: DVec2) -> Bounds {
    Bounds { min: a.min(b).extend(0.0), max: a.max(b).extend(0.0) }
}

/// Boundary edges that an edge of another tile meets in the other direction, each with one: by cell and number, sorted.
pub(crate) fn closed_edges(surveys: &BTreeMap<CellId, &CellSurvey>) -> Vec<(CellId, u32)> {
    // The ends in a fixed order, then the direction: edges that meet lie side by side.
    let mut edges: Vec<([Place; 2], bool, CellId, u32)> = Vec::new();
    for (&cell, survey) in surveys {
        for e in 0..survey.boundary.edges.len() as u32 {
            let [a, b] = [survey.from(e), survey.to(e)].map(position_bits);
            edges.push(([a.min(b), a.max(b)], a < b, cell, e));
        }
    }
    edges.sort_unstable();
    let mut closed = Vec::new();
    for group in edges.chunk_by(|x, y| x.0 == y.0) {
        let up = group.iter().filter(|e| e.1);
        let down = group.iter().filter(|e| !e.1);
        closed.extend(up.zip(down).flat_map(|(a, b)| [(a.2, a.3), (b.2, b.3)]));
    }
    closed.sort_unstable();
    closed
}

/// The edges of all borders between two tiles.
fn border_edges(views: &BTreeMap<CellId, CellView<'_>>) -> Vec<(CellId, u32)> {
    let mut edges = Vec::new();
    for (&cell, view) in views {
        for run in &view.coverage.runs {
            let has_other = match view.domain.side(run.side).label {
                SideLabel::Neighbour(other) => {
                    views.get(&other).is_some_and(|o| !o.survey.boundary.edges.is_empty())
                }
                SideLabel::External => false,
            };
            if has_other {
                edges.extend(run.edges.iter().map(|&e| (cell, e)));
            }
        }
    }
    edges
}
