//! Open holes as closed walks over rim chains and the perimeter: Weiler-Atherton with the hole on the left (algorithms
//! note B.4).

use crate::CellSurvey;
use crate::box_tree::BoxTree;
use crate::coverage::{Coverage, End, RimChain, uncovered};
use glam::DVec3;
use lacuna_mesh::Bounds;

/// A piece of an open hole's outline, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RawPiece {
    /// Index of a rim chain.
    Chain(usize),
    /// A stretch of the perimeter, from and to (to > from, possibly beyond the perimeter's end).
    Border(f64, f64),
    /// A jump over a cut inside the tile, from one chain's end to the next one's start; of no length where a rim touches
    /// the border in a vertex.
    Bridge,
}

/// The open holes of a cell and what did not fit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walked {
    pub(crate) holes: Vec<Vec<RawPiece>>,
    /// Chains whose ends lie where another sheet of surface covers the border: outlines of overhangs, not holes.
    pub(crate) stray_chains: usize,
    /// Uncovered stretches without a chain at both ends: nothing can be said about them.
    pub(crate) broken: Vec<(f64, f64)>,
}

/// How a chain's end is followed.
#[derive(Clone, Copy)]
struct Link {
    border: Option<(f64, f64)>,
    next: usize,
}

/// Walks all open holes of a cell. `bridges` are the pairs of chains, best first, that go on over a cut inside the tile.
pub(crate) fn walk(
    survey: &CellSurvey,
    coverage: &Coverage,
    perimeter_m: f64,
    gap_m: f64,
    bridges: &[(usize, usize)],
) -> Walked {
    let mut walked = Walked::default();
    if coverage.covered.is_empty() && coverage.chains.is_empty() {
        walked.holes.push(vec![RawPiece::Border(0.0, perimeter_m)]);
        return walked;
    }
    let mut links: Vec<Option<Link>> = vec![None; coverage.chains.len()];
    let mut taken = vec![false; coverage.chains.len()];
    let ends = BorderEnds::new(coverage, perimeter_m, |c| c.end);
    let starts = BorderEnds::new(coverage, perimeter_m, |c| c.start);
    for (from, to) in uncovered(&coverage.covered, perimeter_m, gap_m) {
        let end = ends.nearest(from, gap_m, |k| links[k].is_some());
        let start = starts.nearest(to, gap_m, |k| taken[k]);
        if let (Some(end), Some(start)) = (end, start) {
            links[end] = Some(Link { border: Some((from, to)), next: start });
            taken[start] = true;
        } else {
            walked.broken.push((from, to));
        }
    }
    // A rim that touches covered border in a vertex is in two chains there, with nothing uncovered between them.
    let touching = pairs_on_border(survey, coverage, gap_m);
    for &(a, b) in touching.iter().chain(bridges) {
        if links[a].is_none() && !taken[b] {
            links[a] = Some(Link { border: None, next: b });
            taken[b] = true;
        }
    }
    link_narrow_mouths(coverage, perimeter_m, gap_m, &mut links, &mut taken);
    follow(&links, &mut walked);
    walked
}

/// Ends (or starts) of the rim chains that lie on the border, by perimeter parameter.
struct BorderEnds<'a> {
    coverage: &'a Coverage,
    perimeter_m: f64,
    /// Chain and parameter.
    ends: Vec<(usize, f64)>,
    tree: BoxTree,
}

impl<'a> BorderEnds<'a> {
    fn new(coverage: &'a Coverage, perimeter_m: f64, end: impl Fn(&RimChain) -> End) -> Self {
        let on_border = |(k, chain): (usize, &RimChain)| match end(chain) {
            End::Border(_, at) => Some((k, at.rem_euclid(perimeter_m))),
            End::Cut(_) => None,
        };
        let ends: Vec<(usize, f64)> = coverage.chains.iter().enumerate().filter_map(on_border).collect();
        let tree = BoxTree::new(ends.iter().map(|e| Bounds { min: DVec3::X * e.1, max: DVec3::X * e.1 }));
        Self { coverage, perimeter_m, ends, tree }
    }

    /// The chain with an end within `gap_m` of parameter `s`; the nearest, then the one of the longest loop, then the
    /// first.
    fn nearest(&self, s: f64, gap_m: f64, used: impl Fn(usize) -> bool) -> Option<usize> {
        let reach_m = gap_m.max(1e-6);
        let distance = |at: f64| {
            let d = (at - s).rem_euclid(self.perimeter_m);
            d.min(self.perimeter_m - d)
        };
        let around = |s: f64| {
            // Wider than the exact test below by more than `rem_euclid` rounds.
            let reach = DVec3::X * (reach_m + 1e-6);
            self.tree.touching(&Bounds { min: DVec3::X * s - reach, max: DVec3::X * s + reach })
        };
        let s = s.rem_euclid(self.perimeter_m);
        let near = [s - self.perimeter_m, s, s + self.perimeter_m].into_iter().flat_map(around);
        let free = near.map(|k| self.ends[k]).filter(|e| !used(e.0) && distance(e.1) <= reach_m);
        let length = |k: usize| self.coverage.chains[k].loop_edges;
        free.min_by(|a, b| {
            let by_loop = length(b.0).cmp(&length(a.0)).then(a.0.cmp(&b.0));
            distance(a.1).total_cmp(&distance(b.1)).then(by_loop)
        })
        .map(|e| e.0)
    }
}

/// Chain ends on the border and chain starts there within `reach_m` in space, nearest pairs first.
fn pairs_on_border(survey: &CellSurvey, coverage: &Coverage, reach_m: f64) -> Vec<(usize, usize)> {
    let on_border = |end: &End| matches!(end, End::Border(..));
    let chains = || coverage.chains.iter().enumerate();
    let ends: Vec<(usize, DVec3)> = chains()
        .filter(|(_, c)| on_border(&c.end))
        .filter_map(|(k, c)| Some((k, survey.to(*c.edges.last()?))))
        .collect();
    let starts: Vec<(usize, DVec3)> = chains()
        .filter(|(_, c)| on_border(&c.start))
        .filter_map(|(k, c)| Some((k, survey.from(*c.edges.first()?))))
        .collect();
    let tree = BoxTree::new(starts.iter().map(|&(_, p)| Bounds { min: p, max: p }));
    let mut pairs = Vec::new();
    for &(a, end) in &ends {
        let around = Bounds { min: end - reach_m, max: end + reach_m };
        let near = tree.touching(&around).into_iter().map(|k| (end.distance(starts[k].1), a, starts[k].0));
        pairs.extend(near.filter(|pair| pair.0 <= reach_m));
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
}

/// A hole whose opening on the border is narrower than what counts as covered is closed over it.
fn link_narrow_mouths(
    coverage: &Coverage,
    perimeter_m: f64,
    gap_m: f64,
    links: &mut [Option<Link>],
    taken: &mut [bool],
) {
    for (k, chain) in coverage.chains.iter().enumerate() {
        let (End::Border(_, from), End::Border(_, to)) = (chain.end, chain.start) else { continue };
        if links[k].is_none() && !taken[k] && (to - from).rem_euclid(perimeter_m) <= gap_m {
            links[k] = Some(Link { border: None, next: k });
            taken[k] = true;
        }
    }
}

fn follow(links: &[Option<Link>], walked: &mut Walked) {
    let mut seen = vec![false; links.len()];
    // For each chain, the last walk that came by, by its first chain.
    let mut walk_of = vec![usize::MAX; links.len()];
    for first in 0..links.len() {
        if seen[first] {
            continue;
        }
        let mut pieces = Vec::new();
        let mut chains = vec![first];
        walk_of[first] = first;
        let mut at = first;
        let closed = loop {
            pieces.push(RawPiece::Chain(at));
            let Some(link) = links[at] else { break false };
            pieces.push(link.border.map_or(RawPiece::Bridge, |(a, b)| RawPiece::Border(a, b)));
            at = link.next;
            if at == first {
                break true;
            }
            if seen[at] || walk_of[at] == first {
                break false;
            }
            walk_of[at] = first;
            chains.push(at);
        };
        if closed {
            chains.iter().for_each(|&k| seen[k] = true);
            walked.holes.push(pieces);
        } else {
            // The chains that lead into a dead end may be reached again from the one before them: count each once.
            seen[first] = true;
            walked.stray_chains += 1;
        }
    }
}
