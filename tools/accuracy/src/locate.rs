//! Vertical lines against triangles.

use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Triangles by the squares of the plan that they touch: one grid for each power of two of their size, so that graded
/// patches cost no more than even ones.
#[derive(Clone, Debug, Default)]
pub struct Locator {
    triangles: Vec<[DVec3; 3]>,
    /// Sides of the grids' squares, as powers of two.
    levels: Vec<i32>,
    /// Looked up only, never walked.
    squares: HashMap<(i32, i64, i64), Vec<u32>>,
}

/// A point this little outside of a triangle (in barycentric coordinates) still lies in it.
const SLACK: f64 = 1e-9;

impl Locator {
    /// Sorts triangles in.
    #[must_use]
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let mut locator = Self { triangles, ..Self::default() };
        for (number, corners) in (0u32..).zip(&locator.triangles) {
            let low = corners[0].min(corners[1]).min(corners[2]).truncate();
            let high = corners[0].max(corners[1]).max(corners[2]).truncate();
            let level = (high - low).max_element().max(1e-6).log2().ceil() as i32;
            let side = f64::from(level).exp2();
            let (first, last) = ((low / side).floor(), (high / side).floor());
            for i in first.x as i64..=last.x as i64 {
                for j in first.y as i64..=last.y as i64 {
                    locator.squares.entry((level, i, j)).or_default().push(number);
                }
            }
            locator.levels.push(level);
        }
        locator.levels.sort_unstable();
        locator.levels.dedup();
        locator
    }

    /// Heights of all surfaces on the vertical through a place, metres; in no order that means anything.
    #[must_use]
    pub fn heights(&self, place: DVec2) -> Vec<f64> {
        let mut heights = Vec::new();
        for &level in &self.levels {
            let square = (place / f64::from(level).exp2()).floor();
            let key = (level, square.x as i64, square.y as i64);
            let here = self.squares.get(&key).map_or(&[][..], Vec::as_slice);
            heights.extend(here.iter().filter_map(|&t| height_on(&self.triangles[t as usize], place)));
        }
        heights
    }

    /// Height of the surface nearest to a point on its vertical, minus the point's own; `None` where there is none.
    #[must_use]
    pub fn nearest_error(&self, point: DVec3) -> Option<f64> {
        let errors = self.heights(point.truncate()).into_iter().map(|z| z - point.z);
        errors.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

/// Height of a triangle over a place in it.
fn height_on(corners: &[DVec3; 3], place: DVec2) -> Option<f64> {
    let [a, b, c] = corners.map(|p| p.truncate() - place);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let whole: f64 = weights.iter().sum();
    let shares = weights.map(|w| w / whole);
    let is_inside = whole != 0.0 && shares.iter().all(|s| *s > -SLACK);
    is_inside.then(|| shares.iter().zip(corners).map(|(s, p)| s * p.z).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_two_storeys_counts() {
        let floor =
            |z: f64, size: f64| [[0.0, 0.0], [size, 0.0], [0.0, size]].map(|[x, y]| DVec3::new(x, y, z));
        let locator = Locator::new(vec![floor(0.0, 8.0), floor(5.0, 100.0)]);
        for (point, expected) in [
            ([1.0, 1.0, 1.0], Some(-1.0)),
            ([1.0, 1.0, 3.0], Some(2.0)),
            ([20.0, 20.0, 1.0], Some(4.0)),
            ([0.0, 0.0, 0.0], Some(0.0)),
            ([90.0, 90.0, 0.0], None),
        ] {
            assert_eq!(locator.nearest_error(DVec3::from(point)), expected, "{point:?}");
        }
    }
}
