//! Triangles by their place in plan: which of them lie over a point.

use glam::{DVec2, DVec3};
use lacuna_mesh::side_of_line;

/// Most squares of the index for each triangle.
const SQUARES_A_TRIANGLE: usize = 2;

/// Triangles sorted into the squares of a plan grid that their boxes touch.
pub(super) struct PlanIndex {
    triangles: Vec<[DVec3; 3]>,
    low: DVec2,
    square_m: f64,
    columns: usize,
    rows: usize,
    /// Triangles of square k: `members[starts[k]..starts[k + 1]]`.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl PlanIndex {
    /// Indexes triangles of finite corners.
    pub(super) fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let corners = || triangles.iter().flatten().map(|p| p.truncate());
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let high = corners().fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = (high - low).max(DVec2::splat(1e-9));
        let squares = (triangles.len() * SQUARES_A_TRIANGLE).max(1) as f64;
        let square_m = (size.x * size.y / squares).sqrt().max(size.max_element() / 4096.0);
        let (columns, rows) = ((size.x / square_m) as usize + 1, (size.y / square_m) as usize + 1);
        let mut index =
            Self { triangles, low, square_m, columns, rows, starts: Vec::new(), members: Vec::new() };
        if !index.triangles.is_empty() {
            index.sort_in();
        }
        index
    }

    fn sort_in(&mut self) {
        let mut counts = vec![0u32; self.columns * self.rows + 1];
        for t in 0..self.triangles.len() {
            self.squares_of(t).for_each(|square| counts[square + 1] += 1);
        }
        for k in 1..counts.len() {
            counts[k] += counts[k - 1];
        }
        let mut next = counts.clone();
        self.members = vec![0; counts.last().copied().unwrap_or(0) as usize];
        for t in 0..self.triangles.len() {
            for square in self.squares_of(t).collect::<Vec<_>>() {
                self.members[next[square] as usize] = t as u32;
                next[square] += 1;
            }
        }
        self.starts = counts;
    }

    fn squares_of(&self, triangle: usize) -> impl Iterator<Item = usize> + use<> {
        let [a, b, c] = self.triangles[triangle].map(|p| p.truncate());
        let (first, last) = (self.square_at(a.min(b).min(c)), self.square_at(a.max(b).max(c)));
        let columns = self.columns;
        (first.1..=last.1).flat_map(move |row| (first.0..=last.0).map(move |column| row * columns + column))
    }

    fn square_at(&self, point: DVec2) -> (usize, usize) {
        let place = ((point - self.low) / self.square_m).max(DVec2::ZERO);
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows - 1))
    }

    /// Number of each triangle that holds the point in plan, its outline included, and the height there. Triangles that
    /// are upright hold nothing.
    pub(super) fn over(&self, point: DVec2) -> impl Iterator<Item = (usize, f64)> + '_ {
        let is_outside = self.triangles.is_empty()
            || point.cmplt(self.low).any()
            || point
                .cmpgt(self.low + DVec2::new(self.columns as f64, self.rows as f64) * self.square_m)
                .any();
        let members = if is_outside {
            &[][..]
        } else {
            let (column, row) = self.square_at(point);
            let square = row * self.columns + column;
            &self.members[self.starts[square] as usize..self.starts[square + 1] as usize]
        };
        members
            .iter()
            .filter_map(move |&t| Some((t as usize, height_at(&self.triangles[t as usize], point)?)))
    }
}

/// Height of a triangle over a point that it holds in plan.
fn height_at(triangle: &[DVec3; 3], point: DVec2) -> Option<f64> {
    let [a, b, c] = triangle.map(|p| p.truncate());
    let sides = [side_of_line(b, c, point), side_of_line(c, a, point), side_of_line(a, b, point)];
    let total: f64 = sides.iter().sum();
    let holds = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
    if !holds || total == 0.0 {
        return None;
    }
    Some((sides[0] * triangle[0].z + sides[1] * triangle[1].z + sides[2] * triangle[2].z) / total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_lies_over_a_point() {
        let place = |i: u32, j: u32| DVec3::new(f64::from(i), f64::from(j), f64::from(i) * 0.5);
        let square = |i, j| {
            [
                [place(i, j), place(i + 1, j), place(i + 1, j + 1)],
                [place(i, j), place(i + 1, j + 1), place(i, j + 1)],
            ]
        };
        let all: Vec<_> = (0..20).flat_map(|i| (0..9).flat_map(move |j| square(i, j))).collect();
        let index = PlanIndex::new(all);
        for (point, expected) in
            [((0.25, 0.1), Some(0.125)), ((19.9, 8.95), Some(9.95)), ((20.5, 3.0), None), ((-0.1, 3.0), None)]
        {
            let found: Vec<f64> = index.over(DVec2::from(point)).map(|(_, z)| z).collect();
            assert_eq!(found.len(), usize::from(expected.is_some()), "{point:?}");
            assert!(found.iter().zip(expected).all(|(z, e)| (z - e).abs() < 1e-12), "{point:?}: {found:?}");
        }
        assert_eq!(index.over(DVec2::new(4.0, 4.0)).count(), 6, "all triangles round a vertex");
        assert_eq!(PlanIndex::new(Vec::new()).over(DVec2::ZERO).count(), 0);
    }
}
