//! Where the border lines run through the holes of a scene: between the open edges of all tiles.

use crate::BorderFit;
use crate::faces::{Cut, Node};
use crate::loose::LONGEST_STUB_EDGES;
use crate::open_edges::{OpenEdge, OpenEdges};
use crate::plan::{Anchor, Curve, CurveKind};
use crate::shared::{CellView, SidePiece};
use glam::DVec2;
use lacuna_grid::{CellId, CornerId, Domain, Side, SideLabel};
use lacuna_mesh::{Meeting, position_bits, segments_cross};
use std::collections::{BTreeMap, BTreeSet};

/// A stretch of a border line inside a hole.
struct Stretch {
    /// The cell north or east of the border, and its side.
    cell: CellId,
    side: Side,
    line: f64,
    ends: [StretchEnd; 2],
}

/// Where a stretch ends.
#[derive(Clone, Copy)]
struct StretchEnd {
    along_m: f64,
    at: EndKind,
}

#[derive(Clone, Copy)]
enum EndKind {
    /// Where an open edge crosses the line.
    Edge(usize),
    /// At a grid corner inside the hole.
    Corner(CornerId),
}

/// The cuts along all borders between cells on which some hole opens a stretch.
///
/// Steps: (1) along every border line the open edges that cross it, in order: where one opens towards larger coordinates
/// and the next one back, the line runs through a hole; (2) of these stretches those near one that the plan opens, and all
/// that meet them in a grid corner; (3) their ends go to the nearer end of the crossing edge that sees the line.
pub(crate) fn border_cuts(
    open: &OpenEdges,
    pieces: &[SidePiece],
    views: &BTreeMap<CellId, CellView<'_>>,
    fit: &BorderFit,
) -> Vec<Cut> {
    let mut opened: BTreeMap<(CellId, Side), Vec<&SidePiece>> = BTreeMap::new();
    for p in pieces {
        let border = p.cell.border(p.side);
        opened.entry((border.cell, border.side)).or_default().push(p);
    }
    let mut all: Vec<(Stretch, bool)> = Vec::new();
    for (&cell, view) in views {
        for side in [Side::South, Side::West] {
            let SideLabel::Neighbour(other) = view.domain.side(side).label else { continue };
            if !views.contains_key(&other) {
                continue;
            }
            let near = opened.get(&(cell, side)).map_or(&[][..], Vec::as_slice);
            let slack_m = 3.0 * fit.edge_m;
            let both = both_open(near, cell);
            let stretches = stretches(open, view.domain, side, near, fit).into_iter();
            for s in stretches.filter(|s| !open.is_loose || is_between(s, &both)) {
                let is_near = near
                    .iter()
                    .any(|p| p.low_m - slack_m < s.ends[1].along_m && p.high_m + slack_m > s.ends[0].along_m);
                all.push((s, is_near));
            }
        }
    }
    keep_whole_corners(&mut all);
    let kept = all.iter().filter(|s| s.1);
    let mut cuts: Vec<Cut> = kept.filter_map(|(s, _)| cut(open, s, fit)).collect();
    leave_near_corners(&mut cuts, fit.edge_m);
    cuts.retain(|c| c.nodes[0] != c.nodes[1] && !has_edge(open, c));
    cuts
}

/// The stretches of a border that both cells open, by the pieces on it.
fn both_open(pieces: &[&SidePiece], cell: CellId) -> Vec<(f64, f64)> {
    let (own, others): (Vec<&SidePiece>, Vec<&SidePiece>) = pieces.iter().partition(|p| p.cell == cell);
    let shared =
        own.iter().flat_map(|a| others.iter().map(|b| (a.low_m.max(b.low_m), a.high_m.min(b.high_m))));
    shared.filter(|(low, high)| low < high).collect()
}

/// True if a stretch has the better part of one that both cells open, or lies in one. Where tiles share no vertices their
/// borders cross the line and each other with no hole between them.
fn is_between(s: &Stretch, both: &[(f64, f64)]) -> bool {
    let [low_m, high_m] = s.ends.map(|e| e.along_m);
    both.iter().any(|&(a, b)| high_m.min(b) - low_m.max(a) > 0.5 * (high_m - low_m).min(b - a))
}

/// A corner is as good as a vertex this many median edges from it.
const CORNER_EDGES: f64 = 0.75;

/// Where a cut leads from a corner to a vertex close by, all cuts at the corner go to that vertex instead.
fn leave_near_corners(cuts: &mut [Cut], edge_m: f64) {
    let mut near: BTreeMap<CornerId, (f64, CutEnd)> = BTreeMap::new();
    for cut in cuts.iter() {
        for (k, anchor) in [cut.curve.high, cut.curve.low].into_iter().enumerate() {
            let (Node::Corner(corner), Node::Vertex(_)) = (cut.nodes[k], cut.nodes[1 - k]) else { continue };
            let distance_m = cut.ends[0].distance(cut.ends[1]);
            let best = near.get(&corner).map_or(CORNER_EDGES * edge_m, |b| b.0);
            if distance_m < best {
                let end = CutEnd { anchor, node: cut.nodes[1 - k], place: cut.ends[1 - k] };
                near.insert(corner, (distance_m, end));
            }
        }
    }
    for cut in cuts {
        for k in [0, 1] {
            if let Node::Corner(corner) = cut.nodes[k]
                && let Some((_, end)) = near.get(&corner)
            {
                cut.nodes[k] = end.node;
                cut.ends[k] = end.place;
                let step_m = (0.5 * edge_m).min(0.5 * (cut.curve.high_m - cut.curve.low_m));
                if k == 0 {
                    (cut.curve.low, cut.curve.low_m) = (end.anchor, cut.curve.low_m + step_m);
                } else {
                    (cut.curve.high, cut.curve.high_m) = (end.anchor, cut.curve.high_m - step_m);
                }
            }
        }
        cut.toward = toward(&cut.curve, cut.nodes.map(|n| matches!(n, Node::Vertex(_))), edge_m);
    }
}

/// True if an open edge joins the ends of a cut: it would cut off nothing.
fn has_edge(open: &OpenEdges, cut: &Cut) -> bool {
    let [Node::Vertex(a), Node::Vertex(b)] = cut.nodes else { return false };
    let leads = |from, to| open.starting_at(from).any(|e| position_bits(open.list[e].ends[1]) == to);
    leads(a, b) || leads(b, a)
}

/// A curve of less than so many median edges has no point of its own.
const SHORT_EDGES: f64 = 1.5;

/// A corner inside a hole has all its stretches or none.
fn keep_whole_corners(all: &mut [(Stretch, bool)]) {
    let corners = |s: &Stretch| {
        s.ends.into_iter().filter_map(|e| match e.at {
            EndKind::Corner(corner) => Some(corner),
            EndKind::Edge(_) => None,
        })
    };
    loop {
        let kept: BTreeSet<CornerId> = all.iter().filter(|s| s.1).flat_map(|s| corners(&s.0)).collect();
        let mut grown = false;
        for (s, is_kept) in all.iter_mut().filter(|s| !s.1) {
            *is_kept = corners(s).any(|c| kept.contains(&c));
            grown |= *is_kept;
        }
        if !grown {
            return;
        }
    }
}

/// An open edge that crosses the line of a border.
#[derive(Clone, Copy)]
struct Crossing {
    along_m: f64,
    edge: usize,
    /// How many more holes lie on the line behind it than before it.
    opened: i32,
}

/// Crossings with those closer than `reach_m` taken as one where together they open or close: where borders that share no
/// vertices meet in a corner, both and the stub between them cross the line within decimetres, the stub backwards. Such a
/// group counts where the hole beyond it begins, and with an edge that opens or closes as the group does.
fn merged(crossings: &[Crossing], reach_m: f64) -> Vec<Crossing> {
    let mut rest = crossings;
    let mut found = Vec::new();
    while let Some(first) = rest.first() {
        let count = rest.partition_point(|c| c.along_m < first.along_m + reach_m);
        let (group, behind) = rest.split_at(count);
        let opened: i32 = group.iter().map(|c| c.opened).sum();
        let alike = |c: &&Crossing| c.opened.signum() == opened.signum();
        let (end, chosen) = match opened.signum() {
            1 => (group.last(), group.iter().rfind(alike)),
            -1 => (group.first(), group.iter().find(alike)),
            _ => (None, None),
        };
        match (end, chosen) {
            (Some(end), Some(chosen)) => {
                found.push(Crossing { along_m: end.along_m, edge: chosen.edge, opened });
            }
            _ => found.extend(group),
        }
        rest = behind;
    }
    found
}

/// The stretches of a border between its two corners that lie inside holes.
///
/// Each crossing counts: on the line lie as many holes over one another as opened and did not close again.
fn stretches(
    open: &OpenEdges,
    domain: &Domain,
    side: Side,
    pieces: &[&SidePiece],
    fit: &BorderFit,
) -> Vec<Stretch> {
    let cell = domain.cell;
    let line = domain.side(side).line;
    let last = if side == Side::South { Side::South } else { Side::North };
    let corners = [cell.corner_after(Side::West), cell.corner_after(last)];
    let [low_m, high_m] = [Side::West, last].map(|s| side.along(domain.corner_after(s)));
    let mut crossings = crossings(open, side, line, [2.0 * low_m - high_m, 2.0 * high_m - low_m]);
    if open.is_loose {
        crossings = merged(&crossings, LONGEST_STUB_EDGES * fit.edge_m);
    }
    let before = crossings.partition_point(|c| c.along_m < low_m);
    let middle_is_open = || {
        let middle_m = (low_m + high_m) / 2.0;
        let over = |p: &&&SidePiece| p.low_m < middle_m && p.high_m > middle_m;
        pieces.iter().filter(over).count() == 2
    };
    // What the first crossing closes was open before it.
    let first_depth = crossings.first().map_or(i32::from(middle_is_open()), |c| (-c.opened).max(0));
    let mut depth = crossings[..before].iter().fold(first_depth, |depth, c| (depth + c.opened).max(0));
    let mut found = Vec::new();
    let mut start = (depth > 0).then_some(StretchEnd { along_m: low_m, at: EndKind::Corner(corners[0]) });
    for c in crossings[before..].iter().take_while(|c| c.along_m < high_m) {
        let end = StretchEnd { along_m: c.along_m, at: EndKind::Edge(c.edge) };
        depth = (depth + c.opened).max(0);
        if depth > 0 {
            start.get_or_insert(end);
        } else if let Some(s) = start.take() {
            found.push(Stretch { cell, side, line, ends: [s, end] });
        }
    }
    if let Some(s) = start {
        let end = StretchEnd { along_m: high_m, at: EndKind::Corner(corners[1]) };
        found.push(Stretch { cell, side, line, ends: [s, end] });
    }
    found
}

/// The open edges that cross a line between two coordinates, in order along it.
fn crossings(open: &OpenEdges, side: Side, line: f64, [low_m, high_m]: [f64; 2]) -> Vec<Crossing> {
    let up = side.point(1.0, 0.0) - side.point(0.0, 0.0);
    let near = open.near(side.point(low_m, line), side.point(high_m, line));
    let mut found: Vec<Crossing> = near
        .into_iter()
        .filter_map(|edge| {
            let [a, b] = open.list[edge].ends.map(|p| p.truncate());
            let [from, to] = [a, b].map(|p| side.across(p) - line);
            if (from > 0.0) == (to > 0.0) {
                return None;
            }
            let along_m = side.along(a) + from / (from - to) * (side.along(b) - side.along(a));
            let opened = if (b - a).perp().dot(up) > 0.0 { 1 } else { -1 };
            Some(Crossing { along_m, edge, opened })
        })
        .collect();
    found.sort_by(|x, y| x.along_m.total_cmp(&y.along_m).then(x.edge.cmp(&y.edge)));
    found
}

/// A stretch as a cut; `None` if both its ends go to one vertex.
fn cut(open: &OpenEdges, s: &Stretch, fit: &BorderFit) -> Option<Cut> {
    let [low_m, high_m] = s.ends.map(|e| e.along_m);
    let step_m = (0.5 * fit.edge_m).min(0.5 * (high_m - low_m));
    let low = end_at(open, s, s.ends[0], low_m + step_m);
    let high = end_at(open, s, s.ends[1], high_m - step_m);
    if low.node == high.node {
        return None;
    }
    // The curve comes to the line where its vertices see it, and stays on it.
    let is_edge = |end: StretchEnd| matches!(end.at, EndKind::Edge(_));
    let low_m = if is_edge(s.ends[0]) { low_m + step_m } else { low_m };
    let high_m = if is_edge(s.ends[1]) { (high_m - step_m).max(low_m) } else { high_m };
    let curve = Curve {
        border: s.cell.border(s.side),
        kind: CurveKind::Shared,
        line: s.line,
        low_m,
        high_m,
        low: low.anchor,
        high: high.anchor,
        holes: Vec::new(),
        over: Vec::new(),
    };
    let mut cells = [None; 2];
    for (cell, side) in [(s.cell, s.side), (s.cell.neighbour(s.side), s.side.opposite())] {
        cells[usize::from(!side.runs_upward())] = Some((cell, side));
    }
    let toward = toward(&curve, s.ends.map(is_edge), fit.edge_m);
    let ends = [low, high];
    Some(Cut { curve, nodes: ends.map(|e| e.node), ends: ends.map(|e| e.place), toward, cells })
}

/// What is seen of a curve from its ends: where it comes to the line, or from a corner a point farther along.
fn toward(curve: &Curve, comes_to_line: [bool; 2], edge_m: f64) -> [DVec2; 2] {
    let step_m = (0.7 * edge_m).min(0.5 * (curve.high_m - curve.low_m));
    let at = |k: usize, end_m: f64, inward: f64| {
        let along_m = if comes_to_line[k] { end_m } else { end_m + inward * step_m };
        curve.border.side.point(along_m, curve.line)
    };
    [at(0, curve.low_m, 1.0), at(1, curve.high_m, -1.0)]
}

/// An end of a cut.
#[derive(Clone, Copy)]
pub(crate) struct CutEnd {
    pub(crate) anchor: Anchor,
    pub(crate) node: Node,
    pub(crate) place: DVec2,
}

/// A cut from its curve and ends.
pub(crate) fn new_cut(
    curve: Curve,
    ends: [CutEnd; 2],
    cells: [Option<(CellId, Side)>; 2],
    side: Side,
    edge_m: f64,
) -> Cut {
    let places = ends.map(|e| e.place);
    let length_m = curve.high_m - curve.low_m;
    let toward = if length_m < SHORT_EDGES * edge_m {
        [places[1], places[0]]
    } else {
        let step_m = (0.7 * edge_m).min(0.5 * length_m);
        [curve.low_m + step_m, curve.high_m - step_m].map(|m| side.point(m, curve.line))
    };
    Cut { curve, nodes: ends.map(|e| e.node), ends: places, toward, cells }
}

/// The vertex (or corner) where a stretch ends: of the crossing edge's ends the one nearer to the line that sees it
/// `first_m` along, else the nearer one; beside another tile's loose border a vertex of that.
fn end_at(open: &OpenEdges, s: &Stretch, end: StretchEnd, first_m: f64) -> CutEnd {
    let edge = match end.at {
        EndKind::Corner(corner) => {
            let place = s.side.point(end.along_m, s.line);
            return CutEnd { anchor: Anchor::Corner(corner), node: Node::Corner(corner), place };
        }
        EndKind::Edge(edge) => &open.list[edge],
    };
    let first = s.side.point(first_m, s.line);
    let off_m = |e: &CutEnd| (s.side.across(e.place) - s.line).abs();
    let mut ends = edge_ends(edge).to_vec();
    ends.sort_by(|a, b| off_m(a).total_cmp(&off_m(b)).then(a.node.cmp(&b.node)));
    let chosen = *ends.iter().find(|e| sees(open, e.place, first)).unwrap_or(&ends[0]);
    let Node::Vertex(place) = chosen.node else { return chosen };
    let Some(turned) = open.turned(place) else { return chosen };
    let mut others: Vec<CutEnd> = turned.iter().flat_map(|&e| edge_ends(&open.list[e])).collect();
    let reach_m = |e: &CutEnd| e.place.distance(first);
    others.sort_by(|a, b| reach_m(a).total_cmp(&reach_m(b)).then(a.node.cmp(&b.node)));
    *others.iter().find(|e| sees(open, e.place, first)).unwrap_or(&chosen)
}

/// Both ends of an open edge as ends of a cut.
fn edge_ends(edge: &OpenEdge) -> [CutEnd; 2] {
    [0, 1].map(|k| {
        let (cell, point) = edge.points[k];
        let node = Node::Vertex(position_bits(edge.ends[k]));
        CutEnd { anchor: Anchor::Point(cell, point), node, place: edge.ends[k].truncate() }
    })
}

/// True if no open edge lies between a vertex and a point of the line.
fn sees(open: &OpenEdges, vertex: DVec2, point: DVec2) -> bool {
    open.near(vertex, point).into_iter().all(|e| {
        let [a, b] = open.list[e].ends.map(|p| p.truncate());
        a == vertex || b == vertex || segments_cross(vertex, point, a, b) == Meeting::Apart
    })
}
