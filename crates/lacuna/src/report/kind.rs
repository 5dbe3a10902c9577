//! Kinds of holes as the report names them: closed, or I/II with a shape A-D.

use serde::{Deserialize, Serialize};

/// Closed, or open and internal (I) or external (II).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum HoleClass {
    /// Its loop touches no border of the cell.
    #[serde(rename = "closed")]
    Closed,
    /// Open, nowhere on the edge of the reconstruction area.
    #[serde(rename = "I")]
    Internal,
    /// Open, and some border piece lies on the edge of the reconstruction area.
    #[serde(rename = "II")]
    External,
}

impl HoleClass {
    /// `closed`, `I` or `II`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Internal => "I",
            Self::External => "II",
        }
    }
}

/// Shape of an open hole (algorithms.md B.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum HoleShape {
    /// Hollow: the cell has no surface at all.
    A,
    /// Semi-enclosed: a bay.
    B,
    /// Crossing: from one border to another.
    C,
    /// Island: surface stands inside.
    D,
}

impl HoleShape {
    /// Its letter.
    #[must_use]
    pub fn letter(self) -> &'static str {
        ["A", "B", "C", "D"][self as usize]
    }
}

/// A row of the summary table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HoleKind {
    /// Closed.
    Closed,
    /// Open, internal.
    Internal(HoleShape),
    /// Open, external.
    External(HoleShape),
}

impl HoleKind {
    /// All rows in the order in which they are written.
    pub const ALL: [Self; 9] = [
        Self::Closed,
        Self::Internal(HoleShape::A),
        Self::Internal(HoleShape::B),
        Self::Internal(HoleShape::C),
        Self::Internal(HoleShape::D),
        Self::External(HoleShape::A),
        Self::External(HoleShape::B),
        Self::External(HoleShape::C),
        Self::External(HoleShape::D),
    ];

    /// The row of a class and a shape; an open hole without a shape counts as crossing.
    #[must_use]
    pub fn of(class: HoleClass, shape: Option<HoleShape>) -> Self {
        let shape = shape.unwrap_or(HoleShape::C);
        match class {
            HoleClass::Closed => Self::Closed,
            HoleClass::Internal => Self::Internal(shape),
            HoleClass::External => Self::External(shape),
        }
    }

    /// The key in `summary.by_type`.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Internal(shape) => ["I-A", "I-B", "I-C", "I-D"][shape as usize],
            Self::External(shape) => ["II-A", "II-B", "II-C", "II-D"][shape as usize],
        }
    }

    /// Words for people, letter last.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Closed => "closed, inside a tile",
            Self::Internal(shape) | Self::External(shape) => {
                ["a whole tile (A)", "bay (B)", "crossing (C)", "with island (D)"][shape as usize]
            }
        }
    }

    /// Position in [`HoleKind::ALL`].
    #[must_use]
    pub fn row(self) -> usize {
        match self {
            Self::Closed => 0,
            Self::Internal(shape) => 1 + shape as usize,
            Self::External(shape) => 5 + shape as usize,
        }
    }
}
