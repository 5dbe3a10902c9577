//! The boundary edges of all ragged tiles that no neighbour closes, and the stubs that join them where tiles share no
//! vertices along their borders.

use crate::box_tree::BoxTree;
use crate::loose::{stubs, turned_ends};
use crate::plan::Hole;
use crate::shared::CellView;
use crate::{BorderFit, CellSurvey};
use glam::{DVec2, DVec3};
use lacuna_grid::CellId;
use lacuna_mesh::{Bounds, PointId, position_bits};
use std::collections::BTreeMap;

/// The bits of a position.
pub(crate) type Place = [u64; 3];

/// A boundary edge of a tile, or a stub between two tiles; the missing surface on its left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenEdge {
    /// Whose boundary edge it is, and its index in the survey's boundary; `None`: a stub.
    pub(crate) of: Option<(CellId, u32)>,
    /// True if it lies on the border of its cell: no rim.
    pub(crate) is_border: bool,
    pub(crate) ends: [DVec3; 2],
    /// The vertices at the ends.
    pub(crate) points: [(CellId, PointId); 2],
}

impl OpenEdge {
    /// The cell whose boundary edge it is.
    pub(crate) fn cell(&self) -> Option<CellId> {
        self.of.map(|of| of.0)
    }
}

/// All open edges: those of tiles by cell and number, then the stubs.
pub(crate) struct OpenEdges {
    pub(crate) list: Vec<OpenEdge>,
    /// How many of them are boundary edges.
    delivered: usize,
    /// Where each edge starts, with its place in the list; sorted.
    starts: Vec<(Place, usize)>,
    tree: BoxTree,
    /// Vertices at which no cut may end, with the edges at which it may end instead; see `loose::turned_ends`.
    turned: BTreeMap<Place, Vec<usize>>,
    /// True if the tiles share no vertices along their borders.
    pub(crate) is_loose: bool,
}

impl OpenEdges {
    /// The edges of rims, islands and borders that are not `closed` (sorted): that no edge of another tile meets in the
    /// other direction, or that only face another tile's border. With `is_loose` the rest is joined by stubs.
    pub(crate) fn new(
        holes: &[Hole],
        views: &BTreeMap<CellId, CellView<'_>>,
        closed: &[(CellId, u32)],
        fit: &BorderFit,
        is_loose: bool,
    ) -> Self {
        let is_closed = |key: &(CellId, u32)| closed.binary_search(key).is_ok();
        let mut keys: Vec<(CellId, u32)> = Vec::new();
        for hole in holes {
            if let Some(view) = views.get(&hole.cell) {
                keys.extend(hole.rim_edges(view.survey).map(|e| (hole.cell, e)));
            }
        }
        let mut on_border: Vec<(CellId, u32)> = Vec::new();
        for (&cell, view) in views {
            let coverage = view.coverage;
            on_border.extend(coverage.runs.iter().flat_map(|r| &r.edges).map(|&e| (cell, e)));
            keys.extend(coverage.chains.iter().flat_map(|c| &c.edges).map(|&e| (cell, e)));
        }
        on_border.sort_unstable();
        keys.extend(&on_border);
        keys.sort_unstable();
        keys.dedup();
        keys.retain(|key| !is_closed(key));
        let is_border = |key: &(CellId, u32)| on_border.binary_search(key).is_ok();
        let mut list: Vec<OpenEdge> =
            keys.into_iter().map(|key| open_edge(&views[&key.0], key.1, is_border(&key))).collect();
        let delivered = list.len();
        let mut turned = BTreeMap::new();
        if is_loose {
            let stubs = stubs(&list, fit);
            turned = turned_ends(&list, &stubs);
            list.extend(stubs);
        }
        let mut starts: Vec<(Place, usize)> =
            list.iter().enumerate().map(|(k, e)| (position_bits(e.ends[0]), k)).collect();
        starts.sort_unstable();
        let tree = BoxTree::new(list.iter().map(|e| flat_box(e.ends[0].truncate(), e.ends[1].truncate())));
        Self { list, delivered, starts, tree, turned, is_loose }
    }

    /// The edges that start at a place.
    pub(crate) fn starting_at(&self, place: Place) -> impl Iterator<Item = usize> + '_ {
        let first = self.starts.partition_point(|s| s.0 < place);
        self.starts[first..].iter().take_while(move |s| s.0 == place).map(|s| s.1)
    }

    /// Where a cut may end instead of at a place: ends of the edges there. `None`: at the place itself.
    pub(crate) fn turned(&self, place: Place) -> Option<&[usize]> {
        self.turned.get(&place).map(Vec::as_slice)
    }

    /// The edges whose boxes touch that of a segment in plan, ascending.
    pub(crate) fn near(&self, a: DVec2, b: DVec2) -> Vec<usize> {
        self.tree.touching(&flat_box(a, b))
    }

    /// The place in the list of a cell's boundary edge, if it is open.
    pub(crate) fn find(&self, cell: CellId, edge: u32) -> Option<usize> {
        self.list[..self.delivered].binary_search_by_key(&Some((cell, edge)), |e| e.of).ok()
    }
}

fn open_edge(view: &CellView<'_>, edge: u32, is_border: bool) -> OpenEdge {
    let record = &view.survey.boundary.edges[edge as usize];
    let cell = view.survey.cell;
    OpenEdge {
        of: Some((cell, edge)),
        is_border,
        ends: [view.survey.from(edge), view.survey.to(edge)],
        points: [(cell, record.from), (cell, record.to)],
    }
}

/// A box in plan.
pub(crate) fn flat_box(a: DVec2, b: DVec2) -> Bounds {
    Bounds { min: a.min(b).extend(0.0), max: a.max(b).extend(0.0) }
}

/// Boundary edges that an edge of another tile (or another one of the same tile) meets in the other direction, pair by
/// pair: of edges on one another as many are closed as run each way. By cell and number, sorted.
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
