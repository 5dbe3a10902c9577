//! The command line as a user meets it: exit codes, stdout and stderr, files in OUT, and what is refused.

mod kit;

use kit::{SceneFolder, digest, files_in, lacuna, repair, report, same_bytes, small};
use lacuna::report::{Outcome, Report};
use scene::encode::Format;
use scene::make::make;
use scene::maker::{MakeOptions, Maker};
use scene::preset::Preset;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What a run leaves in OUT/lacuna.
const OWN_FILES: [&str; 8] = [
    ".lock",
    "cells.geojson",
    "changed.txt",
    "holes.geojson",
    "manifest.json",
    "plan.json",
    "report.html",
    "report.json",
];

fn filled(report: &Report) -> usize {
    report.holes.iter().filter(|h| h.outcome == Outcome::Filled).count()
}

#[test]
fn repair_fills_and_reports() {
    let scene = small();
    let out = scene.beside("out");
    let run = repair(&scene, &out, &[]);
    run.ends(0);
    assert_eq!(run.stderr, "", "nothing is wrong, nothing is said");
    assert!(run.stdout.starts_with("hole  "), "only the table stands on stdout:\n{}", run.stdout);
    assert!(run.stdout.contains("all                                  11       10        1        -"));
    let long = run.stdout.lines().filter(|l| l.chars().count() > 80 && !l.contains("report.html")).count();
    assert_eq!(long, 0, "80 columns:\n{}", run.stdout);
    let own: Vec<String> = files_in(&out.join("lacuna")).into_keys().collect();
    assert_eq!(own, OWN_FILES);
    let report = report(&out);
    assert_eq!((report.summary.found, report.summary.filled, report.summary.skipped), (11, 10, 1));
    let changed = fs::read_to_string(out.join("lacuna/changed.txt")).expect("a list");
    assert_eq!(changed.lines().collect::<Vec<_>>(), report.changed_tiles);
}

#[test]
fn originals_come_out_byte_for_byte() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(0);
    for (name, before) in files_in(scene.path()) {
        let after = fs::read(out.join(&name)).expect("every file of SCENE stands in OUT");
        if name.ends_with(".ply") {
            let rows =
                |bytes: &[u8]| bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
            let body = &before[rows(&before)..];
            let vertex_rows = body.len() - face_bytes(&before);
            let now = &after[rows(&after)..];
            assert!(now[..vertex_rows] == body[..vertex_rows], "{name}: vertices");
            assert!(contains(now, &body[vertex_rows..]), "{name}: faces");
        } else {
            assert!(after == before, "{name}");
        }
    }
}

/// Bytes of the face rows of a binary PLY of the scene tool: 13 a triangle.
fn face_bytes(ply: &[u8]) -> usize {
    let text = String::from_utf8_lossy(ply);
    let count = text.lines().find_map(|l| l.strip_prefix("element face ")).expect("a face count");
    13 * count.trim().parse::<usize>().expect("a number")
}

fn contains(all: &[u8], part: &[u8]) -> bool {
    part.is_empty() || all.windows(part.len()).any(|w| w == part)
}

#[test]
fn the_same_command_again_leaves_the_same_bytes() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &[]).ends(0);
    let first = digest(&out);
    repair(&scene, &out, &[]).ends(0);
    same_bytes(&first, &digest(&out), "second run");
    fs::write(out.join("mine.txt"), "notes").expect("a file");
    repair(&scene, &out, &["--overwrite"]).ends(0);
    assert_eq!(fs::read_to_string(out.join("mine.txt")).expect("not deleted"), "notes");
    fs::remove_file(out.join("mine.txt")).expect("removed");
    same_bytes(&first, &digest(&out), "--overwrite");
}

#[test]
fn other_settings_on_the_same_folder_leave_what_a_fresh_run_leaves() {
    let scene = small();
    let (out, fresh) = (scene.beside("out"), scene.beside("fresh"));
    repair(&scene, &out, &["--external", "fill"]).ends(0);
    repair(&scene, &out, &["--class", "closed"]).ends(0);
    repair(&scene, &fresh, &["--class", "closed"]).ends(0);
    same_bytes(&digest(&out), &digest(&fresh), "closed after all");
}

#[test]
fn threads_and_memory_do_not_change_a_byte() {
    let scene = small();
    let runs: [&[&str]; 4] = [&["-j", "1"], &["-j", "2"], &["-j", "7"], &["-j", "2", "--memory", "32MiB"]];
    let digests: Vec<_> = (0..)
        .zip(runs)
        .map(|(k, flags)| {
            let out = scene.beside(&format!("out{k}"));
            repair(&scene, &out, flags).ends(0);
            digest(&out)
        })
        .collect();
    for (flags, other) in runs.iter().zip(&digests) {
        same_bytes(&digests[0], other, &flags.join(" "));
    }
}

#[test]
fn omit_leaves_out_what_is_unchanged() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &["--untouched", "omit", "--class", "closed"]).ends(0);
    let tiles: Vec<String> = files_in(&out).into_keys().filter(|f| !f.starts_with("lacuna/")).collect();
    assert_eq!(tiles, ["Tile_+000_+002/Tile_+000_+002.ply", "Tile_+002_+002/Tile_+002_+002.ply"]);
    let changed = fs::read_to_string(out.join("lacuna/changed.txt")).expect("a list");
    assert_eq!(changed.lines().collect::<Vec<_>>(), tiles);
}

/// Two formats with files beside the tiles, and a tile of two files of which one gets the patch.
#[test]
fn changed_txt_lists_what_differs_from_the_scene() {
    let made = |format| {
        let options = MakeOptions { format, ..MakeOptions::new(Preset::Small) };
        SceneFolder::new(|path| {
            make(&Maker::new(options).expect("options"), path).expect("a scene");
        })
    };
    let in_parts = small().changed(|path| {
        let name = "Tile_+000_+002";
        let part = |k: u32| path.join(name).join(format!("{name}_L20_{k}.ply"));
        fs::rename(path.join(name).join(name).with_extension("ply"), part(1)).expect("renamed");
        let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        fs::write(part(2), format!("{header}50 201 0\n51 201 0\n50 202 0\n3 0 1 2\n")).expect("written");
    });
    for (name, scene) in [("obj", made(Format::Obj)), ("glb", made(Format::Glb)), ("parts", in_parts)] {
        let out = scene.beside("out");
        repair(&scene, &out, &["--class", "closed"]).ends(0);
        let before = files_in(scene.path());
        let mut after = files_in(&out);
        after.retain(|path, bytes| !path.starts_with("lacuna/") && before.get(path) != Some(bytes));
        let changed = fs::read_to_string(out.join("lacuna/changed.txt")).expect("a list");
        assert_eq!(changed.lines().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>(), "{name}");
        let report = report(&out);
        assert_eq!(
            (report.changed_tiles.len(), filled(&report)),
            (2, 2),
            "{name}: {:?}",
            report.changed_tiles
        );
    }
}

#[test]
fn a_dry_run_and_inspect_write_nothing() {
    let scene = small();
    let out = scene.beside("out");
    let dry = repair(&scene, &out, &["--dry-run"]);
    dry.ends(0);
    assert!(dry.stdout.contains("all                                  11        -       11        -"));
    assert!(!out.exists(), "a dry run made its output folder");
    let inspected = lacuna(["inspect".as_ref(), scene.path().as_os_str()]);
    inspected.ends(0);
    let table = |text: &str| text.split("\nChanged").next().map(str::to_owned);
    assert_eq!(table(&inspected.stdout), table(&dry.stdout));
    assert_eq!(fs::read_dir(scene.beside(".")).expect("a folder").count(), 1, "only the scene is there");
}

#[test]
fn inspect_reports_into_a_folder() {
    let scene = small();
    let look = scene.beside("look");
    lacuna(["inspect".as_ref(), scene.path().as_os_str(), "--report".as_ref(), look.as_os_str()]).ends(0);
    let files: Vec<String> = files_in(&look).into_keys().collect();
    assert_eq!(files, ["cells.geojson", "holes.geojson", "report.html", "report.json"]);
    let report = report(&look);
    let reasons: BTreeSet<_> = report.holes.iter().filter_map(|h| h.reason.as_deref()).collect();
    assert!(reasons.contains("inspected only"), "{reasons:?}");
    assert!(report.holes.iter().all(|h| h.outcome == Outcome::Skipped));
}

#[test]
fn info_describes_the_scene() {
    let scene = small();
    let run = lacuna(["info".as_ref(), scene.path().as_os_str(), "--json".as_ref()]);
    run.ends(0);
    let info: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON alone on stdout");
    assert_eq!(info["formats"]["PLY"], 8);
    assert_eq!(info["cells"], 8);
    assert_eq!(info["cell_size_m"], 100.0);
    assert_eq!(info["border_mode"], "exact");
    let text = lacuna(["info".as_ref(), scene.path().as_os_str()]);
    text.ends(0);
    assert!(text.stdout.contains("8 cells of 100 m"), "{}", text.stdout);
}

/// The small scene holds a lake (A and 2 B), a river (C and 2 B), an island pond (D and B), 2 closed ponds and one pond
/// at the edge (B).
#[test]
fn filters_take_whole_clusters() {
    let scene = small();
    let cases: [(&[&str], usize); 13] = [
        (&[], 10),
        (&["--external", "skip"], 10),
        (&["--external", "fill"], 11),
        (&["--class", "closed"], 2),
        (&["--class", "I"], 8),
        (&["--class", "II", "--external", "fill"], 1),
        (&["--class", "II"], 0),
        (&["--class", "closed,I"], 10),
        (&["--shape", "A"], 3),
        (&["--shape", "c"], 3),
        (&["--shape", "D"], 2),
        (&["--min-area", "5000"], 3),
        (&["--max-area", "1500"], 2),
    ];
    for (k, (flags, expected)) in cases.into_iter().enumerate() {
        let out = scene.beside(&format!("out{k}"));
        repair(&scene, &out, flags).ends(0);
        let report = report(&out);
        assert_eq!(filled(&report), expected, "{flags:?}");
        assert!(
            report.holes.iter().all(|h| (h.outcome == Outcome::Filled) == h.reason.is_none()),
            "{flags:?}"
        );
    }
}

#[test]
fn a_run_can_be_limited_to_one_cluster() {
    let scene = small();
    let look = scene.beside("look");
    lacuna(["inspect".as_ref(), scene.path().as_os_str(), "--report".as_ref(), look.as_os_str()]).ends(0);
    let inspected = report(&look);
    let lake = inspected.clusters.iter().max_by(|a, b| a.area_m2.total_cmp(&b.area_m2)).expect("a cluster");
    let hole = inspected.holes.iter().find(|h| h.cluster == lake.id).expect("a hole of the lake");
    let list = scene.beside("list.txt");
    fs::write(&list, "Tile_+000_+002\n").expect("a list");
    let list = list.to_str().expect("UTF-8").to_owned();
    let nowhere = scene.beside("nowhere");
    repair(&scene, &nowhere, &["--at", "0.5,0.5"]).ends(2);
    let cases: [(&[&str], usize); 4] = [
        (&["--at", "150,150"], 3),
        (&["--hole", &hole.id], 3),
        (&["--hole", &lake.id], 3),
        (&["--cells", &list], 1),
    ];
    for (k, (flags, expected)) in cases.into_iter().enumerate() {
        let out = scene.beside(&format!("out{k}"));
        repair(&scene, &out, flags).ends(0);
        assert_eq!(filled(&report(&out)), expected, "{flags:?}");
    }
}

#[test]
fn a_selection_that_selects_nothing_says_so() {
    let scene = small();
    let list = scene.beside("list.txt");
    fs::write(&list, "Tile_+009_+009\n").expect("written");
    let list = list.to_str().expect("UTF-8").to_owned();
    for flags in [["--at", "5000,5000"], ["--hole", "nonsense"], ["--cells", &list]] {
        let run = repair(&scene, &scene.beside("out"), &flags);
        assert!(run.stderr.contains(flags[0]), "{flags:?}: nothing is said: {}", run.stderr);
        run.ends(2);
    }
    repair(&scene, &scene.beside("out"), &["--cells", &list]).says("did you mean Tile_+00");
    fs::write(&list, "Tile_+002_+000\nTile_+009_+009\n").expect("written");
    repair(&scene, &scene.beside("out"), &["--cells", &list]).ends(2).says("Tile_+009_+009");
}

#[test]
fn a_region_without_a_hole_is_said() {
    let scene = small();
    let file = scene.beside("regions.ron");
    let text = r#"(version: 1, regions: [(name: "basin", at: point(9000, 9000), skip: "open"), (name: "lake", at: point(150, 150), skip: "open")])"#;
    fs::write(&file, text).expect("a file");
    let run = repair(&scene, &scene.beside("out"), &["--config", file.to_str().expect("UTF-8")]);
    run.ends(0).says("region basin: no hole lies in it");
    assert!(!run.stderr.contains("region lake"), "{}", run.stderr);
}

#[test]
fn an_unfinished_run_of_a_part_is_finished_by_the_same_command() {
    let scene = small();
    let (out, fresh) = (scene.beside("out"), scene.beside("fresh"));
    for folder in [&out, &fresh] {
        repair(&scene, folder, &["--at", "150,150"]).ends(0);
    }
    repair(&scene, &out, &["--at", "150,150"]).ends(2).says("holds an earlier run");
    let manifest = out.join("lacuna/manifest.json");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    let unfinished = text.replacen("\"finished\": true", "\"finished\": false", 1);
    assert_ne!(text, unfinished, "the manifest says that it is finished");
    fs::write(&manifest, unfinished).expect("written");
    repair(&scene, &out, &["--at", "150,150"]).ends(0);
    same_bytes(&digest(&fresh), &digest(&out), "finished and fresh");
}

#[test]
fn a_configuration_file_does_what_flags_do() {
    let scene = small();
    let (by_file, by_flags) = (scene.beside("by_file"), scene.beside("by_flags"));
    let file = scene.beside("lake.ron");
    let text =
        r#"(version: 1, scene: (input: "scene", output: "by_file"), find: (shape: [A], min_area_m2: 10))"#;
    fs::write(&file, text).expect("a file");
    lacuna(["repair".as_ref(), "--config".as_ref(), file.as_os_str()]).ends(0);
    repair(&scene, &by_flags, &["--shape", "A", "--min-area", "10"]).ends(0);
    same_bytes(&digest(&by_file), &digest(&by_flags), "file and flags");
    let named =
        ["repair".as_ref(), "-i".as_ref(), scene.path().as_os_str(), "-o".as_ref(), by_flags.as_os_str()];
    lacuna(named).ends(0);
}

#[test]
fn outputs_that_would_touch_the_scene_are_refused() {
    let scene = small();
    let link = scene.beside("link");
    #[cfg(unix)]
    std::os::unix::fs::symlink(scene.path(), &link).expect("a link");
    let cases = [
        (scene.path().to_owned(), "is the scene itself"),
        (scene.path().join("."), "is the scene itself"),
        (link.clone(), "is the scene itself"),
        (scene.path().join("out"), "lies inside the scene"),
        (link.join("deep/out"), "lies inside the scene"),
        (scene.beside("."), "holds the scene"),
    ];
    for (out, why) in cases {
        repair(&scene, &out, &[]).ends(2).says(why);
        repair(&scene, &out, &["--overwrite"]).ends(2);
    }
    fs::remove_file(link).expect("removed");
}

#[test]
fn a_folder_with_other_files_is_refused() {
    let scene = small();
    let out = scene.beside("out");
    fs::create_dir(&out).expect("a folder");
    fs::write(out.join("mine.txt"), "notes").expect("a file");
    for flags in [&[][..], &["--overwrite"]] {
        let run = repair(&scene, &out, flags);
        run.ends(2).says("holds files that no run of lacuna left").says("give an empty or new folder");
        assert_eq!(files_in(&out).into_keys().collect::<Vec<_>>(), ["mine.txt"]);
    }
}

#[test]
fn two_runs_do_not_share_an_output() {
    let scene = small();
    let out = scene.beside("out");
    fs::create_dir_all(out.join("lacuna")).expect("a folder");
    let lock = File::create(out.join("lacuna/.lock")).expect("a lock file");
    lock.lock().expect("a lock");
    repair(&scene, &out, &[]).ends(75).says("another run").says("wait for it or stop it");
    assert_eq!(files_in(&out).len(), 1, "nothing was written");
    drop(lock);
    repair(&scene, &out, &[]).ends(0);
}

#[test]
fn what_is_not_in_this_version_says_so() {
    let scene = small();
    let out = scene.beside("out");
    repair(&scene, &out, &["--resume"]).ends(2).says("not in this version");
    assert!(!out.exists());
    let help = lacuna(["repair", "--help"]).stdout;
    assert!(!help.contains("--resume") && help.contains("aggregate"), "{help}");
}

#[test]
fn wrong_usage_ends_with_2() {
    let cases: [&[&str]; 7] = [
        &[],
        &["repair"],
        &["mend", "scene", "out"],
        &["repair", "scene", "out", "--frobnicate"],
        &["repair", "scene", "out", "--min-area", "big"],
        &["repair", "scene", "out", "--memory", "512"],
        &["repair", "scene"],
    ];
    for arguments in cases {
        let run = lacuna(arguments);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{arguments:?}: {}", run.stderr);
        assert!(!run.stderr.is_empty());
    }
}

/// A scene that takes long enough to be stopped.
fn large() -> SceneFolder {
    let options =
        MakeOptions { cells: Some([12, 5]), triangles: Some(4_000), ..MakeOptions::new(Preset::Demo) };
    SceneFolder::new(|path| {
        make(&Maker::new(options).expect("options"), path).expect("a scene");
    })
}

fn start(scene: &SceneFolder, out: &Path, flags: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(["repair", "--progress=none", "-j", "1"])
        .args([scene.path(), out])
        .args(flags)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts")
}

#[cfg(unix)]
fn send(child: &Child, signal: rustix::process::Signal) {
    let id = rustix::process::Pid::from_raw(i32::try_from(child.id()).expect("an id")).expect("an id");
    rustix::process::kill_process(id, signal).expect("the process is there");
}

/// Waits until something is there, or the run has ended.
fn wait_for(child: &mut Child, is_there: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_there() && child.try_wait().expect("a state").is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "the run hangs");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_run_is_finished_by_the_same_command() {
    use rustix::process::Signal;
    let scene = large();
    let whole = scene.beside("whole");
    repair(&scene, &whole, &[]).ends(0);
    let expected = digest(&whole);
    for (name, signal, code) in [
        ("interrupted", Signal::INT, Some(130)),
        ("terminated", Signal::TERM, Some(143)),
        ("killed", Signal::KILL, None),
    ] {
        for (moment, waited_for) in [("early", "lacuna/.lock"), ("late", "lacuna/manifest.json")] {
            let out = scene.beside(&format!("{name}_{moment}"));
            let mut child = start(&scene, &out, &[]);
            wait_for(&mut child, || out.join(waited_for).exists());
            send(&child, signal);
            let ended = child.wait().expect("an end").code();
            assert_eq!(ended, code, "{name} {moment}");
            if name != "killed" {
                let half: Vec<_> = files_in(&out).into_keys().filter(|f| f.contains(".lacuna-")).collect();
                assert_eq!(half, Vec::<String>::new(), "half-written files after {name}");
            }
            assert!(!out.join("lacuna/report.json").exists(), "no report of a run that was not finished");
            repair(&scene, &out, &[]).ends(0);
            same_bytes(&expected, &digest(&out), name);
        }
    }
}

/// The first fill alone takes several seconds at this spacing, and nobody looks at a flag in it.
#[cfg(unix)]
#[test]
fn a_signal_during_a_long_fill_ends_the_run_at_once() {
    use rustix::process::Signal;
    let scene = small();
    for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143)] {
        let out = scene.beside("out");
        let mut child = start(&scene, &out, &["--spacing", "0.25"]);
        wait_for(&mut child, || out.join("lacuna/.lock").exists());
        std::thread::sleep(Duration::from_secs(1));
        let sent = Instant::now();
        send(&child, signal);
        assert_eq!(child.wait().expect("an end").code(), Some(code));
        assert!(sent.elapsed() < Duration::from_secs(2), "{:?}", sent.elapsed());
        assert_eq!(files_in(&out).into_keys().collect::<Vec<_>>(), ["lacuna/.lock"]);
    }
}
