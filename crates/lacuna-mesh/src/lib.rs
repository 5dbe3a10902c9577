//! Triangle columns of one cell, its boundary, loops, components and rings; contours and patches.
//!
//! Every kernel here is sequential and pure: it borrows plain columns and returns plain values. Coordinates are f64,
//! metres, z up, in the frame of the scene's files; a boundary has its missing surface on the **left** seen from above.

mod band;
mod boundary;
mod components;
mod contour;
mod ids;
mod loops;
mod mesh;
mod places;
mod turn;

pub use band::{Band, BandVertex, band};
pub use boundary::{Boundary, BoundaryEdge, BoundaryKind, BoundaryPoint, Defects, boundary};
pub use components::{Component, Components, components};
pub use contour::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind, Patch, Support};
pub use ids::{FaceId, PointId, VertexId};
pub use loops::{BoundaryLoop, BoundaryLoops, loops};
pub use mesh::{Bounds, TriMesh};
pub use places::{is_same_place, position_bits};
