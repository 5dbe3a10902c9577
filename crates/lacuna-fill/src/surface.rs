//! The surface over a triangulated contour: rows, overshoot guard, heights.

use crate::heights::{HeightProblem, Smoothness, solve_heights};
use crate::plan_mesh::PlanMesh;
use crate::weld::Welded;
use crate::{FillError, FillParams, HeightRule};
use glam::{DVec2, DVec3};
use lacuna_mesh::{Contour, EdgeKind, closed_fans};
use lacuna_solve::Solver;

/// Triangles behind the rim steeper than this (z of the unit normal) or with longer edges (times the local spacing)
/// must not steer slopes: walls and spikes.
const STEEP: f64 = 0.15;
const SPIKE: f64 = 8.0;
/// How often tension is raised fourfold before the surface becomes a soap film.
const TENSION_STEPS: i32 = 6;

/// Heights (along the frame's third axis) of all of `mesh`'s points.
///
/// The contour gives the fixed heights and the ring triangles behind the rim. A rim vertex has a row in the bi-Laplacian
/// iff patch and ring triangles close round it and none of the ring triangles is a wall or a spike; a vertex with a
/// border edge has none (natural condition there). If heights leave the range of the data by more than
/// `params.overshoot` of it, tension is added, then the surface is harmonic.
pub(crate) fn patch_heights(
    rim: &Welded<'_>,
    mesh: &PlanMesh,
    pockets: &[[u32; 3]],
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Vec<f64>, FillError> {
    let field = Field::new(rim, mesh, pockets);
    let problem = HeightProblem {
        points: &field.points,
        triangles: &field.triangles,
        fixed: &field.fixed,
        rows: &field.rows,
    };
    let mut heights = solve_guarded(&problem, mesh, params, solver)?;
    heights.truncate(mesh.points.len());
    Ok(heights)
}

fn solve_guarded(
    problem: &HeightProblem<'_>,
    mesh: &PlanMesh,
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Vec<f64>, FillError> {
    if params.heights == HeightRule::Biharmonic {
        let known = problem.fixed.iter().flatten();
        let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &z| (l.min(z), h.max(z)));
        let rounding = 1e-9 * (high - low + low.abs().max(high.abs()));
        let slack = params.overshoot * (high - low) + rounding;
        let area: f64 = (0..mesh.topology.triangle_count() as u32)
            .map(|t| mesh.corner_points(t))
            .map(|[a, b, c]| 0.5 * (b - a).perp_dot(c - a))
            .sum();
        for step in 0..=TENSION_STEPS {
            // 1 / R^2 of a disk of the hole's area, then four times as much, and so on.
            let tension = if step == 0 { 0.0 } else { 4f64.powi(step - 1) * std::f64::consts::PI / area };
            match solve_heights(problem, Smoothness::Biharmonic { tension }, solver) {
                Ok(heights) if heights.iter().all(|z| *z >= low - slack && *z <= high + slack) => {
                    return Ok(heights);
                }
                Ok(_) | Err(lacuna_solve::SolveError::NotPositiveDefinite { .. }) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }
    Ok(solve_heights(problem, Smoothness::Harmonic, solver)?)
}

/// Patch and surroundings as one height problem.
struct Field {
    points: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    fixed: Vec<Option<f64>>,
    rows: Vec<bool>,
}

impl Field {
    /// Points: those of the mesh (contour first), then the support's.
    fn new(rim: &Welded<'_>, mesh: &PlanMesh, pockets: &[[u32; 3]]) -> Self {
        let contour = &rim.contour;
        let n = contour.len() as u32;
        let shift = mesh.points.len() as u32 - n;
        let frame = mesh.frame;
        let mut points = mesh.points.clone();
        let mut fixed: Vec<Option<f64>> =
            contour.positions().into_iter().map(|p| Some(frame.local(p).z)).collect();
        fixed.resize(points.len(), None);
        let support: Vec<DVec3> = contour.support.vertices.iter().map(|&p| frame.local(p)).collect();
        points.extend(support.iter().map(|p| p.truncate()));
        fixed.extend(support.iter().map(|p| Some(p.z)));
        let mut triangles = mesh.topology.triangles();
        let patch = triangles.len();
        let renumber = |v: u32| if v < n { v } else { v + shift };
        triangles.extend(contour.support.triangles.iter().map(|t| t.map(renumber)));
        let mut rows = closed_at_rim(n, points.len(), &triangles);
        let place = |v: u32| points[v as usize].extend(fixed[v as usize].unwrap_or(0.0));
        for triangle in &triangles[patch..] {
            let spacing = triangle.iter().filter_map(|&v| mesh.sizes.get(v as usize)).copied();
            if !is_calm(triangle.map(place), spacing.fold(0.0, f64::max)) {
                triangle.iter().for_each(|&v| rows[v as usize] = false);
            }
        }
        pockets.iter().flatten().for_each(|&v| rows[v as usize] = false);
        for v in border_vertices(contour) {
            rows[rim.first(v) as usize] = false;
        }
        rows[mesh.points.len()..].fill(false);
        Self { points, triangles, fixed, rows }
    }
}

/// As [`closed_fans`], for patch triangles whose new vertices all lie inside: only the first `n` vertices are judged.
fn closed_at_rim(n: u32, count: usize, triangles: &[[u32; 3]]) -> Vec<bool> {
    let at_rim: Vec<[u32; 3]> = triangles.iter().filter(|t| t.iter().any(|&v| v < n)).copied().collect();
    let mut closed = closed_fans(count, &at_rim);
    closed[n as usize..].fill(true);
    closed
}

/// True if a ring triangle is neither a wall, nor turned over, nor a spike.
fn is_calm([a, b, c]: [DVec3; 3], spacing: f64) -> bool {
    let normal = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    normal.z > STEEP * normal.length() && (spacing == 0.0 || longest <= SPIKE * spacing)
}

fn border_vertices(contour: &Contour) -> Vec<u32> {
    let (mut found, mut first) = (vec![], 0u32);
    for ring in contour.rings() {
        let n = ring.vertices.len() as u32;
        for (edge, i) in ring.edges.iter().zip(0u32..) {
            if edge.kind == EdgeKind::Border {
                found.extend([first + i, first + (i + 1) % n]);
            }
        }
        first += n;
    }
    found
}
