//! All tiles in one mesh, and the holes of that.

use super::memory::{counts, merge_bytes, parts};
use super::{AggregateInput, NotFilled};
use crate::pipeline::RunError;
use crate::pipeline::context::Context;
use crate::pipeline::scan::{Part, append_mesh};
use glam::DVec3;
use lacuna_grid::{Area, AreaLimit, CellId, Grid};
use lacuna_hole::{ClusterRule, Hole, HoleClass, Piece, Plan, PlanOptions, Span, Surveys, plan, survey};
use lacuna_mesh::{TriMesh, VertexId, position_bits};
use lacuna_schedule::{Job, JobResult};
use lacuna_tile::read_tile;
use std::collections::{BTreeMap, BTreeSet};

/// What stays of the merged mesh: the survey of its one cell, and its holes.
pub(super) struct Merged {
    pub(super) surveys: Surveys,
    pub(super) plan: Plan,
    /// First vertex of every cell's tile in the merged numbering, ascending.
    first_vertices: Vec<(u32, CellId)>,
}

/// The cell of the merged mesh.
const WHOLE: CellId = CellId { j: 0, i: 0 };

/// Reads all tiles into one mesh, finds its boundary (places with equal position bits are one there), and plans the
/// whole scene as one cell. The mesh is dropped.
///
/// # Errors
/// A tile that can't be read any more or has changed, more vertices than 32 bits number, a stop.
pub(super) fn merge(input: &AggregateInput<'_>, context: &Context<'_>) -> Result<Merged, RunError> {
    let job = Job { key: 0, bytes: merge_bytes(input) };
    let budget = context.budget_beside(0);
    let results = context
        .pool
        .run(&[job], &budget, &context.stop, |_| merge_all(input, context), |_| {})
        .map_err(|e| context.memory_too_small("the merged mesh", e.needed_bytes, e.limit_bytes))?;
    context.check_stop()?;
    match results.into_iter().next() {
        Some(JobResult::Done(merged)) => merged,
        Some(JobResult::Panicked(message)) => {
            Err(RunError::failed(format!("a fault of the program while merging: {message}")))
        }
        Some(JobResult::Stopped) | None => Err(RunError::failed("the merge was stopped")),
    }
}

fn merge_all(input: &AggregateInput<'_>, context: &Context<'_>) -> Result<Merged, RunError> {
    let (vertices, triangles) =
        parts(input).map(|p| counts(input, p)).fold((0, 0), |(v, t), (a, b)| (v + a, t + b));
    if u32::try_from(vertices).is_err() {
        return Err(RunError::failed(format!(
            "{vertices} vertices are more than one mesh can number; take field or layered"
        )));
    }
    let mut mesh = TriMesh::default();
    mesh.positions.reserve_exact(vertices as usize);
    mesh.triangles.reserve_exact(triangles as usize);
    let mut first_vertices = Vec::new();
    for (&cell, tile) in &input.scanned.tiles {
        first_vertices.push((mesh.positions.len() as u32, cell));
        for part in &tile.parts {
            read_part(input, part, context, &mut mesh)?;
        }
    }
    let surveys = Surveys::from([(WHOLE, survey(WHOLE, &mesh))]);
    drop(mesh);
    lacuna_system::trim();
    let plan = plan_whole(input, &surveys);
    Ok(Merged { surveys, plan, first_vertices })
}

fn read_part(
    input: &AggregateInput<'_>,
    part: &Part,
    context: &Context<'_>,
    mesh: &mut TriMesh,
) -> Result<(), RunError> {
    context.check_stop()?;
    let entry = &input.scene.tiles[part.tile];
    let read = read_tile(&input.scene.path(entry), entry.format, &context.read_options)
        .map_err(|e| RunError::input_output(e.message_below(&input.scene.root)))?;
    if read.hash != part.hash {
        return Err(RunError::failed(format!(
            "{}: the file changed while the run was under way; run again",
            entry.relative.escape_debug()
        )));
    }
    append_mesh(mesh, read);
    Ok(())
}

/// The plan of the whole scene as one cell, as large as the box of all vertices.
fn plan_whole(input: &AggregateInput<'_>, surveys: &Surveys) -> Plan {
    let bounds = &input.scanned.bounds;
    let (low, high) = (bounds.min.truncate(), bounds.max.truncate());
    plan(
        surveys,
        &PlanOptions {
            grid: Grid { origin: low, cell_size_m: (high - low).max_element().max(1e-3) },
            area: Area { cells: [WHOLE].into(), limit: AreaLimit::Box(low, high) },
            fit: input.plan.fit,
            rule: ClusterRule::Interval,
            unreadable: BTreeSet::new(),
        },
    )
}

impl Merged {
    /// The closed holes of the merged mesh, each under the cluster with most of its rim vertices (the lowest of equal ones).
    pub(super) fn holes_of_clusters(&self, input: &AggregateInput<'_>) -> BTreeMap<u32, Vec<u32>> {
        let mut owner: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        for hole in &input.plan.holes {
            for p in rim_places(hole, &input.scanned.surveys) {
                owner.entry(position_bits(p)).or_insert(hole.cluster);
            }
        }
        let mut found: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (h, hole) in (0..).zip(&self.plan.holes).filter(|(_, h)| h.class == HoleClass::Closed) {
            let mut votes: BTreeMap<u32, u32> = BTreeMap::new();
            for p in rim_places(hole, &self.surveys) {
                if let Some(&cluster) = owner.get(&position_bits(p)) {
                    *votes.entry(cluster).or_default() += 1;
                }
            }
            let most = votes.into_iter().max_by_key(|&(cluster, n)| (n, std::cmp::Reverse(cluster)));
            if let Some((cluster, _)) = most {
                found.entry(cluster).or_default().push(h);
            }
        }
        found
    }

    /// The cell that a vertex of the merged mesh comes from, and its number there.
    pub(super) fn home(&self, vertex: VertexId) -> Result<(CellId, VertexId), NotFilled> {
        let k = self.first_vertices.partition_point(|(first, _)| *first <= vertex.0);
        let home = k.checked_sub(1).and_then(|k| self.first_vertices.get(k));
        home.map(|&(first, cell)| (cell, VertexId(vertex.0 - first)))
            .ok_or_else(|| super::failure("a vertex of the merged mesh has no tile".to_owned()))
    }
}

/// Places of the original vertices round a hole, those that it adopts from neighbouring tiles included.
fn rim_places<'a>(hole: &'a Hole, surveys: &'a Surveys) -> impl Iterator<Item = DVec3> + 'a {
    let own = surveys.get(&hole.cell);
    let rims = own.into_iter().flat_map(|s| hole.rim_edges(s).map(|e| s.from(e)));
    let spans = hole.outer.iter().flat_map(|piece| match piece {
        Piece::Side { spans, .. } => spans.as_slice(),
        _ => &[],
    });
    let adopted = spans.flat_map(|span| match span {
        Span::Adopted { neighbour, edges } => {
            let survey = surveys.get(neighbour);
            survey.map_or_else(Vec::new, |s| edges.iter().map(|&e| s.from(e)).collect())
        }
        Span::Curve(_) => Vec::new(),
    });
    rims.chain(adopted)
}
