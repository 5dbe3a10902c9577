//! Smoothing of the heights along a repaired border, so that the two cells' patches meet without a step.
//!
//! The crate knows no cells and no meshes: it sees the vertices of a border and a strip of points on both sides of it.
//! Coordinates are f64, metres, z up.

mod neighbours;
mod smooth;

pub use smooth::{SeamError, SeamVertex, SmoothOutcome, SmoothParams, buffer_m, smooth};
