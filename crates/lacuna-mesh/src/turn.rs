//! The order of directions round a point, in a plan that suits the surface there.

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};
use std::cmp::Ordering;

/// Surface whose normal's vertical share is below this is looked at from its own side, not from above.
const STEEP_SHARE: f64 = 0.15;

/// A plane to look at directions in: the horizontal one where the surface faces up, else the surface's own.
pub(crate) enum Plan {
    /// Seen from above; coordinates are copied, so that nothing is rounded.
    Above { origin: DVec3 },
    /// Seen against the surface's normal.
    Across { origin: DVec3, right: DVec3, up: DVec3 },
}

impl Plan {
    /// The plan for surface with this normal (any length) at `origin`.
    pub(crate) fn facing(origin: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize_or(DVec3::Z);
        if normal.z >= STEEP_SHARE {
            return Self::Above { origin };
        }
        let right = least_axis(normal).cross(normal).normalize_or(DVec3::X);
        Self::Across { origin, right, up: normal.cross(right) }
    }

    /// Where the plan's origin is in the plan.
    pub(crate) fn origin(&self) -> DVec2 {
        match self {
            Self::Above { origin } => origin.truncate(),
            Self::Across { .. } => DVec2::ZERO,
        }
    }

    /// Where a point is in the plan.
    pub(crate) fn of(&self, point: DVec3) -> DVec2 {
        match *self {
            Self::Above { .. } => point.truncate(),
            Self::Across { origin, right, up } => {
                DVec2::new((point - origin).dot(right), (point - origin).dot(up))
            }
        }
    }
}

/// The coordinate axis that is farthest from the direction.
fn least_axis(direction: DVec3) -> DVec3 {
    let size = direction.abs();
    if size.x <= size.y && size.x <= size.z {
        DVec3::X
    } else if size.y <= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// Which of the directions `origin -> a` and `origin -> b` comes first when one rotates clockwise round `origin`,
/// starting at the direction of `back` (itself first). Exact.
#[must_use]
pub fn clockwise_order(origin: DVec2, back: DVec2, a: DVec2, b: DVec2) -> Ordering {
    let (sector_a, sector_b) = (sector(origin, back, a), sector(origin, back, b));
    let within = side(origin, a, b).partial_cmp(&0.0).unwrap_or(Ordering::Equal);
    sector_a.cmp(&sector_b).then(within)
}

/// Quarter of the clockwise turn in which `p` lies: 0 along `back`, 1 before half a turn, 2 opposite, 3 after it.
fn sector(origin: DVec2, back: DVec2, p: DVec2) -> u8 {
    let turn = side(origin, back, p);
    if turn < 0.0 {
        1
    } else if turn > 0.0 {
        3
    } else if points_the_same_way(origin, back, p) {
        0
    } else {
        2
    }
}

/// For collinear points: true if `a` and `b` lie on the same side of `origin`.
fn points_the_same_way(origin: DVec2, a: DVec2, b: DVec2) -> bool {
    let same = |o: f64, a: f64, b: f64| (a > o && b > o) || (a < o && b < o);
    same(origin.x, a.x, b.x) || same(origin.y, a.y, b.y)
}

/// Positive if `c` lies to the left of the line `a -> b`.
fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight directions clockwise from west.
    const COMPASS: [DVec2; 8] = [
        DVec2::new(-1.0, 0.0),
        DVec2::new(-1.0, 1.0),
        DVec2::new(0.0, 1.0),
        DVec2::new(1.0, 1.0),
        DVec2::new(1.0, 0.0),
        DVec2::new(1.0, -1.0),
        DVec2::new(0.0, -1.0),
        DVec2::new(-1.0, -1.0),
    ];

    #[test]
    fn directions_are_ordered_clockwise_from_the_way_back() {
        for shift in [DVec2::ZERO, DVec2::new(5e5, -4e6)] {
            for start in 0..8 {
                let at = |i: usize| shift + COMPASS[(start + i) % 8];
                for i in 0..8 {
                    for j in 0..8 {
                        let order = clockwise_order(shift, at(0), at(i), at(j));
                        assert_eq!(order, i.cmp(&j), "start {start}, {i} against {j}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_plan_keeps_the_hand_of_the_side_it_is_seen_from() {
        for normal in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.3, -2.0, 0.1), DVec3::NEG_Y] {
            let origin = DVec3::new(3.0, 4.0, 5.0);
            let plan = Plan::facing(origin, normal);
            let a = least_axis(normal).cross(normal).normalize();
            let b = normal.cross(a);
            assert!(side(plan.origin(), plan.of(origin + a), plan.of(origin + b)) > 0.0, "{normal}");
        }
    }
}
