//! The patches of one cell as edges and places: how often each edge is used, and by what.

use glam::DVec3;
use lacuna_mesh::{TriMesh, position_bits};
use std::collections::HashMap;

/// Owner of triangles that were delivered.
pub(super) const ORIGINAL: u32 = u32::MAX;

/// The final mesh of a cell: which triangles are whose.
#[derive(Clone, Debug, Default)]
pub(super) struct CellMesh {
    /// Everything that stands in the cell's files.
    pub(super) mesh: TriMesh,
    /// For each triangle the number of its patch, or [`ORIGINAL`].
    pub(super) owner: Vec<u32>,
    /// Hole of each patch, as its mark says; `None` for triangles without a mark.
    pub(super) holes: Vec<Option<String>>,
}

impl CellMesh {
    /// Triangles that were not delivered.
    pub(super) fn patch_triangles(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.owner.len()).filter(|&t| self.owner[t] != ORIGINAL)
    }

    /// What messages call a patch.
    pub(super) fn patch_name(&self, patch: u32) -> &str {
        self.holes.get(patch as usize).and_then(|h| h.as_deref()).unwrap_or("a patch without a mark")
    }
}

/// One triangle's use of an edge between two places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeUse {
    pub(super) low: u32,
    pub(super) high: u32,
    /// False for triangles that were delivered.
    pub(super) is_patch: bool,
    /// True if the triangle runs from the lower to the higher place.
    pub(super) is_upward: bool,
    pub(super) triangle: u32,
}

/// Edges of all patches, with every use of them, also by delivered triangles. Vertices at one place are one.
pub(super) struct PatchEdges {
    /// Sorted by edge.
    pub(super) uses: Vec<EdgeUse>,
    /// Position of each place that a patch uses.
    pub(super) positions: Vec<DVec3>,
    ids: HashMap<[u64; 3], u32>,
}

impl PatchEdges {
    pub(super) fn new(cell: &CellMesh) -> Self {
        let mut edges = Self { uses: Vec::new(), positions: Vec::new(), ids: HashMap::new() };
        for t in cell.patch_triangles() {
            let corners = cell.mesh.corners(t).map(|p| edges.place(p));
            edges.add(corners, true, t as u32);
        }
        for t in (0..cell.owner.len()).filter(|&t| cell.owner[t] == ORIGINAL) {
            edges.add_original(cell.mesh.corners(t), t as u32);
        }
        edges.uses.sort_unstable();
        edges
    }

    fn place(&mut self, position: DVec3) -> u32 {
        let next = self.positions.len() as u32;
        let id = *self.ids.entry(position_bits(position)).or_insert(next);
        if id == next {
            self.positions.push(position);
        }
        id
    }

    /// The place at a position, if a patch uses it.
    pub(super) fn find(&self, position: DVec3) -> Option<u32> {
        self.ids.get(&position_bits(position)).copied()
    }

    fn add(&mut self, [a, b, c]: [u32; 3], is_patch: bool, triangle: u32) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                let (low, high) = (from.min(to), from.max(to));
                self.uses.push(EdgeUse { low, high, is_patch, is_upward: from < to, triangle });
            }
        }
    }

    fn add_original(&mut self, corners: [DVec3; 3], triangle: u32) {
        let [a, b, c] = corners.map(|p| self.find(p));
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if let (Some(from), Some(to)) = (from, to)
                && from != to
            {
                let (low, high) = (from.min(to), from.max(to));
                self.uses.push(EdgeUse { low, high, is_patch: false, is_upward: from < to, triangle });
            }
        }
    }

    /// The uses of each edge that a patch has.
    pub(super) fn of_patches(&self) -> impl Iterator<Item = &[EdgeUse]> {
        let groups = self.uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high));
        groups.filter(|uses| uses.iter().any(|u| u.is_patch))
    }

    /// Edges at which a patch joins delivered surface.
    pub(super) fn rims(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.of_patches().filter(|uses| uses.len() == 2 && uses[0].is_patch != uses[1].is_patch)
    }
}
