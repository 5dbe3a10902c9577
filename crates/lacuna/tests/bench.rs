//! The verb `bench`: what it measures, writes and refuses.

mod kit;

use kit::lacuna;
use lacuna::bench::{BenchConfig, BenchResult, RowOutcome, Series};
use lacuna::config::{Machine, MethodName};
use scene::maker::{MakeOptions, Maker};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const MACHINE: Machine = Machine { memory_bytes: 16 << 30, threads: 8 };

/// A folder with a configuration in it, and where the bench writes.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new(config: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("bench.ron"), config).expect("a file");
        Self { folder }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn run(&self, flags: &[&str]) -> kit::Run {
        let config = self.folder.path().join("bench.ron");
        let mut line = vec!["bench".as_ref(), config.as_os_str(), "--out".as_ref()];
        let out = self.out();
        line.push(out.as_os_str());
        line.extend(flags.iter().map(std::ffi::OsStr::new));
        lacuna(line)
    }

    fn result(&self) -> BenchResult {
        let text = std::fs::read_to_string(self.out().join("bench.json")).expect("a result");
        serde_json::from_str(&text).expect("JSON")
    }
}

const TWO_SIZES: &str = r#"(
    version: 1,
    run: (threads: [2], memory: "1GiB", repeats: 2),
    series: [(name: "two", preset: growing, cells: [(4, 2), (4, 4)], triangles: 2_000, methods: [field, aggregate])],
)"#;

#[test]
fn every_method_has_a_row_with_what_it_took_and_filled() {
    let place = Place::new(TWO_SIZES);
    let run = place.run(&[]);
    run.ends(0);
    let result = place.result();
    let rows: Vec<(&str, &str)> =
        result.rows.iter().map(|r| (r.scene.split('_').nth(1).unwrap_or(""), r.method.as_str())).collect();
    let methods = ["copy", "read", "field", "aggregate"];
    let expected: Vec<_> = ["4x2", "4x4"].iter().flat_map(|s| methods.map(|m| (*s, m))).collect();
    assert_eq!(rows, expected);
    for row in &result.rows {
        let name = format!("{} {}", row.scene, row.method);
        let made = result.scene_of(row).expect("a scene");
        assert_eq!((row.outcome, row.runs), (RowOutcome::Done, 2), "{name}: {:?}", row.message);
        let wall = row.wall_s.expect("a time");
        assert!(0.0 < wall.least && wall.least <= wall.median && wall.median <= wall.most, "{name}");
        assert!(row.ratio_to_copy.is_some_and(|r| r.median > 0.0), "{name}");
        if cfg!(target_os = "linux") {
            assert!(row.read_bytes.is_some_and(|b| b >= made.bytes), "{name}: {:?}", row.read_bytes);
            let least = if row.method == "read" { 0 } else { made.bytes };
            assert!(row.written_bytes.is_some_and(|b| b >= least), "{name}: {:?}", row.written_bytes);
            assert!(row.peak_rss_bytes.is_some_and(|b| b < 1 << 30), "{name}");
        }
        if row.memory_limit_bytes.is_some() {
            let filled: BTreeMap<String, u64> =
                row.holes.iter().map(|(kind, count)| (kind.clone(), count.filled)).collect();
            assert_eq!(filled, made.holes, "{name}");
        }
    }
    for file in ["bench.md", "samples.json", "two_time.svg", "two_memory.svg", "two_memory_over_time.svg"] {
        assert!(place.out().join(file).exists(), "{file}");
    }
    assert!(run.stdout.contains("| 0.50 | 8 |") && run.stdout.contains("7 of 7 (100 %)"), "{}", run.stdout);
    let left: Vec<_> = std::fs::read_dir(place.out())
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name())
        .filter(|name| name.to_string_lossy().starts_with("run-"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

const ONE: &str = r#"(
    version: 1,
    run: (threads: [1], memory: "1GiB", repeats: 1),
    series: [(name: "one", preset: small, triangles: 600, methods: [field])],
)"#;

#[test]
fn scenes_are_used_again_and_what_worsens_fails() {
    let place = Place::new(ONE);
    place.run(&[]).ends(0);
    let record = place.out().join("scenes/small_own_600_ply_1/made.json");
    let made = || std::fs::metadata(&record).expect("a record").modified().expect("a time");
    let first = made();
    let baseline = place.folder.path().join("baseline.json");
    let mut old = place.result();
    for row in &mut old.rows {
        row.ratio_to_copy = None;
    }
    let save = |result: &BenchResult| {
        std::fs::write(&baseline, serde_json::to_string(result).expect("JSON")).expect("a file");
    };
    save(&old);
    let check = ["--check", baseline.to_str().expect("a path")];
    place.run(&check).ends(0);
    assert_eq!(made(), first, "the scene was made again");
    for row in &mut old.rows {
        row.peak_rss_bytes = Some(5 << 20);
    }
    save(&old);
    place.run(&check).ends(1).says("one small_own_600_ply_1 field -j 1: peak memory in MiB is");
    std::fs::write(&baseline, "{}").expect("a file");
    place.run(&check).ends(2).says("no bench.json of an earlier run");
    std::fs::remove_file(&record).expect("a record");
    place.run(&[]).ends(2).says("remove it, or name another --out");
}

#[test]
fn limits_are_rows_and_no_failures() {
    let place = Place::new(
        r#"(version: 1, run: (threads: [1], repeats: 2, references: false), series: [
            (name: "memory", preset: small, triangles: 8_000, methods: [aggregate], memory: "30MiB"),
            (name: "time", preset: small, triangles: 8_000, methods: [field], memory: "1GiB", time_limit_s: 0.001),
        ])"#,
    );
    let run = place.run(&[]);
    run.ends(0);
    let result = place.result();
    let ends: Vec<_> = result.rows.iter().map(|r| (r.series.as_str(), r.outcome, r.runs)).collect();
    assert_eq!(ends, [("memory", RowOutcome::MemoryLimit, 1), ("time", RowOutcome::TimeLimit, 1)]);
    assert!(result.rows[0].message.as_deref().is_some_and(|m| m.contains("give at least --memory")));
    assert!(run.stdout.contains("stopped at the time limit after") && run.stdout.contains("* small_"));
}

#[test]
fn wrong_configurations_are_refused_with_the_place() {
    for (text, expected) in [
        ("(version: 2, series: [])", "version 2 is unknown"),
        ("(version: 1, series: [])", "`series` is empty"),
        ("(version: 1)", "`series` is missing"),
        ("(version: 1, series: [(preset: a)])", "`name` is missing"),
        (r#"(version: 1, series: [(name: "a", preset: z)])"#, "small, demo, city"),
        (r#"(version: 1, series: [(name: "a/b", preset: a)])"#, "letters, digits"),
        (r#"(version: 1, series: [(name: "a", preset: a), (name: "a", preset: b)])"#, "twice"),
        (r#"(version: 1, series: [(name: "a", preset: a, cell: [(1, 2)])])"#, "did you mean `cells`"),
        (r#"(version: 1, series: [(name: "a", preset: a, cells: [])])"#, "at least one"),
        (r#"(version: 1, run: (repeats: 0), series: [(name: "a", preset: a)])"#, "at least 1"),
        (r#"(version: 1, run: (time_limit_s: -1), series: [(name: "a", preset: a)])"#, "above 0"),
        (r#"(version: 1, run: (memory: "9"), series: [(name: "a", preset: a)])"#, "no unit"),
        (r#"(version: 1, series: [(name: "a", preset: a, triangles: 5)])"#, "give 128 to"),
        (r#"(version: 1, series: [(name: "a", preset: a, cells: [(1, 1)])])"#, "--cells 2x2 or more"),
    ] {
        let place = Place::new(text);
        place.run(&[]).ends(2).says(expected);
    }
    lacuna(["bench", "missing.ron"]).ends(2).says("missing.ron: cannot be read");
}

fn configs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs")
}

#[test]
fn every_bench_of_the_repository_can_be_made() {
    for name in ["bench.ron", "bench-small.ron", "bench-guard.ron"] {
        let config = BenchConfig::read(&configs().join(name), &MACHINE).expect(name);
        for spec in config.series.iter().flat_map(|s| &s.scenes) {
            let options = MakeOptions {
                triangles: Some(spec.triangles),
                format: spec.format,
                seed: spec.seed,
                cells: spec.cells,
                ..MakeOptions::new(spec.preset)
            };
            assert!(Maker::new(options).is_ok(), "{name}: {}", spec.folder_name());
        }
    }
}

#[test]
fn a_series_beats_the_common_settings_and_these_the_defaults() {
    let text = r#"(version: 1, run: (repeats: 5, threads: [0, 1]), series: [
        (name: "a", preset: a), (name: "b", preset: b, repeats: 2, methods: [layered], memory: "25%", seed: 7)])"#;
    let config = BenchConfig::parse(text, Path::new("x.ron"), &MACHINE).expect("a configuration");
    let facts = |s: &Series| (s.repeats, s.threads.clone(), s.memory_limit_bytes, s.scenes[0].seed);
    assert_eq!(facts(&config.series[0]), (5, vec![8, 1], 8 << 30, 1));
    assert_eq!(facts(&config.series[1]), (2, vec![8, 1], 4 << 30, 7));
    assert_eq!(config.series[0].methods, [MethodName::Field, MethodName::Layered, MethodName::Aggregate]);
    assert_eq!((config.series[0].references, config.series[0].scenes[0].triangles), (true, 50_000));
}
