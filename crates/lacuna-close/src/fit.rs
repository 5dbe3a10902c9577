//! The robust fit of a plate to samples of the ground.

use crate::height_field::FieldParams;
use crate::held_back::{arcs, scattered};
use crate::plate::Plate;
use crate::robust::{Kind, REJECTED, ROUNDS, robust_weights};
use crate::sample::Sample;
use lacuna_solve::{Factor, SolveError, Solver, SparseSymmetric, Triplet};

/// Smoothing lengths to choose from, rim edges, and by what the error of each on held-back data is multiplied. Those data
/// lie among others; the hole does not. There a long length, which takes its slope from farther behind the rim, is a risk
/// that a slightly better prediction is not worth: on rough ground 0.7 is better in the mean and worse by a tenth at times.
const SMOOTHING_EDGES: [(f64, f64); 4] = [(0.1, 1.0), (0.35, 1.02), (0.7, 1.2), (1.4, 1.3)];
/// Tensions to choose from, times the given one, and by what the error of each on held-back arcs is multiplied: on ground
/// that shows neither, the thin plate stands. Rough ground goes back to its mean soon, smooth ground goes on.
const TENSIONS: [(f64, f64); 4] = [(1.0, 1.0), (4.0, 1.01), (16.0, 1.02), (64.0, 1.03)];
/// Share of the held-back residuals that count: the largest may be outliers.
const COUNTED_SHARE: f64 = 0.8;
/// How often tension is raised fourfold.
const TENSION_STEPS: u32 = 6;

/// What a fit starts from.
pub(crate) struct Problem<'a> {
    pub(crate) plate: &'a Plate<'a>,
    pub(crate) samples: &'a [Sample],
    /// Places without a datum.
    pub(crate) is_wanted: &'a [bool],
    pub(crate) params: &'a FieldParams,
    /// Typical rim edge, metres.
    pub(crate) edge_m: f64,
    /// Tension by which others are measured, 1 / m2.
    pub(crate) tension: f64,
}

/// What held-back data choose where nothing is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chosen {
    /// Smoothing length, rim edges.
    pub(crate) smoothing_edges: f64,
    /// Times the tension by which others are measured.
    pub(crate) tension: f64,
}

/// Chooses smoothing and tension by the data of `problem`.
pub(crate) fn choose(problem: &Problem<'_>, solver: &dyn Solver) -> Result<Chosen, SolveError> {
    Fit::new(problem, solver)?.choose()
}

/// A fitted surface and how it came about.
pub(crate) struct Fitted {
    /// Height at each place, metres.
    pub(crate) heights_m: Vec<f64>,
    /// Robust weight of each sample.
    pub(crate) robust: Vec<f64>,
    pub(crate) smoothing_edges: f64,
    /// 1 / m2.
    pub(crate) tension: f64,
    /// How often tension was raised.
    pub(crate) tension_steps: u32,
}

/// Minimises the energy of [`crate::height_field`] over the places of `problem`.
pub(crate) fn fit(problem: &Problem<'_>, solver: &dyn Solver) -> Result<Fitted, SolveError> {
    let mut fit = Fit::new(problem, solver)?;
    let Chosen { smoothing_edges, tension } = fit.choose()?;
    fit.set_tension(tension)?;
    fit.refactor()?;
    let (heights_m, tension_steps) = fit.solve_guarded()?;
    Ok(Fitted { heights_m, robust: fit.robust, smoothing_edges, tension: fit.tension, tension_steps })
}

/// A fit in work.
struct Fit<'a> {
    problem: &'a Problem<'a>,
    /// Smoothing length to the fourth.
    length4: f64,
    /// 1 / m2.
    tension: f64,
    /// Least standard deviation of the data, metres.
    floor_m: f64,
    energy: SparseSymmetric,
    factor: Box<dyn Factor>,
    /// Robust weight of each sample.
    robust: Vec<f64>,
}

impl<'a> Fit<'a> {
    fn new(problem: &'a Problem<'a>, solver: &dyn Solver) -> Result<Self, SolveError> {
        let energy = problem.plate.matrix(problem.tension)?;
        let length4 = problem.edge_m.powi(4);
        let robust = vec![1.0; problem.samples.len()];
        let factor = solver.factor(&energy.plus(data_entries(problem, &robust, length4))?)?;
        let floor_m = problem.params.noise_floor_edges * problem.edge_m;
        Ok(Self { problem, length4, tension: problem.tension, floor_m, energy, factor, robust })
    }

    /// Smoothing first; it stays set.
    fn choose(&mut self) -> Result<Chosen, SolveError> {
        let params = self.problem.params;
        let smoothing_edges = match params.smoothing_edges {
            Some(given) => given,
            None => self.best_smoothing()?,
        };
        self.set_smoothing(smoothing_edges);
        let tension = match params.tension {
            Some(given) => given,
            None => self.best_tension()?,
        };
        Ok(Chosen { smoothing_edges, tension })
    }

    fn set_smoothing(&mut self, edges: f64) {
        self.length4 = (edges * self.problem.edge_m).powi(4);
    }

    /// Takes a tension, in units of the given one.
    fn set_tension(&mut self, times: f64) -> Result<(), SolveError> {
        self.tension = times * self.problem.tension;
        self.energy = self.problem.plate.matrix(self.tension)?;
        Ok(())
    }

    /// The smoothing length, in edges, whose surface comes nearest to data that it has not seen: the noise of the rim
    /// asks for a long one, the shape of the ground for a short one.
    fn best_smoothing(&mut self) -> Result<f64, SolveError> {
        let held = scattered(self.problem.samples.len());
        let mut best = (SMOOTHING_EDGES[0].0, f64::INFINITY);
        for (edges, risk) in SMOOTHING_EDGES {
            self.set_smoothing(edges);
            let error = risk * self.held_back_error(&held)?;
            if error < best.1 {
                best = (edges, error);
            }
        }
        self.robust.fill(1.0);
        Ok(best.0)
    }

    /// The tension, times the given one, whose surface comes nearest to arcs of the rim that it has not seen.
    fn best_tension(&mut self) -> Result<f64, SolveError> {
        let Problem { plate, samples, is_wanted, edge_m, .. } = *self.problem;
        let held = arcs(plate, samples, is_wanted, edge_m);
        let mut best = (TENSIONS[0].0, f64::INFINITY);
        if !held.is_empty() && held.len() < samples.len() {
            for (times, risk) in TENSIONS {
                self.set_tension(times)?;
                let error = risk * self.held_back_error(&held)?;
                if error < best.1 {
                    best = (times, error);
                }
            }
        }
        self.robust.fill(1.0);
        Ok(best.0)
    }

    /// Mean residual of the held-back samples, the largest left out.
    fn held_back_error(&mut self, held: &[usize]) -> Result<f64, SolveError> {
        let hold_back = |robust: &mut Vec<f64>| held.iter().for_each(|&k| robust[k] = 0.0);
        self.robust.fill(1.0);
        hold_back(&mut self.robust);
        self.refactor()?;
        let z = self.solve()?;
        self.reweight(&z, Kind::Huber);
        hold_back(&mut self.robust);
        self.refactor()?;
        let z = self.solve()?;
        let residual = |&k: &usize| self.problem.samples[k].residual_m(&z).abs();
        let mut residuals: Vec<f64> = held.iter().map(residual).collect();
        residuals.sort_by(f64::total_cmp);
        residuals.truncate(((residuals.len() as f64 * COUNTED_SHARE).ceil() as usize).max(1));
        Ok(residuals.iter().sum::<f64>() / residuals.len().max(1) as f64)
    }

    /// Solves with more and more tension until the surface keeps to the range of its data; the last one stands.
    fn solve_guarded(&mut self) -> Result<(Vec<f64>, u32), SolveError> {
        let mut z = self.solve_robust()?;
        let mut step = 0;
        while step < TENSION_STEPS && !self.is_in_range(&z) {
            step += 1;
            self.set_tension(4.0 * self.tension / self.problem.tension)?;
            self.robust.fill(1.0);
            self.refactor()?;
            z = self.solve_robust()?;
        }
        Ok((z, step))
    }

    fn solve_robust(&mut self) -> Result<Vec<f64>, SolveError> {
        let mut z = self.solve()?;
        for kind in ROUNDS {
            self.reweight(&z, kind);
            self.refactor()?;
            z = self.solve()?;
        }
        Ok(z)
    }

    fn solve(&self) -> Result<Vec<f64>, SolveError> {
        let mut z = data_load(self.problem, &self.robust, self.length4);
        self.factor.solve(&mut z)?;
        Ok(z)
    }

    fn refactor(&mut self) -> Result<(), SolveError> {
        let entries = data_entries(self.problem, &self.robust, self.length4);
        self.factor.refactor(&self.energy.plus(entries)?)
    }

    fn reweight(&mut self, z: &[f64], kind: Kind) {
        let residuals: Vec<f64> = self.problem.samples.iter().map(|s| s.residual_m(z)).collect();
        self.robust = robust_weights(&residuals, kind, self.floor_m);
    }

    /// True if no height leaves the range of the data that count by more than the share allowed.
    fn is_in_range(&self, z: &[f64]) -> bool {
        let problem = self.problem;
        let counted = problem.samples.iter().zip(&self.robust).filter(|(_, robust)| **robust > 0.5);
        let heights = counted.map(|(sample, _)| sample.height_m);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let slack = problem.params.overshoot * (high - low) + self.floor_m;
        let mut wanted = z.iter().zip(problem.is_wanted).filter(|(_, is_wanted)| **is_wanted);
        wanted.all(|(&z, _)| z >= low - slack && z <= high + slack)
    }
}

/// What the data add to the matrix of the energy.
fn data_entries<'a>(
    problem: &'a Problem<'_>,
    robust: &'a [f64],
    length4: f64,
) -> impl Iterator<Item = Triplet> + 'a {
    let samples = problem.samples.iter().zip(robust);
    samples.flat_map(move |(s, robust)| s.entries(s.mass_m2 * robust / length4))
}

/// The right-hand side that the data make.
fn data_load(problem: &Problem<'_>, robust: &[f64], length4: f64) -> Vec<f64> {
    let mut load = vec![0.0; problem.is_wanted.len()];
    for (sample, robust) in problem.samples.iter().zip(robust) {
        let weight = sample.mass_m2 * robust / length4;
        for (&corner, share) in sample.spot.corners.iter().zip(sample.spot.shares) {
            load[corner as usize] += weight * share * sample.height_m;
        }
    }
    load
}

/// Share of the samples that a fit took for outliers.
pub(crate) fn outlier_share(robust: &[f64]) -> f64 {
    robust.iter().filter(|r| **r <= REJECTED).count() as f64 / robust.len().max(1) as f64
}
