//! A planned hole: where triangles are left out, and which class each cell should show.

use crate::area::Cell;
use crate::class::Class;
use crate::shape::{Place, Shape};

/// A hole of the scene, as a person sees it: over one or more cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hole {
    /// Short name, unique in the scene.
    pub id: String,
    /// Cells without any surface.
    pub hollow: Vec<Cell>,
    /// Triangles whose centroid lies in one of these are left out ...
    pub parts: Vec<Shape>,
    /// ... unless it lies in one of these.
    pub islands: Vec<Shape>,
    /// The class each cell should show.
    pub expected: Vec<(Cell, Class)>,
}

impl Hole {
    /// True if a triangle of `cell` with this centroid is left out.
    #[must_use]
    pub fn takes(&self, cell: Cell, centroid: Place) -> bool {
        self.hollow.contains(&cell)
            || (self.parts.iter().any(|s| s.contains(centroid))
                && !self.islands.iter().any(|s| s.contains(centroid)))
    }

    /// True if the hole may take triangles in the box from `low` to `high`, metres.
    #[must_use]
    pub fn may_touch(&self, low: Place, high: Place, cell_size_m: f64) -> bool {
        let meets = |b: [Place; 2]| (0..2).all(|k| b[0][k] <= high[k] && b[1][k] >= low[k]);
        let cell_box = |c: &Cell| {
            let corner = c.map(|k| k as f64 * cell_size_m);
            [corner, corner.map(|k| k + cell_size_m)]
        };
        self.hollow.iter().any(|c| meets(cell_box(c))) || self.parts.iter().any(|s| meets(s.bounds()))
    }
}
