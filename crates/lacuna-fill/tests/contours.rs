//! Every contour of the table, as it is and changed: turned, mirrored, moved, started elsewhere.

mod common;

use common::{assert_sound, cases, contour_of, mapped, mirrored, started_at, turned};
use glam::DVec3;
use lacuna_fill::{FillError, FillParams, Filled, FillerChoice, HeightRule, fill};
use lacuna_mesh::Contour;
use lacuna_solve::{FaerSolver, ReferenceSolver};
use proptest::prelude::*;

fn run(contour: &Contour) -> Result<Filled, FillError> {
    fill(contour, &FillParams::default(), &FaerSolver)
}

/// Fills and checks; the outcome must be the expected filler, or a refusal.
fn assert_outcome(name: &str, contour: &Contour, expect: &str) -> Option<Filled> {
    match run(contour) {
        Ok(done) => {
            assert_eq!(done.filler.to_string(), expect, "{name}");
            assert_sound(name, contour, &done);
            Some(done)
        }
        Err(e) => {
            assert_eq!(expect, "refused", "{name}: {e}");
            assert!(e.is_refusal(), "{name}: {e}");
            None
        }
    }
}

#[test]
fn every_contour_has_its_outcome() {
    for case in cases() {
        assert_outcome(&case.name, &case.contour, &case.expect);
    }
}

#[test]
fn turned_mirrored_moved_and_renumbered_contours_have_the_same_outcome() {
    for case in cases() {
        let name = &case.name;
        for degrees in [17.0, 90.0, 180.0, 271.3] {
            // Turning rounds coordinates: places that were one in plan must stay one.
            assert_outcome(
                &format!("{name} turned {degrees}"),
                &turned(&case.contour, degrees),
                &case.expect,
            );
        }
        assert_outcome(&format!("{name} mirrored"), &mirrored(&case.contour), &case.expect);
        let far = mapped(&case.contour, |p| p + DVec3::new(5e5, -4.6e6, 100.0));
        if name != "tiny" {
            assert_outcome(&format!("{name} moved"), &far, &case.expect);
        }
        for by in [1, 5] {
            assert_outcome(&format!("{name} from {by}"), &started_at(&case.contour, by), &case.expect);
        }
    }
}

#[test]
fn moving_by_whole_metres_changes_hardly_a_triangle() {
    // Coordinates on a lattice of 2^-10 m: adding whole metres is exact. About as many triangles must come out: ties
    // may fall otherwise, since new vertices are rounded where they are written.
    for case in cases().into_iter().filter(|c| c.expect == "delaunay" && c.name != "tiny") {
        let snapped = mapped(&case.contour, |p| (p * 1024.0).round() / 1024.0);
        let Ok(here) = run(&snapped) else { continue };
        let there = run(&mapped(&snapped, |p| p + DVec3::new(4096.0, -8192.0, 0.0))).unwrap();
        let difference = here.patch.triangles.len().abs_diff(there.patch.triangles.len());
        assert!(difference * 50 <= here.patch.triangles.len(), "{}: {difference}", case.name);
    }
}

#[test]
fn a_convex_contour_without_new_vertices_has_n_minus_2_triangles_however_it_is_turned() {
    let ring: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i), f64::from(i * i) * 0.1, 0.0)).collect();
    let contour = contour_of(&[ring]);
    let params = FillParams { spacing_m: Some(1e6), growth: 10.0, ..FillParams::default() };
    for degrees in [0.0, 33.0, 123.0, 250.0] {
        let done = fill(&turned(&contour, degrees), &params, &FaerSolver).unwrap();
        assert_eq!((done.patch.vertices.len(), done.patch.triangles.len()), (0, 7));
    }
}

#[test]
fn graded_patches_are_well_shaped() {
    for name in ["convex", "l_shape", "star", "ragged", "island_1", "spiral"] {
        let done = run(&common::case(name)).unwrap();
        let q = done.quality;
        assert!(q.mean >= 0.85 && q.share_good >= 0.97, "{name}: mean {}, good {}", q.mean, q.share_good);
    }
    // Kept rim edges of 2 m next to ones of 2 cm have no well-shaped triangle.
    let q = run(&common::case("uneven")).unwrap().quality;
    assert!(q.mean >= 0.85 && q.share_good >= 0.93, "uneven: mean {}, good {}", q.mean, q.share_good);
}

#[test]
fn spacing_and_growth_set_the_density() {
    let contour = common::case("convex");
    let count = |spacing_m, growth| {
        let params = FillParams { spacing_m, growth, ..FillParams::default() };
        fill(&contour, &params, &FaerSolver).unwrap().patch.vertices.len()
    };
    let (graded, rim, fine) = (count(None, 0.3), count(None, 0.0), count(Some(0.4), 0.0));
    // Area 188 m2, rim edges of about 1.06 m: an even hexagonal pattern has area / (0.866 h^2) vertices.
    assert!(graded * 2 < rim, "{graded} {rim} {fine}");
    assert!((120..240).contains(&rim), "rim {rim}");
    assert!((900..1700).contains(&fine), "fine {fine}");
}

#[test]
fn existing_edges_are_avoided() {
    // Every chord between vertices two apart exists behind the rim (ears).
    let mut contour = common::case("convex");
    let n = contour.len() as u32;
    contour.forbidden_edges = (0..n).map(|i| [i.min((i + 2) % n), i.max((i + 2) % n)]).collect();
    contour.forbidden_edges.sort_unstable();
    let mut square = contour_of(&[vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]]);
    square.forbidden_edges = vec![[0, 2], [1, 3]];
    for (name, contour) in [("convex", contour), ("square", square)] {
        for growth in [0.0, 0.3] {
            let params = FillParams { growth, ..FillParams::default() };
            let done = fill(&contour, &params, &FaerSolver).unwrap();
            assert_sound(name, &contour, &done);
        }
    }
}

#[test]
fn existing_edges_are_avoided_whatever_name_their_ends_have() {
    // Two squares that meet in a corner, whose vertices 0 and 4 are one; all four diagonals exist.
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.1 * x * y);
    let squares = vec![
        at(0., 0.),
        at(4., 0.),
        at(4., 4.),
        at(0., 4.),
        at(0., 0.),
        at(-4., 0.),
        at(-4., -4.),
        at(0., -4.),
    ];
    let mut contour = contour_of(&[squares]);
    let coarse = FillParams { spacing_m: Some(1e6), growth: 10.0, ..FillParams::default() };
    assert_eq!(fill(&contour, &coarse, &FaerSolver).unwrap().patch.triangles.len(), 4);
    contour.forbidden_edges = vec![[0, 6], [1, 3], [2, 4], [5, 7]];
    let done = fill(&contour, &coarse, &FaerSolver).unwrap();
    assert_sound("squares", &contour, &done);
    assert_eq!(done.patch.vertices.len(), 2);
}

#[test]
fn walls_round_an_island_are_no_reason_to_refuse() {
    // A raster's step behind every rim edge, and one side of the rim on a roof: neither upright nor flat.
    let mut contour = common::case("touch_once");
    let lifted = |p: DVec3| if p.y < -4.0 { p + DVec3::Z * 40.0 } else { p };
    contour = mapped(&contour, lifted);
    for ring in std::iter::once(&mut contour.outer).chain(&mut contour.inner) {
        for (edge, vertex) in ring.edges.iter_mut().zip(&ring.vertices) {
            edge.apex = Some(vertex.position + DVec3::new(0.01, 0.01, 9.0));
        }
    }
    let done = assert_outcome("walls", &contour, "delaunay").unwrap();
    assert!(done.in_plan && done.vertical.is_empty());
    let facade = mapped(&contour, |p| DVec3::new(p.x, 0.05 * p.y + 0.4 * p.z, p.y));
    assert_outcome("facade with an island", &facade, "refused");
}

#[test]
fn refusals_say_what_crosses_and_where() {
    // A rim of 600 vertices that loops over itself: too large for a pocket, too long for a triangulation in space.
    let loop_at = |i: u32| {
        let t = std::f64::consts::TAU * f64::from(i) / 600.0;
        let r = 10.0 + 12.0 * libm::cos(t);
        DVec3::new(r * libm::cos(t), r * libm::sin(t), libm::sin(3.0 * t))
    };
    let limacon = contour_of(&[(0..600).map(loop_at).collect()]);
    let mut across = common::case("touch_once");
    across.inner[0].vertices.iter_mut().for_each(|v| v.position.x += 1.25);
    let crossing = common::case("crossing_in_vertices");
    for (name, contour, words) in [
        ("limacon", limacon, "no chord cuts off what hangs over"),
        ("island across", across, "an island hangs over another ring"),
        ("crossing in vertices", started_at(&crossing, 3), "cross each other in a vertex"),
    ] {
        let said = run(&contour).unwrap_err().to_string();
        assert!(said.contains(words) && said.contains(" at "), "{name}: {said}");
    }
}

#[test]
fn pockets_are_recorded() {
    for (name, least) in [("vertical_edges", 3), ("overhang", 2), ("duplicate_xy", 2)] {
        let done = run(&common::case(name)).unwrap();
        assert!(done.vertical.len() >= least, "{name}: {:?}", done.vertical);
        assert!(done.vertical.is_sorted());
    }
}

#[test]
fn both_solvers_give_nearly_the_same_patch() {
    for name in ["ragged", "islands_3", "steep_roof", "saddle"] {
        let contour = common::case(name);
        let params = FillParams::default();
        let one = fill(&contour, &params, &FaerSolver).unwrap();
        let two = fill(&contour, &params, &ReferenceSolver).unwrap();
        assert_eq!(one.patch.triangles, two.patch.triangles, "{name}");
        let far = one.patch.vertices.iter().zip(&two.patch.vertices).map(|(p, q)| p.distance(*q));
        assert!(far.fold(0.0, f64::max) < 1e-6, "{name}");
    }
}

#[test]
fn equal_input_gives_equal_bits() {
    for case in cases() {
        let (one, two) = (run(&case.contour), run(&case.contour));
        assert_eq!(one, two, "{}", case.name);
    }
}

#[test]
fn minimum_area_takes_rings_in_space_and_refuses_the_rest() {
    let params = FillParams { filler: FillerChoice::MinArea, growth: 0.0, ..FillParams::default() };
    for name in ["convex", "l_shape", "ragged", "saddle", "facade", "vertical_edges"] {
        let contour = common::case(name);
        let done = fill(&contour, &params, &FaerSolver).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_sound(name, &contour, &done);
        assert!(done.patch.vertices.len() > 20 || name == "facade", "{name}: {}", done.patch.vertices.len());
    }
    let refusal = |name: &str| fill(&common::case(name), &params, &FaerSolver).unwrap_err();
    assert_eq!(refusal("island_1"), FillError::IslandsIn3d);
    assert_eq!(refusal("two_lobes"), FillError::TouchingIn3d);
    let large: Vec<DVec3> = (0..501).map(|i| DVec3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
    let refused = fill(&contour_of(&[large]), &params, &FaerSolver).unwrap_err();
    assert_eq!(refused, FillError::TooManyVertices { vertices: 501, limit: 500 });
}

#[test]
fn nonsense_is_refused_in_words() {
    let square = vec![DVec3::ZERO, DVec3::X * 4.0, DVec3::new(4.0, 4.0, 0.0), DVec3::Y * 4.0];
    let reversed: Vec<DVec3> = square.iter().rev().copied().collect();
    let small: Vec<DVec3> = reversed.iter().map(|p| *p * 0.25 + DVec3::new(1.0, 1.0, 0.0)).collect();
    let outside: Vec<DVec3> = small.iter().map(|p| *p + DVec3::X * 9.0).collect();
    let across: Vec<DVec3> = small.iter().map(|p| *p + DVec3::X * 2.5).collect();
    let within: Vec<DVec3> = small.iter().map(|p| p.lerp(DVec3::new(1.5, 1.5, 0.0), 0.5)).collect();
    let table = [
        ("two vertices", vec![vec![DVec3::ZERO, DVec3::X]], "2 vertices"),
        ("not finite", vec![vec![DVec3::ZERO, DVec3::X, DVec3::NAN]], "not finite"),
        ("clockwise", vec![reversed], "wrong way round"),
        ("no area", vec![vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0]], "stands upright"),
        ("island outside", vec![square.clone(), outside], "outside"),
        ("island across", vec![square.clone(), across], "hangs over another ring"),
        ("island in island", vec![square.clone(), small.clone(), within], "another island"),
        ("island twice", vec![square.clone(), small.clone(), small], "two edges join"),
        ("vertex twice in a row", vec![[&square[..1], &square[..]].concat()], "no length"),
    ];
    for (name, rings, words) in table {
        let contour = contour_of(&rings);
        let params = FillParams { filler: FillerChoice::Delaunay, ..FillParams::default() };
        let refused = fill(&contour, &params, &FaerSolver).map(|d| d.filler).unwrap_err();
        assert!(refused.to_string().contains(words), "{name}: {refused}");
    }
    let too_fine = FillParams { max_vertices: 10, ..FillParams::default() };
    let refused = fill(&common::case("convex"), &too_fine, &FaerSolver).unwrap_err();
    assert_eq!(refused, FillError::CapReached { limit: 10 });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn random_stars_with_islands_are_filled_soundly(
        radii in prop::collection::vec(4.0f64..10.0, 6..80),
        island in prop::collection::vec(0.5f64..3.0, 3..20),
        heights in prop::collection::vec(-1.0f64..1.0, 7),
        growth in 0.0f64..0.5,
        harmonic in any::<bool>(),
    ) {
        let place = |i: usize, n: usize, r: f64, turn: f64| {
            let t = turn * std::f64::consts::TAU * i as f64 / n as f64;
            DVec3::new(r * libm::cos(t), r * libm::sin(t), heights[i % 7])
        };
        let ring = |radii: &[f64], turn: f64| -> Vec<DVec3> {
            radii.iter().enumerate().map(|(i, &r)| place(i, radii.len(), r, turn)).collect()
        };
        let contour = contour_of(&[ring(&radii, 1.0), ring(&island, -1.0)]);
        let heights = if harmonic { HeightRule::Harmonic } else { HeightRule::Biharmonic };
        let params = FillParams { growth, heights, ..FillParams::default() };
        match fill(&contour, &params, &FaerSolver) {
            Ok(done) => {
                assert_sound("star", &contour, &done);
                prop_assert!(done.in_plan);
            }
            // A coarse ring's chords can cut across the other ring.
            Err(e) => prop_assert!(matches!(e, FillError::CrossingRim { .. }), "{e}"),
        }
    }
}
