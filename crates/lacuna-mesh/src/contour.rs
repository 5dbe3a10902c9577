//! What a filler sees of a hole (contour), and what it returns (patch).

use crate::position_bits;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What an edge of a contour is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EdgeKind {
    /// An edge of the original mesh: the patch joins it.
    Rim,
    /// A closing edge on the cell's border: the neighbour's patch (or nothing) joins it.
    Border,
}

/// A vertex of a contour. It is never moved, and its position is copied bit for bit into the patch's triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContourVertex {
    /// Position, metres, z up.
    pub position: DVec3,
    /// Local edge length that the patch should have here, metres (Liepa's sigma: mean length of the vertex's original
    /// edges on the contour).
    pub spacing_m: f64,
}

/// The edge from a contour vertex to the next one of its ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContourEdge {
    /// Rim or border.
    pub kind: EdgeKind,
    /// The third corner of the original triangle behind a rim edge; `None` on a border.
    pub apex: Option<DVec3>,
}

/// One closed ring of a contour. `edges[i]` runs from `vertices[i]` to `vertices[(i + 1) % n]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContourRing {
    /// Vertices in walking order, hole on the left: an outer ring runs counter-clockwise seen from above, an inner
    /// ring (island) clockwise.
    pub vertices: Vec<ContourVertex>,
    /// As many edges as vertices.
    pub edges: Vec<ContourEdge>,
}

/// Original surface round the hole that a filler may read for slopes: the ring triangles behind the rim.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Support {
    /// Vertices behind the rim, metres; their indices follow the contour's vertices.
    pub vertices: Vec<DVec3>,
    /// Triangles, counter-clockwise from above: index `i < n` is contour vertex `i` (outer ring first, then the inner
    /// ones in order, n vertices in all), `n + k` is `vertices[k]`.
    pub triangles: Vec<[u32; 3]>,
}

/// A closed hole of one cell, as a filler sees it. Contour vertices are numbered through: outer ring, then inner rings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contour {
    /// The outer ring.
    pub outer: ContourRing,
    /// Islands.
    pub inner: Vec<ContourRing>,
    /// Surface behind the rims.
    pub support: Support,
    /// Pairs of contour vertices (smaller index first, sorted) that an inner edge of the original mesh already joins:
    /// a patch edge there would have three triangles.
    pub forbidden_edges: Vec<[u32; 2]>,
}

impl Contour {
    /// Rings in order: outer, then inner.
    pub fn rings(&self) -> impl Iterator<Item = &ContourRing> {
        std::iter::once(&self.outer).chain(&self.inner)
    }

    /// Number of contour vertices over all rings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rings().map(|r| r.vertices.len()).sum()
    }

    /// True if there is no vertex at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Positions of all contour vertices in numbering order.
    #[must_use]
    pub fn positions(&self) -> Vec<DVec3> {
        self.rings().flat_map(|r| r.vertices.iter().map(|v| v.position)).collect()
    }

    /// For each contour vertex the first one at its place: itself, unless rings touch there or a ring touches itself.
    /// O(n log n).
    #[must_use]
    pub fn first_at_place(&self) -> Vec<u32> {
        let mut sorted: Vec<([u64; 3], u32)> =
            self.positions().into_iter().map(position_bits).zip(0..).collect();
        sorted.sort_unstable();
        let mut first = vec![0; sorted.len()];
        for place in sorted.chunk_by(|a, b| a.0 == b.0) {
            place.iter().for_each(|&(_, v)| first[v as usize] = place[0].1);
        }
        first
    }
}

/// The new surface of one hole in one cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// New vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Triangles, counter-clockwise from above: index `i < n` is contour vertex `i` (n = `Contour::len`), `n + k` is
    /// `vertices[k]`.
    pub triangles: Vec<[u32; 3]>,
}
