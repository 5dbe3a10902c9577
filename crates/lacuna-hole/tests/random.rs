//! Random lakes of discs over 3 x 3 cells: what is missing is found, to the square millimetre.

mod kit;

use kit::{Planned, Scene, Step, lattice};
use lacuna_hole::{HoleClass, Piece, Span};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn discs() -> impl Strategy<Value = Vec<Step>> {
    let disc = (0.0..24.0f64, 0.0..24.0f64, 0.4..6.0f64, prop::bool::weighted(0.75));
    let step = disc.prop_map(
        |(x, y, r, is_cut)| {
            if is_cut { Step::CutDisc(x, y, r) } else { Step::KeepDisc(x, y, 0.6 * r) }
        },
    );
    prop::collection::vec(step, 1..12)
}

fn settings(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_210_731),
        failure_persistence: None,
        ..Default::default()
    }
}

/// Border pieces never follow each other but round a corner, and every hole has a rim or is hollow.
fn check_walks(planned: &Planned) {
    for hole in &planned.plan.holes {
        let n = hole.outer.len();
        for (k, piece) in hole.outer.iter().enumerate() {
            let next = &hole.outer[(k + 1) % n];
            match (piece, next) {
                (Piece::Rim(_), Piece::Rim(_)) => assert_eq!(n, 1, "{hole:?}: two rims in a row"),
                (Piece::Side { corner_after, .. }, Piece::Rim(_)) => assert!(!corner_after, "{hole:?}"),
                (Piece::Side { corner_after, .. }, Piece::Side { .. }) => assert!(corner_after, "{hole:?}"),
                _ => {}
            }
        }
        check_chains(planned, hole);
    }
}

/// Rim edges follow each other, and so do adopted edges.
fn check_chains(planned: &Planned, hole: &lacuna_hole::Hole) {
    let follows = |cell, edges: &[u32]| {
        let survey = &planned.surveys[&cell];
        edges.windows(2).all(|w| survey.to(w[0]) == survey.from(w[1]))
    };
    for piece in &hole.outer {
        match piece {
            Piece::Rim(edges) => assert!(!edges.is_empty() && follows(hole.cell, edges), "{hole:?}"),
            Piece::Side { spans, .. } => {
                assert!(!spans.is_empty() || hole.leave.is_some(), "{hole:?}");
                for span in spans {
                    if let Span::Adopted { neighbour, edges } = span {
                        assert!(follows(*neighbour, edges), "{hole:?}");
                    }
                }
            }
            Piece::Bridge => {}
        }
    }
}

/// The areas add up to what was taken out.
fn check_area(scene: &Scene, planned: &Planned) {
    let found: f64 = planned.plan.holes.iter().map(|h| h.area_m2).sum();
    let debris = debris_m2(planned);
    let expected = scene.removed_m2 + debris;
    let message = || format!("found {found}, taken out {expected}: {:#?}", kit::lines(&planned.plan));
    assert!((found - expected).abs() <= 1e-9 * expected.max(1.0), "{}", message());
    let clusters: f64 = planned.plan.clusters.iter().map(|c| c.area_m2).sum();
    assert!((found - clusters).abs() <= 1e-9 * found.max(1.0));
}

/// Plan area of small pieces inside holes: they are no islands, so holes count them in.
fn debris_m2(planned: &Planned) -> f64 {
    let islands: Vec<_> =
        planned.plan.holes.iter().flat_map(|h| h.islands.iter().map(|&l| (h.cell, l))).collect();
    let mut sum = 0.0;
    for (&cell, survey) in &planned.surveys {
        for (k, l) in survey.loops.iter().enumerate() {
            let touches_border = l.edges.iter().any(|&e| {
                let domain = &planned.plan.domains[&cell];
                let near = |p: glam::DVec2| {
                    lacuna_grid::Side::ALL.iter().any(|&s| domain.outside_m(s, p).abs() < 1e-6)
                };
                near(survey.from(e).truncate()) && near(survey.to(e).truncate())
            });
            if l.vector_area.z < 0.0 && !touches_border && !islands.contains(&(cell, k as u32)) {
                sum += l.vector_area.z.abs();
            }
        }
    }
    sum
}

/// Clusters and layers refer to each other.
fn check_clusters(planned: &Planned) {
    let plan = &planned.plan;
    for (c, cluster) in plan.clusters.iter().enumerate() {
        assert!(cluster.holes.iter().all(|&h| plan.holes[h as usize].cluster == c as u32));
        let is_external = |h: &u32| matches!(plan.holes[*h as usize].class, HoleClass::External(_));
        assert_eq!(cluster.is_external, cluster.holes.iter().any(is_external));
        assert_eq!(cluster.leave, cluster.holes.iter().filter_map(|&h| plan.holes[h as usize].leave).max());
        assert!(cluster.leave.is_none(), "{:?}", cluster.leave);
    }
    assert_eq!(plan.clusters.iter().map(|c| c.holes.len()).sum::<usize>(), plan.holes.len());
    assert!(plan.holes.iter().all(|h| h.layer >= 1));
    assert_eq!(plan.unclear_stretches, 0);
}

proptest! {
    #![proptest_config(settings(300))]

    #[test]
    fn discs_on_a_raster(steps in discs()) {
        let scene = lattice(3, 3, 0.0, &steps);
        let planned = scene.plan();
        check_walks(&planned);
        check_area(&scene, &planned);
        check_clusters(&planned);
    }

    #[test]
    fn discs_on_a_jittered_lattice(steps in discs()) {
        let scene = lattice(3, 3, 0.25, &steps);
        let planned = scene.plan();
        check_walks(&planned);
        check_area(&scene, &planned);
        check_clusters(&planned);
    }
}
