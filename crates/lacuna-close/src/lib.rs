//! Closing polylines on the borders of cells, with heights, and the contours that fillers see.
//!
//! A border has one curve for every stretch where both cells are open; both cells take the same points from it, so that
//! their patches meet without a crack. Method `layered`: heights are projected from the rims, layer by layer. Method
//! `field`: one robust thin plate over the hole of a whole cluster gives heights to curves and patches.

mod blocks;
mod coarsen;
mod contour;
mod curve;
mod field;
mod fit;
mod flat_water;
mod height_field;
mod held_back;
mod islands;
mod layered;
mod plate;
mod profile;
mod refine;
mod region;
mod rim_join;
mod ring;
mod robust;
mod sample;
mod sloped_water;
mod square;
mod strip;
mod untangle;
mod water;

pub use contour::{CellContour, CloseError, ClosingPoint, Source, contour};
pub use curve::{BorderCurve, Curves};
pub use field::{ClusterField, WaterRule, field, field_bytes, measuring_bytes, raise_curves};
pub use height_field::{Datum, FieldError, FieldParams, HeightField, Region, height_field};
pub use islands::hovering_islands;
pub use layered::{LayeredOptions, project};
pub use region::{ClusterRegion, FieldPart, cluster_region};
pub use sloped_water::sloped_water;
pub use square::SquarePoint;
pub use strip::Strip;
pub use water::{RimPoint, Water, forced_water, given_water, water};
