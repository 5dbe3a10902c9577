//! Boundary edges joined into simple closed loops.

use crate::turn::{Plan, clockwise_order};
use crate::{Boundary, BoundaryEdge, BoundaryKind, PointId};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A closed walk along the boundary with the hole on its left. No point occurs twice.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoundaryLoop {
    /// Indices into [`Boundary::edges`] in walking order; the first edge starts at the loop's smallest point.
    pub edges: Vec<u32>,
}

impl BoundaryLoop {
    /// The points in walking order.
    pub fn points<'a>(&'a self, boundary: &'a Boundary) -> impl ExactSizeIterator<Item = PointId> + 'a {
        self.edges.iter().map(|&e| boundary.edges[e as usize].from)
    }

    /// The points' positions in walking order, metres.
    #[must_use]
    pub fn positions(&self, boundary: &Boundary) -> Vec<DVec3> {
        self.points(boundary).map(|p| boundary.position(p)).collect()
    }

    /// True if an edge is what was left over of three or more triangles: such a loop is never filled.
    #[must_use]
    pub fn has_non_manifold(&self, boundary: &Boundary) -> bool {
        self.edges.iter().any(|&e| boundary.edges[e as usize].kind == BoundaryKind::NonManifold)
    }

    /// True if an edge belongs to a pair of triangles that run along it in the same direction.
    #[must_use]
    pub fn has_conflict(&self, boundary: &Boundary) -> bool {
        self.edges.iter().any(|&e| boundary.edges[e as usize].kind == BoundaryKind::Conflict)
    }
}

/// All loops of a boundary.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoundaryLoops {
    /// Loops of three or more points, sorted by their edges: the one with the smallest point comes first.
    pub loops: Vec<BoundaryLoop>,
    /// Loops of fewer than three points (cracks without area) that were dropped.
    pub cracks: usize,
    /// Edges that lie on no closed walk. Zero for every [`crate::boundary()`]; only a boundary put together in another way
    /// can have them.
    pub open_edges: usize,
}

/// Joins the edges of `boundary` into closed loops, each simple (no point twice), each edge in exactly one.
///
/// Steps: (1) walk from the smallest unused edge; (2) where several edges go on (a bow-tie, a pinched hole), take the
/// one that turns most sharply to the left seen from above, so that the walk stays with the same hole; on steep or
/// overhanging surface "above" is the side that the triangles there face; ties by id; (3) when a point is met again,
/// cut the walk off there as a loop of its own; (4) rotate each loop to start at its smallest point, sort, drop loops
/// of fewer than three points. Takes O(n log n).
///
/// Source: algorithm note, section A.5.
#[must_use]
pub fn loops(boundary: &Boundary) -> BoundaryLoops {
    debug_assert!(boundary.edges.is_sorted_by_key(|e| (e.from, e.to, e.face)));
    let mut walker = Walker::new(boundary);
    let mut found = Vec::new();
    let mut open_edges = 0;
    for start in 0..boundary.edges.len() as u32 {
        if !walker.is_used[start as usize] {
            open_edges += walker.walk(start, &mut found);
        }
    }
    let all = found.len();
    found.retain(|edges| edges.len() >= 3);
    let cracks = all - found.len();
    found.iter_mut().for_each(|edges| start_at_smallest(edges));
    found.sort_by_cached_key(|edges| edges.clone());
    BoundaryLoops {
        loops: found.into_iter().map(|edges| BoundaryLoop { edges }).collect(),
        cracks,
        open_edges,
    }
}

/// Edges are sorted by their start, so the smallest edge starts at the smallest point.
fn start_at_smallest(edges: &mut [u32]) {
    let first = (0..edges.len()).min_by_key(|&i| edges[i]).unwrap_or(0);
    edges.rotate_left(first);
}

/// Walks over the edges, using each once.
struct Walker<'a> {
    boundary: &'a Boundary,
    /// Edges that start at point p: `starts[p]..starts[p + 1]`.
    starts: Vec<u32>,
    is_used: Vec<bool>,
    /// Edges walked and not yet cut off as a loop.
    stack: Vec<u32>,
    /// For each point, 1 + the place on the stack of the edge that leaves it; 0 = none.
    on_stack: Vec<u32>,
}

impl<'a> Walker<'a> {
    fn new(boundary: &'a Boundary) -> Self {
        let points = boundary.points.len();
        let starts =
            (0..=points).map(|p| boundary.edges.partition_point(|e| e.from.index() < p) as u32).collect();
        let is_used = vec![false; boundary.edges.len()];
        Self { boundary, starts, is_used, stack: Vec::new(), on_stack: vec![0; points] }
    }

    /// Walks from edge `start` until nothing is left on the stack. Returns the number of edges that led nowhere.
    fn walk(&mut self, start: u32, found: &mut Vec<Vec<u32>>) -> usize {
        self.push(start);
        while let Some(&last) = self.stack.last() {
            let here = self.edge(last).to;
            if self.on_stack[here.index()] != 0 {
                found.push(self.cut_off(here));
                if self.stack.is_empty() {
                    return 0;
                }
            }
            match self.next_edge(last) {
                Some(next) => self.push(next),
                None => return self.give_up(),
            }
        }
        0
    }

    fn push(&mut self, edge: u32) {
        self.stack.push(edge);
        self.is_used[edge as usize] = true;
        let from = self.edge(edge).from;
        self.on_stack[from.index()] = self.stack.len() as u32;
    }

    /// Takes the walk since `point` off the stack: a loop. What stays on the stack ends at `point`.
    fn cut_off(&mut self, point: PointId) -> Vec<u32> {
        // Not `split_off`: that may hand out the stack itself, with room for the longest walk so far, in every loop.
        let edges: Vec<u32> = self.stack.drain(self.on_stack[point.index()] as usize - 1..).collect();
        self.leave_stack(&edges);
        edges
    }

    /// Empties the stack after a walk that came to an end without closing.
    fn give_up(&mut self) -> usize {
        let edges = std::mem::take(&mut self.stack);
        self.leave_stack(&edges);
        edges.len()
    }

    fn leave_stack(&mut self, edges: &[u32]) {
        for &edge in edges {
            let from = self.edge(edge).from;
            self.on_stack[from.index()] = 0;
        }
    }

    /// The unused edge on which the walk goes on after `last`.
    fn next_edge(&self, last: u32) -> Option<u32> {
        let mut unused = self.starting_at(self.edge(last).to).filter(|&e| !self.is_used[e as usize]);
        let first = unused.next()?;
        let mut others = unused.peekable();
        if others.peek().is_none() {
            return Some(first);
        }
        Some(self.sharpest_left(last, std::iter::once(first).chain(others).collect()))
    }

    /// The edge that comes first when one rotates clockwise from the way back; ties by id.
    fn sharpest_left(&self, last: u32, choices: Vec<u32>) -> u32 {
        let here = self.edge(last).to;
        let plan = Plan::facing(self.boundary.position(here), self.normal_at(last));
        let back = plan.of(self.boundary.position(self.edge(last).from));
        let direction = |e: u32| plan.of(self.boundary.position(self.edge(e).to));
        let sharper = |a: u32, b: u32| {
            let order = clockwise_order(plan.origin(), back, direction(a), direction(b));
            if order.then(a.cmp(&b)).is_le() { a } else { b }
        };
        choices.into_iter().reduce(sharper).unwrap_or(last)
    }

    /// Sum of the normals of the boundary triangles at the end of `last`, weighted by area.
    fn normal_at(&self, last: u32) -> DVec3 {
        let leaving = self.starting_at(self.edge(last).to).map(|e| self.normal(e));
        leaving.fold(self.normal(last), |sum, normal| sum + normal)
    }

    /// Normal of the edge's triangle, which runs from the edge's end to its start and on to the apex.
    fn normal(&self, edge: u32) -> DVec3 {
        let edge = self.edge(edge);
        let (from, to) = (self.boundary.position(edge.from), self.boundary.position(edge.to));
        (from - to).cross(edge.apex - to)
    }

    fn starting_at(&self, point: PointId) -> Range<u32> {
        self.starts[point.index()]..self.starts[point.index() + 1]
    }

    fn edge(&self, edge: u32) -> &'a BoundaryEdge {
        &self.boundary.edges[edge as usize]
    }
}
