//! Conjugate gradients for well-conditioned systems: no fill, a few vectors of memory.

use crate::{SolveError, SparseSymmetric};

/// Solves `matrix * x = rhs` by conjugate gradients scaled by the diagonal, from `x = 0`, until the residual is `tolerance`
/// of the right-hand side's (norms weighted by the inverse diagonal). Right for systems with a strong diagonal, such as a
/// screened Laplacian: the number of rounds goes with the root of the condition number.
///
/// Source: Hestenes, Stiefel 1952; sums run in the order of the unknowns.
///
/// # Errors
/// [`SolveError::WrongLength`], [`SolveError::NotPositiveDefinite`] if a direction has no positive energy,
/// [`SolveError::NotFinite`] if it does not settle within ten rounds an unknown and a hundred more.
pub fn conjugate_gradients(
    matrix: &SparseSymmetric,
    rhs: &[f64],
    tolerance: f64,
) -> Result<Vec<f64>, SolveError> {
    let order = matrix.order();
    if rhs.len() != order {
        return Err(SolveError::WrongLength { length: rhs.len(), order });
    }
    let inverse: Vec<f64> = (0..order).map(|j| matrix.diagonal(j).recip()).collect();
    if let Some(pivot) = inverse.iter().position(|d| !(d.is_finite() && *d > 0.0)) {
        return Err(SolveError::NotPositiveDefinite { pivot, order });
    }
    let mut x = vec![0.0; order];
    let mut residual = rhs.to_vec();
    let mut direction = scaled(&residual, &inverse);
    let mut square = dot(&residual, &direction);
    let enough = tolerance * tolerance * square;
    for _ in 0..10 * order + 100 {
        if square <= enough {
            return Ok(x);
        }
        let image = matrix.multiply(&direction)?;
        let energy = dot(&direction, &image);
        if !(energy.is_finite() && energy > 0.0) {
            return Err(SolveError::NotPositiveDefinite { pivot: 0, order });
        }
        let step = square / energy;
        for k in 0..order {
            x[k] += step * direction[k];
            residual[k] -= step * image[k];
        }
        let next = scaled(&residual, &inverse);
        let next_square = dot(&residual, &next);
        let turn = next_square / square;
        (0..order).for_each(|k| direction[k] = next[k] + turn * direction[k]);
        square = next_square;
    }
    Err(SolveError::NotFinite)
}

fn scaled(vector: &[f64], scale: &[f64]) -> Vec<f64> {
    vector.iter().zip(scale).map(|(v, s)| v * s).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReferenceSolver, Solver, Triplet};

    /// A path of `n` unknowns with springs between neighbours and a screen on each.
    fn chain(n: u32, screen: f64) -> SparseSymmetric {
        let link = |i: u32| {
            [(i, i, 1.0), (i + 1, i + 1, 1.0), (i + 1, i, -1.0)].map(|(row, column, value)| Triplet {
                row,
                column,
                value,
            })
        };
        let screens = (0..n).map(|i| Triplet { row: i, column: i, value: screen });
        let triplets: Vec<Triplet> = (0..n - 1).flat_map(link).chain(screens).collect();
        SparseSymmetric::from_triplets(n as usize, &triplets).expect("well formed")
    }

    #[test]
    fn it_finds_what_the_factor_finds() {
        for (n, screen) in [(1, 0.5), (2, 0.1), (300, 0.01)] {
            let matrix = if n == 1 {
                let one = [Triplet { row: 0, column: 0, value: screen }];
                SparseSymmetric::from_triplets(1, &one).expect("one")
            } else {
                chain(n, screen)
            };
            let rhs: Vec<f64> = (0..n).map(|k| f64::from(k * 7919 % 101) - 50.0).collect();
            let mut exact = rhs.clone();
            ReferenceSolver.factor(&matrix).expect("positive").solve(&mut exact).expect("solved");
            let found = conjugate_gradients(&matrix, &rhs, 1e-13).expect("settles");
            assert!(found.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-9), "{n}");
        }
        assert_eq!(conjugate_gradients(&chain(5, 1.0), &[0.0; 5], 1e-12), Ok(vec![0.0; 5]));
    }

    #[test]
    fn what_is_not_positive_is_refused() {
        let matrix = SparseSymmetric::from_triplets(
            2,
            &[(0, 0, 1.0), (1, 1, 1.0), (1, 0, 2.0)].map(|(row, column, value)| Triplet {
                row,
                column,
                value,
            }),
        )
        .expect("well formed");
        assert!(conjugate_gradients(&matrix, &[1.0, -1.0], 1e-12).is_err());
        assert!(conjugate_gradients(&matrix, &[1.0], 1e-12).is_err());
    }
}
