//! Cotangent stiffness and lumped area of a triangulation.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// What is done with very small and very large cotangents.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Clamp {
    /// Nothing: for Delaunay triangles in plan, where edge weights are not negative away from kept edges.
    Off,
    /// Each cotangent is brought into `min..=max`.
    Range {
        /// Smallest cotangent.
        min: f64,
        /// Largest cotangent.
        max: f64,
    },
}

impl Clamp {
    /// The range for triangles in space.
    pub const IN_SPACE: Self = Self::Range { min: 0.01, max: 20.0 };

    fn apply(self, cotangent: f64) -> f64 {
        match self {
            Self::Off => cotangent,
            Self::Range { min, max } => cotangent.max(min).min(max),
        }
    }
}

/// Stiffness K and lumped area M: for heights z, `z' K z` is the Dirichlet energy and `M^-1 K z` minus the Laplacian.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// `(row, column, value)` with row >= column, sorted by (row, column), each once. Off the diagonal the value is
    /// `-w`, `w = (cot a + cot b) / 2` over the angles opposite to the edge; on it the sum of the row's `w`. A vertex
    /// without triangles has no entry.
    pub entries: Vec<(u32, u32, f64)>,
    /// A third of the areas of each vertex's triangles, square metres.
    pub mass: Vec<f64>,
    /// Triangles left out because they have no area (or a corner that is not finite).
    pub left_out: usize,
}

impl Stiffness {
    /// The edges with their weights `w`: `(larger vertex, smaller vertex, w)`, sorted.
    pub fn edge_weights(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        self.entries.iter().filter(|e| e.0 != e.1).map(|&(row, column, value)| (row, column, -value))
    }
}

/// Stiffness of triangles in plan. Corners are indices into `points` (metres), which must be in range; the direction
/// of triangles doesn't matter. Sums run in the order of triangles.
///
/// Source: Pinkall and Polthier 1993; algorithm note, sections D.3 and E.7.
#[must_use]
pub fn stiffness(points: &[DVec2], triangles: &[[u32; 3]], clamp: Clamp) -> Stiffness {
    assemble(points.len(), triangles, clamp, |v| points[v as usize].extend(0.0))
}

/// Stiffness of triangles in space; as [`stiffness`]. The usual clamp is [`Clamp::IN_SPACE`].
#[must_use]
pub fn stiffness_in_space(points: &[DVec3], triangles: &[[u32; 3]], clamp: Clamp) -> Stiffness {
    assemble(points.len(), triangles, clamp, |v| points[v as usize])
}

fn assemble(
    count: usize,
    triangles: &[[u32; 3]],
    clamp: Clamp,
    position: impl Fn(u32) -> DVec3,
) -> Stiffness {
    let mut parts = Vec::with_capacity(3 * triangles.len());
    let mut diagonal = vec![None; count];
    let mut mass = vec![0.0; count];
    let mut left_out = 0;
    for &triangle in triangles {
        match angles(triangle.map(&position)) {
            Some((area, cotangents)) => {
                triangle.iter().for_each(|&v| mass[v as usize] += area / 3.0);
                let half_cotangents = cotangents.map(|cot| clamp.apply(cot) / 2.0);
                push_parts(&mut parts, &mut diagonal, triangle, half_cotangents);
            }
            None => left_out += 1,
        }
    }
    Stiffness { entries: summed(&parts, &diagonal), mass, left_out }
}

/// Area and the cotangents at the three corners; `None` without area.
fn angles(corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let [a, b, c] = corners;
    let doubled_area = (b - a).cross(c - a).length();
    let cotangents =
        [(b - a).dot(c - a), (c - b).dot(a - b), (a - c).dot(b - c)].map(|dot| dot / doubled_area);
    (doubled_area > 0.0 && cotangents.iter().all(|cot| cot.is_finite()))
        .then_some((doubled_area / 2.0, cotangents))
}

/// The triangle's part of K: corner i's half cotangent is a weight of the edge opposite to it.
fn push_parts(
    parts: &mut Vec<(u32, u32, f64)>,
    diagonal: &mut [Option<f64>],
    triangle: [u32; 3],
    half_cotangents: [f64; 3],
) {
    for corner in 0..3 {
        let (i, j) = (triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]);
        let weight = half_cotangents[corner];
        for v in [i, j] {
            let sum = &mut diagonal[v as usize];
            *sum = Some(sum.map_or(weight, |sum| sum + weight));
        }
        parts.push((i.max(j), i.min(j), -weight));
    }
}

/// Equal places added up in the order in which they came: counted into rows, then each row sorted by column (stable).
fn summed(parts: &[(u32, u32, f64)], diagonal: &[Option<f64>]) -> Vec<(u32, u32, f64)> {
    let mut ends = vec![0usize; diagonal.len() + 1];
    parts.iter().for_each(|&(row, ..)| ends[row as usize + 1] += 1);
    for row in 0..diagonal.len() {
        ends[row + 1] += ends[row];
    }
    let mut next = ends.clone();
    let mut rows = vec![(0u32, 0.0); parts.len()];
    for &(row, column, value) in parts {
        rows[next[row as usize]] = (column, value);
        next[row as usize] += 1;
    }
    let mut entries = Vec::with_capacity(parts.len() / 2 + diagonal.len());
    for (row, sum) in diagonal.iter().enumerate() {
        let Some(sum) = *sum else { continue };
        let columns = &mut rows[ends[row]..ends[row + 1]];
        columns.sort_by_key(|&(column, _)| column);
        for same in columns.chunk_by(|a, b| a.0 == b.0) {
            let value = same[1..].iter().fold(same[0].1, |sum, part| sum + part.1);
            entries.push((row as u32, same[0].0, value));
        }
        entries.push((row as u32, row as u32, sum));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two right triangles on a unit square.
    const SQUARE: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn value(k: &Stiffness, row: u32, column: u32) -> f64 {
        k.entries.iter().find(|e| (e.0, e.1) == (row, column)).map_or(0.0, |e| e.2)
    }

    /// `z' K z`.
    fn energy(k: &Stiffness, z: &[f64]) -> f64 {
        k.edge_weights().map(|(i, j, w)| w * (z[i as usize] - z[j as usize]).powi(2)).sum()
    }

    #[test]
    fn a_square_has_the_known_matrix() {
        let k = stiffness(&SQUARE, &HALVES, Clamp::Off);
        assert_eq!((value(&k, 1, 0), value(&k, 2, 1), value(&k, 2, 0)), (-0.5, -0.5, 0.0));
        assert_eq!((value(&k, 0, 0), value(&k, 1, 1)), (1.0, 1.0));
        assert_eq!(k.mass, [1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0, 1.0 / 6.0]);
        assert!(k.entries.is_sorted_by(|a, b| (a.0, a.1) < (b.0, b.1)));
    }

    #[test]
    fn energy_of_a_plane_is_slope_squared_times_area() {
        let points =
            [DVec2::new(0.0, 0.0), DVec2::new(3.0, 0.5), DVec2::new(2.0, 4.0), DVec2::new(-1.0, 2.0)];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let z: Vec<f64> = points.iter().map(|p| 2.0 * p.x - 3.0 * p.y + 7.0).collect();
        let k = stiffness(&points, &triangles, Clamp::Off);
        let area: f64 = k.mass.iter().sum();
        assert!((energy(&k, &z) - 13.0 * area).abs() < 1e-9);
    }

    #[test]
    fn plan_and_space_agree_and_nothing_depends_on_where_they_are() {
        let k = stiffness(&SQUARE, &HALVES, Clamp::Off);
        let turned: Vec<DVec3> = SQUARE.iter().map(|p| DVec3::new(5e5, p.y, p.x)).collect();
        assert_eq!(stiffness_in_space(&turned, &HALVES, Clamp::Off), k);
        let mirrored: Vec<DVec2> = SQUARE.iter().map(|p| DVec2::new(-p.x, p.y) + DVec2::splat(5e5)).collect();
        assert_eq!(stiffness(&mirrored, &HALVES, Clamp::Off), k);
    }

    #[test]
    fn clamped_weights_stay_in_range() {
        let needle = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-9, 0.0)];
        let k = stiffness_in_space(&needle, &[[0, 1, 2]], Clamp::IN_SPACE);
        let weights: Vec<f64> = k.edge_weights().map(|e| e.2).collect();
        assert_eq!(weights, [0.005, 10.0, 10.0]);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        let points = [DVec2::ZERO, DVec2::X, DVec2::X * 2.0, DVec2::NAN];
        let k = stiffness(&points, &[[0, 1, 2], [0, 1, 3], [0, 1, 1]], Clamp::Off);
        assert_eq!((k.left_out, k.entries.len()), (3, 0));
        assert_eq!(k.mass, [0.0; 4]);
    }
}
