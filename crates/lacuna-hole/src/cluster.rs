//! Clusters: open holes joined over shared borders (Wang et al. 2021, sec. 3.2; algorithms note C.1).

use serde::{Deserialize, Serialize};

/// When two holes of neighbouring cells belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClusterRule {
    /// They share a stretch of the border that is open in both cells.
    Interval,
    /// Both are open on the border that their cells share (the paper's adjacency).
    Cell,
}

/// Sets that merge; the smallest member names the set.
pub(crate) struct DisjointSets {
    parent: Vec<usize>,
}

impl DisjointSets {
    pub(crate) fn new(count: usize) -> Self {
        Self { parent: (0..count).collect() }
    }

    /// Smallest member of the set of `k`.
    pub(crate) fn root(&mut self, mut k: usize) -> usize {
        while self.parent[k] != k {
            self.parent[k] = self.parent[self.parent[k]];
            k = self.parent[k];
        }
        k
    }

    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }
}
