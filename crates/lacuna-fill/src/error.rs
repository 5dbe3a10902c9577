//! Why a contour was not filled.

use thiserror::Error;

/// Why there is no patch. [`FillError::is_refusal`] tells a contour that no filler takes (a reason to skip) from work
/// that went wrong (a failure).
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FillError {
    /// A coordinate is NaN or infinite, a ring has fewer than three vertices, counts do not fit.
    #[error("the contour is malformed: {what}")]
    Malformed {
        /// What is wrong.
        what: String,
    },
    /// The rim crosses itself and neither pockets nor a tilted plane make it simple.
    #[error(
        "the rim crosses or touches itself near contour vertex {vertex}, seen from above and in its best-fit plane"
    )]
    CrossingRim {
        /// A contour vertex at the place.
        vertex: u32,
    },
    /// The ring runs the wrong way round, or an island lies outside.
    #[error("the rings do not enclose a surface: {what}")]
    BadRings {
        /// What is wrong.
        what: String,
    },
    /// Only the 3D triangulation could fill this, and its cost grows with the cube of the vertices.
    #[error(
        "the rim is neither simple from above nor flat, and {vertices} vertices are too many for a 3D triangulation (at most {limit})"
    )]
    TooManyVertices {
        /// Vertices of the contour.
        vertices: usize,
        /// Largest number.
        limit: usize,
    },
    /// Only the 3D triangulation could fill this, and it takes no islands.
    #[error("the rim is neither simple from above nor flat, and a 3D triangulation takes no islands")]
    IslandsIn3d,
    /// The patch would need more new vertices than allowed.
    #[error("the patch would need more than {limit} new vertices; set a larger spacing")]
    CapReached {
        /// Largest number.
        limit: usize,
    },
    /// No triangulation avoids the edges that the mesh already has, or the surface would fold back on itself.
    #[error("no acceptable triangulation: {what}")]
    NoTriangulation {
        /// What stands in the way.
        what: String,
    },
    /// The system for heights or positions could not be solved.
    #[error("the surface could not be solved: {0}")]
    Solve(#[from] lacuna_solve::SolveError),
    /// The finished patch has a defect: our own fault.
    #[error("the finished patch fails its check: {what}")]
    CheckFailed {
        /// The defect.
        what: String,
    },
}

impl FillError {
    /// True if the contour is one that no filler takes; false if something went wrong on the way.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::Malformed { .. } | Self::Solve(_) | Self::CheckFailed { .. })
    }
}
