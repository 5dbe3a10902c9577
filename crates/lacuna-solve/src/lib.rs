//! Sparse symmetric positive definite systems behind one small trait.
//!
//! A caller gathers a [`SparseSymmetric`], asks a [`Solver`] for a [`Factor`] and solves as many right-hand sides as it
//! likes; when only the values change (robust weights, tension) the factor's symbolic part is reused by
//! [`Factor::refactor`]. Two solvers: [`FaerSolver`] (fast, the default) and [`ReferenceSolver`] (plain f64 in a fixed
//! order: the same bits on every machine). Both are sequential. Where a system is well-conditioned,
//! [`conjugate_gradients`] needs no factor.

mod conjugate;
mod error;
mod faer_solver;
mod matrix;
mod ordering;
mod reference;
mod solver;

pub use conjugate::conjugate_gradients;
pub use error::SolveError;
pub use faer_solver::FaerSolver;
pub use matrix::{SparseSymmetric, Triplet};
pub use reference::ReferenceSolver;
pub use solver::{Factor, Solver};
