//! Is a hole water? Its level, from the lower envelope of the rim (algorithms D.5).

use glam::{DVec2, DVec3};
use lacuna_mesh::PlaneFit;

/// A water surface and how the rim supports it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// The surface: level, or sloped along the hole's longer axis.
    pub plane: PlaneFit,
    /// Share of the rim's length that lies on it.
    pub support: f64,
    /// Root mean square distance of that part, metres.
    pub residual_m: f64,
}

/// A rim vertex with half the length of its rim edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RimPoint {
    /// Position, metres.
    pub position: DVec3,
    /// Its share of the rim, metres.
    pub length_m: f64,
}

/// Part of the rim below the envelope's line.
const QUANTILE: f64 = 0.2;
/// Rim points this near lie on the water, metres.
const NEAR_M: f64 = 0.15;
/// Share of the rim that must.
const SUPPORT: f64 = 0.6;
/// Share of the rim that may lie deeper: water would run off there.
const BELOW: f64 = 0.05;
/// A rim with residuals up to this is flat, metres; one with larger ones must be uneven.
const FLAT_M: f64 = 0.03;
const UNEVEN: f64 = 0.1;
/// Steepest water.
const STEEPEST: f64 = 0.01;
/// A hole this many rim edges wide may be water; smaller ones follow their rim anyway.
const WIDE_EDGES: f64 = 20.0;
/// A rim so many times longer than wide may be a river.
const LONG: f64 = 3.0;
const ROUNDS: usize = 40;

/// Finds the water level of a rim, `None` if the rim does not support one: fewer than 60 % of its length within 0.15 m of
/// a level, or of a slope of at most 1 % along a long hole; more than 5 % of it deeper; a rim that is not flat but bends as
/// ground does, without noise; a hole too narrow to tell.
///
/// Steps: quantile regression at 20 % of the heights (iteratively reweighted), first level, then with a slope along the
/// principal axis; the points near it recentre it (their mean), until it stays.
#[must_use]
pub fn water(rim: &[RimPoint], width_m: f64, edge_m: f64) -> Option<Water> {
    if width_m <= WIDE_EDGES * edge_m || rim.len() < 3 {
        return None;
    }
    let level = supported(rim, envelope(rim, DVec2::ZERO));
    level.or_else(|| {
        let axis = principal_axis(rim).filter(|axis| axis.elongation >= LONG)?;
        supported(rim, envelope(rim, axis.direction))
    })
}

/// The water of a hole that is known to be water: as [`water`] finds it, else level on the rim's lower envelope, whatever
/// part of the rim that is; `support` and `residual_m` tell how far it can be trusted. `None` without a rim.
#[must_use]
pub fn forced_water(rim: &[RimPoint]) -> Option<Water> {
    // The width does not matter: a narrow ditch is water too.
    let found = water(rim, f64::INFINITY, 0.0);
    found.or_else(|| (!rim.is_empty()).then(|| given_water(rim, envelope(rim, DVec2::ZERO))))
}

/// The water with a given plane, as the rim sees it.
#[must_use]
pub fn given_water(rim: &[RimPoint], plane: PlaneFit) -> Water {
    let off = |p: &RimPoint| p.position.z - plane.at(p.position.truncate());
    let near = rim.iter().filter(|p| off(p).abs() <= NEAR_M);
    let (length, square) =
        near.fold((0.0, 0.0), |(l, s), p| (l + p.length_m, s + p.length_m * off(p) * off(p)));
    Water {
        plane,
        support: share(rim, |off_m| off_m.abs() <= NEAR_M, &plane),
        residual_m: if length > 0.0 { (square / length).sqrt() } else { 0.0 },
    }
}

fn supported(rim: &[RimPoint], plane: PlaneFit) -> Option<Water> {
    let found = given_water(rim, plane);
    let is_shore = share(rim, |off_m| off_m < -NEAR_M, &plane) <= BELOW;
    let is_plane = found.residual_m <= FLAT_M || unevenness(rim, &plane) >= UNEVEN;
    (found.support >= SUPPORT && is_shore && is_plane && plane.slope.length() <= STEEPEST).then_some(found)
}

/// How unlike each other the offsets of neighbouring rim points from a plane are, as a share of what independent ones would
/// be: half the mean square of their differences over their mean square, for points near the plane (von Neumann 1941).
/// Noise on a level is uneven; ground that happens to lie near a level is not.
fn unevenness(rim: &[RimPoint], plane: &PlaneFit) -> f64 {
    let off_m = |p: &RimPoint| p.position.z - plane.at(p.position.truncate());
    let (mut steps, mut squares) = (0.0, 0.0);
    for [a, b] in rim.array_windows() {
        let are_neighbours = a.position.truncate().distance(b.position.truncate()) <= a.length_m + b.length_m;
        let [a_m, b_m] = [off_m(a), off_m(b)];
        if are_neighbours && a_m.abs().max(b_m.abs()) <= NEAR_M {
            steps += (a_m - b_m) * (a_m - b_m);
            squares += a_m * a_m + b_m * b_m;
        }
    }
    if squares > 0.0 { steps / squares } else { 0.0 }
}

/// Share of a rim's length whose height over a plane is as asked for, metres.
fn share(rim: &[RimPoint], is_wanted: impl Fn(f64) -> bool, plane: &PlaneFit) -> f64 {
    let off_m = |p: &RimPoint| p.position.z - plane.at(p.position.truncate());
    let total_m: f64 = rim.iter().map(|p| p.length_m).sum();
    let wanted_m: f64 = rim.iter().filter(|p| is_wanted(off_m(p))).map(|p| p.length_m).sum();
    if total_m > 0.0 { wanted_m / total_m } else { 0.0 }
}

/// The plane below which a fifth of the rim lies, recentred on the points near it; its slope runs along `axis`, none if
/// that is zero.
fn envelope(rim: &[RimPoint], axis: DVec2) -> PlaneFit {
    let mut plane = fit(rim, axis, |_| 1.0);
    for round in 0..ROUNDS {
        let off = |p: &RimPoint| p.position.z - plane.at(p.position.truncate());
        // First the quantile, then the mean of what lies near it, if anything does.
        if round < ROUNDS / 2 {
            plane = fit(rim, axis, |p| quantile_side(off(p)) / off(p).abs().max(0.01));
        } else if rim.iter().any(|p| off(p).abs() <= NEAR_M) {
            plane = fit(rim, axis, |p| f64::from(u8::from(off(p).abs() <= NEAR_M)));
        }
    }
    plane
}

/// How badly a plane fits the lower envelope of a rim: the quantile loss that [`water`] minimises.
pub(crate) fn envelope_loss(rim: &[RimPoint], plane: &PlaneFit) -> f64 {
    let off = |p: &RimPoint| p.position.z - plane.at(p.position.truncate());
    rim.iter().map(|p| p.length_m * quantile_side(off(p)) * off(p).abs()).sum()
}

/// Weight of a residual: what lies below the envelope counts four times as much as what lies above it.
fn quantile_side(residual_m: f64) -> f64 {
    if residual_m < 0.0 { 1.0 - QUANTILE } else { QUANTILE }
}

/// Weighted least squares of a height and a slope along `axis`.
fn fit(rim: &[RimPoint], axis: DVec2, weight: impl Fn(&RimPoint) -> f64) -> PlaneFit {
    let weighted = || rim.iter().map(|p| (p.position, p.length_m * weight(p)));
    let total: f64 = weighted().map(|(_, w)| w).sum();
    if total <= 0.0 {
        return PlaneFit { level_m: f64::INFINITY, ..PlaneFit::default() };
    }
    let mean = weighted().map(|(p, w)| p * w).sum::<DVec3>() / total;
    let (mut ss, mut sz) = (0.0, 0.0);
    for (d, w) in weighted().map(|(p, w)| (p - mean, w)) {
        let s = axis.dot(d.truncate());
        ss += w * s * s;
        sz += w * s * d.z;
    }
    let slope = if ss > 0.0 { axis * (sz / ss) } else { DVec2::ZERO };
    PlaneFit { centre: mean.truncate(), level_m: mean.z, slope }
}

/// The direction in which a rim is longest.
pub(crate) struct PrincipalAxis {
    /// Of length 1.
    pub(crate) direction: DVec2,
    /// Length over width: square root of the ratio of the second moments.
    elongation: f64,
}

/// The longer principal axis of a rim in plan; `None` if it has none, as a circle.
pub(crate) fn principal_axis(rim: &[RimPoint]) -> Option<PrincipalAxis> {
    let total: f64 = rim.iter().map(|p| p.length_m).sum();
    let mean = rim.iter().map(|p| p.position.truncate() * p.length_m).sum::<DVec2>() / total;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (d, w) in rim.iter().map(|p| (p.position.truncate() - mean, p.length_m)) {
        xx += w * d.x * d.x;
        xy += w * d.x * d.y;
        yy += w * d.y * d.y;
    }
    let (half, root) = ((xx + yy) / 2.0, (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt());
    let [long, short] = [half + root, half - root];
    // Of the two rows of the eigenvector's equation the one with the larger numbers.
    let axis = if xx > yy { DVec2::new(long - yy, xy) } else { DVec2::new(xy, long - xx) };
    let elongation = (long / short.max(1e-12 * long)).sqrt();
    axis.try_normalize().map(|direction| PrincipalAxis { direction, elongation })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Repeatable numbers in [-1, 1].
    fn noise(k: usize) -> f64 {
        let x = libm::sin(k as f64 * 12.9898) * 43_758.545_3;
        2.0 * (x - x.floor()) - 1.0
    }

    /// An ellipse of 400 rim points 1 m apart, about; `z` by index and place.
    fn rim(half: DVec2, z: impl Fn(usize, DVec2) -> f64) -> Vec<RimPoint> {
        let point = |k: usize| {
            let t = std::f64::consts::TAU * k as f64 / 400.0;
            let p = DVec2::new(half.x * libm::cos(t), half.y * libm::sin(t));
            RimPoint { position: p.extend(z(k, p)), length_m: 1.0 }
        };
        (0..400).map(point).collect()
    }

    const ROUND: DVec2 = DVec2::new(60.0, 50.0);
    const RIVER: DVec2 = DVec2::new(180.0, 15.0);

    #[test]
    fn a_level_shows_through_noise_and_walls() {
        for walls in [0, 10, 20, 30] {
            let lake = rim(ROUND, |k, _| {
                if k % 100 < walls { 0.5 + 3.0 * noise(k + 7).abs() } else { -0.45 + 0.1 * noise(k) }
            });
            let found = water(&lake, 100.0, 1.0).unwrap_or_else(|| panic!("{walls} % walls"));
            assert!((found.plane.at(DVec2::ZERO) + 0.45).abs() < 0.05, "{walls} %: {found:?}");
            assert_eq!(found.plane.slope, DVec2::ZERO);
            assert!((found.support - (1.0 - walls as f64 / 100.0)).abs() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn a_river_may_fall_along_its_axis() {
        let river = rim(RIVER, |k, p| 10.0 + 0.004 * p.x + 0.05 * noise(k));
        let found = water(&river, 30.0, 1.0).expect("a river");
        assert!((found.plane.slope.x - 0.004).abs() < 2e-4 && found.plane.slope.y.abs() < 1e-6, "{found:?}");
        let steep = rim(RIVER, |_, p| 10.0 + 0.02 * p.x);
        assert_eq!(water(&steep, 30.0, 1.0), None);
        let round = rim(ROUND, |_, p| 10.0 + 0.008 * p.x);
        assert_eq!(water(&round, 100.0, 1.0), None, "a round lake does not fall");
    }

    #[test]
    fn hills_and_small_holes_are_no_water() {
        let hills = rim(ROUND, |_, p| 1.5 * libm::sin(0.1 * p.x) + 0.7 * libm::cos(0.07 * p.y));
        assert_eq!(water(&hills, 100.0, 1.0), None);
        // Low ground, three quarters of it within 25 cm, the rest a slope.
        let basin = rim(ROUND, |_, p| 0.1 * libm::sin(0.05 * p.y) + 0.4 * (p.x / 60.0 - 0.4).max(0.0));
        assert_eq!(water(&basin, 100.0, 1.0), None);
        let outflow = rim(ROUND, |k, _| if k < 40 { -0.5 } else { 0.05 * noise(k) });
        assert_eq!(water(&outflow, 100.0, 1.0), None);
        let lake = rim(ROUND, |k, _| 0.02 * noise(k));
        assert!(water(&lake, 100.0, 1.0).is_some());
        assert_eq!(water(&lake, 19.0, 1.0), None);
        assert_eq!(water(&[], 100.0, 1.0), None);
    }

    #[test]
    fn known_water_has_a_level_whatever_the_rim_says() {
        // Quay walls all round but for a slip: a sixth of the rim.
        let basin = rim(ROUND, |k, _| if k.is_multiple_of(6) { -0.45 } else { 1.0 + 2.0 * noise(k).abs() });
        assert_eq!(water(&basin, 100.0, 1.0), None);
        let found = forced_water(&basin).expect("known water");
        assert!(found.plane.level_m < 1.2 && found.plane.slope == DVec2::ZERO, "{found:?}");
        assert!(found.support < SUPPORT, "{found:?}");
        // A step with nothing between: the level stays finite.
        let step = rim(ROUND, |k, _| if k.is_multiple_of(5) { 0.0 } else { 5.0 });
        let level = forced_water(&step).expect("known water").plane.level_m;
        assert!((-0.1..5.1).contains(&level), "{level}");
        let lake = rim(ROUND, |k, _| 3.0 + 0.05 * noise(k));
        assert_eq!(forced_water(&lake), water(&lake, 100.0, 1.0));
        assert_eq!(forced_water(&[]), None);
    }
}
