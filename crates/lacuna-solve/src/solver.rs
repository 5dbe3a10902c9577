//! The trait that hides which Cholesky is at work.

use crate::{SolveError, SparseSymmetric};

/// Relative diagonal shift of the second attempt after a pivot that is not positive.
pub(crate) const SHIFT: f64 = 1e-12;

/// Factors symmetric positive definite matrices.
pub trait Solver: Send + Sync {
    /// Name for reports and manifests.
    fn name(&self) -> &'static str;

    /// Factors `matrix`: fill-reducing order, symbolic part, numeric part. After a pivot that is not positive it tries
    /// once more with every diagonal entry enlarged by 1e-12 of itself.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`], [`SolveError::NotFinite`], [`SolveError::TooLarge`].
    fn factor(&self, matrix: &SparseSymmetric) -> Result<Box<dyn Factor>, SolveError>;

    /// Memory that [`Self::factor`] takes for `matrix` at its peak, bytes, from the symbolic part alone; the matrix
    /// itself is not counted.
    ///
    /// # Errors
    /// [`SolveError::TooLarge`].
    fn factor_bytes(&self, matrix: &SparseSymmetric) -> Result<u64, SolveError>;
}

/// A factored matrix.
pub trait Factor: Send {
    /// Number of unknowns.
    fn order(&self) -> usize;

    /// Factors another matrix of the same pattern, reusing order and symbolic part.
    ///
    /// # Errors
    /// [`SolveError::PatternChanged`], else as [`Solver::factor`]. After an error the factor must not be used to solve.
    fn refactor(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError>;

    /// Replaces each right-hand side by its solution. `rhs` holds one or more of them, one after another.
    ///
    /// # Errors
    /// [`SolveError::WrongLength`] unless the length is a multiple of the order, [`SolveError::NotFinite`] if the
    /// solution is not finite.
    fn solve(&self, rhs: &mut [f64]) -> Result<(), SolveError>;
}

/// Checks the length of right-hand sides.
pub(crate) fn check_length(rhs: &[f64], order: usize) -> Result<(), SolveError> {
    let fits = if order == 0 { rhs.is_empty() } else { rhs.len().is_multiple_of(order) };
    if fits { Ok(()) } else { Err(SolveError::WrongLength { length: rhs.len(), order }) }
}

/// Checks that a solution is made of numbers.
pub(crate) fn check_finite(values: &[f64]) -> Result<(), SolveError> {
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(SolveError::NotFinite) }
}
