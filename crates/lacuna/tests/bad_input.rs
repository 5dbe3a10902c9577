//! Damaged tiles, wrong folders, wrong settings, full disks: each ends with one sentence that names the file and what to
//! do, with the right exit code, and without a half-written tile.
#![allow(clippy::print_stdout, reason = "says which case runs, and what is skipped")]

mod kit;

use kit::scene_folder::tile_of;
use kit::{Run, SceneFolder, digest, files_in, lacuna, repair, report, small};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The tile that is damaged: it holds a closed pond, and no cluster of other tiles reaches it.
const BAD: &str = "Tile_+000_+002";

/// What is done to the bytes of a tile.
type Damage = fn(&[u8]) -> Vec<u8>;

/// Damage that makes a tile unusable, with words that the message must hold beside the tile's name.
const DAMAGES: [(&str, Damage, &str); 9] = [
    ("empty", |_| Vec::new(), "byte 0"),
    ("cut in the header", |ply| ply[..40].to_vec(), "end_header"),
    ("cut in the vertices", |ply| ply[..ply.len() / 4].to_vec(), "the header promises 978 rows"),
    ("cut in the last face", |ply| ply[..ply.len() - 5].to_vec(), "left in the file"),
    ("an OBJ in a .ply", |_| b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "ply"),
    (
        "2^64 faces promised",
        |ply| with_text(ply, "element face ", "element face 18446744073709551616"),
        "line 8",
    ),
    ("a corner past the last vertex", with_wild_corner, "face row 1784"),
    ("2^40 vertices promised", |ply| with_count(ply, "vertex", 1 << 40), "1099511627776"),
    ("no position is a number", without_positions, "not finite"),
];

fn header_length(ply: &[u8]) -> usize {
    let end = b"end_header\n";
    ply.windows(end.len()).position(|w| w == end).expect("a header") + end.len()
}

fn with_text(ply: &[u8], from: &str, to: &str) -> Vec<u8> {
    let (header, rows) = ply.split_at(header_length(ply));
    let header = std::str::from_utf8(header).expect("text").replacen(from, to, 1);
    [header.as_bytes(), rows].concat()
}

fn with_wild_corner(ply: &[u8]) -> Vec<u8> {
    let mut bytes = ply.to_vec();
    let last = bytes.len() - 4;
    bytes[last..].copy_from_slice(&0x00ff_ffff_u32.to_le_bytes());
    bytes
}

fn vertex_count(ply: &[u8]) -> usize {
    let text = String::from_utf8_lossy(&ply[..header_length(ply)]).into_owned();
    let count = text.lines().find_map(|l| l.strip_prefix("element vertex ")).expect("a vertex count");
    count.trim().parse().expect("a number")
}

fn with_count(ply: &[u8], element: &str, count: u64) -> Vec<u8> {
    with_text(ply, &format!("element {element} "), &format!("element {element} {count}\ncomment was "))
}

fn without_positions(ply: &[u8]) -> Vec<u8> {
    let mut bytes = ply.to_vec();
    let (rows, count) = (header_length(ply), vertex_count(ply));
    bytes[rows..rows + 12 * count]
        .chunks_exact_mut(4)
        .for_each(|f| f.copy_from_slice(&f32::NAN.to_le_bytes()));
    bytes
}

fn damage(tile: &Path, how: Damage) {
    let bytes = fs::read(tile).expect("a tile");
    fs::write(tile, how(&bytes)).expect("written");
}

/// One problem, one line: it names the file and asks for something.
#[track_caller]
fn one_sentence(run: &Run, file: &str) {
    let lines: Vec<&str> = run.stderr.lines().filter(|l| !l.trim().is_empty()).collect();
    assert_eq!(lines.len(), 1, "one line, not:\n{}", run.stderr);
    assert!(lines[0].contains(file), "{file} is not named: {}", run.stderr);
    assert!(!run.stderr.contains("panicked") && !run.stderr.contains('\u{1b}'), "{}", run.stderr);
}

/// Files of OUT but those of the report.
fn tiles(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = digest(out);
    files.retain(|name, _| !name.starts_with("lacuna/"));
    files
}

/// Every file that is there is whole: the same bytes as in a good run.
#[track_caller]
fn nothing_half_written(out: &Path, whole: &BTreeMap<String, Vec<u8>>) {
    if !out.exists() {
        return;
    }
    for (name, bytes) in tiles(out) {
        let expected = whole.get(&name);
        assert!(expected == Some(&bytes), "{name} is half-written or a stranger");
    }
}

#[test]
fn a_bad_tile_costs_the_clusters_it_touches() {
    let clean = small();
    let good_out = clean.beside("out");
    repair(&clean, &good_out, &[]).ends(0);
    let good = tiles(&good_out);
    let file = format!("{BAD}/{BAD}.ply");
    for (name, how, word) in DAMAGES {
        println!("{name}");
        let scene = small().changed(|path| damage(&tile_of(path, BAD), how));
        let out = scene.beside("out");
        let run = repair(&scene, &out, &[]);
        run.ends(3);
        one_sentence(&run, &format!("{BAD}.ply"));
        let sentence = run.stderr.to_lowercase();
        assert!(sentence.contains(word), "{name}: no {word:?} in {sentence}");
        let report = report(&out);
        assert!(report.defects.iter().any(|d| d.unusable && d.tile == BAD), "{name}: {:?}", report.defects);
        assert_eq!((report.summary.found, report.summary.filled), (10, 9), "{name}");
        let mut now = tiles(&out);
        let copied = now.remove(&file);
        assert!(copied == fs::read(scene.tile(BAD)).ok(), "{name}: the bad tile is passed on as it is");
        let mut others = good.clone();
        others.remove(&file);
        kit::same_bytes(&others, &now, name);
    }
}

#[test]
fn a_bad_tile_in_a_lake_leaves_the_whole_lake() {
    let scene = small().changed(|path| damage(&tile_of(path, "Tile_+001_+002"), |_| Vec::new()));
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(3);
    let report = report(&out);
    let lake: Vec<_> =
        report.holes.iter().filter(|h| h.cell == [1, 1] || h.tile == "Tile_+000_+001").collect();
    assert!(lake.iter().all(|h| h.outcome != lacuna::report::Outcome::Filled), "{lake:?}");
    assert!(lake.iter().all(|h| h.reason.is_some()), "{lake:?}");
    assert!(!out.join("Tile_+001_+001").exists(), "no tile for the lake's middle");
}

#[test]
fn fail_on_and_strict_decide_how_a_bad_tile_ends() {
    let cases: [(&[&str], i32); 5] = [
        (&[], 3),
        (&["--fail-on", "tiles"], 3),
        (&["--fail-on", "holes"], 3),
        (&["--fail-on", "never"], 0),
        (&["--strict"], 1),
    ];
    for (flags, code) in cases {
        let scene = small().changed(|path| damage(&tile_of(path, BAD), |_| Vec::new()));
        repair(&scene, &scene.beside("out"), flags).ends(code).says(BAD);
    }
}

#[test]
fn some_positions_that_are_no_numbers_do_not_end_the_run() {
    fn one_vertex(ply: &[u8]) -> Vec<u8> {
        let mut bytes = ply.to_vec();
        let row = header_length(ply) + 12 * (vertex_count(ply) / 2);
        bytes[row..row + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes
    }
    let scene = small().changed(|path| damage(&tile_of(path, BAD), one_vertex));
    let out = scene.beside("out");
    let run = repair(&scene, &out, &[]);
    assert!(matches!(run.code, 0 | 3), "{}: {}", run.code, run.stderr);
    assert!(report(&out).defects.iter().any(|d| d.tile == BAD), "the defect stands in the report");
}

#[test]
fn a_stray_vertex_does_not_stretch_the_scene() {
    fn stray(ply: &[u8]) -> Vec<u8> {
        let mut bytes = ply.to_vec();
        let row = header_length(ply) + 12 * (vertex_count(ply) - 1);
        bytes[row..row + 4].copy_from_slice(&1e9_f32.to_le_bytes());
        bytes
    }
    let scene = small().changed(|path| damage(&tile_of(path, BAD), stray));
    for area in ["cells", "box"] {
        let out = scene.beside(area);
        repair(&scene, &out, &["--area", area]).ends(0);
        let report = report(&out);
        let told = report.defects.iter().any(|d| d.tile == BAD && d.what.contains("past its cell"));
        assert!(told, "{:?}", report.defects);
        assert_eq!(report.scene.cells, 9, "{area}");
        let lake = report.holes.iter().find(|h| h.cell == [1, 1]).expect("the lake's middle");
        assert_eq!(lake.outcome, lacuna::report::Outcome::Filled, "{area}");
        lacuna(["verify".as_ref(), scene.path().as_os_str(), out.as_os_str()]).ends(0);
    }
}

#[test]
fn an_area_of_too_many_cells_is_refused() {
    let scene = small();
    let file = scene.beside("world.geojson");
    let square = "[[-1e9, -1e9], [1e9, -1e9], [1e9, 1e9], [-1e9, 1e9], [-1e9, -1e9]]";
    fs::write(&file, format!(r#"{{"type": "Polygon", "coordinates": [{square}]}}"#)).expect("written");
    let out = scene.beside("out");
    let run = repair(&scene, &out, &["--area", file.to_str().expect("UTF-8")]);
    run.ends(2).says("more than a run can plan");
    one_sentence(&run, "world.geojson");
}

#[test]
fn all_tiles_bad_is_a_failed_run() {
    let scene = small().changed(|path| {
        for name in files_in(path).into_keys().filter(|n| n.ends_with(".ply")) {
            fs::write(path.join(name), "no ply").expect("written");
        }
    });
    let out = scene.beside("out");
    let run = repair(&scene, &out, &[]);
    run.ends(1).says("no tile could be read").says("Tile_+000_+000");
    assert_eq!(tiles(&out).len(), 0, "nothing is written");
}

#[test]
fn names_far_out_are_no_panic() {
    let far = |path: &Path, name: &str| path.join(name).join(name).with_extension("ply");
    let beside = |path: &Path, name: &str, bytes: &[u8]| {
        let file = far(path, name);
        fs::create_dir_all(file.parent().expect("a folder")).expect("made");
        fs::write(file, bytes).expect("written");
    };
    for name in ["Tile_+2147483647_+000", "Tile_-2147483648_+001"] {
        let scene = small().changed(|path| beside(path, name, b"ply cut off"));
        repair(&scene, &scene.beside("out"), &[]).ends(3).says(name);
    }
    let scene = small().changed(|path| {
        let good = fs::read(tile_of(path, BAD)).expect("a tile");
        ["Tile_+2000000000_+000", "Tile_-2000000000_+000"].iter().for_each(|name| beside(path, name, &good));
    });
    repair(&scene, &scene.beside("out"), &[]).ends(2).says("too many cells out");
}

#[test]
fn a_missing_scene_is_named_wherever_the_output_lies() {
    let scene = small();
    let (none, out) = (scene.beside("none"), scene.beside("out"));
    lacuna(["repair".as_ref(), none.as_os_str(), out.as_os_str()])
        .ends(4)
        .says("none")
        .says("check the path");
    assert!(!out.exists());
}

#[test]
fn an_area_beside_the_scene_and_dust_are_refused() {
    let scene = small();
    let file = scene.beside("elsewhere.geojson");
    let ring = "[[9e5,9e5],[9.1e5,9e5],[9.1e5,9.1e5],[9e5,9e5]]";
    fs::write(&file, format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#)).expect("written");
    let run = repair(&scene, &scene.beside("out"), &["--area", file.to_str().expect("UTF-8")]);
    run.ends(2).says("elsewhere.geojson").says("do not touch the scene");
    repair(&scene, &scene.beside("dust"), &["--spacing", "1e-9"]).ends(2).says("give at least");
}

#[test]
fn scenes_that_are_none_are_refused() {
    type Spoil = fn(&Path);
    let cases: [(&str, Spoil, i32, &str, &str); 4] = [
        ("missing", |path| fs::remove_dir_all(path).expect("removed"), 4, "scene", "check the path"),
        ("without tiles", |path| empty(path), 2, "scene", "no tile found"),
        (
            "a file",
            |path| {
                (empty(path), fs::remove_dir(path).expect("removed"), fs::write(path, "x").expect("written"))
                    .2
            },
            2,
            "scene",
            "not a folder",
        ),
        ("two tiles for one cell", twice, 2, BAD, "each cell once"),
    ];
    for (name, spoil, code, named, help) in cases {
        println!("{name}");
        let scene = small();
        let folder = scene.beside("spoilt").join("scene");
        kit::copy_tree(scene.path(), &folder);
        spoil(&folder);
        let out = scene.beside("out");
        for verb in ["repair", "inspect", "info"] {
            let mut arguments = vec![verb.as_ref(), folder.as_os_str()];
            arguments.extend((verb == "repair").then_some(out.as_os_str()));
            let run = lacuna(arguments);
            run.ends(code).says(help);
            one_sentence(&run, named);
        }
        assert!(!out.exists() || tiles(&out).is_empty(), "{name}");
    }
}

fn empty(path: &Path) {
    fs::remove_dir_all(path).expect("removed");
    fs::create_dir(path).expect("made");
}

fn twice(path: &Path) {
    let copy = path.join("again").join(BAD).with_extension("ply");
    fs::create_dir_all(copy.parent().expect("a folder")).expect("made");
    fs::copy(tile_of(path, BAD), copy).expect("copied");
}

/// A FIFO would block a reader for ever; a folder with a tile's name is no tile. (Files without permission prove nothing
/// here: the tests may run as root, who reads them.)
#[cfg(unix)]
#[test]
fn odd_files_in_the_place_of_a_tile_do_not_block_the_run() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let fifo = small().changed(|path| {
        let tile = tile_of(path, BAD);
        fs::remove_file(&tile).expect("removed");
        mknodat(CWD, &tile, FileType::Fifo, Mode::from_raw_mode(0o644), 0).expect("a FIFO");
    });
    let run = repair(&fifo, &fifo.beside("out"), &[]);
    assert!(matches!(run.code, 0 | 3), "{}: {}", run.code, run.stderr);
    run.says(BAD);
    let folder = small().changed(|path| {
        let tile = tile_of(path, BAD);
        fs::remove_file(&tile).expect("removed");
        fs::create_dir(&tile).expect("made");
    });
    let run = repair(&folder, &folder.beside("out"), &[]);
    assert!(matches!(run.code, 0 | 3), "{}: {}", run.code, run.stderr);
}

#[cfg(unix)]
#[test]
fn links_out_of_the_scene_are_not_followed() {
    let scene = small();
    let secret = scene.beside("secret.txt");
    fs::write(&secret, "SECRET").expect("written");
    let scene = scene.changed(|path| {
        let link = path.join("Tile_+000_+002/notes.txt");
        std::os::unix::fs::symlink(path.parent().expect("a folder").join("secret.txt"), link)
            .expect("a link");
    });
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(0);
    let leaked =
        files_in(&out).into_iter().filter(|(_, bytes)| bytes.windows(6).any(|w| w == b"SECRET")).count();
    assert_eq!(leaked, 0);
}

#[test]
fn a_missing_texture_is_none_of_our_business() {
    use scene::encode::Format;
    use scene::make::make;
    use scene::maker::{MakeOptions, Maker};
    use scene::preset::Preset;
    let options = MakeOptions { format: Format::Obj, ..MakeOptions::new(Preset::Small) };
    let scene = SceneFolder::new(|path| {
        make(&Maker::new(options).expect("options"), path).expect("a scene");
        let tile = path.join(BAD).join(BAD).with_extension("obj");
        let text = fs::read_to_string(&tile).expect("a tile");
        fs::write(&tile, format!("mtllib {BAD}.mtl\nusemtl roof\n{text}")).expect("written");
        let material = "newmtl roof\nmap_Kd nowhere.jpg\n";
        fs::write(tile.with_extension("mtl"), material).expect("written");
    });
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(0);
    assert_eq!(report(&out).summary.filled, 10);
}

#[test]
fn wrong_configurations_name_the_place_and_the_cure() {
    let scene = small();
    let cases = [
        ("unknown key", "(version: 1, find: (min_area: 2.0))", "min_area_m2"),
        ("wrong unit", "(version: 1, run: (memory: \"2 metres\"))", "512MiB"),
        ("no number", "(version: 1, find: (min_area_m2: \"big\"))", "min_area_m2"),
        ("not RON", "(version: 1, find: (", "expected"),
        ("another version", "(version: 7)", "1"),
        ("a missing polygon", "(version: 1, area: (limit: polygon(\"none.geojson\")))", "none.geojson"),
    ];
    for (name, text, help) in cases {
        let file = scene.beside("wrong.ron");
        fs::write(&file, text).expect("written");
        let out = scene.beside("out");
        let flags = ["--config", file.to_str().expect("UTF-8")];
        let run = repair(&scene, &out, &flags);
        run.ends(2);
        let named = run.stderr.contains("wrong.ron") || run.stderr.contains("none.geojson");
        assert!(named && run.stderr.contains(help), "{name}: {}", run.stderr);
        assert!(!out.exists(), "{name}");
    }
}

#[test]
fn wrong_flags_name_the_flag() {
    let scene = small();
    let cases: [(&[&str], &str); 5] = [
        (&["--cells", "none.txt"], "none.txt"),
        (&["--region", "nowhere"], "nowhere"),
        (&["--area", "none.geojson"], "none.geojson"),
        (&["--cell-size=-3"], "--cell-size"),
        (&["--memory", "many"], "--memory"),
    ];
    for (flags, named) in cases {
        let out = scene.beside("out");
        repair(&scene, &out, flags).ends(2).says(named);
        assert!(!out.exists(), "{flags:?}");
    }
}

#[test]
fn a_limit_too_small_names_the_tile_before_anything_is_written() {
    let scene = small();
    for limit in ["1MiB", "25MiB"] {
        let out = scene.beside("out");
        let run = repair(&scene, &out, &["--memory", limit]);
        run.ends(5).says("--memory");
        one_sentence(&run, if limit == "1MiB" { "program" } else { "Tile_" });
        assert!(!out.exists() || tiles(&out).is_empty(), "{limit}");
    }
}

#[test]
fn a_report_holds_no_path_of_the_machine() {
    let scene = small().changed(|path| damage(&tile_of(path, BAD), |_| Vec::new()));
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(3);
    let place = scene.path().display().to_string();
    let report = report(&out);
    assert!(report.defects.iter().all(|d| !d.what.contains(&place)), "{:?}", report.defects);
}

#[test]
fn a_report_inside_the_scene_is_refused() {
    let scene = small();
    for folder in [scene.path().to_owned(), scene.path().join("look")] {
        let arguments =
            ["inspect".as_ref(), scene.path().as_os_str(), "--report".as_ref(), folder.as_os_str()];
        lacuna(arguments).ends(2).says("scene");
    }
}

#[cfg(unix)]
#[test]
fn a_full_or_closed_stdout_is_no_panic() {
    let scene = small();
    for verb in ["info", "inspect"] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a full device");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_lacuna"))
            .args([verb, "--progress=none"])
            .arg(scene.path())
            .stdin(std::process::Stdio::null())
            .stdout(full)
            .output()
            .expect("the program starts");
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(4), "{verb}: {stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
}

/// The limit that a message asks for.
fn asked_for(run: &Run) -> String {
    let (_, rest) = run.stderr.split_once("at least --memory ").expect("a limit is named");
    rest.split_whitespace().next().expect("a limit").to_owned()
}

#[test]
fn the_limit_that_is_asked_for_is_enough() {
    let scene = small();
    for (limit, flags) in
        [("1MiB", &[][..]), ("16MiB", &["--external", "fill"]), ("25MiB", &[]), ("26MiB", &[])]
    {
        let (refused, out) = (scene.beside("refused"), scene.beside("out"));
        let run = repair(&scene, &refused, &[&["--memory", limit], flags].concat());
        run.ends(5);
        let enough = asked_for(&run);
        repair(&scene, &out, &[&["--overwrite", "--memory", &enough], flags].concat()).ends(0);
    }
}

/// An OBJ of separate triangles, 50 x 50 on a square metre: all that is in it is boundary, and stays in memory.
fn confetti(west_m: u32) -> String {
    let triangle = |k: u32| {
        let (x, y) = (f64::from(west_m) + f64::from(k % 50) * 0.02, f64::from(k / 50) * 0.02);
        let (right, up) = (x + 0.01, y + 0.01);
        let first = 3 * k + 1;
        format!("v {x} {y} 1\nv {right} {y} 1\nv {x} {up} 1\nf {first} {} {}\n", first + 1, first + 2)
    };
    (0..2_500).map(triangle).collect()
}

#[test]
fn what_is_kept_of_all_tiles_counts() {
    let scene = SceneFolder::new(|path| {
        fs::create_dir_all(path).expect("a folder");
        for i in 0..12 {
            fs::write(path.join(format!("Tile_+{i:03}_+000.obj")), confetti(i)).expect("written");
        }
    });
    let run = lacuna(["info".as_ref(), scene.path().as_os_str(), "--memory=32MiB".as_ref()]);
    run.ends(5);
    let enough = format!("--memory={}", asked_for(&run));
    lacuna(["info".as_ref(), scene.path().as_os_str(), enough.as_ref()]).ends(0);
}

/// A file that opens and cannot be read, laid over a file of the scene (the memory of this process has no byte 0).
fn unreadable(file: &Path) -> Option<Mounted> {
    let memory = format!("/proc/{}/mem", std::process::id());
    let status = std::process::Command::new("mount")
        .args(["--bind", &memory])
        .arg(file)
        .stderr(std::process::Stdio::null())
        .status();
    status.is_ok_and(|s| s.success()).then(|| Mounted(file.to_owned()))
}

#[test]
fn a_file_that_cannot_be_copied_is_a_record() {
    let scene = small().changed(|path| fs::write(path.join("notes.txt"), "notes").expect("written"));
    let whole_out = scene.beside("whole");
    repair(&scene, &whole_out, &[]).ends(0);
    let whole = tiles(&whole_out);
    for (name, file, filled) in [("notes.txt", scene.path().join("notes.txt"), 10), (BAD, scene.tile(BAD), 9)]
    {
        let Some(_laid_over) = unreadable(&file) else {
            println!("skipped: files cannot be laid over others here (it needs root)");
            return;
        };
        let out = scene.beside(name);
        let run = repair(&scene, &out, &[]);
        run.ends(3).says(name);
        let report = report(&out);
        let records: Vec<_> = report.defects.iter().filter(|d| d.unusable && d.tile == name).collect();
        assert_eq!(records.len(), 1, "{:?}", report.defects);
        assert_eq!(report.summary.filled, filled);
        let mut expected = whole.clone();
        expected.retain(|path, _| !path.contains(name));
        kit::same_bytes(&expected, &tiles(&out), name);
        repair(&scene, &scene.beside("strict"), &["--strict"]).ends(1).says(name);
    }
}

/// Something mounted, unmounted when dropped: a small file system of its own, or a file laid over another.
struct Mounted(std::path::PathBuf);

impl Mounted {
    fn disk(path: &Path, kibibytes: u32) -> Option<Self> {
        fs::create_dir_all(path).ok()?;
        let size = format!("size={kibibytes}k");
        let status = std::process::Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(path)
            .stderr(std::process::Stdio::null())
            .status();
        status.is_ok_and(|s| s.success()).then(|| Self(path.to_owned()))
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_leaves_no_half_tile() {
    let scene = small();
    let whole_out = scene.beside("whole");
    repair(&scene, &whole_out, &[]).ends(0);
    let whole = tiles(&whole_out);
    for kibibytes in [16, 64, 150, 300, 600] {
        let Some(disk) = Mounted::disk(&scene.beside("disk"), kibibytes) else {
            println!("skipped: a small file system cannot be mounted here (it needs root)");
            return;
        };
        let out = disk.0.join("out");
        let run = repair(&scene, &out, &[]);
        run.ends(4);
        one_sentence(&run, "disk");
        assert!(run.stderr.contains("os error 28") || run.stderr.contains("No space"), "{}", run.stderr);
        nothing_half_written(&out, &whole);
        assert!(!out.join("lacuna/report.json").exists(), "{kibibytes}: a report of a run that failed");
    }
}
