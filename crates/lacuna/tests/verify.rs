//! `verify` holds the promises for what a run writes, and names the right promise for every damage.

mod damage;
mod kit;

use damage::{PlyTile, edit_json, relist, surface};
use kit::{SceneFolder, copy_tree, small};
use lacuna::{Again, Status, Verdict, VerifyOptions, digest, verify};
use scene::encode::Format;
use scene::make::make;
use scene::maker::{CutOption, MakeOptions, Maker};
use scene::preset::Preset;
use std::path::{Path, PathBuf};

const NEVER: VerifyOptionsOf = VerifyOptionsOf(Again::Never);

/// Options with one thread.
struct VerifyOptionsOf(Again);

impl VerifyOptionsOf {
    fn judge(&self, scene: &Path, out: &Path) -> Verdict {
        let options = VerifyOptions { threads: 1, again: self.0, ..VerifyOptions::default() };
        verify(scene, out, &options).unwrap_or_else(|e| panic!("{e}"))
    }
}

fn broken(verdict: &Verdict) -> Vec<u8> {
    verdict.promises.iter().filter(|p| p.status == Status::Broken).map(|p| p.number).collect()
}

fn repaired(scene: SceneFolder, flags: &[&str]) -> (SceneFolder, PathBuf) {
    let out = scene.beside("out");
    kit::repair(&scene, &out, flags).ends(0);
    (scene, out)
}

fn made(options: MakeOptions) -> SceneFolder {
    let maker = Maker::new(options).expect("a scene");
    SceneFolder::new(|path| {
        make(&maker, path).expect("written");
    })
}

/// The file of a tile in OUT.
fn tile_of(out: &Path, tile: &str) -> PathBuf {
    out.join(tile).join(tile).with_extension("ply")
}

fn edit(out: &Path, tile: &str, change: fn(&mut PlyTile)) {
    let path = tile_of(out, tile);
    let mut parts = PlyTile::read(&path);
    change(&mut parts);
    parts.write(&path);
    relist(out);
}

#[test]
fn a_repair_keeps_all_promises() {
    let (scene, out) = repaired(small(), &[]);
    let verdict = VerifyOptionsOf(Again::Always).judge(scene.path(), &out);
    assert!(verdict.is_ok(), "{}", verdict.to_text());
    let judged: Vec<u8> =
        verdict.promises.iter().filter(|p| p.status == Status::Held).map(|p| p.number).collect();
    assert_eq!(judged, [1, 2, 3, 4, 5, 6, 7, 8], "{}", verdict.to_text());
    let count = |promise: u8, name: &str| verdict.promise(promise).expect("a result").counts[name];
    assert_eq!(
        (count(5, "patches"), count(7, "filled holes looked for"), count(8, "patches marked")),
        (10, 10, 10)
    );
    assert!(count(4, "borders") >= 7 && count(4, "border vertices") > 100, "{}", verdict.to_text());
    assert!(count(7, "places looked at") > 1000, "{}", verdict.to_text());
}

#[test]
fn repairs_of_every_format_keep_all_promises() {
    let small = || MakeOptions::new(Preset::Small);
    let cases = [
        ("OBJ", MakeOptions { format: Format::Obj, ..small() }, vec![]),
        ("GLB", MakeOptions { format: Format::Glb, ..small() }, vec![]),
        ("filled up to the edge", small(), vec!["--external", "fill"]),
        ("box", small(), vec!["--area", "box", "--external", "fill"]),
        ("omitted", small(), vec!["--untouched", "omit", "--max-area", "1000"]),
    ];
    for (name, options, flags) in cases {
        let (scene, out) = repaired(made(options), &flags);
        let verdict = NEVER.judge(scene.path(), &out);
        assert!(verdict.is_ok(), "{name}:\n{}", verdict.to_text());
        assert_eq!(verdict.promise(5).expect("a result").status, Status::Held, "{name}");
        let seams = if name == "omitted" { Status::NotJudged } else { Status::Held };
        assert_eq!(verdict.promise(4).expect("a result").status, seams, "{name}:\n{}", verdict.to_text());
    }
}

#[test]
fn tiles_that_overrun_their_cell_are_compared_over_the_overlap() {
    let options = MakeOptions { cut: CutOption::Overrun(0.1), ..MakeOptions::new(Preset::Small) };
    let (scene, out) = repaired(made(options), &[]);
    let verdict = NEVER.judge(scene.path(), &out);
    assert!(verdict.is_ok(), "{}", verdict.to_text());
    let seams = verdict.promise(4).expect("a result");
    assert_eq!(seams.status, Status::Held);
    assert!(seams.counts["overlaps"] >= 5 && seams.counts["samples"] > 50, "{}", verdict.to_text());
    edit(&out, BORDER, surface::raise_overlap);
    assert_eq!(broken(&NEVER.judge(scene.path(), &out)), [4]);
}

/// The widest margins that these scenes can have, a lake over four cells, one at the scene's edge: strips, and squares where
/// they meet.
#[test]
fn cells_that_overlap_agree_at_corners_and_at_the_scenes_edge() {
    for (preset, triangles, margin_m) in [(Preset::Small, 8_000, 0.6), (Preset::A, 4_000, 2.2)] {
        let options = MakeOptions {
            cut: CutOption::Overrun(margin_m),
            triangles: Some(triangles),
            seed: 6,
            ..MakeOptions::new(preset)
        };
        let (scene, out) = repaired(made(options), &["--area", "box", "--external", "fill"]);
        let verdict = NEVER.judge(scene.path(), &out);
        assert!(verdict.is_ok(), "{}", verdict.to_text());
        let seams = verdict.promise(4).expect("a result");
        assert!(seams.counts["samples"] > 100, "{}", verdict.to_text());
    }
}

/// A damage: to which tile, which promises it must break, which it may break besides.
type Damage = (&'static str, &'static str, fn(&mut PlyTile), &'static [u8], &'static [u8]);

const CLOSED: &str = "Tile_+000_+002";
const BORDER: &str = "Tile_+000_+000";
const HOLLOW: &str = "Tile_+001_+001";

const DAMAGES: [Damage; 18] = [
    ("a delivered vertex moved", BORDER, surface::move_delivered_vertex, &[2], &[]),
    ("a border vertex 1 mm up", BORDER, surface::lift_border_vertex, &[4], &[]),
    ("a border vertex 1 mm off the border", BORDER, surface::pull_border_vertex, &[4], &[]),
    ("a T-junction on the border", BORDER, surface::split_border_edge, &[4, 8], &[]),
    ("a T-junction at the rim", CLOSED, surface::split_rim_edge, &[5, 8], &[]),
    ("a flipped triangle", CLOSED, surface::flip_face, &[5], &[]),
    ("a triangle twice", CLOSED, surface::repeat_face, &[5, 8], &[]),
    ("a hole left open", CLOSED, surface::leave_hole_open, &[7, 8], &[]),
    ("one triangle left out", CLOSED, surface::leave_face_out, &[7, 8], &[]),
    ("a second sheet", CLOSED, surface::add_sheet, &[5, 8], &[]),
    ("a patch above its rim", CLOSED, surface::lift_patch, &[5], &[]),
    ("no number", CLOSED, surface::lose_height, &[5, 7, 8], &[]),
    ("a vertex that does not exist", CLOSED, surface::name_missing_vertex, &[5], &[7, 8]),
    ("a flat triangle", CLOSED, surface::collapse_face, &[5], &[7]),
    ("a new tile upside down", HOLLOW, surface::turn_tile_over, &[5], &[4]),
    ("a patch upside down", CLOSED, surface::turn_tile_over, &[5], &[]),
    ("a fold", CLOSED, surface::fold, &[5], &[]),
    ("a wall", CLOSED, surface::raise_wall, &[], &[]),
];

#[test]
fn damages_to_tiles_break_the_right_promise() {
    let (scene, out) = repaired(small(), &[]);
    for (number, (name, tile, change, must, may)) in DAMAGES.into_iter().enumerate() {
        let damaged = scene.beside(&format!("damaged_{number}"));
        copy_tree(&out, &damaged);
        edit(&damaged, tile, change);
        let verdict = NEVER.judge(scene.path(), &damaged);
        let found = broken(&verdict);
        let text = verdict.to_text();
        assert!(must.iter().all(|p| found.contains(p)), "{name}: {must:?} not all in {found:?}\n{text}");
        assert!(
            found.iter().all(|p| must.contains(p) || may.contains(p)),
            "{name}: {found:?}, not only {must:?}\n{text}"
        );
    }
}

/// A damage to files or records of OUT (second path) or to SCENE (first path).
type FileDamage = (&'static str, fn(&Path, &Path), &'static [u8]);

const FILE_DAMAGES: [FileDamage; 15] = [
    ("the input changed", |scene, _| append(&scene.join("Tile_+000_+000/Tile_+000_+000.ply"), b"x"), &[1, 2]),
    ("a half-written file", |_, out| write(&out.join("Tile_+000_+000/.lacuna-x.tmp"), b"x"), &[1]),
    ("an output changed", |_, out| append(&out.join("Tile_+000_+000/Tile_+000_+000.ply"), b"x"), &[1, 2]),
    ("a side file changed", |_, out| relisted(out, |out| append(&out.join("truth.csv"), b"x")), &[2]),
    ("a side file missing", |_, out| remove(&out.join("truth.csv")), &[1, 2]),
    ("a tile missing", |_, out| remove(&tile_of(out, "Tile_+001_+002")), &[1, 2, 4, 7, 8]),
    ("a new tile missing", |_, out| remove(&tile_of(out, HOLLOW)), &[1, 4, 7, 8]),
    ("a tile nobody asked for", |_, out| copy(out, "Tile_+000_+000", "Tile_+009_+009"), &[8]),
    ("over the memory limit", |_, out| report(out, |r| r["peak_rss_bytes"] = (1_u64 << 50).into()), &[6]),
    ("another sum", |_, out| report(out, |r| r["summary"]["found"] = 12.into()), &[7]),
    (
        "another sum by type",
        |_, out| report(out, |r| r["summary"]["by_type"]["I-B"]["filled"] = 1.into()),
        &[7],
    ),
    ("no reason", |_, out| report(out, |r| hole(r, "skipped")["reason"] = "".into()), &[7]),
    (
        "half a cluster",
        |_, out| report(out, |r| hole(r, "filled")["cluster"] = skipped_cluster(r).into()),
        &[8],
    ),
    ("another mark", |_, out| edit(out, CLOSED, |t| t.header.iter_mut().for_each(rename_mark)), &[8]),
    ("no mark", |_, out| edit(out, CLOSED, |t| t.header.retain(|l| !l.contains("lacuna patch"))), &[8]),
];

#[test]
fn damages_to_files_and_records_break_the_right_promise() {
    let (source, out) = repaired(small(), &[]);
    for (number, (name, change, expected)) in FILE_DAMAGES.into_iter().enumerate() {
        let folder = source.beside(&format!("damaged_{number}"));
        let (scene, damaged) = (folder.join("scene"), folder.join("out"));
        copy_tree(source.path(), &scene);
        copy_tree(&out, &damaged);
        change(&scene, &damaged);
        let verdict = NEVER.judge(&scene, &damaged);
        assert_eq!(broken(&verdict), expected, "{name}:\n{}", verdict.to_text());
        assert!(verdict.to_text().lines().all(|line| line.chars().count() <= 80 || !line.contains(' ')));
    }
}

#[test]
fn another_result_of_the_same_run_breaks_promise_3() {
    let (scene, out) = repaired(small(), &[]);
    edit_json(&out, "plan.json", |plan| plan["unclear_stretches"] = 7.into());
    let verdict = VerifyOptionsOf(Again::Always).judge(scene.path(), &out);
    assert_eq!(broken(&verdict), [3], "{}", verdict.to_text());
}

#[test]
fn damages_to_obj_and_glb_break_the_right_promise() {
    for (format, marker, change) in [
        (Format::Obj, "v ", obj_vertex as fn(&mut [u8])),
        (Format::Obj, "# hole", |b: &mut [u8]| replace_last(b, b"# hole ", b"# Hole ")),
        (Format::Glb, "BIN", |b: &mut [u8]| invert_byte(b, b"BIN\0", 12)),
        (Format::Glb, "hole", |b: &mut [u8]| replace_last(b, b"\"hole\":", b"\"holl\":")),
    ] {
        let (scene, out) = repaired(made(MakeOptions { format, ..MakeOptions::new(Preset::Small) }), &[]);
        let path = tile_of(&out, CLOSED).with_extension(format.extension());
        let mut bytes = std::fs::read(&path).expect("a tile");
        change(&mut bytes);
        std::fs::write(&path, bytes).expect("written");
        relist(&out);
        let verdict = NEVER.judge(scene.path(), &out);
        let expected = if marker.contains("hole") { 8 } else { 2 };
        assert!(broken(&verdict).contains(&expected), "{format:?} {marker}:\n{}", verdict.to_text());
    }
}

#[test]
fn digests_agree_for_equal_runs_alone() {
    let (scene, out) = repaired(small(), &["-j", "1"]);
    let again = scene.beside("again");
    kit::repair(&scene, &again, &["-j", "2", "--memory", "200MiB"]).ends(0);
    let first = digest(&out).expect("a digest");
    assert_eq!(first, digest(&again).expect("a digest"));
    assert!(first.len() == 64 && first.bytes().all(|b| b.is_ascii_hexdigit()));
    report(&again, |r| r["threads"] = 77.into());
    assert_eq!(first, digest(&again).expect("a digest"), "run facts do not count");
    append(&again.join("README.md"), b"x");
    assert_ne!(first, digest(&again).expect("a digest"));
}

#[test]
fn what_is_no_finished_run_is_refused() {
    let (scene, out) = repaired(small(), &[]);
    let options = VerifyOptions::default();
    let refused = |out: &Path| verify(scene.path(), out, &options).expect_err("refused").message;
    assert!(refused(scene.path()).contains("manifest.json"));
    edit_json(&out, "manifest.json", |m| m["finished"] = false.into());
    assert!(refused(&out).contains("did not finish"));
    assert!(digest(scene.path()).is_err());
}

fn append(path: &Path, more: &[u8]) {
    let mut bytes = std::fs::read(path).expect("a file");
    bytes.extend(more);
    write(path, &bytes);
}

fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("written");
}

fn remove(path: &Path) {
    std::fs::remove_file(path).expect("removed");
}

fn copy(out: &Path, from: &str, to: &str) {
    std::fs::create_dir_all(out.join(to)).expect("a folder");
    std::fs::copy(tile_of(out, from), tile_of(out, to)).expect("copied");
}

fn relisted(out: &Path, change: impl FnOnce(&Path)) {
    change(out);
    relist(out);
}

fn report(out: &Path, change: impl FnOnce(&mut serde_json::Value)) {
    edit_json(out, "report.json", change);
}

/// The first hole of this outcome.
fn hole<'a>(report: &'a mut serde_json::Value, outcome: &str) -> &'a mut serde_json::Value {
    let holes = report["holes"].as_array_mut().expect("holes");
    holes.iter_mut().find(|h| h["outcome"] == outcome).expect("such a hole")
}

fn skipped_cluster(report: &serde_json::Value) -> String {
    let clusters = report["clusters"].as_array().expect("clusters");
    let cluster = clusters.iter().find(|c| c["outcome"] == "skipped").expect("such a cluster");
    cluster["id"].as_str().expect("an id").to_owned()
}

fn rename_mark(line: &mut String) {
    if line.contains("lacuna patch") {
        line.push('9');
    }
}

/// Another digit in the first vertex line.
fn obj_vertex(bytes: &mut [u8]) {
    let start = bytes.windows(3).position(|w| w == b"\nv ").expect("a vertex") + 3;
    let digit = start + bytes[start..].iter().position(u8::is_ascii_digit).expect("a digit");
    bytes[digit] = if bytes[digit] == b'9' { b'8' } else { bytes[digit] + 1 };
}

fn replace_last(bytes: &mut [u8], from: &[u8], to: &[u8]) {
    let at = bytes.windows(from.len()).rposition(|w| w == from).expect("such bytes");
    bytes[at..at + to.len()].copy_from_slice(to);
}

fn invert_byte(bytes: &mut [u8], after: &[u8], offset: usize) {
    let at = bytes.windows(after.len()).position(|w| w == after).expect("such bytes") + offset;
    bytes[at] ^= 1;
}
