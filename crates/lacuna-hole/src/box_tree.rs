//! Boxes that are asked many times which of them touch another one: a tile can have 1e5 holes.

use glam::DVec3;
use lacuna_mesh::Bounds;

/// Most boxes that are not divided further.
const LEAF: usize = 8;

/// A binary tree over boxes, halved at the median of their middles along the longest axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxTree {
    boxes: Vec<Bounds>,
    /// Numbers of the boxes, node by node.
    order: Vec<u32>,
    /// Preorder: the left child follows its parent.
    nodes: Vec<Node>,
}

/// A stretch of the order and the box round all its boxes.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
    /// The right child; 0 for a leaf.
    right: u32,
}

impl BoxTree {
    /// Builds the tree in O(n log n); boxes are numbered in the order they come in.
    pub(crate) fn new(boxes: impl IntoIterator<Item = Bounds>) -> Self {
        let boxes: Vec<Bounds> = boxes.into_iter().collect();
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self { boxes, order, nodes: Vec::new() };
        if !tree.boxes.is_empty() {
            tree.add_node(0, tree.boxes.len());
        }
        tree
    }

    /// Numbers of all boxes that touch a box, ascending.
    pub(crate) fn touching(&self, place: &Bounds) -> Vec<usize> {
        let mut found = Vec::new();
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(k) = stack.pop() {
            let node = self.nodes[k];
            if !touch(&node.bounds, place) {
                continue;
            }
            if node.right == 0 {
                let items = &self.order[node.first as usize..(node.first + node.count) as usize];
                found.extend(items.iter().map(|&b| b as usize).filter(|&b| touch(&self.boxes[b], place)));
            } else {
                stack.extend([node.right as usize, k + 1]);
            }
        }
        found.sort_unstable();
        found
    }

    fn add_node(&mut self, first: usize, count: usize) {
        let items = &mut self.order[first..first + count];
        let bounds = items.iter().fold(Bounds::EMPTY, |all, &b| all.union(&self.boxes[b as usize]));
        let k = self.nodes.len();
        self.nodes.push(Node { bounds, first: first as u32, count: count as u32, right: 0 });
        if count <= LEAF {
            return;
        }
        let boxes = &self.boxes;
        // Twice the middle will do to compare.
        let middle = |b: u32| boxes[b as usize].min + boxes[b as usize].max;
        let (low, high) = items
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &b| (l.min(middle(b)), h.max(middle(b))));
        let axis = longest_axis(high - low);
        let half = count / 2;
        items.select_nth_unstable_by(half, |&a, &b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b))
        });
        self.add_node(first, half);
        self.nodes[k].right = self.nodes.len() as u32;
        self.add_node(first + half, count - half);
    }
}

fn longest_axis(size: DVec3) -> usize {
    (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best })
}

fn touch(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(count: usize) -> impl Strategy<Value = Vec<Bounds>> {
        // Whole numbers, so that many boxes touch exactly and many are alike.
        let number = || (0..12i32).prop_map(f64::from);
        let corner = || (number(), number(), number()).prop_map(DVec3::from);
        let one = (corner(), corner()).prop_map(|(a, b)| Bounds { min: a.min(b), max: a.max(b) });
        prop::collection::vec(one, 0..count)
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_a_look_at_every_box_finds(all in boxes(120), places in boxes(8)) {
            let tree = BoxTree::new(all.iter().copied());
            for place in &places {
                let expected: Vec<usize> = (0..all.len()).filter(|&k| touch(&all[k], place)).collect();
                prop_assert_eq!(tree.touching(place), expected);
            }
        }
    }
}
