//! What the plan says of borders: adopted edges, curves, corners, clusters.

mod kit;

use glam::DVec2;
use kit::{CELL_M, Limit, Planned, Scene, Step, block, cut, keep, lattice, lines};
use lacuna_grid::{CellId, CornerId, Grid, Side};
use lacuna_hole::{Anchor, ClusterRule, CurveKind, Hole, Leave, Piece, Span};
use std::collections::BTreeMap;

/// The spans of a hole on one side, in walking order.
fn spans(hole: &Hole, on: Side) -> Vec<&Span> {
    let pieces = hole.outer.iter().filter_map(|p| match p {
        Piece::Side { side, spans, .. } if *side == on => Some(spans),
        _ => None,
    });
    pieces.flatten().collect()
}

/// The positions that a span of adopted edges passes.
fn adopted(planned: &Planned, span: &Span) -> Vec<[f64; 3]> {
    let Span::Adopted { neighbour, edges } = span else { panic!("{span:?} is not adopted") };
    let survey = &planned.surveys[neighbour];
    let start = edges.first().map(|&e| survey.from(e));
    start.into_iter().chain(edges.iter().map(|&e| survey.to(e))).map(|p| p.to_array()).collect()
}

#[test]
fn a_covered_neighbour_lends_its_vertices() {
    for (side, rect, neighbour) in [
        (Side::East, (13.0, 10.0, 16.0, 13.0), (2, 1)),
        (Side::West, (8.0, 10.0, 11.0, 13.0), (0, 1)),
        (Side::North, (10.0, 13.0, 13.0, 16.0), (1, 2)),
        (Side::South, (10.0, 8.0, 13.0, 11.0), (1, 0)),
    ] {
        let planned = lattice(3, 3, 0.2, &[cut(rect.0, rect.1, rect.2, rect.3)]).plan();
        let hole = &planned.plan.holes[0];
        let found = spans(hole, side);
        assert_eq!(found.len(), 1, "{side:?}");
        let Span::Adopted { neighbour: lender, edges } = found[0] else { panic!("{side:?}: {found:?}") };
        assert_eq!((lender.i, lender.j, edges.len()), (neighbour.0, neighbour.1, 3), "{side:?}");
        let points = adopted(&planned, found[0]);
        assert_eq!(points.first().copied(), Some(chain_end(&planned, hole, true)), "{side:?}");
        assert_eq!(points.last().copied(), Some(chain_end(&planned, hole, false)), "{side:?}");
        assert!(planned.plan.curves.is_empty());
    }
}

/// Last (first) position of the hole's only rim.
fn chain_end(planned: &Planned, hole: &Hole, last: bool) -> [f64; 3] {
    let rims: Vec<&Vec<u32>> = hole
        .outer
        .iter()
        .filter_map(|p| match p {
            Piece::Rim(edges) => Some(edges),
            _ => None,
        })
        .collect();
    assert_eq!(rims.len(), 1);
    let survey = &planned.surveys[&hole.cell];
    let end = if last { survey.to(*rims[0].last().unwrap()) } else { survey.from(rims[0][0]) };
    end.to_array()
}

#[test]
fn a_hollow_cell_is_closed_by_its_four_neighbours() {
    for steps in [[Step::Missing(1, 1)], [Step::Empty(1, 1)]] {
        let planned = lattice(3, 3, 0.2, &steps).plan();
        let hole = &planned.plan.holes[0];
        let counts: Vec<usize> =
            Side::ALL.iter().map(|&s| adopted(&planned, spans(hole, s)[0]).len()).collect();
        assert_eq!(counts, [9, 9, 9, 9]);
        assert!(planned.plan.curves.is_empty());
        assert_eq!(hole.leave, None);
        assert!((hole.perimeter_m - 4.0 * CELL_M).abs() < 1e-9);
    }
}

#[test]
fn partly_open_partly_covered() {
    // East of the border the hole reaches from 11 to 12 only.
    let planned = lattice(3, 3, 0.0, &[cut(13.0, 10.0, 16.0, 14.0), cut(16.0, 11.0, 18.0, 12.0)]).plan();
    assert_eq!(lines(&planned.plan), ["1,1 I-B L1 #0 12", "2,1 I-B L1 #0 2"]);
    let found = spans(&planned.plan.holes[0], Side::East);
    let kinds: Vec<bool> = found.iter().map(|s| matches!(s, Span::Curve(_))).collect();
    assert_eq!(kinds, [false, true, false]);
    assert_eq!(adopted(&planned, found[0]).len(), 2);
    assert_eq!(adopted(&planned, found[2]).len(), 3);
    let curve = &planned.plan.curves[0];
    assert_eq!((curve.low_m, curve.high_m, curve.line), (11.0, 12.0, 16.0));
    // The curve ends at the rim of the narrower hole.
    let ends = [curve.low, curve.high].map(|a| matches!(a, Anchor::Point(c, _) if c == CellId::new(2, 1)));
    assert_eq!(ends, [true, true]);
}

#[test]
fn both_holes_name_one_curve() {
    let planned = lattice(3, 3, 0.2, &[cut(6.0, 9.0, 18.0, 14.0), keep(11.0, 9.0, 12.0, 14.0)]).plan();
    let plan = &planned.plan;
    assert_eq!(plan.curves.len(), 2);
    for (c, curve) in plan.curves.iter().enumerate() {
        assert_eq!(curve.kind, CurveKind::Shared);
        assert_eq!(curve.holes.len(), 2);
        for &h in &curve.holes {
            let names = Side::ALL
                .iter()
                .flat_map(|&s| spans(&plan.holes[h as usize], s))
                .filter(|s| **s == Span::Curve(c as u32))
                .count();
            assert_eq!(names, 1, "curve {c}, hole {h}");
        }
        let cells = curve.border.cells();
        assert!(curve.holes.iter().all(|&h| cells.contains(&plan.holes[h as usize].cell)));
    }
}

#[test]
fn a_hole_over_a_grid_corner_has_curves_to_the_corner() {
    let planned = lattice(3, 3, 0.2, &[cut(14.0, 14.0, 18.0, 18.0)]).plan();
    let corner = CornerId { i: 2, j: 2 };
    assert_eq!(planned.plan.curves.len(), 4);
    for curve in &planned.plan.curves {
        let at_corner = [curve.low, curve.high].iter().filter(|a| **a == Anchor::Corner(corner)).count();
        assert_eq!(at_corner, 1, "{curve:?}");
    }
    assert_eq!(planned.plan.corner_vertex(corner), None);
    assert!(planned.plan.corner_vertex(CornerId { i: 1, j: 1 }).is_some());
}

#[test]
fn a_corner_that_only_the_diagonal_cell_has() {
    // Three of the four cells are open round the corner; the fourth has its vertex there.
    let planned = lattice(3, 3, 0.2, &[cut(14.0, 14.0, 18.0, 18.0), keep(16.0, 16.0, 18.0, 18.0)]).plan();
    let corner = CornerId { i: 2, j: 2 };
    assert_eq!(planned.plan.holes.len(), 3);
    assert_eq!(planned.plan.clusters.len(), 1);
    assert!(
        matches!(planned.plan.corner_vertex(corner), Some(Anchor::Point(c, _)) if c == CellId::new(2, 2))
    );
}

#[test]
fn holes_that_meet_in_a_corner_alone_stay_two() {
    let planned = lattice(3, 3, 0.2, &[cut(14.0, 14.0, 16.0, 16.0), cut(16.0, 16.0, 18.0, 18.0)]).plan();
    assert_eq!(planned.plan.clusters.len(), 2);
    assert!(planned.plan.curves.is_empty());
}

#[test]
fn two_lakes_of_neighbouring_cells() {
    let steps = [cut(6.0, 9.0, 8.0, 11.0), cut(8.0, 13.0, 10.0, 15.0)];
    for (rule, clusters) in [(ClusterRule::Interval, 2), (ClusterRule::Cell, 1)] {
        let scene = Scene { rule, ..lattice(3, 3, 0.2, &steps) };
        assert_eq!(scene.plan().plan.clusters.len(), clusters, "{rule:?}");
    }
    let apart = [cut(6.0, 9.0, 7.0, 11.0), cut(9.0, 13.0, 10.0, 15.0)];
    let scene = Scene { rule: ClusterRule::Cell, ..lattice(3, 3, 0.2, &apart) };
    assert_eq!(scene.plan().plan.clusters.len(), 2, "closed holes are clusters of one");
}

#[test]
fn clusters_know_their_middle_and_edge() {
    let planned = lattice(3, 3, 0.0, &[cut(6.0, 10.0, 14.0, 13.0), cut(20.0, 2.0, 24.0, 4.0)]).plan();
    let clusters = &planned.plan.clusters;
    assert_eq!(clusters.iter().map(|c| c.area_m2).collect::<Vec<_>>(), [8.0, 24.0]);
    assert_eq!(clusters.iter().map(|c| c.is_external).collect::<Vec<_>>(), [true, false]);
    let inside = |p: DVec2, low: (f64, f64), high: (f64, f64)| {
        (low.0..high.0).contains(&p.x) && (low.1..high.1).contains(&p.y)
    };
    assert!(inside(clusters[0].centre, (20.0, 2.0), (24.0, 4.0)));
    assert!(inside(clusters[1].centre, (8.0, 10.0), (14.0, 13.0)), "in its largest hole");
}

#[test]
fn beside_a_tile_that_cannot_be_read() {
    let mut scene = lattice(3, 3, 0.2, &[cut(13.0, 10.0, 16.0, 13.0), cut(9.0, 9.0, 10.0, 10.0)]);
    let bad = CellId::new(2, 1);
    scene.tiles.remove(&bad);
    scene.unreadable.insert(bad);
    let plan = scene.plan().plan;
    assert_eq!(plan.holes.iter().map(|h| h.leave).collect::<Vec<_>>(), [Some(Leave::BadNeighbour), None]);
    assert_eq!(plan.clusters[0].leave, Some(Leave::BadNeighbour));
}

#[test]
fn a_scene_without_any_surface_says_so() {
    let all = (0..2).flat_map(|j| (0..2).map(move |i| Step::Empty(i, j)));
    let plan = lattice(2, 2, 0.0, &all.collect::<Vec<_>>()).plan().plan;
    assert_eq!(plan.holes.len(), 4);
    assert_eq!(plan.clusters.len(), 1);
    assert_eq!(plan.clusters[0].leave, Some(Leave::NoSurface));
}

/// Two cells side by side with a step of the ground, a wall along y = 4, in both of them. `keep` says which quads
/// (column, row) of the west cell stay; row 4 is the wall.
fn stepped(keep: impl Fn(usize, usize) -> bool) -> Scene {
    let xs = |low: f64| -> Vec<f64> { (0..=8).map(|k| low + f64::from(k)).collect() };
    let mut rows: Vec<(f64, f64)> = (0..=4).map(|k| (f64::from(k), 0.0)).collect();
    rows.extend((4..=8).map(|k| (f64::from(k), 5.0)));
    let tiles = BTreeMap::from([
        (CellId::new(0, 0), block(&xs(0.0), &rows, keep)),
        (CellId::new(1, 0), block(&xs(8.0), &rows, |_, _| true)),
    ]);
    Scene::new(Grid { origin: DVec2::ZERO, cell_size_m: CELL_M }, tiles)
}

#[test]
fn a_wall_that_crosses_the_border_inside_an_adopted_stretch() {
    // The hole holds two rows below the wall, the wall, and two rows above.
    let planned = stepped(|column, row| !(column >= 5 && (2..=6).contains(&row))).plan();
    assert_eq!(lines(&planned.plan), ["0,0 I-B L1 #0 12"]);
    let hole = &planned.plan.holes[0];
    let found = spans(hole, Side::East);
    assert_eq!(found.len(), 1);
    let heights: Vec<(f64, f64)> = adopted(&planned, found[0]).iter().map(|p| (p[1], p[2])).collect();
    assert_eq!(heights, [(2.0, 0.0), (3.0, 0.0), (4.0, 0.0), (4.0, 5.0), (5.0, 5.0), (6.0, 5.0)]);
}

#[test]
fn a_wall_at_the_end_of_an_adopted_stretch() {
    for (name, rows, expected) in [
        ("above, the wall stays", 5..=6, vec![(4.0, 5.0), (5.0, 5.0), (6.0, 5.0)]),
        ("above, the wall goes", 4..=6, vec![(4.0, 0.0), (4.0, 5.0), (5.0, 5.0), (6.0, 5.0)]),
        ("below, the wall stays", 2..=3, vec![(2.0, 0.0), (3.0, 0.0), (4.0, 0.0)]),
        ("below, the wall goes", 2..=4, vec![(2.0, 0.0), (3.0, 0.0), (4.0, 0.0), (4.0, 5.0)]),
    ] {
        let planned = stepped(|column, row| !(column >= 5 && rows.contains(&row))).plan();
        assert_eq!(planned.plan.holes.len(), 1, "{name}: {:?}", planned.plan.not_holes);
        let hole = &planned.plan.holes[0];
        let found: Vec<(f64, f64)> =
            spans(hole, Side::East).iter().flat_map(|s| adopted(&planned, s)).map(|p| (p[1], p[2])).collect();
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn holes_outside_a_polygon_are_left() {
    let steps = [
        cut(2.0, 2.0, 4.0, 4.0),
        cut(9.0, 9.0, 12.0, 12.0),
        cut(14.0, 2.0, 18.0, 4.0),
        cut(18.0, 10.0, 22.0, 12.0),
        cut(14.0, 20.0, 20.0, 22.0),
    ];
    let scene = Scene { limit: Limit::Rectangle([8.0, 0.0, 20.0, 18.0]), ..lattice(3, 3, 0.0, &steps) };
    let plan = scene.plan().plan;
    let found: Vec<String> = plan
        .holes
        .iter()
        .map(|h| {
            format!("{},{} {} {:?}", h.cell.i, h.cell.j, h.class, plan.clusters[h.cluster as usize].leave)
        })
        .collect();
    let expected = [
        "0,0 closed Some(OutsideArea)",
        "1,0 I-B None",
        "2,0 I-B None",
        "1,1 closed None",
        "2,1 closed Some(CrossesArea)",
        "1,2 II-B Some(OutsideArea)",
        "2,2 II-B Some(OutsideArea)",
    ];
    assert_eq!(found, expected);
    let external: Vec<bool> = plan.holes.iter().map(|h| h.is_external).collect();
    assert_eq!(external, [true, false, false, false, true, true, true]);
}

#[test]
fn a_lake_with_a_piece_outside_a_polygon_crosses_its_outline() {
    let lake = cut(12.0, 10.0, 20.0, 14.0);
    let scene = Scene { limit: Limit::Rectangle([0.0, 0.0, 16.0, 24.0]), ..lattice(3, 3, 0.0, &[lake]) };
    let plan = scene.plan().plan;
    let leaves: Vec<_> = plan.holes.iter().map(|h| h.leave).collect();
    assert_eq!(leaves, [None, Some(Leave::OutsideArea)]);
    assert_eq!(plan.clusters[0].leave, Some(Leave::CrossesArea));
}
