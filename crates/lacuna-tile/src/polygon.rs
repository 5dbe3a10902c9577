//! Cuts the polygons of a face list into triangles.

use glam::{DVec2, DVec3};

/// Non-convex polygons with more corners are cut as fans: ears cost the square of the corners, and the boundary that
/// the reader is after comes out the same.
pub(crate) const MOST_EAR_CORNERS: usize = 1024;

/// Appends the triangles of one polygon to `triangles`, in the polygon's own direction.
///
/// Strictly convex polygons become a fan round their first corner; others lose ears one by one (Meisters 1975), judged in the
/// plane of the polygon's Newell normal. A polygon without any area, and a non-convex one with more than
/// `MOST_EAR_CORNERS` corners, becomes a fan as well. Every polygon of n >= 3 corners gives n - 2 triangles whose outer
/// edges are the polygon's. Every corner must be an index into `positions`.
pub(crate) fn cut_polygon(corners: &[u32], positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) {
    match corners {
        [] | [_] | [_, _] => {}
        &[a, b, c] => triangles.push([a, b, c]),
        _ if corners.len() > MOST_EAR_CORNERS => fan(corners, triangles),
        _ => match flatten(corners, positions) {
            Some(plane) if !is_convex(&plane) => cut_ears(corners, &plane, triangles),
            _ => fan(corners, triangles),
        },
    }
}

fn fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let [first, rest @ ..] = corners else { return };
    triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
}

/// The corners in the plane of their Newell normal, counter-clockwise; `None` without a finite normal.
fn flatten(corners: &[u32], positions: &[DVec3]) -> Option<Vec<DVec2>> {
    let origin = positions[corners[0] as usize];
    let local: Vec<DVec3> = corners.iter().map(|&c| positions[c as usize] - origin).collect();
    let normal: DVec3 = (0..local.len()).map(|i| local[i].cross(local[(i + 1) % local.len()])).sum();
    let normal = normal.try_normalize()?;
    let (u, v) = normal.any_orthonormal_pair();
    let turned = if u.cross(v).dot(normal) < 0.0 { (v, u) } else { (u, v) };
    Some(local.iter().map(|p| DVec2::new(p.dot(turned.0), p.dot(turned.1))).collect())
}

/// Convex: every corner turns left, and the turns add up to one round (a star turns left everywhere but twice round).
fn is_convex(plane: &[DVec2]) -> bool {
    let n = plane.len();
    let all_left = (0..n).all(|i| turn(plane[i], plane[(i + 1) % n], plane[(i + 2) % n]) > 0.0);
    all_left && sign_changes(plane) <= 2
}

/// How often the x direction of the walk turns round: twice in a convex polygon.
fn sign_changes(plane: &[DVec2]) -> usize {
    let n = plane.len();
    let steps: Vec<bool> =
        (0..n).map(|i| plane[(i + 1) % n].x - plane[i].x).filter(|s| *s != 0.0).map(|s| s > 0.0).collect();
    (0..steps.len()).filter(|&i| steps[i] != steps[(i + 1) % steps.len()]).count()
}

/// Twice the signed area of a triangle, positive when counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Takes ears off, always the first one round from the last cut; where there is none (a polygon that crosses itself),
/// the corner itself goes, so that the count holds.
fn cut_ears(corners: &[u32], plane: &[DVec2], triangles: &mut Vec<[u32; 3]>) {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut ears: Vec<bool> = (0..left.len()).map(|at| is_ear(&left, plane, at)).collect();
    let mut at = 0;
    while left.len() > 3 {
        let n = left.len();
        at = (at..n).chain(0..at).find(|&k| ears[k]).unwrap_or(at % n);
        triangles.push([(at + n - 1) % n, at, (at + 1) % n].map(|k| corners[left[k]]));
        left.remove(at);
        ears.remove(at);
        let n = left.len();
        at %= n;
        for k in [(at + n - 1) % n, at] {
            ears[k] = is_ear(&left, plane, k);
        }
    }
    triangles.push([corners[left[0]], corners[left[1]], corners[left[2]]]);
}

/// Corner `at` turns left and no other corner lies in its triangle.
fn is_ear(left: &[usize], plane: &[DVec2], at: usize) -> bool {
    let n = left.len();
    let [a, b, c] = [(at + n - 1) % n, at, (at + 1) % n].map(|k| plane[left[k]]);
    turn(a, b, c) > 0.0
        && left.iter().map(|&k| plane[k]).all(|p| {
            let is_corner = p == a || p == b || p == c;
            is_corner || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &[[u32; 3]], positions: &[DVec3]) -> f64 {
        triangles
            .iter()
            .map(|t| t.map(|v| positions[v as usize]))
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum()
    }

    fn check(name: &str, outline: &[[f64; 3]], want_area: f64) {
        let positions: Vec<DVec3> = outline.iter().map(|&p| DVec3::from(p)).collect();
        for start in 0..positions.len() {
            let corners: Vec<u32> =
                (0..positions.len()).map(|k| ((k + start) % positions.len()) as u32).collect();
            let mut triangles = Vec::new();
            cut_polygon(&corners, &positions, &mut triangles);
            assert_eq!(triangles.len(), positions.len() - 2, "{name} from {start}");
            let got = area(&triangles, &positions);
            assert!((got - want_area).abs() < 1e-9, "{name} from {start}: area {got}, not {want_area}");
        }
    }

    #[test]
    fn polygons_keep_their_area_from_any_first_corner() {
        let l = [[0., 0., 0.], [4., 0., 0.], [4., 1., 0.], [1., 1., 0.], [1., 4., 0.], [0., 4., 0.]];
        check("square", &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]], 1.0);
        check("arrow", &[[0., 0., 0.], [2., 2., 0.], [0., 1., 0.], [-2., 2., 0.]], 2.0);
        check("L", &l, 7.0);
        check("standing L", &l.map(|[x, y, _]| [x, 3.0, y]), 7.0);
        check("mirrored L", &l.map(|[x, y, z]| [-x, y, z]), 7.0);
        check("L far away", &l.map(|[x, y, z]| [x + 5e5, y + 5e6, z]), 7.0);
        let comb = [[0., 0.], [6., 0.], [6., 3.], [5., 1.], [4., 3.], [3., 1.], [2., 3.], [1., 1.], [0., 3.]];
        check("comb", &comb.map(|[x, y]| [x, y, 0.0]), 12.0);
    }

    #[test]
    fn odd_polygons_give_their_count() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 0.0, 0.0), DVec3::NAN, DVec3::Y];
        for corners in [vec![0, 1, 2, 0], vec![0, 1, 3, 4], vec![0, 0, 0, 0, 0], vec![0, 2, 4, 1, 0, 4, 2]] {
            let mut triangles = Vec::new();
            cut_polygon(&corners, &positions, &mut triangles);
            assert_eq!(triangles.len(), corners.len() - 2, "{corners:?}");
        }
    }
}
