//! Contours that cross themselves where ragged tiles overlap: the neighbours' borders run past each other at a corner, or
//! past the end of a rim.

use glam::DVec2;
use lacuna_mesh::{Meeting, find_meetings, segments_cross};

/// Most vertices between two crossing edges for them to be one place: no tile strays over more edges than that.
const LONGEST_KNOT: usize = 6;

/// Takes vertices out of a ring until no two edges near each other along it cross, as far as that can be done without
/// those that must stay. Returns which vertices are left.
///
/// Steps: (1) the first pair of crossing edges with few vertices between them; (2) of the vertices between, the one
/// without which the ring crosses itself least there, then the one that cuts off the least area, goes; (3) again.
pub(crate) fn untangle(ring: &[DVec2], may_go: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut left: Vec<usize> = (0..ring.len()).collect();
    while let Some(knot) = first_knot(ring, &left, &may_go) {
        let cost = |&at: &usize| {
            let without: Vec<usize> = left.iter().copied().filter(|&v| v != left[at]).collect();
            let n = left.len();
            let [a, b, c] = [left[(at + n - 1) % n], left[at], left[(at + 1) % n]].map(|v| ring[v]);
            (crossings_near(ring, &without, at), (b - a).perp_dot(c - a).abs())
        };
        let best = knot
            .into_iter()
            .map(|at| (cost(&at), at))
            .min_by(|(x, a), (y, b)| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then(a.cmp(b)));
        let Some((_, at)) = best else { break };
        left.remove(at);
    }
    left
}

/// Places in `left` of the vertices between the first two edges that cross near each other and that may go.
fn first_knot(ring: &[DVec2], left: &[usize], may_go: &impl Fn(usize) -> bool) -> Option<Vec<usize>> {
    let n = left.len();
    if n <= 3 {
        return None;
    }
    let places: Vec<DVec2> = left.iter().map(|&v| ring[v]).collect();
    let crossing = find_meetings(&[&places]).into_iter().filter(|p| p.meeting != Meeting::Touching);
    crossing
        .filter_map(|pair| {
            let (first, count) = if pair.second - pair.first <= n / 2 {
                (pair.first + 1, pair.second - pair.first)
            } else {
                (pair.second + 1, n - (pair.second - pair.first))
            };
            let between: Vec<usize> =
                (first..first + count).map(|k| k % n).filter(|&k| may_go(left[k])).collect();
            (count <= LONGEST_KNOT && !between.is_empty()).then_some(between)
        })
        .next()
}

/// How many pairs of edges cross among those around a place of the ring.
fn crossings_near(ring: &[DVec2], left: &[usize], at: usize) -> usize {
    let n = left.len();
    let edge = |k: usize| [ring[left[k % n]], ring[left[(k + 1) % n]]];
    let reach = (2 * LONGEST_KNOT).min(n);
    let around: Vec<[DVec2; 2]> = (0..reach).map(|d| edge(at + n + d - reach / 2)).collect();
    let meets = |i: usize, j: usize| {
        let ([a, b], [c, d]) = (around[i], around[j]);
        matches!(segments_cross(a, b, c, d), Meeting::Crossing | Meeting::Overlapping)
    };
    (0..reach).flat_map(|i| (i + 1..reach).map(move |j| (i, j))).filter(|&(i, j)| meets(i, j)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_mesh::is_simple;

    fn check(name: &str, ring: &[(f64, f64)], fixed: &[usize], expected: &[usize]) {
        let places: Vec<DVec2> = ring.iter().copied().map(DVec2::from).collect();
        let left = untangle(&places, |v| !fixed.contains(&v));
        assert_eq!(left, expected, "{name}");
    }

    #[test]
    fn borders_that_run_past_each_other_at_a_corner() {
        let tangled =
            [(0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (10.0, 10.4), (10.3, 9.7), (5.0, 10.0), (0.0, 10.0)];
        check("the vertex that costs least goes", &tangled, &[], &[0, 1, 2, 4, 5, 6]);
        check("unless it must stay", &tangled, &[4], &[0, 1, 2, 4, 5, 6]);
        check("the other one goes then", &tangled, &[3], &[0, 1, 2, 3, 5, 6]);
        check("or none", &tangled, &[3, 4], &[0, 1, 2, 3, 4, 5, 6]);
        let places: Vec<DVec2> = tangled.iter().copied().map(DVec2::from).collect();
        let simple: Vec<DVec2> = untangle(&places, |_| true).into_iter().map(|v| places[v]).collect();
        assert!(!is_simple(&[&places]) && is_simple(&[&simple]));
    }

    #[test]
    fn simple_rings_stay() {
        let square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
        check("a square", &square, &[], &[0, 1, 2, 3]);
    }

    #[test]
    fn crossings_far_apart_along_the_ring_are_not_touched() {
        // A figure of eight with many vertices in both halves.
        let turn = |k: usize| std::f64::consts::TAU * (k as f64 + 0.5) / 40.0;
        let eight: Vec<(f64, f64)> = (0..40).map(|k| (turn(k).sin(), (2.0 * turn(k)).sin())).collect();
        check("an eight", &eight, &[], &(0..40).collect::<Vec<_>>());
    }
}
