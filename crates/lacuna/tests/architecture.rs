//! The rules of ARCHITECTURE.md, checked against the sources and manifests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Which crates of the workspace each crate may use in its own code; a missing name is a new crate without a place.
const EDGES: [(&str, &[&str]); 13] = [
    ("lacuna-solve", &[]),
    ("lacuna-system", &[]),
    ("lacuna-mesh", &[]),
    ("lacuna-grid", &[]),
    ("lacuna-seam", &[]),
    ("lacuna-schedule", &[]),
    ("lacuna-tile", &["lacuna-grid", "lacuna-mesh"]),
    ("lacuna-hole", &["lacuna-grid", "lacuna-mesh"]),
    ("lacuna-fill", &["lacuna-mesh", "lacuna-solve"]),
    ("lacuna-close", &["lacuna-fill", "lacuna-grid", "lacuna-hole", "lacuna-mesh", "lacuna-solve"]),
    (
        "lacuna",
        &[
            "lacuna-close",
            "lacuna-fill",
            "lacuna-grid",
            "lacuna-hole",
            "lacuna-mesh",
            "lacuna-schedule",
            "lacuna-seam",
            "lacuna-solve",
            "lacuna-system",
            "lacuna-tile",
            "scene",
        ],
    ),
    ("scene", &[]),
    ("accuracy", &["lacuna", "lacuna-mesh", "lacuna-system", "lacuna-tile", "scene"]),
];

/// Crates whose code does nothing but compute.
const KERNELS: [&str; 7] = [
    "lacuna-solve",
    "lacuna-mesh",
    "lacuna-grid",
    "lacuna-seam",
    "lacuna-hole",
    "lacuna-fill",
    "lacuna-close",
];

/// Longest source file, in lines.
const LONGEST_FILE: usize = 750;

/// Longest ARCHITECTURE.md, in lines: nobody reads a longer one.
const LONGEST_MAP: usize = 150;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Folders of all crates of the workspace, by name.
fn crates() -> BTreeMap<String, PathBuf> {
    ["crates", "tools"]
        .iter()
        .flat_map(|folder| fs::read_dir(root().join(folder)).expect("a folder"))
        .map(|entry| entry.expect("an entry"))
        .filter(|entry| entry.path().join("Cargo.toml").exists())
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path()))
        .collect()
}

/// Names in the `[dependencies]` tables (those for one platform too, not those of tests) of a manifest.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut wanted = false;
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            wanted = line == "[dependencies]"
                || line.ends_with("build-dependencies]")
                || (line.starts_with("[target.") && line.ends_with(".dependencies]"));
        } else if wanted && let Some((name, _)) = line.split_once(['.', '=', ' ']) {
            names.insert(name.trim().to_owned());
        }
    }
    names
}

/// The sources of a crate without its tests: path and text.
fn sources(krate: &Path) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut folders = vec![krate.join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = read(&path);
                files.push((path, text));
            }
        }
    }
    files.sort();
    files
}

/// The code of a file: no comments, and nothing from its test module on.
fn code(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
    text[..end].lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Every use of a word in the code of crates that may not use it.
fn uses(words: &[&str], may: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for (name, folder) in crates().iter().filter(|(name, _)| !may.contains(&name.as_str())) {
        for (path, text) in sources(folder) {
            let code = code(&text);
            let hits = words.iter().filter(|w| code.contains(**w));
            found.extend(hits.map(|w| format!("{name}: {} uses {w}", path.display())));
        }
    }
    found
}

#[test]
fn crates_use_only_what_lies_below_them() {
    let allowed: BTreeMap<&str, &[&str]> = EDGES.into();
    let crates = crates();
    assert_eq!(crates.keys().map(String::as_str).collect::<BTreeSet<_>>(), allowed.keys().copied().collect());
    for (name, folder) in &crates {
        let used = dependencies(&read(&folder.join("Cargo.toml")));
        let inside: Vec<&str> = used.iter().map(String::as_str).filter(|d| crates.contains_key(*d)).collect();
        let wrong: Vec<_> = inside.iter().filter(|d| !allowed[name.as_str()].contains(d)).collect();
        assert!(wrong.is_empty(), "{name} must not use {wrong:?}");
    }
}

#[test]
fn edges_have_no_way_back() {
    let allowed: BTreeMap<&str, &[&str]> = EDGES.into();
    let mut tier: BTreeMap<&str, usize> = BTreeMap::new();
    for _ in 0..allowed.len() {
        for (name, below) in &allowed {
            if let Some(tiers) = below.iter().map(|b| tier.get(b).copied()).collect::<Option<Vec<_>>>() {
                tier.insert(name, tiers.into_iter().max().map_or(0, |t| t + 1));
            }
        }
    }
    assert_eq!(tier.len(), allowed.len(), "a circle: {tier:?}");
}

#[test]
fn the_map_is_short_and_its_paths_exist() {
    let text = read(&root().join("ARCHITECTURE.md"));
    assert!(text.lines().count() <= LONGEST_MAP, "{} lines", text.lines().count());
    let mut checked = 0;
    for word in text.split('`').skip(1).step_by(2) {
        let tops = ["crates/", "tools/", "testdata/", "configs/", "docs/", ".ci/", ".cargo/"];
        if tops.iter().any(|t| word.starts_with(t)) {
            assert!(root().join(word).exists(), "ARCHITECTURE.md names {word}, which is not there");
            checked += 1;
        }
    }
    assert!(checked > 20, "only {checked} paths");
    for name in crates().keys() {
        assert!(text.contains(&format!("`{name}`")), "ARCHITECTURE.md does not name {name}");
    }
}

#[test]
fn threads_start_in_one_place() {
    let words = ["rayon::", "thread::spawn", "thread::scope", "thread::Builder"];
    assert_eq!(uses(&words, &["lacuna-schedule"]), Vec::<String>::new());
}

#[test]
fn unsafe_code_stands_in_one_place() {
    let words = ["unsafe {", "unsafe fn", "unsafe impl", "allow(unsafe_code)"];
    assert_eq!(uses(&words, &["lacuna-system"]), Vec::<String>::new());
    assert!(read(&root().join("Cargo.toml")).contains("unsafe_code = \"forbid\""));
    for (name, folder) in crates().iter().filter(|(name, _)| *name != "lacuna-system") {
        let manifest = read(&folder.join("Cargo.toml"));
        assert!(manifest.contains("[lints]\nworkspace = true"), "{name} does not take the workspace's lints");
    }
}

#[test]
fn files_are_touched_in_few_places() {
    let words = ["std::fs", "fs::File", "File::open", "File::create"];
    // lacuna-system reads what the kernel tells of this process under /proc and /sys.
    assert_eq!(
        uses(&words, &["lacuna-tile", "lacuna", "lacuna-system", "scene", "accuracy"]),
        Vec::<String>::new()
    );
}

#[test]
fn kernels_do_not_log() {
    let crates = crates();
    for name in KERNELS {
        let used = dependencies(&read(&crates[name].join("Cargo.toml")));
        let talkative: Vec<_> =
            ["tracing", "log", "indicatif", "rayon"].iter().filter(|d| used.contains(**d)).collect();
        assert!(talkative.is_empty(), "{name} uses {talkative:?}");
    }
    let others: Vec<&str> = crates.keys().map(String::as_str).filter(|n| !KERNELS.contains(n)).collect();
    assert_eq!(uses(&["println!", "eprintln!", "print!"], &others), Vec::<String>::new());
}

#[test]
fn nothing_is_left_to_do() {
    let words = [concat!("todo", "!("), concat!("unimpl", "emented!("), concat!("dbg", "!(")];
    assert_eq!(uses(&words, &[]), Vec::<String>::new());
}

#[test]
fn the_program_does_not_read_what_judges_it() {
    let words = ["\"scene.json\"", "\"truth.csv\"", "\"truth.npz\"", "\"grid.json\""];
    assert_eq!(uses(&words, &["scene", "accuracy"]), Vec::<String>::new());
}

#[test]
fn files_are_of_one_thing() {
    for (name, folder) in crates() {
        for (path, text) in sources(&folder) {
            let lines = text.lines().count();
            assert!(lines <= LONGEST_FILE, "{name}: {} has {lines} lines", path.display());
        }
    }
}

#[test]
fn every_crate_says_what_it_is() {
    for (name, folder) in crates() {
        let lib = read(&folder.join("src/lib.rs"));
        assert!(lib.starts_with("//! "), "{name}: lib.rs starts with what the crate is");
        assert!(read(&folder.join("Cargo.toml")).contains("\ndescription = "), "{name}: no description");
    }
}
