//! Triangles of one cell as two columns.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Triangles of one cell: positions in file order, and three vertex indices a triangle.
///
/// Vertices that texture seams split stay split: two vertices are the same *place* iff their position bits agree
/// (with -0 read as +0).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Positions, metres, z up, in the frame of the scene's files. May hold non-finite values: no triangle uses them.
    pub positions: Vec<DVec3>,
    /// Indices into `positions`, counter-clockwise seen from outside (above, for terrain). Every index is in range.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The three corners of triangle `t`.
    #[inline]
    #[must_use]
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }
}

/// An axis-parallel box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Lower corner, metres.
    pub min: DVec3,
    /// Upper corner, metres.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// True if nothing was ever added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// Grows the box to hold `point`.
    pub fn add(&mut self, point: DVec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}
