//! The domain of a cell: the rectangle that its surface should fill, with a label on every side.

use crate::{Area, AreaLimit, BorderId, CellId, Grid, Side};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// What lies beyond a side of a domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SideLabel {
    /// Another cell of the area.
    Neighbour(CellId),
    /// The edge of the reconstruction area.
    External,
}

/// One side of a domain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DomainSide {
    /// Which side of the cell.
    pub side: Side,
    /// What lies beyond.
    pub label: SideLabel,
    /// Constant coordinate of the side's line, metres: y on south and north, x on east and west.
    pub line: f64,
}

/// The domain of a cell: its rectangle, cut to the area's limit, grown where tiles overrun their cell.
///
/// The perimeter parameter `s` runs counter-clockwise from the south-west corner, in metres, in `[0, perimeter)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// The cell.
    pub cell: CellId,
    /// South-west corner.
    pub low: DVec2,
    /// North-east corner.
    pub high: DVec2,
    /// South, east, north, west.
    pub sides: [DomainSide; 4],
}

impl Domain {
    /// The domain of `cell`. Tiles run `overrun_m` past their cell on every side (0 where they are cut on the line).
    /// A polygon limit does not change the rectangle; it decides later which holes lie at the area's edge.
    #[must_use]
    pub fn new(grid: &Grid, area: &Area, cell: CellId, overrun_m: f64) -> Self {
        let (low, high) = grid.rectangle(cell);
        let (mut low, mut high) = (low - overrun_m, high + overrun_m);
        let mut cut = [false; 4];
        if let AreaLimit::Box(box_low, box_high) = &area.limit {
            cut = [box_low.y > low.y, box_high.x < high.x, box_high.y < high.y, box_low.x > low.x];
            low = low.max(*box_low);
            high = high.min(*box_high);
        }
        let sides = Side::ALL.map(|side| {
            let external = cut[side.index()] || area.is_edge(cell, side);
            let label =
                if external { SideLabel::External } else { SideLabel::Neighbour(cell.neighbour(side)) };
            let line = match side {
                Side::South => low.y,
                Side::East => high.x,
                Side::North => high.y,
                Side::West => low.x,
            };
            DomainSide { side, label, line }
        });
        Self { cell, low, high, sides }
    }

    /// Length of the whole perimeter, metres.
    #[must_use]
    pub fn perimeter_m(&self) -> f64 {
        2.0 * (self.width_m() + self.height_m())
    }

    /// East-west extent, metres.
    #[must_use]
    pub fn width_m(&self) -> f64 {
        self.high.x - self.low.x
    }

    /// North-south extent, metres.
    #[must_use]
    pub fn height_m(&self) -> f64 {
        self.high.y - self.low.y
    }

    /// The side's record.
    #[must_use]
    pub fn side(&self, side: Side) -> &DomainSide {
        &self.sides[side.index()]
    }

    /// Parameter where a side starts, walking counter-clockwise.
    #[must_use]
    pub fn side_start_m(&self, side: Side) -> f64 {
        let (w, h) = (self.width_m(), self.height_m());
        [0.0, w, w + h, w + h + w][side.index()]
    }

    /// Length of a side, metres.
    #[must_use]
    pub fn side_length_m(&self, side: Side) -> f64 {
        if side.is_horizontal() { self.width_m() } else { self.height_m() }
    }

    /// Perimeter parameter of the foot of `point` on a side, clamped to the side.
    #[must_use]
    pub fn parameter(&self, side: Side, point: DVec2) -> f64 {
        let distance = match side {
            Side::South => point.x - self.low.x,
            Side::East => point.y - self.low.y,
            Side::North => self.high.x - point.x,
            Side::West => self.high.y - point.y,
        };
        self.side_start_m(side) + distance.clamp(0.0, self.side_length_m(side))
    }

    /// The side that holds parameter `s` (a corner belongs to the side that starts there), and the point there.
    #[must_use]
    pub fn at(&self, s: f64) -> (Side, DVec2) {
        let s = s.rem_euclid(self.perimeter_m());
        let side = *Side::ALL.iter().rev().find(|&&k| s >= self.side_start_m(k)).unwrap_or(&Side::South);
        (side, self.point(side, s))
    }

    /// The point of a side at perimeter parameter `s`, both ends of the side included (unlike [`Domain::at`]).
    #[must_use]
    pub fn point(&self, side: Side, s: f64) -> DVec2 {
        let d = s - self.side_start_m(side);
        match side {
            Side::South => DVec2::new(self.low.x + d, self.low.y),
            Side::East => DVec2::new(self.high.x, self.low.y + d),
            Side::North => DVec2::new(self.high.x - d, self.high.y),
            Side::West => DVec2::new(self.low.x, self.high.y - d),
        }
    }

    /// The corner where `side` ends.
    #[must_use]
    pub fn corner_after(&self, side: Side) -> DVec2 {
        match side {
            Side::South => DVec2::new(self.high.x, self.low.y),
            Side::East => self.high,
            Side::North => DVec2::new(self.low.x, self.high.y),
            Side::West => self.low,
        }
    }

    /// Signed distance of `point` beyond a side's line, metres: positive outside.
    #[must_use]
    pub fn outside_m(&self, side: Side, point: DVec2) -> f64 {
        match side {
            Side::South => self.low.y - point.y,
            Side::East => point.x - self.high.x,
            Side::North => point.y - self.high.y,
            Side::West => self.low.x - point.x,
        }
    }

    /// The border that a side lies on.
    #[must_use]
    pub fn border(&self, side: Side) -> BorderId {
        self.cell.border(side)
    }

    /// Plan area, square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.width_m() * self.height_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn domain() -> Domain {
        let grid = Grid { origin: DVec2::new(100.0, 200.0), cell_size_m: 50.0 };
        let area = Area::of_cells(&BTreeSet::from([CellId::new(0, 0), CellId::new(1, 0)]));
        Domain::new(&grid, &area, CellId::new(0, 0), 0.0)
    }

    #[test]
    fn labels_name_the_neighbour_or_the_edge() {
        let d = domain();
        assert_eq!(d.side(Side::East).label, SideLabel::Neighbour(CellId::new(1, 0)));
        assert_eq!(d.side(Side::West).label, SideLabel::External);
    }

    #[test]
    fn parameter_and_point_agree_all_round() {
        let d = domain();
        for k in 0..40 {
            let s = 5.0 * f64::from(k) + 1.25;
            let (side, point) = d.at(s);
            assert!((d.parameter(side, point) - s).abs() < 1e-9, "s {s}");
            assert!(d.outside_m(side, point).abs() < 1e-9);
            let corner = d.point(side, d.side_start_m(side) + d.side_length_m(side));
            assert_eq!(corner, d.corner_after(side));
        }
    }

    #[test]
    fn a_box_cuts_the_domain_and_makes_its_sides_external() {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 50.0 };
        let area = Area::of_box(&BTreeSet::new(), &grid, DVec2::ZERO, DVec2::new(64.0, 50.0));
        let d = Domain::new(&grid, &area, CellId::new(1, 0), 0.0);
        assert_eq!((d.width_m(), d.height_m()), (14.0, 50.0));
        assert_eq!(d.side(Side::East).label, SideLabel::External);
        assert_eq!(d.side(Side::West).label, SideLabel::Neighbour(CellId::new(0, 0)));
    }

    #[test]
    fn overrun_grows_every_side() {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 50.0 };
        let area = Area::of_cells(&BTreeSet::from([CellId::new(0, 0)]));
        let d = Domain::new(&grid, &area, CellId::new(0, 0), 0.1);
        assert!((d.width_m() - 50.2).abs() < 1e-12);
        assert!((d.outside_m(Side::South, DVec2::new(3.0, -0.1))).abs() < 1e-12);
    }
}
