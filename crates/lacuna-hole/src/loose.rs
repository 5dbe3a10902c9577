//! Ragged borders of tiles that share no vertices: each tile was cut and triangulated apart. What both delivered along a
//! border stays as it is; stubs lead from where it ends in one tile to where it ends in the other.

use crate::box_tree::BoxTree;
use crate::label::border_side;
use crate::open_edges::{OpenEdge, Place, flat_box};
use crate::shared::CellView;
use crate::{BorderFit, Surveys};
use glam::{DVec2, DVec3};
use lacuna_grid::{Area, CellId, Grid, Side, SideLabel};
use lacuna_mesh::{PointId, position_bits, side_of_line};
use std::collections::{BTreeMap, BTreeSet};

/// Tiles share their borders if at least this part of the edges on them is met by the neighbour's.
const SHARED_PART: f64 = 0.25;

/// Stubs are at most so many median edges long: an edge along the border, and how far both tiles may stray.
pub(crate) const LONGEST_STUB_EDGES: f64 = 4.0;

/// True if ragged tiles share the vertices along their borders: of the delivered edges that lie on a border between two
/// tiles enough are met by one in the other direction, bit for bit. With no such edges nothing contradicts.
#[must_use]
pub fn share_borders(surveys: &Surveys, grid: &Grid, area: &Area, fit: &BorderFit) -> bool {
    let mut edges: Vec<[Place; 2]> = Vec::new();
    for survey in surveys.values() {
        let domain = fit.domain(grid, area, survey.cell);
        let has_surface = |side: Side| match domain.side(side).label {
            SideLabel::Neighbour(other) => surveys.get(&other).is_some_and(|o| !o.boundary.edges.is_empty()),
            SideLabel::External => false,
        };
        let all = 0..survey.boundary.edges.len() as u32;
        let on_border = all.filter(|&e| border_side(survey, &domain, fit, e).is_some_and(has_surface));
        edges.extend(on_border.map(|e| [survey.from(e), survey.to(e)].map(position_bits)));
    }
    let known: BTreeSet<[Place; 2]> = edges.iter().copied().collect();
    let met = edges.iter().filter(|[a, b]| known.contains(&[*b, *a])).count();
    met as f64 >= SHARED_PART * edges.len() as f64
}

/// True if a stub (the edge on which a patch of `owner` ends between two tiles that share no vertices) leaves a crack
/// beside it: it runs rather along a border than across, and one of its ends lies before an edge of the tile beyond, or a
/// vertex of that tile before it. Before an edge is the side on which it has no surface; what lies behind one is covered by
/// both tiles, and no crack. The stub has its patch on the left. `free` are edges that nothing meets, the missing surface on
/// their left, with their cells; those farther than `reach_m` from the stub do not count.
#[must_use]
pub fn is_cracked_stub(stub: [DVec3; 2], owner: CellId, free: &[(CellId, [DVec3; 2])], reach_m: f64) -> bool {
    let [a, b] = stub.map(|p| p.truncate());
    let [low, high] = [a.min(b) - DVec2::splat(reach_m), a.max(b) + DVec2::splat(reach_m)];
    let is_near = |f: &[DVec2; 2]| f[0].min(f[1]).cmple(high).all() && f[0].max(f[1]).cmpge(low).all();
    let runs_along = |side: Side, [from, to]: [DVec2; 2]| {
        (side.along(to) - side.along(from)).abs() >= (side.across(to) - side.across(from)).abs()
    };
    Side::ALL.into_iter().filter(|&side| runs_along(side, [a, b])).any(|side| {
        let beyond = owner.neighbour(side);
        let theirs = free.iter().filter(|f| f.0 == beyond).map(|f| f.1.map(|p| p.truncate()));
        let theirs: Vec<[DVec2; 2]> = theirs.filter(|f| is_near(f) && runs_along(side, *f)).collect();
        let covers = |[from, to]: [DVec2; 2], p: DVec2| {
            let [from, to, at] = [from, to, p].map(|p| side.along(p));
            from.min(to) <= at && at <= from.max(to)
        };
        let is_before = |[from, to]: [DVec2; 2], p: DVec2| side_of_line(from, to, p) > 0.0;
        let is_over = |p: DVec2| {
            theirs.iter().all(|f| !f.contains(&p)) && theirs.iter().any(|f| covers(*f, p) && is_before(*f, p))
        };
        let is_under = |p: DVec2| p != a && p != b && covers([a, b], p) && is_before([b, a], p);
        is_over(a) || is_over(b) || theirs.iter().flatten().any(|&p| is_under(p))
    })
}

/// The boundary edges on borders that no hole opens: beyond the area, or over a stretch that the other tile covers, too.
/// Sorted.
///
/// Where the other tile's border ends beside the middle of an edge, the edge is open if the other tile falls short of it
/// there: a patch can begin behind that end. Where they overlap it would have to fold back.
pub(crate) fn facing_edges(views: &BTreeMap<CellId, CellView<'_>>) -> Vec<(CellId, u32)> {
    let mut covers: BTreeMap<(CellId, Side), Cover> = BTreeMap::new();
    for (&cell, view) in views {
        for side in Side::ALL {
            covers.insert((cell, side), Cover::new(view, side));
        }
    }
    let mut facing = Vec::new();
    for (&cell, view) in views {
        for run in &view.coverage.runs {
            let other = match view.domain.side(run.side).label {
                SideLabel::Neighbour(other) => covers.get(&(other, run.side.opposite())),
                SideLabel::External => None,
            };
            let is_external = view.domain.side(run.side).label == SideLabel::External;
            let is_facing = |e: &&u32| is_external || other.is_some_and(|c| c.faces(view, run.side, **e));
            facing.extend(run.edges.iter().filter(is_facing).map(|&e| (cell, e)));
        }
    }
    facing.sort_unstable();
    facing
}

/// Stubs between the ends of chains of open edges: from where one tile's end to where another's begin, nearest pairs first.
pub(crate) fn stubs(open: &[OpenEdge], fit: &BorderFit) -> Vec<OpenEdge> {
    let [starts, ends] = loose_ends(open);
    let longest_m = LONGEST_STUB_EDGES * fit.edge_m;
    let reach = DVec2::splat(longest_m);
    let tree = BoxTree::new(starts.iter().map(|s| flat_box(s.place, s.place)));
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (e, end) in ends.iter().enumerate() {
        let near = tree.touching(&flat_box(end.place - reach, end.place + reach));
        for s in near.into_iter().filter(|&s| starts[s].cell != end.cell) {
            let length_m = end.place.distance(starts[s].place);
            if length_m <= longest_m {
                pairs.push((length_m, e, s));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut used_ends, mut used_starts) = (BTreeSet::new(), BTreeSet::new());
    let mut stubs = Vec::new();
    for (_, e, s) in pairs {
        if !used_ends.contains(&e) && !used_starts.contains(&s) {
            used_ends.insert(e);
            used_starts.insert(s);
            let (from, to) = (&ends[e], &starts[s]);
            stubs.push(OpenEdge {
                of: None,
                is_border: false,
                ends: [from.position, to.position],
                points: [from, to].map(|end| (end.cell, end.point)),
            });
        }
    }
    stubs
}

/// Most edges of the other tile's border that are looked at for another end of a cut.
const MOST_TURNED: usize = 8;

/// Where a rim ends beside the other tile's border, a stub leads to that border, and the hole of the rim's cell has it on
/// its outline: no cut may end at the rim's end, between the two. It may at the vertices of the other tile's border, up to
/// the end of that tile's rim: here the edges that have them as ends, with the missing surface's direction.
pub(crate) fn turned_ends(open: &[OpenEdge], stubs: &[OpenEdge]) -> BTreeMap<Place, Vec<usize>> {
    let mut at: [BTreeMap<Place, usize>; 2] = [BTreeMap::new(), BTreeMap::new()];
    for (k, edge) in open.iter().enumerate() {
        for (way, at) in at.iter_mut().enumerate() {
            at.entry(position_bits(edge.ends[way])).or_insert(k);
        }
    }
    let mut turned = BTreeMap::new();
    for stub in stubs {
        let [from, to] = stub.ends.map(position_bits);
        let (Some(&before), Some(&after)) = (at[1].get(&from), at[0].get(&to)) else { continue };
        // (the rim's end, first edge of the other border, which end of an edge leads on)
        let (end, first, way) = match (open[before].is_border, open[after].is_border) {
            (false, true) => (from, after, 1),
            (true, false) => (to, before, 0),
            _ => continue,
        };
        let next = |&k: &usize| at[1 - way].get(&position_bits(open[k].ends[way])).copied();
        let is_border = |k: &usize| open[*k].is_border;
        let along = std::iter::successors(Some(first), next).take_while(is_border).take(MOST_TURNED);
        turned.insert(end, along.collect());
    }
    turned
}

/// A vertex at which more open edges begin than end, or the other way round.
struct LooseEnd {
    cell: CellId,
    point: PointId,
    position: DVec3,
    place: DVec2,
}

/// Where chains of open edges start, and where they end; each in the order of the edges.
fn loose_ends(open: &[OpenEdge]) -> [Vec<LooseEnd>; 2] {
    let mut balance: BTreeMap<Place, i32> = BTreeMap::new();
    for edge in open {
        *balance.entry(position_bits(edge.ends[0])).or_default() += 1;
        *balance.entry(position_bits(edge.ends[1])).or_default() -= 1;
    }
    [0, 1].map(|k| {
        let sign = if k == 0 { 1 } else { -1 };
        let mut left: BTreeMap<Place, i32> =
            balance.iter().filter(|b| b.1.signum() == sign).map(|(p, n)| (*p, n.abs())).collect();
        let mut found = Vec::new();
        for edge in open {
            let position = edge.ends[k];
            if let Some(count) = left.get_mut(&position_bits(position)).filter(|n| **n > 0) {
                *count -= 1;
                let (cell, point) = edge.points[k];
                found.push(LooseEnd { cell, point, position, place: position.truncate() });
            }
        }
        found
    })
}

/// Which stretches of a side a tile's border covers.
struct Cover {
    /// Intervals of the coordinate along the side, ascending, apart from each other.
    covered: Vec<(f64, f64)>,
    /// Where rims end on the side: coordinate along it, and across.
    rim_ends: Vec<DVec2>,
}

impl Cover {
    fn new(view: &CellView<'_>, side: Side) -> Self {
        let survey = view.survey;
        let record = |e: u32| &survey.boundary.edges[e as usize];
        let chains = &view.coverage.chains;
        let chain_starts: BTreeSet<_> =
            chains.iter().filter_map(|c| c.edges.first()).map(|&e| record(e).from).collect();
        let chain_ends: BTreeSet<_> =
            chains.iter().filter_map(|c| c.edges.last()).map(|&e| record(e).to).collect();
        let place = |p: DVec3| DVec2::new(side.along(p.truncate()), side.across(p.truncate()));
        let (mut intervals, mut rim_ends) = (Vec::new(), Vec::new());
        for run in view.coverage.runs.iter().filter(|r| r.side == side) {
            let (Some(&first), Some(&last)) = (run.edges.first(), run.edges.last()) else { continue };
            let [begin, finish] = [survey.from(first), survey.to(last)].map(place);
            let along = run.edges.iter().map(|&e| place(survey.to(e)).x).chain([begin.x]);
            let (mut low, mut high) =
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m), h.max(m)));
            let is_rim = [chain_ends.contains(&record(first).from), chain_starts.contains(&record(last).to)];
            for (end, other, is_rim) in [(begin, finish, is_rim[0]), (finish, begin, is_rim[1])] {
                if is_rim {
                    rim_ends.push(end);
                } else if end.x < other.x {
                    // Round a corner the border goes on along the next side.
                    low = f64::NEG_INFINITY;
                } else {
                    high = f64::INFINITY;
                }
            }
            intervals.push((low, high));
        }
        Self { covered: union(intervals), rim_ends }
    }

    /// True if an edge of the tile on the other side of the border faces nothing but what is covered.
    fn faces(&self, other: &CellView<'_>, side: Side, edge: u32) -> bool {
        let place = |p: DVec3| DVec2::new(side.along(p.truncate()), side.across(p.truncate()));
        let [a, b] = [other.survey.from(edge), other.survey.to(edge)].map(place);
        let (low, high) = if a.x <= b.x { (a, b) } else { (b, a) };
        if self.covered.iter().any(|c| c.0 <= low.x && c.1 >= high.x) {
            return true;
        }
        let outward = side.outward().x + side.outward().y;
        self.rim_ends.iter().filter(|end| end.x > low.x && end.x < high.x).any(|end| {
            let at = low.y + (end.x - low.x) / (high.x - low.x) * (high.y - low.y);
            (at - end.y) * outward > 0.0
        })
    }
}

/// The union of intervals.
fn union(mut intervals: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (low, high) in intervals {
        match merged.last_mut() {
            Some(last) if low <= last.1 => last.1 = last.1.max(high),
            _ => merged.push((low, high)),
        }
    }
    merged
}
