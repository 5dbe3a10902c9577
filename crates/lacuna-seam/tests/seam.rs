//! What smoothing does to a border, and what it never does.

use glam::{DVec2, DVec3};
use lacuna_seam::{SeamError, SeamVertex, SmoothOutcome, SmoothParams, buffer_m, smooth};
use proptest::prelude::*;

const BUFFER_M: f64 = 3.0;

/// A border along x with a vertex each metre, its ends frozen.
fn border(heights: &[f64]) -> Vec<SeamVertex> {
    let last = heights.len() - 1;
    let vertex = |(i, &z): (usize, &f64)| SeamVertex {
        plan: DVec2::new(i as f64, 0.0),
        z,
        frozen: i == 0 || i == last,
    };
    heights.iter().enumerate().map(vertex).collect()
}

/// Rows of points 1 and 2 m off the border on both sides, a point each metre.
fn strips(length_m: usize, height: impl Fn(f64, f64) -> f64) -> Vec<DVec3> {
    let row = |y: f64| (0..=length_m).map(move |x| (x as f64, y));
    let places = [-2.0, -1.0, 1.0, 2.0].into_iter().flat_map(row);
    places.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect()
}

/// A border of 13 vertices and its strips: rough, and always the same. Heights near 0, for sums of equally large ones are
/// exact in any order and would hide a wrong one.
fn rough() -> (Vec<SeamVertex>, Vec<DVec3>) {
    let wave = |x: f64, y: f64| scrambled(x * 3.0 + y * 7.0);
    let heights: Vec<f64> = (0..13).map(|x| wave(f64::from(x), 0.5) + f64::from(x % 3)).collect();
    (border(&heights), strips(12, wave))
}

/// Some number between 0 and 1 that looks random down to its last bit, so that sums in another order differ.
fn scrambled(seed: f64) -> f64 {
    let large = (seed * 12.9898 + 78.233) * 43_758.545;
    (large - large.floor()) / 1.1
}

fn run(border: &[SeamVertex], strips: &[DVec3], params: &SmoothParams) -> (Vec<SeamVertex>, SmoothOutcome) {
    let mut smoothed = border.to_vec();
    let outcome = smooth(&mut smoothed, strips, BUFFER_M, params).expect("sound input");
    (smoothed, outcome)
}

fn heights(border: &[SeamVertex]) -> Vec<f64> {
    border.iter().map(|vertex| vertex.z).collect()
}

fn bits(border: &[SeamVertex]) -> Vec<u64> {
    border.iter().map(|vertex| vertex.z.to_bits()).collect()
}

fn assert_near(name: &str, left: &[f64], right: &[f64], tolerance_m: f64) {
    assert_eq!(left.len(), right.len());
    for (i, (a, b)) in left.iter().zip(right).enumerate() {
        assert!((a - b).abs() <= tolerance_m, "{name}: vertex {i}: {a} against {b}");
    }
}

#[test]
fn one_vertex_follows_the_equation() {
    // The mean of what lies within 3 m is 4; the point at 3.1 m does not count.
    let near = [(1.0, 0.0, 2.0), (-1.0, 2.0, 3.0), (0.0, 3.0, 7.0), (3.1, 0.0, 1000.0)];
    let strips = near.map(DVec3::from);
    for (gamma, rounds, expected) in [(0.5, 1, 2.0), (0.5, 2, 3.0), (0.25, 1, 1.0), (0.5, 0, 0.0)] {
        let mut vertices = [SeamVertex { plan: DVec2::ZERO, z: 0.0, frozen: false }];
        let params = SmoothParams { gamma, rounds, ..SmoothParams::default() };
        let outcome = smooth(&mut vertices, &strips, BUFFER_M, &params).expect("sound input");
        assert_eq!(vertices[0].z, expected, "gamma {gamma}, {rounds} rounds");
        let residual_m = 4.0 - expected;
        assert_eq!(outcome, SmoothOutcome { rounds, residual_m, largest_move_m: expected });
    }
}

#[test]
fn all_vertices_move_at_once() {
    // Two vertices that see only each other: gamma is 1/2, so both reach the middle in one round.
    let vertex = |x: f64, z| SeamVertex { plan: DVec2::new(x, 0.0), z, frozen: false };
    let (smoothed, outcome) = run(&[vertex(0.0, 0.0), vertex(1.0, 8.0)], &[], &SmoothParams::default());
    assert_eq!(heights(&smoothed), [4.0, 4.0]);
    assert_eq!(outcome, SmoothOutcome { rounds: 1, residual_m: 0.0, largest_move_m: 4.0 });
}

#[test]
fn flat_stays_flat_to_the_last_bit() {
    for z in [0.0, 0.1, -3.7, 1_234.567_891] {
        let flat = border(&[z; 20]);
        let (smoothed, outcome) = run(&flat, &strips(19, |_, _| z), &SmoothParams::default());
        assert_eq!(bits(&smoothed), bits(&flat));
        assert_eq!(outcome, SmoothOutcome::default());
    }
}

#[test]
fn a_slope_along_the_border_stays_inside() {
    // Away from the ends the neighbourhood is symmetric, so an even slope is its own mean.
    let slope = |x: f64, _: f64| 5.0 + 0.25 * x;
    let vertices = border(&(0..40).map(|x| slope(f64::from(x), 0.0)).collect::<Vec<_>>());
    let one_round = SmoothParams { rounds: 1, ..SmoothParams::default() };
    let (smoothed, _) = run(&vertices, &strips(39, slope), &one_round);
    assert_near("inside", &heights(&smoothed)[4..36], &heights(&vertices)[4..36], 1e-12);
}

#[test]
fn a_bump_shrinks() {
    let mut bumped = [10.0; 15];
    bumped[7] = 13.0;
    let mut height = 3.0;
    for rounds in 1..=10 {
        let params = SmoothParams { rounds, ..SmoothParams::default() };
        let (smoothed, outcome) = run(&border(&bumped), &strips(14, |_, _| 10.0), &params);
        let now = smoothed.iter().map(|vertex| (vertex.z - 10.0).abs()).fold(0.0, f64::max);
        assert!(now < 0.7 * height, "round {rounds}: {height} -> {now}");
        assert_eq!(outcome.rounds, rounds);
        height = now;
    }
    assert!(height < 0.02, "{height} m are left after ten rounds");
}

#[test]
fn it_ends_early_when_nothing_moves_by_a_millimetre() {
    let mut bumped = [10.0; 15];
    bumped[7] = 10.01;
    let (_, outcome) = run(&border(&bumped), &strips(14, |_, _| 10.0), &SmoothParams::default());
    assert!(outcome.rounds > 1 && outcome.rounds < 10, "{outcome:?}");
    assert!(outcome.residual_m < 1e-3, "{outcome:?}");
}

#[test]
fn frozen_vertices_and_lonely_ones_keep_their_bits() {
    let (mut vertices, strips) = rough();
    for index in [3, 4, 9] {
        vertices[index].frozen = true;
    }
    let far = SeamVertex { plan: DVec2::new(0.0, 100.0), z: 7.7, frozen: false };
    vertices.push(far);
    let (smoothed, _) = run(&vertices, &strips, &SmoothParams::default());
    for (before, after) in vertices.iter().zip(&smoothed) {
        let stays = before.frozen || *before == far;
        assert_eq!(before.z.to_bits() == after.z.to_bits(), stays, "{before:?} -> {after:?}");
        assert_eq!((before.plan, before.frozen), (after.plan, after.frozen));
    }
}

#[test]
fn frozen_vertices_pull_their_neighbours() {
    let mut vertices = border(&[0.0; 9]);
    vertices[4] = SeamVertex { z: 5.0, frozen: true, ..vertices[4] };
    let (smoothed, _) = run(&vertices, &[], &SmoothParams::default());
    assert!(smoothed[3].z > 0.5 && smoothed[5].z > 0.5);
}

#[test]
fn no_order_matters() {
    let (vertices, strips) = rough();
    let (expected, outcome) = run(&vertices, &strips, &SmoothParams::default());
    for step in [1, 5, 11, 25] {
        // 52 strip points and 13 vertices; a step without a common divisor visits each once.
        let mixed: Vec<DVec3> = (0..strips.len()).map(|i| strips[(i * step + 3) % strips.len()]).collect();
        let order: Vec<usize> = (0..13).map(|i| (i * step + 2) % 13).collect();
        let turned: Vec<SeamVertex> = order.iter().map(|&i| vertices[i]).collect();
        let (smoothed, same) = run(&turned, &mixed, &SmoothParams::default());
        let back: Vec<u64> = order.iter().map(|&i| expected[i].z.to_bits()).collect();
        assert_eq!((bits(&smoothed), same), (back, outcome), "step {step}");
    }
}

#[test]
fn symmetric_input_gives_symmetric_output() {
    let hill = |x: f64, y: f64| (x - 6.0) * (x - 6.0) * 0.3 + y * y;
    let vertices = border(&(0..13).map(|x| hill(f64::from(x), 1.5)).collect::<Vec<_>>());
    let (smoothed, outcome) = run(&vertices, &strips(12, hill), &SmoothParams::default());
    let mut mirrored = heights(&smoothed);
    mirrored.reverse();
    assert_near("mirror", &heights(&smoothed), &mirrored, 1e-12);
    assert!(outcome.largest_move_m > 0.1);
}

#[test]
fn turning_mirroring_and_shifting_the_plan_changes_no_height() {
    let (vertices, strips) = rough();
    let (expected, _) = run(&vertices, &strips, &SmoothParams::default());
    type Motion = fn(DVec2) -> DVec2;
    let motions: [(&str, Motion, f64); 6] = [
        ("turn by 90 degrees", |p| DVec2::new(-p.y, p.x), 1e-12),
        ("turn by 180 degrees", |p| -p, 1e-12),
        ("mirror in x", |p| DVec2::new(-p.x, p.y), 1e-12),
        ("mirror in y", |p| DVec2::new(p.x, -p.y), 1e-12),
        ("shift by 5e5 m", |p| p + DVec2::new(5e5, -5e5), 0.0),
        ("shift by a cell", |p| p + DVec2::new(-30.0, 30.0), 0.0),
    ];
    for (name, motion, tolerance_m) in motions {
        let moved: Vec<SeamVertex> =
            vertices.iter().map(|vertex| SeamVertex { plan: motion(vertex.plan), ..*vertex }).collect();
        let points: Vec<DVec3> =
            strips.iter().map(|point| motion(point.truncate()).extend(point.z)).collect();
        let (smoothed, _) = run(&moved, &points, &SmoothParams::default());
        assert_near(name, &heights(&smoothed), &heights(&expected), tolerance_m);
    }
}

#[test]
fn the_buffer_is_three_mean_spacings() {
    let params = SmoothParams::default();
    let at = |x: f64, y: f64| SeamVertex { plan: DVec2::new(x, y), z: 99.0 * x, frozen: false };
    assert_eq!(buffer_m(&[], &params), 0.0);
    assert_eq!(buffer_m(&[at(1.0, 1.0)], &params), 0.0);
    assert_eq!(buffer_m(&[at(0.0, 0.0), at(3.0, 4.0)], &params), 15.0);
    assert_eq!(buffer_m(&[at(0.0, 0.0), at(1.0, 0.0), at(4.0, 0.0)], &params), 6.0);
    let wider = SmoothParams { buffer_spacings: 5.0, ..params };
    assert_eq!(buffer_m(&[at(0.0, 0.0), at(1.0, 0.0)], &wider), 5.0);
}

#[test]
fn input_without_meaning_is_refused_and_left_alone() {
    let params = SmoothParams::default();
    let gamma = |gamma| SmoothParams { gamma, ..params };
    let point = DVec3::new(0.0, 1.0, 2.0);
    let good = SeamVertex { plan: DVec2::ZERO, z: 1.0, frozen: false };
    let bad_z = SeamVertex { z: f64::INFINITY, ..good };
    let bad_plan = SeamVertex { plan: DVec2::new(0.0, f64::NEG_INFINITY), ..good };
    let far = DVec3::new(f64::INFINITY, 0.0, 0.0);
    let cases = [
        ("gamma 0", vec![good], vec![point], 3.0, gamma(0.0), SeamError::Gamma(0.0)),
        ("gamma 1", vec![good], vec![point], 3.0, gamma(1.0), SeamError::Gamma(1.0)),
        ("buffer below 0", vec![good], vec![point], -1.0, params, SeamError::Buffer(-1.0)),
        ("no end", vec![good], vec![point], f64::INFINITY, params, SeamError::Buffer(f64::INFINITY)),
        (
            "tolerance",
            vec![good],
            vec![point],
            3.0,
            SmoothParams { tolerance_m: -1.0, ..params },
            SeamError::Tolerance(-1.0),
        ),
        ("height", vec![good, bad_z], vec![point], 3.0, params, SeamError::Vertex(1)),
        ("place", vec![bad_plan, good], vec![point], 3.0, params, SeamError::Vertex(0)),
        ("strip", vec![good], vec![point, point, far], 3.0, params, SeamError::Strip(2)),
    ];
    for (name, vertices, strips, buffer, params, expected) in cases {
        let mut after = vertices.clone();
        assert_eq!(smooth(&mut after, &strips, buffer, &params), Err(expected), "{name}");
        assert_eq!(after, vertices, "{name}");
    }
    let not_a_number = smooth(&mut [good], &[point], 3.0, &gamma(f64::NAN));
    assert!(matches!(not_a_number, Err(SeamError::Gamma(_))));
}

#[test]
fn nothing_to_do_is_no_error() {
    let params = SmoothParams::default();
    assert_eq!(smooth(&mut [], &[], 3.0, &params), Ok(SmoothOutcome::default()));
    let mut vertices = border(&[0.0, 9.0, 0.0]);
    assert_eq!(smooth(&mut vertices, &[DVec3::Z], 0.0, &params), Ok(SmoothOutcome::default()));
    assert_eq!(heights(&vertices), [0.0, 9.0, 0.0]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Means never leave the range of what they are means of.
    #[test]
    fn heights_stay_between_the_lowest_and_the_highest(
        vertices in prop::collection::vec((0.0..20.0, -2.0..2.0, -50.0..50.0, any::<bool>()), 1..25),
        points in prop::collection::vec((0.0..20.0, -5.0..5.0, -50.0..50.0), 0..40),
        gamma in 0.01..0.99,
    ) {
        let vertices: Vec<SeamVertex> = vertices
            .into_iter()
            .map(|(x, y, z, frozen)| SeamVertex { plan: DVec2::new(x, y), z, frozen })
            .collect();
        let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
        let all = || vertices.iter().map(|vertex| vertex.z).chain(points.iter().map(|point| point.z));
        let (low, high) = (all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max));
        let (smoothed, outcome) = run(&vertices, &points, &SmoothParams { gamma, ..SmoothParams::default() });
        for (before, after) in vertices.iter().zip(&smoothed) {
            prop_assert!(after.z >= low - 1e-9 && after.z <= high + 1e-9);
            prop_assert!(!before.frozen || before.z.to_bits() == after.z.to_bits());
            prop_assert!((after.z - before.z).abs() <= outcome.largest_move_m);
        }
    }
}
