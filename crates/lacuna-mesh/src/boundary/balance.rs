//! The balance pass: one read of the positions, one of the triangles.

use super::Defects;
use crate::TriMesh;
use crate::places::{NO_PLACE, place_hash};

/// Hash of the position, and balance, of each vertex. One column, so that a triangle's corner costs one cache line.
pub(super) struct Balance {
    vertices: Vec<HashAndSum>,
    non_finite: u64,
    degenerate: u64,
}

#[derive(Clone, Copy)]
struct HashAndSum {
    hash: u64,
    sum: u64,
}

impl Balance {
    /// Tabulates the hashes and sums the triangles' contributions.
    pub(super) fn of(mesh: &TriMesh, seed: u64) -> Self {
        let vertices =
            mesh.positions.iter().map(|&p| HashAndSum { hash: place_hash(p, seed), sum: 0 }).collect();
        let mut balance = Self { vertices, non_finite: 0, degenerate: 0 };
        balance.add_triangles(mesh);
        balance
    }

    fn add_triangles(&mut self, mesh: &TriMesh) {
        let vertices = self.vertices.as_mut_slice();
        let (mut non_finite, mut degenerate) = (0u64, 0u64);
        for &[a, b, c] in &mesh.triangles {
            let (a, b, c) = (a as usize, b as usize, c as usize);
            let (h_a, h_b, h_c) = (vertices[a].hash, vertices[b].hash, vertices[c].hash);
            if (h_a == NO_PLACE) | (h_b == NO_PLACE) | (h_c == NO_PLACE) {
                non_finite += 1;
                continue;
            }
            // A degenerate triangle adds zero to every place by algebra; it is only counted.
            degenerate += u64::from((h_a == h_b) | (h_b == h_c) | (h_c == h_a));
            vertices[a].add(h_b.wrapping_sub(h_c));
            vertices[b].add(h_c.wrapping_sub(h_a));
            vertices[c].add(h_a.wrapping_sub(h_b));
        }
        (self.non_finite, self.degenerate) = (non_finite, degenerate);
    }

    /// Takes the contribution of one triangle out again. It must be finite.
    pub(super) fn remove(&mut self, mesh: &TriMesh, face: u32) {
        let [a, b, c] = mesh.triangles[face as usize];
        let (h_a, h_b, h_c) = (self.hash(a), self.hash(b), self.hash(c));
        self.vertices[a as usize].add(h_c.wrapping_sub(h_b));
        self.vertices[b as usize].add(h_a.wrapping_sub(h_c));
        self.vertices[c as usize].add(h_b.wrapping_sub(h_a));
    }

    /// Hash of the vertex's position, `NO_PLACE` if that is not finite.
    pub(super) fn hash(&self, vertex: u32) -> u64 {
        self.vertices[vertex as usize].hash
    }

    /// The three corners' hashes, or `None` if the triangle is to be ignored: a corner is not finite, or two corners
    /// are at the same place.
    pub(super) fn corner_hashes(&self, triangle: [u32; 3]) -> Option<[u64; 3]> {
        let [a, b, c] = triangle.map(|v| self.hash(v));
        let is_ignored = a == NO_PLACE || b == NO_PLACE || c == NO_PLACE || a == b || b == c || c == a;
        (!is_ignored).then_some([a, b, c])
    }

    /// The vertex's sum: zero iff its edges balance.
    pub(super) fn sum(&self, vertex: u32) -> u64 {
        self.vertices[vertex as usize].sum
    }

    /// Hashes of all vertices, in order.
    pub(super) fn hashes(&self) -> impl Iterator<Item = u64> {
        self.vertices.iter().map(|v| v.hash)
    }

    /// The vertices that do not balance, ascending.
    pub(super) fn unbalanced(&self) -> Vec<u32> {
        self.vertices.iter().enumerate().filter(|(_, v)| v.sum != 0).map(|(i, _)| i as u32).collect()
    }

    /// What the pass counted on its way.
    pub(super) fn defects(&self) -> Defects {
        Defects { non_finite: self.non_finite, degenerate: self.degenerate, ..Defects::default() }
    }
}

impl HashAndSum {
    fn add(&mut self, amount: u64) {
        self.sum = self.sum.wrapping_add(amount);
    }
}
