//! The minimum-area filler: one ring in space, refined and faired.

use crate::adjust::{Freedom, adjust};
use crate::heights::{Rows, Smoothness, solve_component};
use crate::lift::vector_area;
use crate::ring_dp::{Ring3d, RingWeight, triangulate_ring};
use crate::space_mesh::SpaceMesh;
use crate::topology::Topology;
use crate::{FillError, FillParams, HeightRule};
use glam::DVec3;
use lacuna_mesh::{Clamp, Contour, EdgeKind, Patch, stiffness_in_space};
use lacuna_solve::Solver;

/// Largest share of a patch's area that may look against the ring's mean normal, and least share of it that the ring's
/// vector area must make up: a ring that winds both ways has no mean normal.
const FOLDED_SHARE: f64 = 0.2;
const LEAST_SHARE: f64 = 0.15;

/// Fills the outer ring in space: Liepa's dynamic programming without existing edges; refinement to the rim's density
/// in space; fairing of the new vertices (bi-Laplacian of x, y, z with the ring behind the rim as data; the Laplacian
/// if a triangle would turn over; Wang et al.'s adjustment, else the refined surface as it is, if it still would).
///
/// Source: Liepa 2003; Wang et al. 2021, sec. 3.4 and eq. 1-4.
///
/// # Errors
/// [`FillError::NoTriangulation`] if existing edges leave none or the surface folds back on itself,
/// [`FillError::CapReached`], [`FillError::Solve`].
pub(crate) fn min_area_patch(
    contour: &Contour,
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Patch, FillError> {
    let fixed = contour.len();
    let mut mesh = refined_ring(contour, params)?;
    let triangles = mesh.topology.triangles();
    if mesh.points.len() > fixed {
        mesh.points = faired(contour, &mesh.points, &triangles, params, solver)?;
    }
    check_folds(contour, &mesh.points, &triangles)?;
    Ok(Patch { vertices: mesh.points.split_off(fixed), triangles })
}

fn refined_ring<'a>(contour: &'a Contour, params: &FillParams) -> Result<SpaceMesh<'a>, FillError> {
    let points = contour.positions();
    let apexes: Vec<Option<DVec3>> = contour.outer.edges.iter().map(|e| e.apex).collect();
    let ring = Ring3d { points: &points, apexes: &apexes, forbidden: &contour.forbidden_edges };
    let triangles = triangulate_ring(&ring, RingWeight::AngleThenArea)
        .or_else(|| triangulate_ring(&ring, RingWeight::Area))
        .ok_or_else(|| folded("every triangulation of the rim uses an edge that the mesh already has"))?;
    let n = points.len();
    let largest = params.spacing_m.or(params.max_spacing_m).unwrap_or(f64::INFINITY);
    let edge = |i: usize| points[i % n].distance(points[(i + 1) % n]);
    let size = |i: usize| {
        let given = contour.outer.vertices[i].spacing_m;
        let mean = 0.5 * (edge(i) + edge(i + n - 1));
        if given > 0.0 && given.is_finite() { given } else { mean }
    };
    let sizes: Vec<f64> = (0..n).map(|i| size(i).clamp(1e-6, largest.max(1e-6))).collect();
    let mean_size = sizes.iter().sum::<f64>() / n as f64;
    let area: f64 = triangles
        .iter()
        .map(|t| t.map(|v| points[v as usize]))
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum();
    let limit = (10 * n + 1000).saturating_add((2.5 * area / (mean_size * mean_size)) as usize);
    let topology = Topology::new(&triangles);
    let forbidden = &contour.forbidden_edges;
    let mut mesh = SpaceMesh { points, sizes, topology, forbidden, growth: params.growth.max(0.0), largest };
    mesh.refine(limit.min(params.max_vertices))?;
    Ok(mesh)
}

fn faired(
    contour: &Contour,
    points: &[DVec3],
    triangles: &[[u32; 3]],
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Vec<DVec3>, FillError> {
    let fixed = contour.len();
    let biharmonic = Smoothness::Biharmonic { tension: 0.0 };
    let first = (params.heights == HeightRule::Biharmonic).then_some(biharmonic);
    for smoothness in first.into_iter().chain([Smoothness::Harmonic]) {
        let done = solve_positions(contour, points, triangles, smoothness, solver);
        match done {
            Ok(moved) if !turns_over(points, &moved, triangles) => return Ok(moved),
            Ok(_) | Err(lacuna_solve::SolveError::NotPositiveDefinite { .. }) => {}
            Err(e) => return Err(e.into()),
        }
    }
    let mut adjusted = points.to_vec();
    adjust(&mut adjusted, triangles, fixed, Freedom::Position);
    Ok(if turns_over(points, &adjusted, triangles) { points.to_vec() } else { adjusted })
}

/// Solves x, y and z of the new vertices with weights from the patch as it is.
fn solve_positions(
    contour: &Contour,
    points: &[DVec3],
    triangles: &[[u32; 3]],
    smoothness: Smoothness,
    solver: &dyn Solver,
) -> Result<Vec<DVec3>, lacuna_solve::SolveError> {
    let (n, count) = (contour.len(), points.len());
    let origin = points[0];
    let mut all: Vec<DVec3> = points.iter().map(|p| *p - origin).collect();
    all.extend(contour.support.vertices.iter().map(|p| *p - origin));
    let mut joined = triangles.to_vec();
    let renumber = |v: u32| if (v as usize) < n { v } else { v + (count - n) as u32 };
    joined.extend(contour.support.triangles.iter().map(|t| t.map(renumber)));
    let mut is_row = lacuna_mesh::closed_fans(all.len(), &joined);
    for (i, edge) in contour.outer.edges.iter().enumerate().filter(|(_, e)| e.kind == EdgeKind::Border) {
        debug_assert!(edge.apex.is_none());
        is_row[i] = false;
        is_row[(i + 1) % n] = false;
    }
    is_row[count..].fill(false);
    let rows = Rows::new(&stiffness_in_space(&all, &joined, Clamp::IN_SPACE));
    let mut moved = points.to_vec();
    for axis in 0..3 {
        let known: Vec<Option<f64>> = all
            .iter()
            .enumerate()
            .map(|(v, p)| (v < n || v >= count).then_some(p.to_array()[axis]))
            .collect();
        let solved = solve_component(&rows, &is_row, &known, smoothness, solver)?;
        for (v, x) in (n..count).zip(solved) {
            moved[v][axis] = x + origin[axis];
        }
    }
    Ok(moved)
}

fn turns_over(before: &[DVec3], after: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let normal = |points: &[DVec3], t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        (b - a).cross(c - a)
    };
    triangles.iter().any(|t| normal(before, t).dot(normal(after, t)) <= 0.0)
}

/// Refuses a surface of which much looks against the ring's own mean normal.
fn check_folds(contour: &Contour, points: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), FillError> {
    let ring: Vec<DVec3> = contour.outer.vertices.iter().map(|v| v.position).collect();
    let mean = vector_area(&ring);
    let (mut against, mut total) = (0.0, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|v| points[v as usize]);
        let normal = (b - a).cross(c - a);
        total += normal.length();
        if normal.dot(mean) < 0.0 {
            against += normal.length();
        }
    }
    if against <= FOLDED_SHARE * total && mean.length() >= LEAST_SHARE * total {
        return Ok(());
    }
    Err(folded("the surface over the rim folds back on itself"))
}

fn folded(what: &str) -> FillError {
    FillError::NoTriangulation { what: what.to_owned() }
}
