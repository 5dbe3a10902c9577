//! `verify`: all checks in order.

use super::accounts::{check_clusters, check_memory, check_sums};
use super::again::check_again;
use super::cell::{CellFindings, ChangedCell, Context, check_cell};
use super::files::{Files, check_files};
use super::layout::{Layout, group_bytes, read_options};
use super::overlap::{CellStrips, check_overlaps};
use super::ragged::check_ragged;
use super::records::Records;
use super::seams::{CellBorder, check_seams};
use super::verdict::{Findings, PromiseResult, Verdict};
use super::work::Work;
use crate::report::Outcome;
use crate::{ExitCode, Interrupt, RunError};
use lacuna_grid::CellId;
use lacuna_hole::BorderMode;
use lacuna_tile::{Scene, SceneError, SceneOptions, TileFormat, open_scene};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Scenes below this size are repaired again to judge promise 3, bytes.
const SMALL_SCENE_BYTES: u64 = 64 << 20;

/// Whether promise 3 is judged by repairing again into a temporary folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Again {
    /// If the scene is smaller than 64 MiB.
    #[default]
    IfSmall,
    /// Whatever it takes.
    Always,
    /// Not at all.
    Never,
}

/// How `verify` works.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// Worker threads; 0 = one a processor.
    pub threads: usize,
    /// Memory for the tiles in work, bytes.
    pub memory_limit_bytes: u64,
    /// Promise 3.
    pub again: Again,
    /// Raised when the user asks to stop.
    pub interrupt: Interrupt,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self {
            threads: 0,
            memory_limit_bytes: 1 << 30,
            again: Again::default(),
            interrupt: Interrupt::default(),
        }
    }
}

/// Reads a scene and what a finished run made of it, and judges the promises.
///
/// Steps: (1) hash all files; (2) read every delivered tile, keep its boundary, find grid, area and border mode; (3) read
/// every changed tile and the delivered one: bytes, patches, filled holes, marks; (4) compare neighbours; (5) check the
/// report's sums; (6) repair again and compare digests, if asked for. Nothing is written but by step 6, and that into a
/// temporary folder.
///
/// # Errors
/// An OUT without the records of a finished run, a scene that cannot be read, a memory limit below a tile's need, a stop.
/// A broken promise is no error: see [`Verdict::is_ok`].
pub fn verify(scene: &Path, out: &Path, options: &VerifyOptions) -> Result<Verdict, RunError> {
    let work = Work::new(options.threads, options.memory_limit_bytes, &options.interrupt)?;
    let records = Records::read(out)?;
    let scene = open_scene(scene, &SceneOptions { follow_symlinks: false }).map_err(scene_error)?;
    let files = Files::read(&scene, out, &work)?;
    let read_options = read_options(&records.report);
    let layout = Layout::read(&scene, out, &records, &read_options, &work)?;
    let context = Context {
        scene: &scene,
        out,
        files: &files,
        records: &records,
        layout: &layout,
        options: &read_options,
    };
    let mut checks = Checks { originals: check_untouched(&context), ..Checks::default() };
    let changed = changed_cells(&context, &mut checks);
    checks.cells(&context, &changed, &work)?;
    checks.unchanged_holes(&context, &changed);
    let mut promises = vec![check_files(&files, &records, out)?.into_result(1, TITLES[0], true)];
    promises.push(checks.originals.into_result(2, TITLES[1], true));
    promises.push(same_again(&scene, out, &records, options)?);
    promises.push(seams(&layout, checks.borders, &checks.strips));
    let is_patched = checks.patches.counted("patches") > 0;
    promises.push(checks.patches.into_result(5, TITLES[4], is_patched));
    promises.push(check_memory(&records.report).into_result(6, TITLES[5], true));
    let mut sums = check_sums(&records.report);
    sums.take(checks.holes_left);
    promises.push(sums.into_result(7, TITLES[6], true));
    let mut clusters = check_clusters(&records.report);
    clusters.take(checks.marks);
    promises.push(clusters.into_result(8, TITLES[7], true));
    Ok(Verdict { promises })
}

/// The promises in a few words.
const TITLES: [&str; 8] = [
    "the input is unmodified, the output whole",
    "original geometry and textures come out byte for byte",
    "the same bytes from another run",
    "cells meet across repaired holes",
    "patches are manifold, join the rim, and are not folded",
    "peak memory is under the limit",
    "every hole is filled, or left with a reason",
    "a cluster is filled in all its tiles or in none",
];

fn scene_error(error: SceneError) -> RunError {
    let exit = match error {
        SceneError::Io { .. } => ExitCode::InputOutput,
        _ => ExitCode::Usage,
    };
    RunError { exit, message: error.to_string() }
}

/// Promise 2 for files without a patch: the same bytes, or left out where that was asked for.
fn check_untouched(context: &Context<'_>) -> Findings {
    let mut findings = Findings::default();
    let tiles: BTreeSet<&str> = context.scene.tiles.iter().map(|t| t.relative.as_str()).collect();
    for (name, then) in &context.files.scene {
        match context.files.out.get(name) {
            None if context.records.is_omitting() => {}
            None => findings.offend(format!("{name}: missing in OUT")),
            Some(now) if now == then => findings.count("files of the same bytes", 1),
            Some(_) if tiles.contains(name.as_str()) => {}
            Some(_) => findings.offend(format!("{name}: a side file with other content")),
        }
    }
    findings
}

/// Cells of which a file differs from the delivered one, or has none.
fn changed_cells(context: &Context<'_>, checks: &mut Checks) -> Vec<ChangedCell> {
    let scene = context.scene;
    let mut cells = Vec::new();
    let cell_of: BTreeMap<usize, CellId> = context.layout.groups.iter().map(|(c, g)| (*g, *c)).collect();
    for (number, group) in scene.groups.iter().enumerate() {
        let parts: Vec<(String, TileFormat)> =
            group.parts.iter().map(|&p| (scene.tiles[p].relative.clone(), scene.tiles[p].format)).collect();
        if !parts.iter().any(|(name, _)| context.files.is_changed(name)) {
            continue;
        }
        match cell_of.get(&number) {
            Some(&cell) => cells.push(ChangedCell { cell, tile: group.name.clone(), parts }),
            None => {
                checks.originals.offend(format!("{}: changed, but cannot be read as delivered", group.name))
            }
        }
    }
    cells.extend(new_cells(context, checks));
    cells
}

/// Tiles that the scene lacks: those of hollow cells. The report says which cell each is of.
fn new_cells(context: &Context<'_>, checks: &mut Checks) -> Vec<ChangedCell> {
    let holes = &context.records.report.holes;
    let mut cells = Vec::new();
    for name in context.files.out.keys().filter(|name| !context.files.scene.contains_key(*name)) {
        let path = Path::new(name);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some(format) = TileFormat::from_path(path) else { continue };
        match holes.iter().find(|h| h.tile == stem && h.outcome == Outcome::Filled) {
            Some(hole) if !context.layout.groups.contains_key(&CellId::new(hole.cell[0], hole.cell[1])) => {
                let cell = CellId::new(hole.cell[0], hole.cell[1]);
                cells.push(ChangedCell { cell, tile: stem, parts: vec![(name.clone(), format)] });
            }
            _ => checks.marks.offend(format!("{name}: a new tile that no filled hole asks for")),
        }
    }
    cells
}

/// Findings of all cells together.
#[derive(Default)]
struct Checks {
    originals: Findings,
    patches: Findings,
    holes_left: Findings,
    marks: Findings,
    borders: BTreeMap<CellId, CellBorder>,
    strips: BTreeMap<CellId, CellStrips>,
}

impl Checks {
    fn cells(
        &mut self,
        context: &Context<'_>,
        changed: &[ChangedCell],
        work: &Work<'_>,
    ) -> Result<(), RunError> {
        for (&cell, &group) in &context.layout.groups {
            let tile = context.scene.groups[group].name.clone();
            let edges = context.layout.delivered_border(cell);
            self.borders.insert(cell, CellBorder { tile, edges, last_place_m: 0.0 });
        }
        let results = work.each(
            changed.len(),
            |k| cell_bytes(context, &changed[k]),
            |k| check_cell(context, &changed[k]),
        )?;
        for (changed, found) in changed.iter().zip(results) {
            self.take(changed.cell, found);
        }
        Ok(())
    }

    fn take(&mut self, cell: CellId, found: CellFindings) {
        self.originals.take(found.originals);
        self.patches.take(found.patches);
        self.holes_left.take(found.holes_left);
        self.marks.take(found.marks);
        self.borders.insert(cell, found.border);
        self.strips.insert(cell, found.strips);
    }

    /// Holes that the report calls filled in tiles that did not change at all.
    fn unchanged_holes(&mut self, context: &Context<'_>, changed: &[ChangedCell]) {
        let cells: BTreeSet<[i32; 2]> = changed.iter().map(|c| [c.cell.i, c.cell.j]).collect();
        let holes = context.records.report.holes.iter();
        for hole in holes.filter(|h| h.outcome == Outcome::Filled && !cells.contains(&h.cell)) {
            self.holes_left.offend(format!("{} ({}): the hole is still open", hole.tile, hole.id));
            self.marks
                .offend(format!("{}: no patch of {}, which the report calls filled", hole.tile, hole.id));
        }
    }
}

/// A changed cell is held twice, as mesh and as bytes, and its patches as edges.
fn cell_bytes(context: &Context<'_>, changed: &ChangedCell) -> u64 {
    let written = changed.parts.iter().filter_map(|(name, _)| context.files.out.get(name)).map(|f| f.bytes);
    let group = context.layout.groups.get(&changed.cell).map(|&g| &context.scene.groups[g]);
    let delivered = group.map_or(0, |g| group_bytes(context.scene, g));
    2 * delivered + 4 * written.sum::<u64>() + (1 << 20)
}

fn same_again(
    scene: &Scene,
    out: &Path,
    records: &Records,
    options: &VerifyOptions,
) -> Result<PromiseResult, RunError> {
    let is_small = records.report.scene.bytes < SMALL_SCENE_BYTES;
    let asked = match options.again {
        Again::IfSmall => is_small,
        Again::Always => true,
        Again::Never => false,
    };
    let mut findings = Findings::default();
    if !asked {
        findings.note("not repaired again; compare `lacuna verify --digest OUT` of two runs");
        return Ok(findings.into_result(3, TITLES[2], false));
    }
    match check_again(&scene.root, out, &records.report, &options.interrupt)? {
        Some(found) => Ok(found.into_result(3, TITLES[2], true)),
        None => {
            findings.note("the report does not hold the polygons of the run; compare digests of two runs");
            Ok(findings.into_result(3, TITLES[2], false))
        }
    }
}

fn seams(
    layout: &Layout,
    borders: BTreeMap<CellId, CellBorder>,
    strips: &BTreeMap<CellId, CellStrips>,
) -> PromiseResult {
    let (grid, tolerance_m) = (&layout.grid, layout.tolerance_m());
    let mut findings = match layout.fit.mode {
        BorderMode::Overrun => check_overlaps(strips, grid, layout.fit.margin_m, tolerance_m),
        BorderMode::Exact => check_seams(&borders, grid, tolerance_m, &layout.area.cells, &layout.unreadable),
        BorderMode::Ragged => {
            check_ragged(&borders, layout.stub_reach_m(), |cell, place| layout.is_outer(cell, place))
        }
        BorderMode::Overlap => Findings::default(),
    };
    findings.note(format!("tiles meet their borders: {:?}", layout.fit.mode).to_lowercase());
    if layout.fit.mode == BorderMode::Overlap {
        findings.note("such tiles share no border vertices, and their overlap has no fixed width to compare");
    }
    let judged = ["border vertices", "border edges", "samples", "stubs between tiles"]
        .map(|what| findings.counted(what));
    let is_judged = judged.iter().sum::<u64>() > 0;
    findings.into_result(4, TITLES[3], is_judged)
}
