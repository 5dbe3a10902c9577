//! Liepa's refinement of a triangulation in space.

use crate::FillError;
use crate::topology::{Topology, next, prev};
use glam::DVec3;

/// A triangulation in space whose boundary never changes.
pub(crate) struct SpaceMesh<'a> {
    pub(crate) points: Vec<DVec3>,
    /// Wanted edge length at each point (Liepa's sigma), metres.
    pub(crate) sizes: Vec<f64>,
    pub(crate) topology: Topology,
    /// Pairs that must not be joined, sorted.
    pub(crate) forbidden: &'a [[u32; 2]],
    /// By how much sigma grows with each metre (0: Liepa's own rule).
    pub(crate) growth: f64,
    /// Largest sigma, metres.
    pub(crate) largest: f64,
}

/// Liepa's density factor.
const DENSITY: f64 = std::f64::consts::SQRT_2;
/// Most rounds of splitting, and sweeps of relaxing in each.
const ROUNDS: usize = 12;
const SWEEPS: usize = 20;

impl SpaceMesh<'_> {
    /// Splits triangles at their centroid c while, for each corner v, `sqrt 2 |c - v|` exceeds both sigma(c) and
    /// sigma(v); relaxes the edges round each split, then all inner edges; repeats until nothing is added. A new
    /// vertex has the mean sigma of its triangle's corners.
    ///
    /// Source: Liepa 2003, sec. 5.
    ///
    /// # Errors
    /// [`FillError::CapReached`] when `limit` vertices have been added.
    pub(crate) fn refine(&mut self, limit: usize) -> Result<(), FillError> {
        let first = self.points.len();
        for _ in 0..ROUNDS {
            let before = self.points.len();
            for t in 0..self.topology.triangle_count() as u32 {
                let Some((centre, size)) = self.split_point(t) else { continue };
                if self.points.len() - first >= limit {
                    return Err(FillError::CapReached { limit });
                }
                let v = self.points.len() as u32;
                self.points.push(centre);
                self.sizes.push(size);
                for t in self.topology.split_face(t, v) {
                    let outer = (3 * t..3 * t + 3).find(|&h| self.topology.apex(h) == v);
                    outer.into_iter().for_each(|h| _ = self.relax(h));
                }
            }
            self.relax_all();
            if self.points.len() == before {
                break;
            }
        }
        Ok(())
    }

    fn split_point(&self, t: u32) -> Option<(DVec3, f64)> {
        let corners = self.topology.corners(t);
        let centre = corners.map(|v| self.at(v)).iter().sum::<DVec3>() / 3.0;
        let size_of = |v: u32| self.sizes[v as usize];
        let reach = |v: u32| self.at(v).distance(centre);
        let mean = corners.map(size_of).iter().sum::<f64>() / 3.0;
        let grown =
            corners.map(|v| size_of(v) + self.growth * reach(v)).into_iter().fold(f64::INFINITY, f64::min);
        let size = if self.growth > 0.0 { grown } else { mean }.min(self.largest);
        let wide = |v: u32| DENSITY * reach(v) > size && DENSITY * reach(v) > size_of(v);
        corners.into_iter().all(wide).then_some((centre, size))
    }

    fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    fn relax_all(&mut self) {
        for _ in 0..SWEEPS {
            let swapped = (0..self.topology.origin.len() as u32).filter(|&h| self.relax(h)).count();
            if swapped == 0 {
                break;
            }
        }
    }

    /// Swaps the edge of `h` if either far corner lies in the sphere of the other triangle's circumcircle, unless the
    /// new edge exists, is forbidden, or would fold the surface.
    fn relax(&mut self, h: u32) -> bool {
        let Some(twin) = self.topology.twin(h) else { return false };
        let [a, b, c, d] =
            [self.topology.start(h), self.topology.end(h), self.topology.apex(h), self.topology.apex(twin)];
        let p = [a, b, c, d].map(|v| self.at(v));
        let swaps = (in_sphere(p[0], p[1], p[2], p[3]) || in_sphere(p[1], p[0], p[3], p[2]))
            && stays_unfolded(p)
            && self.forbidden.binary_search(&[c.min(d), c.max(d)]).is_err()
            && !self.is_joined(prev(h), d);
        if swaps {
            self.topology.flip(h);
        }
        swaps
    }

    /// True if the vertex at which `from` starts has an edge to `to`.
    fn is_joined(&self, from: u32, to: u32) -> bool {
        let t = &self.topology;
        if t.star(from).any(|h| t.end(h) == to || t.apex(h) == to) {
            return true;
        }
        let mut here = t.twin(from);
        while let Some(h) = here.map(next) {
            if h == from {
                return false;
            }
            if t.end(h) == to || t.apex(h) == to {
                return true;
            }
            here = t.twin(h);
        }
        false
    }
}

/// True if d lies clearly inside the sphere round a, b, c whose centre is in their plane.
fn in_sphere(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> bool {
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v);
    let double = 2.0 * normal.length_squared();
    if double == 0.0 {
        return true;
    }
    let to_centre = (normal.cross(u) * v.length_squared() + v.cross(normal) * u.length_squared()) / double;
    // The margin keeps rounding from swapping an edge to and fro.
    (d - a).distance_squared(to_centre) < to_centre.length_squared() * (1.0 - 1e-9)
}

/// True if the two triangles after the swap look the way the two before it do.
fn stays_unfolded([a, b, c, d]: [DVec3; 4]) -> bool {
    let before = (b - a).cross(c - a) + (a - b).cross(d - b);
    let after = [(c - d).cross(a - d), (d - c).cross(b - c)];
    after.iter().all(|n| n.dot(before) > 1e-6 * before.length() * (c - d).length_squared())
}
