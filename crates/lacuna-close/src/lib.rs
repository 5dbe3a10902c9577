//! Closing polylines on the borders of cells, with heights, and the contours that fillers see.
//!
//! A border has one curve for every stretch where both cells are open; both cells take the same points from it, so that
//! their patches meet without a crack. Method `layered`: heights are projected from the rims, layer by layer.

mod contour;
mod curve;
mod layered;
mod profile;
mod strip;

pub use contour::{CellContour, CloseError, Source, contour};
pub use curve::{BorderCurve, Curves};
pub use layered::{LayeredOptions, project};
