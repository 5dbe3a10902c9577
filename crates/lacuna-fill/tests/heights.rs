//! Surfaces over contours: planes, wells, bounds, walls behind the rim.

mod common;

use common::{assert_sound, case, contour_of, mapped};
use glam::{DVec2, DVec3};
use lacuna_fill::{FillParams, Filled, Filler, HeightProblem, HeightRule, Smoothness, fill, solve_heights};
use lacuna_mesh::{Contour, Support};
use lacuna_solve::{FaerSolver, ReferenceSolver, SolveError};

const AROUND: usize = 48;

/// A round hole of radius 6 with two rings of triangles behind its rim, heights from `z`.
fn well(z: impl Fn(DVec2) -> f64) -> Contour {
    let place = |ring: usize, i: usize| {
        let t = std::f64::consts::TAU * (i % AROUND) as f64 / AROUND as f64;
        let r = 6.0 + 0.8 * ring as f64;
        let p = DVec2::new(r * libm::cos(t), r * libm::sin(t));
        p.extend(z(p))
    };
    let mut contour = contour_of(&[(0..AROUND).map(|i| place(0, i)).collect()]);
    let mut support = Support::default();
    let id = |ring: usize, i: usize| (ring * AROUND + i % AROUND) as u32;
    for ring in 1..=2 {
        support.vertices.extend((0..AROUND).map(|i| place(ring, i)));
        for i in 0..AROUND {
            let [a, b] = [id(ring - 1, i), id(ring - 1, i + 1)];
            let [c, d] = [id(ring, i + 1), id(ring, i)];
            support.triangles.extend([[b, a, d], [b, d, c]]);
        }
    }
    contour.support = support;
    for i in 0..AROUND {
        contour.outer.edges[i].apex = Some(place(1, i));
    }
    contour
}

fn run(contour: &Contour, heights: HeightRule, overshoot: f64) -> Filled {
    let params = FillParams { heights, overshoot, ..FillParams::default() };
    let done = fill(contour, &params, &FaerSolver).unwrap();
    assert_sound("well", contour, &done);
    done
}

fn largest_error(done: &Filled, z: impl Fn(DVec2) -> f64) -> f64 {
    done.patch.vertices.iter().map(|p| (p.z - z(p.truncate())).abs()).fold(0.0, f64::max)
}

#[test]
fn planes_are_reproduced() {
    let plane = |p: DVec2| 40.0 + 0.3 * p.x - 0.7 * p.y;
    for rule in [HeightRule::Biharmonic, HeightRule::Harmonic] {
        let simple = ["convex", "l_shape", "star", "spiral", "islands_3", "ragged", "needle"];
        let touching =
            ["touch_once", "touch_twice", "touch_three", "ring_of_islands", "two_lobes", "closed_atoll"];
        for name in simple.into_iter().chain(touching) {
            let contour = mapped(&case(name), |p| p.truncate().extend(plane(p.truncate())));
            let done = run(&contour, rule, 0.25);
            assert!(
                largest_error(&done, plane) < 40.0 * 1e-9,
                "{name}, {rule:?}: {:e}",
                largest_error(&done, plane)
            );
        }
        let done = run(&well(plane), rule, 0.25);
        assert!(largest_error(&done, plane) < 40.0 * 1e-9, "well, {rule:?}");
    }
}

#[test]
fn a_quadratic_well_is_continued_by_the_rings_behind_its_rim() {
    let well_z = |p: DVec2| 0.05 * p.length_squared();
    let saddle_z = |p: DVec2| 0.05 * (p.x * p.x - p.y * p.y);
    let contour = well(well_z);
    let depth = 0.05 * 36.0;
    let plate = largest_error(&run(&contour, HeightRule::Biharmonic, f64::INFINITY), well_z) / depth;
    let film = largest_error(&run(&contour, HeightRule::Harmonic, f64::INFINITY), well_z) / depth;
    assert!(plate < 0.12, "thin plate {plate}");
    assert!(film > 0.9, "soap film {film}");
    let saddle = largest_error(&run(&well(saddle_z), HeightRule::Biharmonic, 0.25), saddle_z) / depth;
    assert!(saddle < 0.02, "saddle {saddle}");
}

#[test]
fn soap_films_stay_between_the_heights_of_their_rim() {
    for name in ["convex", "star", "ragged", "islands_3", "spiral", "comb"] {
        let contour = case(name);
        let heights = contour.positions().into_iter().map(|p| p.z);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let done = run(&contour, HeightRule::Harmonic, 0.25);
        let slack = 1e-9 * (high - low);
        assert!(done.patch.vertices.iter().all(|p| p.z >= low - slack && p.z <= high + slack), "{name}");
    }
}

#[test]
fn tension_holds_back_what_leaves_the_range_of_the_data() {
    // Steep slopes behind the rim would raise a dome far above everything known.
    let crater = well(|p| 2.0 * (6.0 - p.length()).min(0.0));
    let highest = |overshoot: f64| {
        let done = run(&crater, HeightRule::Biharmonic, overshoot);
        done.patch.vertices.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max)
    };
    let range = 2.0 * 1.6;
    assert!(highest(f64::INFINITY) > 0.5 * range, "free: {}", highest(f64::INFINITY));
    assert!(highest(0.25) <= 0.25 * range + 1e-6, "guarded: {}", highest(0.25));
    assert!(highest(0.25) > 0.01 * range, "guarded, but not a soap film: {}", highest(0.25));
}

#[test]
fn walls_behind_the_rim_do_not_steer_slopes() {
    // A quay: the rim's ring drops vertically. The hole's surface must stay flat.
    let mut quay = well(|_| 0.0);
    for (v, p) in quay.support.vertices.iter_mut().enumerate() {
        let rim = quay.outer.vertices[v % AROUND].position;
        *p = rim + DVec3::new(rim.x * 1e-4, rim.y * 1e-4, -3.0 * (1 + v / AROUND) as f64);
    }
    let done = run(&quay, HeightRule::Biharmonic, f64::INFINITY);
    assert_eq!(done.filler, Filler::Delaunay);
    assert!(largest_error(&done, |_| 0.0) < 1e-9);
}

#[test]
fn heights_turn_and_scale_with_the_contour() {
    let bumps = |p: DVec2| 0.4 * libm::sin(0.7 * p.x) + 0.1 * p.y * p.x;
    let contour = well(bumps);
    let here = run(&contour, HeightRule::Biharmonic, 0.25);
    // A quarter turn may change the triangulation's ties, and with it the heights a little.
    let turned = mapped(&contour, |p| DVec3::new(-p.y, p.x, 2.0 * p.z));
    let there = run(&turned, HeightRule::Biharmonic, 0.25);
    let at_centre = |done: &Filled| {
        let nearest = |p: &&DVec3| (p.truncate().length() * 1e9) as u64;
        done.patch.vertices.iter().min_by_key(nearest).map(|p| p.z).unwrap()
    };
    assert!(
        (at_centre(&there) - 2.0 * at_centre(&here)).abs() < 0.15,
        "{} {}",
        at_centre(&here),
        at_centre(&there)
    );
}

#[test]
fn facades_are_filled_in_their_own_plane() {
    for name in ["facade", "steep_roof"] {
        let contour = case(name);
        let done = fill(&contour, &FillParams::default(), &FaerSolver).unwrap();
        assert_eq!(done.filler, Filler::Plane, "{name}");
        assert!(!done.in_plan && done.quality.mean > 0.8, "{name}: {:?}", done.quality);
        let rim = contour.positions();
        let near = |p: &DVec3| rim.iter().map(|r| r.distance(*p)).fold(f64::INFINITY, f64::min) < 4.5;
        assert!(done.patch.vertices.iter().all(near), "{name}");
    }
}

/// A strip of n x 3 points with unit steps.
fn strip(n: usize) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let points = (0..3 * n).map(|i| DVec2::new((i / 3) as f64, (i % 3) as f64)).collect();
    let mut triangles = vec![];
    for c in 0..(n - 1) as u32 {
        for r in 0..2 {
            let [a, b] = [3 * c + r, 3 * (c + 1) + r];
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    (points, triangles)
}

#[test]
fn height_problems_can_be_solved_on_their_own() {
    let (points, triangles) = strip(9);
    let tilt = |p: DVec2| 3.0 * p.x - p.y + 1.0;
    let is_edge = |i: usize| !(3..24).contains(&i) || i % 3 != 1;
    let fixed: Vec<Option<f64>> =
        points.iter().enumerate().map(|(i, &p)| is_edge(i).then_some(tilt(p))).collect();
    let rows: Vec<bool> = fixed.iter().map(Option::is_none).collect();
    let problem = HeightProblem { points: &points, triangles: &triangles, fixed: &fixed, rows: &rows };
    for smoothness in [
        Smoothness::Harmonic,
        Smoothness::Biharmonic { tension: 0.0 },
        Smoothness::Biharmonic { tension: 2.0 },
    ] {
        let heights = solve_heights(&problem, smoothness, &ReferenceSolver).unwrap();
        let worst = heights.iter().zip(&points).map(|(z, &p)| (z - tilt(p)).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-12, "{smoothness:?}: {worst:e}");
    }
    let loose = HeightProblem { fixed: &vec![None; 27], ..problem };
    let refused = solve_heights(&loose, Smoothness::Harmonic, &ReferenceSolver);
    assert!(matches!(refused, Err(SolveError::NotPositiveDefinite { .. })));
}
