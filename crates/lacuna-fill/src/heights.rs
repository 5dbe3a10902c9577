//! Heights over a plane triangulation: harmonic or biharmonic, some fixed, the rest solved for.

use glam::DVec2;
use lacuna_mesh::{Clamp, PlaneFit, Stiffness, stiffness};
use lacuna_solve::{SolveError, Solver, SparseSymmetric};

/// Points in a plane, their triangles, and what is known of the heights above it.
#[derive(Clone, Copy, Debug)]
pub struct HeightProblem<'a> {
    /// Places, metres.
    pub points: &'a [DVec2],
    /// Triangles (indices into `points`), those of the surroundings included.
    pub triangles: &'a [[u32; 3]],
    /// Known heights, metres; `None` where they are wanted.
    pub fixed: &'a [Option<f64>],
    /// Which points have a row in the bi-Laplacian: those whose one-ring of triangles is complete. Every unknown must
    /// be among them. Other points take part as neighbours only (natural condition).
    pub rows: &'a [bool],
}

/// Which surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothness {
    /// `min z' K z`: a soap film, never above or below its data.
    Harmonic,
    /// `min sum over rows (K z)_i^2 / M_i + tension * z' K z`: a thin plate that continues slopes. `tension` in 1 / m2.
    Biharmonic {
        /// 0 for the pure bi-Laplacian; the larger, the closer to a soap film.
        tension: f64,
    },
}

/// Solves for the unknown heights; returns all heights, the known ones as given.
///
/// Steps: cotangent stiffness K (unclamped, for Delaunay triangles) and lumped areas M in the plane; the plane that fits
/// the known heights best is taken off (both energies ignore it, and digits are saved); symmetric system of the
/// unknowns, Cholesky, one step of refinement; the plane is put back.
///
/// Source: Wang et al. 2021, eq. 2-4 (U2 = 0), in the symmetric form `(K M^-1 K)_ff z_f = -(K M^-1 K)_fb z_b`.
///
/// # Errors
/// [`SolveError`]: above all [`SolveError::NotPositiveDefinite`] if an unknown hangs on no known height.
pub fn solve_heights(
    problem: &HeightProblem<'_>,
    smoothness: Smoothness,
    solver: &dyn Solver,
) -> Result<Vec<f64>, SolveError> {
    let rows = Rows::new(&stiffness(problem.points, problem.triangles, Clamp::Off));
    let trend =
        PlaneFit::of(problem.points.iter().zip(problem.fixed).filter_map(|(p, z)| z.map(|z| p.extend(z))));
    let known: Vec<Option<f64>> = problem
        .points
        .iter()
        .zip(problem.fixed)
        .map(|(&p, height)| height.map(|z| z - trend.at(p)))
        .collect();
    let mut offsets = solve_component(&rows, problem.rows, &known, smoothness, solver)?.into_iter();
    let height = |(v, known): (usize, &Option<f64>)| {
        known.unwrap_or_else(|| offsets.next().unwrap_or(0.0) + trend.at(problem.points[v]))
    };
    Ok(problem.fixed.iter().enumerate().map(height).collect())
}

/// Solves one coordinate; returns the unknowns in order.
pub(crate) fn solve_component(
    rows: &Rows,
    is_row: &[bool],
    known: &[Option<f64>],
    smoothness: Smoothness,
    solver: &dyn Solver,
) -> Result<Vec<f64>, SolveError> {
    if !known.is_empty() && known.iter().all(Option::is_none) {
        return Err(SolveError::NotPositiveDefinite { pivot: 0, order: known.len() });
    }
    System::assemble(rows, is_row, known, smoothness)?.solve(solver)
}

/// The stiffness by rows, both triangles, and the lumped areas.
pub(crate) struct Rows {
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
    mass: Vec<f64>,
}

impl Rows {
    pub(crate) fn new(stiffness: &Stiffness) -> Self {
        let n = stiffness.mass.len();
        let mut starts = vec![0usize; n + 1];
        for &(i, j, _) in &stiffness.entries {
            starts[i as usize + 1] += 1;
            if i != j {
                starts[j as usize + 1] += 1;
            }
        }
        for v in 0..n {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0u32, 0.0); starts[n]];
        // Entries come sorted by (row, column), so every row fills up in ascending order.
        for &(i, j, value) in &stiffness.entries {
            for (row, column) in [(i, j), (j, i)] {
                entries[next[row as usize]] = (column, value);
                next[row as usize] += 1;
                if i == j {
                    break;
                }
            }
        }
        Self { starts, entries, mass: stiffness.mass.clone() }
    }

    fn of(&self, v: u32) -> &[(u32, f64)] {
        &self.entries[self.starts[v as usize]..self.starts[v as usize + 1]]
    }
}

const NONE: u32 = u32::MAX;

/// The symmetric system of the unknowns.
struct System {
    matrix: SparseSymmetric,
    rhs: Vec<f64>,
}

impl System {
    fn assemble(
        rows: &Rows,
        is_row: &[bool],
        known: &[Option<f64>],
        smoothness: Smoothness,
    ) -> Result<Self, SolveError> {
        let unknowns: Vec<u32> = (0..known.len() as u32).filter(|&v| known[v as usize].is_none()).collect();
        let mut builder = Builder::new(&unknowns, known);
        for &v in &unknowns {
            match smoothness {
                Smoothness::Harmonic => builder.add_row(rows.of(v), 1.0),
                Smoothness::Biharmonic { tension } => {
                    for &(i, weight) in rows.of(v) {
                        if is_row[i as usize] && rows.mass[i as usize] > 0.0 {
                            builder.add_row(rows.of(i), weight / rows.mass[i as usize]);
                        }
                    }
                    if tension > 0.0 {
                        builder.add_row(rows.of(v), tension);
                    }
                }
            }
            builder.finish_column()?;
        }
        let matrix = SparseSymmetric::from_sorted_columns(builder.starts, builder.rows, builder.values)?;
        Ok(Self { matrix, rhs: builder.rhs })
    }

    fn solve(&self, solver: &dyn Solver) -> Result<Vec<f64>, SolveError> {
        if self.rhs.iter().all(|&b| b == 0.0) {
            return Ok(vec![0.0; self.rhs.len()]);
        }
        let factor = solver.factor(&self.matrix)?;
        let mut x = self.rhs.clone();
        factor.solve(&mut x)?;
        // One step of refinement: the bi-Laplacian's condition grows with the fourth power of the size.
        let product = self.matrix.multiply(&x)?;
        let mut residual: Vec<f64> = self.rhs.iter().zip(product).map(|(b, p)| b - p).collect();
        factor.solve(&mut residual)?;
        x.iter_mut().zip(residual).for_each(|(x, r)| *x += r);
        Ok(x)
    }
}

/// Gathers one column at a time: sums in the order of the neighbours' ids.
struct Builder<'a> {
    known: &'a [Option<f64>],
    /// Number of each unknown among the unknowns.
    number: Vec<u32>,
    sum: Vec<f64>,
    seen: Vec<u32>,
    column: Vec<u32>,
    here: u32,
    total: f64,
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    rhs: Vec<f64>,
}

impl<'a> Builder<'a> {
    fn new(unknowns: &[u32], known: &'a [Option<f64>]) -> Self {
        let mut number = vec![NONE; known.len()];
        for (k, &v) in unknowns.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        let n = unknowns.len();
        Self {
            known,
            number,
            sum: vec![0.0; n],
            seen: vec![NONE; n],
            column: vec![],
            here: 0,
            total: 0.0,
            starts: vec![0],
            rows: vec![],
            values: vec![],
            rhs: vec![],
        }
    }

    /// Adds `weight` times a row of K: unknowns to the column, known heights to the right-hand side.
    fn add_row(&mut self, row: &[(u32, f64)], weight: f64) {
        for &(v, value) in row {
            match self.known[v as usize] {
                Some(z) => self.total -= weight * value * z,
                None => self.add(self.number[v as usize], weight * value),
            }
        }
    }

    fn add(&mut self, k: u32, value: f64) {
        if k < self.here {
            return;
        }
        if self.seen[k as usize] != self.here {
            self.seen[k as usize] = self.here;
            self.sum[k as usize] = 0.0;
            self.column.push(k);
        }
        self.sum[k as usize] += value;
    }

    fn finish_column(&mut self) -> Result<(), SolveError> {
        self.add(self.here, 0.0);
        self.column.sort_unstable();
        for &k in &self.column {
            self.rows.push(k);
            self.values.push(self.sum[k as usize]);
        }
        self.column.clear();
        let end = u32::try_from(self.rows.len()).map_err(|_| SolveError::TooLarge {
            order: self.number.len(),
            what: "more than 2^32 matrix entries".to_owned(),
        })?;
        self.starts.push(end);
        self.rhs.push(std::mem::take(&mut self.total));
        self.here += 1;
        Ok(())
    }
}
