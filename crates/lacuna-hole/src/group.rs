//! Which holes belong together: layers and clusters from the borders that holes share (algorithms note C.1, C.2).

use crate::cluster::{ClusterRule, DisjointSets};
use crate::layer::layers;
use crate::outline::point_inside;
use crate::plan::{Curve, Hole, HoleCluster, Leave, Piece, Span};
use crate::shared::SidePiece;
use glam::DVec2;
use lacuna_grid::BorderId;
use std::collections::BTreeMap;

/// Sets cluster and layer of every hole, and returns the clusters. `by_interval` are the pairs of holes that share an open
/// stretch of a border, `pieces` all stretches of borders that holes open.
pub(crate) fn group(
    holes: &mut [Hole],
    pieces: &[SidePiece],
    by_interval: &[(usize, usize)],
    curves: &[Curve],
    rule: ClusterRule,
) -> Vec<HoleCluster> {
    let joined = match rule {
        ClusterRule::Interval => by_interval.to_vec(),
        ClusterRule::Cell => [by_interval, &by_cell(holes, pieces)].concat(),
    };
    for (k, layer) in layers_of(holes, &joined, curves).into_iter().enumerate() {
        holes[k].layer = layer;
    }
    clusters(holes, &joined)
}

/// Pairs of holes of neighbouring cells that are open on one border.
fn by_cell(holes: &[Hole], pieces: &[SidePiece]) -> Vec<(usize, usize)> {
    let mut on_border: BTreeMap<BorderId, Vec<usize>> = BTreeMap::new();
    for p in pieces {
        on_border.entry(p.cell.border(p.side)).or_default().push(p.hole);
    }
    let mut pairs = Vec::new();
    for open in on_border.values() {
        for (k, &a) in open.iter().enumerate() {
            let others = open[k + 1..].iter().filter(|&&b| holes[b].cell != holes[a].cell);
            pairs.extend(others.map(|&b| (a.min(b), a.max(b))));
        }
    }
    pairs
}

fn layers_of(holes: &[Hole], joined: &[(usize, usize)], curves: &[Curve]) -> Vec<u32> {
    let mut neighbours = vec![Vec::new(); holes.len()];
    for &(a, b) in joined {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let has_surface: Vec<bool> = holes.iter().map(|h| has_surface(h, curves)).collect();
    layers(&has_surface, &neighbours)
}

fn clusters(holes: &mut [Hole], joined: &[(usize, usize)]) -> Vec<HoleCluster> {
    let mut sets = DisjointSets::new(holes.len());
    joined.iter().for_each(|&(a, b)| sets.join(a, b));
    let mut members: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for h in 0..holes.len() {
        members.entry(sets.root(h)).or_default().push(h as u32);
    }
    let mut clusters = Vec::new();
    for list in members.into_values() {
        for &h in &list {
            holes[h as usize].cluster = clusters.len() as u32;
        }
        clusters.push(cluster(holes, list));
    }
    clusters
}

fn cluster(all: &[Hole], holes: Vec<u32>) -> HoleCluster {
    let hole = |h: &u32| &all[*h as usize];
    let largest = holes.iter().map(hole).fold(None, |best: Option<&Hole>, h| match best {
        Some(b) if b.area_m2 >= h.area_m2 => Some(b),
        _ => Some(h),
    });
    let unsolved = holes.iter().any(|h| hole(h).layer == 0).then_some(Leave::NoSurface);
    HoleCluster {
        centre: largest.map_or(DVec2::ZERO, |h| point_inside(&h.outline)),
        area_m2: holes.iter().map(|h| hole(h).area_m2).sum(),
        layers: holes.iter().map(|h| hole(h).layer).max().unwrap_or(0),
        is_external: holes.iter().any(|h| hole(h).is_external),
        leave: leave_of(holes.iter().map(|h| hole(h).leave)).max(unsolved),
        holes,
    }
}

/// Why a cluster is left: what is said last of its holes. One with holes in the area and outside crosses its outline.
fn leave_of(holes: impl Iterator<Item = Option<Leave>> + Clone) -> Option<Leave> {
    let is_outside = |leave: &Option<Leave>| *leave == Some(Leave::OutsideArea);
    let is_parted = holes.clone().any(|l| is_outside(&l)) && !holes.clone().all(|l| is_outside(&l));
    let leave = holes.flatten().max();
    if is_parted && leave == Some(Leave::OutsideArea) { Some(Leave::CrossesArea) } else { leave }
}

/// True if some original surface bounds the hole: a rim of its own, a neighbour's border, or a neighbour's surface under
/// a curve.
fn has_surface(hole: &Hole, curves: &[Curve]) -> bool {
    let over = |span: &Span| match span {
        Span::Adopted { edges, .. } => !edges.is_empty(),
        Span::Curve(c) => !curves[*c as usize].over.is_empty(),
    };
    hole.outer.iter().any(|p| match p {
        Piece::Rim(_) => true,
        Piece::Side { spans, .. } => spans.iter().any(over),
        Piece::Bridge => false,
    }) || !hole.islands.is_empty()
}
