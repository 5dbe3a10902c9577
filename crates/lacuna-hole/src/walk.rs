//! Open holes as closed walks over rim chains and the perimeter: Weiler-Atherton with the hole on the left (algorithms
//! note B.4).

use crate::CellSurvey;
use crate::coverage::{Coverage, End, uncovered};
use glam::DVec3;

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

/// Walks all open holes of a cell. `bridge_m` is how far two rim ends at a cut inside the tile may lie apart.
pub(crate) fn walk(
    survey: &CellSurvey,
    coverage: &Coverage,
    perimeter_m: f64,
    gap_m: f64,
    bridge_m: f64,
) -> Walked {
    let mut walked = Walked::default();
    if coverage.covered.is_empty() && coverage.chains.is_empty() {
        walked.holes.push(vec![RawPiece::Border(0.0, perimeter_m)]);
        return walked;
    }
    let mut links: Vec<Option<Link>> = vec![None; coverage.chains.len()];
    let mut taken = vec![false; coverage.chains.len()];
    for (from, to) in uncovered(&coverage.covered, perimeter_m, gap_m) {
        let end = nearest_chain(coverage, from, perimeter_m, gap_m, |c| c.end, |k| links[k].is_some());
        let start = nearest_chain(coverage, to, perimeter_m, gap_m, |c| c.start, |k| taken[k]);
        if let (Some(end), Some(start)) = (end, start) {
            links[end] = Some(Link { border: Some((from, to)), next: start });
            taken[start] = true;
        } else {
            walked.broken.push((from, to));
        }
    }
    // A rim that touches covered border in a vertex is in two chains there, with nothing uncovered between them.
    let on_border = |end: &End| matches!(end, End::Border(..));
    link_near(survey, coverage, gap_m, on_border, &mut links, &mut taken);
    let at_cut = |end: &End| matches!(end, End::Cut(_));
    link_near(survey, coverage, bridge_m, at_cut, &mut links, &mut taken);
    link_narrow_mouths(coverage, perimeter_m, gap_m, &mut links, &mut taken);
    follow(&links, &mut walked);
    walked
}

/// The chain with an end within `gap_m` of parameter `s`; the nearest, then the one of the longest loop, then the first.
fn nearest_chain(
    coverage: &Coverage,
    s: f64,
    perimeter_m: f64,
    gap_m: f64,
    end: impl Fn(&crate::coverage::RimChain) -> End,
    used: impl Fn(usize) -> bool,
) -> Option<usize> {
    let distance = |k: usize| match end(&coverage.chains[k]) {
        End::Border(_, at) => {
            let d = (at - s).rem_euclid(perimeter_m);
            d.min(perimeter_m - d)
        }
        End::Cut(_) => f64::INFINITY,
    };
    (0..coverage.chains.len()).filter(|&k| !used(k) && distance(k) <= gap_m.max(1e-6)).min_by(|&a, &b| {
        let length = |k: usize| coverage.chains[k].loop_edges;
        distance(a).total_cmp(&distance(b)).then(length(b).cmp(&length(a))).then(a.cmp(&b))
    })
}

/// Joins free chain ends of a kind to free chain starts of that kind within `reach_m` in space, nearest pairs first.
fn link_near(
    survey: &CellSurvey,
    coverage: &Coverage,
    reach_m: f64,
    is_kind: impl Fn(&End) -> bool,
    links: &mut [Option<Link>],
    taken: &mut [bool],
) {
    let chains = || coverage.chains.iter().enumerate();
    let ends: Vec<(usize, DVec3)> = chains()
        .filter(|(k, c)| links[*k].is_none() && is_kind(&c.end))
        .filter_map(|(k, c)| Some((k, survey.to(*c.edges.last()?))))
        .collect();
    let starts: Vec<(usize, DVec3)> = chains()
        .filter(|(k, c)| !taken[*k] && is_kind(&c.start))
        .filter_map(|(k, c)| Some((k, survey.from(*c.edges.first()?))))
        .collect();
    let mut pairs = Vec::new();
    for &(a, end) in &ends {
        let near = starts.iter().map(|&(b, start)| (end.distance(start), a, b));
        pairs.extend(near.filter(|pair| pair.0 <= reach_m));
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    for (_, a, b) in pairs {
        if links[a].is_none() && !taken[b] {
            links[a] = Some(Link { border: None, next: b });
            taken[b] = true;
        }
    }
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
    for first in 0..links.len() {
        if seen[first] {
            continue;
        }
        let mut pieces = Vec::new();
        let mut chains = vec![first];
        let mut at = first;
        let closed = loop {
            pieces.push(RawPiece::Chain(at));
            let Some(link) = links[at] else { break false };
            pieces.push(link.border.map_or(RawPiece::Bridge, |(a, b)| RawPiece::Border(a, b)));
            at = link.next;
            if at == first {
                break true;
            }
            if seen[at] || chains.contains(&at) {
                break false;
            }
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
