//! Smoothing of new vertices in the plane.

use crate::plan_mesh::PlanMesh;
use crate::predicates::{circumcentre, shape};
use crate::topology::next;
use glam::DVec2;
use lacuna_mesh::side_of_line;

/// Moves every free vertex to improve the triangles round it, `rounds` times, with Delaunay flips after each round.
/// Contour vertices stay. A vertex is offered the density-weighted mean of its triangles' circumcentres (optimal
/// Delaunay triangulation), then the mean of its neighbours, then half the way there; it takes the first place where
/// all its triangles stay counter-clockwise and the worst one gets no worse, or stays good while the mean improves.
///
/// Source: Chen & Xu 2004 (optimal Delaunay triangulations); guard after Freitag & Ollivier-Gooch 1997.
///
/// The mesh must be constrained Delaunay. A vertex none of whose triangles changed since it last stayed would stay again
/// and is not tried.
pub(crate) fn smooth(mesh: &mut PlanMesh, rounds: usize) {
    let mut has_changed = vec![true; mesh.points.len()];
    let mut ring = vec![];
    for _ in 0..rounds {
        let leaving = mesh.topology.leaving(mesh.points.len());
        let mut moved = vec![false; mesh.points.len()];
        for v in mesh.fixed..mesh.points.len() {
            if !std::mem::take(&mut has_changed[v]) {
                continue;
            }
            ring.clear();
            for h in mesh.topology.star(leaving[v]) {
                let n = next(h);
                ring.push([mesh.topology.start(n), mesh.topology.end(n)]);
            }
            moved[v] = improve(mesh, v, &ring);
            if moved[v] {
                has_changed[v] = true;
                ring.iter().for_each(|edge| has_changed[edge[0] as usize] = true);
            }
        }
        mesh.restore_delaunay_near(&moved, |corners| {
            corners.iter().for_each(|&v| has_changed[v as usize] = true);
        });
    }
}

/// The worst q a vertex may accept in exchange for a better mean.
const GOOD: f64 = 0.7;
/// A vertex whose worst triangle has this q is left alone: most are so after the frontal insertion.
const EXCELLENT: f64 = 0.92;

/// Moves a vertex to a better place; false if it stays.
fn improve(mesh: &mut PlanMesh, v: usize, ring: &[[u32; 2]]) -> bool {
    let here = mesh.points[v];
    let Some(before) = judge(mesh, here, ring) else { return false };
    if before.0 >= EXCELLENT {
        return false;
    }
    let mean = neighbour_mean(mesh, ring);
    for candidate in [optimal_place(mesh, here, ring), mean, here.midpoint(mean)] {
        let place = mesh.frame.snap(candidate);
        let Some(after) = judge(mesh, place, ring) else { continue };
        let better = after.1 > before.1 && after.0 >= before.0.min(GOOD);
        if better {
            mesh.points[v] = place;
            return true;
        }
    }
    false
}

/// Worst and mean q of the triangles round a vertex at `p`; `None` if one is not counter-clockwise.
fn judge(mesh: &PlanMesh, p: DVec2, ring: &[[u32; 2]]) -> Option<(f64, f64)> {
    let (mut worst, mut sum) = (f64::INFINITY, 0.0);
    for edge in ring {
        let [a, b] = edge.map(|w| mesh.at(w));
        if side_of_line(p, a, b) <= 0.0 {
            return None;
        }
        let q = shape(p.distance(a), a.distance(b), b.distance(p));
        worst = q.min(worst);
        sum += q;
    }
    Some((worst, sum / ring.len() as f64))
}

fn neighbour_mean(mesh: &PlanMesh, ring: &[[u32; 2]]) -> DVec2 {
    ring.iter().map(|edge| mesh.at(edge[0])).sum::<DVec2>() / ring.len() as f64
}

/// Mean of the triangles' circumcentres, weighted by area over wanted size to the fourth.
fn optimal_place(mesh: &PlanMesh, p: DVec2, ring: &[[u32; 2]]) -> DVec2 {
    let (mut sum, mut total) = (DVec2::ZERO, 0.0);
    for edge in ring {
        let [a, b] = edge.map(|w| mesh.at(w));
        let size = mesh.sizes[edge[0] as usize] + mesh.sizes[edge[1] as usize];
        let weight = (a - p).perp_dot(b - p) / (size * size * size * size);
        sum += (circumcentre(p, a, b) - p) * weight;
        total += weight;
    }
    p + sum / total
}
