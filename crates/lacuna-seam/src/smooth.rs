//! Laplacian smoothing of a border's heights.

use crate::neighbours::Neighbours;
use glam::{DVec2, DVec3};

/// A vertex of a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamVertex {
    /// Place in plan, metres. Never changed.
    pub plan: DVec2,
    /// Height, metres.
    pub z: f64,
    /// True for vertices of original meshes (covered, rim end): they are neighbours to others but never move.
    pub frozen: bool,
}

/// How strongly and how far to smooth. The default is what algorithms.md, H gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothParams {
    /// Share of the way to the neighbours' mean that a vertex goes in a round (gamma), between 0 and 1 without both.
    pub gamma: f64,
    /// Most rounds.
    pub rounds: u32,
    /// Rounds end when no vertex would move its height by as much as this towards the full mean, metres.
    pub tolerance_m: f64,
    /// Reach of the neighbourhood in mean spacings of the border's vertices.
    pub buffer_spacings: f64,
}

impl Default for SmoothParams {
    fn default() -> Self {
        Self { gamma: 0.5, rounds: 10, tolerance_m: 1e-3, buffer_spacings: 3.0 }
    }
}

/// What smoothing did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SmoothOutcome {
    /// Rounds that moved vertices.
    pub rounds: u32,
    /// Largest |dp| that was left when it ended, metres: how far some vertex still is from its neighbours' mean.
    pub residual_m: f64,
    /// Largest change of a height over all rounds, metres.
    pub largest_move_m: f64,
}

/// Input that has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SeamError {
    /// Gamma is outside of its range: 0 moves nothing, 1 and more may swing.
    #[error("seam smoothing: gamma is {0}; choose a number above 0 and below 1")]
    Gamma(f64),
    /// The reach is not a length.
    #[error("seam smoothing: the buffer is {0} m; it must be a finite length of 0 or more")]
    Buffer(f64),
    /// The tolerance is not a length.
    #[error("seam smoothing: the tolerance is {0} m; it must be 0 or more")]
    Tolerance(f64),
    /// A border vertex is not finite.
    #[error("seam smoothing: border vertex {0} has a coordinate that is no finite number; mend its tile")]
    Vertex(usize),
    /// A strip point is not finite.
    #[error("seam smoothing: strip point {0} has a coordinate that is no finite number; mend its tile")]
    Strip(usize),
}

/// Smooths the heights of a border's vertices towards the surfaces on both sides.
///
/// Wang et al. 2021, sec. 3.4, eq. 5-6: in each round `dp = (1/m) sum (s_i - p)` and `p_new = p + gamma * dp`, where `p`
/// is a vertex's height and `s_i` are the heights of the `m` points not farther than `buffer_m` in plan: points of
/// `strips` and other vertices of the border. All vertices move at once (Jacobi), so that no order matters. It ends
/// after `params.rounds`, or when the largest `|dp|` is below `params.tolerance_m`. A vertex without neighbours stays.
///
/// `border`: the vertices of one border, or of all borders that meet in a corner; their order has no meaning here.
/// `strips`: vertices of the patches of all cells on either side, metres, without the border's own vertices; heights
/// there are fixed. Only `z` of vertices that are not frozen changes. The result is bit for bit the same for any order
/// of `strips`, and of `border`.
///
/// # Errors
/// [`SeamError`] if a parameter is out of range or a coordinate is not finite; then nothing was changed.
pub fn smooth(
    border: &mut [SeamVertex],
    strips: &[DVec3],
    buffer_m: f64,
    params: &SmoothParams,
) -> Result<SmoothOutcome, SeamError> {
    check(border, strips, buffer_m, params)?;
    let neighbours = Neighbours::find(border, strips, buffer_m);
    let before: Vec<f64> = border.iter().map(|vertex| vertex.z).collect();
    let mut outcome = SmoothOutcome::default();
    loop {
        let steps = steps(border, strips, &neighbours);
        outcome.residual_m = largest(steps.iter().copied());
        if outcome.rounds == params.rounds || outcome.residual_m < params.tolerance_m {
            break;
        }
        border.iter_mut().zip(&steps).for_each(|(vertex, step)| vertex.z += params.gamma * step);
        outcome.rounds += 1;
    }
    outcome.largest_move_m = largest(border.iter().zip(&before).map(|(vertex, z)| vertex.z - z));
    Ok(outcome)
}

/// Reach of the neighbourhood for a polyline of border vertices in walking order, metres: `params.buffer_spacings`
/// times the mean distance of consecutive vertices in plan; 0 if there are fewer than two.
#[must_use]
pub fn buffer_m(polyline: &[SeamVertex], params: &SmoothParams) -> f64 {
    let edges = polyline.len().saturating_sub(1);
    if edges == 0 {
        return 0.0;
    }
    let length_m: f64 = polyline.windows(2).map(|pair| pair[0].plan.distance(pair[1].plan)).sum();
    params.buffer_spacings * length_m / edges as f64
}

/// `dp` of every vertex; 0 for those that stay: a frozen vertex has no neighbours here.
fn steps(border: &[SeamVertex], strips: &[DVec3], neighbours: &Neighbours) -> Vec<f64> {
    let step = |index: usize| {
        let z = border[index].z;
        let near = neighbours.of(index);
        // Differences, not heights, are added: a flat border stays flat to the last bit.
        let sum: f64 = near.iter().map(|neighbour| neighbour.height(border, strips) - z).sum();
        if near.is_empty() { 0.0 } else { sum / near.len() as f64 }
    };
    (0..border.len()).map(step).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

fn check(
    border: &[SeamVertex],
    strips: &[DVec3],
    buffer_m: f64,
    params: &SmoothParams,
) -> Result<(), SeamError> {
    if !(params.gamma > 0.0 && params.gamma < 1.0) {
        return Err(SeamError::Gamma(params.gamma));
    }
    if !(buffer_m >= 0.0 && buffer_m.is_finite()) {
        return Err(SeamError::Buffer(buffer_m));
    }
    if params.tolerance_m.is_nan() || params.tolerance_m < 0.0 {
        return Err(SeamError::Tolerance(params.tolerance_m));
    }
    let bad_vertex = |vertex: &SeamVertex| !(vertex.plan.is_finite() && vertex.z.is_finite());
    match (border.iter().position(bad_vertex), strips.iter().position(|point| !point.is_finite())) {
        (Some(index), _) => Err(SeamError::Vertex(index)),
        (None, Some(index)) => Err(SeamError::Strip(index)),
        (None, None) => Ok(()),
    }
}
