//! Method `aggregate`, the baseline: all cells merged in memory, and the closed holes of that one mesh filled.

mod fill;
mod memory;
mod merge;
mod share;

use super::RunError;
use super::assemble::border_mode;
use super::context::{Context, StageKind, Stages};
use super::frames::Frames;
use super::scan::Scanned;
use super::solve::{Fills, NotFilled, Solved};
use crate::config::FillSettings;
use lacuna_hole::{BorderMode, Plan};
use lacuna_schedule::{Job, JobResult};
use lacuna_tile::Scene;
use merge::{Merged, merge};
use std::collections::{BTreeMap, BTreeSet};

/// What the baseline reads.
pub(super) struct AggregateInput<'a> {
    pub(super) scene: &'a Scene,
    pub(super) scanned: &'a Scanned,
    pub(super) plan: &'a Plan,
    /// How each tile stores positions.
    pub(super) frames: &'a Frames,
    /// Holes in work, by number.
    pub(super) todo: &'a BTreeSet<u32>,
    pub(super) settings_of: &'a (dyn Fn(u32) -> FillSettings + Sync),
}

/// Fills the holes of `todo` on the merged mesh.
///
/// Steps: (1) all tiles are read into one mesh, where places with the same position bits are one; (2) its closed holes
/// are found; each belongs to the cluster whose rims it shares; (3) each is filled with the minimum-area triangulation,
/// refined to the rim's density and faired; (4) every triangle goes to the cell that holds its centroid. What is open to the
/// outside of the merged mesh is left, with that reason. Memory grows with the whole scene: that is what is compared.
///
/// Source: Han & Shen's way as Wang et al. 2021, sec. 4, describe it for their comparison.
///
/// # Errors
/// Exit 2 where tiles share no border vertices, exit 5 before any tile is read if the limit does not hold the merged mesh
/// or the largest hole.
pub(super) fn aggregate(
    input: &AggregateInput<'_>,
    context: &Context<'_>,
    stages: &mut Stages,
) -> Result<Solved, RunError> {
    refuse_unshared_borders(input.plan)?;
    if input.todo.is_empty() {
        return Ok(Solved::default());
    }
    memory::check(input, context)?;
    let merged = stages.measure("merge", || merge(input, context))?;
    let fills = stages.measure("fill", || fill_clusters(input, &merged, context))?;
    Ok(Solved { fills, ..Solved::default() })
}

/// Tiles that share no vertices can't be merged by position.
fn refuse_unshared_borders(plan: &Plan) -> Result<(), RunError> {
    if plan.fit.mode == BorderMode::Exact {
        return Ok(());
    }
    Err(RunError::usage(format!(
        "--method aggregate merges tiles by the vertices that they share on their borders, and these share none (borders: \
         {}); take field or layered",
        border_mode(plan.fit.mode)
    )))
}

/// A cluster in work: its number, its holes in the plan, and its holes in the merged mesh.
struct Work {
    cluster: u32,
    holes: Vec<u32>,
    merged_holes: Vec<u32>,
}

fn fill_clusters(
    input: &AggregateInput<'_>,
    merged: &Merged,
    context: &Context<'_>,
) -> Result<Fills, RunError> {
    let work = work(input, merged);
    context.progress.start(StageKind::Fill, work.len() as u64, input.todo.len() as u64);
    let jobs: Vec<Job> = work
        .iter()
        .map(|w| Job { key: u64::from(w.cluster), bytes: memory::fill_bytes(input, &w.holes) })
        .collect();
    let fill = |k: usize| {
        let filled = fill::fill_cluster(input, merged, &work[k]);
        context.progress.advance(1);
        filled
    };
    let budget = context.budget_beside(0);
    let results = context
        .pool
        .run(&jobs, &budget, &context.stop, fill, |_| {})
        .map_err(|e| context.memory_too_small(memory::LARGEST_HOLE, e.needed_bytes, e.limit_bytes))?;
    context.check_stop()?;
    let mut fills = Fills::new();
    for (work, result) in work.iter().zip(results) {
        let outcome = match result {
            JobResult::Done(outcome) => outcome,
            JobResult::Panicked(message) => Err(failure(format!("a fault of the program: {message}"))),
            JobResult::Stopped => Err(failure("stopped".to_owned())),
        };
        match outcome {
            Ok(filled) => fills.extend(filled.into_iter().map(|(h, f)| (h, Ok(f)))),
            Err(problem) => fills.extend(work.holes.iter().map(|&h| (h, Err(problem.clone())))),
        }
    }
    Ok(fills)
}

fn failure(reason: String) -> NotFilled {
    NotFilled { is_refusal: false, reason }
}

/// The clusters of `todo`, each with the closed holes of the merged mesh that share its rims.
fn work(input: &AggregateInput<'_>, merged: &Merged) -> Vec<Work> {
    let mut found = merged.holes_of_clusters(input);
    let mut clusters: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &h in input.todo {
        clusters.entry(input.plan.holes[h as usize].cluster).or_default().push(h);
    }
    clusters
        .into_iter()
        .map(|(cluster, holes)| Work {
            cluster,
            holes,
            merged_holes: found.remove(&cluster).unwrap_or_default(),
        })
        .collect()
}
