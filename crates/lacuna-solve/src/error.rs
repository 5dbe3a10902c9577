//! What can go wrong with a system.

use thiserror::Error;

/// Why a system could not be built, factored or solved.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SolveError {
    /// An entry or a column lies outside the matrix, or columns are not sorted: the caller's mistake.
    #[error("the system's matrix is malformed: {what}")]
    Malformed {
        /// What is wrong with it.
        what: String,
    },
    /// A pivot was not positive, with and without the diagonal shift: the unknowns are not all tied down by data.
    #[error(
        "the system has no unique solution (pivot {pivot} of {order} is not positive): some unknowns hang loose"
    )]
    NotPositiveDefinite {
        /// About where in the order of elimination it stands (solvers count differently).
        pivot: usize,
        /// Number of unknowns.
        order: usize,
    },
    /// The right-hand side does not fit the matrix.
    #[error("a right-hand side of {length} numbers does not fit a system of {order} unknowns")]
    WrongLength {
        /// Length of the right-hand side.
        length: usize,
        /// Number of unknowns.
        order: usize,
    },
    /// `refactor` got a matrix with another pattern than the first one.
    #[error("the matrix's pattern changed between two factorisations; factor it anew")]
    PatternChanged,
    /// NaN or infinity in the matrix, the right-hand side or the solution.
    #[error("the system holds or produced a number that is not finite")]
    NotFinite,
    /// The factor does not fit into memory or its indices into 32 bits.
    #[error("the system of {order} unknowns is too large: {what}")]
    TooLarge {
        /// Number of unknowns.
        order: usize,
        /// What ran out.
        what: String,
    },
}
