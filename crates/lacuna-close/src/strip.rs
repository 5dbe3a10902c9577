//! Overlap strips of tiles that overrun their cell: both cells take the same triangles between their two lines, so that
//! the surfaces agree there (decisions 8).
//!
//! A strip is a lattice: columns at the points of its curve, lanes side by side between the lines, as wide as the rims'
//! edges. Both cells take the lattice's rectangles that lie clear of their rims, and end on its outline.

use crate::square::mark_squares;
use crate::{BorderCurve, Curves};
use glam::DVec2;
use lacuna_grid::Side;
use lacuna_hole::{BorderMode, Curve, CurveKind, Hole, Plan, Surveys};
use serde::{Deserialize, Serialize};

/// What two cells share of the overlap along a curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strip {
    /// Lanes between the lower and the upper line.
    pub lanes: u32,
    /// For each step between neighbouring points of the curve the lanes from..to that are shared.
    pub shared: Vec<[u32; 2]>,
}

/// A point of a strip's lattice: column, and line between lanes.
pub(crate) type Node = (usize, u32);

/// More lanes than this are no overlap but a slip of the grid.
const MOST_LANES: f64 = 64.0;

impl Strip {
    /// Coordinate across the border of a line between lanes, given those of the lower and the upper line.
    pub(crate) fn line(&self, [low, high]: [f64; 2], lane: u32) -> f64 {
        match lane {
            0 => low,
            _ if lane == self.lanes => high,
            _ => low + (high - low) * (f64::from(lane) / f64::from(self.lanes)),
        }
    }

    fn step(&self, k: usize) -> [u32; 2] {
        self.shared.get(k).copied().unwrap_or([0, 0])
    }

    /// True if a step is shared from line to line.
    pub(crate) fn is_whole(&self, k: usize) -> bool {
        self.step(k) == [0, self.lanes] && self.lanes > 0
    }

    fn is_shared(&self, k: usize) -> bool {
        let [from, to] = self.step(k);
        from < to
    }

    /// True if both cells have a vertex of their own lines at a column: a shared rectangle touches it.
    pub(crate) fn touches(&self, column: usize) -> bool {
        self.is_shared(column) || column.checked_sub(1).is_some_and(|k| self.is_shared(k))
    }

    /// True if a column has vertices on all lines between lanes, not on the outer ones alone.
    fn is_split(&self, column: usize) -> bool {
        let before = column.checked_sub(1).map(|k| self.step(k));
        let after = self.shared.get(column).copied();
        match (before, after) {
            (Some(before), Some(after)) => before != after || before != [0, self.lanes],
            (one, other) => one.or(other).is_some_and(|step| step != [0, self.lanes]),
        }
    }

    /// The outline that a cell has beside the strip, from the first column to the last: on its own line where nothing is
    /// shared, round what is shared elsewhere. `columns` is their number; `from_square`, `to_square` tell where the strip
    /// goes on beyond its ends.
    pub(crate) fn outline(
        &self,
        columns: usize,
        own_is_upper: bool,
        [from_square, to_square]: [bool; 2],
    ) -> Vec<Node> {
        let own = if own_is_upper { self.lanes } else { 0 };
        let mut nodes: Vec<Node> = Vec::new();
        let mut at = 0;
        while at < columns {
            if !self.is_shared(at) {
                push(&mut nodes, (at, own));
                at += 1;
                continue;
            }
            let end = (at..).find(|&k| !self.is_shared(k)).unwrap_or(columns);
            if at == 0 && from_square {
                push(&mut nodes, (0, self.lanes - own));
            } else {
                self.low_end(at, own_is_upper).into_iter().for_each(|n| push(&mut nodes, n));
            }
            self.far_line(at, end, own).for_each(|n| push(&mut nodes, n));
            if end + 1 == columns && to_square {
                push(&mut nodes, (end, self.lanes - own));
            } else {
                let mirrored = self.mirrored().low_end(self.shared.len() - end, own_is_upper);
                let back =
                    mirrored.into_iter().rev().map(|(column, lane)| (self.shared.len() - column, lane));
                back.for_each(|n| push(&mut nodes, n));
            }
            at = end + 1;
        }
        nodes
    }

    fn mirrored(&self) -> Self {
        Self { lanes: self.lanes, shared: self.shared.iter().rev().copied().collect() }
    }

    /// Columns of the steps `from..to` on the line of the other cell, wherever that is shared.
    fn far_line(&self, from: usize, to: usize, own: u32) -> impl Iterator<Item = Node> {
        let far = self.lanes - own;
        let reaches = move |k: usize| self.step(k).contains(&far);
        let first = (from..to).find(|&k| reaches(k)).unwrap_or(to);
        let last = (from..to).rfind(|&k| reaches(k)).map_or(from, |k| k + 1);
        (first..=last).map(move |column| (column, far))
    }

    /// Round the low end of the shared run that begins with step `first`: from where it leaves the cell's own line, out to
    /// its tip and back to the other line.
    fn low_end(&self, first: usize, own_is_upper: bool) -> Vec<Node> {
        // Lanes counted from the cell's own line: those between it and the run, and those up to the run's far side.
        let near_far = |k: usize| {
            let [from, to] = self.step(k);
            if own_is_upper { [self.lanes - to, self.lanes - from] } else { [from, to] }
        };
        let lane = |l: u32| if own_is_upper { self.lanes - l } else { l };
        let mut nodes = Vec::new();
        let mut go = |column: usize, from: u32, to: u32| {
            let count = from.abs_diff(to);
            let step = |i: u32| if to > from { from + i } else { from - i };
            let is_there = |i: &u32| *i == 0 || *i == count || self.is_split(column);
            (0..=count).filter(is_there).for_each(|i| push(&mut nodes, (column, lane(step(i)))));
        };
        let touching = (first..self.shared.len()).find(|&k| near_far(k)[0] == 0).unwrap_or(first);
        (first..touching).for_each(|column| go(column, 0, 0));
        for k in (first..touching).rev() {
            go(k + 1, near_far(k + 1)[0], near_far(k)[0]);
        }
        let [near, mut reached] = near_far(first);
        go(first, near, reached);
        for k in first + 1..self.shared.len() {
            if reached == self.lanes || !self.is_shared(k) {
                break;
            }
            let far = near_far(k)[1];
            go(k, reached, far);
            reached = far;
        }
        nodes
    }

    /// The triangles of a step, the same whichever cell asks, as nodes counter-clockwise from above.
    pub(crate) fn triangles(&self, k: usize, side: Side) -> Vec<[Node; 3]> {
        let [from, to] = self.step(k);
        let split = [self.is_split(k), self.is_split(k + 1)];
        let rectangle = |a: [u32; 2], b: [u32; 2]| {
            // Lower and upper line, at the step's first and second column.
            let triangles = step_triangles(side, [(k, a[0]), (k + 1, b[0])], [(k, a[1]), (k + 1, b[1])]);
            triangles.into_iter().filter(|[p, q, r]| p != q && q != r && r != p)
        };
        if from >= to {
            return Vec::new();
        }
        let middle = self.lanes / 2;
        match split {
            [false, false] => rectangle([0, self.lanes], [0, self.lanes]).collect(),
            [true, true] => (from..to).flat_map(|l| rectangle([l, l + 1], [l, l + 1])).collect(),
            // A fan from each of the two vertices of the column that is not split; they meet in the middle.
            [first_split, _] => {
                let fan = |l: u32| {
                    let apex = if l < middle { 0 } else { self.lanes };
                    let (split, whole) = ([l, l + 1], [apex, apex]);
                    if first_split { rectangle(split, whole) } else { rectangle(whole, split) }
                };
                let (split, whole) = ([middle, middle], [0, self.lanes]);
                let between = if first_split { rectangle(split, whole) } else { rectangle(whole, split) };
                (0..self.lanes).flat_map(fan).chain(between).collect()
            }
        }
    }
}

fn push(nodes: &mut Vec<Node>, node: Node) {
    if nodes.last() != Some(&node) {
        nodes.push(node);
    }
}

/// Marks, in every shared curve, what both cells take of the strip between their lines, and then the squares at grid
/// corners.
pub(crate) fn mark_strips(surveys: &Surveys, plan: &Plan, curves: &mut Curves) {
    if plan.fit.mode != BorderMode::Overrun {
        return;
    }
    for (k, curve) in plan.curves.iter().enumerate() {
        if curve.kind == CurveKind::Shared {
            curves.curves[k].strip = strip(surveys, plan, curve, &curves.curves[k]);
        }
    }
    mark_squares(surveys, plan, curves);
}

/// The lower and the upper line of a border, coordinates across it.
pub(crate) fn lines(plan: &Plan, curve: &Curve) -> [f64; 2] {
    let sides = [curve.border.side, curve.border.side.opposite()];
    let domains = curve.border.cells().map(|cell| plan.domains.get(&cell));
    let known = domains.iter().zip(sides).filter_map(|(d, side)| d.map(|d| d.side(side).line));
    known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], line| [low.min(line), high.max(line)])
}

fn strip(surveys: &Surveys, plan: &Plan, curve: &Curve, points: &BorderCurve) -> Strip {
    let side = curve.border.side;
    let [low, high] = lines(plan, curve);
    let lanes = ((high - low) / points.spacing_m).ceil().clamp(1.0, MOST_LANES);
    let lane_m = (high - low) / lanes;
    let slack_m = (0.25 * (high - low)).min(0.5 * lane_m);
    let columns: Vec<f64> = points.inner.iter().map(|p| side.along(p.truncate())).collect();
    let mut clear = vec![vec![true; lanes as usize]; columns.len().saturating_sub(1)];
    for [a, b] in rims_beside(surveys, plan, curve, [low - slack_m, high + slack_m]) {
        let reach = |p: f64, q: f64| [p.min(q) - slack_m, p.max(q) + slack_m];
        let along = reach(side.along(a), side.along(b));
        let across =
            reach(side.across(a) - low, side.across(b) - low).map(|x| (x / lane_m).clamp(0.0, lanes));
        let first = columns.partition_point(|&x| x < along[0]).saturating_sub(1);
        let last = columns.partition_point(|&x| x <= along[1]).min(clear.len()).max(first);
        let blocked = across[0].floor() as usize..across[1].ceil() as usize;
        clear[first.min(last)..last].iter_mut().for_each(|step| step[blocked.clone()].fill(false));
    }
    Strip { lanes: lanes as u32, shared: shared_lanes(&clear, lanes as u32) }
}

/// Ends of the rim edges of a curve's holes between two lines.
fn rims_beside(surveys: &Surveys, plan: &Plan, curve: &Curve, [low, high]: [f64; 2]) -> Vec<[DVec2; 2]> {
    let side = curve.border.side;
    let holes = curve.holes.iter().map(|&h| &plan.holes[h as usize]);
    let of_hole = |hole: &Hole| {
        surveys.get(&hole.cell).map_or_else(Vec::new, |survey| {
            let ends = hole.rim_edges(survey).map(|e| [survey.from(e).truncate(), survey.to(e).truncate()]);
            let is_beside = |[a, b]: &[DVec2; 2]| {
                let [a, b] = [side.across(*a), side.across(*b)];
                a.max(b) >= low && a.min(b) <= high
            };
            ends.filter(is_beside).collect()
        })
    };
    holes.flat_map(of_hole).collect()
}

/// What is shared of the clear rectangles, step by step: whole steps, and from their ends outward one run of lanes a step
/// that joins the one before, as far as it leaves no part of the overlap between itself and a line.
fn shared_lanes(clear: &[Vec<bool>], lanes: u32) -> Vec<[u32; 2]> {
    let mut shared: Vec<[u32; 2]> =
        clear.iter().map(|c| if c.iter().all(|&free| free) { [0, lanes] } else { [0, 0] }).collect();
    let whole: Vec<usize> = (0..shared.len()).filter(|&k| shared[k] == [0, lanes]).collect();
    for &k in &whole {
        if k + 1 < shared.len() && shared[k + 1] == [0, 0] {
            add_wing(clear, lanes, &mut shared, (k + 1)..clear.len());
        }
    }
    for &k in &whole {
        if k > 0 && shared[k - 1] == [0, 0] {
            add_wing(clear, lanes, &mut shared, (0..k).rev());
        }
    }
    shared
}

/// Adds steps in order until none is left that joins the one before, or the next run comes near.
fn add_wing(
    clear: &[Vec<bool>],
    lanes: u32,
    shared: &mut [[u32; 2]],
    steps: impl Iterator<Item = usize> + Clone,
) {
    let mut before = [0, lanes];
    let ahead = steps.clone().skip(1).map(Some).chain([None]);
    for (k, next) in steps.zip(ahead) {
        // A step stays open between two runs: their outlines must not meet.
        if next.is_some_and(|n| shared[n] != [0, 0]) || shared[k] != [0, 0] {
            return;
        }
        let least = u32::from(before[0] > 0);
        let most = lanes - u32::from(before[1] < lanes);
        let runs = runs(&clear[k]).into_iter().map(|[from, to]| [from.max(least), to.min(most)]);
        let joins = runs.filter(|r| r[0].max(before[0]) < r[1].min(before[1]));
        // Of runs of equal width the lower one.
        let Some(run) = joins.max_by(|a, b| (a[1] - a[0]).cmp(&(b[1] - b[0])).then(b[0].cmp(&a[0]))) else {
            return;
        };
        shared[k] = run;
        before = run;
    }
}

/// Maximal runs of clear lanes.
fn runs(clear: &[bool]) -> Vec<[u32; 2]> {
    let mut runs = Vec::new();
    let mut from = None;
    for (l, &free) in clear.iter().chain([&false]).enumerate() {
        match (free, from) {
            (true, None) => from = Some(l as u32),
            (false, Some(start)) => {
                runs.push([start, l as u32]);
                from = None;
            }
            _ => {}
        }
    }
    runs
}

/// The two triangles of a step of a strip, counter-clockwise from above, in terms of its corners: lower and upper line
/// (by the coordinate across), first and second point (by the coordinate along).
fn step_triangles<T: Copy>(side: Side, low: [T; 2], high: [T; 2]) -> [[T; 3]; 2] {
    let [a, b] = low;
    let [d, c] = high;
    if side.is_horizontal() { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn clear() -> impl Strategy<Value = Vec<Vec<bool>>> {
        (1_usize..6, 1_usize..14).prop_flat_map(|(lanes, steps)| {
            // Whole steps are as frequent as others.
            let step = prop_oneof![
                proptest::collection::vec(proptest::bool::weighted(0.8), lanes),
                Just(vec![true; lanes])
            ];
            proptest::collection::vec(step, steps)
        })
    }

    fn place((column, lane): Node) -> DVec2 {
        DVec2::new(column as f64, f64::from(lane))
    }

    proptest! {
        #[test]
        fn outlines_and_triangles_fill_the_overlap(clear in clear(), ends in any::<[bool; 2]>()) {
            let lanes = clear[0].len() as u32;
            let strip = Strip { lanes, shared: shared_lanes(&clear, lanes) };
            for (step, run) in clear.iter().zip(&strip.shared) {
                prop_assert!((run[0]..run[1]).all(|l| step[l as usize]), "a blocked rectangle is shared");
            }
            let steps = clear.len();
            // A strip ends in a square only where it is whole.
            let squares = [ends[0] && strip.is_whole(0), ends[1] && strip.is_whole(steps - 1)];
            let triangles: Vec<[Node; 3]> = (0..steps).flat_map(|k| strip.triangles(k, Side::South)).collect();
            let area = |[a, b, c]: [Node; 3]| (place(b) - place(a)).perp_dot(place(c) - place(a)) / 2.0;
            prop_assert!(triangles.iter().all(|&t| area(t) > 0.0));
            let shared_area: f64 = triangles.iter().map(|&t| area(t)).sum();
            let rectangles: u32 = strip.shared.iter().map(|s| s[1] - s[0]).sum();
            prop_assert!((shared_area - f64::from(rectangles)).abs() < 1e-9);
            let edges: Vec<[Node; 2]> =
                triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            let undirected = |[a, b]: [Node; 2]| if a < b { [a, b] } else { [b, a] };
            let border: BTreeSet<[Node; 2]> =
                edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a])).map(|&e| undirected(e)).collect();
            for own_is_upper in [false, true] {
                let own = if own_is_upper { lanes } else { 0 };
                let nodes = strip.outline(steps + 1, own_is_upper, squares);
                let outline: Vec<[Node; 2]> = nodes.windows(2).map(|w| [w[0], w[1]]).collect();
                // What lies between the outline and the other cell's line.
                let beside: f64 = outline.iter().map(|&[a, b]| {
                    let height = (place(a).y + place(b).y) / 2.0;
                    (place(b).x - place(a).x) * if own_is_upper { height } else { f64::from(lanes) - height }
                }).sum();
                let whole = (steps as u32 * lanes) as f64;
                prop_assert!((beside + shared_area - whole).abs() < 1e-9, "{strip:?} {nodes:?}");
                let is_on_own = |e: &[Node; 2]| e.iter().all(|n| n.1 == own);
                let is_in_square = |e: &[Node; 2]| {
                    (squares[0] && e.iter().all(|n| n.0 == 0)) || (squares[1] && e.iter().all(|n| n.0 == steps))
                };
                let walked: BTreeSet<[Node; 2]> =
                    outline.iter().copied().filter(|e| !is_on_own(e)).map(undirected).collect();
                let expected: BTreeSet<[Node; 2]> =
                    border.iter().copied().filter(|e| !is_on_own(e) && !is_in_square(e)).collect();
                prop_assert_eq!(walked, expected, "{:?} {:?}", strip, nodes);
            }
        }
    }

    #[test]
    fn wings_go_as_far_as_they_leave_nothing_behind() {
        let o = true;
        let x = false;
        for (name, clear, expected) in [
            ("one lane", vec![vec![o], vec![x], vec![o]], vec![[0, 1], [0, 0], [0, 1]]),
            (
                "a rim that runs out",
                vec![vec![o, o, o], vec![o, o, x], vec![o, x, x], vec![x, x, x]],
                vec![[0, 3], [0, 2], [0, 1], [0, 0]],
            ),
            (
                "no way back to the line",
                vec![vec![o, o, o], vec![x, o, o], vec![o, o, o], vec![x, x, x]],
                vec![[0, 3], [0, 0], [0, 3], [0, 0]],
            ),
            ("nothing from line to line", vec![vec![o, x], vec![x, o]], vec![[0, 0], [0, 0]]),
            (
                "a tip between the lines",
                vec![vec![o, o, o], vec![x, o, x], vec![x, x, x]],
                vec![[0, 3], [1, 2], [0, 0]],
            ),
        ] {
            assert_eq!(shared_lanes(&clear, clear[0].len() as u32), expected, "{name}");
        }
    }

    #[test]
    fn steps_face_up_on_both_kinds_of_border() {
        for side in [Side::South, Side::West] {
            let at = |along: f64, across: f64| side.point(along, across);
            for [a, b, c] in
                step_triangles(side, [at(0.0, -1.0), at(2.0, -1.0)], [at(0.0, 1.0), at(2.0, 1.0)])
            {
                assert!((b - a).perp_dot(c - a) > 0.0, "{side:?}");
            }
        }
    }
}
