//! From the boundary of each cell to classified holes, clusters and layers: the plan.
//!
//! The plan is decided on surveys alone (about one per cent of the bytes). Steps, each a file of its own:
//! survey of a cell -> how tiles meet their borders -> edge labels -> chains and coverage -> perimeter walk -> closed
//! loops and islands -> classes -> borders seen from both cells -> clusters -> layers.

mod box_tree;
mod bridge;
mod build;
mod classify;
mod closed;
mod cluster;
mod corner;
mod coverage;
mod cut;
mod cuts;
mod faces;
mod fit;
mod group;
mod label;
mod layer;
mod loose;
mod open_edges;
mod outline;
mod place;
mod plan;
mod rims;
mod shared;
mod stitch;
mod strips;
mod survey;
mod walk;

pub use build::plan;
pub use classify::{HoleClass, HoleShape};
pub use closed::NotHole;
pub use cluster::ClusterRule;
pub use fit::{BorderFit, BorderMode, fit_borders};
pub use loose::{is_cracked_stub, share_borders};
pub use plan::{Anchor, Curve, CurveKind, Hole, HoleCluster, Leave, Piece, Plan, PlanOptions, Span};
pub use survey::{CellSurvey, LoopSurvey, Surveys, survey};
