//! Triangle columns of one cell, its boundary, loops, components and rings; contours and patches.
//!
//! Every kernel here is sequential and pure: it borrows plain columns and returns plain values. Coordinates are f64,
//! metres, z up, in the frame of the scene's files; a boundary has its missing surface on the **left** seen from above.

mod band;
mod boundary;
mod check;
mod components;
mod contour;
mod cotangent;
mod fans;
mod ids;
mod loops;
mod mesh;
mod places;
mod plane_fit;
mod polygon;
mod quality;
mod turn;

pub use band::{Band, BandVertex, band};
pub use boundary::{Boundary, BoundaryEdge, BoundaryKind, BoundaryPoint, Defects, boundary};
pub use check::{PatchDefect, PatchFacts, PlanView, check_patch};
pub use components::{Component, Components, SMALL_TRIANGLES, components};
pub use contour::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind, Patch, Support};
pub use cotangent::{Clamp, Stiffness, stiffness, stiffness_in_space};
pub use fans::{Fans, closed_fans};
pub use ids::{FaceId, PointId, VertexId};
pub use loops::{BoundaryLoop, BoundaryLoops, loops};
pub use mesh::{Bounds, TriMesh};
pub use places::{is_same_place, position_bits};
pub use plane_fit::PlaneFit;
pub use polygon::{
    EdgePair, Location, Meeting, contains, find_crossings, find_meetings, is_simple, perimeter,
    segments_cross, side_of_line, signed_area,
};
pub use quality::{QualityStats, smallest_angle_deg, triangle_quality};
pub use turn::clockwise_order;
