//! The report's files, made from a made-up run.

mod expected;
mod made_up;

use expected::expect_file;
use lacuna::report::{
    Drawing, HoleClass, HoleKind, Outcome, Report, Summary, attention, cells_geojson, holes_geojson, page,
    table,
};
use made_up::{HOSTILE, drawing, report};
use proptest::prelude::*;

#[test]
fn report_json_is_as_agreed() {
    let text = report().to_json().expect("a report");
    expect_file("report/report.json", &text);
    assert_eq!(text, report().to_json().expect("a report"), "the same report, the same bytes");
}

#[test]
fn fixed_keys_stand_in_order() {
    let text = report().to_json().expect("a report");
    let keys = [
        "version",
        "lacuna",
        "method",
        "threads",
        "memory_limit_bytes",
        "peak_rss_bytes",
        "scene",
        "stages",
        "clusters",
        "holes",
        "summary",
        "seams",
    ];
    let places: Vec<usize> = keys
        .iter()
        .map(|k| text.find(&format!("\n  \"{k}\":")).unwrap_or_else(|| panic!("no key {k}")))
        .collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn a_report_reads_back() {
    let text = report().to_json().expect("a report");
    let back = Report::from_json(&text).expect("our own text");
    assert_eq!(back.to_json().expect("a report"), text);
    let newer = text.replacen("{\n", "{\n  \"key_of_a_later_version\": [1],\n", 1);
    assert!(Report::from_json(&newer).is_ok());
    assert!(Report::from_json("{}").is_err());
}

#[test]
fn numbers_that_are_none_become_null() {
    let mut report = report();
    report.seams.max_gap_m = f64::NAN;
    report.holes[0].quality_mean = Some(f64::INFINITY);
    report.clusters[0].x = f64::NEG_INFINITY;
    let text = report.to_json().expect("a report");
    assert!(!text.contains("NaN") && !text.contains(": inf") && !text.contains(": -inf"));
    assert!(Report::from_json(&text).expect("readable").seams.max_gap_m.is_nan());
}

#[test]
fn geojson_is_as_agreed() {
    expect_file("report/holes.geojson", &holes_geojson(&report(), &drawing(false)).expect("a map"));
    expect_file("report/cells.geojson", &cells_geojson(&report(), &drawing(false)).expect("a map"));
}

#[test]
fn geojson_coordinates_follow_the_srs() {
    let first_x = |srs: Option<&str>, origin| {
        let mut report = report();
        report.scene.srs = srs.map(str::to_owned);
        report.scene.srs_origin = origin;
        let text = cells_geojson(&report, &drawing(false)).expect("a map");
        let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let x = value["features"][0]["geometry"]["coordinates"][0][0][0].as_f64().expect("a number");
        (x, value.get("crs").is_some())
    };
    let origin = Some([84_000.0, 446_000.0, 0.0]);
    assert_eq!(first_x(Some("EPSG:28992"), origin), (84_000.0, true));
    assert_eq!(first_x(Some("EPSG:28992"), None), (0.0, true));
    assert_eq!(first_x(Some("LOCAL_CS[\"x\"]"), origin), (0.0, false));
    assert_eq!(first_x(None, origin), (0.0, false));
}

#[test]
fn outlines_without_points_have_no_geometry() {
    let mut drawing = drawing(false);
    drawing.holes[0].rings = vec![vec![[f64::NAN, 0.0], [1.0, 1.0], [2.0, 0.0]]];
    drawing.holes.remove(1);
    let text = holes_geojson(&report(), &drawing).expect("a map");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON without NaN");
    assert_eq!(value["features"].as_array().map(Vec::len), Some(report().holes.len()));
    assert!(value["features"][0]["geometry"].is_null() && value["features"][1]["geometry"].is_null());
    assert!(value["features"][2]["geometry"].is_object());
}

#[test]
fn the_terminal_table_is_as_agreed() {
    let mut none = report();
    none.holes.clear();
    none.clusters.clear();
    none.summary = Summary::from_holes(&none.holes);
    let text = format!("{}\n{}", table(&report(), "out/oosterhaven_v2/lacuna/report.html"), table(&none, ""));
    expect_file("report/table.txt", &text);
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(!text.contains('\u{1b}'));
}

#[test]
fn failures_come_first() {
    let topics: Vec<&str> = attention(&report()).iter().map(|a| a.topic).collect();
    assert_eq!(topics, ["failed", "largest", "quality", "edge"]);
    let mut report = report();
    report.seams.differing_vertices = 1;
    report.defects[0].unusable = true;
    let topics: Vec<&str> = attention(&report).iter().map(|a| a.topic).collect();
    assert_eq!(topics, ["failed", "tile", "seam", "largest", "quality", "edge"]);
    report.clusters = vec![report.clusters[3].clone(); 9];
    report.clusters.iter_mut().for_each(|c| c.outcome = Outcome::Failed);
    assert_eq!(attention(&report).iter().filter(|a| a.topic == "failed").count(), 6);
}

#[test]
fn the_page_needs_nothing_from_outside() {
    let html = page(&report(), &drawing(true)).expect("a page");
    for part in ["http:", "https:", "//", "url(", "@import", "<link", "src="] {
        let shown = html.replace("url(#wipe)", "");
        let outside_code: String = shown.lines().filter(|l| !l.trim_start().starts_with("//")).collect();
        let without_images = strip_data_uris(&outside_code);
        assert!(!without_images.contains(part), "{part}: {:?}", context(&without_images, part));
    }
    if let Some(path) = std::env::var_os("LACUNA_PAGE") {
        std::fs::write(path, html).expect("a place for the page");
    }
}

fn strip_data_uris(html: &str) -> String {
    let mut pieces = html.split("data:image/png;base64,");
    let first = pieces.next().unwrap_or_default().to_owned();
    pieces.fold(first, |text, piece| text + piece.split_once('"').map_or("", |(_, rest)| rest))
}

fn context<'a>(text: &'a str, part: &str) -> &'a str {
    text.find(part).map_or("", |at| text.get(at.saturating_sub(60)..at + 60).unwrap_or("(near the edge)"))
}

#[test]
fn names_of_tiles_cannot_break_out_of_the_page() {
    let mut report = report();
    report.execution.scene = format!("scenes/{HOSTILE}");
    report.warnings = vec![HOSTILE.to_owned()];
    report.defects[0].what = HOSTILE.to_owned();
    report.scene.srs = Some(HOSTILE.to_owned());
    report.not_holes.insert(HOSTILE.to_owned(), 1);
    report.configuration = serde_json::json!({ HOSTILE: HOSTILE });
    let html = page(&report, &drawing(false)).expect("a page");
    assert_eq!(html.matches("<script").count(), 1, "only the page's own");
    assert!(html.contains("&lt;script&gt;"));
    assert!(!html.contains("<b>\"") && !html.contains('\u{1b}'));
}

#[test]
fn a_run_without_anything_has_a_page() {
    let html = page(&Report::default(), &Drawing::default()).expect("a page");
    assert!(html.contains("No holes were found") && !html.contains("id=\"map\""));
}

proptest! {
    #[test]
    fn counts_add_up(picks in prop::collection::vec((0usize..8, 0usize..3, 0usize..3, prop::bool::ANY), 0..60)) {
        let base = report().holes;
        let holes: Vec<_> = picks.iter().map(|&(row, outcome, class, shape)| {
            let mut hole = base[row].clone();
            hole.outcome = [Outcome::Filled, Outcome::Skipped, Outcome::Failed][outcome];
            hole.class = [HoleClass::Closed, HoleClass::Internal, HoleClass::External][class];
            hole.shape = hole.shape.filter(|_| shape);
            hole
        }).collect();
        let summary = Summary::from_holes(&holes);
        prop_assert_eq!(summary.found, holes.len() as u64);
        prop_assert_eq!(summary.found, summary.filled + summary.skipped + summary.failed);
        let rows = HoleKind::ALL.map(|kind| *summary.by_type.get(kind));
        prop_assert_eq!(summary.found, rows.iter().map(|r| r.found).sum::<u64>());
        prop_assert!(rows.iter().all(|r| r.found == r.filled + r.skipped + r.failed));
        let area: f64 = holes.iter().map(|h| h.area_m2).sum();
        prop_assert!((area - rows.iter().map(|r| r.area_m2).sum::<f64>()).abs() <= 1e-9 * area.max(1.0));
    }
}
