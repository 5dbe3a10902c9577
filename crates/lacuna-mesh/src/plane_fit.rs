//! The plane through points, over x and y.

use glam::{DVec2, DVec3};

/// A plane `z = level + slope . (p - centre)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneFit {
    /// Where the plane has its level, metres.
    pub centre: DVec2,
    /// Height at the centre, metres.
    pub level_m: f64,
    /// Rise per metre along x and y.
    pub slope: DVec2,
}

impl PlaneFit {
    /// Least squares over points; level only if their places lie on a line, zero without points.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        Self::weighted(points.into_iter().map(|p| (p, 1.0)))
    }

    /// Least squares over points with weights that are not negative.
    #[must_use]
    pub fn weighted(points: impl IntoIterator<Item = (DVec3, f64)>) -> Self {
        let points: Vec<(DVec3, f64)> = points.into_iter().collect();
        let total: f64 = points.iter().map(|p| p.1).sum();
        if total <= 0.0 {
            return Self::default();
        }
        let mean = points.iter().map(|&(p, w)| p * w).sum::<DVec3>() / total;
        let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (d, w) in points.iter().map(|&(p, w)| (p - mean, w)) {
            xx += w * d.x * d.x;
            xy += w * d.x * d.y;
            yy += w * d.y * d.y;
            xz += w * d.x * d.z;
            yz += w * d.y * d.z;
        }
        let determinant = xx * yy - xy * xy;
        let slope = if determinant > 1e-9 * (xx + yy) * (xx + yy) {
            DVec2::new(yy * xz - xy * yz, xx * yz - xy * xz) / determinant
        } else {
            DVec2::ZERO
        };
        Self { centre: mean.truncate(), level_m: mean.z, slope }
    }

    /// Height of the plane at a place, metres.
    #[must_use]
    pub fn at(&self, p: DVec2) -> f64 {
        self.level_m + self.slope.dot(p - self.centre)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_again_and_weights_count() {
        let plane = |x: f64, y: f64| DVec3::new(x, y, 3.0 + 0.25 * x - 0.5 * y);
        let points = [plane(5e5, 1.0), plane(5e5 + 3.0, 2.0), plane(5e5 + 1.0, 7.0), plane(5e5 + 4.0, 4.0)];
        let fit = PlaneFit::of(points);
        assert!((fit.at(DVec2::new(5e5 + 10.0, 10.0)) - plane(5e5 + 10.0, 10.0).z).abs() < 1e-6);
        let outlier = (DVec3::new(5e5, 0.0, 1e3), 0.0);
        assert_eq!(
            PlaneFit::weighted(points.into_iter().map(|p| (p, 2.0)).chain([outlier])).slope,
            fit.slope
        );
    }

    #[test]
    fn places_on_a_line_give_their_level() {
        let fit = PlaneFit::of([DVec3::new(0.0, 0.0, 1.0), DVec3::new(2.0, 2.0, 5.0)]);
        assert_eq!((fit.slope, fit.level_m), (DVec2::ZERO, 3.0));
        assert_eq!(PlaneFit::of([]), PlaneFit::default());
    }
}
