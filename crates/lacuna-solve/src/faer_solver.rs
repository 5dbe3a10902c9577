//! The default solver: faer's sparse Cholesky, one thread.

use crate::solver::{SHIFT, check_finite, check_length};
use crate::{Factor, SolveError, Solver, SparseSymmetric};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::mat::MatMut;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};

/// Sparse Cholesky of the faer crate, sequential, approximate minimum degree order.
///
/// Equal bits on one kind of processor; its last bits differ between processors with other vector units.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaerSolver;

impl Solver for FaerSolver {
    fn name(&self) -> &'static str {
        "faer"
    }

    fn factor(&self, matrix: &SparseSymmetric) -> Result<Box<dyn Factor>, SolveError> {
        let symbolic = symbolic(matrix)?;
        let mut factor = FaerFactor { matrix: matrix.clone(), symbolic, numeric: Vec::new() };
        factor.factor_numeric(matrix)?;
        Ok(Box::new(factor))
    }

    fn factor_bytes(&self, matrix: &SparseSymmetric) -> Result<u64, SolveError> {
        let symbolic = symbolic(matrix)?;
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let symbolic_bytes = SYMBOLIC_BYTES * matrix.order() + SYMBOLIC_ENTRY_BYTES * matrix.entry_count();
        Ok((8 * symbolic.len_val() + scratch.unaligned_bytes_required() + symbolic_bytes) as u64)
    }
}

/// What the order, the elimination tree and the structure of the factor take for each unknown, with what finding them
/// takes for each entry of the matrix.
const SYMBOLIC_BYTES: usize = 64;
const SYMBOLIC_ENTRY_BYTES: usize = 24;

fn symbolic(matrix: &SparseSymmetric) -> Result<SymbolicCholesky<u32>, SolveError> {
    let params = CholeskySymbolicParams::default();
    factorize_symbolic_cholesky(symbolic_view(matrix), Side::Lower, SymmetricOrdering::Amd, params)
        .map_err(|e| too_large(matrix.order(), &e))
}

struct FaerFactor {
    matrix: SparseSymmetric,
    symbolic: SymbolicCholesky<u32>,
    numeric: Vec<f64>,
}

impl Factor for FaerFactor {
    fn order(&self) -> usize {
        self.matrix.order()
    }

    fn refactor(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        if !matrix.has_pattern_of(&self.matrix) {
            return Err(SolveError::PatternChanged);
        }
        self.factor_numeric(matrix)
    }

    fn solve(&self, rhs: &mut [f64]) -> Result<(), SolveError> {
        let order = self.order();
        check_length(rhs, order)?;
        if rhs.is_empty() {
            return Ok(());
        }
        let columns = rhs.len() / order;
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let mut memory = buffer(order, scratch)?;
        LltRef::new(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, order, columns),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        check_finite(rhs)
    }
}

impl FaerFactor {
    fn factor_numeric(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        check_finite(matrix.values())?;
        match self.try_numeric(matrix) {
            Err(SolveError::NotPositiveDefinite { .. }) => self.try_numeric(&matrix.shifted(SHIFT)),
            other => other,
        }
    }

    fn try_numeric(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        let order = matrix.order();
        if order == 0 {
            return Ok(());
        }
        let length = self.symbolic.len_val();
        self.numeric.clear();
        self.numeric.try_reserve_exact(length).map_err(|e| too_large(order, &e))?;
        self.numeric.resize(length, 0.0);
        let scratch = self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = buffer(order, scratch)?;
        let done = self.symbolic.factorize_numeric_llt::<f64>(
            &mut self.numeric,
            SparseColMatRef::new(symbolic_view(matrix), matrix.values()),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        match done {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => {
                Err(SolveError::NotPositiveDefinite { pivot: index, order })
            }
        }
    }
}

fn symbolic_view(matrix: &SparseSymmetric) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(matrix.order(), matrix.order(), matrix.starts(), None, matrix.rows())
}

fn buffer(order: usize, scratch: StackReq) -> Result<MemBuffer, SolveError> {
    MemBuffer::try_new(scratch).map_err(|_| too_large(order, &"out of memory"))
}

fn too_large(order: usize, what: &dyn std::fmt::Display) -> SolveError {
    SolveError::TooLarge { order, what: what.to_string() }
}
