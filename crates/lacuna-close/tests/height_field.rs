//! The surface of a cluster: what it keeps, what it ignores, what it continues.

use glam::DVec2;
use lacuna_close::{Datum, FieldError, FieldParams, HeightField, Region, height_field};
use lacuna_solve::{FaerSolver, ReferenceSolver};

/// Half the side of the square, and radius of the hole in its middle.
const HALF: i32 = 16;
const RADIUS: f64 = 9.5;

/// Where data are missing.
#[derive(Clone, Copy, PartialEq)]
enum Hole {
    /// A disk in the middle.
    Disk,
    /// A half-disk at the square's eastern edge, which is free.
    AtEdge,
}

/// A square of places 1 m apart, about, whose hole wants heights; `z` is the ground.
fn region(hole: Hole, shift: DVec2, z: impl Fn(DVec2) -> f64) -> Region {
    let side = 2 * HALF + 1;
    let shake = |k: i32| 0.15 * libm::sin(f64::from(k) * 12.9898);
    let place = |k: i32| {
        let even = DVec2::new(f64::from(k % side - HALF), f64::from(k / side - HALF));
        even + DVec2::new(shake(k), shake(k + 991))
    };
    let places: Vec<DVec2> = (0..side * side).map(place).collect();
    let centre = if hole == Hole::Disk { DVec2::ZERO } else { DVec2::new(f64::from(HALF), 0.0) };
    let depth = |p: DVec2| RADIUS - p.distance(centre);
    let datum = |p: DVec2| Datum { height_m: z(p), weight: 1.0, is_exact: depth(p) > -1.5 };
    let quads = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| j * side + i));
    let corners = |k: i32| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]];
    Region {
        data: places.iter().map(|&p| (depth(p) <= 0.0).then(|| datum(p))).collect(),
        places: places.iter().map(|&p| p + shift).collect(),
        triangles: quads.flat_map(corners).map(|t| t.map(|v| v as u32)).collect(),
        edge_m: 1.0,
        radius_m: RADIUS,
    }
}

fn solved(region: &Region) -> HeightField {
    height_field(region, &FieldParams::default(), &FaerSolver).expect("solved")
}

/// Mean error inside the hole.
fn mean_error(region: &Region, field: &HeightField, z: impl Fn(DVec2) -> f64) -> f64 {
    let wanted: Vec<usize> = (0..region.places.len()).filter(|&v| region.data[v].is_none()).collect();
    let sum: f64 = wanted.iter().map(|&v| (field.heights_m[v] - z(region.places[v])).abs()).sum();
    sum / wanted.len() as f64
}

/// Repeatable numbers in [-1, 1].
fn noise(k: usize) -> f64 {
    let mut x = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn hills(p: DVec2) -> f64 {
    2.0 * libm::sin(0.13 * p.x + 0.4) + 1.5 * libm::cos(0.11 * p.y - 0.2)
}

#[test]
fn a_plane_goes_on_through_holes_and_over_free_edges() {
    let plane = |p: DVec2| 7.0 + 0.3 * p.x - 0.2 * p.y;
    for hole in [Hole::Disk, Hole::AtEdge] {
        let region = region(hole, DVec2::ZERO, plane);
        let field = solved(&region);
        assert!(mean_error(&region, &field, plane) < 1e-6);
        assert_eq!((field.tension_steps, field.outlier_share), (0, 0.0));
    }
}

#[test]
fn exact_data_come_back_bit_for_bit() {
    let mut region = region(Hole::Disk, DVec2::ZERO, hills);
    let noisy = |(v, d): (usize, &mut Option<Datum>)| d.iter_mut().for_each(|d| d.height_m += 0.3 * noise(v));
    region.data.iter_mut().enumerate().for_each(noisy);
    let field = solved(&region);
    for (datum, z) in region.data.iter().zip(&field.heights_m) {
        if let Some(d) = datum.filter(|d| d.is_exact) {
            assert_eq!(d.height_m.to_bits(), z.to_bits());
        }
    }
}

#[test]
fn ground_bends_on_into_the_hole() {
    let region = region(Hole::Disk, DVec2::ZERO, hills);
    let error = mean_error(&region, &solved(&region), hills);
    let soap = FieldParams { tension: Some(1e6), ..FieldParams::default() };
    let film = height_field(&region, &soap, &FaerSolver).expect("solved");
    let of_film = mean_error(&region, &film, hills);
    assert!(error < 0.4 * of_film, "{error} against {of_film} of a soap film");
}

#[test]
fn outliers_do_not_pull_the_surface() {
    for percent in [5, 15] {
        let mut region = region(Hole::Disk, DVec2::ZERO, hills);
        let clean = mean_error(&region, &solved(&region), hills);
        for (v, datum) in region.data.iter_mut().enumerate() {
            if let Some(d) = datum.as_mut().filter(|_| v * 7919 % 100 < percent) {
                d.height_m += 2.0 + noise(v);
            }
        }
        let field = solved(&region);
        let error = mean_error(&region, &field, hills);
        assert!(error < clean + 0.15, "{percent} %: {error} against {clean}");
        let share = percent as f64 / 100.0;
        assert!((0.5 * share..1.5 * share).contains(&field.outlier_share), "{}", field.outlier_share);
    }
}

#[test]
fn noise_asks_for_smoothing_and_clean_ground_for_none() {
    let clean = region(Hole::Disk, DVec2::ZERO, |p| hills(p * 3.0));
    let mut noisy = region(Hole::Disk, DVec2::ZERO, hills);
    let disturb =
        |(v, d): (usize, &mut Option<Datum>)| d.iter_mut().for_each(|d| d.height_m += 0.5 * noise(v));
    noisy.data.iter_mut().enumerate().for_each(disturb);
    let [clean, noisy] = [&clean, &noisy].map(|r| solved(r).smoothing_edges);
    assert!(clean < noisy, "{clean} and {noisy} edges");
}

#[test]
fn a_surface_that_shoots_up_is_held_back() {
    // A cone's foot: all slopes point up into the hole.
    let cone = |p: DVec2| 3.0 * (12.0 - p.length()).min(2.0);
    let region = region(Hole::Disk, DVec2::ZERO, cone);
    let highest = |overshoot| {
        let params = FieldParams { overshoot, ..FieldParams::default() };
        let field = height_field(&region, &params, &FaerSolver).expect("solved");
        let inside = (0..region.places.len()).filter(|&v| region.data[v].is_none());
        (inside.map(|v| field.heights_m[v]).fold(f64::NEG_INFINITY, f64::max), field.tension_steps)
    };
    let known = region.data.iter().flatten().map(|d| d.height_m);
    let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    let allowed = high + 0.05 * (high - low) + 0.05;
    let (free, steps) = highest(f64::INFINITY);
    assert!(free > allowed && steps == 0, "{free} m of {allowed} m after {steps} steps");
    let (held, steps) = highest(0.05);
    assert!(held <= allowed + 1e-9 && steps > 0, "{held} m of {allowed} m after {steps} steps");
}

#[test]
fn the_place_of_the_scene_and_the_solver_do_not_matter() {
    let here = region(Hole::AtEdge, DVec2::ZERO, hills);
    let far =
        Region { places: here.places.iter().map(|&p| p + DVec2::new(5e5, -4e6)).collect(), ..here.clone() };
    let first = solved(&here).heights_m;
    let others = [
        (solved(&far).heights_m, 1e-6),
        (height_field(&here, &FieldParams::default(), &ReferenceSolver).expect("solved").heights_m, 1e-7),
    ];
    for (other, tolerance) in others {
        let largest = first.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < tolerance, "{largest}");
    }
}

#[test]
fn a_part_without_data_is_an_error() {
    let mut region = region(Hole::Disk, DVec2::ZERO, hills);
    region.data.fill(None);
    let refused = height_field(&region, &FieldParams::default(), &FaerSolver);
    assert_eq!(refused, Err(FieldError::NoData));
}

#[test]
fn turned_scenes_have_turned_surfaces() {
    let region = region(Hole::Disk, DVec2::ZERO, hills);
    let turned = Region { places: region.places.iter().map(|p| p.perp()).collect(), ..region.clone() };
    let mirrored = Region {
        places: region.places.iter().map(|p| DVec2::new(-p.x, p.y)).collect(),
        triangles: region.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..region.clone()
    };
    let first = solved(&region).heights_m;
    for other in [turned, mirrored] {
        let heights = solved(&other).heights_m;
        let largest = first.iter().zip(&heights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < 1e-7, "{largest}");
    }
}

#[test]
fn a_region_over_the_limit_gets_nearly_the_same_surface() {
    for hole in [Hole::Disk, Hole::AtEdge] {
        let mut region = region(hole, DVec2::ZERO, hills);
        for (v, datum) in region.data.iter_mut().enumerate() {
            if let Some(d) = datum.as_mut().filter(|_| v % 23 == 0) {
                d.height_m += 0.5 * noise(v);
            }
        }
        // Given, for parts of a region this small tell too little to choose by.
        let given = FieldParams { smoothing_edges: Some(0.35), tension: Some(1.0), ..FieldParams::default() };
        let whole = height_field(&region, &given, &FaerSolver).expect("solved");
        let error = mean_error(&region, &whole, hills);
        for share in [2, 4] {
            let max_unknowns = region.places.len() / share;
            let params = FieldParams { max_unknowns, ..given };
            let field = height_field(&region, &params, &FaerSolver).expect("solved");
            assert!(field.unknowns <= max_unknowns);
            let coarse_error = mean_error(&region, &field, hills);
            assert!(coarse_error < 1.03 * error, "1/{share}: {coarse_error} against {error}");
        }
    }
}
