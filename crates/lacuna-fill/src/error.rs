//! Why a contour was not filled.

use lacuna_mesh::Contour;
use std::fmt;
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
    #[error("{cause} near contour vertex {vertex}{place}")]
    CrossingRim {
        /// A contour vertex at the place.
        vertex: u32,
        /// What crosses.
        cause: Crossing,
        /// Where that is, in words.
        place: String,
    },
    /// The ring runs the wrong way round, or an island lies outside.
    #[error("the rings do not enclose a surface: {what}")]
    BadRings {
        /// What is wrong.
        what: String,
    },
    /// Neither view holds: the rim stands upright and strays from its best-fit plane.
    #[error("the rim stands upright and is not flat: neither a view from above nor a plane shows it")]
    UprightRim,
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
    /// Only the 3D triangulation could fill this, and it can't tell two lobes from a lobe and an island.
    #[error(
        "the rim is neither simple from above nor flat, and a 3D triangulation takes no ring that touches itself"
    )]
    TouchingIn3d,
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

/// What crosses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// Two rings.
    OtherRing,
    /// One ring, where nothing may be cut off.
    ItSelf,
    /// One ring, and what hangs over is too large for a pocket, or no chord cuts it off.
    NoPocket,
    /// Rings in a common vertex, or places too close to tell apart.
    InVertex,
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherRing => "seen from above, an island hangs over another ring of the rim: they cross or touch",
            Self::ItSelf => "the rim crosses or touches itself",
            Self::NoPocket => {
                "seen from above, the rim crosses or touches itself, and no chord cuts off what hangs over (at most \
                 128 edges and a fifth of the hole's area)"
            }
            Self::InVertex => "rings of the rim cross each other in a vertex",
        })
    }
}

impl FillError {
    /// A crossing whose place is not told yet.
    pub(crate) fn crossing(vertex: u32, cause: Crossing) -> Self {
        Self::CrossingRim { vertex, cause, place: String::new() }
    }

    /// Adds the place of a crossing.
    pub(crate) fn with_place(mut self, contour: &Contour) -> Self {
        if let Self::CrossingRim { vertex, place, .. } = &mut self
            && let Some(p) = contour.positions().get(*vertex as usize)
        {
            *place = format!(" at {:.3}, {:.3}, {:.3}", p.x, p.y, p.z);
        }
        self
    }

    /// True if the contour is one that no filler takes; false if something went wrong on the way.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::Malformed { .. } | Self::Solve(_) | Self::CheckFailed { .. })
    }
}
