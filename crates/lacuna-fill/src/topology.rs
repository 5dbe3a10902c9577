//! Triangles with their neighbours, and the three local changes: split a face, split an edge, flip an edge.

/// No half-edge: the other side of a boundary edge.
pub(crate) const NONE: u32 = u32::MAX;

/// Triangles as half-edges: `3 t + k` runs from corner `k` of triangle `t` to corner `k + 1`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Topology {
    /// Vertex at which each half-edge starts.
    pub(crate) origin: Vec<u32>,
    /// The opposite half-edge, or [`NONE`].
    pub(crate) twin: Vec<u32>,
}

/// The half-edge after `h` in its triangle.
pub(crate) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before `h` in its triangle.
pub(crate) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Topology {
    /// Joins triangles over edges that two of them use in opposite directions.
    pub(crate) fn new(triangles: &[[u32; 3]]) -> Self {
        let origin: Vec<u32> = triangles.iter().flatten().copied().collect();
        let mut topology = Self { twin: vec![NONE; origin.len()], origin };
        let mut edges: Vec<(u32, u32, u32)> = (0..topology.origin.len() as u32)
            .map(|h| {
                let (a, b) = (topology.start(h), topology.end(h));
                (a.min(b), a.max(b), h)
            })
            .collect();
        edges.sort_unstable();
        for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [(.., h), (.., t)] = *group
                && topology.start(h) != topology.start(t)
            {
                topology.join(h, t);
            }
        }
        topology
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.origin.len() / 3
    }

    pub(crate) fn start(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }

    pub(crate) fn end(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }

    /// The corner opposite to half-edge `h`.
    pub(crate) fn apex(&self, h: u32) -> u32 {
        self.origin[prev(h) as usize]
    }

    pub(crate) fn twin(&self, h: u32) -> Option<u32> {
        let t = self.twin[h as usize];
        (t != NONE).then_some(t)
    }

    pub(crate) fn corners(&self, t: u32) -> [u32; 3] {
        let h = 3 * t as usize;
        [self.origin[h], self.origin[h + 1], self.origin[h + 2]]
    }

    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
        self.origin.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
    }

    /// For each vertex one half-edge that starts there; the first one of a boundary fan if the vertex is on the
    /// boundary, so that [`Topology::star`] meets all of the fan.
    pub(crate) fn leaving(&self, vertices: usize) -> Vec<u32> {
        let mut leaving = vec![NONE; vertices];
        for h in 0..self.origin.len() as u32 {
            let slot = &mut leaving[self.start(h) as usize];
            if *slot == NONE || self.twin(h).is_none() {
                *slot = h;
            }
        }
        leaving
    }

    /// Half-edges that start where `first` starts, counter-clockwise, until the boundary or round once.
    pub(crate) fn star(&self, first: u32) -> impl Iterator<Item = u32> + '_ {
        let mut here = (first != NONE).then_some(first);
        std::iter::from_fn(move || {
            let h = here?;
            here = self.twin(prev(h)).filter(|&t| t != first);
            Some(h)
        })
    }

    /// Splits a triangle into three at vertex `v`; returns the three triangles.
    pub(crate) fn split_face(&mut self, t: u32, v: u32) -> [u32; 3] {
        let [a, b, c] = self.corners(t);
        let h = 3 * t;
        let (bc, ca) = (self.twin[h as usize + 1], self.twin[h as usize + 2]);
        let one = self.push([b, c, v]);
        let two = self.push([c, a, v]);
        self.origin[h as usize..h as usize + 3].copy_from_slice(&[a, b, v]);
        self.join(3 * one, bc);
        self.join(3 * two, ca);
        self.join(h + 1, 3 * one + 2);
        self.join(3 * one + 1, 3 * two + 2);
        self.join(3 * two + 1, h + 2);
        [t, one, two]
    }

    /// Splits an edge, and the one or two triangles at it, at vertex `v`; returns these triangles.
    pub(crate) fn split_edge(&mut self, h: u32, v: u32) -> Vec<u32> {
        let twin = self.twin(h);
        let far = self.split_side(h, v);
        let Some(t) = twin else { return vec![h / 3, far / 3] };
        let far_twin = self.split_side(t, v);
        self.join(h, far_twin);
        self.join(t, far);
        vec![h / 3, far / 3, t / 3, far_twin / 3]
    }

    /// Splits the triangle of `h` only: `h` then ends at `v`; returns the half-edge from `v` to the old end.
    fn split_side(&mut self, h: u32, v: u32) -> u32 {
        let (b, c) = (self.end(h), self.apex(h));
        let outer = self.twin[next(h) as usize];
        let far = 3 * self.push([v, b, c]);
        self.origin[next(h) as usize] = v;
        self.join(far + 1, outer);
        self.join(far + 2, next(h));
        far
    }

    /// Flips the edge of half-edge `h`, which must have a twin, in its two triangles. Afterwards `h` runs from the
    /// twin's apex to the old apex of `h`.
    pub(crate) fn flip(&mut self, h: u32) {
        let t = self.twin[h as usize];
        let (hn, hp, tn, tp) = (next(h), prev(h), next(t), prev(t));
        let (a, b, c, d) = (self.start(h), self.start(t), self.start(hp), self.start(tp));
        let [bc, ca, ad, db] = [hn, hp, tn, tp].map(|e| self.twin[e as usize]);
        for (e, v) in [(h, d), (hn, c), (hp, a), (t, c), (tn, d), (tp, b)] {
            self.origin[e as usize] = v;
        }
        self.join(hn, ca);
        self.join(hp, ad);
        self.join(tn, db);
        self.join(tp, bc);
    }

    fn join(&mut self, h: u32, t: u32) {
        self.twin[h as usize] = t;
        if t != NONE {
            self.twin[t as usize] = h;
        }
    }

    fn push(&mut self, corners: [u32; 3]) -> u32 {
        self.origin.extend(corners);
        self.twin.extend([NONE; 3]);
        self.triangle_count() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(topology: &Topology) -> Vec<[u32; 3]> {
        let mut all: Vec<[u32; 3]> = topology
            .triangles()
            .into_iter()
            .map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap())
            .collect();
        all.sort_unstable();
        all
    }

    fn assert_twins(topology: &Topology) {
        let fresh = Topology::new(&topology.triangles());
        assert_eq!(fresh.twin, topology.twin);
    }

    #[test]
    fn every_change_keeps_the_twins_right() {
        let mut square = Topology::new(&[[0, 1, 2], [0, 2, 3]]);
        square.split_face(0, 4);
        assert_twins(&square);
        let diagonal = (0..square.origin.len() as u32).find(|&h| square.start(h) == 0 && square.end(h) == 2);
        let diagonal = diagonal.unwrap();
        square.flip(diagonal);
        assert_twins(&square);
        assert_eq!(sorted(&square), [[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 3, 4]]);
        let side = (0..square.origin.len() as u32).find(|&h| square.twin(h).is_none()).unwrap();
        square.split_edge(side, 5);
        assert_twins(&square);
        let inner = (0..square.origin.len() as u32).find(|&h| square.twin(h).is_some()).unwrap();
        square.split_edge(inner, 6);
        assert_twins(&square);
        assert_eq!(square.triangle_count(), 7);
    }

    #[test]
    fn stars_meet_every_triangle_of_a_vertex_once() {
        let fan = Topology::new(&[[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 4]]);
        let leaving = fan.leaving(5);
        let counts: Vec<usize> = (0..5).map(|v| fan.star(leaving[v]).count()).collect();
        assert_eq!(counts, [3, 2, 3, 3, 1]);
    }
}
