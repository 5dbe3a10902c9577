//! `inspect` and `repair`.

use super::RunError;
use super::area::area;
use super::assemble::{cluster_records, drawing, hole_records, outcomes, scene_record, seam_record};
use super::baseline::{AggregateInput, aggregate};
use super::context::{Context, Stages, Stopwatch};
use super::field::water_rule;
use super::frames::{Frames, SeamFacts};
use super::hollow::hollow_tiles;
use super::manifest::{InputFile, MANIFEST, Manifest, OutputFile, write_whole};
use super::names::Names;
use super::out_dir::{self, OutDir};
use super::outputs::write_report;
use super::preview::scene_rasters;
use super::scan::{Scanned, scan};
use super::select::{Decision, Places, fill_settings, refuse_unmatched, select, warn_unmatched};
use super::solve::{Fills, Solved, solve};
use super::write::{WriteInput, WrittenFiles, hex, write};
use crate::ExitCode;
use crate::Interrupt;
use crate::config::{FailOn, FillSettings, MethodName, Settings, WaterIslands};
use crate::progress::Progress;
use crate::report::{DefectRecord, Drawing, Execution, Outcome, REPORT_VERSION, Report, Summary};
use glam::DVec3;
use lacuna_close::hovering_islands;
use lacuna_grid::CellId;
use lacuna_hole::{ClusterRule, Hole, Plan, PlanOptions, fit_borders, plan};
use lacuna_tile::{Scene, SceneError, SceneOptions, TileFormat, open_scene};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::UNIX_EPOCH;

/// A finished run.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// The report.
    pub report: Report,
    /// Shapes for map and page.
    pub drawing: Drawing,
    /// How the process should end.
    pub exit: ExitCode,
}

/// A scene, scanned and planned.
struct Planned {
    scene: Scene,
    scanned: Scanned,
    plan: Plan,
    names: Names,
    decisions: Vec<Decision>,
    places: Places,
    /// Template cell and relative path of the tile of every hollow cell.
    hollow: BTreeMap<CellId, (CellId, String)>,
    /// Holes as they were planned whose islands the water passes beneath, by number.
    as_planned: BTreeMap<u32, Hole>,
    /// Added to scene coordinates to get SRS coordinates.
    srs_origin: DVec3,
}

/// Finds and classifies all holes of a scene; writes no tile. With `report` the report, page and maps go into that folder.
///
/// # Errors
/// Unreadable scene, unusable settings, a memory limit too small for a tile, or a stop.
pub fn inspect(
    settings: &Settings,
    report: Option<&Path>,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<RunResult, RunError> {
    if let Some(folder) = report {
        out_dir::refuse_nesting(&settings.scene.input, folder)?;
    }
    let context = Context::new(settings, interrupt, progress)?.only_looking(report.is_some());
    let mut stages = Stages::default();
    let mut planned = scan_and_plan(&context, &mut stages)?;
    for decision in &mut planned.decisions {
        if *decision == Decision::Fill {
            *decision = Decision::Skip("inspected only".to_owned());
        }
    }
    let clock = Stopwatch::start();
    let mut result = finish(&planned, &Solved::default(), &Written::default(), stages, &context);
    result.drawing.after = None;
    if let Some(folder) = report {
        std::fs::create_dir_all(folder).map_err(|e| out_dir::io_error("make", folder, &e))?;
        write_report(&mut result, folder, clock)?;
    }
    Ok(result)
}

/// Repairs a scene into the output folder of the settings: scan, plan, close and fill, write, report.
///
/// # Errors
/// As `inspect`; an output folder that may not be written; errors of the disk.
pub fn repair(
    settings: &Settings,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<RunResult, RunError> {
    let Some(out) = settings.scene.output.as_deref() else {
        return Err(RunError::usage("no output folder; give it after the scene, or as scene.output"));
    };
    if settings.run.dry_run {
        return inspect(settings, None, interrupt, progress);
    }
    let context = Context::new(settings, interrupt, progress)?;
    let mut stages = Stages::default();
    let out = out_dir::take(&settings.scene.input, out)?;
    refuse_partial_rerun(settings, &out)?;
    let mut planned = scan_and_plan(&context, &mut stages)?;
    pass_under_islands(&mut planned, settings);
    let solved = context.interrupt.end_at_once_during(|| fill(&planned, &context, &mut stages))?;
    context.check_stop()?;
    let mut manifest = start_manifest(&planned, &context);
    let written =
        stages.measure("write", || write_all(&planned, &solved.fills, &out, &mut manifest, &context))?;
    context.check_stop()?;
    let clock = Stopwatch::start();
    let mut result = finish(&planned, &solved, &written, stages, &context);
    write_plan(&planned, &out)?;
    write_changed(&manifest, &out)?;
    write_report(&mut result, &out.own, clock)?;
    manifest.finished = true;
    manifest.write(&out.own.join(MANIFEST))?;
    Ok(result)
}

/// A run of a part would leave out what an earlier, finished run repaired elsewhere.
fn refuse_partial_rerun(settings: &Settings, out: &OutDir) -> Result<(), RunError> {
    let is_finished = out.earlier.as_ref().is_some_and(|e| e.finished);
    if settings.selection.is_whole_scene() || settings.run.overwrite || !is_finished {
        return Ok(());
    }
    Err(RunError::usage(format!(
        "{} holds an earlier run, and this version can't repair a part of it again; give a new folder, or --overwrite to \
         start anew",
        out.root.display()
    )))
}

fn scan_and_plan(context: &Context<'_>, stages: &mut Stages) -> Result<Planned, RunError> {
    let settings = context.settings;
    let options = SceneOptions { follow_symlinks: !settings.run.untrusted };
    let scene = open_scene(&settings.scene.input, &options).map_err(scene_error)?;
    scene.warnings.iter().for_each(|w| tracing::warn!("{w}"));
    let scanned = stages.measure("scan", || scan(&scene, context))?;
    let planned = stages
        .measure("plan", || context.interrupt.end_at_once_during(|| make_plan(scene, scanned, context)))?;
    context.check_stop()?;
    Ok(planned)
}

pub(crate) fn scene_error(error: SceneError) -> RunError {
    let exit = match error {
        SceneError::Io { .. } => ExitCode::InputOutput,
        _ => ExitCode::Usage,
    };
    RunError { exit, message: error.to_string() }
}

fn make_plan(scene: Scene, scanned: Scanned, context: &Context<'_>) -> Result<Planned, RunError> {
    let settings = context.settings;
    let origin = settings.scene.srs_origin.or_else(|| scene.metadata.as_ref().map(|m| m.srs_origin));
    let srs_origin = origin.map_or(DVec3::ZERO, DVec3::from);
    let fit = fit_borders(&scanned.surveys, &scanned.grid.grid);
    let area = area(&scanned, &settings.area.limit, srs_origin.truncate(), fit.margin_m)?;
    let unreadable = scanned.unreadable_cells(&area.cells);
    let options = PlanOptions {
        grid: scanned.grid.grid,
        fit,
        // A lake as a person sees it: holes that meet, not all holes of neighbouring cells.
        rule: ClusterRule::Interval,
        unreadable,
        area,
    };
    let plan = plan(&scanned.surveys, &options);
    let hollow = hollow_tiles(&scene, &scanned.tiles, plan.domains.keys());
    let hollow_names: BTreeMap<CellId, String> =
        hollow.iter().map(|(c, (_, path))| (*c, stem(path))).collect();
    let names = Names::new(&plan, &scanned.tiles, &hollow_names, srs_origin.truncate());
    let places = Places::new(settings, srs_origin);
    let hollow_names = hollow_names.values().map(String::as_str);
    let known_tiles = scene.groups.iter().map(|g| g.name.as_str()).chain(hollow_names).collect();
    refuse_unmatched(&plan, &names, &known_tiles, settings, &places)?;
    warn_unmatched(&plan, &names, settings, &places);
    let decisions = select(&plan, &names, settings, &places);
    let as_planned = BTreeMap::new();
    Ok(Planned { scene, scanned, plan, names, decisions, places, hollow, as_planned, srs_origin })
}

/// Takes the islands that hover over water out of the holes that are to be filled (decisions 23).
fn pass_under_islands(planned: &mut Planned, settings: &Settings) {
    let surveys = &planned.scanned.surveys;
    for c in 0..planned.plan.clusters.len() {
        let fill = fill_settings(&planned.plan, c, settings, &planned.places);
        let WaterIslands::Under { max_area_m2 } = fill.islands else { continue };
        if planned.decisions[c] != Decision::Fill || fill.method != MethodName::Field {
            continue;
        }
        let rule = water_rule(fill.water);
        let cluster = &planned.plan.clusters[c];
        for (h, islands) in hovering_islands(surveys, &planned.plan, cluster, rule, max_area_m2) {
            let hole = &mut planned.plan.holes[h as usize];
            planned.as_planned.insert(h, hole.clone());
            if let Some(survey) = surveys.get(&hole.cell) {
                hole.pass_under(survey, &islands);
            }
        }
        let area = |h: &u32| planned.plan.holes[*h as usize].area_m2;
        planned.plan.clusters[c].area_m2 = planned.plan.clusters[c].holes.iter().map(area).sum();
    }
}

fn stem(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

fn fill(planned: &Planned, context: &Context<'_>, stages: &mut Stages) -> Result<Solved, RunError> {
    let todo: BTreeSet<u32> = planned
        .plan
        .clusters
        .iter()
        .zip(&planned.decisions)
        .filter(|(_, d)| **d == Decision::Fill)
        .flat_map(|(c, _)| c.holes.iter().copied())
        .collect();
    let of_cluster = |cluster| fill_settings(&planned.plan, cluster, context.settings, &planned.places);
    let of_clusters: Vec<FillSettings> = (0..planned.plan.clusters.len()).map(of_cluster).collect();
    let settings_of = |hole: u32| of_clusters[planned.plan.holes[hole as usize].cluster as usize];
    let frames = frames(planned);
    if context.settings.fill.method == MethodName::Aggregate {
        let input = AggregateInput {
            scene: &planned.scene,
            scanned: &planned.scanned,
            plan: &planned.plan,
            frames: &frames,
            todo: &todo,
            settings_of: &settings_of,
        };
        return aggregate(&input, context, stages);
    }
    solve(&planned.scanned.surveys, &planned.plan, &frames, &todo, &settings_of, context, stages)
}

fn frames(planned: &Planned) -> Frames {
    let templates = planned.hollow.iter().map(|(c, (t, _))| (*c, *t)).collect();
    Frames::new(&planned.scanned.tiles, &templates)
}

/// What the write stage left, beside the manifest.
#[derive(Default)]
struct Written {
    /// Cells whose tile could not take its patches, with the reason.
    refused: BTreeMap<CellId, String>,
    /// Files of the scene that OUT lacks.
    missing: Vec<DefectRecord>,
    /// Relative paths of the tiles that got a patch.
    changed_tiles: Vec<String>,
}

/// Writes all files, and lists them in the manifest. A tile that can't take its patches costs the clusters it touches:
/// the others are written again without them, until what is written holds every cluster whole or not at all.
fn write_all(
    planned: &Planned,
    fills: &Fills,
    out: &OutDir,
    manifest: &mut Manifest,
    context: &Context<'_>,
) -> Result<Written, RunError> {
    // Until the new list stands, the old one and what may come tell what is lacuna's in OUT.
    manifest.outputs = out.earlier.as_ref().map_or_else(Vec::new, |e| e.outputs.clone());
    let listed: BTreeSet<String> = manifest.outputs.iter().map(|f| f.path.clone()).collect();
    let coming = planned.hollow.values().map(|(_, path)| path).filter(|p| !listed.contains(*p));
    manifest.outputs.extend(coming.map(|path| OutputFile::coming(path)));
    manifest.write(&out.own.join(MANIFEST))?;
    let mut refused: BTreeMap<CellId, String> = BTreeMap::new();
    loop {
        let outcomes = outcomes(&planned.plan, &planned.names, &planned.decisions, fills, &refused);
        let holes: BTreeSet<u32> =
            (0..outcomes.len() as u32).filter(|&h| outcomes[h as usize].outcome == Outcome::Filled).collect();
        let input = WriteInput {
            scene: &planned.scene,
            out: &out.root,
            plan: &planned.plan,
            names: &planned.names,
            tiles: &planned.scanned.tiles,
            fills,
            holes: &holes,
            hollow: &planned.hollow,
        };
        let written = write(&input, context)?;
        if let Some(file) = written.missing.first().filter(|_| context.settings.run.strict) {
            return Err(RunError::failed(&file.what));
        }
        if written.refused.is_empty() {
            remove_stale(out, &written)?;
            let tiles = written
                .outputs
                .iter()
                .filter(|f| f.changed && TileFormat::from_path(f.path.as_ref()).is_some());
            let changed_tiles = tiles.map(|f| f.path.clone()).collect();
            manifest.outputs = written.outputs;
            return Ok(Written { refused, missing: written.missing, changed_tiles });
        }
        // The tiles that this round did patch may belong to clusters that are dropped now.
        delete_changed(out, &written)?;
        refused.extend(written.refused);
    }
}

/// Deletes the patched tiles of a round that is done again.
fn delete_changed(out: &OutDir, written: &WrittenFiles) -> Result<(), RunError> {
    let mut patched = Manifest::new(String::new());
    patched.outputs = written.outputs.iter().filter(|f| f.changed).cloned().collect();
    patched.delete_listed(&out.root)
}

/// Files that an earlier run wrote and this one did not.
fn remove_stale(out: &OutDir, written: &WrittenFiles) -> Result<(), RunError> {
    let Some(earlier) = &out.earlier else { return Ok(()) };
    let now: BTreeSet<&str> = written.outputs.iter().map(|f| f.path.as_str()).collect();
    let mut stale = earlier.clone();
    stale.outputs.retain(|f| !now.contains(f.path.as_str()));
    stale.delete_listed(&out.root)
}

fn start_manifest(planned: &Planned, context: &Context<'_>) -> Manifest {
    let untouched = format!("{:?}", context.settings.scene.untouched).to_lowercase();
    let mut manifest = Manifest::new(untouched);
    for part in planned.scanned.tiles.values().flat_map(|t| &t.parts) {
        let entry = &planned.scene.tiles[part.tile];
        let path = planned.scene.path(entry);
        manifest.inputs.push(InputFile {
            path: entry.relative.clone(),
            bytes: part.bytes,
            modified_ns: modified_ns(&path),
            blake3: hex(&part.hash),
        });
    }
    manifest.inputs.sort_by(|a, b| a.path.cmp(&b.path));
    manifest
}

fn modified_ns(path: &Path) -> u64 {
    let modified = std::fs::metadata(path).and_then(|m| m.modified());
    let since = modified.ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
    since.map_or(0, |d| d.as_nanos() as u64)
}

/// Makes the report and says how the process should end.
fn finish(
    planned: &Planned,
    solved: &Solved,
    ending: &Written,
    stages: Stages,
    context: &Context<'_>,
) -> RunResult {
    let settings = context.settings;
    let plan = &planned.plan;
    let Solved { fills, curves, water } = solved;
    let outcomes = outcomes(plan, &planned.names, &planned.decisions, fills, &ending.refused);
    let is_filled = |h: u32| outcomes[h as usize].outcome == Outcome::Filled;
    let seams = if curves.curves.is_empty() {
        SeamFacts::default()
    } else {
        frames(planned).compare(plan, curves, fills, is_filled)
    };
    let holes = hole_records(plan, &planned.names, &outcomes, fills);
    let report = Report {
        version: REPORT_VERSION,
        lacuna: env!("CARGO_PKG_VERSION").to_owned(),
        method: settings.fill.method.word().to_owned(),
        threads: context.pool.thread_count(),
        memory_limit_bytes: settings.run.memory_limit_bytes,
        peak_rss_bytes: lacuna_system::peak_rss_bytes().unwrap_or(0),
        scene: scene_record(&planned.scene, &planned.scanned, plan, settings),
        clusters: cluster_records(plan, &planned.names, &outcomes, water, planned.srs_origin),
        summary: Summary::from_holes(&holes),
        holes,
        seams: seam_record(&seams),
        configuration: settings.to_json(),
        not_holes: not_holes(plan),
        defects: defects(planned, ending),
        warnings: planned.scene.warnings.clone(),
        changed_tiles: ending.changed_tiles.clone(),
        execution: Execution {
            command: std::env::args().collect(),
            scene: settings.scene.input.display().to_string(),
            output: settings.scene.output.as_ref().map(|p| p.display().to_string()).unwrap_or_default(),
            seconds: stages.records.iter().map(|s| s.seconds).sum(),
            kept_clusters: 0,
            settings: settings.run_facts(),
        },
        stages: stages.records,
    };
    let written = (0..outcomes.len() as u32).filter(|&h| is_filled(h)).collect();
    let mut drawing = drawing(plan, &planned.scanned, &planned.names, &outcomes);
    if context.draws {
        let scanned = &planned.scanned;
        let (before, after) = scene_rasters(&scanned.previews, &scanned.bounds, fills, &written);
        drawing.before = Some(before);
        drawing.after = Some(after);
    }
    let exit = exit_code(&report, settings.run.fail_on, !ending.refused.is_empty());
    RunResult { report, drawing, exit }
}

fn not_holes(plan: &Plan) -> BTreeMap<String, u64> {
    let name = |n: &lacuna_hole::NotHole| {
        serde_json::to_value(n).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
    };
    let mut counts: BTreeMap<String, u64> =
        plan.not_holes.iter().map(|(n, &count)| (name(n), u64::from(count))).collect();
    if plan.unclear_stretches > 0 {
        counts.insert("unclear_border".to_owned(), u64::from(plan.unclear_stretches));
    }
    counts
}

/// What is wrong with files of the scene; of a tile that neither scan nor copy could read, what the scan said.
fn defects(planned: &Planned, ending: &Written) -> Vec<DefectRecord> {
    let mut defects = planned.scanned.defects.clone();
    for file in &ending.missing {
        tracing::warn!("{}", file.what);
        if !defects.iter().any(|d| d.unusable && d.tile == file.tile) {
            defects.push(file.clone());
        }
    }
    defects
}

fn exit_code(report: &Report, fail_on: FailOn, tile_refused: bool) -> ExitCode {
    let bad_tile = tile_refused || report.defects.iter().any(|d| d.unusable);
    let failed = report.summary.failed > 0;
    match fail_on {
        FailOn::Never => ExitCode::Done,
        FailOn::Tiles if bad_tile => ExitCode::Finished,
        FailOn::Holes if bad_tile || failed => ExitCode::Finished,
        _ => ExitCode::Done,
    }
}

fn write_plan(planned: &Planned, out: &OutDir) -> Result<(), RunError> {
    let mut plan = Cow::Borrowed(&planned.plan);
    for (&h, hole) in &planned.as_planned {
        plan.to_mut().holes[h as usize] = hole.clone();
    }
    let plan = serde_json::to_string_pretty(&*plan).map_err(|e| RunError::failed(e.to_string()))?;
    write_whole(&out.own.join("plan.json"), plan.as_bytes())
}

/// All that a copy of the scene needs from OUT: changed and new tiles, and new files beside them.
fn write_changed(manifest: &Manifest, out: &OutDir) -> Result<(), RunError> {
    let changed: String =
        manifest.outputs.iter().filter(|f| f.changed).map(|f| format!("{}\n", f.path)).collect();
    write_whole(&out.own.join("changed.txt"), changed.as_bytes())
}
