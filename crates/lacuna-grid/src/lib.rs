//! The grid of cells: indices, sides, borders, corners, domains and the reconstruction area. No triangles here.
//!
//! x grows east, y grows north; a cell's sides run counter-clockwise: south, east, north, west.

mod area;
mod cell;
mod domain;
mod infer;

pub use area::{Area, AreaLimit};
pub use cell::{BorderId, CellId, CornerId, Grid, Side};
pub use domain::{Domain, DomainSide, SideLabel};
pub use infer::{GridError, GridHints, InferredGrid, TileBox, infer_grid, is_near_index};
