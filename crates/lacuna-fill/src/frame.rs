//! The frame in which a contour is triangulated: seen from above, or square to its best-fit plane.

use glam::{DVec2, DVec3};

/// An orthonormal frame: two coordinates in the plane and a height along its normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: DVec3,
    axes: Option<[DVec3; 3]>,
}

/// Differences below this are taken as 0: the triangulation refuses tiny numbers, and nobody measures them.
const TINY_M: f64 = 1e-40;

impl Frame {
    /// Seen from above: x, y, z less an origin of whole metres in the middle, so that the subtraction is exact for
    /// all but absurd coordinates.
    pub(crate) fn plan(points: &[DVec3]) -> Self {
        let low = points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
        Self { origin: ((low + high) * 0.5).floor(), axes: None }
    }

    /// In a plane through `origin` with the unit vector `normal`.
    pub(crate) fn plane(origin: DVec3, normal: DVec3) -> Self {
        let across = if normal.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
        let u = across.cross(normal).normalize();
        Self { origin, axes: Some([u, normal.cross(u), normal]) }
    }

    /// Coordinates in the frame: two in its plane, then the height.
    pub(crate) fn local(&self, world: DVec3) -> DVec3 {
        let d = world - self.origin;
        let p = self.axes.map_or(d, |[u, v, n]| DVec3::new(d.dot(u), d.dot(v), d.dot(n)));
        DVec3::new(clean(p.x), clean(p.y), p.z)
    }

    /// The reverse of [`Frame::local`].
    pub(crate) fn world(&self, local: DVec3) -> DVec3 {
        self.axes.map_or(local, |[u, v, n]| u * local.x + v * local.y + n * local.z) + self.origin
    }

    /// The nearest place that survives the way out and back: seen from above, predicates then say the same of the
    /// written coordinates as of the local ones.
    pub(crate) fn snap(&self, p: DVec2) -> DVec2 {
        if self.axes.is_some() {
            return p;
        }
        let origin = self.origin.truncate();
        let q = (p + origin) - origin;
        DVec2::new(clean(q.x), clean(q.y))
    }
}

fn clean(x: f64) -> f64 {
    if x.abs() < TINY_M { 0.0 } else { x }
}
