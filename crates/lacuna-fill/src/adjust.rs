//! Mesh adjustment: each new vertex to the weighted mean of its neighbours, ring after ring.

use glam::DVec3;

/// What may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Only z: triangles can't turn over in plan.
    Height,
    /// x, y and z.
    Position,
}

/// Least distance in the weights, metres.
const FLOOR_M: f64 = 1e-6;

/// Moves all vertices from `fixed` on: `v = sum w_i p_i / sum w_i`, `w_i = 1 / |v - p_i|`, over the first- and
/// second-order neighbours. Goes ring by ring from the fixed vertices inwards, each ring at once, so a ring sees the
/// moved rings before it and the unmoved ones behind it. Vertices that hang on no fixed one stay.
///
/// Source: Wang et al. 2021, eq. 1 (the printed numerator lacks its sum).
pub fn adjust(points: &mut [DVec3], triangles: &[[u32; 3]], fixed: usize, freedom: Freedom) {
    let neighbours = neighbours(points.len(), triangles);
    let depth = depths(&neighbours, fixed);
    let deepest = depth.iter().flatten().copied().max().unwrap_or(0);
    for ring in 1..=deepest {
        let members = (0..points.len()).filter(|&v| depth[v] == Some(ring));
        let moved: Vec<(usize, DVec3)> =
            members.map(|v| (v, weighted_mean(points, &second_order(&neighbours, v), v))).collect();
        for (v, p) in moved {
            match freedom {
                Freedom::Height => points[v].z = p.z,
                Freedom::Position => points[v] = p,
            }
        }
    }
}

/// Sorted neighbours of every vertex.
fn neighbours(count: usize, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut lists = vec![vec![]; count];
    for &[a, b, c] in triangles {
        for (v, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            lists[v as usize].extend(others);
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}

/// Number of edges from the nearest fixed vertex.
fn depths(neighbours: &[Vec<u32>], fixed: usize) -> Vec<Option<u32>> {
    let mut depth = vec![None; neighbours.len()];
    depth[..fixed].fill(Some(0));
    let mut front: Vec<u32> = (0..fixed as u32).collect();
    let mut ring = 0;
    while !front.is_empty() {
        ring += 1;
        let mut inner = vec![];
        for &w in front.iter().flat_map(|&v| &neighbours[v as usize]) {
            if depth[w as usize].is_none() {
                depth[w as usize] = Some(ring);
                inner.push(w);
            }
        }
        front = inner;
    }
    depth
}

fn second_order(neighbours: &[Vec<u32>], v: usize) -> Vec<u32> {
    let first = &neighbours[v];
    let mut all: Vec<u32> =
        first.iter().flat_map(|&w| &neighbours[w as usize]).chain(first).copied().collect();
    all.sort_unstable();
    all.dedup();
    all.retain(|&w| w as usize != v);
    all
}

fn weighted_mean(points: &[DVec3], neighbours: &[u32], v: usize) -> DVec3 {
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for &w in neighbours {
        let weight = 1.0 / points[v].distance(points[w as usize]).max(FLOOR_M);
        sum += (points[w as usize] - points[v]) * weight;
        total += weight;
    }
    if total > 0.0 { points[v] + sum / total } else { points[v] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 5 x 5 points, rim first; the nine inner ones start at `height`.
    fn grid(height: f64) -> (Vec<DVec3>, Vec<[u32; 3]>, usize) {
        let cells = (0..5).flat_map(|y| (0..5).map(move |x| (x, y)));
        let is_rim = |&(x, y): &(i32, i32)| x == 0 || y == 0 || x == 4 || y == 4;
        let (rim, inner): (Vec<_>, Vec<_>) = cells.partition(is_rim);
        let order: Vec<(i32, i32)> = rim.iter().chain(&inner).copied().collect();
        let id = |x: i32, y: i32| order.iter().position(|&p| p == (x, y)).unwrap() as u32;
        let mut triangles = vec![];
        for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
            triangles.push([id(x, y), id(x + 1, y), id(x + 1, y + 1)]);
            triangles.push([id(x, y), id(x + 1, y + 1), id(x, y + 1)]);
        }
        let z = |i: usize| if i < rim.len() { 0.0 } else { height };
        let points =
            order.iter().enumerate().map(|(i, &(x, y))| DVec3::new(x.into(), y.into(), z(i))).collect();
        (points, triangles, rim.len())
    }

    #[test]
    fn a_flat_patch_stays_and_a_raised_one_sinks_towards_its_rim() {
        let (mut flat, triangles, fixed) = grid(0.0);
        let before = flat.clone();
        adjust(&mut flat, &triangles, fixed, Freedom::Height);
        assert_eq!(flat, before);
        let (mut raised, ..) = grid(1.0);
        adjust(&mut raised, &triangles, fixed, Freedom::Height);
        assert!(raised[fixed..].iter().all(|p| p.z > 0.0 && p.z < 0.8));
        assert_eq!(raised[..fixed], before[..fixed]);
        let places = |p: &[DVec3]| p.iter().map(|p| p.truncate()).collect::<Vec<_>>();
        assert_eq!(places(&raised), places(&before));
    }

    #[test]
    fn one_vertex_goes_to_the_mean_weighted_by_inverse_distance() {
        let at = DVec3::new;
        let mut points =
            vec![at(1., 0., 3.), at(0., 1., 0.), at(-2., 0., 0.), at(0., -1., 0.), at(0., 0., 0.)];
        let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let weights = [1.0 / 10f64.sqrt(), 1.0, 0.5, 1.0];
        adjust(&mut points, &triangles, 4, Freedom::Height);
        let expected = 3.0 * weights[0] / weights.iter().sum::<f64>();
        assert!((points[4].z - expected).abs() < 1e-15);
    }
}
