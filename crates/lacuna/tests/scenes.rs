//! Made scenes with known holes: every class is found where it was put, everything is filled, and turning, mirroring,
//! shifting, shuffling, renumbering or another format changes nothing of that.

mod kit;

use kit::{SceneFolder, repair, report};
use lacuna::report::{Outcome, Report};
use lacuna::{Again, Status, VerifyOptions, verify};
use scene::class::{Class, Form};
use scene::encode::Format;
use scene::make::make;
use scene::maker::{CutOption, MakeOptions, Maker};
use scene::preset::Preset;
use std::collections::BTreeMap;

/// How often each class was promised or found, by the report's words.
type Counts = BTreeMap<String, usize>;

/// Fill all that is found, up to the area's edge.
const ALL: [&str; 4] = ["--area", "cells", "--external", "fill"];

fn small() -> MakeOptions {
    MakeOptions::new(Preset::Small)
}

/// The class of a hole as the report has it: `closed`, `I-A`, `II-B`.
fn words(class: Class) -> String {
    match class {
        Class::Closed => "closed".to_owned(),
        Class::Internal(form) => format!("I-{}", letter(form)),
        Class::External(form) => format!("II-{}", letter(form)),
    }
}

fn letter(form: Form) -> char {
    match form {
        Form::Hollow => 'A',
        Form::SemiEnclosed => 'B',
        Form::Crossing => 'C',
        Form::Island => 'D',
    }
}

/// A made scene, its repair, and the classes that each cell should show.
struct Repaired {
    scene: SceneFolder,
    report: Report,
    /// Classes by cell as they lie in the files (turned), sorted.
    promised: BTreeMap<[i32; 2], Vec<String>>,
}

fn make_and_repair(options: MakeOptions, what: &str) -> Repaired {
    let maker = Maker::new(options).unwrap_or_else(|e| panic!("{what}: {e}"));
    let scene = SceneFolder::new(|path| {
        make(&maker, path).unwrap_or_else(|e| panic!("{what}: {e}"));
    });
    let mut promised: BTreeMap<[i32; 2], Vec<String>> = BTreeMap::new();
    for (cell, class) in maker.plan().holes.iter().flat_map(|h| &h.expected) {
        let turned = maker.frame().cell(*cell).map(|k| i32::try_from(k).expect("a small number"));
        promised.entry(turned).or_default().push(words(*class));
    }
    promised.values_mut().for_each(|v| v.sort());
    let out = scene.beside("out");
    let run = repair(&scene, &out, &ALL);
    assert_eq!(run.code, 0, "{what}:\n{}{}", run.stdout, run.stderr);
    Repaired { report: report(&out), scene, promised }
}

impl Repaired {
    /// Classes by tile index. The report counts cells from the grid's corner, which a shift moves; names keep theirs.
    fn found(&self) -> BTreeMap<[i32; 2], Vec<String>> {
        let mut found: BTreeMap<[i32; 2], Vec<String>> = BTreeMap::new();
        for hole in &self.report.holes {
            found.entry(index(&hole.tile)).or_default().push(hole.kind().key().to_owned());
        }
        found.values_mut().for_each(|v| v.sort());
        found
    }

    #[track_caller]
    fn check(&self, what: &str) {
        assert_eq!(self.found(), self.promised, "{what}: classes by cell");
        let open: Vec<_> = self.report.holes.iter().filter(|h| h.outcome != Outcome::Filled).collect();
        assert!(open.is_empty(), "{what}: not filled: {open:?}");
        let seams = &self.report.seams;
        assert_eq!(seams.differing_vertices, 0, "{what}: {seams:?}");
        assert!(self.scene.path().exists());
    }

    /// Tiles that share no vertices: what is filled is closed and verified; where the tiles overlap at the end of a rim, no
    /// edge joins them, and the hole is left with that reason. At `least` so many are filled.
    #[track_caller]
    fn check_ragged(&self, least: usize, what: &str) {
        assert_eq!(self.found(), self.promised, "{what}: classes by cell");
        let (filled, left): (Vec<_>, Vec<_>) =
            self.report.holes.iter().partition(|h| h.outcome == Outcome::Filled);
        assert!(filled.len() >= least, "{what}: {} of {} filled", filled.len(), self.report.holes.len());
        assert!(left.iter().all(|h| h.reason.is_some()), "{what}: {left:?}");
        let options = VerifyOptions { threads: 1, again: Again::Never, ..VerifyOptions::default() };
        let verdict = verify(self.scene.path(), &self.scene.beside("out"), &options)
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        let wrong: Vec<_> = verdict.promises.iter().filter(|p| p.status == Status::Broken).collect();
        assert!(wrong.is_empty(), "{what}: {wrong:?}");
        let is_judged = verdict.promises.iter().any(|p| p.number == 4 && p.status == Status::Held);
        assert!(is_judged || filled.len() < self.report.holes.len(), "{what}: borders are not judged");
    }
}

/// `Tile_+002_-001` is cell 2, -1.
fn index(tile: &str) -> [i32; 2] {
    let mut parts = tile.rsplit('_').map(|n| n.parse().unwrap_or_else(|e| panic!("{tile}: {e}")));
    let (j, i) = (parts.next().expect("a row"), parts.next().expect("a column"));
    [i, j]
}

fn counts(report: &Report) -> Counts {
    let mut counts = Counts::new();
    report.holes.iter().for_each(|h| *counts.entry(h.kind().key().to_owned()).or_default() += 1);
    counts
}

#[test]
fn every_hole_has_the_class_it_was_given() {
    for seed in 1..=6 {
        let repaired = make_and_repair(MakeOptions { seed, ..small() }, &format!("seed {seed}"));
        repaired.check(&format!("seed {seed}"));
    }
    let repaired =
        make_and_repair(MakeOptions { triangles: Some(1_800), ..MakeOptions::new(Preset::Demo) }, "demo");
    repaired.check("demo");
    let tower = MakeOptions { buildings: 6, triangles: Some(6_000), ..small() };
    make_and_repair(tower, "buildings").check("buildings");
}

#[test]
fn turned_mirrored_shuffled_and_renumbered_scenes_show_the_same() {
    let base = make_and_repair(small(), "as made");
    let cases = [
        ("turned by 90", MakeOptions { turns: 1, ..small() }),
        ("turned by 180", MakeOptions { turns: 2, ..small() }),
        ("turned by 270", MakeOptions { turns: 3, ..small() }),
        ("mirrored", MakeOptions { mirror: true, ..small() }),
        ("mirrored and turned", MakeOptions { mirror: true, turns: 1, ..small() }),
        ("shuffled", MakeOptions { shuffle: true, ..small() }),
        ("renumbered", MakeOptions { renumber: true, ..small() }),
        ("shuffled and renumbered", MakeOptions { shuffle: true, renumber: true, ..small() }),
    ];
    for (what, options) in cases {
        let repaired = make_and_repair(options, what);
        repaired.check(what);
        same_areas(&base.report, &repaired.report, what);
    }
}

/// The same holes, hole by hole in order of area: area, perimeter and rim do not depend on place or order.
#[track_caller]
fn same_areas(base: &Report, other: &Report, what: &str) {
    let sorted = |report: &Report| {
        let mut rows: Vec<(f64, f64, u64)> =
            report.holes.iter().map(|h| (h.area_m2, h.perimeter_m, h.rim_vertices)).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        rows
    };
    for (a, b) in sorted(base).into_iter().zip(sorted(other)) {
        assert!((a.0 - b.0).abs() < 1e-2 && (a.1 - b.1).abs() < 1e-2, "{what}: {a:?} became {b:?}");
        assert_eq!(a.2, b.2, "{what}: rim vertices");
    }
}

#[test]
fn every_format_shows_the_same() {
    let base = make_and_repair(small(), "ply");
    let formats = [Format::PlyDouble, Format::PlyAscii, Format::Obj, Format::Glb];
    for format in formats {
        let what = format!("{format:?}");
        let repaired = make_and_repair(MakeOptions { format, ..small() }, &what);
        repaired.check(&what);
        same_areas(&base.report, &repaired.report, &what);
    }
}

#[test]
fn far_from_the_origin_the_same_is_found() {
    let base = make_and_repair(small(), "at home");
    for (format, shift_m) in
        [(Format::Obj, [5e5, 5e5]), (Format::PlyDouble, [5e5, 5e5]), (Format::PlyDouble, [-5e5, 4_649_000.0])]
    {
        let what = format!("{format:?} shifted by {shift_m:?}");
        let repaired = make_and_repair(MakeOptions { format, shift_m, ..small() }, &what);
        repaired.check(&what);
        same_areas(&base.report, &repaired.report, &what);
    }
}

#[test]
fn tiles_that_overrun_or_stray_show_the_same_classes() {
    let cuts = [
        CutOption::Overrun(0.1),
        CutOption::Overrun(0.5),
        CutOption::Ragged(0.1),
        CutOption::Ragged(0.3),
        CutOption::Ragged(0.8),
    ];
    for cut in cuts {
        for seed in 1..=2 {
            let what = format!("{cut:?}, seed {seed}");
            let repaired = make_and_repair(MakeOptions { cut, seed, ..small() }, &what);
            let mode = &repaired.report.scene.border_mode;
            let expected = if matches!(cut, CutOption::Overrun(_)) { "overrun" } else { "ragged" };
            assert_eq!(mode, expected, "{what}");
            match cut {
                CutOption::Ragged(_) => repaired.check_ragged(3, &what),
                _ => repaired.check(&what),
            }
        }
    }
}

#[test]
fn tiles_that_stray_without_common_vertices_close_over_borders_and_corners() {
    for reach_m in [0.5, 1.0] {
        let what = format!("reach {reach_m}");
        let options = MakeOptions { cut: CutOption::Ragged(reach_m), seed: 13, ..small() };
        make_and_repair(options, &what).check_ragged(11, &what);
    }
}

/// Wang et al. 2021, sec. 4: 449 cells, 56 closed holes; I: 17 A, 43 B, 4 C, 3 D; II: 5 B, 1 D.
#[test]
fn the_city_shows_the_papers_counts() {
    let options = MakeOptions { triangles: Some(1_000), ..MakeOptions::new(Preset::City) };
    let repaired = make_and_repair(options, "city");
    let expected =
        [("I-A", 17), ("I-B", 43), ("I-C", 4), ("I-D", 3), ("II-B", 5), ("II-D", 1), ("closed", 56)];
    let expected: Counts = expected.into_iter().map(|(k, n)| (k.to_owned(), n)).collect();
    assert_eq!(counts(&repaired.report), expected);
    repaired.check("city");
}
