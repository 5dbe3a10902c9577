//! Which points lie near a border vertex in plan.

use crate::smooth::SeamVertex;
use glam::{DVec2, DVec3};
use std::cmp::Ordering;
use std::ops::Range;

/// A point whose height counts for a border vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Neighbour {
    /// Index of another border vertex.
    Border(usize),
    /// Index of a strip point.
    Strip(usize),
}

impl Neighbour {
    /// Its height now, metres.
    pub(crate) fn height(self, border: &[SeamVertex], strips: &[DVec3]) -> f64 {
        match self {
            Self::Border(index) => border[index].z,
            Self::Strip(index) => strips[index].z,
        }
    }
}

/// The neighbours of every border vertex that may move, as one column with a range for each vertex.
pub(crate) struct Neighbours {
    ranges: Vec<Range<usize>>,
    column: Vec<Neighbour>,
}

/// A square of the plan.
type Bucket = (i64, i64);

/// A point in its bucket; the order of two points depends on where they are, not on how they were listed.
struct Entry {
    bucket: Bucket,
    position: DVec3,
    rank: u8,
    neighbour: Neighbour,
}

impl Neighbours {
    /// Finds all points not farther than `buffer_m` in plan from each vertex of the border that is not frozen.
    ///
    /// 1. Points are sorted by squares a little larger than the buffer, inside a square by position.
    /// 2. For each vertex the nine squares around it are searched, and what is near is sorted by position.
    pub(crate) fn find(border: &[SeamVertex], strips: &[DVec3], buffer_m: f64) -> Self {
        let grid = Grid::new(border, strips, buffer_m);
        let mut found = Self { ranges: Vec::with_capacity(border.len()), column: Vec::new() };
        for (index, vertex) in border.iter().enumerate() {
            let start = found.column.len();
            if !vertex.frozen && buffer_m > 0.0 {
                found.column.extend(grid.near(index, vertex.plan, buffer_m));
            }
            found.ranges.push(start..found.column.len());
        }
        found
    }

    /// The neighbours of border vertex `index`; none if it is frozen.
    pub(crate) fn of(&self, index: usize) -> &[Neighbour] {
        &self.column[self.ranges[index].clone()]
    }
}

struct Grid {
    entries: Vec<Entry>,
    bucket_m: f64,
}

impl Grid {
    fn new(border: &[SeamVertex], strips: &[DVec3], buffer_m: f64) -> Self {
        // The surplus outweighs the rounding of the division: a point within the buffer is never two squares away.
        let bucket_m = buffer_m * 1.001;
        let entry = |position: DVec3, rank: u8, neighbour: Neighbour| Entry {
            bucket: bucket(position.truncate(), bucket_m),
            position,
            rank,
            neighbour,
        };
        let points = strips.iter().enumerate().map(|(i, &point)| entry(point, 0, Neighbour::Strip(i)));
        let vertices = border.iter().enumerate().map(|(i, vertex)| {
            let rank = if vertex.frozen { 1 } else { 2 };
            entry(vertex.plan.extend(vertex.z), rank, Neighbour::Border(i))
        });
        let mut entries: Vec<Entry> = points.chain(vertices).collect();
        entries.sort_by(|a, b| a.bucket.cmp(&b.bucket).then_with(|| by_position(a, b)));
        Self { entries, bucket_m }
    }

    /// Points near `plan`, sorted by position, without border vertex `index` itself.
    fn near(&self, index: usize, plan: DVec2, buffer_m: f64) -> impl Iterator<Item = Neighbour> {
        let (column, row) = bucket(plan, self.bucket_m);
        let mut near: Vec<&Entry> = (-1..=1)
            .filter_map(|step| column.checked_add(step))
            .flat_map(|column| self.three_rows(column, row))
            .filter(|entry| entry.position.truncate().distance_squared(plan) <= buffer_m * buffer_m)
            .filter(|entry| !matches!(entry.neighbour, Neighbour::Border(other) if other == index))
            .collect();
        // Over all squares, so that a shift of the squares against the points changes no sum.
        near.sort_by(|a, b| by_position(a, b));
        near.into_iter().map(|entry| entry.neighbour)
    }

    /// Entries of three squares of a column; they lie side by side in the sorted entries.
    fn three_rows(&self, column: i64, row: i64) -> &[Entry] {
        let first = (column, row.saturating_sub(1));
        let last = (column, row.saturating_add(1));
        let start = self.entries.partition_point(|entry| entry.bucket < first);
        let count = self.entries[start..].partition_point(|entry| entry.bucket <= last);
        &self.entries[start..start + count]
    }
}

fn bucket(plan: DVec2, bucket_m: f64) -> Bucket {
    // A cast of a float saturates: far points share a square, which costs time and changes nothing.
    ((plan.x / bucket_m).floor() as i64, (plan.y / bucket_m).floor() as i64)
}

/// By position bits, fixed heights before moving ones: points that are still equal have equal heights in every round, so
/// their order does not show.
fn by_position(a: &Entry, b: &Entry) -> Ordering {
    let (p, q) = (a.position, b.position);
    p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)).then(a.rank.cmp(&b.rank))
}

#[cfg(test)]
mod tests {
    use super::{Neighbour, Neighbours};
    use crate::smooth::SeamVertex;
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    /// The same by looking at every point: (strip?, index), sorted.
    fn by_search(border: &[SeamVertex], strips: &[DVec3], index: usize, buffer_m: f64) -> Vec<(bool, usize)> {
        let near = |plan: DVec2| plan.distance_squared(border[index].plan) <= buffer_m * buffer_m;
        let others = (0..border.len()).filter(|&other| other != index && near(border[other].plan));
        let points = (0..strips.len()).filter(|&point| near(strips[point].truncate()));
        others.map(|other| (false, other)).chain(points.map(|point| (true, point))).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn the_grid_finds_what_a_full_search_finds(
            // Places in eighths of a metre, so that many lie exactly at the buffer's end.
            border in prop::collection::vec((-40_i32..40, -8_i32..8, any::<bool>()), 1..30),
            strips in prop::collection::vec((-40_i32..40, -8_i32..8), 0..60),
            eighths in 1_i32..30,
            shift in prop::sample::select(vec![0.0, 5e5, -5e5, 8e7]),
        ) {
            let plan = |x: i32, y: i32| DVec2::new(shift + f64::from(x) / 8.0, f64::from(y) / 8.0 - shift);
            let border: Vec<SeamVertex> = border
                .iter()
                .map(|&(x, y, frozen)| SeamVertex { plan: plan(x, y), z: 1.0, frozen })
                .collect();
            let strips: Vec<DVec3> = strips.iter().map(|&(x, y)| plan(x, y).extend(2.0)).collect();
            let buffer_m = f64::from(eighths) / 8.0;
            let neighbours = Neighbours::find(&border, &strips, buffer_m);
            for (index, vertex) in border.iter().enumerate() {
                let mut found: Vec<(bool, usize)> = neighbours
                    .of(index)
                    .iter()
                    .map(|neighbour| match *neighbour {
                        Neighbour::Border(other) => (false, other),
                        Neighbour::Strip(point) => (true, point),
                    })
                    .collect();
                found.sort_unstable();
                let expected =
                    if vertex.frozen { Vec::new() } else { by_search(&border, &strips, index, buffer_m) };
                prop_assert_eq!(found, expected);
            }
        }
    }
}
