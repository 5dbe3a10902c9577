//! Every boundary edge has one owner: a hole's rim or island, the border, or something that is no hole.

mod kit;

use glam::{DVec2, DVec3};
use kit::{CELL_M, Planned, Scene, Step, append, lattice};
use lacuna_grid::{CellId, Grid, Side};
use lacuna_hole::CellSurvey;
use lacuna_mesh::TriMesh;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// How often each boundary edge of a cell is on the rim of a hole or an island.
fn claims(planned: &Planned, survey: &CellSurvey) -> Vec<u32> {
    let mut claims = vec![0; survey.boundary.edges.len()];
    for hole in planned.plan.holes.iter().filter(|h| h.cell == survey.cell) {
        hole.rim_edges(survey).for_each(|e| claims[e as usize] += 1);
    }
    claims
}

fn check_no_edge_twice(planned: &Planned) {
    for survey in planned.surveys.values() {
        let claims = claims(planned, survey);
        assert!(claims.iter().all(|&c| c <= 1), "{}: {:?}", survey.cell, kit::lines(&planned.plan));
    }
}

/// What is on no hole and not on the border are whole loops, and the plan counts each of them as no hole.
fn check_every_edge(planned: &Planned) {
    let mut others = 0;
    for (cell, survey) in &planned.surveys {
        let claims = claims(planned, survey);
        let domain = &planned.plan.domains[cell];
        let on_border = |e: u32| {
            let ends = [survey.from(e), survey.to(e)].map(|p| p.truncate());
            Side::ALL.iter().any(|&s| ends.iter().all(|p| domain.outside_m(s, *p).abs() < 1e-6))
        };
        for l in &survey.loops {
            let is_claimed = l.edges.iter().filter(|&&e| claims[e as usize] == 1).count();
            let is_border = l.edges.iter().filter(|&&e| claims[e as usize] == 0 && on_border(e)).count();
            let left = l.edges.len() - is_claimed - is_border;
            assert!(left == 0 || left == l.edges.len(), "{cell}: {left} of {} edges", l.edges.len());
            others += u32::from(left > 0);
        }
        let in_loops: usize = survey.loops.iter().map(|l| l.edges.len()).sum();
        assert_eq!(in_loops, survey.boundary.edges.len(), "{cell}");
    }
    assert_eq!(others, planned.plan.not_holes.values().sum::<u32>(), "{:?}", planned.plan.not_holes);
}

fn discs() -> impl Strategy<Value = Vec<Step>> {
    let disc = (0.0..24.0f64, 0.0..24.0f64, 0.4..4.0f64, prop::bool::weighted(0.8));
    let step = disc.prop_map(
        |(x, y, r, is_cut)| {
            if is_cut { Step::CutDisc(x, y, r) } else { Step::KeepDisc(x, y, 0.6 * r) }
        },
    );
    prop::collection::vec(step, 1..14)
}

/// Loose triangles: the column and row of a cell, and corners within it.
fn fragments() -> impl Strategy<Value = Vec<(i32, i32, [DVec3; 3])>> {
    let number = || 0.5..CELL_M - 0.5;
    let corner = || (number(), number(), -3.0..12.0f64).prop_map(DVec3::from);
    let triangle = (0..3i32, 0..3i32, [corner(), corner(), corner()]);
    prop::collection::vec(triangle, 0..8)
}

/// A scene with loose triangles in it, those that face down among them.
fn with_fragments(mut scene: Scene, fragments: &[(i32, i32, [DVec3; 3])]) -> Scene {
    for &(i, j, corners) in fragments {
        let low = DVec3::new(f64::from(i), f64::from(j), 0.0) * CELL_M;
        let positions = corners.map(|c| low + c).to_vec();
        append(scene.tile(i, j), TriMesh { positions, triangles: vec![[0, 1, 2]] });
    }
    scene
}

/// Triangles at random over few places, some of them outside the cell: nothing about them is sound.
fn soup() -> impl Strategy<Value = TriMesh> {
    let number = || (-2..11i32).prop_map(f64::from);
    let place = (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, 0.25 * z));
    (prop::collection::vec(place, 3..30), prop::collection::vec([0..30u32, 0..30, 0..30], 1..60)).prop_map(
        |(positions, triangles)| {
            let count = positions.len() as u32;
            let triangles = triangles.into_iter().map(|t| t.map(|v| v % count)).collect();
            TriMesh { positions, triangles }
        },
    )
}

fn settings(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_130_802),
        failure_persistence: None,
        ..Default::default()
    }
}

proptest! {
    #![proptest_config(settings(200))]

    #[test]
    fn punched_holes(steps in discs(), fragments in fragments()) {
        let planned = with_fragments(lattice(3, 3, 0.25, &steps), &fragments).plan();
        check_no_edge_twice(&planned);
        check_every_edge(&planned);
    }

    #[test]
    fn punched_holes_on_a_raster(steps in discs()) {
        let planned = lattice(3, 3, 0.0, &steps).plan();
        check_no_edge_twice(&planned);
        check_every_edge(&planned);
    }

    #[test]
    fn triangles_at_random(west in soup(), east in soup()) {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: CELL_M };
        let shifted = TriMesh {
            positions: east.positions.iter().map(|p| *p + DVec3::X * CELL_M).collect(),
            ..east
        };
        let tiles = [(CellId::new(0, 0), west), (CellId::new(1, 0), shifted)].into();
        let planned = Scene::new(grid, tiles).plan();
        check_no_edge_twice(&planned);
        prop_assert!(planned.plan.holes.iter().all(|h| h.area_m2.is_finite() && h.perimeter_m.is_finite()));
    }
}
