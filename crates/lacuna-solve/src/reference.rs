//! The reference solver: own LDLt, the same bits on every machine.

use crate::ordering::nested_dissection;
use crate::solver::{SHIFT, check_finite, check_length};
use crate::{Factor, SolveError, Solver, SparseSymmetric};

const NONE: u32 = u32::MAX;

/// Up-looking sparse LDLt in plain f64 after a nested dissection. Slower than [`crate::FaerSolver`] (1e5 unknowns in
/// seconds), but without vector units in play: golden files are made with it, and it is the other solver's oracle.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReferenceSolver;

impl Solver for ReferenceSolver {
    fn name(&self) -> &'static str {
        "reference"
    }

    fn factor(&self, matrix: &SparseSymmetric) -> Result<Box<dyn Factor>, SolveError> {
        let mut factor = ReferenceFactor::analyse(matrix)?;
        factor.factor_numeric(matrix)?;
        Ok(Box::new(factor))
    }

    fn factor_bytes(&self, matrix: &SparseSymmetric) -> Result<u64, SolveError> {
        let (_, counts) = Upper::new(matrix, &inverse(&nested_dissection(matrix))).elimination_tree();
        let entries: u64 = counts.iter().map(|&c| u64::from(c)).sum();
        Ok(12 * entries + 2 * 12 * matrix.entry_count() as u64 + 64 * matrix.order() as u64)
    }
}

/// Place of each unknown in an order of elimination.
fn inverse(unknown: &[u32]) -> Vec<u32> {
    let mut place = vec![0u32; unknown.len()];
    for (k, &v) in unknown.iter().enumerate() {
        place[v as usize] = k as u32;
    }
    place
}

/// L (unit lower triangle, compressed columns without the diagonal) and D of the permuted matrix.
struct ReferenceFactor {
    pattern: SparseSymmetric,
    /// Unknown at each place of the elimination, and the reverse.
    unknown: Vec<u32>,
    place: Vec<u32>,
    parent: Vec<u32>,
    starts: Vec<usize>,
    rows: Vec<u32>,
    lower: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Factor for ReferenceFactor {
    fn order(&self) -> usize {
        self.unknown.len()
    }

    fn refactor(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        if !matrix.has_pattern_of(&self.pattern) {
            return Err(SolveError::PatternChanged);
        }
        self.factor_numeric(matrix)
    }

    fn solve(&self, rhs: &mut [f64]) -> Result<(), SolveError> {
        check_length(rhs, self.order())?;
        if rhs.is_empty() {
            return Ok(());
        }
        for one in rhs.chunks_mut(self.order()) {
            self.solve_one(one);
        }
        check_finite(rhs)
    }
}

impl ReferenceFactor {
    fn analyse(matrix: &SparseSymmetric) -> Result<Self, SolveError> {
        let order = matrix.order();
        let unknown = nested_dissection(matrix);
        let place = inverse(&unknown);
        let upper = Upper::new(matrix, &place);
        let (parent, counts) = upper.elimination_tree();
        let mut starts = vec![0usize; order + 1];
        for k in 0..order {
            starts[k + 1] = starts[k] + counts[k] as usize;
        }
        let entries = starts[order];
        let mut lower = Vec::new();
        lower.try_reserve_exact(entries).map_err(|e| SolveError::TooLarge { order, what: e.to_string() })?;
        lower.resize(entries, 0.0);
        let pattern = matrix.clone();
        let diagonal = vec![0.0; order];
        Ok(Self { pattern, unknown, place, parent, starts, rows: vec![0; entries], lower, diagonal })
    }

    fn factor_numeric(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        check_finite(matrix.values())?;
        match self.try_numeric(matrix) {
            Err(SolveError::NotPositiveDefinite { .. }) => self.try_numeric(&matrix.shifted(SHIFT)),
            other => other,
        }
    }

    /// Row by row: solve with the rows above, then the pivot (Davis, *Direct methods for sparse linear systems*, 4.8).
    fn try_numeric(&mut self, matrix: &SparseSymmetric) -> Result<(), SolveError> {
        let order = self.order();
        let upper = Upper::new(matrix, &self.place);
        let mut filled = self.starts[..order].to_vec();
        let mut row = vec![0.0; order];
        let mut mark = vec![NONE; order];
        let mut reach: Vec<u32> = Vec::new();
        for k in 0..order {
            reach.clear();
            mark[k] = k as u32;
            for (i, value) in upper.column(k) {
                row[i as usize] += value;
                let mut i = i;
                while mark[i as usize] != k as u32 {
                    reach.push(i);
                    mark[i as usize] = k as u32;
                    i = self.parent[i as usize];
                }
            }
            // Ascending places are a topological order of the elimination tree.
            reach.sort_unstable();
            let mut pivot = std::mem::take(&mut row[k]);
            for &i in &reach {
                pivot -= self.eliminate(i as usize, k, &mut row, &mut filled);
            }
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(SolveError::NotPositiveDefinite { pivot: k, order });
            }
            self.diagonal[k] = pivot;
        }
        Ok(())
    }

    /// Applies column `i` to row `k` and stores L(k, i); returns what the pivot of row `k` loses.
    fn eliminate(&mut self, i: usize, k: usize, row: &mut [f64], filled: &mut [usize]) -> f64 {
        let y = std::mem::take(&mut row[i]);
        for at in self.starts[i]..filled[i] {
            row[self.rows[at] as usize] -= self.lower[at] * y;
        }
        let l = y / self.diagonal[i];
        self.rows[filled[i]] = k as u32;
        self.lower[filled[i]] = l;
        filled[i] += 1;
        l * y
    }

    fn solve_one(&self, rhs: &mut [f64]) {
        let order = self.order();
        let mut x: Vec<f64> = self.unknown.iter().map(|&v| rhs[v as usize]).collect();
        for j in 0..order {
            for at in self.starts[j]..self.starts[j + 1] {
                x[self.rows[at] as usize] -= self.lower[at] * x[j];
            }
        }
        for j in 0..order {
            x[j] /= self.diagonal[j];
        }
        for j in (0..order).rev() {
            for at in self.starts[j]..self.starts[j + 1] {
                x[j] -= self.lower[at] * x[self.rows[at] as usize];
            }
        }
        for (k, &v) in self.unknown.iter().enumerate() {
            rhs[v as usize] = x[k];
        }
    }
}

/// Columns of the permuted matrix's upper triangle, diagonal included.
struct Upper {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Upper {
    fn new(matrix: &SparseSymmetric, place: &[u32]) -> Self {
        let order = matrix.order();
        let mut starts = vec![0usize; order + 1];
        let ends = |i: u32, j: usize| {
            let (a, b) = (place[i as usize], place[j]);
            (a.min(b), a.max(b) as usize)
        };
        for j in 0..order {
            for (i, _) in matrix.column(j) {
                starts[ends(i, j).1 + 1] += 1;
            }
        }
        for k in 0..order {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0u32, 0.0); starts[order]];
        for j in 0..order {
            for (i, value) in matrix.column(j) {
                let (row, column) = ends(i, j);
                entries[next[column]] = (row, value);
                next[column] += 1;
            }
        }
        Self { starts, entries }
    }

    fn column(&self, k: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.entries[self.starts[k]..self.starts[k + 1]].iter().copied()
    }

    /// Parent of each column in the elimination tree, and the number of entries below its diagonal.
    fn elimination_tree(&self) -> (Vec<u32>, Vec<u32>) {
        let order = self.starts.len() - 1;
        let (mut parent, mut counts, mut mark) = (vec![NONE; order], vec![0u32; order], vec![NONE; order]);
        for k in 0..order {
            mark[k] = k as u32;
            for (i, _) in self.column(k) {
                let mut i = i as usize;
                while mark[i] != k as u32 {
                    if parent[i] == NONE {
                        parent[i] = k as u32;
                    }
                    counts[i] += 1;
                    mark[i] = k as u32;
                    i = parent[i] as usize;
                }
            }
        }
        (parent, counts)
    }
}
