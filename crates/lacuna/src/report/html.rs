//! `report.html`: one page that needs nothing but itself, offline, in light and dark.
//!
//! All text goes through the template's escaping (its name ends in `.html`) or [`escaped`](super::map::escaped). A
//! content security policy allows no script but the page's own, and nothing from outside.

use super::attention::{Attention, attention, place};
use super::drawing::Drawing;
use super::kind::HoleKind;
use super::map::map;
use super::model::{ClusterRecord, HoleRecord, Outcome, Report};
use super::numbers;
use crate::logging::shown;
use minijinja::Environment;
use minijinja::value::{Serde, Value};
use serde::Serialize;
use std::collections::BTreeMap;

/// Most rows of a list on the page; `report.json` has all.
const MAX_ROWS: usize = 2000;

/// A page that could not be made. Both are faults of the program, not of the input.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The template.
    #[error("the page of the report could not be made: {0}")]
    Template(#[from] minijinja::Error),
    /// A hillshade.
    #[error("the hillshade of the report could not be made: {0}")]
    Image(#[from] png::EncodingError),
    /// The settings.
    #[error("the settings could not be written into the report's page: {0}")]
    Settings(#[from] serde_json::Error),
}

/// The page of a run.
///
/// # Errors
/// See [`PageError`].
pub fn page(report: &Report, drawing: &Drawing) -> Result<String, PageError> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    environment.add_template("report.html", include_str!("../../templates/report.html"))?;
    let template = environment.get_template("report.html")?;
    let contents = Page {
        title: title(report),
        sentence: sentence(report),
        facts: facts(report),
        table: table_rows(report),
        attention: attention(report).into_iter().map(Look::of).collect(),
        map: Value::from_safe_string(map_of(report, drawing)?),
        has_after: drawing.before.is_some() && drawing.after.is_some(),
        clusters: cluster_rows(report),
        clusters_left_out: report.clusters.len().saturating_sub(MAX_ROWS),
        holes: hole_rows(report),
        holes_left_out: report.holes.len().saturating_sub(MAX_ROWS),
        stages: stage_rows(report),
        not_holes: report
            .not_holes
            .iter()
            .map(|(kind, count)| format!("{count} {}", shown(&kind.replace('_', " "))))
            .collect(),
        warnings: report.warnings.iter().map(|w| shown(w)).collect(),
        defects: report.defects.iter().take(MAX_ROWS).map(|d| [shown(&d.tile), shown(&d.what)]).collect(),
        configuration: shown_lines(&serde_json::to_string_pretty(&report.configuration)?),
        execution: shown_lines(&serde_json::to_string_pretty(&report.execution)?),
        nonce: nonce(report)?,
    };
    Ok(template.render(Value::from(Serde(&contents)))?)
}

/// What the template sees.
#[derive(Serialize)]
struct Page {
    title: String,
    sentence: String,
    facts: Vec<[String; 2]>,
    table: Vec<KindRow>,
    attention: Vec<Look>,
    map: Value,
    has_after: bool,
    clusters: Vec<ClusterRow>,
    clusters_left_out: usize,
    holes: Vec<HoleRow>,
    holes_left_out: usize,
    stages: Vec<StageRow>,
    not_holes: Vec<String>,
    warnings: Vec<String>,
    defects: Vec<[String; 2]>,
    configuration: String,
    execution: String,
    nonce: String,
}

#[derive(Serialize)]
struct Look {
    topic: &'static str,
    text: String,
    id: Option<String>,
}

impl Look {
    fn of(one: Attention) -> Self {
        Self { topic: one.topic, text: shown(&one.text), id: one.id.as_deref().map(shown) }
    }
}

#[derive(Serialize)]
struct KindRow {
    group: &'static str,
    words: &'static str,
    key: &'static str,
    found: u64,
    filled: u64,
    skipped: u64,
    failed: u64,
    area: String,
}

#[derive(Serialize)]
struct ClusterRow {
    id: String,
    place: String,
    tiles: String,
    tile_count: usize,
    area: String,
    area_m2: f64,
    layers: u32,
    level: String,
    outcome: &'static str,
    reason: String,
}

#[derive(Serialize)]
struct HoleRow {
    id: String,
    tile: String,
    kind: String,
    kind_order: usize,
    layer: u32,
    area: String,
    area_m2: f64,
    perimeter_m: f64,
    rim_vertices: u64,
    outcome: &'static str,
    reason: String,
    filler: String,
    triangles: u64,
    quality: String,
}

#[derive(Serialize)]
struct StageRow {
    name: String,
    time: String,
    cpu: String,
    share: f64,
    memory: String,
    memory_share: f64,
}

/// A value that nobody who wrote the tiles could know: the page's own script and style carry it.
fn nonce(report: &Report) -> Result<String, serde_json::Error> {
    Ok(blake3::hash(report.to_json()?.as_bytes()).to_hex()[..32].to_owned())
}

fn title(report: &Report) -> String {
    let scene = report.execution.scene.trim_end_matches(['/', '\\']);
    let name = scene.rsplit(['/', '\\']).next().unwrap_or(scene);
    if name.is_empty() { "Repair of a scene".to_owned() } else { shown(name) }
}

/// What happened, in one sentence or two.
fn sentence(report: &Report) -> String {
    let summary = &report.summary;
    if summary.found == 0 {
        return "No holes were found; every tile is as it was.".to_owned();
    }
    let inspected = |h: &HoleRecord| h.reason.as_deref() == Some("inspected only");
    let clusters = numbers::count(report.clusters.len() as u64, "cluster", "clusters");
    if report.holes.iter().any(inspected) {
        return format!(
            "Found {} in {clusters}; nothing was written.",
            numbers::count(summary.found, "hole", "holes")
        );
    }
    let area_m2: f64 = report.holes.iter().filter(|h| h.outcome == Outcome::Filled).map(|h| h.area_m2).sum();
    let mut text = format!(
        "Filled {} of {} in {clusters}, {} m\u{b2}, and changed {} of {}.",
        numbers::grouped(summary.filled),
        numbers::count(summary.found, "hole", "holes"),
        numbers::area(area_m2),
        numbers::grouped(report.changed_tiles.len() as u64),
        numbers::count(report.scene.cells, "tile", "tiles"),
    );
    if summary.skipped > 0 {
        let holes = numbers::count(summary.skipped, "hole was", "holes were");
        text += &format!(" {holes} left open on purpose.");
    }
    if summary.failed > 0 {
        text += &format!(" {} failed.", numbers::count(summary.failed, "hole", "holes"));
    }
    text
}

/// Facts of scene and run: name and value.
fn facts(report: &Report) -> Vec<[String; 2]> {
    let scene = &report.scene;
    let mut facts = vec![
        ["Tiles".to_owned(), format!("{} {}", numbers::grouped(scene.cells), shown(&scene.format))],
        ["Triangles".to_owned(), numbers::grouped(scene.triangles)],
        ["Size".to_owned(), numbers::bytes(scene.bytes)],
        ["Cells".to_owned(), format!("{} m, {} borders", scene.cell_size_m, scene.border_mode)],
        ["Method".to_owned(), report.method.clone()],
        ["Time".to_owned(), numbers::seconds(report.stages.iter().map(|s| s.seconds).sum())],
        [
            "Peak memory".to_owned(),
            format!(
                "{} of {}",
                numbers::bytes(report.peak_rss_bytes),
                numbers::bytes(report.memory_limit_bytes)
            ),
        ],
        [
            "Seams".to_owned(),
            format!(
                "{} borders, {} of {} vertices shared, widest gap {:.4} m",
                numbers::grouped(report.seams.borders),
                numbers::grouped(report.seams.shared_vertices),
                numbers::grouped(report.seams.shared_vertices + report.seams.differing_vertices),
                report.seams.max_gap_m
            ),
        ],
    ];
    if let Some(srs) = &scene.srs {
        facts.insert(4, ["SRS".to_owned(), shown(srs)]);
    }
    facts
}

fn table_rows(report: &Report) -> Vec<KindRow> {
    let row = |kind: HoleKind| {
        let count = report.summary.by_type.get(kind);
        KindRow {
            group: match kind {
                HoleKind::Closed => "closed",
                HoleKind::Internal(_) => "I, internal",
                HoleKind::External(_) => "II, at the area's edge",
            },
            words: kind.words(),
            key: kind.key(),
            found: count.found,
            filled: count.filled,
            skipped: count.skipped,
            failed: count.failed,
            area: numbers::area(count.area_m2),
        }
    };
    HoleKind::ALL.map(row).into()
}

/// Failures first, then by area; at most [`MAX_ROWS`].
fn cluster_rows(report: &Report) -> Vec<ClusterRow> {
    let mut clusters: Vec<&ClusterRecord> = report.clusters.iter().collect();
    clusters.sort_by(|a, b| {
        b.outcome.cmp(&a.outcome).then(b.area_m2.total_cmp(&a.area_m2)).then(a.id.cmp(&b.id))
    });
    clusters.truncate(MAX_ROWS);
    let row = |cluster: &ClusterRecord| ClusterRow {
        id: shown(&cluster.id),
        place: place(cluster),
        tiles: shown(&cluster.tiles.join(", ")),
        tile_count: cluster.tiles.len(),
        area: numbers::area(cluster.area_m2),
        area_m2: cluster.area_m2,
        layers: cluster.layers,
        level: cluster.level_m.map_or_else(String::new, |level| format!("{level:.2}")),
        outcome: cluster.outcome.word(),
        reason: shown(cluster.reason.as_deref().unwrap_or_default()),
    };
    clusters.into_iter().map(row).collect()
}

fn hole_rows(report: &Report) -> Vec<HoleRow> {
    let mut holes: Vec<&HoleRecord> = report.holes.iter().collect();
    holes.sort_by(|a, b| {
        b.outcome.cmp(&a.outcome).then(b.area_m2.total_cmp(&a.area_m2)).then(a.id.cmp(&b.id))
    });
    holes.truncate(MAX_ROWS);
    let row = |hole: &HoleRecord| HoleRow {
        id: shown(&hole.id),
        tile: shown(&hole.tile),
        kind: hole.kind().key().to_owned(),
        kind_order: hole.kind().row(),
        layer: hole.layer,
        area: numbers::area(hole.area_m2),
        area_m2: hole.area_m2,
        perimeter_m: (hole.perimeter_m * 10.0).round() / 10.0,
        rim_vertices: hole.rim_vertices,
        outcome: hole.outcome.word(),
        reason: shown(hole.reason.as_deref().unwrap_or_default()),
        filler: shown(hole.filler.as_deref().unwrap_or_default()),
        triangles: hole.patch_triangles,
        quality: hole.quality_mean.map_or_else(String::new, |q| format!("{q:.3}")),
    };
    holes.into_iter().map(row).collect()
}

fn stage_rows(report: &Report) -> Vec<StageRow> {
    let longest = report.stages.iter().map(|s| s.seconds).fold(0.0, f64::max);
    let limit = report.memory_limit_bytes.max(1) as f64;
    let row = |stage: &super::StageRecord| StageRow {
        name: stage.name.clone(),
        time: numbers::seconds(stage.seconds),
        cpu: numbers::seconds(stage.cpu_seconds),
        share: if longest > 0.0 { stage.seconds / longest } else { 0.0 },
        memory: numbers::bytes(stage.peak_rss_bytes),
        memory_share: (stage.peak_rss_bytes as f64 / limit).min(1.0),
    };
    report.stages.iter().map(row).collect()
}

/// The map, with each hole's record as its title.
fn map_of(report: &Report, drawing: &Drawing) -> Result<String, PageError> {
    let records: BTreeMap<&str, &HoleRecord> = report.holes.iter().map(|h| (h.id.as_str(), h)).collect();
    let title_of = |id: &str| records.get(id).map_or_else(|| shown(id), |hole| one_line(hole));
    Ok(map(drawing, &title_of)?)
}

fn one_line(hole: &HoleRecord) -> String {
    let kind = match hole.kind() {
        HoleKind::Closed => "closed".to_owned(),
        kind => format!("{} {}", hole.class.word(), kind.words()),
    };
    let reason = hole.reason.as_ref().map_or_else(String::new, |r| format!(": {r}"));
    shown(&format!(
        "{} in {} \u{b7} {kind} \u{b7} layer {} \u{b7} {} m\u{b2} \u{b7} rim of {} vertices \u{b7} {}{reason}",
        hole.id,
        hole.tile,
        hole.layer,
        numbers::area(hole.area_m2),
        hole.rim_vertices,
        hole.outcome.word(),
    ))
}

fn shown_lines(text: &str) -> String {
    text.lines().map(shown).collect::<Vec<_>>().join("\n")
}
