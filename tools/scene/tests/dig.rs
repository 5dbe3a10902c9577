//! What digging promises: only faces go, everything else stays.
#![allow(clippy::print_stdout, reason = "a skipped test says so")]

use scene::dig::{DigError, DigOptions, dig};
use scene::encode::Format;
use scene::make::make;
use scene::maker::{MakeOptions, Maker};
use scene::preset::Preset;
use std::collections::BTreeMap;
use std::path::Path;

const DISCS: DigOptions = DigOptions { discs: 4, radius_m: [6.0, 12.0], across_borders: true, seed: 1 };

fn source(format: Format, folder: &Path) {
    let options = MakeOptions { format, ..MakeOptions::new(Preset::Small) };
    make(&Maker::new(options).unwrap(), folder).unwrap();
    std::fs::write(folder.join("metadata.xml"), "<kept/>").unwrap();
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            all.extend(contents(&entry.path()).into_iter().map(|(k, v)| (format!("{name}/{k}"), v)));
        } else {
            all.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    all
}

#[test]
fn obj_tiles_lose_face_lines_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (folder.path().join("scene"), folder.path().join("out"));
    source(Format::Obj, &scene);
    let summary = dig(&scene, &out, &DISCS).unwrap();
    let (before, after) = (contents(&scene), contents(&out));
    assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>());
    assert_eq!(after["metadata.xml"], b"<kept/>");
    let mut gone = 0;
    for name in before.keys().filter(|n| n.ends_with(".obj")) {
        let lines = |bytes: &[u8]| -> Vec<String> {
            String::from_utf8_lossy(bytes).lines().map(String::from).collect()
        };
        let (old, new) = (lines(&before[name]), lines(&after[name]));
        let is_face = |l: &&String| l.starts_with("f ");
        assert!(old.iter().filter(|l| !is_face(l)).eq(new.iter().filter(|l| !is_face(l))), "{name}");
        let mut rest = old.iter();
        assert!(new.iter().all(|line| rest.any(|l| l == line)), "{name}: lines keep their order");
        gone += old.len() - new.len();
    }
    assert_eq!(gone, summary.removed.iter().sum::<usize>());
    assert!(summary.removed.iter().all(|&n| n > 5), "{:?}", summary.removed);
    let truth = String::from_utf8_lossy(&after["truth.csv"]).lines().count();
    assert_eq!(truth, summary.lost_vertices + 1);
}

#[test]
fn ply_tiles_lose_rows_and_the_header_counts_them() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (folder.path().join("scene"), folder.path().join("out"));
    source(Format::Ply, &scene);
    let summary = dig(&scene, &out, &DISCS).unwrap();
    let (before, after) = (contents(&scene), contents(&out));
    let count = |bytes: &[u8]| -> usize {
        let text = String::from_utf8_lossy(bytes);
        text.lines().find_map(|l| l.strip_prefix("element face ")).unwrap().parse().unwrap()
    };
    let mut gone = 0;
    let mut changed = 0;
    for (name, old) in before.iter().filter(|(n, _)| n.ends_with(".ply")) {
        let new = &after[name];
        let fewer = count(old) - count(new);
        let digits = |n: usize| n.to_string().len();
        assert_eq!(old.len() - new.len(), 13 * fewer + digits(count(old)) - digits(count(new)), "{name}");
        gone += fewer;
        changed += usize::from(old != new);
    }
    assert_eq!(gone, summary.removed.iter().sum::<usize>());
    assert_eq!(changed, summary.changed_tiles);
    assert!(changed >= 4, "discs on borders touch two tiles each: {changed}");
}

#[test]
fn the_same_seed_digs_the_same_bytes_and_another_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene");
    source(Format::Ply, &scene);
    let dug = |name: &str, seed| {
        let out = folder.path().join(name);
        dig(&scene, &out, &DigOptions { seed, ..DISCS }).unwrap();
        contents(&out)
    };
    let first = dug("first", 1);
    assert!(first == dug("again", 1) && first != dug("other", 2));
}

#[test]
fn bad_requests_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (folder.path().join("scene"), folder.path().join("out"));
    source(Format::Ply, &scene);
    let radius = |radius_m| DigOptions { radius_m, ..DISCS };
    assert!(matches!(dig(&scene, &out, &radius([5.0, 2.0])), Err(DigError::Radius { .. })));
    assert!(matches!(dig(&scene, &scene.join("inside"), &DISCS), Err(DigError::BadOut(_))));
    assert!(matches!(dig(&scene, &scene, &DISCS), Err(DigError::BadOut(_))));
    let crowd = DigOptions { discs: 10_000, ..DISCS };
    assert!(matches!(dig(&scene, &out, &crowd), Err(DigError::NoRoom { .. })));
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    assert!(matches!(dig(&empty, &out, &DISCS), Err(DigError::NoTiles(_))));
    let other = folder.path().join("broken");
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("a.ply"), "ply\nformat ascii 1.0\nend_header\n").unwrap();
    let problem = dig(&other, &folder.path().join("out2"), &DISCS).unwrap_err().to_string();
    assert!(problem.contains("a.ply") && problem.contains("ascii"), "{problem}");
}

#[test]
fn real_tiles_can_be_dug() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let scenes = [("contextcapture-tiles/obj/L17", 3), ("ahn3-delft/tiles_dsm_50m", 6)];
    for (name, discs) in scenes {
        let scene = data.join(name);
        if !scene.is_dir() {
            println!("skipped: {} is absent", scene.display());
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let summary = dig(&scene, folder.path(), &DigOptions { discs, ..DISCS }).unwrap();
        assert!(summary.removed.iter().all(|&n| n > 0), "{name}: {:?}", summary.removed);
        assert!(summary.changed_tiles >= 2);
        let (before, after) = (contents(&scene), contents(folder.path()));
        let is_other = |n: &&String| !n.ends_with(".obj") && !n.ends_with(".ply");
        assert!(before.keys().filter(is_other).all(|n| before[n] == after[n]), "{name}: textures stay");
    }
}
