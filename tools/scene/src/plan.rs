//! What a preset asks for.

use crate::area::Area;
use crate::class::Class;
use crate::hole::Hole;
use std::collections::BTreeMap;

/// Holes of each class.
pub type Counts = BTreeMap<Class, usize>;

/// A scene before any triangle is made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The preset's name.
    pub name: &'static str,
    /// Side of a cell, metres.
    pub cell_size_m: f64,
    /// Height between the terrain's lowest and highest place, about, metres.
    pub relief_m: f64,
    /// The cells.
    pub area: Area,
    /// The holes; no two touch.
    pub holes: Vec<Hole>,
}

impl Plan {
    /// How many holes of each class the cells should show.
    #[must_use]
    pub fn promised(&self) -> Counts {
        let mut counts = Counts::new();
        for (_, class) in self.holes.iter().flat_map(|h| &h.expected) {
            *counts.entry(*class).or_default() += 1;
        }
        counts
    }
}
