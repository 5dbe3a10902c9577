//! Triangle columns of one cell, its boundary, loops, components and rings; contours and patches.
//!
//! Every kernel here is sequential and pure: it borrows plain columns and returns plain values. Coordinates are f64,
//! metres, z up, in the frame of the scene's files; a boundary has its missing surface on the **left** seen from above.

mod contour;
mod ids;
mod mesh;

pub use contour::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind, Patch, Support};
pub use ids::{FaceId, PointId, VertexId};
pub use mesh::{Bounds, TriMesh};
