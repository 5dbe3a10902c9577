//! Fill: contours of all holes in work, patches layer by layer, borders smoothed, touched cells filled again.

use super::RunError;
use super::context::{Context, StageKind, Stages};
use super::field::{Fields, solve_fields};
use super::frames::Frames;
use super::watertight::Watertight;
use crate::config::{ClosedFiller, FillSettings, MethodName, OpenFiller};
use glam::DVec3;
use lacuna_close::{CellContour, Curves, LayeredOptions, Source, Water, contour, project};
use lacuna_fill::{FillError, FillParams, Filled, Filler, FillerChoice, HeightRule, fill, raise};
use lacuna_grid::CellId;
use lacuna_hole::{Anchor, BorderMode, CurveKind, HoleClass, Plan, Surveys};
use lacuna_mesh::{Patch, PlanView, QualityStats, check_patch};
use lacuna_schedule::{Job, JobResult, MemoryBudget};
use lacuna_seam::{SeamVertex, SmoothParams, buffer_m, smooth};
use lacuna_solve::{FaerSolver, Solver};
use std::collections::{BTreeMap, BTreeSet};

/// A hole's patch, and what its writer and its seams need of the contour.
#[derive(Clone, Debug)]
pub(crate) struct FilledHole {
    /// Positions of the contour's vertices, in its numbering.
    pub(crate) rim: Vec<DVec3>,
    /// Where each of them comes from.
    pub(crate) sources: Vec<Source>,
    /// How many of them each ring has.
    pub(crate) ring_lengths: Vec<usize>,
    pub(crate) patch: Patch,
    pub(crate) filler: Filler,
    pub(crate) quality: QualityStats,
    /// Where its heights come from.
    pub(crate) method: MethodName,
    /// Why not from a field, where one was asked for.
    pub(crate) instead_of_field: Option<String>,
}

/// Why a hole has no patch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NotFilled {
    /// True if no filler takes it (skipped), false if work went wrong (failed).
    pub(crate) is_refusal: bool,
    pub(crate) reason: String,
}

/// Result of every hole in work, by hole number.
pub(crate) type Fills = BTreeMap<u32, Result<FilledHole, NotFilled>>;

/// Patches, and the curves they stand on.
#[derive(Default)]
pub(crate) struct Solved {
    pub(crate) fills: Fills,
    pub(crate) curves: Curves,
    /// The water of each cluster that has one, by the cluster's number.
    pub(crate) water: BTreeMap<u32, Water>,
}

/// Least spacing, in rim edges.
const FINEST: f64 = 1e-3;

/// Growth of edge lengths with the distance from the rim, in methods that grade them.
const GROWTH: f64 = 0.3;

/// Closes and fills all holes of `todo` (hole numbers).
///
/// Steps: curves from the rims, layer by layer, and the fields of the clusters that use them, which raise their curves and
/// patches; patches, a barrier after every layer; then the curves between holes of one layer that no field raised are
/// smoothed towards the patches on both sides and the cells they touch are filled again. A cluster that its patches do not
/// close is tried once more without its field, then left.
pub(crate) fn solve(
    surveys: &Surveys,
    plan: &Plan,
    frames: &Frames,
    todo: &BTreeSet<u32>,
    settings_of: &(dyn Fn(u32) -> FillSettings + Sync),
    context: &Context<'_>,
    stages: &mut Stages,
) -> Result<Solved, RunError> {
    refuse_dust(plan, todo, settings_of)?;
    context.progress.start(StageKind::Fill, todo.len() as u64, todo.len() as u64);
    let mut filler = HoleFiller {
        surveys,
        plan,
        frames,
        settings_of,
        context,
        solver: &FaerSolver,
        fields: Fields::default(),
        budget: context.budget_beside(0),
    };
    let kept = todo.iter().map(|&h| filler.patch_bytes(h)).fold(0, u64::saturating_add);
    filler.budget = context.budget_beside(kept);
    let (mut curves, fields) = stages.measure("close", || filler.close(todo))?;
    filler.fields = fields;
    let mut fills = stages.measure("fill", || filler.fill_layers(todo, &curves))?;
    stages.measure("seams", || {
        filler.smooth(&mut curves, &mut fills)?;
        filler.close_or_leave(todo, &curves, &mut fills)
    })?;
    Ok(Solved { fills, curves, water: filler.fields.water })
}

/// Triangles finer than a thousandth of the rims' edges are a slip of units, and would take all memory there is.
fn refuse_dust(
    plan: &Plan,
    todo: &BTreeSet<u32>,
    settings_of: &dyn Fn(u32) -> FillSettings,
) -> Result<(), RunError> {
    let least_m = FINEST * plan.fit.edge_m;
    match todo.iter().filter_map(|&h| settings_of(h).spacing_m).find(|s| *s < least_m) {
        Some(spacing) => Err(RunError::usage(format!(
            "a spacing of {spacing} m is less than a thousandth of the rims' edges, {:.3} m; give at least {least_m:.3} m",
            plan.fit.edge_m
        ))),
        None => Ok(()),
    }
}

fn layers_of(plan: &Plan, todo: &BTreeSet<u32>) -> BTreeSet<u32> {
    todo.iter().map(|&h| plan.holes[h as usize].layer).collect()
}

/// What a worker needs to fill one hole.
pub(crate) struct HoleFiller<'a> {
    pub(crate) surveys: &'a Surveys,
    pub(crate) plan: &'a Plan,
    frames: &'a Frames,
    pub(crate) settings_of: &'a (dyn Fn(u32) -> FillSettings + Sync),
    context: &'a Context<'a>,
    pub(crate) solver: &'a dyn Solver,
    /// Heights from the clusters' fields.
    fields: Fields,
    /// What the limit leaves beside the surveys and all patches.
    budget: MemoryBudget,
}

impl HoleFiller<'_> {
    /// Curves with their heights, and what the clusters' fields give to the holes.
    fn close(&self, todo: &BTreeSet<u32>) -> Result<(Curves, Fields), RunError> {
        let options = |h: u32| {
            let settings = (self.settings_of)(h);
            let growth = if settings.method == MethodName::Field { GROWTH } else { 0.0 };
            LayeredOptions { growth, spacing_m: settings.spacing_m }
        };
        let mut curves = project(self.surveys, self.plan, &options);
        self.frames.round_curves(self.plan, &mut curves);
        let fields = solve_fields(self, todo, &mut curves)?;
        self.frames.round_curves(self.plan, &mut curves);
        Ok((curves, fields))
    }

    fn fill_layers(&self, todo: &BTreeSet<u32>, curves: &Curves) -> Result<Fills, RunError> {
        let mut fills = Fills::new();
        for layer in layers_of(self.plan, todo) {
            let is_here = |h: &u32| self.plan.holes[*h as usize].layer == layer;
            fills.extend(self.fill_all(&todo.iter().copied().filter(is_here).collect(), curves)?);
        }
        Ok(fills)
    }

    /// Smooths curves and fills again what they touch.
    fn smooth(&self, curves: &mut Curves, fills: &mut Fills) -> Result<(), RunError> {
        let moved = smooth_seams(self.plan, curves, fills);
        self.frames.round_curves(self.plan, curves);
        let again: BTreeSet<u32> = moved
            .iter()
            .flat_map(|&c| self.plan.curves[c as usize].holes.iter().copied())
            .filter(|h| matches!(fills.get(h), Some(Ok(_))))
            .collect();
        self.context.progress.start(StageKind::Seams, again.len() as u64, again.len() as u64);
        fills.extend(self.fill_all(&again, curves)?);
        Ok(())
    }

    /// Tries clusters that a field did not close with `layered`, and leaves those that their patches do not close.
    fn close_or_leave(
        &mut self,
        todo: &BTreeSet<u32>,
        curves: &Curves,
        fills: &mut Fills,
    ) -> Result<(), RunError> {
        let clusters: BTreeSet<u32> = todo.iter().map(|&h| self.plan.holes[h as usize].cluster).collect();
        let mut again = BTreeSet::new();
        for &c in &clusters {
            let holes = &self.plan.clusters[c as usize].holes;
            let raised = holes.iter().any(|h| self.fields.holes.contains_key(h));
            if let Some(reason) = self.problem(c, curves, fills).filter(|_| raised) {
                for h in holes {
                    self.fields.holes.remove(h);
                    self.fields.refused.insert(*h, reason.clone());
                }
                self.fields.water.remove(&c);
                again.extend(holes);
            }
        }
        fills.extend(self.fill_all(&again, curves)?);
        let judge = Watertight { surveys: self.surveys, plan: self.plan, curves };
        for c in clusters {
            if let Some(reason) = judge.defect(c, fills) {
                for &h in &self.plan.clusters[c as usize].holes {
                    fills.insert(h, Err(NotFilled { is_refusal: true, reason: reason.clone() }));
                }
            }
        }
        Ok(())
    }

    /// Why a cluster cannot be written as it is filled.
    fn problem(&self, cluster: u32, curves: &Curves, fills: &Fills) -> Option<String> {
        let holes = &self.plan.clusters[cluster as usize].holes;
        let own = holes.iter().find_map(|h| Some(fills.get(h)?.as_ref().err()?.reason.clone()));
        let judge = Watertight { surveys: self.surveys, plan: self.plan, curves };
        own.or_else(|| judge.defect(cluster, fills))
    }

    /// Fills holes in parallel; each is a job of its own, largest first.
    fn fill_all(&self, holes: &BTreeSet<u32>, curves: &Curves) -> Result<Fills, RunError> {
        let holes: Vec<u32> = holes.iter().copied().collect();
        let jobs: Vec<Job> = holes.iter().map(|&h| self.job(h)).collect();
        let fill = |k: usize| {
            let filled = self.fill_one(holes[k], curves);
            self.context.progress.advance(1);
            filled
        };
        let results = self.run(&jobs, &|k| self.name(holes[k]), &fill)?;
        let outcome = |result| match result {
            JobResult::Done(outcome) => outcome,
            JobResult::Panicked(message) => {
                Err(NotFilled { is_refusal: false, reason: format!("a fault of the program: {message}") })
            }
            JobResult::Stopped => Err(NotFilled { is_refusal: false, reason: "stopped".to_owned() }),
        };
        Ok(holes.into_iter().zip(results.into_iter().map(outcome)).collect())
    }

    /// Runs jobs under the memory limit; `name` tells what a job that does not fit works on.
    pub(crate) fn run<T: Send>(
        &self,
        jobs: &[Job],
        name: &dyn Fn(usize) -> String,
        work: &(dyn Fn(usize) -> T + Sync),
    ) -> Result<Vec<JobResult<T>>, RunError> {
        let context = self.context;
        let results = context
            .pool
            .run(jobs, &self.budget, &context.stop, work, |_| {})
            .map_err(|e| context.memory_too_small(&name(e.index), e.needed_bytes, e.limit_bytes))?;
        context.check_stop()?;
        Ok(results)
    }

    /// The cell of a hole, for messages.
    pub(crate) fn name(&self, hole: u32) -> String {
        self.plan.holes[hole as usize].cell.to_string()
    }

    /// Memory of one fill: 2.4 kB an unknown (measured on hollow cells of 1e5 triangles), the triangulation included.
    pub(crate) fn job(&self, hole: u32) -> Job {
        Job { key: u64::from(hole), bytes: ((2400.0 * self.unknowns(hole)) as u64).saturating_add(1 << 20) }
    }

    /// What stays of a patch: two triangles a vertex.
    fn patch_bytes(&self, hole: u32) -> u64 {
        (48.0 * self.unknowns(hole)) as u64
    }

    /// New vertices that a hole will need, from its area and its rim's density.
    fn unknowns(&self, hole: u32) -> f64 {
        let record = &self.plan.holes[hole as usize];
        let settings = (self.settings_of)(hole);
        let edge_m = settings.spacing_m.unwrap_or_else(|| self.plan.fit.edge_m.max(1e-3));
        let rim = f64::from(record.rim_vertices) + record.perimeter_m / edge_m;
        let inside = 1.2 * record.area_m2.max(0.0) / (edge_m * edge_m);
        let is_graded = settings.method == MethodName::Field && settings.spacing_m.is_none();
        // Where edges grow inwards a vertex of the rim brings two or three (measured), whatever the area.
        if is_graded { inside.min(4.0 * rim) + 4.0 * rim } else { inside + 4.0 * rim }
    }

    fn fill_one(&self, hole: u32, curves: &Curves) -> Result<FilledHole, NotFilled> {
        self.refuse_dry_islands(hole)?;
        let contour = self.contour(hole, curves)?;
        let filled = match self.fields.holes.get(&hole) {
            Some(field) => raise(&contour.contour, &field.triangulation, &field.new_m),
            None => fill(&contour.contour, &fill_params(self, hole), self.solver),
        };
        let mut filled = filled.map_err(|e| refused(&e))?;
        self.round(self.plan.holes[hole as usize].cell, &contour, &mut filled)?;
        add_strip(&contour, &mut filled.patch);
        Ok(FilledHole {
            rim: contour.contour.positions(),
            ring_lengths: contour.contour.rings().map(|r| r.vertices.len()).collect(),
            sources: contour.sources,
            patch: filled.patch,
            filler: filled.filler,
            quality: filled.quality,
            method: if self.fields.holes.contains_key(&hole) {
                MethodName::Field
            } else {
                MethodName::Layered
            },
            instead_of_field: self.instead_of_field(hole, filled.filler),
        })
    }

    /// Beneath islands only water passes: no other surface is known to lie below their rims.
    fn refuse_dry_islands(&self, hole: u32) -> Result<(), NotFilled> {
        match self.fields.refused.get(&hole) {
            Some(why) if !self.plan.holes[hole as usize].passed_under.is_empty() => Err(NotFilled {
                is_refusal: true,
                reason: format!("no water can pass beneath its islands: {why}; set water: (islands: join)"),
            }),
            _ => Ok(()),
        }
    }

    /// Why a hole seen from above has no field though it should; other fillers need none.
    fn instead_of_field(&self, hole: u32, filler: Filler) -> Option<String> {
        self.fields.refused.get(&hole).filter(|_| filler == Filler::Delaunay).cloned()
    }

    /// The contour of a hole, with closing points as its tile stores them.
    pub(crate) fn contour(&self, hole: u32, curves: &Curves) -> Result<CellContour, NotFilled> {
        let record = &self.plan.holes[hole as usize];
        let frame = self.frames.of(record.cell);
        let round = |p: DVec3| frame.map_or(p, |f| f.round(p));
        contour(self.surveys, self.plan, record, curves, &round)
            .map_err(|e| NotFilled { is_refusal: true, reason: e.to_string() })
    }

    /// Rounds new vertices to what the tile stores, and checks the patch as it will be read again.
    fn round(&self, cell: CellId, contour: &CellContour, filled: &mut Filled) -> Result<(), NotFilled> {
        let Some(frame) = self.frames.of(cell) else { return Ok(()) };
        for vertex in &mut filled.patch.vertices {
            *vertex = frame.round(*vertex);
        }
        let judged = filled.in_plan && filled.vertical.is_empty();
        let view = if judged { PlanView::Judged } else { PlanView::NotJudged };
        check_patch(&contour.contour, &filled.patch, view).map(|_| ()).map_err(|e| NotFilled {
            is_refusal: true,
            reason: format!("the tile's number type is too coarse for the patch: {e}"),
        })
    }
}

/// Adds the overlap strips that the cells of a border share.
fn add_strip(contour: &CellContour, patch: &mut Patch) {
    let (count, shift) = (contour.contour.len() as u32, patch.vertices.len() as u32);
    patch.vertices.extend(&contour.strip.vertices);
    let number = |v: u32| if v < count { v } else { v + shift };
    patch.triangles.extend(contour.strip.triangles.iter().map(|t| t.map(number)));
}

fn refused(error: &FillError) -> NotFilled {
    NotFilled { is_refusal: error.is_refusal(), reason: error.to_string() }
}

/// Settings of the fill of one hole. `layered` keeps the rim's density (growth 0), as the paper does.
pub(crate) fn fill_params(filler: &HoleFiller<'_>, hole: u32) -> FillParams {
    let settings = (filler.settings_of)(hole);
    let choice = if filler.plan.holes[hole as usize].class == HoleClass::Closed {
        match settings.closed {
            ClosedFiller::Auto => FillerChoice::Auto,
            ClosedFiller::Delaunay => FillerChoice::Delaunay,
            ClosedFiller::MinArea => FillerChoice::MinArea,
        }
    } else {
        match settings.open {
            OpenFiller::Auto => FillerChoice::Auto,
            OpenFiller::Delaunay => FillerChoice::Delaunay,
        }
    };
    FillParams {
        filler: choice,
        spacing_m: settings.spacing_m,
        growth: if settings.method == MethodName::Field { GROWTH } else { 0.0 },
        heights: HeightRule::Biharmonic,
        ..FillParams::default()
    }
}

/// Smooths the curves between holes of one layer (Wang et al. 2021, sec. 3.4; decisions 11): heights only, ends and
/// corners stay. Returns the curves that moved.
fn smooth_seams(plan: &Plan, curves: &mut Curves, fills: &Fills) -> Vec<u32> {
    let params = SmoothParams::default();
    let mut moved = Vec::new();
    for (c, curve) in plan.curves.iter().enumerate() {
        let CurveKind::Shared = curve.kind else { continue };
        let layers: BTreeSet<u32> = curve.holes.iter().map(|&h| plan.holes[h as usize].layer).collect();
        let patches: Vec<&FilledHole> =
            curve.holes.iter().filter_map(|h| fills.get(h)?.as_ref().ok()).collect();
        let is_raised = patches.iter().any(|p| p.method == MethodName::Field);
        if layers.len() != 1 || patches.len() != 2 || is_raised {
            continue;
        }
        let inner = &mut curves.curves[c].inner;
        let mut border: Vec<SeamVertex> =
            inner.iter().map(|p| SeamVertex { plan: p.truncate(), z: p.z, frozen: false }).collect();
        // The corners of a square that four cells share keep its height.
        let overrun = plan.fit.mode == BorderMode::Overrun;
        let is_square = |a: Anchor| overrun && matches!(a, Anchor::Corner(_));
        for (end, anchor) in [(0, curve.low), (border.len().saturating_sub(1), curve.high)] {
            if let Some(vertex) = border.get_mut(end) {
                vertex.frozen |= is_square(anchor);
            }
        }
        let reach = buffer_m(&border, &params);
        let near = |p: &&DVec3| {
            let side = curve.border.side;
            let along = side.along(p.truncate());
            (side.across(p.truncate()) - curve.line).abs() <= reach
                && along >= curve.low_m - reach
                && along <= curve.high_m + reach
        };
        let strips: Vec<DVec3> =
            patches.iter().flat_map(|f| f.patch.vertices.iter()).filter(near).copied().collect();
        match smooth(&mut border, &strips, reach, &params) {
            Ok(outcome) if outcome.rounds > 0 => {
                inner.iter_mut().zip(&border).for_each(|(p, v)| p.z = v.z);
                moved.push(c as u32);
            }
            Ok(_) => {}
            Err(error) => tracing::warn!("a border was not smoothed: {error}"),
        }
    }
    moved
}
