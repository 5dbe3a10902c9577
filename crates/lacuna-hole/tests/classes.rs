//! Every class and shape of hole, on lattices of 3 x 3 cells of 8 m unless a case says otherwise.
//!
//! A line reads `column,row class Llayer #cluster area`, with `+n` for n islands. Areas hold for the lattice without
//! jitter; with it the classes, layers and clusters must be the same.

mod kit;

use kit::{Limit, Step, cut, keep, lattice, lines};

struct Case {
    name: &'static str,
    cells: (i32, i32),
    jitters_m: &'static [f64],
    limit: Limit,
    steps: Vec<Step>,
    expected: &'static [&'static str],
}

fn case(name: &'static str, steps: Vec<Step>, expected: &'static [&'static str]) -> Case {
    Case { name, cells: (3, 3), jitters_m: &[0.0, 0.2], limit: Limit::Cells, steps, expected }
}

fn without_area(line: &str) -> String {
    let words: Vec<&str> = line.split(' ').enumerate().filter(|(k, _)| *k != 4).map(|w| w.1).collect();
    words.join(" ")
}

fn check(cases: Vec<Case>) {
    let mut wrong = Vec::new();
    for c in cases {
        for &jitter_m in c.jitters_m {
            let mut scene = lattice(c.cells.0, c.cells.1, jitter_m, &c.steps);
            scene.limit = c.limit;
            let mut found = lines(&scene.plan().plan);
            let mut expected: Vec<String> = c.expected.iter().map(|e| (*e).to_owned()).collect();
            if jitter_m > 0.0 {
                found = found.iter().map(|l| without_area(l)).collect();
                expected = expected.iter().map(|l| without_area(l)).collect();
            }
            if found != expected {
                wrong.push(format!(
                    "{} (jitter {jitter_m})\n  expected {expected:#?}\n  found {found:#?}",
                    c.name
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nothing_missing_is_no_hole() {
    check(vec![case("full", vec![], &[])]);
}

#[test]
fn closed() {
    check(vec![
        case("one", vec![cut(10.0, 10.0, 13.0, 12.0)], &["1,1 closed L1 #0 6"]),
        case(
            "two in a cell, one in another",
            vec![cut(1.0, 1.0, 2.0, 3.0), cut(10.0, 10.0, 12.0, 12.0), cut(13.0, 13.0, 15.0, 15.0)],
            &["0,0 closed L1 #0 2", "1,1 closed L1 #1 4", "1,1 closed L1 #2 4"],
        ),
        case(
            "with an island",
            vec![cut(9.0, 9.0, 15.0, 15.0), keep(11.0, 11.0, 14.0, 13.0)],
            &["1,1 closed L1 #0 30 +1"],
        ),
        case(
            "a hole in its island",
            vec![cut(9.0, 9.0, 15.0, 15.0), keep(10.0, 10.0, 14.0, 14.0), cut(11.0, 11.0, 12.0, 13.0)],
            &["1,1 closed L1 #0 20 +1", "1,1 closed L1 #1 2"],
        ),
        case(
            "an island in a hole of an island",
            vec![
                cut(8.0 + 1.0, 9.0, 15.0, 15.0),
                keep(10.0, 10.0, 14.0, 14.0),
                cut(10.0 + 1.0, 11.0, 13.0, 13.0),
                keep(12.0, 12.0, 13.0, 13.0),
            ],
            // The inner piece touches the island in a corner and along two edges: it is no island of its own.
            &["1,1 closed L1 #0 20 +1", "1,1 closed L1 #1 3"],
        ),
        case(
            "with an island that hangs on its rim by a vertex",
            vec![cut(9.0, 9.0, 15.0, 15.0), keep(9.0, 9.0, 11.0, 11.0), keep(11.0, 11.0, 14.0, 13.0)],
            &["1,1 closed L1 #0 26 +1"],
        ),
        case(
            "of one triangle",
            vec![Step::CutDisc(10.0 + 1.0 / 3.0, 10.0 + 2.0 / 3.0, 0.1)],
            &["1,1 closed L1 #0 0.5"],
        ),
    ]);
}

#[test]
fn internal_hollow() {
    check(vec![
        case("missing file", vec![Step::Missing(1, 1)], &["1,1 I-A L1 #0 64"]),
        case("empty mesh", vec![Step::Empty(1, 1)], &["1,1 I-A L1 #0 64"]),
        case("all triangles cut", vec![cut(8.0, 8.0, 16.0, 16.0)], &["1,1 I-A L1 #0 64"]),
        Case {
            cells: (4, 3),
            ..case(
                "two, side by side",
                vec![Step::Missing(1, 1), Step::Empty(2, 1)],
                &["1,1 I-A L1 #0 64", "2,1 I-A L1 #0 64"],
            )
        },
    ]);
}

#[test]
fn internal_semi_enclosed() {
    check(vec![
        case("ends at a covered border", vec![cut(13.0, 10.0, 16.0, 12.0)], &["1,1 I-B L1 #0 6"]),
        case("across a border", vec![cut(14.0, 10.0, 19.0, 13.0)], &["1,1 I-B L1 #0 6", "2,1 I-B L1 #0 9"]),
        case(
            "wider on one side of the border",
            vec![cut(14.0, 10.0, 16.0, 12.0), cut(16.0, 9.0, 18.0, 14.0)],
            &["1,1 I-B L1 #0 4", "2,1 I-B L1 #0 10"],
        ),
        case(
            "over a grid corner",
            vec![cut(14.0, 14.0, 18.0, 19.0)],
            &["1,1 I-B L1 #0 4", "2,1 I-B L1 #0 4", "1,2 I-B L1 #0 6", "2,2 I-B L1 #0 6"],
        ),
        case("in a grid corner of one cell", vec![cut(14.0, 14.0, 16.0, 16.0)], &["1,1 I-B L1 #0 4"]),
        case("a whole side", vec![cut(14.0, 8.0, 16.0, 16.0)], &["1,1 I-B L1 #0 16"]),
        case(
            "three sides, the fourth covered by one quad",
            vec![cut(8.0, 8.0, 16.0, 16.0), keep(11.0, 8.0, 12.0, 9.0)],
            &["1,1 I-B L1 #0 63"],
        ),
        case(
            "over the south-west corner, where the perimeter begins",
            vec![cut(8.0, 8.0, 10.0, 11.0)],
            &["1,1 I-B L1 #0 6"],
        ),
    ]);
}

#[test]
fn internal_crossing() {
    check(vec![
        case("west to east", vec![cut(8.0, 11.0, 16.0, 13.0)], &["1,1 I-C L1 #0 16"]),
        case("south to north", vec![cut(10.0, 8.0, 13.0, 16.0)], &["1,1 I-C L1 #0 24"]),
        case(
            "with its ends in the neighbours",
            vec![cut(6.0, 11.0, 18.0, 13.0)],
            &["0,1 I-B L1 #0 4", "1,1 I-C L1 #0 16", "2,1 I-B L1 #0 4"],
        ),
    ]);
}

#[test]
fn internal_island() {
    check(vec![
        case(
            "a corner cut off",
            vec![cut(8.0, 8.0, 12.0, 12.0), keep(8.0, 8.0, 10.0, 10.0)],
            &["1,1 I-D L1 #0 12"],
        ),
        case(
            "a side remnant",
            vec![cut(12.0, 10.0, 16.0, 14.0), keep(15.0, 11.0, 16.0, 13.0)],
            &["1,1 I-D L1 #0 14"],
        ),
        case(
            "three pieces",
            vec![cut(8.0, 11.0, 16.0, 13.0), cut(11.0, 13.0, 13.0, 16.0)],
            &["1,1 I-D L1 #0 22"],
        ),
        case(
            "four corners left",
            vec![cut(8.0, 11.0, 16.0, 13.0), cut(11.0, 8.0, 13.0, 16.0)],
            &["1,1 I-D L1 #0 28"],
        ),
        case(
            "an island",
            vec![cut(11.0, 9.0, 16.0, 15.0), keep(13.0, 11.0, 15.0, 14.0)],
            &["1,1 I-D L1 #0 24 +1"],
        ),
        case(
            "nothing but an island",
            vec![cut(8.0, 8.0, 16.0, 16.0), keep(11.0, 11.0, 14.0, 13.0)],
            &["1,1 I-D L1 #0 58 +1"],
        ),
        case(
            "an island on a border is a remnant of a side in both cells",
            vec![cut(12.0, 9.0, 20.0, 15.0), keep(15.0, 11.0, 17.0, 13.0)],
            &["1,1 I-D L1 #0 22", "2,1 I-D L1 #0 22"],
        ),
        case(
            "a hole in an island",
            vec![cut(9.0, 9.0, 20.0, 15.0), keep(10.0, 10.0, 14.0, 14.0), cut(11.0, 11.0, 13.0, 13.0)],
            &["1,1 I-D L1 #0 26 +1", "1,1 closed L1 #1 4", "2,1 I-B L1 #0 24"],
        ),
    ]);
}

#[test]
fn external() {
    check(vec![
        case("hollow", vec![Step::Empty(2, 2)], &["2,2 II-A L1 #0 64"]),
        case("semi-enclosed", vec![cut(20.0, 10.0, 24.0, 13.0)], &["2,1 II-B L1 #0 12"]),
        case("crossing", vec![cut(0.0, 11.0, 8.0, 13.0)], &["0,1 II-C L1 #0 16"]),
        case(
            "a river through the scene",
            vec![cut(0.0, 11.0, 24.0, 13.0)],
            &["0,1 II-C L1 #0 16", "1,1 I-C L1 #0 16", "2,1 II-C L1 #0 16"],
        ),
        case("a corner of the area", vec![cut(22.0, 21.0, 24.0, 24.0)], &["2,2 II-B L1 #0 6"]),
        case(
            "a corner cut off",
            vec![cut(20.0, 20.0, 24.0, 24.0), keep(22.0, 22.0, 24.0, 24.0)],
            &["2,2 II-D L1 #0 12"],
        ),
        case(
            "island",
            vec![cut(18.0, 9.0, 24.0, 14.0), keep(20.0, 10.0, 22.0, 13.0)],
            &["2,1 II-D L1 #0 24 +1"],
        ),
        case(
            "an internal bay and an external one in one cell",
            vec![cut(16.0, 9.0, 18.0, 11.0), cut(22.0, 12.0, 24.0, 14.0)],
            &["2,1 I-B L1 #0 4", "2,1 II-B L1 #1 4"],
        ),
    ]);
}

#[test]
fn the_area_decides() {
    let half = || vec![cut(20.0, 0.0, 24.0, 24.0)];
    check(vec![
        case(
            "data end inside the last cells, area of cells",
            half(),
            &["2,0 II-B L1 #0 32", "2,1 II-B L1 #0 32", "2,2 II-B L1 #0 32"],
        ),
        // A box that a jittered edge touches in one vertex has slivers all along: the edge must be straight.
        Case {
            limit: Limit::Box,
            jitters_m: &[0.0],
            ..case("data end inside the last cells, area of the box", half(), &[])
        },
        Case {
            limit: Limit::Box,
            jitters_m: &[0.0],
            ..case(
                "a bay at the edge of the box",
                vec![cut(20.0, 0.0, 24.0, 24.0), cut(18.0, 10.0, 20.0, 12.0)],
                &["2,1 II-B L1 #0 4"],
            )
        },
        case("a missing corner cell is outside the area of cells", vec![Step::Missing(2, 2)], &[]),
        Case {
            limit: Limit::Box,
            ..case(
                "a missing corner cell is inside the box",
                vec![Step::Missing(2, 2)],
                &["2,2 II-A L1 #0 64"],
            )
        },
        case("a missing cell at the side is outside", vec![Step::Missing(1, 2)], &[]),
    ]);
}

#[test]
fn a_rim_that_touches_the_border_in_a_vertex() {
    let triangle = |x: f64, y: f64| Step::CutDisc(x, y, 0.1);
    let third = 1.0 / 3.0;
    check(vec![
        case(
            "from a closed hole",
            vec![cut(13.0, 10.0, 15.0, 12.0), triangle(15.0 + third, 11.0 + 2.0 * third)],
            &["1,1 closed L1 #0 4.5"],
        ),
        case(
            "on both sides of a closed hole",
            vec![
                cut(9.0, 11.0, 15.0, 12.0),
                triangle(15.0 + third, 11.0 + 2.0 * third),
                triangle(9.0 - third, 11.0 + 2.0 * third),
            ],
            &["1,1 closed L1 #0 7"],
        ),
        case(
            "a disc that opens two borders and touches them besides",
            vec![Step::CutDisc(12.5, 12.5, 3.6)],
            &["1,1 I-D L1 #0 41"],
        ),
        case(
            "from a bay at another border",
            vec![Step::CutDisc(21.138, 4.478, 2.941)],
            &["2,0 II-B L1 #0 27.5"],
        ),
        case(
            "from holes of both cells: they meet in a point and stay two",
            vec![
                cut(13.0, 10.0, 15.0, 12.0),
                triangle(15.0 + third, 11.0 + 2.0 * third),
                cut(17.0, 10.0, 19.0, 12.0),
                triangle(17.0 - third, 11.0 + 2.0 * third),
            ],
            &["1,1 closed L1 #0 4.5", "2,1 closed L1 #1 4.5"],
        ),
    ]);
}

#[test]
fn layers_count_from_the_shore() {
    check(vec![
        Case {
            cells: (5, 5),
            ..case(
                "a lake of 3 x 3 hollow cells with covered shores",
                vec![cut(8.0, 8.0, 32.0, 32.0)],
                &[
                    "1,1 I-A L1 #0 64",
                    "2,1 I-A L1 #0 64",
                    "3,1 I-A L1 #0 64",
                    "1,2 I-A L1 #0 64",
                    "2,2 I-A L2 #0 64",
                    "3,2 I-A L1 #0 64",
                    "1,3 I-A L1 #0 64",
                    "2,3 I-A L1 #0 64",
                    "3,3 I-A L1 #0 64",
                ],
            )
        },
        Case {
            cells: (5, 5),
            ..case(
                "a lake whose shore lies in the next cells",
                vec![cut(7.0, 7.0, 33.0, 33.0)],
                &[
                    "0,0 I-B L1 #0 1",
                    "1,0 I-B L1 #0 8",
                    "2,0 I-B L1 #0 8",
                    "3,0 I-B L1 #0 8",
                    "4,0 I-B L1 #0 1",
                    "0,1 I-B L1 #0 8",
                    "1,1 I-A L2 #0 64",
                    "2,1 I-A L2 #0 64",
                    "3,1 I-A L2 #0 64",
                    "4,1 I-B L1 #0 8",
                    "0,2 I-B L1 #0 8",
                    "1,2 I-A L2 #0 64",
                    "2,2 I-A L3 #0 64",
                    "3,2 I-A L2 #0 64",
                    "4,2 I-B L1 #0 8",
                    "0,3 I-B L1 #0 8",
                    "1,3 I-A L2 #0 64",
                    "2,3 I-A L2 #0 64",
                    "3,3 I-A L2 #0 64",
                    "4,3 I-B L1 #0 8",
                    "0,4 I-B L1 #0 1",
                    "1,4 I-B L1 #0 8",
                    "2,4 I-B L1 #0 8",
                    "3,4 I-B L1 #0 8",
                    "4,4 I-B L1 #0 1",
                ],
            )
        },
    ]);
}
