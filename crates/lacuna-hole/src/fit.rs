//! How the tiles of a scene meet the borders of their cells (algorithms note B.1, decisions 7 and 8).

use crate::{CellSurvey, Surveys};
use glam::DVec3;
use lacuna_grid::{Area, AreaLimit, Domain, Grid, Side};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How tiles are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BorderMode {
    /// On the border line, with common vertices.
    Exact,
    /// On a line a fixed margin outside the cell; neighbours overlap and share no vertices.
    Overrun,
    /// Triangles overshoot and fall short.
    Ragged,
    /// Tiles reach far into their neighbours.
    Overlap,
}

/// The border mode of a scene and its tolerances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BorderFit {
    /// How tiles are cut.
    pub mode: BorderMode,
    /// How far tiles run past their cell, metres; 0 unless `Overrun`.
    pub margin_m: f64,
    /// A boundary edge whose ends are this near to the line lies on it, metres (eps_b).
    pub tolerance_m: f64,
    /// Gaps in the coverage up to this length are covered, metres (eps_g).
    pub gap_m: f64,
    /// Rim runs that stay this near to the line count as border, metres (hysteresis).
    pub absorb_m: f64,
    /// Median length of all boundary edges, metres (e).
    pub edge_m: f64,
}

impl BorderFit {
    /// The domain of a cell under this fit.
    #[must_use]
    pub fn domain(&self, grid: &Grid, area: &Area, cell: lacuna_grid::CellId) -> Domain {
        Domain::new(grid, area, cell, self.margin_m)
    }
}

/// Width of a histogram bin for the margin, metres.
const BIN_M: f64 = 0.0005;

/// Edges within this many median edges of the outermost one at their place are outline, too.
const SAME_EDGES: f64 = 0.5;

/// What subtracting coordinates of a scene in f64 may lose, metres.
const ROUNDING_M: f64 = 1e-8;

/// Bins up to a margin of 500 m.
const MOST_BINS: usize = 1_000_000;

/// Measures how tiles meet their borders: overrun first (one peak of the offsets holds 40 % of the vertices near a
/// side), then exact (80 % of the length that runs along a side lies on it), overlap, ragged.
#[must_use]
pub fn fit_borders(surveys: &Surveys, grid: &Grid) -> BorderFit {
    let edge_m = median(surveys.values().map(|s| s.median_edge_m).filter(|e| *e > 0.0).collect());
    let size = grid.cell_size_m;
    let offsets = offsets_near_sides(surveys, grid);
    if let Some(margin_m) = overrun_peak(&offsets, size) {
        let tolerance_m = (0.05 * margin_m).max(0.002);
        return BorderFit {
            mode: BorderMode::Overrun,
            margin_m,
            tolerance_m,
            gap_m: (2.0 * tolerance_m).max(0.5 * edge_m),
            // A rim that cuts off a corner within a wide margin is no roughness.
            absorb_m: (3.0 * margin_m).clamp(0.5 * edge_m, edge_m),
            edge_m,
        };
    }
    let reach = surveys.values().map(|s| largest_coordinate(s, grid)).fold(size, f64::max);
    let tolerance_m = 4.0 * (8.0 * ulp_f32(reach)).max(1e-4).min(0.01 * edge_m.max(1e-3));
    let on_line = share(&offsets, |o| o.abs() <= tolerance_m);
    if offsets.is_empty() || on_line >= 0.8 {
        let fit = BorderFit {
            mode: BorderMode::Exact,
            margin_m: 0.0,
            tolerance_m,
            gap_m: 2.0 * tolerance_m,
            absorb_m: 2.0 * tolerance_m,
            edge_m,
        };
        return fit;
    }
    let far = share(&offsets, |o| o > 1.5 * edge_m);
    let mode = if far >= 0.2 { BorderMode::Overlap } else { BorderMode::Ragged };
    let tolerance_m = (1.5 * edge_m).min(0.02 * size);
    BorderFit {
        mode,
        margin_m: 0.0,
        tolerance_m,
        gap_m: (2.0 * tolerance_m).max(0.5 * edge_m),
        absorb_m: 2.0 * tolerance_m,
        edge_m,
    }
}

/// (signed offset of the middle, length) of every boundary edge that runs along a side of its cell near to it, on the
/// tile's outline: far rims of holes beside the border run the same way, but surface lies farther out.
fn offsets_near_sides(surveys: &Surveys, grid: &Grid) -> Vec<(f64, f64)> {
    let mut offsets = Vec::new();
    for survey in surveys.values() {
        let area = Area { cells: [survey.cell].into(), limit: AreaLimit::Cells };
        let domain = Domain::new(grid, &area, survey.cell, 0.0);
        let near = (3.0 * survey.median_edge_m).min(0.05 * grid.cell_size_m);
        let bin_m = survey.median_edge_m.max(1e-6);
        let mut found = Vec::new();
        for index in 0..survey.boundary.edges.len() as u32 {
            let (a, b) = (survey.from(index), survey.to(index));
            if let Some((side, offset)) = offset_along_side(&domain, a, b, near) {
                let along = side.along((a + b).truncate() / 2.0);
                let bin = (side.index(), (along / bin_m).floor() as i64);
                found.push((bin, offset, a.truncate().distance(b.truncate())));
            }
        }
        let mut outermost: BTreeMap<(usize, i64), f64> = BTreeMap::new();
        for &(bin, offset, _) in &found {
            let most = outermost.entry(bin).or_insert(offset);
            *most = most.max(offset);
        }
        let on_outline =
            found.iter().filter(|(bin, offset, _)| *offset >= outermost[bin] - SAME_EDGES * bin_m);
        offsets.extend(on_outline.map(|&(_, offset, length)| (offset, length)));
    }
    offsets
}

fn offset_along_side(domain: &Domain, a: DVec3, b: DVec3, near: f64) -> Option<(Side, f64)> {
    let (a, b) = (a.truncate(), b.truncate());
    let direction = (b - a).normalize_or_zero();
    // Walking the outline with the mesh on the right runs clockwise round the cell.
    Side::ALL.into_iter().find_map(|side| {
        let clockwise = side.outward().perp() * -1.0;
        let offsets = [domain.outside_m(side, a), domain.outside_m(side, b)];
        let along = direction.dot(clockwise) >= 0.9 && offsets.iter().all(|o| o.abs() <= near);
        along.then(|| (side, (offsets[0] + offsets[1]) / 2.0))
    })
}

/// The margin that at least 40 % of the edges near a side share, if it lies in (0.5 mm, 2 % of the cell].
fn overrun_peak(offsets: &[(f64, f64)], cell_size_m: f64) -> Option<f64> {
    let bins = ((0.02 * cell_size_m / BIN_M).ceil() as usize).min(MOST_BINS) + 1;
    let mut histogram = vec![0u64; bins + 1];
    for (offset, _) in offsets.iter().filter(|(o, _)| *o > BIN_M && *o <= 0.02 * cell_size_m) {
        histogram[((offset / BIN_M) as usize).min(bins)] += 1;
    }
    // Two neighbouring bins, so that a margin on a bin's edge is one peak.
    let (best, count) = (0..bins)
        .map(|k| (k, histogram[k] + histogram[k + 1]))
        .max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(&a.0)))?;
    if (count as f64) < 0.4 * offsets.len() as f64 || count == 0 {
        return None;
    }
    let (low, high) = (best as f64 * BIN_M, (best + 2) as f64 * BIN_M);
    let margin = median(offsets.iter().map(|o| o.0).filter(|o| (low..high).contains(o)).collect());
    // A round number where it differs by no more than arithmetic does: else the line of the tiles as they store it.
    let tidy = (margin * 1e4).round() / 1e4;
    Some(if (tidy - margin).abs() < ROUNDING_M { tidy } else { margin })
}

fn share(offsets: &[(f64, f64)], holds: impl Fn(f64) -> bool) -> f64 {
    let all: f64 = offsets.iter().map(|o| o.1).sum();
    let part: f64 = offsets.iter().filter(|o| holds(o.0)).map(|o| o.1).sum();
    if all > 0.0 { part / all } else { 0.0 }
}

/// Largest distance of a coordinate from the grid's origin or from zero, whichever a file may have stored.
fn largest_coordinate(survey: &CellSurvey, grid: &Grid) -> f64 {
    let low = survey.bounds.min.truncate() - grid.origin;
    let high = survey.bounds.max.truncate() - grid.origin;
    low.abs().max(high.abs()).max_element().min(1e7)
}

fn ulp_f32(value: f64) -> f64 {
    let bits = (value as f32).to_bits();
    f64::from(f32::from_bits(bits + 1)) - f64::from(f32::from_bits(bits))
}

fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
