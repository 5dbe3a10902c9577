//! Water that falls from one height to another along a hole.

use crate::water::{RimPoint, envelope_loss, principal_axis};
use glam::DVec2;
use lacuna_mesh::PlaneFit;

/// The plane that stands at `from_m` at one end of the rim and at `to_m` at the other, metres; the ends are those of the
/// rim's longer principal axis.
///
/// Of the two ways it can lie the one is taken that fits the lower envelope of the rim better (least quantile loss at
/// 20 %): the higher height comes to the end with the higher banks. Where the rim does not tell, `from_m` is in the west,
/// or in the south if the axis runs north.
#[must_use]
pub fn sloped_water(rim: &[RimPoint], from_m: f64, to_m: f64) -> PlaneFit {
    let axis = principal_axis(rim).map_or(DVec2::X, |axis| axis.direction);
    let axis = if axis.x < -EVEN || (axis.x.abs() <= EVEN && axis.y < 0.0) { -axis } else { axis };
    let along = rim.iter().map(|p| axis.dot(p.position.truncate()));
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s), h.max(s)));
    let length_m = high - low;
    if length_m.is_nan() || length_m <= 0.0 {
        return PlaneFit { level_m: from_m.midpoint(to_m), ..PlaneFit::default() };
    }
    let centre = axis * low.midpoint(high);
    let plane =
        |rise_m: f64| PlaneFit { centre, level_m: from_m.midpoint(to_m), slope: axis * (rise_m / length_m) };
    let (forth, back) = (plane(to_m - from_m), plane(from_m - to_m));
    let is_clear = envelope_loss(rim, &back) < (1.0 - CLEAR) * envelope_loss(rim, &forth);
    if is_clear { back } else { forth }
}

/// An axis whose part to the east is smaller runs north.
const EVEN: f64 = 1e-9;
/// The rim tells the direction if one way fits it better by this share.
const CLEAR: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    /// A river of 2 m wide rim points along `axis`, 400 m long, whose banks have the height `z` at a distance along it.
    fn river(axis: DVec2, z: impl Fn(f64) -> f64) -> Vec<RimPoint> {
        let point = |k: usize| {
            let (s, side) = ((k / 2) as f64 - 200.0, if k.is_multiple_of(2) { 10.0 } else { -10.0 });
            let place = axis * s + axis.perp() * side + DVec2::new(5e5, 4e5);
            RimPoint { position: place.extend(z(s)), length_m: 1.0 }
        };
        (0..802).map(point).collect()
    }

    #[test]
    fn the_higher_height_comes_to_the_higher_end() {
        for angle in [0.0, 0.7, 1.6, 2.9, 4.1] {
            let axis = DVec2::new(libm::cos(angle), libm::sin(angle));
            for fall in [-0.004, 0.004] {
                // Walls stand on every fifth place: the envelope does not see them.
                let rim = river(axis, |s| 20.0 - fall * s + if s as i64 % 5 == 0 { 4.0 } else { 0.0 });
                let plane = sloped_water(&rim, 20.8, 19.2);
                let at = |s: f64| plane.at(axis * s + DVec2::new(5e5, 4e5));
                assert!((at(-200.0) - (20.0 + 200.0 * fall)).abs() < 0.02, "{angle}, {fall}: {}", at(-200.0));
                assert!((at(200.0) - (20.0 - 200.0 * fall)).abs() < 0.02, "{angle}, {fall}: {}", at(200.0));
            }
        }
    }

    #[test]
    fn without_a_hint_it_falls_eastward_or_northward() {
        for (axis, end) in [
            (DVec2::X, DVec2::X),
            (-DVec2::X, DVec2::X),
            (DVec2::Y, DVec2::Y),
            (-DVec2::Y, DVec2::Y),
            (DVec2::new(0.6, -0.8), DVec2::new(0.6, -0.8)),
        ] {
            let plane = sloped_water(&river(axis, |_| 7.0), 1.0, 0.0);
            assert!(plane.slope.dot(end) < 0.0, "{axis}: {}", plane.slope);
        }
        assert_eq!(sloped_water(&[], 1.0, 0.0).level_m, 0.5);
    }
}
