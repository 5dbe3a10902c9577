//! Contours of every class: orientation, rims, shared borders, and no crack between tiles and patches.

mod closing;
#[path = "../../lacuna-hole/tests/kit/mod.rs"]
mod kit;

use closing::{close, plan_rings};
use glam::DVec3;
use kit::{CELL_M, Limit, Motion, Scene, Step, cut, keep, lattice, lattice_of};
use lacuna_grid::{CornerId, Side};
use lacuna_hole::{Anchor, ClusterRule};
use lacuna_mesh::{EdgeKind, is_simple};

/// Scenes of 3 x 3 cells (5 x 5 for the lakes of hollow cells) that hold every class.
fn cases() -> Vec<(&'static str, i32, Vec<Step>)> {
    vec![
        ("closed", 3, vec![cut(10.0, 10.0, 13.0, 12.0)]),
        ("closed with an island", 3, vec![cut(9.0, 9.0, 15.0, 15.0), keep(11.0, 11.0, 14.0, 13.0)]),
        ("hollow, no file", 3, vec![Step::Missing(1, 1)]),
        ("hollow, no triangle", 3, vec![Step::Empty(1, 1)]),
        ("a bay that the neighbour covers", 3, vec![cut(13.0, 10.0, 16.0, 13.0)]),
        ("across a border", 3, vec![cut(13.0, 10.0, 19.0, 13.0)]),
        ("across a border, wider beyond", 3, vec![cut(13.0, 10.0, 16.0, 12.0), cut(16.0, 9.0, 18.0, 14.0)]),
        ("shifted across a border", 3, vec![cut(13.0, 10.0, 16.0, 13.0), cut(16.0, 11.0, 18.0, 15.0)]),
        ("over a grid corner", 3, vec![cut(13.0, 13.0, 19.0, 18.0)]),
        (
            "over a grid corner that one tile has",
            3,
            vec![cut(13.0, 13.0, 19.0, 18.0), keep(16.0, 16.0, 19.0, 18.0)],
        ),
        ("in a corner of one tile", 3, vec![cut(13.0, 13.0, 16.0, 16.0)]),
        ("two cells beside a corner", 3, vec![cut(13.0, 13.0, 19.0, 16.0)]),
        ("a whole side", 3, vec![cut(13.0, 8.0, 19.0, 16.0)]),
        ("crossing", 3, vec![cut(6.0, 11.0, 18.0, 13.0)]),
        ("a corner cut off", 3, vec![cut(8.0, 8.0, 13.0, 13.0), keep(8.0, 8.0, 10.0, 10.0)]),
        ("three pieces", 3, vec![cut(8.0, 11.0, 16.0, 13.0), cut(11.0, 13.0, 13.0, 16.0)]),
        ("island", 3, vec![cut(10.0, 9.0, 20.0, 15.0), keep(12.0, 11.0, 15.0, 14.0)]),
        ("island on a border", 3, vec![cut(12.0, 9.0, 20.0, 15.0), keep(14.0, 11.0, 18.0, 13.0)]),
        ("nothing but an island", 3, vec![cut(8.0, 8.0, 16.0, 16.0), keep(11.0, 11.0, 14.0, 13.0)]),
        (
            "a hole in an island",
            3,
            vec![cut(9.0, 9.0, 20.0, 15.0), keep(10.0, 10.0, 14.0, 14.0), cut(11.0, 11.0, 13.0, 13.0)],
        ),
        ("a river to the area's edge", 3, vec![cut(0.0, 11.0, 24.0, 13.0)]),
        ("a corner of the area", 3, vec![cut(20.0, 20.0, 24.0, 24.0)]),
        ("a hollow corner of the area", 3, vec![Step::Empty(2, 2)]),
        ("touches a border", 3, vec![Step::CutDisc(12.5, 12.5, 3.6)]),
        ("touches a border beside the area's edge", 3, vec![Step::CutDisc(21.138, 4.478, 2.941)]),
        ("a lake of hollow cells", 5, vec![cut(8.0, 8.0, 32.0, 32.0)]),
        ("a lake of three layers", 5, vec![cut(7.0, 7.0, 33.0, 33.0)]),
        (
            "a lake with an island in its middle",
            5,
            vec![cut(7.0, 7.0, 33.0, 33.0), keep(17.0, 18.0, 21.0, 22.0)],
        ),
        ("a round lake", 5, vec![Step::CutDisc(20.0, 19.0, 14.3)]),
    ]
}

#[test]
fn every_class_closes_without_a_crack() {
    for (name, size, steps) in cases() {
        for (jitter_m, growth) in [(0.0, 0.0), (0.25, 0.0), (0.25, 0.3)] {
            let scene = lattice(size, size, jitter_m, &steps);
            close(&scene, growth).check(&format!("{name}, jitter {jitter_m}, growth {growth}"));
        }
    }
}

#[test]
fn contours_are_simple_in_plan() {
    for (name, size, steps) in cases().into_iter().filter(|c| !c.0.contains("touches")) {
        let scene = lattice(size, size, 0.25, &steps);
        for made in &close(&scene, 0.0).contours {
            let rings = plan_rings(&made.contour);
            let slices: Vec<_> = rings.iter().map(Vec::as_slice).collect();
            assert!(is_simple(&slices), "{name}");
        }
    }
}

#[test]
fn clusters_by_cell_close_as_well() {
    for (name, size, steps) in cases() {
        let scene = Scene { rule: ClusterRule::Cell, ..lattice(size, size, 0.25, &steps) };
        close(&scene, 0.0).check(name);
    }
}

#[test]
fn turned_mirrored_and_shifted() {
    for (name, size, steps) in cases() {
        let scene = lattice(size, size, 0.25, &steps);
        for motions in [
            vec![Motion::Turn],
            vec![Motion::Turn; 3],
            vec![Motion::Mirror],
            vec![Motion::Shift(5e5, -5e5), Motion::ShuffleVertices],
        ] {
            let moved = motions.iter().fold(scene.clone(), |s, m| m.of(&s));
            close(&moved, 0.0).check(&format!("{name}, {motions:?}"));
        }
    }
}

#[test]
fn the_box_of_the_data_closes_external_holes() {
    let scene = Scene {
        limit: Limit::Box,
        ..lattice(3, 3, 0.0, &[cut(20.0, 0.0, 24.0, 24.0), cut(18.0, 10.0, 20.0, 12.0)])
    };
    close(&scene, 0.0).check("a bay at the edge of the box");
}

#[test]
fn a_plane_is_closed_in_its_plane() {
    let plane = |x: i32, y: i32| DVec3::new(f64::from(x), f64::from(y), 7.25);
    for (name, size, steps) in cases() {
        let scene = lattice_of(size, size, &steps, &plane);
        for made in &close(&scene, 0.0).contours {
            let off = made.contour.positions().iter().map(|p| (p.z - 7.25).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{name}: {off}");
        }
    }
}

#[test]
fn heights_stay_between_the_rim_s() {
    for (name, size, steps) in cases() {
        let scene = lattice(size, size, 0.25, &steps);
        let closing = close(&scene, 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for mesh in scene.tiles.values() {
            for p in &mesh.positions {
                (low, high) = (low.min(p.z), high.max(p.z));
            }
        }
        for curve in &closing.curves.curves {
            assert!(curve.inner.iter().all(|p| p.z >= low && p.z <= high), "{name}");
        }
    }
}

#[test]
fn four_cells_share_the_height_of_their_corner() {
    let scene = lattice(3, 3, 0.25, &[cut(13.0, 13.0, 19.0, 18.0)]);
    let closing = close(&scene, 0.0);
    let corner = closing.curves.corners[&CornerId { i: 2, j: 2 }];
    assert_eq!((corner.x, corner.y), (16.0, 16.0));
    for made in &closing.contours {
        assert_eq!(made.contour.positions().iter().filter(|p| **p == corner).count(), 1);
    }
}

#[test]
fn a_curve_begins_at_the_rim_s_last_vertex() {
    let scene = lattice(3, 3, 0.25, &[cut(13.0, 10.0, 19.0, 14.0)]);
    let closing = close(&scene, 0.0);
    let plan = &closing.planned.plan;
    assert_eq!(plan.curves.len(), 1);
    let curve = &plan.curves[0];
    assert!(matches!((curve.low, curve.high), (Anchor::Point(..), Anchor::Point(..))));
    for (h, made) in closing.contours.iter().enumerate() {
        let ring = &made.contour.outer;
        let border: Vec<usize> =
            (0..ring.edges.len()).filter(|&k| ring.edges[k].kind == EdgeKind::Border).collect();
        assert_eq!(border.len(), closing.curves.curves[0].inner.len() + 1, "hole {h}");
        // Rim edges have the triangle behind, border edges have none.
        assert!(ring.edges.iter().all(|e| (e.kind == EdgeKind::Rim) == e.apex.is_some()), "hole {h}");
    }
    // The rim's edge is a metre: so is the curve's.
    assert_eq!(closing.curves.curves[0].inner.len(), 3);
}

#[test]
fn spacing_follows_the_options() {
    let scene = lattice(3, 3, 0.0, &[cut(0.0, 4.0, 24.0, 20.0)]);
    let planned = scene.plan();
    let with = |growth: f64, spacing_m: Option<f64>| {
        let options = lacuna_close::LayeredOptions { growth, spacing_m };
        lacuna_close::project(&planned.surveys, &planned.plan, &|_| options)
    };
    let counts =
        |curves: &lacuna_close::Curves| -> usize { curves.curves.iter().map(|c| c.inner.len()).sum() };
    assert!(counts(&with(0.0, Some(0.25))) > 3 * counts(&with(0.0, None)));
    assert!(counts(&with(0.5, None)) < counts(&with(0.0, None)));
}

#[test]
fn adopted_heights_are_the_neighbour_s_own() {
    // The neighbour's border is rough: nothing smooths it.
    let rough = |x: i32, y: i32| DVec3::new(f64::from(x), f64::from(y), 5.0 + kit::scatter(x, y, 9));
    let scene = lattice_of(3, 3, &[cut(13.0, 10.0, 16.0, 14.0)], &rough);
    let closing = close(&scene, 0.0);
    closing.check("rough");
    let on_border: Vec<DVec3> =
        closing.contours[0].contour.positions().into_iter().filter(|p| p.x == 2.0 * CELL_M).collect();
    let expected: Vec<DVec3> = (10..=14).map(|y| rough(16, y)).collect();
    assert_eq!(on_border.len(), expected.len());
    assert!(expected.iter().all(|p| on_border.contains(p)));
    assert_eq!(closing.planned.plan.holes[0].cell.border(Side::East).cells().len(), 2);
}
