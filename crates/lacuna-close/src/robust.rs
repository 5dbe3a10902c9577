//! Robust weights from residuals (algorithms D.3).

/// Which weight function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Pulls large residuals less than their square would.
    Huber,
    /// Drops them.
    Tukey,
}

/// Rounds of Huber and then of Tukey weights.
pub(crate) const ROUNDS: [Kind; 7] =
    [Kind::Huber, Kind::Huber, Kind::Huber, Kind::Tukey, Kind::Tukey, Kind::Tukey, Kind::Tukey];

/// What is left of an outlier's weight: the system stays definite.
pub(crate) const REJECTED: f64 = 1e-6;

/// Widths in standard deviations.
const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
/// Standard deviation over median absolute deviation.
const DEVIATION: f64 = 1.4826;

/// A weight for each residual, metres; their scale comes from the median, and is at least `floor_m`: the median of a
/// clean rim is so small that the ground's own shape would be rejected.
pub(crate) fn robust_weights(residuals_m: &[f64], kind: Kind, floor_m: f64) -> Vec<f64> {
    if residuals_m.is_empty() {
        return vec![];
    }
    let mut sizes: Vec<f64> = residuals_m.iter().map(|r| r.abs()).collect();
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let scale = (DEVIATION * median).max(floor_m);
    let weight = |r: &f64| match kind {
        Kind::Huber => (HUBER * scale / r.abs().max(1e-300)).min(1.0),
        Kind::Tukey => {
            let t = r / (TUKEY * scale);
            if t.abs() < 1.0 { ((1.0 - t * t) * (1.0 - t * t)).max(REJECTED) } else { REJECTED }
        }
    };
    residuals_m.iter().map(weight).collect()
}
