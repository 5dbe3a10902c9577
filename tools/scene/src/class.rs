//! The class that a cell shows of a hole.

use std::fmt;

/// The shape of an open hole in one cell (Wang et al. 2021, sec. 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Form {
    /// A: the cell holds no surface.
    Hollow,
    /// B: one piece of surface, a bay.
    SemiEnclosed,
    /// C: two pieces, each with a whole side: a crossing strip.
    Crossing,
    /// D: everything else: corners, several pieces, islands.
    Island,
}

/// The class of one hole in one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// The hole keeps away from the cell's border.
    Closed,
    /// Open, away from the edge of the reconstruction area (type I).
    Internal(Form),
    /// Open, with a piece of the area's edge (type II).
    External(Form),
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hollow => "A",
            Self::SemiEnclosed => "B",
            Self::Crossing => "C",
            Self::Island => "D",
        })
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed => f.write_str("closed"),
            Self::Internal(form) => write!(f, "I-{form}"),
            Self::External(form) => write!(f, "II-{form}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_field() {
        let names: Vec<String> =
            [Class::Closed, Class::Internal(Form::Hollow), Class::External(Form::Island)]
                .map(|c| c.to_string())
                .into();
        assert_eq!(names, ["closed", "I-A", "II-D"]);
    }
}
