//! Both solvers against dense elimination and against each other.

use lacuna_solve::{FaerSolver, ReferenceSolver, SolveError, Solver, SparseSymmetric, Triplet};
use proptest::prelude::*;

const SOLVERS: [&dyn Solver; 2] = [&FaerSolver, &ReferenceSolver];

fn triplet(row: u32, column: u32, value: f64) -> Triplet {
    Triplet { row, column, value }
}

/// Laplacian of a grid of `side` x `side` points, tied down by `tie` on the diagonal.
fn grid_laplacian(side: u32, tie: f64) -> Vec<Triplet> {
    let at = |x: u32, y: u32| y * side + x;
    let mut entries: Vec<Triplet> = (0..side * side).map(|i| triplet(i, i, tie)).collect();
    let mut join = |a: u32, b: u32| {
        entries.extend([triplet(a, a, 1.0), triplet(b, b, 1.0), triplet(b, a, -1.0)]);
    };
    for y in 0..side {
        for x in 0..side {
            if x + 1 < side {
                join(at(x, y), at(x + 1, y));
            }
            if y + 1 < side {
                join(at(x, y), at(x, y + 1));
            }
        }
    }
    entries
}

/// Gaussian elimination with partial pivoting on the full matrix.
fn solve_dense(matrix: &SparseSymmetric, rhs: &[f64]) -> Vec<f64> {
    let n = matrix.order();
    let mut a = vec![vec![0.0; n + 1]; n];
    for j in 0..n {
        a[j][n] = rhs[j];
        for (i, value) in matrix.column(j) {
            a[i as usize][j] = value;
            a[j][i as usize] = value;
        }
    }
    for k in 0..n {
        let best = (k..n).max_by(|&p, &q| a[p][k].abs().total_cmp(&a[q][k].abs())).unwrap();
        a.swap(k, best);
        for i in k + 1..n {
            let f = a[i][k] / a[k][k];
            for j in k..=n {
                a[i][j] -= f * a[k][j];
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * x[j]).sum();
        x[k] = (a[k][n] - known) / a[k][k];
    }
    x
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(1e-300f64, |m, v| m.max(v.abs()));
    a.iter().zip(b).fold(0.0f64, |m, (p, q)| m.max((p - q).abs())) / size
}

fn solve(solver: &dyn Solver, matrix: &SparseSymmetric, rhs: &[f64]) -> Vec<f64> {
    let mut x = rhs.to_vec();
    solver.factor(matrix).unwrap().solve(&mut x).unwrap();
    x
}

#[test]
fn solutions_equal_dense_elimination() {
    for side in [1, 2, 3, 7, 12, 17] {
        let matrix =
            SparseSymmetric::from_triplets((side * side) as usize, &grid_laplacian(side, 0.1)).unwrap();
        let rhs: Vec<f64> = (0..side * side).map(|i| f64::from(i % 7) - 2.5).collect();
        let dense = solve_dense(&matrix, &rhs);
        for solver in SOLVERS {
            let difference = largest_difference(&solve(solver, &matrix, &rhs), &dense);
            assert!(difference < 1e-12, "{} on side {side}: {difference:e}", solver.name());
        }
    }
}

#[test]
fn both_solvers_agree_on_a_large_grid() {
    let side = 120;
    let matrix = SparseSymmetric::from_triplets((side * side) as usize, &grid_laplacian(side, 1e-3)).unwrap();
    let rhs: Vec<f64> = (0..side * side).map(|i| f64::from(i * 7919 % 1000) - 500.0).collect();
    let [faer, reference] = SOLVERS.map(|s| solve(s, &matrix, &rhs));
    let difference = largest_difference(&faer, &reference);
    assert!(difference < 1e-9, "{difference:e}");
    let product = matrix.multiply(&reference).unwrap();
    assert!(largest_difference(&product, &rhs) < 1e-10);
}

#[test]
fn several_right_hand_sides_are_solved_one_after_another() {
    let matrix = SparseSymmetric::from_triplets(16, &grid_laplacian(4, 0.5)).unwrap();
    let first: Vec<f64> = (0..16).map(f64::from).collect();
    let second: Vec<f64> = (0..16).map(|i| f64::from(i * i % 5)).collect();
    for solver in SOLVERS {
        let mut both = [first.clone(), second.clone()].concat();
        solver.factor(&matrix).unwrap().solve(&mut both).unwrap();
        let alone = [solve(solver, &matrix, &first), solve(solver, &matrix, &second)].concat();
        assert!(largest_difference(&both, &alone) < 1e-14, "{}", solver.name());
    }
}

#[test]
fn refactor_equals_a_new_factor_and_refuses_another_pattern() {
    let one = SparseSymmetric::from_triplets(100, &grid_laplacian(10, 0.5)).unwrap();
    let other = SparseSymmetric::from_triplets(100, &grid_laplacian(10, 4.0)).unwrap();
    let sparser = SparseSymmetric::from_triplets(100, &[]).unwrap();
    let rhs = vec![1.0; 100];
    for solver in SOLVERS {
        let mut factor = solver.factor(&one).unwrap();
        factor.refactor(&other).unwrap();
        let mut x = rhs.clone();
        factor.solve(&mut x).unwrap();
        assert_eq!(x, solve(solver, &other, &rhs), "{}", solver.name());
        assert_eq!(factor.refactor(&sparser), Err(SolveError::PatternChanged));
    }
}

#[test]
fn systems_without_a_unique_solution_are_refused() {
    let indefinite = [triplet(0, 0, 1.0), triplet(1, 1, -1.0)];
    let loose = [triplet(0, 0, 1.0)];
    let saddle = [triplet(0, 0, 1.0), triplet(1, 1, 1.0), triplet(1, 0, 2.0)];
    for entries in [&indefinite[..], &loose, &saddle] {
        let matrix = SparseSymmetric::from_triplets(2, entries).unwrap();
        for solver in SOLVERS {
            let refused = solver.factor(&matrix).map(|_| ()).unwrap_err();
            assert!(
                matches!(refused, SolveError::NotPositiveDefinite { order: 2, .. }),
                "{}: {refused}",
                solver.name()
            );
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let matrix = SparseSymmetric::from_triplets(1, &[triplet(0, 0, f64::NAN)]).unwrap();
    let good = SparseSymmetric::from_triplets(1, &[triplet(0, 0, 2.0)]).unwrap();
    for solver in SOLVERS {
        assert_eq!(solver.factor(&matrix).map(|_| ()).unwrap_err(), SolveError::NotFinite);
        let factor = solver.factor(&good).unwrap();
        assert_eq!(factor.solve(&mut [f64::INFINITY]), Err(SolveError::NotFinite));
    }
}

#[test]
fn wrong_lengths_are_refused_and_empty_systems_are_not() {
    let matrix = SparseSymmetric::from_triplets(4, &grid_laplacian(2, 1.0)).unwrap();
    let empty = SparseSymmetric::from_triplets(0, &[]).unwrap();
    for solver in SOLVERS {
        let factor = solver.factor(&matrix).unwrap();
        assert_eq!(factor.solve(&mut [1.0; 6]), Err(SolveError::WrongLength { length: 6, order: 4 }));
        assert_eq!(solver.factor(&empty).unwrap().solve(&mut []), Ok(()));
    }
}

#[test]
fn triplets_are_summed_and_columns_are_checked() {
    let sum = SparseSymmetric::from_triplets(
        2,
        &[triplet(0, 1, 0.25), triplet(1, 0, 0.5), triplet(1, 1, 2.0), triplet(0, 0, 3.0)],
    );
    let direct = SparseSymmetric::from_sorted_columns(vec![0, 2, 3], vec![0, 1, 1], vec![3.0, 0.75, 2.0]);
    assert_eq!(sum, direct);
    assert_eq!(sum.unwrap().entry_count(), 3);
    assert!(SparseSymmetric::from_triplets(2, &[triplet(2, 0, 1.0)]).is_err());
    for (starts, rows) in
        [(vec![0, 1, 1], vec![0]), (vec![0, 2, 3], vec![1, 0, 1]), (vec![0, 1, 2], vec![0, 2])]
    {
        let values = vec![1.0; rows.len()];
        assert!(SparseSymmetric::from_sorted_columns(starts, rows, values).is_err());
    }
}

proptest! {
    #[test]
    fn random_diagonally_dominant_systems_are_solved(
        order in 1usize..60,
        picks in prop::collection::vec((0u32..60, 0u32..60, -1.0f64..1.0), 0..300),
    ) {
        let mut entries = vec![];
        for &(i, j, value) in picks.iter().filter(|p| p.0 != p.1) {
            let (i, j) = (i % order as u32, j % order as u32);
            if i != j {
                entries.extend([triplet(i, j, value), triplet(i, i, value.abs()), triplet(j, j, value.abs())]);
            }
        }
        entries.extend((0..order as u32).map(|i| triplet(i, i, 0.5)));
        let matrix = SparseSymmetric::from_triplets(order, &entries).unwrap();
        let rhs: Vec<f64> = (0..order).map(|i| (i % 5) as f64 - 1.0).collect();
        let dense = solve_dense(&matrix, &rhs);
        for solver in SOLVERS {
            prop_assert!(largest_difference(&solve(solver, &matrix, &rhs), &dense) < 1e-10);
        }
    }
}
