//! What a fitted surface misses on the rim, carried into the hole.

use crate::height_field::Region;
use lacuna_mesh::{Clamp, stiffness};
use lacuna_solve::{SolveError, SparseSymmetric, Triplet, conjugate_gradients};

/// Reach of the correction, rim edges.
const REACH_EDGES: f64 = 3.0;
/// The correction is found to this share of itself.
const TOLERANCE: f64 = 1e-12;

/// Adds to the surface `z` what it misses on the exact data, fading out over a few rim edges: `(K + M / reach^2) c = 0`
/// where heights are wanted, c = residual on the rim (algorithms D.3: a noisy residual has no slope to go on with).
/// `height_m` tells the height of the datum at a place, in the frame of `z`.
pub(crate) fn join_rim(
    region: &Region,
    height_m: impl Fn(usize) -> Option<f64>,
    z: &mut [f64],
) -> Result<(), SolveError> {
    let reach_m = REACH_EDGES * region.edge_m;
    let mut number = vec![u32::MAX; z.len()];
    let free: Vec<u32> = (0..z.len() as u32).filter(|&v| region.data[v as usize].is_none()).collect();
    free.iter().zip(0u32..).for_each(|(&v, k)| number[v as usize] = k);
    if free.is_empty() {
        return Ok(());
    }
    let residual = |v: u32| match region.data[v as usize] {
        Some(d) if d.is_exact => height_m(v as usize).map_or(0.0, |height_m| height_m - z[v as usize]),
        _ => 0.0,
    };
    let is_near_free = |t: &&[u32; 3]| t.iter().any(|&v| number[v as usize] != u32::MAX);
    let triangles: Vec<[u32; 3]> = region.triangles.iter().filter(is_near_free).copied().collect();
    let stiffness = stiffness(&region.places, &triangles, Clamp::Off);
    let mut triplets = Vec::with_capacity(stiffness.entries.len());
    let mut rhs = vec![0.0; free.len()];
    for &(row, column, value) in &stiffness.entries {
        match (number[row as usize], number[column as usize]) {
            (u32::MAX, u32::MAX) => {}
            (k, u32::MAX) => rhs[k as usize] -= value * residual(column),
            (u32::MAX, k) => rhs[k as usize] -= value * residual(row),
            (row, column) => triplets.push(Triplet { row, column, value }),
        }
    }
    triplets.extend(free.iter().zip(0u32..).map(|(&v, k)| {
        let value = stiffness.mass[v as usize] / (reach_m * reach_m);
        Triplet { row: k, column: k, value }
    }));
    let matrix = SparseSymmetric::from_triplets(free.len(), &triplets)?;
    let correction = conjugate_gradients(&matrix, &rhs, TOLERANCE)?;
    free.iter().zip(correction).for_each(|(&v, c)| z[v as usize] += c);
    Ok(())
}
