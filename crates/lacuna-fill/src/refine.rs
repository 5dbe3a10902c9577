//! New vertices at the density that the rim asks for.

use crate::FillError;
use crate::plan_mesh::{Place, PlanMesh};
use crate::predicates::{circumcentre, distance_to_segment};
use crate::topology::NONE;
use glam::DVec2;
use std::collections::VecDeque;

/// How edge lengths depend on the place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeRule {
    /// Growth per metre from the rim; 0: interpolate the rim's lengths.
    pub(crate) growth: f64,
    /// Largest length, metres.
    pub(crate) largest: f64,
}

/// A triangle is split while its circumradius exceeds this many times that of an equilateral triangle of wanted size.
const TOO_LARGE: f64 = 1.25;
/// A new vertex keeps this share of the wanted length from every boundary edge.
const CLEARANCE: f64 = 0.5;

/// Inserts vertices until no triangle is larger than its size allows, front by front from the boundary: each one on
/// the bisector of the shortest edge of a triangle that is too large and next to the boundary or to finished
/// triangles, at the height of an equilateral triangle but not beyond the circumcentre. Boundary edges stay whole;
/// triangles that only such a split could mend stay too.
///
/// A new vertex gets its size from the triangle that holds it: the least of `size + growth * distance` over the
/// corners, or for growth 0 the barycentric mean (Liepa 2003, sec. 5).
///
/// Source: the frontal rule is Rebay 1993 (efficient unstructured mesh generation, sec. 3), the size test Liepa's.
///
/// # Errors
/// [`FillError::CapReached`] when `limit` vertices have been added.
pub(crate) fn refine(mesh: &mut PlanMesh, rule: SizeRule, limit: usize) -> Result<(), FillError> {
    let most = mesh.points.len() + limit;
    let excess = (0..mesh.topology.triangle_count() as u32).map(|t| excess(mesh, rule, t)).collect();
    let mut sized = Sized { mesh, rule, excess };
    let capped = |_| FillError::CapReached { limit };
    advance(&mut sized, most, Front::Only).map_err(capped)?;
    // Where kept edges are longer than the size, the triangles at them never finish: go on without a front.
    advance(&mut sized, most, Front::Anywhere).map_err(capped)
}

/// A mesh in work, and how much too large each triangle is.
struct Sized<'a> {
    mesh: &'a mut PlanMesh,
    rule: SizeRule,
    /// Circumradius of each triangle over the largest one allowed there.
    excess: Vec<f64>,
}

impl Sized<'_> {
    /// Inserts a vertex; `touched` then holds the triangles that were made or changed, perhaps more than once.
    fn insert(&mut self, place: Place, p: DVec2, size: f64, touched: &mut Vec<u32>) {
        touched.clear();
        self.mesh.insert(place, p, size, touched);
        self.excess.resize(self.mesh.topology.triangle_count(), 0.0);
        for &t in touched.iter() {
            self.excess[t as usize] = excess(self.mesh, self.rule, t);
        }
    }
}

/// Which triangles may ask for a vertex: those at the front, or all.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Front {
    Only,
    Anywhere,
}

fn advance(sized: &mut Sized<'_>, most: usize, front: Front) -> Result<(), FillError> {
    let mut queue: VecDeque<u32> = (0..sized.mesh.topology.triangle_count() as u32).collect();
    let mut queued = vec![true; queue.len()];
    let mut touched = vec![];
    while let Some(t) = queue.pop_front() {
        queued[t as usize] = false;
        let Some((place, p, size)) = proposal(sized, t, front) else { continue };
        if sized.mesh.points.len() >= most {
            return Err(FillError::CapReached { limit: most });
        }
        sized.insert(place, p, size, &mut touched);
        let topology = &sized.mesh.topology;
        queued.resize(topology.triangle_count(), false);
        // A triangle that became small enough makes its neighbours part of the front.
        for i in 0..touched.len() {
            for h in 3 * touched[i]..3 * touched[i] + 3 {
                touched.extend(topology.twin(h).map(|twin| twin / 3));
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for &t in &touched {
            if !std::mem::replace(&mut queued[t as usize], true) {
                queue.push_back(t);
            }
        }
    }
    Ok(())
}

/// Where triangle `t` asks for a vertex, and the size there; `None` if it is small enough, not at the front, or no
/// place is free.
fn proposal(sized: &Sized<'_>, t: u32, front: Front) -> Option<(Place, DVec2, f64)> {
    let (mesh, rule, excess) = (&*sized.mesh, sized.rule, sized.excess[t as usize]);
    if excess <= 1.0 {
        return None;
    }
    let base = base_edge(sized, t, front)?;
    let apexes = [frontal_point(mesh, rule, t, base), Some(centroid(mesh, t)).filter(|_| excess > 1.6)];
    for p in apexes.into_iter().flatten() {
        let p = mesh.frame.snap(p);
        let place = mesh.locate(t, p);
        let holder = match place {
            Place::Inside(t) => t,
            Place::OnEdge(h) => h / 3,
            Place::Blocked => continue,
        };
        let size = size_at(mesh, rule, holder, p);
        if is_clear(mesh, holder, p, size) {
            return Some((place, p, size));
        }
    }
    None
}

fn centroid(mesh: &PlanMesh, t: u32) -> DVec2 {
    let [a, b, c] = mesh.corner_points(t);
    (a + b + c) / 3.0
}

/// Circumradius over the largest one allowed here.
fn excess(mesh: &PlanMesh, rule: SizeRule, t: u32) -> f64 {
    let [a, b, c] = mesh.corner_points(t);
    let radius = a.distance(b) * b.distance(c) * c.distance(a) / (2.0 * (b - a).perp_dot(c - a));
    radius / (size_at(mesh, rule, t, (a + b + c) / 3.0) * (TOO_LARGE / 3f64.sqrt()))
}

/// The wanted edge length at `p`, seen from the corners of triangle `t`.
fn size_at(mesh: &PlanMesh, rule: SizeRule, t: u32, p: DVec2) -> f64 {
    let corners = mesh.topology.corners(t);
    let size = |v: u32| mesh.sizes[v as usize];
    let wanted = if rule.growth > 0.0 {
        corners.iter().map(|&v| size(v) + rule.growth * p.distance(mesh.at(v))).fold(f64::INFINITY, f64::min)
    } else {
        let [a, b, c] = corners.map(|v| mesh.at(v));
        let whole = (b - a).perp_dot(c - a);
        let shares = [(c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)];
        let mean: f64 = corners.iter().zip(shares).map(|(&v, s)| size(v) * (s / whole).clamp(0.0, 1.0)).sum();
        mean.max(corners.iter().map(|&v| size(v)).fold(f64::INFINITY, f64::min))
    };
    wanted.min(rule.largest)
}

/// The shortest edge of `t` that has an acute angle opposite and, at the front, the boundary or a finished triangle
/// behind it.
fn base_edge(sized: &Sized<'_>, t: u32, front: Front) -> Option<u32> {
    let mesh = &*sized.mesh;
    let length = |h: u32| mesh.at(mesh.topology.start(h)).distance_squared(mesh.at(mesh.topology.end(h)));
    let is_front = |h: u32| {
        front == Front::Anywhere || mesh.topology.twin[h as usize] == NONE || {
            let behind = mesh.topology.twin[h as usize] / 3;
            sized.excess[behind as usize] <= 1.0
        }
    };
    let is_acute = |h: u32| {
        let apex = mesh.at(mesh.topology.apex(h));
        (mesh.at(mesh.topology.start(h)) - apex).dot(mesh.at(mesh.topology.end(h)) - apex) > 0.0
    };
    let mut edges = [3 * t, 3 * t + 1, 3 * t + 2];
    edges.sort_by(|&a, &b| length(a).total_cmp(&length(b)).then(a.cmp(&b)));
    edges.into_iter().find(|&h| is_front(h) && is_acute(h))
}

/// The point over edge `base` that makes a triangle of wanted size, on the way to the circumcentre of `t`.
fn frontal_point(mesh: &PlanMesh, rule: SizeRule, t: u32, base: u32) -> Option<DVec2> {
    let (a, b) = (mesh.at(mesh.topology.start(base)), mesh.at(mesh.topology.end(base)));
    let [p, q, r] = mesh.corner_points(t);
    let middle = a.midpoint(b);
    let centre = circumcentre(p, q, r);
    let (half, reach) = (0.5 * a.distance(b), centre.distance(middle));
    let mut size = size_at(mesh, rule, t, middle);
    if rule.growth > 0.0 {
        size = (size * (1.0 + 0.43 * rule.growth)).min(rule.largest);
    }
    let wanted = (size / 3f64.sqrt()).max(half);
    let radius = wanted.min((half * half + reach * reach) / (2.0 * reach));
    let height = (radius + (radius * radius - half * half).max(0.0).sqrt()).min(reach);
    let inward = (b - a).perp().try_normalize()?;
    (reach > 0.0 && height.is_finite()).then(|| middle + inward * height)
}

/// True if `p` is far enough from the corners and boundary edges of its triangle and the triangles around it.
fn is_clear(mesh: &PlanMesh, holder: u32, p: DVec2, size: f64) -> bool {
    let topology = &mesh.topology;
    let clear_of = |t: u32| {
        (3 * t..3 * t + 3).all(|h| {
            let (a, b) = (mesh.at(topology.start(h)), mesh.at(topology.end(h)));
            let near = CLEARANCE * size.min(a.distance(b));
            p.distance(a) > 0.55 * size && (topology.twin(h).is_some() || distance_to_segment(p, a, b) > near)
        })
    };
    clear_of(holder)
        && (3 * holder..3 * holder + 3).all(|h| topology.twin(h).is_none_or(|twin| clear_of(twin / 3)))
}
