//! The triangles round each vertex.

/// Vertices whose triangles close round them, true for each of `count` vertices: every edge at the vertex has two
/// triangles that run through it in opposite directions. A vertex without triangles is not closed.
#[must_use]
pub fn closed_fans(count: usize, triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut edges: Vec<(u32, u32, bool)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b), a < b))
        .collect();
    edges.sort_unstable();
    let mut closed = vec![false; count];
    triangles.iter().flatten().for_each(|&v| closed[v as usize] = true);
    for edge in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let is_inner = matches!(edge, [(.., false), (.., true)]);
        if !is_inner {
            closed[edge[0].0 as usize] = false;
            closed[edge[0].1 as usize] = false;
        }
    }
    closed
}

/// Which triangles touch each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fans {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Fans {
    /// The fans of `count` vertices; corners are indices below `count`. O(vertices + triangles).
    #[must_use]
    pub fn new(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; count + 1];
        for &v in triangles.iter().flatten() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..count {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut members = vec![0u32; 3 * triangles.len()];
        for (t, corners) in triangles.iter().enumerate() {
            for &v in corners {
                members[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        Self { starts, triangles: members }
    }

    /// Memory of the lists, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (size_of::<u32>() * (self.starts.capacity() + self.triangles.capacity())) as u64
    }

    /// Indices of the triangles at a vertex, ascending.
    #[must_use]
    pub fn of(&self, vertex: u32) -> &[u32] {
        &self.triangles[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_is_closed_if_its_triangles_go_all_round_in_one_direction() {
        let around = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
        assert_eq!(closed_fans(5, &around), [true, false, false, false, false]);
        assert!(!closed_fans(4, &around[..2])[0], "a gap");
        assert!(!closed_fans(4, &[[0, 1, 2], [0, 2, 3], [0, 1, 3]])[0], "one is turned over");
        let fans = Fans::new(5, &around);
        assert_eq!((fans.of(0), fans.of(2), fans.of(4)), (&[0, 1, 2][..], &[0, 1][..], &[][..]));
    }
}
