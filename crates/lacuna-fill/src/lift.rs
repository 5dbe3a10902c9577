//! The Delaunay filler in a frame: triangulate, refine, smooth, solve heights, write back.

use crate::delaunay::triangulate;
use crate::forbidden::split_forbidden;
use crate::frame::Frame;
use crate::plan::{PlanRings, Pockets, plan_rings};
use crate::plan_mesh::PlanMesh;
use crate::refine::{SizeRule, refine};
use crate::smooth::smooth;
use crate::surface::patch_heights;
use crate::weld::Welded;
use crate::{FillError, FillParams};
use glam::{DVec2, DVec3};
use lacuna_mesh::Patch;
use lacuna_solve::Solver;

/// Rounds of smoothing after each of the two refinements.
const ROUNDS: [usize; 2] = [3, 2];
/// Growth used when a spacing is given without one: from the rim's density to the spacing.
const GROWTH_TO_SPACING: f64 = 0.3;

/// A patch over a frame's plane, and its pocket triangles.
pub(crate) struct Lifted {
    pub(crate) patch: Patch,
    pub(crate) vertical: Vec<u32>,
}

/// Fills a contour whose rings are simple in `frame` (after pockets are cut, if they may be).
///
/// Steps: rings; constrained Delaunay; refinement to the rim's density and smoothing in the plane, twice; forbidden
/// edges; heights; new vertices back to the scene's coordinates.
pub(crate) fn fill_in_frame(
    rim: &Welded<'_>,
    frame: Frame,
    pockets: Pockets,
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Lifted, FillError> {
    let (mesh, plan) = mesh_in_frame(rim, frame, pockets, params)?;
    let heights = patch_heights(rim, &mesh, &plan.pockets, params, solver)?;
    let n = mesh.fixed;
    let new = mesh.points[n..].iter().zip(&heights[n..]);
    let vertices = new.map(|(p, &z)| frame.world(p.extend(z))).collect();
    let (triangles, vertical) = with_pockets(mesh.topology.triangles(), &plan.pockets);
    Ok(Lifted { patch: Patch { vertices, triangles }, vertical })
}

/// Rings, Delaunay, refinement and smoothing in the plane, without heights.
pub(crate) fn mesh_in_frame(
    rim: &Welded<'_>,
    frame: Frame,
    pockets: Pockets,
    params: &FillParams,
) -> Result<(PlanMesh, PlanRings), FillError> {
    let positions = rim.contour.positions();
    let points: Vec<DVec2> = positions.iter().map(|&p| frame.local(p).truncate()).collect();
    let plan = plan_rings(rim, &points, &positions, pockets)?;
    let mesh = triangulate_and_refine(rim, frame, points, &plan, params)?;
    Ok((mesh, plan))
}

/// All triangles of a patch, pockets last, and the indices of the pockets.
pub(crate) fn with_pockets(mut triangles: Vec<[u32; 3]>, pockets: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let vertical = (triangles.len() as u32..).take(pockets.len()).collect();
    triangles.extend(pockets);
    (triangles, vertical)
}

fn triangulate_and_refine(
    rim: &Welded<'_>,
    frame: Frame,
    points: Vec<DVec2>,
    plan: &PlanRings,
    params: &FillParams,
) -> Result<PlanMesh, FillError> {
    let topology = triangulate(&points, &plan.rings)?;
    let fixed = points.len();
    let (sizes, median) = wanted_sizes(rim, &points, params);
    let mut mesh = PlanMesh { frame, points, sizes, fixed, topology };
    let rule = size_rule(params, median);
    let limit = vertex_limit(&mesh, params, median);
    for rounds in ROUNDS {
        let left = limit.saturating_sub(mesh.points.len() - fixed);
        refine(&mut mesh, rule, left)?;
        split_forbidden(&mut mesh, &rim.contour.forbidden_edges)?;
        mesh.restore_delaunay();
        smooth(&mut mesh, rounds);
    }
    split_forbidden(&mut mesh, &rim.contour.forbidden_edges)?;
    Ok(mesh)
}

fn size_rule(params: &FillParams, median: f64) -> SizeRule {
    match params.spacing_m {
        Some(spacing) => {
            let growth = if params.growth > 0.0 { params.growth } else { GROWTH_TO_SPACING };
            SizeRule { growth, largest: spacing }
        }
        None => SizeRule {
            growth: params.growth.max(0.0),
            largest: params.max_spacing_m.unwrap_or(f64::INFINITY).min(16.0 * median),
        },
    }
}

/// Wanted length at each contour vertex (its own, or the mean of its edges if that is missing; the least one of its
/// place), and the median edge.
fn wanted_sizes(rim: &Welded<'_>, points: &[DVec2], params: &FillParams) -> (Vec<f64>, f64) {
    let (mut sizes, mut lengths) = (vec![], vec![]);
    for ring in rim.contour.rings() {
        let (first, n) = (sizes.len(), ring.vertices.len());
        let length = |i: usize| points[first + i % n].distance(points[first + (i + 1) % n]);
        for (i, vertex) in ring.vertices.iter().enumerate() {
            let given = vertex.spacing_m;
            let mean = 0.5 * (length(i) + length(i + n - 1));
            sizes.push(if given > 0.0 && given.is_finite() { given } else { mean });
            lengths.push(length(i));
        }
    }
    lengths.sort_by(f64::total_cmp);
    let median = lengths[lengths.len() / 2].max(1e-6);
    let largest = params.spacing_m.unwrap_or(f64::INFINITY);
    sizes.iter_mut().for_each(|s| *s = s.min(largest).max(1e-3 * median));
    for (v, &first) in rim.first_at_place.iter().enumerate() {
        sizes[first as usize] = sizes[first as usize].min(sizes[v]);
    }
    (sizes, median)
}

/// 10 n + 1000 + 2.5 area / spacing^2, and not above what the caller allows.
fn vertex_limit(mesh: &PlanMesh, params: &FillParams, median: f64) -> usize {
    let area: f64 = (0..mesh.topology.triangle_count() as u32)
        .map(|t| mesh.corner_points(t))
        .map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a))
        .sum();
    let spacing = params.spacing_m.unwrap_or(median);
    let by_area = 2.5 * area / (spacing * spacing);
    (10 * mesh.fixed + 1000).saturating_add(by_area as usize).min(params.max_vertices)
}

/// Sum of cross products round the outer ring: twice its vector area (Newell).
pub(crate) fn vector_area(ring: &[DVec3]) -> DVec3 {
    let Some(&first) = ring.first() else { return DVec3::ZERO };
    ring.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum()
}
