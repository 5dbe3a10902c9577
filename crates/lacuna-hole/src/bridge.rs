//! Which rim goes on where, across a cut inside the tile.

use crate::box_tree::BoxTree;
use crate::coverage::{Coverage, End, RimChain};
use crate::cut::FacingEdge;
use crate::{BorderFit, CellSurvey};
use lacuna_mesh::Bounds;
use std::collections::BTreeMap;

/// Pairs of rim chains that one hole's walk takes one after the other over a cut, nearest first: (end of, start of).
///
/// The two sides of a cut have vertices of their own, so the two rims end apart from each other, by up to an edge. But
/// the first edges of the cut beyond the rims face each other: from the end of a chain over to the other side and back
/// along it to the rim is where the hole goes on. Where that leads nowhere, rim ends near each other are pairs.
pub(crate) fn bridges(
    survey: &CellSurvey,
    coverage: &Coverage,
    facing: &[FacingEdge],
    fit: &BorderFit,
) -> Vec<(usize, usize)> {
    if facing.is_empty() {
        return Vec::new();
    }
    let reach_m = bridge_reach(survey, fit);
    let sides = Sides::new(survey, coverage, facing);
    let mut faced = Vec::new();
    let mut near = Vec::new();
    for (a, chain) in coverage.chains.iter().enumerate() {
        let End::Cut(beyond) = chain.end else { continue };
        faced.extend(sides.starts_opposite(beyond, reach_m).map(|b| (sides.apart_m(a, b), a, b)));
        let starts = sides.starts_near(a, reach_m).map(|b| (sides.apart_m(a, b), a, b));
        near.extend(starts.filter(|pair| pair.0 <= reach_m));
    }
    for pairs in [&mut faced, &mut near] {
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    }
    faced.into_iter().chain(near).map(|(_, a, b)| (a, b)).collect()
}

/// How far two rim ends may lie apart to be joined over a cut that says no more.
fn bridge_reach(survey: &CellSurvey, fit: &BorderFit) -> f64 {
    (6.0 * fit.margin_m).max(survey.median_edge_m)
}

/// The two sides of all cuts of a cell.
struct Sides<'a> {
    survey: &'a CellSurvey,
    chains: &'a [RimChain],
    /// For each cut edge, those that it faces.
    opposite: BTreeMap<u32, Vec<u32>>,
    /// For each cut edge, the boundary edge after it in its loop.
    next: BTreeMap<u32, u32>,
    /// Chains by their first edge.
    by_first: BTreeMap<u32, usize>,
    /// Chains that start at a cut, and the boxes of their starts.
    at_cut: Vec<usize>,
    starts: BoxTree,
}

impl<'a> Sides<'a> {
    fn new(survey: &'a CellSurvey, coverage: &'a Coverage, facing: &[FacingEdge]) -> Self {
        let chains = &coverage.chains;
        let mut opposite: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for f in facing {
            opposite.entry(f.edge).or_default().push(f.other);
        }
        let steps = survey.loops.iter().flat_map(|l| {
            let after = l.edges.iter().cycle().skip(1);
            l.edges.iter().copied().zip(after.copied())
        });
        let next = steps.filter(|(e, _)| opposite.contains_key(e)).collect();
        let by_first = chains.iter().enumerate().filter_map(|(k, c)| Some((*c.edges.first()?, k))).collect();
        let starts_at_cut = |k: &usize| matches!(chains[*k].start, End::Cut(_));
        let at_cut: Vec<usize> = (0..chains.len()).filter(starts_at_cut).collect();
        let firsts = at_cut.iter().filter_map(|&k| chains[k].edges.first());
        let starts = BoxTree::new(firsts.map(|&e| Bounds { min: survey.from(e), max: survey.from(e) }));
        Self { survey, chains, opposite, next, by_first, at_cut, starts }
    }

    /// Chains that start at a cut about `reach_m` from the end of chain `a` or nearer.
    fn starts_near(&self, a: usize, reach_m: f64) -> impl Iterator<Item = usize> {
        let end = self.chains[a].edges.last().map(|&e| self.survey.to(e));
        let around = end.map(|p| Bounds { min: p - reach_m, max: p + reach_m });
        let near = around.map_or_else(Vec::new, |b| self.starts.touching(&b));
        near.into_iter().map(|k| self.at_cut[k])
    }

    /// Chains that start where the sides opposite of cut edge `beyond` end, at most `reach_m` after it.
    fn starts_opposite(&self, beyond: u32, reach_m: f64) -> impl Iterator<Item = usize> {
        let over = self.opposite.get(&beyond).map_or(&[][..], Vec::as_slice);
        over.iter().filter_map(move |&edge| self.chain_after(edge, reach_m))
    }

    /// The chain that starts at most `reach_m` after a cut edge.
    fn chain_after(&self, edge: u32, reach_m: f64) -> Option<usize> {
        let mut at = *self.next.get(&edge)?;
        let mut walked_m = 0.0;
        while walked_m <= reach_m {
            if let Some(&chain) = self.by_first.get(&at) {
                return Some(chain);
            }
            walked_m += self.survey.from(at).distance(self.survey.to(at));
            at = *self.next.get(&at).filter(|&&next| next != edge)?;
        }
        None
    }

    /// Distance of the end of chain `a` from the start of chain `b`, metres; no chain is empty.
    fn apart_m(&self, a: usize, b: usize) -> f64 {
        let ends = (self.chains[a].edges.last(), self.chains[b].edges.first());
        let (Some(&last), Some(&first)) = ends else { return f64::INFINITY };
        self.survey.to(last).distance(self.survey.from(first))
    }
}
