//! Minimum-area triangulation of one 3D ring by dynamic programming.

use glam::DVec3;

/// What a triangulation of a ring makes small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RingWeight {
    /// The sum of areas ("minimum area" of Wang et al. 2021).
    Area,
    /// The largest dihedral angle, then the sum of areas (Liepa 2003).
    #[default]
    AngleThenArea,
}

/// A ring to triangulate.
#[derive(Clone, Copy, Debug)]
pub struct Ring3d<'a> {
    /// Vertices in walking order, hole on the left.
    pub points: &'a [DVec3],
    /// For the edge from each vertex to the next one: the third corner of the existing triangle behind it.
    pub apexes: &'a [Option<DVec3>],
    /// Pairs of places (smaller first, sorted) that must not be joined.
    pub forbidden: &'a [[u32; 2]],
}

/// Triangulates a ring without new vertices: for every sub-polygon (i, k) the split m with the least weight, ties to
/// the smallest m. Angles are compared as 1 - cos against the triangles across, existing or chosen. O(n^3) time,
/// O(n^2) memory. Returns triangles of places, oriented as the ring; `None` if forbidden edges leave no triangulation.
///
/// Source: Liepa 2003, *Filling holes in meshes*, sec. 4; Barequet & Sharir 1995.
#[must_use]
pub fn triangulate_ring(ring: &Ring3d<'_>, weight: RingWeight) -> Option<Vec<[u32; 3]>> {
    let n = ring.points.len();
    if n < 3 {
        return None;
    }
    let mut table = Table { n, cost: vec![Cost::NOTHING; n * n], split: vec![0; n * n] };
    for span in 2..n {
        for i in 0..n - span {
            fill_entry(ring, weight, &mut table, i, i + span);
        }
    }
    table.cost[n - 1].is_finite().then(|| table.collect())
}

/// Largest 1 - cos of a dihedral angle, and area.
#[derive(Clone, Copy, PartialEq)]
struct Cost {
    bend: f64,
    area: f64,
}

impl Cost {
    const NOTHING: Self = Self { bend: 0.0, area: 0.0 };
    const INFINITE: Self = Self { bend: f64::INFINITY, area: f64::INFINITY };

    fn join(self, other: Self) -> Self {
        Self { bend: self.bend.max(other.bend), area: self.area + other.area }
    }

    fn is_finite(self) -> bool {
        self.area.is_finite()
    }

    fn is_less(self, other: Self) -> bool {
        self.bend < other.bend || (self.bend == other.bend && self.area < other.area)
    }
}

struct Table {
    n: usize,
    cost: Vec<Cost>,
    split: Vec<u32>,
}

impl Table {
    fn collect(&self) -> Vec<[u32; 3]> {
        let mut triangles = vec![];
        let mut stack = vec![(0usize, self.n - 1)];
        while let Some((i, k)) = stack.pop() {
            if k - i < 2 {
                continue;
            }
            let m = self.split[i * self.n + k] as usize;
            triangles.push([i as u32, m as u32, k as u32]);
            stack.extend([(m, k), (i, m)]);
        }
        triangles
    }
}

fn fill_entry(ring: &Ring3d<'_>, weight: RingWeight, table: &mut Table, i: usize, k: usize) {
    let n = table.n;
    let closes = i == 0 && k + 1 == n;
    let (mut best, mut split) = (Cost::INFINITE, i as u32 + 1);
    if closes || ring.forbidden.binary_search(&[i as u32, k as u32]).is_err() {
        for m in i + 1..k {
            let parts = table.cost[i * n + m].join(table.cost[m * n + k]);
            if !parts.is_finite() || !parts.is_less(best) {
                continue;
            }
            let cost = parts.join(triangle_cost(ring, weight, table, [i, m, k]));
            if cost.is_less(best) {
                (best, split) = (cost, m as u32);
            }
        }
    }
    table.cost[i * n + k] = best;
    table.split[i * n + k] = split;
}

fn triangle_cost(ring: &Ring3d<'_>, weight: RingWeight, table: &Table, [i, m, k]: [usize; 3]) -> Cost {
    let p = |v: usize| ring.points[v];
    let normal = (p(m) - p(i)).cross(p(k) - p(i));
    let area = 0.5 * normal.length();
    if weight == RingWeight::Area {
        return Cost { bend: 0.0, area };
    }
    let mut bend = bend_across(ring, table, normal, i, m).max(bend_across(ring, table, normal, m, k));
    if i == 0 && k + 1 == table.n {
        bend = bend.max(bend_at_rim(ring, normal, k, i));
    }
    Cost { bend, area }
}

/// 1 - cos of the angle between a triangle with this normal and the one across the edge from `a` to `b`.
fn bend_across(ring: &Ring3d<'_>, table: &Table, normal: DVec3, a: usize, b: usize) -> f64 {
    if b == a + 1 {
        return bend_at_rim(ring, normal, a, b);
    }
    let m = table.split[a * table.n + b] as usize;
    let [p, q, r] = [a, m, b].map(|v| ring.points[v]);
    bend(normal, (q - p).cross(r - p))
}

fn bend_at_rim(ring: &Ring3d<'_>, normal: DVec3, a: usize, b: usize) -> f64 {
    let (p, q) = (ring.points[a], ring.points[b]);
    ring.apexes[a].map_or(0.0, |apex| bend(normal, (p - q).cross(apex - q)))
}

/// 1 - cos of the angle between two normals; flat triangles count as folded, so that they are avoided.
fn bend(a: DVec3, b: DVec3) -> f64 {
    let product = (a.length_squared() * b.length_squared()).sqrt();
    if product > 0.0 { 1.0 - a.dot(b) / product } else { 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[[f64; 3]]) -> Vec<DVec3> {
        points.iter().map(|&p| DVec3::from_array(p)).collect()
    }

    #[test]
    fn a_square_takes_the_diagonal_that_is_left() {
        let points = ring(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
        let apexes = [None; 4];
        for (forbidden, expected) in
            [(vec![[0, 2]], Some(vec![[0, 1, 3], [1, 2, 3]])), (vec![[0, 2], [1, 3]], None)]
        {
            for weight in [RingWeight::Area, RingWeight::AngleThenArea] {
                let ring = Ring3d { points: &points, apexes: &apexes, forbidden: &forbidden };
                assert_eq!(triangulate_ring(&ring, weight), expected);
            }
        }
    }

    #[test]
    fn area_is_minimal_among_all_triangulations() {
        let points =
            ring(&[[0., 0., 0.], [2., -1., 1.], [4., 0., 0.], [5., 2., 2.], [2., 4., -1.], [-1., 2., 1.]]);
        let apexes = [None; 6];
        let ring = Ring3d { points: &points, apexes: &apexes, forbidden: &[] };
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| points[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        fn brute(i: usize, k: usize, area: &dyn Fn([u32; 3]) -> f64) -> f64 {
            let split =
                |m: usize| brute(i, m, area) + brute(m, k, area) + area([i as u32, m as u32, k as u32]);
            if k - i < 2 { 0.0 } else { (i + 1..k).map(split).fold(f64::INFINITY, f64::min) }
        }
        let done: f64 = triangulate_ring(&ring, RingWeight::Area).unwrap().into_iter().map(area).sum();
        assert!((done - brute(0, 5, &area)).abs() < 1e-12);
    }

    #[test]
    fn the_rim_behind_an_edge_steers_the_fold() {
        // A square bent along one diagonal: the mesh behind decides which way it folds.
        let points = ring(&[[0., 0., 0.], [1., 0., 0.5], [1., 1., 0.], [0., 1., 0.5]]);
        let flat = |a: [f64; 3]| Some(DVec3::from_array(a));
        let valley =
            [flat([0.5, -1., 0.75]), flat([2., 0.5, 0.75]), flat([0.5, 2., 0.75]), flat([-1., 0.5, 0.75])];
        let ring = Ring3d { points: &points, apexes: &valley, forbidden: &[] };
        assert_eq!(triangulate_ring(&ring, RingWeight::AngleThenArea).map(|t| t.len()), Some(2));
    }
}
