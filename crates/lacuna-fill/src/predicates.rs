//! Exact signs in the plane, and a few constructions.

use glam::DVec2;
use robust::Coord;

fn coord(p: DVec2) -> Coord<f64> {
    Coord { x: p.x, y: p.y }
}

/// Positive if d lies inside the circle through the counter-clockwise a, b, c: the sign is exact.
pub(crate) fn in_circle(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> f64 {
    robust::incircle(coord(a), coord(b), coord(c), coord(d))
}

/// Centre of the circle through three points that are not collinear.
pub(crate) fn circumcentre(a: DVec2, b: DVec2, c: DVec2) -> DVec2 {
    let (u, v) = (b - a, c - a);
    let double = 2.0 * u.perp_dot(v);
    let (uu, vv) = (u.length_squared(), v.length_squared());
    a + DVec2::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu) / double
}

/// q = 2 r / R of a triangle with the given side lengths: 1 if equilateral, 0 if flat (Field 2000).
pub(crate) fn shape(a: f64, b: f64, c: f64) -> f64 {
    let product = a * b * c;
    if product > 0.0 { ((b + c - a) * (c + a - b) * (a + b - c) / product).max(0.0) } else { 0.0 }
}

/// Distance from `p` to the segment from `a` to `b`.
pub(crate) fn distance_to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let t =
        if d.length_squared() > 0.0 { ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + d * t)
}
