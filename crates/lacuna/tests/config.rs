//! Command line and configuration file: what is read, and what is refused in which words.

mod expected;

use clap::{CommandFactory, Parser};
use expected::expect_file;
use lacuna::cli::Cli;
use lacuna::config::{
    AreaLimit, ClosedFiller, External, FailOn, FillSettings, HoleClassFilter, HoleShapeFilter, Machine,
    MethodName, OpenFiller, RegionPlace, Settings, Untouched, UpAxis,
};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const MACHINE: Machine = Machine { memory_bytes: 16 << 30, threads: 8 };

fn resolve(line: &str) -> Result<Settings, String> {
    let words = std::iter::once("lacuna").chain(line.split_whitespace());
    let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
    Settings::resolve_on(&cli, &MACHINE).map_err(|e| e.to_string())
}

fn good(line: &str) -> Settings {
    resolve(line).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Writes a configuration file beside nothing else.
fn with_file(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("city.ron");
    std::fs::write(&path, text).expect("a temporary file");
    (folder, path)
}

fn from_file(text: &str, flags: &str) -> Result<Settings, String> {
    let (folder, path) = with_file(text);
    let place = folder.path().display().to_string();
    resolve(&format!("repair --config {} {flags}", path.display()))
        .map_err(|e| e.replace(&format!("{place}/"), ""))
}

#[test]
fn the_command_line_is_sound() {
    Cli::command().debug_assert();
}

#[test]
fn every_flag_reaches_the_settings() {
    type Check = fn(&Settings) -> bool;
    let cases: [(&str, Check); 36] = [
        ("repair in out", |s| {
            s.scene.input == Path::new("in") && s.scene.output.as_deref() == Some(Path::new("out"))
        }),
        ("repair -i in -o out", |s| {
            s.scene.input == Path::new("in") && s.scene.output.as_deref() == Some(Path::new("out"))
        }),
        ("repair in -o out", |s| s.scene.output.as_deref() == Some(Path::new("out"))),
        ("repair in --dry-run", |s| s.run.dry_run && s.scene.output.is_none()),
        ("inspect in --report look", |s| s.scene.input == Path::new("in") && s.scene.output.is_none()),
        ("info in --json", |s| s.scene.input == Path::new("in")),
        ("verify in out", |s| s.scene.output.as_deref() == Some(Path::new("out"))),
        ("verify --digest out", |s| s.scene.output.as_deref() == Some(Path::new("out"))),
        ("repair in out", |s| s.run.memory_limit_bytes == 8 << 30 && s.run.threads == 8),
        ("repair in out --memory 512MiB", |s| s.run.memory_limit_bytes == 512 << 20),
        ("repair in out --memory 6GB", |s| s.run.memory_limit_bytes == 6_000_000_000),
        ("repair in out --memory 25%", |s| s.run.memory_limit_bytes == 4 << 30),
        ("repair in out -j 3", |s| s.run.threads == 3),
        ("repair in out --threads 0", |s| s.run.threads == 8),
        ("repair in out --cell-size 250", |s| s.scene.cell_size_m == Some(250.0)),
        ("repair in out --cell-origin -5.5,3", |s| s.scene.cell_origin_m == Some([-5.5, 3.0])),
        ("repair in out --up-axis y", |s| s.scene.up_axis == Some(UpAxis::Y)),
        ("repair in out --srs EPSG:28992 --srs-origin 1,2", |s| {
            s.scene.srs.is_some() && s.scene.srs_origin == Some([1., 2., 0.])
        }),
        ("repair in out --srs-origin -1,2,3.5", |s| s.scene.srs_origin == Some([-1.0, 2.0, 3.5])),
        ("repair in out", |s| s.area.limit == AreaLimit::Cells && s.area.external == External::Skip),
        ("repair in out --area box --external fill", |s| {
            s.area.limit == AreaLimit::Box && s.area.external == External::Fill
        }),
        ("repair in out --method layered", |s| s.fill.method == MethodName::Layered),
        ("repair in out --closed min_area --open delaunay", |s| {
            s.fill.closed == ClosedFiller::MinArea && s.fill.open == OpenFiller::Delaunay
        }),
        ("repair in out --spacing 0.5", |s| s.fill.spacing_m == Some(0.5)),
        ("repair in out --at -12.5,7 --at 1,2", |s| s.selection.at == [[-12.5, 7.0], [1.0, 2.0]]),
        ("repair in out --hole 1_2", |s| s.selection.holes == ["1_2"] && !s.selection.is_whole_scene()),
        ("repair in out --min-area 0 --max-area 1e6", |s| {
            s.find.min_area_m2 == Some(0.0) && s.find.max_area_m2 == Some(1e6)
        }),
        ("repair in out --max-perimeter 9", |s| s.find.max_perimeter_m == Some(9.0)),
        ("repair in out --max-edges-around-hole 30", |s| s.find.max_edges_around_hole == Some(30)),
        ("repair in out --class II,closed", |s| {
            s.find.class == [HoleClassFilter::Closed, HoleClassFilter::External]
        }),
        ("repair in out --shape d,A", |s| s.find.shape == [HoleShapeFilter::A, HoleShapeFilter::D]),
        ("repair in out --untouched omit", |s| s.scene.untouched == Untouched::Omit),
        ("repair in out --fail-on never", |s| s.run.fail_on == FailOn::Never),
        ("repair in out --overwrite --strict --untrusted", |s| {
            s.run.overwrite && s.run.strict && s.run.untrusted
        }),
        ("repair in out --progress none --log-json -q", |s| s.selection.is_whole_scene()),
        ("-vv repair in out", |s| s.scene.input == Path::new("in")),
    ];
    for (line, check) in cases {
        assert!(check(&good(line)), "{line}: {:?}", good(line));
    }
}

#[test]
fn wrong_command_lines_are_refused() {
    for (line, part) in [
        ("repair", "no scene"),
        ("repair in", "no output folder"),
        ("inspect", "no scene"),
        ("repair in out -o other", "cannot be used with"),
        ("repair in out --memory 512", "no unit"),
        ("repair in out --memory 12gigs", "not understood"),
        ("repair in out --memory 0MiB", "is nothing"),
        ("repair in out --memory 120%", "at most 100 %"),
        ("repair in out --cell-size 250m", "without a unit"),
        ("repair in out --cell-size=-1", "above 0"),
        ("repair in out --cell-size NaN", "no number"),
        ("repair in out --at 5", "two numbers"),
        ("repair in out --area everything", "GeoJSON"),
        ("repair in out --area missing.geojson", "missing.geojson: cannot be read"),
        ("repair in out --resume", "--resume is not in this version"),
        ("bench", "required"),
        ("bench a.ron --plots", "unexpected argument"),
        ("repair in out --region quay", "no such region"),
        ("repair in out --min-area 5 --max-area 1", "no hole fits"),
        ("repair in out -q -v", "cannot be used with"),
        ("verify in", "required"),
        ("verify in out --digest out", "cannot be used with"),
    ] {
        let error = resolve(line).expect_err(line);
        assert!(error.contains(part), "{line}: {error}");
    }
}

#[test]
fn what_is_not_built_is_absent_from_help() {
    let mut command = Cli::command();
    let mut help = command.render_long_help().to_string();
    for verb in ["info", "inspect", "repair", "verify", "bench"] {
        let sub = command.find_subcommand_mut(verb).unwrap_or_else(|| panic!("no {verb}"));
        help += &sub.render_long_help().to_string();
    }
    for word in ["resume", "--make", "not in this version"] {
        assert!(!help.contains(word), "{word} in\n{help}");
    }
    assert!(help.contains("--max-edges-around-hole") && help.contains("--digest"));
}

#[test]
fn a_flag_beats_the_file_and_the_file_beats_the_default() {
    let text = r#"(version: 1, scene: (input: "a/b", output: "/abs/out", cell_size_m: 100, untouched: omit),
        run: (memory: "2GiB", threads: 3, fail_on: never), find: (class: [I], min_area_m2: 2), fill: (spacing_m: 4.0),
        regions: [(name: "r", at: point(1, 2), fill: (closed: min_area)), (name: "s", at: box(0, 0, 1, 2), skip: "why")])"#;
    let file = from_file(text, "").expect("a good file");
    assert!(file.scene.input.ends_with("a/b") && file.scene.input.is_absolute());
    assert_eq!(file.scene.output.as_deref(), Some(Path::new("/abs/out")));
    assert_eq!(
        (file.run.memory_limit_bytes, file.run.threads, file.run.fail_on),
        (2 << 30, 3, FailOn::Never)
    );
    assert_eq!(file.regions[0].fill, FillSettings { closed: ClosedFiller::MinArea, ..file.fill });
    assert_eq!(file.regions[1].at, RegionPlace::Box([0.0, 0.0, 1.0, 2.0]));
    assert_eq!(file.regions[1].skip.as_deref(), Some("why"));

    let both = from_file(
        text,
        "in out --cell-size 50 --memory 1GiB -j 1 --class II --spacing 1 --closed delaunay --untouched copy",
    )
    .expect("good flags");
    assert_eq!((both.scene.input.as_path(), both.scene.cell_size_m), (Path::new("in"), Some(50.0)));
    assert_eq!((both.run.memory_limit_bytes, both.run.threads), (1 << 30, 1));
    assert_eq!(
        (both.find.class.as_slice(), both.find.min_area_m2),
        (&[HoleClassFilter::External][..], Some(2.0))
    );
    assert_eq!((both.fill.spacing_m, both.regions[0].fill.closed), (Some(1.0), ClosedFiller::Delaunay));
    assert_eq!(both.scene.untouched, Untouched::Copy);
    assert!(from_file(text, "--region s").is_ok());
}

#[test]
fn a_scene_is_merged_whole_or_not_at_all() {
    let with = |scene: &str, region: &str| {
        format!(
            "(version: 1, fill: (method: {scene}), regions: [(name: \"r\", at: point(1, 2), fill: ({region}))])"
        )
    };
    for (scene, region, flags, is_good) in [
        ("aggregate", "", "", true),
        ("aggregate", "method: aggregate", "", true),
        ("aggregate", "method: layered", "", false),
        ("field", "method: aggregate", "", false),
        ("field", "method: layered", "--method aggregate", true),
    ] {
        let settings = from_file(&with(scene, region), &format!("in out {flags}"));
        match settings {
            Ok(_) => assert!(is_good, "{scene}, {region}, {flags}"),
            Err(error) => assert!(!is_good && error.contains("merges the whole scene"), "{error}"),
        }
    }
}

#[test]
fn errors_of_the_file_show_the_place() {
    let cases = [
        ("unknown key", "(\n    version: 1,\n    scene: (input: \"a\", cell_size: 250),\n)"),
        ("misspelt section", "(version: 1, regoins: [])"),
        ("no key at all", "(version: 1, 12)"),
        ("value on the next line", "(version: 1, find: (\n  max_perimeter_m:\n    \"9\",\n))"),
        ("key of another section", "(version: 1, fill: (min_area_m2: 0.5))"),
        ("key of a later version", "(version: 1, facade: (mode: auto))"),
        ("nothing like it", "(version: 1, run: (colour: \"red\"))"),
        ("unknown key of a region", "(version: 1, regions: [(name: \"a\", place: point(1, 2))])"),
        ("area in quotes", "(\n    version: 1,\n    find: (min_area_m2: \"5 m2\", max_area_m2: 3),\n)"),
        ("length with a unit", "(version: 1, scene: (cell_size_m: 250m))"),
        ("negative length", "(version: 1, fill: (spacing_m: -2.5))"),
        ("memory without a unit", "(version: 1, run: (memory: \"12\"))"),
        ("memory with a wrong unit", "(version: 1, run: (memory: \"12 gigs\", threads: 2))"),
        ("memory as a number", "(version: 1, run: (memory: 12))"),
        ("threads that are no count", "(version: 1, run: (threads: -1))"),
        ("unknown method", "(version: 1, fill: (method: agregate))"),
        ("unknown word", "(version: 1, scene: (untouched: link))"),
        ("unknown place", "(version: 1, regions: [(name: \"a\", at: circle(1, 2, 3))])"),
        ("missing key of a region", "(version: 1, regions: [(name: \"a\")])"),
        ("key twice", "(version: 1, run: (threads: 1, threads: 2))"),
        ("another version", "(version: 2)"),
        ("no version", "(run: (threads: 2))"),
        ("comma left out", "(version: 1\n run: (threads: 2))"),
        ("bracket left out", "(version: 1, run: (threads: 2)"),
        ("text behind the end", "(version: 1) trailing"),
        ("empty file", ""),
        (
            "two regions of one name",
            "(version: 1, scene: (input: \"a\", output: \"b\"), regions: [(name: \"a\", at: point(1, 2)), (name: \"a\", at: point(1, 2))])",
        ),
        (
            "box inside out",
            "(version: 1, scene: (input: \"a\", output: \"b\"), regions: [(name: \"a\", at: box(9, 0, 1, 2))])",
        ),
        ("unknown word of water", "(version: 1, water: (mode: flat))"),
        ("slope with one end", "(version: 1, water: (mode: sloped(from_m: 1.5)))"),
        ("slope with a wrong key", "(version: 1, water: (mode: sloped(from: 1.5, to_m: 1.0)))"),
        ("level that is none", "(version: 1, water: (mode: level(inf)))"),
        ("islands without an area", "(version: 1, water: (islands: under(max_area_m2: 0)))"),
        ("water file missing", "(version: 1, water: (polygons: \"gis/none.geojson\"))"),
        ("polygon file missing", "(version: 1, area: (limit: polygon(\"gis/none.geojson\")))"),
    ];
    let mut text = String::new();
    for (name, file) in cases {
        let error = from_file(file, "").expect_err(name);
        let _ = writeln!(text, "== {name}\n{error}\n");
    }
    expect_file("config/errors.txt", &text);
}

#[test]
fn the_report_keeps_limits_and_paths_apart() {
    let quick = good("repair in out --memory 1GiB -j 2 --fail-on never --spacing 2");
    let slow = good("repair elsewhere other --memory 90% -j 1 --overwrite --strict --spacing 2");
    assert_eq!(quick.to_json(), slow.to_json());
    assert_ne!(quick.run_facts(), slow.run_facts());
    assert_ne!(quick.to_json(), good("repair in out --spacing 3").to_json());
}

#[test]
fn every_example_loads() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs");
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder configs")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        // The bench has files of its own kind, and tests/bench.rs reads them.
        .filter(|path| !path.to_string_lossy().contains("bench"))
        .collect();
    names.sort();
    assert!(names.len() >= 3, "{names:?}");
    for path in names {
        good(&format!("repair --config {}", path.display()));
    }
}

#[test]
fn lists_of_tiles_are_read_line_by_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let list = folder.path().join("tiles.txt");
    std::fs::write(&list, "\u{feff}# mine\r\nTile_+001_+000\r\n\r\n  Tile_+000_+000  \nTile_+001_+000\n")
        .expect("a file");
    let settings = good(&format!("repair in out --cells {}", list.display()));
    assert_eq!(
        settings.selection.cells,
        Some(BTreeSet::from(["Tile_+000_+000".to_owned(), "Tile_+001_+000".to_owned()]))
    );
    std::fs::write(&list, "# nothing\n").expect("a file");
    assert!(
        resolve(&format!("repair in out --cells {}", list.display()))
            .expect_err("empty")
            .contains("names no tile")
    );
}
