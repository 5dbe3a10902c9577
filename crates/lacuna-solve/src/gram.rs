//! Energies that are sums of squares: from sparse rows to the normal matrix.

use crate::{SolveError, SparseSymmetric};

/// Sparse rows over a number of unknowns, with a weight each: the energy `sum over rows of weight * (row . x)^2`.
#[derive(Clone, Debug, Default)]
pub struct WeightedRows {
    starts: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
    weights: Vec<f64>,
}

const NONE: u32 = u32::MAX;

impl WeightedRows {
    /// No rows.
    #[must_use]
    pub fn new() -> Self {
        Self { starts: vec![0], ..Self::default() }
    }

    /// Adds a row: unknowns with their coefficients, each unknown once, in any order.
    ///
    /// # Errors
    /// [`SolveError::TooLarge`] over 2^32 entries.
    pub fn push(&mut self, weight: f64, entries: &[(u32, f64)]) -> Result<(), SolveError> {
        self.columns.extend(entries.iter().map(|e| e.0));
        self.values.extend(entries.iter().map(|e| e.1));
        self.weights.push(weight);
        let end = u32::try_from(self.columns.len()).map_err(|_| too_large(self.weights.len()))?;
        self.starts.push(end);
        Ok(())
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// True if there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// The matrix of the energy over `order` unknowns: the sum of `weight * row' row`. Its pattern depends on the rows
    /// alone, not on their weights. Sums run in the order of the rows.
    ///
    /// # Errors
    /// [`SolveError::Malformed`] if a row names an unknown that does not exist, [`SolveError::TooLarge`] over 2^32 entries.
    pub fn gram(&self, order: usize) -> Result<SparseSymmetric, SolveError> {
        if self.columns.iter().any(|&c| c as usize >= order) {
            return Err(SolveError::Malformed {
                what: "a row names an unknown that does not exist".to_owned(),
            });
        }
        let (starts, of_column) = self.rows_by_column(order);
        let mut seen = vec![NONE; order];
        let mut sum = vec![0.0; order];
        let mut found: Vec<u32> = vec![];
        let (mut out_starts, mut out_rows, mut out_values) = (vec![0u32], vec![], vec![]);
        for column in 0..order as u32 {
            found.clear();
            found.push(column);
            seen[column as usize] = column;
            sum[column as usize] = 0.0;
            for &entry in &of_column[starts[column as usize] as usize..starts[column as usize + 1] as usize] {
                let [row, at] = entry;
                let scale = self.weights[row as usize] * self.values[at as usize];
                for k in self.starts[row as usize] as usize..self.starts[row as usize + 1] as usize {
                    let other = self.columns[k];
                    if other < column {
                        continue;
                    }
                    if seen[other as usize] != column {
                        seen[other as usize] = column;
                        sum[other as usize] = 0.0;
                        found.push(other);
                    }
                    sum[other as usize] += scale * self.values[k];
                }
            }
            found.sort_unstable();
            out_rows.extend_from_slice(&found);
            out_values.extend(found.iter().map(|&r| sum[r as usize]));
            out_starts.push(u32::try_from(out_rows.len()).map_err(|_| too_large(order))?);
        }
        SparseSymmetric::from_sorted_columns(out_starts, out_rows, out_values)
    }

    /// For each column its entries as (row, position), rows ascending.
    fn rows_by_column(&self, order: usize) -> (Vec<u32>, Vec<[u32; 2]>) {
        let mut starts = vec![0u32; order + 1];
        for &c in &self.columns {
            starts[c as usize + 1] += 1;
        }
        for c in 0..order {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut entries = vec![[0u32; 2]; self.columns.len()];
        for row in 0..self.weights.len() {
            for at in self.starts[row]..self.starts[row + 1] {
                let place = &mut next[self.columns[at as usize] as usize];
                entries[*place as usize] = [row as u32, at];
                *place += 1;
            }
        }
        (starts, entries)
    }
}

fn too_large(order: usize) -> SolveError {
    SolveError::TooLarge { order, what: "more than 2^32 matrix entries".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FaerSolver, ReferenceSolver, Solver};

    fn energy(rows: &[(f64, Vec<(u32, f64)>)], diagonal: &[f64], x: &[f64]) -> f64 {
        let of_rows: f64 = rows
            .iter()
            .map(|(w, row)| w * row.iter().map(|&(c, v)| v * x[c as usize]).sum::<f64>().powi(2))
            .sum();
        of_rows + diagonal.iter().zip(x).map(|(d, x)| d * x * x).sum::<f64>()
    }

    #[test]
    fn the_matrix_is_that_of_the_energy() {
        let rows = vec![
            (2.0, vec![(0, 1.0), (2, -1.0)]),
            (0.5, vec![(3, 4.0), (1, 1.0), (0, -2.0)]),
            (1.0, vec![(1, 3.0)]),
        ];
        let diagonal = [0.25, 0.0, 1.0, 0.5];
        let mut all = WeightedRows::new();
        rows.iter().for_each(|(w, row)| all.push(*w, row).expect("few"));
        let matrix = all.gram(4).expect("well formed").plus_diagonal(&diagonal).expect("four");
        for x in [[1.0, 2.0, 3.0, 4.0], [-1.0, 0.5, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]] {
            let product = matrix.multiply(&x).expect("four");
            let quadratic: f64 = x.iter().zip(&product).map(|(a, b)| a * b).sum();
            assert!((quadratic - energy(&rows, &diagonal, &x)).abs() < 1e-12);
        }
        for solver in [&FaerSolver as &dyn Solver, &ReferenceSolver] {
            let mut x = matrix.multiply(&[1.0, 2.0, 3.0, 4.0]).expect("four");
            solver.factor(&matrix).expect("positive").solve(&mut x).expect("solved");
            assert!(x.iter().zip([1.0, 2.0, 3.0, 4.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{x:?}");
        }
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        let mut rows = WeightedRows::new();
        rows.push(1.0, &[(5, 1.0)]).expect("few");
        assert!(rows.gram(3).is_err());
        let matrix = rows.gram(6).expect("six");
        assert!(matrix.plus_diagonal(&[1.0; 3]).is_err());
        assert!(matrix.plus_diagonal(&[1.0; 6]).is_ok());
    }
}
