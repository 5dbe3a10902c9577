//! Contours to patches: Delaunay in plan or in a plane, minimum area in 3D, refinement, heights.
//!
//! A filler sees one [`lacuna_mesh::Contour`] and knows no cells. Every function is sequential and pure: equal input
//! gives equal bits. Coordinates are f64, metres, z up.

mod error;
mod fill;
mod params;

pub use error::FillError;
pub use fill::{Filled, Filler, QualityFacts, fill};
pub use params::{FillParams, FillerChoice, HeightRule};
