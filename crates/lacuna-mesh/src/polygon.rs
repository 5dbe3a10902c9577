//! Polygons in plan, judged with exact predicates.

use glam::DVec2;
use robust::{Coord, orient2d};

/// Where a point lies with respect to a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Strictly inside.
    Inside,
    /// Strictly outside.
    Outside,
    /// On an edge or at a vertex.
    OnEdge,
}

/// How two segments meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meeting {
    /// No common point.
    Apart,
    /// One common point, an end of at least one of them.
    Touching,
    /// One common point, inside both.
    Crossing,
    /// Collinear with a common stretch.
    Overlapping,
}

/// Two edges of polygons that meet where they should not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgePair {
    /// The edge with the smaller number: edges are numbered through all rings, edge i starts at vertex i.
    pub first: usize,
    /// The edge with the larger number.
    pub second: usize,
    /// How they meet.
    pub meeting: Meeting,
}

/// On which side of the line `a -> b` the point `c` lies: positive left, negative right, zero on it. The sign is exact
/// (Shewchuk 1997, adaptive predicates); the value is about twice the triangle's area.
#[must_use]
pub fn side_of_line(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Area inside a ring, square units; positive if it runs counter-clockwise. Rounded, summed from its first vertex, so
/// that large coordinates do not cost digits.
#[must_use]
pub fn signed_area(ring: &[DVec2]) -> f64 {
    let Some(&origin) = ring.first() else { return 0.0 };
    let doubled: f64 = ring.windows(2).map(|edge| (edge[0] - origin).perp_dot(edge[1] - origin)).sum();
    doubled / 2.0
}

/// Length of a ring, its closing edge included.
#[must_use]
pub fn perimeter(ring: &[DVec2]) -> f64 {
    ring_edges(ring).map(|[a, b]| a.distance(b)).sum()
}

/// Where `point` lies with respect to one ring, by the even-odd rule. Exact, in either direction of the ring.
#[must_use]
pub fn contains(ring: &[DVec2], point: DVec2) -> Location {
    let mut is_inside = false;
    for [a, b] in ring_edges(ring) {
        if is_on_segment(a, b, point) {
            return Location::OnEdge;
        }
        // Half-open in y: a vertex at the ray's height belongs to one of its two edges only.
        if (a.y > point.y) != (b.y > point.y) && (side_of_line(a, b, point) > 0.0) == (b.y > a.y) {
            is_inside = !is_inside;
        }
    }
    if is_inside { Location::Inside } else { Location::Outside }
}

/// How the segments `a`-`b` and `c`-`d` meet. Exact; a segment of length zero is a point.
#[must_use]
pub fn segments_cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Meeting {
    let (side_c, side_d) = (sign(side_of_line(a, b, c)), sign(side_of_line(a, b, d)));
    let (side_a, side_b) = (sign(side_of_line(c, d, a)), sign(side_of_line(c, d, b)));
    if side_c * side_d < 0 && side_a * side_b < 0 {
        return Meeting::Crossing;
    }
    if a != b && c != d && [side_a, side_b, side_c, side_d] == [0; 4] {
        return collinear_meeting([a, b], [c, d]);
    }
    let touches =
        is_on_segment(a, b, c) || is_on_segment(a, b, d) || is_on_segment(c, d, a) || is_on_segment(c, d, b);
    if touches { Meeting::Touching } else { Meeting::Apart }
}

/// Pairs of edges that cross, or overlap along a stretch, in the polygon made of `rings` (edges numbered through,
/// smaller first, sorted). Edges that only touch in a point are not among them: see [`find_meetings`].
#[must_use]
pub fn find_crossings(rings: &[&[DVec2]]) -> Vec<(usize, usize)> {
    let crossing = |pair: &EdgePair| pair.meeting != Meeting::Touching;
    find_meetings(rings).iter().filter(|p| crossing(p)).map(|p| (p.first, p.second)).collect()
}

/// All pairs of edges that meet where they should not in the polygon made of `rings`: crossing, overlapping or touching,
/// except that neighbours on a ring may touch. Sorted by (first, second).
///
/// Steps: (1) a binary tree of boxes over the edges in ring order, so that a box holds a stretch of the curve; (2) the
/// tree against itself, down where boxes meet; (3) exact test of the edges. About O(n log n) for curves.
#[must_use]
pub fn find_meetings(rings: &[&[DVec2]]) -> Vec<EdgePair> {
    let edges = EdgeTree::new(rings);
    let mut pairs = Vec::new();
    edges.meet_within(0, edges.segments.len(), &mut pairs);
    pairs.sort_unstable_by_key(|pair| (pair.first, pair.second));
    pairs
}

/// True if no edge of the polygon made of `rings` meets another one but its neighbours at their common vertex.
#[must_use]
pub fn is_simple(rings: &[&[DVec2]]) -> bool {
    find_meetings(rings).is_empty()
}

/// The edges of a ring, the closing one last: as many as vertices.
fn ring_edges(ring: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// True if `point` lies on the closed segment `a`-`b`. Exact.
fn is_on_segment(a: DVec2, b: DVec2, point: DVec2) -> bool {
    let is_in_box = a.min(b).cmple(point).all() && point.cmple(a.max(b)).all();
    is_in_box && side_of_line(a, b, point) == 0.0
}

/// Meeting of two collinear segments of positive length: compares their ends in lexicographic order, which along one
/// line is the order along it.
fn collinear_meeting(first: [DVec2; 2], second: [DVec2; 2]) -> Meeting {
    let key = |p: DVec2| (p.x, p.y);
    let ends = |[a, b]: [DVec2; 2]| if key(a) <= key(b) { (key(a), key(b)) } else { (key(b), key(a)) };
    let (first, second) = (ends(first), ends(second));
    let start = if first.0 >= second.0 { first.0 } else { second.0 };
    let end = if first.1 <= second.1 { first.1 } else { second.1 };
    match start.partial_cmp(&end) {
        Some(std::cmp::Ordering::Less) => Meeting::Overlapping,
        Some(std::cmp::Ordering::Equal) => Meeting::Touching,
        _ => Meeting::Apart,
    }
}

/// Box of a stretch of edges.
#[derive(Clone, Copy)]
struct Stretch {
    min: DVec2,
    max: DVec2,
}

impl Stretch {
    fn meets(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// The edges of some rings, with the boxes of a binary tree over their numbers: node `[low, high)` is split in the
/// middle, and no two nodes have the same middle.
struct EdgeTree {
    segments: Vec<[DVec2; 2]>,
    /// For each edge, the next one on its ring.
    next: Vec<usize>,
    boxes: Vec<Stretch>,
}

impl EdgeTree {
    fn new(rings: &[&[DVec2]]) -> Self {
        let mut segments = Vec::new();
        let mut next = Vec::new();
        for ring in rings {
            let first = segments.len();
            segments.extend(ring_edges(ring));
            let count = segments.len() - first;
            next.extend((0..count).map(|i| first + (i + 1) % count));
        }
        let empty = Stretch { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        let boxes = vec![empty; 2 * segments.len()];
        let mut tree = Self { segments, next, boxes };
        tree.fill_box(0, tree.segments.len());
        tree
    }

    /// Place of the node's box: leaves at even places, inner nodes at odd ones.
    fn slot(low: usize, high: usize) -> usize {
        if high - low == 1 { 2 * low } else { 2 * Self::middle(low, high) - 1 }
    }

    fn middle(low: usize, high: usize) -> usize {
        low + (high - low) / 2
    }

    fn fill_box(&mut self, low: usize, high: usize) {
        if low >= high {
            return;
        }
        let stretch = if high - low == 1 {
            let [a, b] = self.segments[low];
            Stretch { min: a.min(b), max: a.max(b) }
        } else {
            let middle = Self::middle(low, high);
            self.fill_box(low, middle);
            self.fill_box(middle, high);
            let (a, b) = (self.boxes[Self::slot(low, middle)], self.boxes[Self::slot(middle, high)]);
            Stretch { min: a.min.min(b.min), max: a.max.max(b.max) }
        };
        self.boxes[Self::slot(low, high)] = stretch;
    }

    /// Adds the meetings of edges inside one node.
    fn meet_within(&self, low: usize, high: usize, pairs: &mut Vec<EdgePair>) {
        if high - low < 2 {
            return;
        }
        let middle = Self::middle(low, high);
        self.meet_within(low, middle, pairs);
        self.meet_within(middle, high, pairs);
        self.meet_between([low, middle], [middle, high], pairs);
    }

    /// Adds the meetings between the edges of two disjoint nodes, the first before the second.
    fn meet_between(&self, first: [usize; 2], second: [usize; 2], pairs: &mut Vec<EdgePair>) {
        let box_of = |[low, high]: [usize; 2]| self.boxes[Self::slot(low, high)];
        if !box_of(first).meets(&box_of(second)) {
            return;
        }
        let count = |[low, high]: [usize; 2]| high - low;
        if count(first) == 1 && count(second) == 1 {
            pairs.extend(self.meet(first[0], second[0]));
        } else if count(first) >= count(second) {
            let middle = Self::middle(first[0], first[1]);
            self.meet_between([first[0], middle], second, pairs);
            self.meet_between([middle, first[1]], second, pairs);
        } else {
            let middle = Self::middle(second[0], second[1]);
            self.meet_between(first, [second[0], middle], pairs);
            self.meet_between(first, [middle, second[1]], pairs);
        }
    }

    fn meet(&self, first: usize, second: usize) -> Option<EdgePair> {
        let ([a, b], [c, d]) = (self.segments[first], self.segments[second]);
        let meeting = segments_cross(a, b, c, d);
        let are_neighbours = self.next[first] == second || self.next[second] == first;
        let is_allowed = meeting == Meeting::Apart || (meeting == Meeting::Touching && are_neighbours);
        (!is_allowed).then_some(EdgePair { first, second, meeting })
    }
}
