//! The outlines that open edges and cuts along the border lines make together: each lies in one cell.

use crate::open_edges::{OpenEdges, Place};
use crate::plan::Curve;
use glam::DVec2;
use lacuna_grid::{CellId, CornerId, Side};
use lacuna_mesh::{clockwise_order, position_bits, signed_area};
use std::collections::{BTreeMap, BTreeSet};

/// Where cuts begin and end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Node {
    Vertex(Place),
    Corner(CornerId),
}

/// A closing curve as an edge between two nodes. Index 0 stands for its low end, or for the walk from low to high.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    pub(crate) curve: Curve,
    pub(crate) nodes: [Node; 2],
    /// Where the nodes are.
    pub(crate) ends: [DVec2; 2],
    /// What is seen of the curve from each end.
    pub(crate) toward: [DVec2; 2],
    /// Whose hole lies to the left of each walk, and on which of its sides the cut is; none beyond the area.
    pub(crate) cells: [Option<(CellId, Side)>; 2],
}

/// A step of a walk with the missing surface on the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Step {
    /// Along an open edge, by its place in the list.
    Edge(usize),
    /// Along a cut, and which way.
    Cut(usize, usize),
}

/// A closed walk.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    pub(crate) steps: Vec<Step>,
    /// Area inside, square metres; negative round a piece of surface.
    pub(crate) area_m2: f64,
}

/// All faces that touch a cut or a start, and the face of every step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faces {
    pub(crate) list: Vec<Face>,
    pub(crate) of: BTreeMap<Step, usize>,
}

/// Walks all faces from the cuts and the given open edges: at every node the next edge clockwise from where the walk came,
/// which keeps to one sector of the hole. A walk that ends, or runs into another one, makes no face.
pub(crate) fn faces(open: &OpenEdges, cuts: &[Cut], starts: impl Iterator<Item = usize>) -> Faces {
    let mut at_node: BTreeMap<Node, Vec<Step>> = BTreeMap::new();
    for (c, cut) in cuts.iter().enumerate() {
        for way in [0, 1].into_iter().filter(|&way| cut.cells[way].is_some()) {
            at_node.entry(cut.nodes[way]).or_default().push(Step::Cut(c, way));
        }
    }
    let walker = Walker { open, cuts, at_node };
    let from_cuts = walker.at_node.values().flatten().copied().collect::<BTreeSet<Step>>();
    let mut faces = Faces::default();
    let mut seen: BTreeSet<Step> = BTreeSet::new();
    for first in from_cuts.into_iter().chain(starts.map(Step::Edge)) {
        if seen.contains(&first) {
            continue;
        }
        let mut steps = vec![first];
        seen.insert(first);
        let closed = loop {
            match walker.next(steps[steps.len() - 1]) {
                Some(step) if step == first => break true,
                Some(step) if seen.insert(step) => steps.push(step),
                _ => break false,
            }
        };
        if closed {
            let outline: Vec<DVec2> = steps.iter().map(|s| walker.start(*s)).collect();
            faces.of.extend(steps.iter().map(|s| (*s, faces.list.len())));
            faces.list.push(Face { steps, area_m2: signed_area(&outline) });
        }
    }
    faces
}

struct Walker<'a> {
    open: &'a OpenEdges,
    cuts: &'a [Cut],
    at_node: BTreeMap<Node, Vec<Step>>,
}

impl Walker<'_> {
    fn start(&self, step: Step) -> DVec2 {
        match step {
            Step::Edge(e) => self.open.list[e].ends[0].truncate(),
            Step::Cut(c, way) => self.cuts[c].ends[way],
        }
    }

    /// A point on the way of a step, seen from its start.
    fn ahead(&self, step: Step) -> DVec2 {
        match step {
            Step::Edge(e) => self.open.list[e].ends[1].truncate(),
            Step::Cut(c, way) => self.cuts[c].toward[way],
        }
    }

    fn next(&self, step: Step) -> Option<Step> {
        let (node, origin, back) = match step {
            Step::Edge(e) => {
                let [from, to] = self.open.list[e].ends;
                (Node::Vertex(position_bits(to)), to.truncate(), from.truncate())
            }
            Step::Cut(c, way) => {
                let cut = &self.cuts[c];
                (cut.nodes[1 - way], cut.ends[1 - way], cut.toward[1 - way])
            }
        };
        let edges = match node {
            Node::Vertex(place) => self.open.starting_at(place).map(Step::Edge).collect::<Vec<_>>(),
            Node::Corner(_) => Vec::new(),
        };
        let turns_back = |s: &Step| matches!((step, *s), (Step::Cut(a, _), Step::Cut(b, _)) if a == b);
        let cuts = self.at_node.get(&node).into_iter().flatten().copied();
        edges
            .into_iter()
            .chain(cuts)
            .filter(|s| !turns_back(s))
            .min_by(|a, b| clockwise_order(origin, back, self.ahead(*a), self.ahead(*b)).then(a.cmp(b)))
    }
}
