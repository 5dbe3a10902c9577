//! Internal or external, and the shapes A to D: exact predicates on the walk's result (algorithms note B.6).

use crate::coverage::{Coverage, End};
use crate::outline::side_stretches;
use crate::walk::RawPiece;
use lacuna_grid::{Domain, Side, SideLabel};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Shape of an open hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum HoleShape {
    /// A: the cell has no surface at all.
    Hollow,
    /// B: one piece of surface, with border of its own.
    SemiEnclosed,
    /// C: two pieces, each with one full side and parts of two more: a strip from side to side.
    Crossing,
    /// D: everything else: corners cut off, three or more pieces, islands.
    Island,
}

impl HoleShape {
    /// The letter that reports use.
    #[must_use]
    pub fn letter(self) -> &'static str {
        match self {
            Self::Hollow => "A",
            Self::SemiEnclosed => "B",
            Self::Crossing => "C",
            Self::Island => "D",
        }
    }
}

/// Class of a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum HoleClass {
    /// Its loop holds no piece of the cell's border.
    Closed,
    /// Open; no border piece lies on the edge of the reconstruction area.
    Internal(HoleShape),
    /// Open; some border piece lies on the edge of the reconstruction area.
    External(HoleShape),
}

impl HoleClass {
    /// "closed", "I" or "II".
    #[must_use]
    pub fn class(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Internal(_) => "I",
            Self::External(_) => "II",
        }
    }

    /// The shape of an open hole.
    #[must_use]
    pub fn shape(self) -> Option<HoleShape> {
        match self {
            Self::Closed => None,
            Self::Internal(shape) | Self::External(shape) => Some(shape),
        }
    }
}

impl fmt::Display for HoleClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.shape() {
            None => f.write_str("closed"),
            Some(shape) => write!(f, "{}-{}", self.class(), shape.letter()),
        }
    }
}

/// Class of an open hole from its pieces and the number of its islands; and the share of its border that is external.
pub(crate) fn classify(
    domain: &Domain,
    coverage: &Coverage,
    pieces: &[RawPiece],
    islands: usize,
    gap_m: f64,
) -> (HoleClass, f64) {
    let (external_m, border_m) = border_lengths(domain, pieces, gap_m);
    if border_m <= 0.0 {
        return (HoleClass::Closed, 0.0);
    }
    let sides: Vec<usize> =
        surface_pieces(coverage, pieces).iter().map(|p| covered_sides(domain, coverage, *p, gap_m)).collect();
    let shape = match (sides.len(), islands) {
        (0, 0) => HoleShape::Hollow,
        (1, 0) if sides[0] >= 1 => HoleShape::SemiEnclosed,
        (2, 0) if sides.iter().all(|&t| t >= 3) => HoleShape::Crossing,
        _ => HoleShape::Island,
    };
    let class = if external_m > 0.0 { HoleClass::External(shape) } else { HoleClass::Internal(shape) };
    (class, external_m / border_m)
}

/// Length of the hole's border pieces on external sides, and in all.
fn border_lengths(domain: &Domain, pieces: &[RawPiece], gap_m: f64) -> (f64, f64) {
    let (mut external_m, mut all_m) = (0.0, 0.0);
    for piece in pieces {
        let RawPiece::Border(from, to) = *piece else { continue };
        for (side, a, b) in side_stretches(domain, from, to) {
            all_m += b - a;
            if domain.side(side).label == SideLabel::External && b - a > gap_m {
                external_m += b - a;
            }
        }
    }
    (external_m, all_m)
}

/// The perimeter interval of each piece of surface that bounds the hole: counter-clockwise from the start of its first
/// chain to the end of its last one (chains that a bridge joins are one piece).
fn surface_pieces(coverage: &Coverage, pieces: &[RawPiece]) -> Vec<(f64, f64)> {
    let n = pieces.len();
    let is_border = |k: usize| matches!(pieces[k % n], RawPiece::Border(..));
    let mut intervals = Vec::new();
    for k in (0..n).filter(|&k| is_border(k)) {
        let length = (1..n).take_while(|&d| !is_border(k + d)).count();
        if length == 0 {
            continue;
        }
        let chain = |at: usize| match pieces[at % n] {
            RawPiece::Chain(c) => Some(&coverage.chains[c]),
            _ => None,
        };
        let (Some(first), Some(last)) = (chain(k + 1), chain(k + length)) else { continue };
        if let (End::Border(_, from), End::Border(_, to)) = (first.start, last.end) {
            intervals.push((from, to));
        }
    }
    intervals
}

/// Number of sides on which a perimeter interval has coverage longer than `gap_m`.
fn covered_sides(domain: &Domain, coverage: &Coverage, (from, to): (f64, f64), gap_m: f64) -> usize {
    let perimeter = domain.perimeter_m();
    let to = if to < from { to + perimeter } else { to };
    let mut length = [0.0; 4];
    for shift in [-perimeter, 0.0, perimeter] {
        for (low, high) in &coverage.covered {
            let (a, b) = ((low + shift).max(from), (high + shift).min(to));
            if b > a {
                for (side, x, y) in
                    side_stretches(domain, a.rem_euclid(perimeter), a.rem_euclid(perimeter) + (b - a))
                {
                    length[side.index()] += y - x;
                }
            }
        }
    }
    Side::ALL.iter().filter(|s| length[s.index()] > gap_m).count()
}
