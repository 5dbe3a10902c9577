//! How each tile stores positions, and border points that come back alike from both tiles of a border (decisions 10).

use super::scan::CellTile;
use super::solve::Fills;
use glam::DVec3;
use lacuna_close::{Curves, Source};
use lacuna_grid::CellId;
use lacuna_hole::{BorderMode, CurveKind, Plan};
use lacuna_tile::VertexFrame;
use std::collections::BTreeMap;

/// The frame of every cell's tile, those of hollow cells included.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frames {
    by_cell: BTreeMap<CellId, VertexFrame>,
}

/// Border points whose positions came back differently from the two tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SeamFacts {
    pub(crate) borders: u64,
    pub(crate) shared_vertices: u64,
    pub(crate) differing_vertices: u64,
    pub(crate) max_gap_m: f64,
}

impl Frames {
    /// Frames of the tiles that exist (of a tile of several files, the first), and for the hollow cells of the area that
    /// of their template.
    pub(crate) fn new(tiles: &BTreeMap<CellId, CellTile>, templates: &BTreeMap<CellId, CellId>) -> Self {
        let mut by_cell: BTreeMap<CellId, VertexFrame> =
            tiles.iter().filter_map(|(&c, t)| Some((c, t.parts.first()?.frame))).collect();
        for (&hollow, template) in templates {
            if let Some(&frame) = by_cell.get(template) {
                by_cell.insert(hollow, frame);
            }
        }
        Self { by_cell }
    }

    pub(crate) fn of(&self, cell: CellId) -> Option<&VertexFrame> {
        self.by_cell.get(&cell)
    }

    /// Rounds all closing points so that every tile that writes them reads the same position back.
    pub(crate) fn round_curves(&self, plan: &Plan, curves: &mut Curves) {
        for (k, curve) in plan.curves.iter().enumerate() {
            let cells: Vec<CellId> = curve.holes.iter().map(|&h| plan.holes[h as usize].cell).collect();
            let frames = self.different(cells.iter());
            for p in &mut curves.curves[k].inner {
                *p = round_shared(&frames, *p);
            }
        }
        for (corner, p) in &mut curves.corners {
            *p = round_shared(&self.different(corner.cells().iter()), *p);
        }
    }

    /// A position near `p` that the tiles of all `cells` store alike, if there is one; else as the first of them does.
    pub(crate) fn round_for<'c>(&self, cells: impl Iterator<Item = &'c CellId>, p: DVec3) -> DVec3 {
        round_shared(&self.different(cells), p)
    }

    /// The frames of some cells, each once: most tiles of a scene store positions alike.
    fn different<'c>(&self, cells: impl Iterator<Item = &'c CellId>) -> Vec<&VertexFrame> {
        let mut frames: Vec<&VertexFrame> = Vec::new();
        for frame in cells.filter_map(|c| self.by_cell.get(c)) {
            if !frames.contains(&frame) {
                frames.push(frame);
            }
        }
        frames
    }

    /// Compares what both tiles of every shared curve store, and where tiles are ragged also what they take from others.
    pub(crate) fn compare(
        &self,
        plan: &Plan,
        curves: &Curves,
        fills: &Fills,
        filled: impl Fn(u32) -> bool,
    ) -> SeamFacts {
        let mut facts = SeamFacts::default();
        if plan.fit.mode == BorderMode::Ragged {
            self.compare_adopted(plan, fills, &filled, &mut facts);
        }
        for (k, curve) in plan.curves.iter().enumerate() {
            if curve.kind != CurveKind::Shared || !curve.holes.iter().all(|&h| filled(h)) {
                continue;
            }
            facts.borders += 1;
            let inner = &curves.curves[k].inner;
            facts.shared_vertices += inner.len() as u64;
            let frames = self.different(curve.holes.iter().map(|&h| &plan.holes[h as usize].cell));
            // Tiles that store positions alike give the same back.
            for &p in inner.iter().filter(|_| frames.len() > 1) {
                let places: Vec<DVec3> = frames.iter().map(|f| f.round(p)).collect();
                if places.windows(2).any(|w| w[0] != w[1]) {
                    facts.differing_vertices += 1;
                    facts.max_gap_m = facts.max_gap_m.max(places[0].distance(places[places.len() - 1]));
                }
            }
        }
        facts
    }
}

impl Frames {
    /// Compares the vertices that patches take from other tiles with what their own tile stores.
    fn compare_adopted(
        &self,
        plan: &Plan,
        fills: &Fills,
        filled: &impl Fn(u32) -> bool,
        facts: &mut SeamFacts,
    ) {
        for (&h, fill) in fills.iter().filter(|f| filled(*f.0)) {
            let (Some(frame), Ok(fill)) = (self.of(plan.holes[h as usize].cell), fill) else { continue };
            for (source, &p) in fill.sources.iter().zip(&fill.rim) {
                if matches!(source, Source::Adopted(..)) {
                    facts.shared_vertices += 1;
                    let gap_m = frame.round(p).distance(p);
                    facts.differing_vertices += u64::from(gap_m > 0.0);
                    facts.max_gap_m = facts.max_gap_m.max(gap_m);
                }
            }
        }
    }
}

/// A position near `p` that all frames return unchanged, if there is one; else the first one's.
fn round_shared(frames: &[&VertexFrame], p: DVec3) -> DVec3 {
    let Some(first) = frames.first() else { return p };
    let stable = |q: DVec3| frames.iter().all(|f| f.round(q) == q);
    let rounded = first.round(p);
    if stable(rounded) {
        return rounded;
    }
    // A lattice of powers of two that both offsets lie on holds exactly in both.
    for bits in [13, 12, 11, 10, 9, 8] {
        let step = f64::from(1u32 << bits);
        let lattice = (p * step).round() / step;
        if stable(lattice) {
            return lattice;
        }
    }
    rounded
}
