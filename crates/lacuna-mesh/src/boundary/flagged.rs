//! Flagged places (those that do not balance over all their copies) and the triangles near them.

use super::balance::Balance;
use crate::places::PlaceTable;
use crate::{TriMesh, VertexId};

/// No flagged place.
pub(super) const UNFLAGGED: u32 = u32::MAX;

/// A triangle with at least two flagged corners.
pub(super) struct Candidate {
    /// Which triangle.
    pub(super) face: u32,
    /// Number of each corner's place, or `UNFLAGGED`.
    pub(super) places: [u32; 3],
}

impl Candidate {
    /// True if one corner balances.
    pub(super) fn has_unflagged_corner(&self) -> bool {
        self.places.contains(&UNFLAGGED)
    }
}

/// The places of unbalanced vertices; flagged are those whose copies' sums do not cancel.
pub(super) struct Flagged<'a> {
    table: PlaceTable<'a>,
    is_flagged: Vec<bool>,
    /// One bit a vertex: it lies at a flagged place.
    vertices: BitSet,
    copies: Vec<[VertexId; 2]>,
}

impl<'a> Flagged<'a> {
    /// Groups the unbalanced vertices by position, adds up each group, and marks every vertex of the mesh that lies at
    /// a place with a non-zero sum.
    pub(super) fn find(mesh: &'a TriMesh, balance: &Balance) -> Self {
        let unbalanced = balance.unbalanced();
        let mut table = PlaceTable::with_capacity(&mesh.positions, unbalanced.len());
        let mut sums: Vec<u64> = Vec::new();
        let mut copies = Vec::new();
        for &vertex in &unbalanced {
            let place = table.insert(balance.hash(vertex), vertex);
            sums.resize(table.len(), 0);
            sums[place] = sums[place].wrapping_add(balance.sum(vertex));
            if table.first_vertex(place) != vertex {
                copies.push([VertexId(vertex), VertexId(table.first_vertex(place))]);
            }
        }
        let is_flagged = sums.iter().map(|&sum| sum != 0).collect();
        let vertices = BitSet::with_len(mesh.positions.len());
        let mut flagged = Self { table, is_flagged, vertices, copies };
        flagged.mark_vertices(balance);
        flagged
    }

    /// Sets the bit of every vertex at a flagged place. Copies there that balance for themselves count as well, so that
    /// the edge counts are complete; a filter on the hash keeps almost all other vertices out of the table.
    fn mark_vertices(&mut self, balance: &Balance) {
        let flagged_places = (0..self.table.len()).filter(|&p| self.is_flagged[p]);
        let filter = HashFilter::of(flagged_places.map(|p| self.table.hash(p)));
        let with_entry = self.copies.len();
        for (vertex, hash) in balance.hashes().enumerate() {
            if filter.may_hold(hash) {
                self.mark(balance, hash, vertex as u32);
            }
        }
        if self.copies.len() > with_entry {
            self.copies.sort_unstable();
        }
    }

    fn mark(&mut self, balance: &Balance, hash: u64, vertex: u32) {
        let Some(place) = self.table.find(hash, vertex).filter(|&p| self.is_flagged[p]) else { return };
        self.vertices.insert(vertex);
        if balance.sum(vertex) == 0 {
            self.copies.push([VertexId(vertex), VertexId(self.table.first_vertex(place))]);
        }
    }

    /// The triangles with two or three flagged corners, ascending, without ignored ones and those in `left_out`
    /// (sorted). Every triangle at an edge between two flagged places is among them.
    pub(super) fn candidates(&self, mesh: &TriMesh, balance: &Balance, left_out: &[u32]) -> Vec<Candidate> {
        let mut candidates = Vec::new();
        for (face, &triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| self.vertices.contains(v));
            if (a & b) | (b & c) | (c & a) {
                let face = face as u32;
                if left_out.binary_search(&face).is_err() {
                    candidates.extend(self.candidate(balance, face, triangle));
                }
            }
        }
        candidates
    }

    fn candidate(&self, balance: &Balance, face: u32, triangle: [u32; 3]) -> Option<Candidate> {
        let hashes = balance.corner_hashes(triangle)?;
        let mut places = [UNFLAGGED; 3];
        for corner in 0..3 {
            let place = self.table.find(hashes[corner], triangle[corner]);
            places[corner] = place.filter(|&p| self.is_flagged[p]).map_or(UNFLAGGED, |p| p as u32);
        }
        Some(Candidate { face, places })
    }

    /// How many places there are, flagged or not.
    pub(super) fn places(&self) -> usize {
        self.table.len()
    }

    /// The lowest unbalanced vertex of the place.
    pub(super) fn first_vertex(&self, place: usize) -> u32 {
        self.table.first_vertex(place)
    }

    /// `[copy, first vertex of its place]`, sorted.
    pub(super) fn into_copies(self) -> Vec<[VertexId; 2]> {
        self.copies
    }
}

/// One bit a vertex.
struct BitSet(Vec<u64>);

impl BitSet {
    fn with_len(len: usize) -> Self {
        Self(vec![0; len.div_ceil(64)])
    }

    fn insert(&mut self, i: u32) {
        self.0[i as usize / 64] |= 1 << (i % 64);
    }

    fn contains(&self, i: u32) -> bool {
        self.0[i as usize / 64] >> (i % 64) & 1 == 1
    }
}

/// A set of hashes that never misses one and seldom lets a foreign one pass.
struct HashFilter {
    bits: Vec<u64>,
    shift: u32,
}

impl HashFilter {
    fn of(hashes: impl Iterator<Item = u64> + Clone) -> Self {
        let slots = (64 * hashes.clone().count()).next_power_of_two().clamp(1 << 10, 1 << 24);
        let mut filter = Self { bits: vec![0; slots / 64], shift: 64 - slots.trailing_zeros() };
        for hash in hashes {
            let slot = hash >> filter.shift;
            filter.bits[slot as usize / 64] |= 1 << (slot % 64);
        }
        filter
    }

    fn may_hold(&self, hash: u64) -> bool {
        let slot = hash >> self.shift;
        self.bits[slot as usize / 64] >> (slot % 64) & 1 == 1
    }
}
