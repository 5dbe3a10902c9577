//! A triangulation in the plane whose boundary never changes: insertion, exact Delaunay flips.

use crate::frame::Frame;
use crate::predicates::in_circle;
use crate::topology::{Topology, next, prev};
use glam::DVec2;
use lacuna_mesh::side_of_line;

/// A triangulation in a frame's plane. The first `fixed` points are the contour's; the boundary of the triangles is the
/// contour itself and is never split or flipped.
#[derive(Clone, Debug)]
pub(crate) struct PlanMesh {
    pub(crate) frame: Frame,
    pub(crate) points: Vec<DVec2>,
    /// Wanted edge length at each point, metres.
    pub(crate) sizes: Vec<f64>,
    pub(crate) fixed: usize,
    pub(crate) topology: Topology,
}

/// Where a walk towards a point ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Inside(u32),
    OnEdge(u32),
    /// The boundary or an existing vertex is in the way.
    Blocked,
}

impl PlanMesh {
    pub(crate) fn at(&self, v: u32) -> DVec2 {
        self.points[v as usize]
    }

    pub(crate) fn corner_points(&self, t: u32) -> [DVec2; 3] {
        self.topology.corners(t).map(|v| self.at(v))
    }

    /// Walks from triangle `t` to the triangle that holds `p`, without leaving the mesh.
    pub(crate) fn locate(&self, mut t: u32, p: DVec2) -> Place {
        for _ in 0..200 {
            let mut zero = None;
            let mut zeros = 0;
            let mut across = None;
            for h in 3 * t..3 * t + 3 {
                let side = side_of_line(self.at(self.topology.start(h)), self.at(self.topology.end(h)), p);
                if side < 0.0 && across.is_none() {
                    across = Some(h);
                } else if side == 0.0 {
                    zero = Some(h);
                    zeros += 1;
                }
            }
            let Some(h) = across else {
                return match (zeros, zero) {
                    (0, _) => Place::Inside(t),
                    (1, Some(h)) if self.topology.twin(h).is_some() => Place::OnEdge(h),
                    _ => Place::Blocked,
                };
            };
            match self.topology.twin(h) {
                Some(twin) => t = twin / 3,
                None => return Place::Blocked,
            }
        }
        Place::Blocked
    }

    /// Adds a point where `place` says and flips until the triangulation is Delaunay again. Every triangle that was
    /// made or changed is appended to `touched`, perhaps more than once.
    pub(crate) fn insert(&mut self, place: Place, p: DVec2, size: f64, touched: &mut Vec<u32>) {
        let v = self.points.len() as u32;
        let made = match place {
            Place::Inside(t) => self.topology.split_face(t, v).to_vec(),
            Place::OnEdge(h) => self.topology.split_edge(h, v),
            Place::Blocked => return,
        };
        self.points.push(p);
        self.sizes.push(size);
        let mut stack: Vec<u32> =
            made.iter().flat_map(|&t| (3 * t..3 * t + 3).filter(|&h| self.topology.apex(h) == v)).collect();
        touched.extend(&made);
        while let Some(h) = stack.pop() {
            if self.is_delaunay(h) {
                continue;
            }
            let twin = self.topology.twin[h as usize];
            self.topology.flip(h);
            // After the flip the new vertex is the end of `h`; the two outer edges are opposite to it.
            stack.push(next(twin));
            stack.push(prev(h));
            touched.extend([h / 3, twin / 3]);
            debug_assert!(self.topology.apex(next(twin)) == v && self.topology.apex(prev(h)) == v);
        }
    }

    /// True if the edge of `h` is on the boundary, or the far apex is not inside the circle of `h`'s triangle.
    pub(crate) fn is_delaunay(&self, h: u32) -> bool {
        let Some(twin) = self.topology.twin(h) else { return true };
        let [a, b, c, d] =
            [self.topology.start(h), self.topology.end(h), self.topology.apex(h), self.topology.apex(twin)]
                .map(|v| self.at(v));
        in_circle(a, b, c, d) <= 0.0
    }

    /// Flips inner edges until the triangulation is constrained Delaunay. All triangles must be counter-clockwise.
    pub(crate) fn restore_delaunay(&mut self) {
        let all = (0..self.topology.origin.len() as u32).filter(|&h| self.topology.twin[h as usize] > h);
        self.flip_until_delaunay(all.collect(), |_| {});
    }

    /// The same for a triangulation that was constrained Delaunay until some points moved. `on_flip` gets the four
    /// vertices of every flip.
    pub(crate) fn restore_delaunay_near(&mut self, moved: &[bool], on_flip: impl FnMut([u32; 4])) {
        let topology = &self.topology;
        let has_moved = |t: u32| topology.corners(t).iter().any(|&v| moved[v as usize]);
        let near = (0..topology.origin.len() as u32).filter(|&h| {
            let twin = topology.twin[h as usize];
            twin > h && topology.twin(h).is_some() && (has_moved(h / 3) || has_moved(twin / 3))
        });
        let near = near.collect();
        self.flip_until_delaunay(near, on_flip);
    }

    fn flip_until_delaunay(&mut self, mut suspects: Vec<u32>, mut on_flip: impl FnMut([u32; 4])) {
        suspects.retain(|&h| !self.is_delaunay(h));
        suspects.reverse();
        while let Some(h) = suspects.pop() {
            if self.is_delaunay(h) {
                continue;
            }
            let twin = self.topology.twin[h as usize];
            let topology = &mut self.topology;
            on_flip([topology.start(h), topology.end(h), topology.apex(h), topology.apex(twin)]);
            topology.flip(h);
            suspects.extend([next(h), prev(h), next(twin), prev(twin)]);
        }
    }
}
