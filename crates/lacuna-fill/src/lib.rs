//! Contours to patches: Delaunay in plan or in a plane, minimum area in space, refinement, heights.
//!
//! A filler sees one [`lacuna_mesh::Contour`] and knows no cells. Every function is sequential and pure: equal input
//! gives equal bits. Coordinates are f64, metres, z up.

mod adjust;
mod delaunay;
mod error;
mod fill;
mod forbidden;
mod frame;
mod heights;
mod lift;
mod min_area;
mod params;
mod plan;
mod plan_mesh;
mod plane;
mod pocket;
mod predicates;
mod refine;
mod ring_dp;
mod smooth;
mod space_mesh;
mod surface;
mod topology;
mod triangulation;
mod weld;

pub use adjust::{Freedom, adjust};
pub use error::{Crossing, FillError};
pub use fill::{Filled, Filler, fill};
pub use heights::{HeightProblem, Smoothness, solve_heights};
pub use params::{FillParams, FillerChoice, HeightRule};
pub use ring_dp::{Ring3d, RingWeight, triangulate_ring};
pub use triangulation::{Triangulation, raise, triangulate_in_plan};
