//! Lakes through the whole program: levels found and given, slopes, polygons, regions, islands.

mod kit;
mod made_lake;

use glam::DVec2;
use kit::{Run, SceneFolder, lacuna, repair, report};
use lacuna::report::Report;
use made_lake::{LEVEL_M, Lake, new_vertices};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Rim edges of the made lakes, metres.
const EDGE_M: f64 = 1.0;

/// Repairs with a configuration file that lies beside the scene.
fn configured(scene: &SceneFolder, sections: &str) -> (PathBuf, Run) {
    let (file, out) = (scene.beside("water.ron"), scene.beside("out"));
    std::fs::write(&file, format!("(version: 1, {sections})")).expect("a file");
    let run = repair(scene, &out, &["--config", &file.to_string_lossy()]);
    (out, run)
}

fn repaired(scene: &SceneFolder, sections: &str) -> (PathBuf, Report) {
    let (out, run) = configured(scene, sections);
    run.ends(0);
    let report = report(&out);
    assert_eq!((report.clusters.len(), report.summary.skipped, report.summary.failed), (1, 0, 0));
    (out, report)
}

fn verified(scene: &SceneFolder, out: &Path) -> Run {
    let words: [&OsStr; 3] = ["verify".as_ref(), scene.path().as_os_str(), out.as_os_str()];
    lacuna(words)
}

/// Largest distance of the new vertices from the water, those nearer to the rim than so many edges left out.
fn farthest_m(scene: &SceneFolder, out: &Path, edges: f64, water_m: impl Fn(DVec2) -> f64) -> f64 {
    let new = new_vertices(scene, out);
    let inner: Vec<_> = new.iter().filter(|(_, away_m)| *away_m >= edges * EDGE_M).collect();
    assert!(inner.len() > 20, "{} of {} vertices are looked at", inner.len(), new.len());
    inner.iter().map(|(p, _)| (p.z - water_m(p.truncate())).abs()).fold(0.0, f64::max)
}

fn geojson(features: &[(&str, [f64; 4])]) -> String {
    let feature = |(properties, [w, s, e, n]): &(&str, [f64; 4])| {
        format!(
            r#"{{"type":"Feature","properties":{properties},"geometry":{{"type":"Polygon","coordinates":[[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]]}}}}"#
        )
    };
    let features: Vec<String> = features.iter().map(feature).collect();
    format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
}

/// All of the lake.
const AROUND: [f64; 4] = [10.0, 10.0, 80.0, 80.0];

#[test]
fn the_level_is_found_behind_noise_and_walls() {
    for walls in [0.0, 0.15, 0.3] {
        let scene = Lake { walls, ..Lake::default() }.scene();
        let (out, report) = repaired(&scene, "");
        let lake = &report.clusters[0];
        let level_m = lake.level_m.unwrap_or_else(|| panic!("{walls}: no level"));
        assert!((level_m - LEVEL_M).abs() < 0.05, "{walls}: {level_m}");
        assert!(lake.level_support.is_some_and(|s| s > 0.6 && s < 1.01 - 0.7 * walls), "{walls}: {lake:?}");
        let off_m = farthest_m(&scene, &out, 2.0, |_| LEVEL_M);
        assert!(off_m < 0.05, "{walls}: {off_m} m off the level");
    }
}

#[test]
fn a_rim_without_a_level_gives_none() {
    for lake in [Lake { hills_m: 2.0, ..Lake::default() }, Lake { walls: 0.6, ..Lake::default() }] {
        let (_, report) = repaired(&lake.scene(), "");
        assert_eq!((report.clusters[0].level_m, report.clusters[0].level_support), (None, None));
    }
    let (_, report) = repaired(&Lake::default().scene(), "water: (mode: off)");
    assert_eq!(report.clusters[0].level_m, None);
}

#[test]
fn a_given_level_is_exact_two_edges_off_the_rim() {
    for (walls, level_m) in [(0.0, LEVEL_M), (0.3, LEVEL_M), (0.9, -2.0)] {
        let scene = Lake { walls, ..Lake::default() }.scene();
        let (out, report) = repaired(&scene, &format!("water: (mode: level({level_m:?}))"));
        assert_eq!(report.clusters[0].level_m, Some(level_m));
        let off_m = farthest_m(&scene, &out, 2.0, |_| level_m);
        assert!(off_m < 0.001, "{walls}: {off_m} m off the level");
        verified(&scene, &out).ends(0);
    }
}

#[test]
fn a_given_slope_falls_along_the_lake() {
    let slope = 0.01;
    let lake = Lake { half_m: DVec2::new(38.0, 18.0), slope, noise_m: 0.03, walls: 0.2, ..Lake::default() };
    let scene = lake.scene();
    // The ends of the rim are 38 m off the middle; which of the heights comes first does not matter here: the banks tell.
    let (high, low) = (LEVEL_M + 38.0 * slope, LEVEL_M - 38.0 * slope);
    for (from_m, to_m) in [(high, low), (low, high)] {
        let (out, report) =
            repaired(&scene, &format!("water: (mode: sloped(from_m: {from_m:?}, to_m: {to_m:?}))"));
        let off_m = farthest_m(&scene, &out, 2.0, |p| LEVEL_M + slope * (p.x - 45.0));
        assert!(off_m < 0.05, "{off_m} m off the slope");
        assert!(report.clusters[0].level_support.is_some_and(|s| s > 0.7), "{:?}", report.clusters[0]);
        std::fs::remove_dir_all(&out).expect("removed");
    }
}

#[test]
fn polygons_say_what_is_water() {
    let scene = Lake { walls: 0.7, ..Lake::default() }.scene();
    let file = scene.beside("water.geojson");
    let water = r#"water: (mode: off, polygons: "water.geojson")"#;
    let beside = [-50.0, 0.0, -40.0, 10.0];
    std::fs::write(&file, geojson(&[(r#"{"level_m":-0.6}"#, AROUND), ("{}", beside)])).expect("a file");
    let (out, run) = configured(&scene, water);
    run.ends(0).says("1 of 2 water polygons hold no hole (features 1, counted from 0)");
    assert_eq!(report(&out).clusters[0].level_m, Some(-0.6));
    assert!(farthest_m(&scene, &out, 2.0, |_| -0.6) < 0.001);

    // Without a level the rim is asked, though too little of it supports one.
    std::fs::write(&file, geojson(&[("{}", AROUND)])).expect("a file");
    let (_, by_rim) = repaired(&scene, water);
    let lake = &by_rim.clusters[0];
    assert!(lake.level_m.is_some_and(|z| (z - LEVEL_M).abs() < 0.05), "{lake:?}");
    assert!(lake.level_support.is_some_and(|s| s < 0.6), "{lake:?}");

    // A region comes before the polygon; a polygon over less than half of the lake says nothing.
    let region = format!(r#"{water}, regions: [(name: "lake", at: point(45, 45), water: level(-0.7))]"#);
    assert_eq!(repaired(&scene, &region).1.clusters[0].level_m, Some(-0.7));
    std::fs::write(&file, geojson(&[(r#"{"level":9}"#, [10.0, 10.0, 42.0, 80.0])])).expect("a file");
    assert_eq!(repaired(&scene, water).1.clusters[0].level_m, None);
    std::fs::write(&file, geojson(&[(r#"{"level":9}"#, beside)])).expect("a file");
    configured(&scene, water).1.ends(0).says("no hole lies in its water polygons");
}

#[test]
fn bad_water_files_are_refused() {
    let scene = Lake::default().scene();
    let water = r#"water: (polygons: "water.geojson")"#;
    configured(&scene, water).1.ends(2).says("water.geojson: cannot be read");
    for (text, part) in [
        ("{}".to_owned(), "no GeoJSON"),
        (
            geojson(&[("{}", AROUND), (r#"{"level":"low"}"#, AROUND)]),
            r#"feature 1: level is "low"; give a height"#,
        ),
        (geojson(&[]), "holds no polygon"),
    ] {
        std::fs::write(scene.beside("water.geojson"), text).expect("a file");
        configured(&scene, water).1.ends(2).says("water.geojson").says(part);
    }
}

#[test]
fn heights_are_those_of_the_reference_system() {
    let scene = Lake::default().scene();
    let origin = "scene: (srs_origin: (1000.0, 2000.0, 10.0))";
    let (out, report) = repaired(&scene, &format!("{origin}, water: (mode: level(9.25))"));
    assert_eq!(report.clusters[0].level_m, Some(9.25));
    assert!(farthest_m(&scene, &out, 2.0, |_| -0.75) < 0.001);
}

#[test]
fn the_water_passes_beneath_a_raft() {
    let under = "water: (mode: level(-0.45), islands: under(max_area_m2: 20))";
    let hovering = Lake { raft_m: Some(1.2), ..Lake::default() }.scene();
    let (out, joined) = repaired(&hovering, "water: (mode: level(-0.45))");
    assert_eq!(joined.holes.iter().map(|h| h.islands_passed_under).sum::<u64>(), 0);
    verified(&hovering, &out).ends(0);

    let (out, run) = configured(&hovering, under);
    run.ends(0);
    assert!(run.stdout.contains("1 island over the water of 1 hole"), "{}", run.stdout);
    let passed = report(&out);
    assert_eq!(passed.holes.iter().map(|h| h.islands_passed_under).sum::<u64>(), 1);
    // 5 m x 3 m of water more.
    assert!((passed.clusters[0].area_m2 - joined.clusters[0].area_m2 - 15.0).abs() < 1e-6);
    let plan = std::fs::read_to_string(out.join("lacuna/plan.json")).expect("a plan");
    assert!(plan.contains("\"Island\""), "the plan keeps the planned class");
    let beneath = new_vertices(&hovering, &out);
    let near_raft = |p: DVec2| p.cmpgt(DVec2::new(42.5, 24.5)).all() && p.cmplt(DVec2::new(46.5, 26.5)).all();
    let heights: Vec<f64> =
        beneath.iter().filter(|(p, _)| near_raft(p.truncate())).map(|(p, _)| p.z).collect();
    assert!(!heights.is_empty() && heights.iter().all(|z| (z - LEVEL_M).abs() < 0.001), "{heights:?}");
    verified(&hovering, &out).ends(0);

    // What the report does not call passed under must be joined.
    let map = out.join("lacuna/holes.geojson");
    let text = std::fs::read_to_string(&map).expect("a map");
    std::fs::write(&map, text.replace("\"passed_under\"", "\"no_such_key\"")).expect("a file");
    let verdict = verified(&hovering, &out);
    assert_eq!(verdict.code, 1, "{}{}", verdict.stdout, verdict.stderr);
    assert!(verdict.stdout.contains("the report counts 1 islands passed"), "{}", verdict.stdout);
}

#[test]
fn large_and_lying_islands_are_joined() {
    for (raft_m, limit) in [(1.2, 14.0), (0.1, 20.0)] {
        let scene = Lake { raft_m: Some(raft_m), ..Lake::default() }.scene();
        let water = format!("water: (mode: level(-0.45), islands: under(max_area_m2: {limit:?}))");
        let (out, report) = repaired(&scene, &water);
        assert_eq!(report.holes.iter().map(|h| h.islands_passed_under).sum::<u64>(), 0, "{raft_m}, {limit}");
        verified(&scene, &out).ends(0);
    }
}
