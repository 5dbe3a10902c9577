//! Overlap squares: where tiles overrun their cell, the cells round a grid corner overlap in a square about it.

use crate::Curves;
use glam::{DVec2, DVec3};
use lacuna_grid::{CellId, CornerId, Side};
use lacuna_hole::{Anchor, BorderMode, Curve, CurveKind, Piece, Plan, Span, Surveys};
use std::collections::BTreeMap;

/// A corner of an overlap square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SquarePoint {
    /// The grid corner.
    pub corner: CornerId,
    /// 0 to 3: south-west, south-east, north-west, north-east; 4 to 7: the middle of the south, east, north, west edge.
    pub at: u8,
}

impl SquarePoint {
    /// True for the middle of an edge: its height is that of the edge.
    pub(crate) fn is_middle(self) -> bool {
        self.at > 3
    }
}

/// The square about a grid corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    corner: CornerId,
    /// Lower and upper x, lower and upper y.
    lines: [[f64; 2]; 2],
}

impl Square {
    /// The square of a corner of tiles that overrun their cell. What a missing cell does not say its neighbours do: all
    /// overrun by the same margin.
    pub(crate) fn of(plan: &Plan, corner: CornerId) -> Option<Self> {
        if plan.fit.mode != BorderMode::Overrun {
            return None;
        }
        let width_m = 2.0 * plan.fit.margin_m;
        let [south_west, south_east, north_west, north_east] = corner.cells();
        let line = |cells: [CellId; 2], side: Side| {
            cells.iter().find_map(|c| plan.domains.get(c)).map(|d| d.side(side).line)
        };
        let pair = |low: Option<f64>, high: Option<f64>| match (low, high) {
            (Some(low), Some(high)) => Some([low, high]),
            (Some(low), None) => Some([low, low + width_m]),
            (None, Some(high)) => Some([high - width_m, high]),
            (None, None) => None,
        };
        let x = pair(line([south_east, north_east], Side::West), line([south_west, north_west], Side::East))?;
        let y =
            pair(line([north_west, north_east], Side::South), line([south_west, south_east], Side::North))?;
        Some(Self { corner, lines: [x, y] })
    }

    fn corner_place(&self, at: u8) -> DVec2 {
        DVec2::new(self.lines[0][usize::from(at & 1)], self.lines[1][usize::from(at >> 1)])
    }

    /// A point with the heights of the four corners.
    fn vertex(&self, at: u8, heights_m: &[f64; 4]) -> DVec3 {
        let corner = |k: u8| self.corner_place(k).extend(heights_m[usize::from(k)]);
        match at {
            4..8 => {
                let [a, b] = EDGES[usize::from(at - 4)];
                corner(a).midpoint(corner(b))
            }
            _ => corner(at & 3),
        }
    }

    /// Where a cell's own line meets the square on its side that the cell shares with no strip: on the side's line, as
    /// near to the cell as the square is.
    pub(crate) fn lone_end(&self, cell: CellId, side: Side) -> Option<SquarePoint> {
        let near = quadrant(self.corner, cell)?;
        let far = 3 - near;
        let at = if side.is_horizontal() { (near & 1) | (far & 2) } else { (far & 1) | (near & 2) };
        Some(SquarePoint { corner: self.corner, at })
    }

    /// The square as a cell brings it: two triangles. Of the two cells across the square from each other that end on the
    /// same edges of it one pair has a point more on each: in the scene as a whole no edge is the outline of two patches.
    pub(crate) fn triangles(&self, cell: CellId) -> Vec<[SquarePoint; 3]> {
        let point = |at: u8| SquarePoint { corner: self.corner, at };
        let triangles: &[[u8; 3]] = match quadrant(self.corner, cell) {
            Some(1) => &[[0, 1, 3], [0, 3, 6], [0, 6, 7], [7, 6, 2]],
            Some(2) => &[[0, 4, 3], [4, 5, 3], [4, 1, 5], [0, 3, 2]],
            _ => &[[0, 1, 3], [0, 3, 2]],
        };
        triangles.iter().map(|t| t.map(point)).collect()
    }

    fn meets(&self, a: DVec2, b: DVec2, slack_m: f64) -> bool {
        (0..2).all(|axis| {
            let [low, high] = self.lines[axis];
            a[axis].min(b[axis]) <= high + slack_m && a[axis].max(b[axis]) >= low - slack_m
        })
    }
}

/// The corners of the square's south, east, north and west edges.
const EDGES: [[u8; 2]; 4] = [[0, 1], [1, 3], [2, 3], [0, 2]];

/// Where a strip along a border ends in a square: at the low or the high end of the strip, on its lower or upper line.
pub(crate) fn strip_end(corner: CornerId, side: Side, is_low_end: bool, is_upper: bool) -> SquarePoint {
    let (along, across) = (u8::from(is_low_end), u8::from(is_upper));
    SquarePoint { corner, at: if side.is_horizontal() { along + 2 * across } else { across + 2 * along } }
}

/// Which of the four cells round a corner a cell is: also the number of the square's point that lies deepest in it.
fn quadrant(corner: CornerId, cell: CellId) -> Option<u8> {
    corner.cells().iter().position(|&c| c == cell).map(|k| k as u8)
}

/// A vertex of a square that is shared.
pub(crate) fn square_vertex(plan: &Plan, curves: &Curves, point: SquarePoint) -> Option<DVec3> {
    let heights_m = curves.squares.get(&point.corner)?;
    Some(Square::of(plan, point.corner)?.vertex(point.at, heights_m))
}

/// Where the squares at the low and the high end of a shared stretch begin, coordinates along it: there both cells have a
/// point. Short stretches have none.
pub(crate) fn square_ends(plan: &Plan, curve: &Curve) -> [Option<f64>; 2] {
    let is_long = curve.high_m - curve.low_m > 12.0 * plan.fit.margin_m;
    if curve.kind != CurveKind::Shared || !is_long {
        return [None, None];
    }
    let lines = |anchor| match anchor {
        Anchor::Corner(corner) => {
            let [x, y] = Square::of(plan, corner)?.lines;
            Some(if curve.border.side.is_horizontal() { x } else { y })
        }
        _ => None,
    };
    [lines(curve.low).map(|l| l[1]), lines(curve.high).map(|l| l[0])]
}

/// Finds the squares that all open cells round a corner share: every stretch of theirs ends in the corner itself, those
/// between two of them with a strip, and no rim reaches into the square. Their heights are those of the corners.
pub(crate) fn mark_squares(surveys: &Surveys, plan: &Plan, curves: &mut Curves) {
    let mut found: BTreeMap<CornerId, bool> = BTreeMap::new();
    for (hole, corner, spans) in holes_round_corners(plan) {
        let ends = spans.map(|span| span.map_or(End::Other, |s| end_of(plan, curves, s, corner)));
        let is_shared = !ends.contains(&End::Other)
            && ends.contains(&End::Strip)
            && !has_rim_in_square(surveys, plan, hole, corner);
        found.entry(corner).and_modify(|all| *all &= is_shared).or_insert(is_shared);
    }
    for corner in found.into_iter().filter(|f| f.1).map(|f| f.0) {
        if let Some(p) = curves.corners.get(&corner) {
            curves.squares.insert(corner, [p.z; 4]);
        }
    }
}

/// How a stretch ends at a corner.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// With a strip that two cells share.
    Strip,
    /// On the cell's own line.
    Lone,
    /// Not at the corner, or with a strip that is not free.
    Other,
}

fn end_of(plan: &Plan, curves: &Curves, span: &Span, corner: CornerId) -> End {
    let Span::Curve(c) = *span else { return End::Other };
    let (curve, strip) = (&plan.curves[c as usize], &curves.curves[c as usize].strip);
    let last = strip.shared.len().saturating_sub(1);
    let ends = [(curve.low, 0, 0), (curve.high, last, 1)];
    let Some((_, step, k)) = ends.into_iter().find(|e| e.0 == Anchor::Corner(corner)) else {
        return End::Other;
    };
    match (curve.kind, strip.is_whole(step), square_ends(plan, curve)[k]) {
        (CurveKind::Shared, true, Some(_)) => End::Strip,
        (CurveKind::Shared, ..) => End::Other,
        _ => End::Lone,
    }
}

/// Every hole that turns a corner of its cell, with the stretches before and behind it.
fn holes_round_corners(plan: &Plan) -> impl Iterator<Item = (u32, CornerId, [Option<&Span>; 2])> {
    plan.holes.iter().enumerate().flat_map(|(h, hole)| {
        let pieces = &hole.outer;
        (0..pieces.len()).filter_map(move |k| {
            let Piece::Side { side, spans, corner_after: true } = &pieces[k] else { return None };
            let after = match &pieces[(k + 1) % pieces.len()] {
                Piece::Side { spans, .. } => spans.first(),
                _ => None,
            };
            Some((h as u32, hole.cell.corner_after(*side), [spans.last(), after]))
        })
    })
}

fn has_rim_in_square(surveys: &Surveys, plan: &Plan, hole: u32, corner: CornerId) -> bool {
    let hole = &plan.holes[hole as usize];
    let (Some(survey), Some(square)) = (surveys.get(&hole.cell), Square::of(plan, corner)) else {
        return false;
    };
    let slack_m = 0.5 * plan.fit.margin_m;
    hole.rim_edges(survey).any(|e| square.meets(survey.from(e).truncate(), survey.to(e).truncate(), slack_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_mesh::side_of_line;

    #[test]
    fn every_cell_brings_the_same_surface() {
        let corner = CornerId { i: 1, j: 1 };
        let square = Square { corner, lines: [[9.0, 11.0], [19.0, 21.0]] };
        let heights_m = [1.0, 3.0, -2.0, 7.0];
        let vertex = |p: SquarePoint| square.vertex(p.at, &heights_m);
        let height_at = |cell: CellId, place: DVec2| {
            let inside = square.triangles(cell).into_iter().map(|t| t.map(vertex)).find(|[a, b, c]| {
                let [a, b, c] = [a, b, c].map(|p| p.truncate());
                [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| side_of_line(p, q, place) >= 0.0)
            });
            let [a, b, c] = inside.unwrap();
            let normal = (b - a).cross(c - a);
            a.z - (normal.x * (place.x - a.x) + normal.y * (place.y - a.y)) / normal.z
        };
        for k in 0..25 {
            let place = DVec2::new(9.0 + 0.08 * f64::from(k), 19.0 + 0.4 * f64::from(k % 5));
            let heights = corner.cells().map(|cell| height_at(cell, place));
            assert!(heights.iter().all(|z| (z - heights[0]).abs() < 1e-12), "{place}: {heights:?}");
        }
    }

    #[test]
    fn no_outline_edge_is_in_two_cells() {
        let corner = CornerId { i: 1, j: 1 };
        let square = Square { corner, lines: [[9.0, 11.0], [19.0, 21.0]] };
        let mut outlines: Vec<[u8; 2]> = Vec::new();
        for (near, cell) in (0..).zip(corner.cells()) {
            // A cell's own lines pass the square on the two edges away from it.
            let lines = (4..).zip(EDGES).filter(|(_, edge)| !edge.contains(&near));
            let lines: Vec<[u8; 3]> = lines.map(|(middle, [a, b])| [a, b, middle]).collect();
            let edges = square.triangles(cell).into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
            let edges = edges.map(|e| e.map(|p| p.at));
            outlines.extend(edges.filter(|e| lines.iter().any(|l| e.iter().all(|p| l.contains(p)))));
        }
        assert_eq!(outlines.len(), 12);
        let count = outlines.len();
        outlines.sort_unstable();
        outlines.dedup();
        assert_eq!(outlines.len(), count, "{outlines:?}");
    }
}
