//! The outline of a hole in plan, and a point inside it.

use crate::CellSurvey;
use crate::coverage::Coverage;
use crate::walk::RawPiece;
use glam::DVec2;
use lacuna_grid::{Domain, Side};

/// The polygon of an open hole: rim vertices, and straight along the perimeter with its corners.
pub(crate) fn outline(
    survey: &CellSurvey,
    domain: &Domain,
    coverage: &Coverage,
    pieces: &[RawPiece],
) -> Vec<DVec2> {
    let mut polygon = Vec::new();
    for piece in pieces {
        match *piece {
            RawPiece::Chain(k) => {
                let edges = &coverage.chains[k].edges;
                polygon.push(survey.from(edges[0]).truncate());
                polygon.extend(edges.iter().map(|&e| survey.to(e).truncate()));
            }
            RawPiece::Border(from, to) => polygon.extend(border_points(domain, from, to)),
            RawPiece::Bridge => {}
        }
    }
    polygon.dedup();
    if polygon.len() > 1 && polygon.first() == polygon.last() {
        polygon.pop();
    }
    polygon
}

/// Both ends of a stretch of the perimeter and the corners between them.
fn border_points(domain: &Domain, from: f64, to: f64) -> Vec<DVec2> {
    let mut points = vec![domain.at(from).1];
    points.extend(side_stretches(domain, from, to).iter().skip(1).map(|s| domain.at(s.1).1));
    if to - from < domain.perimeter_m() {
        points.push(domain.at(to).1);
    }
    points
}

/// A stretch of the perimeter cut at the corners: (side, from, to), parameters inside the side's own range.
pub(crate) fn side_stretches(domain: &Domain, from: f64, to: f64) -> Vec<(Side, f64, f64)> {
    let perimeter = domain.perimeter_m();
    let mut stretches = Vec::new();
    for turn in 0..2 {
        let shift = perimeter * f64::from(turn);
        for side in Side::ALL {
            let low = domain.side_start_m(side) + shift;
            let high = low + domain.side_length_m(side);
            let (a, b) = (from.max(low), to.min(high));
            if b - a > 1e-9 {
                stretches.push((side, a - shift, b - shift));
            }
        }
    }
    stretches
}

/// A point inside a polygon: the middle of the widest inner stretch of the horizontal line half-way between two
/// vertices' heights near the polygon's middle.
pub(crate) fn point_inside(polygon: &[DVec2]) -> DVec2 {
    let (low, high) =
        polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.y), h.max(p.y)));
    let mut best = (0.0, polygon.first().copied().unwrap_or_default());
    // Five lines: the middle one may touch a vertex or run through a narrow place.
    for k in 1..=5 {
        let y = low + (high - low) * (f64::from(k) / 6.0 + 1e-4);
        let mut crossings = crossings_at(polygon, y);
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            if pair[1] - pair[0] > best.0 {
                best = (pair[1] - pair[0], DVec2::new((pair[0] + pair[1]) / 2.0, y));
            }
        }
    }
    best.1
}

fn crossings_at(polygon: &[DVec2], y: f64) -> Vec<f64> {
    let n = polygon.len();
    (0..n)
        .map(|k| (polygon[k], polygon[(k + 1) % n]))
        .filter(|(a, b)| (a.y <= y) != (b.y <= y))
        .map(|(a, b)| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_grid::{Area, CellId, Grid};

    fn domain() -> Domain {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 10.0 };
        let area = Area::of_cells(&[CellId::new(0, 0)].into());
        Domain::new(&grid, &area, CellId::new(0, 0), 0.0)
    }

    #[test]
    fn stretches_are_cut_at_corners_and_wrap() {
        let cut = side_stretches(&domain(), 35.0, 53.0);
        let sides: Vec<_> = cut.iter().map(|s| s.0).collect();
        assert_eq!(sides, [Side::West, Side::South, Side::East]);
        assert_eq!(cut[1], (Side::South, 0.0, 10.0));
        assert_eq!(cut[2], (Side::East, 10.0, 13.0));
    }

    #[test]
    fn the_whole_perimeter_is_the_rectangle() {
        assert_eq!(border_points(&domain(), 0.0, 40.0).len(), 4);
    }

    #[test]
    fn the_inner_point_lies_inside_a_horseshoe() {
        let u =
            [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (6.0, 9.0), (6.0, 3.0), (3.0, 3.0), (3.0, 9.0), (0.0, 9.0)];
        let polygon: Vec<DVec2> = u.map(DVec2::from).to_vec();
        let p = point_inside(&polygon);
        assert_eq!(crossings_at(&polygon, p.y).iter().filter(|x| **x > p.x).count() % 2, 1, "{p}");
    }
}
