//! The last look at a cluster before it is written: do the patches of all its cells close it, with nothing left open?

use super::solve::{FilledHole, Fills};
use super::stubs::Stubs;
use glam::{DVec2, DVec3};
use lacuna_close::{Curves, Source};
use lacuna_grid::{CellId, Side};
use lacuna_hole::{Anchor, BorderMode, CellSurvey, CurveKind, Hole, Piece, Plan, Span, Surveys};
use lacuna_mesh::{Meeting, find_meetings, position_bits};
use std::collections::{BTreeMap, BTreeSet};

/// The bits of a position.
pub(super) type Place = [u64; 3];

/// A directed edge, the missing surface on its left.
pub(super) type Edge = [Place; 2];

/// What a cluster's patches are judged by.
pub(crate) struct Watertight<'a> {
    pub(crate) surveys: &'a Surveys,
    pub(crate) plan: &'a Plan,
    pub(crate) curves: &'a Curves,
}

impl Watertight<'_> {
    /// Why the patches of a cluster do not close it, if so. `None` also if a hole of it has no patch.
    ///
    /// The outlines of its patches are taken together. Each of their edges is one of: a boundary edge of a tile that
    /// nothing else meets; an edge that another patch has in the other direction; an edge along the area's border, or over a
    /// cut inside a tile. And every rim edge is among them. Where tiles share no vertices along their borders what they
    /// delivered is open there: stubs between vertices of two tiles may be free, too, if they leave no crack. Where they
    /// overlap their patches share no edges: there only the rims are judged.
    pub(crate) fn defect(&self, cluster: u32, fills: &Fills) -> Option<String> {
        let holes = &self.plan.clusters.get(cluster as usize)?.holes;
        let filled: Vec<(&Hole, &FilledHole)> = holes
            .iter()
            .filter_map(|h| Some((&self.plan.holes[*h as usize], fills.get(h)?.as_ref().ok()?)))
            .collect();
        if filled.len() < holes.len() {
            return None;
        }
        let overlapping = matches!(self.plan.fit.mode, BorderMode::Overrun | BorderMode::Overlap);
        if overlapping {
            return filled.iter().find_map(|pair| self.open_rim(&[*pair], &self.outlines(&[*pair]).ok()?));
        }
        let outlines = match self.outlines(&filled) {
            Ok(outlines) => outlines,
            Err(place) => return Some(told(place, "two patches have one edge")),
        };
        self.open_rim(&filled, &outlines)
            .or_else(|| self.open_edge(&filled, &outlines))
            .or_else(|| filled.iter().find_map(|(_, fill)| self.crossed_line(fill)))
    }

    /// Where a closing line of ragged tiles crosses the outline; of tiles that share no vertices, any part of it.
    fn crossed_line(&self, fill: &FilledHole) -> Option<String> {
        let is_made = |s: &Source| matches!(s, Source::Closing(_) | Source::Corner(_));
        let has_line = !self.plan.tiles_meet || fill.sources.iter().any(is_made);
        if self.plan.fit.mode != BorderMode::Ragged || !has_line {
            return None;
        }
        let (mut rings, mut next): (Vec<Vec<DVec2>>, Vec<usize>) = (Vec::new(), Vec::new());
        for &length in &fill.ring_lengths {
            let first = next.len();
            rings.push(fill.rim[first..first + length].iter().map(|p| p.truncate()).collect());
            next.extend((0..length).map(|k| first + (k + 1) % length));
        }
        let rings: Vec<&[DVec2]> = rings.iter().map(Vec::as_slice).collect();
        let is_line =
            |e: usize| !self.plan.tiles_meet || is_made(&fill.sources[e]) || is_made(&fill.sources[next[e]]);
        let crossing = find_meetings(&rings)
            .into_iter()
            .find(|p| p.meeting != Meeting::Touching && (is_line(p.first) || is_line(p.second)))?;
        Some(told(fill.rim[crossing.first], "the line between the cells crosses a rim"))
    }

    /// All edges of the outlines of some patches, each with where it starts; an edge that comes twice is the error.
    fn outlines(&self, filled: &[(&Hole, &FilledHole)]) -> Result<BTreeMap<Edge, DVec3>, DVec3> {
        let mut outlines = BTreeMap::new();
        for (_, fill) in filled {
            let places: Vec<Place> = (0..fill.rim.len()).map(|k| self.place(fill, k)).collect();
            let mut first = 0;
            for &length in &fill.ring_lengths {
                for k in 0..length {
                    let (a, b) = (first + k, first + (k + 1) % length);
                    if outlines.insert([places[a], places[b]], fill.rim[a]).is_some() {
                        return Err(fill.rim[a]);
                    }
                }
                first += length;
            }
        }
        Ok(outlines)
    }

    /// Where a contour vertex is; closing points as the curves have them, however the tiles round them.
    fn place(&self, fill: &FilledHole, vertex: usize) -> Place {
        let shared = match fill.sources[vertex] {
            Source::Closing(p) => {
                self.curves.curves.get(p.curve as usize).and_then(|c| c.inner.get(p.point as usize))
            }
            Source::Corner(corner) => self.curves.corners.get(&corner),
            Source::Original(_) | Source::Adopted(..) | Source::Square(_) => None,
        };
        position_bits(*shared.unwrap_or(&fill.rim[vertex]))
    }

    /// A rim edge that no outline has.
    fn open_rim(&self, filled: &[(&Hole, &FilledHole)], outlines: &BTreeMap<Edge, DVec3>) -> Option<String> {
        filled.iter().find_map(|(hole, _)| {
            let survey = self.surveys.get(&hole.cell)?;
            let open = hole.rim_edges(survey).find(|&e| !outlines.contains_key(&edge(survey, e)))?;
            Some(told(survey.from(open), "an edge of the rim stays open"))
        })
    }

    /// An edge of the outlines that nothing meets, or more than one surface.
    fn open_edge(&self, filled: &[(&Hole, &FilledHole)], outlines: &BTreeMap<Edge, DVec3>) -> Option<String> {
        let tiles = self.tile_edges(filled, outlines);
        let mut free: Option<Vec<BTreeSet<Place>>> = None;
        let mut stubs: Option<Stubs<'_>> = None;
        outlines.iter().find_map(|(&[a, b], &place)| {
            let met = [tiles.contains(&[a, b]), outlines.contains_key(&[b, a]), tiles.contains(&[b, a])];
            match met {
                [true, false, false] | [false, true, false] => None,
                [false, false, false] => {
                    let free = free.get_or_insert_with(|| self.free_places(filled));
                    if free.iter().any(|places| places.contains(&a) && places.contains(&b)) {
                        return None;
                    }
                    let what = if self.plan.tiles_meet {
                        Some("an edge stays open: the tiles do not meet there")
                    } else {
                        let stubs = stubs.get_or_insert_with(|| Stubs::new(self, filled, outlines));
                        stubs.defect([a, b])
                    };
                    what.map(|what| told(place, what))
                }
                _ => Some(told(place, "three surfaces would meet in one edge")),
            }
        })
    }

    /// Boundary edges of the cluster's cells, and of those whose border it takes, that begin or end on the outlines.
    fn tile_edges(
        &self,
        filled: &[(&Hole, &FilledHole)],
        outlines: &BTreeMap<Edge, DVec3>,
    ) -> BTreeSet<Edge> {
        let places: BTreeSet<Place> = outlines.keys().map(|e| e[0]).collect();
        let cells: BTreeSet<CellId> = filled.iter().flat_map(|(hole, _)| cells_of(hole)).collect();
        let surveys = cells.iter().filter_map(|c| self.surveys.get(c));
        let edges = surveys.flat_map(|s| (0..s.boundary.edges.len() as u32).map(|e| edge(s, e)));
        edges.filter(|[a, b]| places.contains(a) && places.contains(b)).collect()
    }

    /// Sets of places between which edges may end free: those of each curve along the area's border, and both sides of each
    /// cut inside a tile.
    fn free_places(&self, filled: &[(&Hole, &FilledHole)]) -> Vec<BTreeSet<Place>> {
        let mut sets = Vec::new();
        for (hole, _) in filled {
            for piece in &hole.outer {
                let Piece::Side { spans, .. } = piece else { continue };
                for span in spans {
                    if let Span::Curve(c) = span
                        && self.plan.curves[*c as usize].kind != CurveKind::Shared
                    {
                        sets.push(self.curve_places(*c));
                    }
                }
            }
            sets.extend(self.bridges(hole));
        }
        sets
    }

    fn curve_places(&self, c: u32) -> BTreeSet<Place> {
        let curve = &self.plan.curves[c as usize];
        let anchor = |anchor| match anchor {
            Anchor::Point(cell, point) => Some(self.surveys.get(&cell)?.position(point)),
            Anchor::Corner(corner) => match self.plan.corner_vertex(corner) {
                Some(Anchor::Point(cell, point)) => Some(self.surveys.get(&cell)?.position(point)),
                _ => self.curves.corners.get(&corner).copied(),
            },
            Anchor::Free => None,
        };
        let ends = [curve.low, curve.high].into_iter().filter_map(anchor);
        let inner = self.curves.curves.get(c as usize).into_iter().flat_map(|c| c.inner.iter().copied());
        ends.chain(inner).map(position_bits).collect()
    }

    /// The ends of each straight edge over a cut inside the tile. One along a border is no cut.
    fn bridges(&self, hole: &Hole) -> Vec<BTreeSet<Place>> {
        let (Some(survey), Some(domain)) = (self.surveys.get(&hole.cell), self.plan.domains.get(&hole.cell))
        else {
            return Vec::new();
        };
        let on_border = |p: DVec3| {
            Side::ALL.iter().any(|&s| domain.outside_m(s, p.truncate()).abs() <= self.plan.fit.gap_m)
        };
        let n = hole.outer.len();
        let ends = (0..n).filter(|&k| hole.outer[k] == Piece::Bridge).filter_map(|k| {
            let (Piece::Rim(before), Piece::Rim(after)) =
                (&hole.outer[(k + n - 1) % n], &hole.outer[(k + 1) % n])
            else {
                return None;
            };
            Some([survey.to(*before.last()?), survey.from(*after.first()?)])
        });
        ends.filter(|ends| !ends.iter().all(|p| on_border(*p)))
            .map(|ends| ends.map(position_bits).into())
            .collect()
    }
}

/// The cell of a hole, and those whose border it takes.
pub(super) fn cells_of(hole: &Hole) -> Vec<CellId> {
    let mut cells = vec![hole.cell];
    for piece in &hole.outer {
        let Piece::Side { spans, .. } = piece else { continue };
        cells.extend(spans.iter().filter_map(|s| match s {
            Span::Adopted { neighbour, .. } => Some(*neighbour),
            Span::Curve(_) => None,
        }));
    }
    cells
}

pub(super) fn edge(survey: &CellSurvey, e: u32) -> Edge {
    [survey.from(e), survey.to(e)].map(position_bits)
}

fn told(place: DVec3, what: &str) -> String {
    format!("the patches of its cells do not close it at {:.3}, {:.3}: {what}", place.x, place.y)
}
