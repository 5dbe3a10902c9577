//! Polygons in plan: exact answers near zero, the same when turned, mirrored, reversed or far away.

mod common;

use glam::DVec2;
use lacuna_mesh::{
    Location, Meeting, contains, find_crossings, find_meetings, is_simple, perimeter, segments_cross,
    signed_area,
};
use proptest::prelude::*;

fn ring(points: &[[f64; 2]]) -> Vec<DVec2> {
    points.iter().map(|&p| p.into()).collect()
}

/// An L of 3 unit squares, counter-clockwise.
fn corner_shape() -> Vec<DVec2> {
    ring(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])
}

const MAPS: [fn(DVec2) -> DVec2; 5] =
    [|p| p, |p| DVec2::new(-p.y, p.x), |p| DVec2::new(-p.x, p.y), |p| p + DVec2::new(5e5, -4e6), |p| -p];

#[test]
fn area_and_perimeter() {
    let shape = corner_shape();
    assert_eq!((signed_area(&shape), perimeter(&shape)), (3.0, 8.0));
    let reversed: Vec<DVec2> = shape.iter().rev().copied().collect();
    assert_eq!(signed_area(&reversed), -3.0);
    let far: Vec<DVec2> = shape.iter().map(|&p| p + DVec2::splat(5e5)).collect();
    assert_eq!(signed_area(&far), 3.0);
    assert_eq!((signed_area(&[]), perimeter(&[]), signed_area(&[DVec2::ONE])), (0.0, 0.0, 0.0));
}

#[test]
fn points_are_inside_outside_or_on_an_edge() {
    use Location::{Inside, OnEdge, Outside};
    let cases = [
        ("in the foot", [1.5, 0.5], Inside),
        ("at a vertex's height", [0.5, 1.0], Inside),
        ("in the notch", [1.5, 1.5], Outside),
        ("left, at a vertex's height", [-1.0, 1.0], Outside),
        ("left, at the base's height", [-1.0, 0.0], Outside),
        ("right, at the top's height", [3.0, 2.0], Outside),
        ("on the base", [1.0, 0.0], OnEdge),
        ("on the notch's corner", [1.0, 1.0], OnEdge),
        ("at a vertex", [2.0, 1.0], OnEdge),
        ("just under the base", [1.0, -1e-300], Outside),
    ];
    for (name, point, expected) in cases {
        for map in &MAPS[..3] {
            let shape: Vec<DVec2> = corner_shape().into_iter().map(map).collect();
            assert_eq!(contains(&shape, map(point.into())), expected, "{name}");
        }
    }
    assert_eq!(contains(&[], DVec2::ZERO), Outside);
}

#[test]
fn segments_meet_as_they_should() {
    use Meeting::{Apart, Crossing, Overlapping, Touching};
    let cases = [
        ("an X", [[0, 0], [2, 2], [0, 2], [2, 0]], Crossing),
        ("a T", [[0, 0], [2, 0], [1, 0], [1, 2]], Touching),
        ("a V", [[0, 0], [2, 0], [2, 0], [3, 3]], Touching),
        ("parallel", [[0, 0], [2, 0], [0, 1], [2, 1]], Apart),
        ("a T that is cut short", [[0, 0], [2, 0], [1, 1], [1, 2]], Apart),
        ("collinear, apart", [[0, 0], [1, 1], [2, 2], [3, 3]], Apart),
        ("collinear, end to end", [[0, 0], [1, 1], [1, 1], [3, 3]], Touching),
        ("collinear, overlapping", [[0, 0], [2, 2], [1, 1], [3, 3]], Overlapping),
        ("the same, reversed", [[0, 0], [2, 2], [2, 2], [0, 0]], Overlapping),
        ("upright, one within the other", [[0, 0], [0, 9], [0, 2], [0, 3]], Overlapping),
        ("a point on it", [[0, 0], [2, 2], [1, 1], [1, 1]], Touching),
        ("a point beside it", [[0, 0], [2, 2], [1, 0], [1, 0]], Apart),
        ("a point on its line", [[0, 0], [2, 2], [3, 3], [3, 3]], Apart),
    ];
    for (name, points, expected) in cases {
        for map in MAPS {
            let [a, b, c, d] = points.map(|[x, y]: [i32; 2]| map(DVec2::new(f64::from(x), f64::from(y))));
            for found in [segments_cross(a, b, c, d), segments_cross(d, c, a, b), segments_cross(c, d, b, a)]
            {
                assert_eq!(found, expected, "{name}");
            }
        }
    }
}

#[test]
fn the_smallest_miss_is_a_miss() {
    let (a, b) = (DVec2::new(0.1, 0.1), DVec2::new(24.3, 24.3));
    let on = DVec2::splat(12.7);
    let off = DVec2::new(12.7, f64::from_bits(12.7f64.to_bits() + 1));
    let far = DVec2::new(0.0, 30.0);
    assert_eq!(segments_cross(a, b, on, far), Meeting::Touching);
    assert_eq!(segments_cross(a, b, off, far), Meeting::Apart);
}

#[test]
fn polygons_are_simple_or_say_where_not() {
    let eight = ring(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    let island = ring(&[[0.2, 0.2], [0.2, 0.8], [0.8, 0.8], [0.8, 0.2]]);
    let crossing_island = ring(&[[1.5, 0.5], [1.5, 1.5], [1.8, 1.5], [1.8, 0.5]]);
    let pinched = ring(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]]);
    let spike = ring(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 1.0], [0.0, 1.0]]);
    assert!(is_simple(&[&corner_shape(), &island]) && is_simple(&[]) && is_simple(&[&[]]));
    assert_eq!(find_crossings(&[&eight]), [(0, 2)]);
    assert_eq!(find_crossings(&[&corner_shape(), &crossing_island]), [(2, 6), (2, 8)]);
    assert_eq!(find_crossings(&[&spike]), [(1, 2)]);
    assert!(find_crossings(&[&pinched]).is_empty() && !is_simple(&[&pinched]));
}

#[test]
fn long_rims_are_searched_quickly() {
    let star = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 100_000.0;
        DVec2::new(libm::cos(angle), libm::sin(angle)) * (300.0 + f64::from(i * 37 % 11) * 0.01)
    };
    let mut rim: Vec<DVec2> = (0..100_000).map(star).collect();
    assert!(is_simple(&[&rim]));
    rim.swap(50_000, 50_100);
    assert!(!is_simple(&[&rim]));
}

proptest! {
    #![proptest_config(common::fixed_cases())]

    #[test]
    fn meetings_agree_with_trying_all_pairs(points in prop::collection::vec([0..12i32, 0..12i32], 1..60), cut in 0..60usize) {
        let points: Vec<DVec2> = points.iter().map(|&[x, y]| DVec2::new(f64::from(x), f64::from(y))).collect();
        let (first, second) = points.split_at(cut.min(points.len()));
        let edges: Vec<[DVec2; 2]> = [first, second].into_iter()
            .flat_map(|r| (0..r.len()).map(|i| [r[i], r[(i + 1) % r.len()]])).collect();
        let next = |i: usize| match i {
            i if i + 1 == first.len() => 0,
            i if i + 1 == points.len() => first.len(),
            i => i + 1,
        };
        let mut expected = Vec::new();
        for i in 0..edges.len() {
            for j in i + 1..edges.len() {
                let meeting = segments_cross(edges[i][0], edges[i][1], edges[j][0], edges[j][1]);
                let are_neighbours = next(i) == j || next(j) == i;
                if meeting != Meeting::Apart && !(are_neighbours && meeting == Meeting::Touching) {
                    expected.push((i, j, meeting));
                }
            }
        }
        let found: Vec<_> = find_meetings(&[first, second]).iter().map(|p| (p.first, p.second, p.meeting)).collect();
        prop_assert_eq!(found, expected);
    }
}
