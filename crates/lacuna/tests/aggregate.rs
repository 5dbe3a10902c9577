//! The baseline: one merged mesh, its closed holes filled, every triangle back in a cell.

mod kit;

use kit::{SceneFolder, digest, files_in, repair, report, same_bytes, small};
use lacuna::report::Outcome;
use lacuna_mesh::{TriMesh, boundary, loops};
use lacuna_tile::{ReadOptions, SceneOptions, open_scene, read_tile};
use scene::maker::{CutOption, MakeOptions, Maker};
use scene::preset::Preset;
use std::path::Path;

const AGGREGATE: [&str; 2] = ["--method", "aggregate"];

/// Loops of the boundary of all tiles together.
fn loops_of(folder: &Path) -> usize {
    let scene = open_scene(folder, &SceneOptions::default()).expect("a scene");
    let mut all = TriMesh::default();
    for entry in &scene.tiles {
        let mesh = read_tile(&scene.path(entry), entry.format, &ReadOptions::default()).expect("a tile").mesh;
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    loops(&boundary(&all)).loops.len()
}

#[test]
fn no_loop_is_left_but_the_outline() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &AGGREGATE).ends(0);
    let report = report(&out);
    assert_eq!((report.summary.found, report.summary.filled, report.summary.skipped), (11, 10, 1));
    let filled = || report.holes.iter().filter(|h| h.outcome == Outcome::Filled);
    assert!(filled().all(|h| h.method.as_deref() == Some("aggregate")));
    assert!(filled().any(|h| h.filler.as_deref() == Some("min_area")));
    assert!(loops_of(scene.path()) > 1);
    assert_eq!(loops_of(&out), 1, "the hole at the scene's edge is a bay of its outline");
}

#[test]
fn the_output_depends_on_nothing_but_the_scene() {
    let scene = small();
    let (one, two) = (scene.beside("one"), scene.beside("two"));
    repair(&scene, &one, &[&AGGREGATE[..], &["-j", "1"]].concat()).ends(0);
    repair(&scene, &two, &[&AGGREGATE[..], &["-j", "3", "--memory", "2GiB"]].concat()).ends(0);
    same_bytes(&digest(&one), &digest(&two), "threads and memory");
}

#[test]
fn what_is_open_to_the_outside_is_left_with_that_reason() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &[&AGGREGATE[..], &["--external", "fill"]].concat()).ends(0);
    let report = report(&out);
    let reasons: Vec<_> = report
        .holes
        .iter()
        .filter(|h| h.outcome == Outcome::Skipped)
        .filter_map(|h| h.reason.as_deref())
        .collect();
    assert_eq!(reasons.len(), 1);
    assert!(reasons[0].contains("no closed hole of the merged mesh"), "{}", reasons[0]);
}

#[test]
fn a_limit_below_the_merged_mesh_ends_with_5_and_says_how_much_is_enough() {
    let scene = SceneFolder::new(|folder| {
        let options = MakeOptions { triangles: Some(8_000), ..MakeOptions::new(Preset::Small) };
        scene::make::make(&Maker::new(options).expect("options"), folder).expect("a scene");
    });
    let out = scene.beside("out");
    let short = repair(&scene, &out, &[&AGGREGATE[..], &["--memory", "30MiB"]].concat());
    short.ends(5).says("(aggregate) needs about").says("give at least --memory");
    assert!(files_in(&out).keys().all(|name| !name.ends_with(".ply")), "nothing was written");
    let enough = short.stderr.rsplit("--memory ").next().expect("a limit").trim().to_owned();
    repair(&scene, &out, &[&AGGREGATE[..], &["--memory", &enough]].concat()).ends(0);
}

#[test]
fn tiles_that_share_no_vertices_are_refused() {
    let scene = SceneFolder::new(|folder| {
        let options = MakeOptions { cut: CutOption::Overrun(0.1), ..MakeOptions::new(Preset::Small) };
        scene::make::make(&Maker::new(options).expect("options"), folder).expect("a scene");
    });
    let out = scene.beside("out");
    repair(&scene, &out, &AGGREGATE).ends(2).says("borders: overrun").says("take field or layered");
}
