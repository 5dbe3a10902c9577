//! The same holes come out however a scene is turned, mirrored, shifted, numbered or ordered.

mod kit;

use glam::{DVec2, DVec3};
use kit::{Motion, Scene, Step, append, assert_same, cut, keep, lattice, open_slit, sheet, signature, tube};
use lacuna_grid::CellId;
use lacuna_hole::{ClusterRule, NotHole};

/// Scenes that hold every class between them.
fn scenes() -> Vec<(&'static str, Scene)> {
    let river = [
        cut(0.0, 11.0, 24.0, 13.0),
        cut(10.0, 9.0, 14.0, 15.0),
        keep(11.0, 10.0, 13.0, 14.0),
        cut(2.0, 2.0, 4.0, 5.0),
    ];
    let lake = [
        cut(5.0, 6.0, 35.0, 33.0),
        keep(17.0, 18.0, 22.0, 23.0),
        cut(18.0, 19.0, 20.0, 21.0),
        keep(30.0, 22.0, 33.0, 26.0),
        Step::Missing(0, 4),
        Step::Empty(4, 0),
    ];
    let bays = [
        cut(6.0, 9.0, 8.0, 11.0),
        cut(8.0, 13.0, 10.0, 15.0),
        Step::CutDisc(16.0, 16.0, 3.3),
        cut(20.0, 1.0, 24.0, 5.0),
        keep(22.0, 1.0, 24.0, 3.0),
    ];
    let by_cell = Scene { rule: ClusterRule::Cell, ..lattice(3, 3, 0.25, &bays) };
    vec![
        ("a river", lattice(3, 3, 0.25, &river)),
        ("a lake", lattice(5, 5, 0.25, &lake)),
        ("bays", lattice(3, 3, 0.25, &bays)),
        ("bays, clusters by cell", by_cell),
        ("a plain raster", lattice(3, 3, 0.0, &bays)),
        ("odd pieces", odd_pieces()),
    ]
}

/// A fragment and an island in holes, a slit, a shaft that is open at its bottom, and a crown above the ground.
fn odd_pieces() -> Scene {
    let steps = [
        cut(1.0, 1.0, 4.0, 3.0),
        cut(1.0, 17.0, 7.0, 23.0),
        cut(17.0, 17.0, 23.0, 23.0),
        cut(18.0, 4.0, 24.0, 12.0),
        cut(6.0, 12.0, 9.0, 15.0),
    ];
    let mut scene = lattice(3, 3, 0.25, &steps);
    let rim: Vec<DVec3> = {
        let planned = scene.plan();
        let survey = &planned.surveys[&CellId::new(0, 0)];
        let hole = survey.loops.iter().find(|l| l.vector_area.z > 0.0).expect("a hole");
        hole.edges.iter().map(|&e| survey.from(e)).collect()
    };
    append(scene.tile(0, 0), tube(&rim, 6.0));
    append(scene.tile(0, 2), sheet(DVec2::new(3.1, 19.1), DVec2::new(3.9, 19.9), 5.0, 2, 2));
    append(scene.tile(2, 2), sheet(DVec2::new(18.3, 18.3), DVec2::new(21.4, 21.4), 5.0, 4, 4));
    append(scene.tile(2, 0), sheet(DVec2::new(17.1, 1.1), DVec2::new(21.3, 3.3), 30.0, 5, 5));
    open_slit(scene.tile(1, 1), 0.001);
    scene
}

fn check(motions: &[Motion]) {
    for (name, scene) in scenes() {
        let planned = scene.plan();
        let expected = signature(&planned, |cell| motions.iter().fold(cell, |c, m| m.cell(c)));
        assert!(expected.len() > 3, "{name}: too little to compare");
        let moved = motions.iter().fold(scene, |s, m| m.of(&s)).plan();
        assert_same(&expected, &signature(&moved, |c| c), &format!("{name}, {motions:?}"));
        assert_eq!(planned.plan.not_holes, moved.plan.not_holes, "{name}, {motions:?}");
    }
}

#[test]
fn the_odd_pieces_are_what_they_are_called() {
    let plan = odd_pieces().plan().plan;
    let expected = [(NotHole::Slit, 1), (NotHole::Passage, 1), (NotHole::Floater, 2)];
    assert_eq!(plan.not_holes, expected.into());
    assert_eq!(plan.holes.iter().map(|h| h.islands.len()).sum::<usize>(), 1);
}

#[test]
fn quarter_turns() {
    for turns in 1..=3 {
        check(&vec![Motion::Turn; turns]);
    }
}

#[test]
fn mirrored() {
    check(&[Motion::Mirror]);
    check(&[Motion::Mirror, Motion::Turn]);
}

#[test]
fn far_from_the_origin() {
    check(&[Motion::Shift(5e5, -5e5)]);
    check(&[Motion::Shift(-4.97e5, 2.488e6)]);
    check(&[Motion::Shift(5e5, 5e5), Motion::Turn, Motion::Mirror]);
}

#[test]
fn other_cell_numbers() {
    check(&[Motion::Renumber(-3, 12)]);
    check(&[Motion::Renumber(-20, -20)]);
}

#[test]
fn other_orders_in_the_files() {
    check(&[Motion::ShuffleTriangles]);
    check(&[Motion::ShuffleVertices]);
    check(&[Motion::ShuffleVertices, Motion::ShuffleTriangles, Motion::Turn, Motion::Shift(5e5, 5e5)]);
}

#[test]
fn four_turns_are_none() {
    let (_, scene) = scenes().remove(0);
    let moved = (0..4).fold(scene.clone(), |s, _| Motion::Turn.of(&s));
    assert_eq!(moved.tiles, scene.tiles);
    assert_eq!(moved.tiles.keys().next(), Some(&CellId::new(0, 0)));
}
