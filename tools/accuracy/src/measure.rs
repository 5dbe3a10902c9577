//! Figures of one repair: error against the truth, slope, shape.

use crate::locate::Locator;
use crate::scene_files::{Tiles, TruthPoint, read_tiles};
use crate::slope::{Facet, Slopes, slopes};
use anyhow::Result;
use glam::{DVec2, DVec3};
use lacuna_mesh::QualityStats;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A hole-filled scene, as far as the figures need it.
#[derive(Clone, Debug, Default)]
pub struct Repaired {
    /// Original triangles and those of patches.
    pub facets: Vec<Facet>,
}

/// Statistics of signed height errors, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorStats {
    /// Places.
    pub count: usize,
    /// Mean of the absolute errors.
    pub mean_m: f64,
    /// Largest absolute error.
    pub max_m: f64,
    /// Standard deviation of the signed errors.
    pub sd_m: f64,
    /// Root of the mean square.
    pub rmse_m: f64,
    /// Mean of the signed errors.
    pub bias_m: f64,
}

/// Places of one depth: 0 at the rim, 1 at the place of a hole that lies farthest from its rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DepthBin {
    /// Upper end.
    pub depth: f64,
    /// Places.
    pub count: usize,
    /// Sum of their absolute errors, metres.
    pub sum_m: f64,
}

/// All figures of one repair but its cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Over all true vertices with new surface on their vertical.
    pub error: ErrorStats,
    /// The same over 34 evenly spread places of each hole: the number that Wang et al. 2021 used.
    pub error34: ErrorStats,
    /// Share of true vertices without new surface.
    pub missed: f64,
    /// By depth.
    pub depths: Vec<DepthBin>,
    /// Angles between triangles.
    pub slopes: Slopes,
    /// Triangles of all patches.
    pub new_triangles: usize,
    /// Mean 2r/R.
    pub quality_mean: f64,
    /// Share of triangles with 2r/R above 0.5.
    pub quality_share: f64,
    /// Signed error of every true vertex, metres; for pictures.
    #[serde(skip)]
    pub errors: Vec<Option<f64>>,
}

/// Places of the paper's statistics, in each hole.
const PAPER: usize = 34;
/// Number of depth bins.
const DEPTHS: usize = 8;

/// Reads what a run wrote: triangles behind those of the original file are its patch.
///
/// # Errors
/// Folders that can't be read.
pub fn read_repaired(original: &Tiles, out: &Path) -> Result<Repaired> {
    let mut facets = Vec::new();
    for (tile, (relative, mesh)) in (0u32..).zip(read_tiles(out)?) {
        let old = original.get(&relative).map_or(0, |m| m.triangles.len());
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        let facet = |(k, t): (usize, &[u32; 3])| Facet { corners: corners(t), tile, is_patch: k >= old };
        facets.extend(mesh.triangles.iter().enumerate().map(facet));
    }
    Ok(Repaired { facets })
}

/// Joins the original tiles and a patch of another program.
#[must_use]
pub fn with_patch(original: &Tiles, patch: &[[DVec3; 3]]) -> Repaired {
    let mut facets = Vec::new();
    for (tile, mesh) in (0u32..).zip(original.values()) {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        facets.extend(mesh.triangles.iter().map(|t| Facet { corners: corners(t), tile, is_patch: false }));
    }
    // One number for the whole patch: it knows no tiles, so it has no seams.
    facets.extend(patch.iter().map(|&corners| Facet { corners, tile: u32::MAX, is_patch: true }));
    Repaired { facets }
}

/// Measures a repair. `rims`: places on the rims of the holes.
///
/// The error of a true vertex is the height of the nearest new surface on its vertical, minus its own.
#[must_use]
pub fn measure(repaired: &Repaired, truth: &[TruthPoint], rims: &[DVec3]) -> Figures {
    let patch: Vec<[DVec3; 3]> = repaired.facets.iter().filter(|f| f.is_patch).map(|f| f.corners).collect();
    let quality = QualityStats::of(patch.iter().copied());
    let locator = Locator::new(patch);
    let errors: Vec<Option<f64>> = truth.iter().map(|t| locator.nearest_error(t.position)).collect();
    let known: Vec<(usize, f64)> = errors.iter().enumerate().filter_map(|(k, e)| Some((k, (*e)?))).collect();
    let missed = 1.0 - known.len() as f64 / f64::max(truth.len() as f64, 1.0);
    let mut holes: BTreeMap<u32, Vec<(usize, f64)>> = BTreeMap::new();
    for &(k, e) in &known {
        holes.entry(truth[k].hole).or_default().push((k, e));
    }
    let place = |k: usize| truth[k].position.truncate();
    let spread: Vec<f64> = holes.values().flat_map(|points| spread_errors(points, &place)).collect();
    let all: Vec<f64> = known.iter().map(|k| k.1).collect();
    Figures {
        error: statistics(&all),
        error34: statistics(&spread),
        missed,
        depths: depths(&holes, &place, rims),
        slopes: slopes(&repaired.facets),
        new_triangles: quality.triangles,
        quality_mean: quality.mean,
        quality_share: quality.share_good,
        errors,
    }
}

fn statistics(errors: &[f64]) -> ErrorStats {
    if errors.is_empty() {
        return ErrorStats::default();
    }
    let count = errors.len() as f64;
    let mean = |value: &dyn Fn(f64) -> f64| errors.iter().map(|&e| value(e)).sum::<f64>() / count;
    let bias_m = mean(&|e| e);
    ErrorStats {
        count: errors.len(),
        mean_m: mean(&f64::abs),
        max_m: errors.iter().fold(0.0, |m, e| m.max(e.abs())),
        sd_m: mean(&|e| (e - bias_m) * (e - bias_m)).sqrt(),
        rmse_m: mean(&|e| e * e).sqrt(),
        bias_m,
    }
}

/// Errors of evenly spread places of a hole: the one nearest to their middle, then always the one farthest from those taken.
fn spread_errors(points: &[(usize, f64)], place: &dyn Fn(usize) -> DVec2) -> Vec<f64> {
    if points.len() <= PAPER {
        return points.iter().map(|p| p.1).collect();
    }
    let middle = points.iter().map(|p| place(p.0)).sum::<DVec2>() / points.len() as f64;
    let mut away = vec![f64::INFINITY; points.len()];
    let first = (0..points.len()).min_by(|&a, &b| {
        let distance = |k: usize| place(points[k].0).distance_squared(middle);
        distance(a).total_cmp(&distance(b))
    });
    let mut last = first.unwrap_or(0);
    let mut errors = vec![points[last].1];
    while errors.len() < PAPER {
        for (k, away) in away.iter_mut().enumerate() {
            *away = away.min(place(points[k].0).distance_squared(place(points[last].0)));
        }
        let farthest = (0..points.len()).max_by(|&a, &b| away[a].total_cmp(&away[b]).then(b.cmp(&a)));
        last = farthest.unwrap_or(0);
        errors.push(points[last].1);
    }
    errors
}

fn depths(
    holes: &BTreeMap<u32, Vec<(usize, f64)>>,
    place: &dyn Fn(usize) -> DVec2,
    rims: &[DVec3],
) -> Vec<DepthBin> {
    let bin = |k: usize| DepthBin { depth: (k + 1) as f64 / DEPTHS as f64, ..DepthBin::default() };
    let mut bins: Vec<DepthBin> = (0..DEPTHS).map(bin).collect();
    for points in holes.values() {
        let from_rim = |p: &(usize, f64)| {
            let here = place(p.0);
            rims.iter().map(|r| r.truncate().distance_squared(here)).fold(f64::INFINITY, f64::min).sqrt()
        };
        let distances_m: Vec<f64> = points.iter().map(from_rim).collect();
        let deepest_m = distances_m.iter().fold(0.0, |m: f64, d| m.max(*d));
        for (distance_m, point) in distances_m.iter().zip(points) {
            let share = if deepest_m > 0.0 { distance_m / deepest_m } else { 0.0 };
            let bin = &mut bins[((share * DEPTHS as f64) as usize).min(DEPTHS - 1)];
            bin.count += 1;
            bin.sum_m += point.1.abs();
        }
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_tilted_lid_are_those_of_its_tilt() {
        // A square hole of 10 m; the lid rises by 1 m over it, the truth is level at 0.
        let corner = |x: f64, y: f64| DVec3::new(x, y, x / 10.0);
        let facet = |corners| Facet { corners, tile: 0, is_patch: true };
        let (a, b, c, d) = (corner(0., 0.), corner(10., 0.), corner(10., 10.), corner(0., 10.));
        let repaired = Repaired { facets: vec![facet([a, b, c]), facet([a, c, d])] };
        let point = |k: u32| DVec3::new(f64::from(k % 9 + 1), f64::from(k / 9 + 1), 0.0);
        let mut truth: Vec<TruthPoint> =
            (0..81).map(|k| TruthPoint { position: point(k), hole: 0 }).collect();
        truth.push(TruthPoint { position: DVec3::new(20.0, 5.0, 0.0), hole: 0 });
        let rims = [[0., 0.], [10., 0.], [10., 10.], [0., 10.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let figures = measure(&repaired, &truth, &rims);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert_eq!((figures.error.count, figures.error34.count), (81, 34));
        assert!(close(figures.error.mean_m, 0.5) && close(figures.error.bias_m, 0.5));
        assert!(close(figures.error.max_m, 0.9) && close(figures.missed, 1.0 / 82.0));
        assert!(close(figures.error.sd_m, (60.0f64 / 9.0 / 100.0).sqrt()));
        assert_eq!(figures.depths.iter().map(|b| b.count).sum::<usize>(), 81);
        assert_eq!(figures.new_triangles, 2);
    }
}
