//! From a coarse fit to the fit on all places, block by block (algorithms D.4: a local biharmonic correction).

use crate::blocks::{Block, block, split};
use crate::height_field::FieldParams;
use crate::plate::Plate;
use crate::robust::{Kind, robust_weights};
use crate::sample::{Sample, Spot};
use glam::DVec2;
use lacuna_solve::{SolveError, Solver, Triplet};

/// What is minimised; samples lie on places of the plate.
pub(crate) struct Refinement<'a> {
    pub(crate) plate: &'a Plate<'a>,
    pub(crate) samples: &'a [Sample],
    pub(crate) params: &'a FieldParams,
    pub(crate) edge_m: f64,
    /// 1 / m2.
    pub(crate) tension: f64,
    /// Smoothing length, metres.
    pub(crate) length_m: f64,
}

/// Weights of the sweeps over all blocks. What the coarse fit lacks is short-waved, so that few are enough; they begin mildly,
/// for against coarse triangles the ground's own shape looks like outliers.
const SWEEPS: [Kind; 4] = [Kind::Huber, Kind::Huber, Kind::Tukey, Kind::Tukey];
/// Rings by which blocks overlap.
const OVERLAP: usize = 6;
/// A core of this share of the places that a solve may have leaves room for the overlap.
const CORE_SHARE: f64 = 0.4;

/// Moves the surface `z` (metres, a coarse fit) to the minimum of the energy over all places, and returns the weights of
/// the samples.
///
/// In each sweep every block is solved in turn with all other places held where they are, and takes its heights at once
/// (multiplicative Schwarz with overlap); then the samples are weighed anew.
pub(crate) fn refine(
    problem: &Refinement<'_>,
    mut robust: Vec<f64>,
    z: &mut [f64],
    solver: &dyn Solver,
) -> Result<Vec<f64>, SolveError> {
    let cores = split(problem.plate.places, core_limit(problem.params));
    let sample_of = samples_by_place(problem, z.len());
    let floor_m = problem.params.noise_floor_edges * problem.edge_m;
    for kind in SWEEPS {
        let residuals: Vec<f64> = problem.samples.iter().map(|s| s.residual_m(z)).collect();
        robust = robust_weights(&residuals, kind, floor_m);
        for core in &cores {
            solve_block(problem, core, &sample_of, &robust, z, solver)?;
        }
    }
    Ok(robust)
}

/// Places that the core of a block may have.
pub(crate) fn core_limit(params: &FieldParams) -> usize {
    (CORE_SHARE * params.max_unknowns as f64) as usize
}

const NONE: u32 = u32::MAX;

/// The sample at each place.
fn samples_by_place(problem: &Refinement<'_>, count: usize) -> Vec<u32> {
    let mut sample_of = vec![NONE; count];
    for (sample, k) in problem.samples.iter().zip(0u32..) {
        let Spot { corners, .. } = sample.spot;
        sample_of[corners[0] as usize] = k;
    }
    sample_of
}

fn solve_block(
    problem: &Refinement<'_>,
    core: &[u32],
    sample_of: &[u32],
    robust: &[f64],
    z: &mut [f64],
    solver: &dyn Solver,
) -> Result<(), SolveError> {
    let whole = problem.plate;
    let Block { members, free, triangles } = block(core, OVERLAP, whole.triangles, &whole.fans);
    let places: Vec<DVec2> = members.iter().map(|&v| whole.places[v as usize]).collect();
    let matrix = Plate::new(&places, &triangles).matrix(problem.tension)?;
    let held: Vec<f64> = members[free..].iter().map(|&v| z[v as usize]).collect();
    let (matrix, mut load) = matrix.leading(free, &held)?;
    let mut data = Vec::with_capacity(free);
    let length4 = problem.length_m.powi(4);
    for (k, &v) in members[..free].iter().enumerate() {
        let Some(sample) = problem.samples.get(sample_of[v as usize] as usize) else { continue };
        let weight = sample.mass_m2 * robust[sample_of[v as usize] as usize] / length4;
        load[k] += weight * sample.height_m;
        data.push(Triplet { row: k as u32, column: k as u32, value: weight });
    }
    solver.factor(&matrix.plus(data)?)?.solve(&mut load)?;
    members.iter().zip(load).for_each(|(&v, height_m)| z[v as usize] = height_m);
    Ok(())
}
