//! How the triangles of a patch hang together: fans, parts, handles.

use super::{Edges, PatchDefect, contour_edges};
use crate::Contour;

/// Checks a patch whose edges are sound; `triangles` name places.
///
/// Steps: (1) corners that share an edge at a vertex are one fan; a place has as many fans as contour vertices; (2) all
/// triangles hang together by vertices; (3) triangles that hang together by edges are one part, rings that touch are one
/// part of the contour, and cut open at touching vertices the patch must have Euler number
/// `1 + parts of the patch - parts of the contour`.
///
/// Why (3): join each boundary loop of the parts to the part of the contour that it runs on. That graph is connected by
/// (2), so it has at least `parts of the patch + parts of the contour - 1` loops, and Euler's number of parts of genus g
/// is the sum of `2 - 2 g - loops`: it reaches the value above only if no part has a handle.
pub(super) fn check_surface(
    contour: &Contour,
    first_at_place: &[u32],
    triangles: &[[u32; 3]],
    edges: &Edges,
) -> Result<(), PatchDefect> {
    check_fans(first_at_place, triangles, edges)?;
    check_connection(first_at_place.len(), triangles)?;
    let mut patch = Parts::new(triangles.len());
    edges.joined.iter().for_each(|&[h, t]| patch.join(h / 3, t / 3));
    let mut rims = Parts::new(contour.len());
    first_at_place.iter().take(contour.len()).zip(0..).for_each(|(&first, v)| rims.join(first, v));
    contour_edges(contour, first_at_place).for_each(|[a, b]| rims.join(a, b));
    let found = first_at_place.len() as i64 - edges.count as i64 + triangles.len() as i64;
    let expected = 1 + patch.count() as i64 - rims.count() as i64;
    if found == expected { Ok(()) } else { Err(PatchDefect::EulerNumber { found, expected }) }
}

fn check_fans(first_at_place: &[u32], triangles: &[[u32; 3]], edges: &Edges) -> Result<(), PatchDefect> {
    let next = |h: u32| if h % 3 == 2 { h - 2 } else { h + 1 };
    let mut corners = Parts::new(3 * triangles.len());
    for &[h, t] in &edges.joined {
        corners.join(h, next(t));
        corners.join(next(h), t);
    }
    let mut balance = vec![(0, 0); first_at_place.len()];
    for (&vertex, corner) in triangles.iter().flatten().zip(0..) {
        balance[vertex as usize].0 += usize::from(corners.root(corner) == corner);
    }
    first_at_place.iter().for_each(|&v| balance[v as usize].1 += 1);
    match balance.iter().position(|&(fans, expected)| fans != expected) {
        Some(v) => {
            let (fans, expected) = balance[v];
            Err(PatchDefect::Pinched { vertex: v as u32, fans, expected })
        }
        None => Ok(()),
    }
}

fn check_connection(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), PatchDefect> {
    let mut parts = Parts::new(vertices);
    for &[a, b, c] in triangles {
        parts.join(a, b);
        parts.join(b, c);
    }
    let Some(first) = triangles.first().map(|t| parts.root(t[0])) else { return Ok(()) };
    match triangles.iter().position(|t| parts.root(t[0]) != first) {
        Some(triangle) => Err(PatchDefect::Separate { triangle }),
        None => Ok(()),
    }
}

/// Union-find; the smallest member of a part is its root.
struct Parts {
    parents: Vec<u32>,
}

impl Parts {
    fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    fn root(&mut self, mut v: u32) -> u32 {
        while self.parents[v as usize] != v {
            let above = self.parents[self.parents[v as usize] as usize];
            self.parents[v as usize] = above;
            v = above;
        }
        v
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    fn count(&self) -> usize {
        self.parents.iter().zip(0..).filter(|&(&parent, v)| parent == v).count()
    }
}
