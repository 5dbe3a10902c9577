//! How well triangles are shaped.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A triangle with a quality above this is good (Field 2000; Sun et al. 2013).
const GOOD: f64 = 0.5;
/// Number of classes of the histogram.
const CLASSES: usize = 10;

/// Quality of many triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QualityStats {
    /// Number of triangles.
    pub triangles: usize,
    /// Mean quality; 0 without triangles.
    pub mean: f64,
    /// Smallest quality; 0 without triangles.
    pub min: f64,
    /// Share of triangles with a quality above 0.5, 0..=1; 0 without triangles.
    pub share_good: f64,
    /// Number of triangles in each tenth: `[0, 0.1)`, `[0.1, 0.2)`, ... `[0.9, 1]`.
    pub histogram: [usize; CLASSES],
    /// Smallest angle of all triangles, degrees; 0 without triangles.
    pub min_angle_deg: f64,
}

/// Quality `2 r / R` of a triangle in space, r the radius of the inscribed and R that of the circumscribed circle:
/// 1 for an equilateral one, 0 for one without area or with a corner that is not finite.
///
/// From the side lengths: `(b + c - a)(c + a - b)(a + b - c) / (a b c)`. Source: Field 2000; Sun et al. 2013.
#[must_use]
pub fn triangle_quality(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (to_b, to_c) = (b - a, c - a);
    let doubled_area = to_b.cross(to_c).length();
    let (ab, ac, bc) = (to_b.length(), to_c.length(), b.distance(c));
    // 2 r / R = 16 A^2 / (a b c (a + b + c)): without the differences of lengths that cancel in thin triangles.
    let quality = 4.0 * doubled_area * doubled_area / (ab * ac * bc * (ab + ac + bc));
    if quality.is_finite() { quality.min(1.0) } else { 0.0 }
}

/// The smallest angle of a triangle in space, degrees; 0 if two corners are at the same place.
#[must_use]
pub fn smallest_angle_deg(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let angle = |at: DVec3, p: DVec3, q: DVec3| {
        let (p, q) = (p - at, q - at);
        libm::atan2(p.cross(q).length(), p.dot(q)).to_degrees()
    };
    if a == b || b == c || c == a {
        return 0.0;
    }
    angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
}

impl QualityStats {
    /// Statistics over triangles (three corners each, metres), summed in the iterator's order.
    #[must_use]
    pub fn of(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Self {
        let (mut count, mut good, mut sum) = (0, 0, 0.0);
        let (mut min, mut min_angle_deg) = (f64::INFINITY, f64::INFINITY);
        let mut histogram = [0; CLASSES];
        for [a, b, c] in triangles {
            let quality = triangle_quality(a, b, c);
            count += 1;
            sum += quality;
            good += usize::from(quality > GOOD);
            min = min.min(quality);
            min_angle_deg = min_angle_deg.min(smallest_angle_deg(a, b, c));
            histogram[((quality * CLASSES as f64) as usize).min(CLASSES - 1)] += 1;
        }
        if count == 0 {
            (min, min_angle_deg) = (0.0, 0.0);
        }
        let per_triangle = 1.0 / f64::max(count as f64, 1.0);
        let (mean, share_good) = (sum * per_triangle, good as f64 * per_triangle);
        Self { triangles: count, mean, min, share_good, histogram, min_angle_deg }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EQUILATERAL: [DVec3; 3] =
        [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 1.732_050_807_568_877_2, 0.0)];
    const RIGHT: [DVec3; 3] = [DVec3::ZERO, DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
    const FLAT: [DVec3; 3] = [DVec3::ZERO, DVec3::new(1.0, 0.0, 0.0), DVec3::new(3.0, 0.0, 0.0)];
    const BAD: [DVec3; 3] = [DVec3::ZERO, DVec3::NAN, DVec3::ONE];

    #[test]
    fn known_triangles_have_known_quality() {
        // Right angle: r = 1 - sqrt(1/2), R = sqrt(1/2).
        let right = 2.0 * (1.0 - 0.5f64.sqrt()) / 0.5f64.sqrt();
        for (name, [a, b, c], quality, angle_deg) in
            [("equilateral", EQUILATERAL, 1.0, 60.0), ("right", RIGHT, right, 45.0), ("flat", FLAT, 0.0, 0.0)]
        {
            assert!((triangle_quality(a, b, c) - quality).abs() < 1e-12, "{name}");
            assert!((smallest_angle_deg(a, b, c) - angle_deg).abs() < 1e-9, "{name}");
        }
        assert_eq!(triangle_quality(BAD[0], BAD[1], BAD[2]), 0.0);
        assert_eq!(triangle_quality(DVec3::ONE, DVec3::ONE, DVec3::ONE), 0.0);
    }

    #[test]
    fn quality_does_not_change_when_a_triangle_is_moved_scaled_or_turned() {
        let [a, b, c] = [DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.5, 0.25, 0.0), DVec3::new(0.5, 2.0, 3.0)];
        let expected = triangle_quality(a, b, c);
        let shift = DVec3::new(5e5, 5e5, 128.0);
        assert_eq!(triangle_quality(a + shift, b + shift, c + shift), expected);
        assert_eq!(triangle_quality(a * 4.0, b * 4.0, c * 4.0), expected);
        assert!((triangle_quality(b, c, a) - expected).abs() < 1e-15);
        assert!((triangle_quality(c, b, a) - expected).abs() < 1e-15);
    }

    #[test]
    fn needles_keep_their_digits() {
        // Height h over a base of 1: r = h / 2, R = 1 / (8 h), so the quality is 8 h^2.
        let h = 1e-6;
        let quality = triangle_quality(DVec3::ZERO, DVec3::X, DVec3::new(0.5, h, 0.0));
        assert!((quality / (8.0 * h * h) - 1.0).abs() < 1e-9, "{quality}");
    }

    #[test]
    fn statistics_count_every_triangle() {
        let stats = QualityStats::of([EQUILATERAL, RIGHT, FLAT]);
        assert_eq!((stats.triangles, stats.histogram.iter().sum::<usize>()), (3, 3));
        assert_eq!((stats.histogram[0], stats.histogram[8], stats.histogram[9]), (1, 1, 1));
        assert!((stats.share_good - 2.0 / 3.0).abs() < 1e-15);
        assert_eq!((stats.min, stats.min_angle_deg), (0.0, 0.0));
        let none = QualityStats::of([]);
        assert_eq!((none.triangles, none.mean, none.share_good, none.min), (0, 0.0, 0.0, 0.0));
    }
}
