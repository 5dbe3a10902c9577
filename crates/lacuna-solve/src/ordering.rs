//! A fill-reducing order for the reference solver.

use crate::SparseSymmetric;
use std::collections::VecDeque;

/// Parts of at most this many unknowns are not dissected further.
const LEAF: usize = 48;

/// Orders the unknowns by nested dissection: a part's middle breadth-first level separates the levels before it from
/// the levels behind it and is eliminated after both. Level sets start at a vertex far from everything (two sweeps);
/// ties go to the smallest index, so equal patterns give equal orders. Returns unknowns in the order of elimination.
///
/// Source: George 1973, nested dissection; level-set separators after George & Liu 1978.
pub(crate) fn nested_dissection(matrix: &SparseSymmetric) -> Vec<u32> {
    let graph = Graph::new(matrix);
    let order = matrix.order();
    let mut state = State { part: vec![0; order], level: vec![0; order], parts: 1 };
    let mut reversed: Vec<u32> = Vec::with_capacity(order);
    let mut stack: Vec<Vec<u32>> = vec![(0..order as u32).collect()];
    while let Some(members) = stack.pop() {
        match (members.len() > LEAF).then(|| state.dissect(&graph, &members)).flatten() {
            None => reversed.extend(members.iter().rev()),
            Some(cut) => {
                reversed.extend(cut.separator.iter().rev());
                stack.extend(cut.halves);
            }
        }
    }
    reversed.reverse();
    reversed
}

/// Neighbours of every unknown, both triangles of the matrix.
struct Graph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Graph {
    fn new(matrix: &SparseSymmetric) -> Self {
        let order = matrix.order();
        let mut starts = vec![0usize; order + 1];
        for_each_pair(matrix, |i, j| {
            starts[i + 1] += 1;
            starts[j + 1] += 1;
        });
        for i in 0..order {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![0u32; starts[order]];
        for_each_pair(matrix, |i, j| {
            neighbours[next[i]] = j as u32;
            neighbours[next[j]] = i as u32;
            next[i] += 1;
            next[j] += 1;
        });
        Self { starts, neighbours }
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.neighbours[self.starts[v as usize]..self.starts[v as usize + 1]]
    }
}

fn for_each_pair(matrix: &SparseSymmetric, mut visit: impl FnMut(usize, usize)) {
    for j in 0..matrix.order() {
        for (i, _) in matrix.column(j) {
            if i as usize != j {
                visit(i as usize, j);
            }
        }
    }
}

struct Cut {
    separator: Vec<u32>,
    halves: [Vec<u32>; 2],
}

/// Which part each unknown belongs to while parts are cut (`part`), and its breadth-first level in it.
struct State {
    part: Vec<u32>,
    level: Vec<u32>,
    parts: u32,
}

impl State {
    /// Cuts a part in two along a level; `None` if that would not make it smaller.
    fn dissect(&mut self, graph: &Graph, members: &[u32]) -> Option<Cut> {
        self.parts += 1;
        for &v in members {
            self.part[v as usize] = self.parts;
        }
        let reached = self.levels_from(graph, members[0]);
        if reached.len() < members.len() {
            return Some(self.split_components(members, &reached));
        }
        let far = *reached.last()?;
        let reached = self.levels_from(graph, far);
        let middle = self.level[reached[reached.len() / 2] as usize];
        let depth = self.level[*reached.last()? as usize];
        if depth < 2 {
            return None;
        }
        let middle = middle.clamp(1, depth - 1);
        let pick = |keep: &dyn Fn(u32) -> bool| -> Vec<u32> {
            members.iter().copied().filter(|&v| keep(self.level[v as usize])).collect()
        };
        Some(Cut {
            separator: pick(&|l| l == middle),
            halves: [pick(&|l| l < middle), pick(&|l| l > middle)],
        })
    }

    /// Breadth-first levels within the newest part; returns the vertices in the order of the visit.
    fn levels_from(&mut self, graph: &Graph, start: u32) -> Vec<u32> {
        let here = self.part[start as usize];
        self.parts += 1;
        let seen = self.parts;
        let mut queue = VecDeque::from([start]);
        let mut order = vec![];
        self.part[start as usize] = seen;
        self.level[start as usize] = 0;
        while let Some(v) = queue.pop_front() {
            order.push(v);
            for &w in graph.of(v) {
                if self.part[w as usize] == here {
                    self.part[w as usize] = seen;
                    self.level[w as usize] = self.level[v as usize] + 1;
                    queue.push_back(w);
                }
            }
        }
        order
    }

    fn split_components(&self, members: &[u32], reached: &[u32]) -> Cut {
        let inside = self.part[reached[0] as usize];
        let (a, b) = members.iter().partition(|&&v| self.part[v as usize] == inside);
        Cut { separator: vec![], halves: [a, b] }
    }
}
