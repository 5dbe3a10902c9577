//! Which clusters lie in the water polygons of the configuration.

use crate::PolygonSet;
use crate::config::{WaterFile, WaterMode};
use glam::DVec2;
use lacuna_hole::{HoleCluster, Plan};
use lacuna_mesh::Bounds;

/// The water polygons in scene coordinates.
#[derive(Debug, Default)]
pub(crate) struct WaterPlaces {
    polygons: Vec<Place>,
}

#[derive(Debug)]
struct Place {
    /// The feature's number in its file.
    feature: usize,
    polygon: PolygonSet,
    bounds: Bounds,
    mode: WaterMode,
}

/// Lines on which the area that a hole and a polygon share is measured.
const LINES: usize = 64;
/// A cluster is the water of the polygons that hold this share of its area.
const MAJORITY: f64 = 0.5;

impl WaterPlaces {
    /// Moves the polygons into the scene. `srs_origin` and `srs_height_m` are what is added to scene coordinates and
    /// heights to get those of the SRS.
    pub(crate) fn new(file: Option<&WaterFile>, srs_origin: DVec2, srs_height_m: f64) -> Self {
        let place = |file: &WaterFile, p| {
            let polygon = file.in_scene(p, srs_origin);
            let bounds = bounds_of(polygon.rings.iter().flatten());
            Place { feature: p.feature, polygon, bounds, mode: file.mode(p, srs_height_m) }
        };
        let polygons = file.into_iter().flat_map(|file| file.polygons.iter().map(move |p| place(file, p)));
        Self { polygons: polygons.collect() }
    }

    /// What the polygons say of a cluster: nothing unless they hold at least half of its area, in SRS heights else. Of
    /// several the one that holds most of it counts, of equals the first.
    pub(crate) fn mode(&self, plan: &Plan, cluster: &HoleCluster) -> Option<WaterMode> {
        if self.polygons.is_empty() {
            return None;
        }
        let shares: Vec<f64> = self.polygons.iter().map(|p| p.area_in(plan, cluster)).collect();
        let whole: f64 = outlines(plan, cluster).map(|ring| lacuna_mesh::signed_area(ring).abs()).sum();
        // A hole in a wall has no area from above.
        if whole <= 0.0 || shares.iter().sum::<f64>() < MAJORITY * whole {
            return None;
        }
        // `max_by` takes the last of equals; reversed, that is the first.
        let most = (0..shares.len()).rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b]))?;
        Some(self.polygons[most].mode)
    }

    /// Numbers of the features that no hole of the plan touches.
    pub(crate) fn unused(&self, plan: &Plan) -> Vec<usize> {
        let is_unused = |p: &&Place| plan.clusters.iter().all(|c| p.area_in(plan, c) == 0.0);
        self.polygons.iter().filter(is_unused).map(|p| p.feature).collect()
    }

    /// How many polygons there are.
    pub(crate) fn len(&self) -> usize {
        self.polygons.len()
    }
}

impl Place {
    /// Area of a cluster's holes in the polygon, square metres.
    fn area_in(&self, plan: &Plan, cluster: &HoleCluster) -> f64 {
        let near = outlines(plan, cluster).filter(|ring| meet(&bounds_of(ring.iter()), &self.bounds));
        near.map(|ring| common_area(ring, &self.polygon)).sum()
    }
}

fn outlines<'a>(plan: &'a Plan, cluster: &'a HoleCluster) -> impl Iterator<Item = &'a [DVec2]> {
    cluster.holes.iter().map(|&h| plan.holes[h as usize].outline.as_slice())
}

fn bounds_of<'a>(points: impl Iterator<Item = &'a DVec2>) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    points.for_each(|p| bounds.add(p.extend(0.0)));
    bounds
}

fn meet(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

/// Area that a ring and a polygon share: lengths on lines through the ring, each exact, times their distance.
fn common_area(ring: &[DVec2], polygon: &PolygonSet) -> f64 {
    let bounds = bounds_of(ring.iter());
    let step = (bounds.max.y - bounds.min.y) / LINES as f64;
    let on_line = |k: usize| {
        let y = bounds.min.y + (k as f64 + 0.5) * step;
        common_length(&stretches([ring], y), &stretches(polygon.rings.iter().map(Vec::as_slice), y))
    };
    if step > 0.0 { (0..LINES).map(on_line).sum::<f64>() * step } else { 0.0 }
}

/// What a line of constant y has inside rings, by the even-odd rule, ascending.
fn stretches<'a>(rings: impl IntoIterator<Item = &'a [DVec2]>, y: f64) -> Vec<[f64; 2]> {
    let mut crossings = Vec::new();
    for ring in rings {
        for k in 0..ring.len() {
            let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
            if (a.y > y) != (b.y > y) {
                crossings.push(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).map(|x| [x[0], x[1]]).collect()
}

fn common_length(first: &[[f64; 2]], second: &[[f64; 2]]) -> f64 {
    let overlap = |a: &[f64; 2], b: &[f64; 2]| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
    first.iter().map(|a| second.iter().map(|b| overlap(a, b)).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(west: f64, south: f64, east: f64, north: f64) -> Vec<DVec2> {
        [(west, south), (east, south), (east, north), (west, north)].map(DVec2::from).to_vec()
    }

    #[test]
    fn common_areas() {
        let hole = rectangle(0.0, 0.0, 10.0, 8.0);
        for (name, rings, expected) in [
            ("itself", vec![hole.clone()], 80.0),
            ("around", vec![rectangle(-5.0, -5.0, 50.0, 50.0)], 80.0),
            ("a half", vec![rectangle(5.0, -1.0, 50.0, 9.0)], 40.0),
            ("a corner", vec![rectangle(7.0, 6.0, 12.0, 20.0)], 6.0),
            ("apart", vec![rectangle(11.0, 0.0, 12.0, 8.0)], 0.0),
            ("touching", vec![rectangle(10.0, 0.0, 12.0, 8.0)], 0.0),
            ("with an island", vec![hole.clone(), rectangle(2.0, 2.0, 6.0, 4.0)], 72.0),
        ] {
            for shift in [DVec2::ZERO, DVec2::new(5e5, -5e5)] {
                let moved = |ring: &Vec<DVec2>| ring.iter().map(|&p| p + shift).collect::<Vec<_>>();
                let set = PolygonSet { rings: rings.iter().map(moved).collect() };
                let area = common_area(&moved(&hole), &set);
                assert!((area - expected).abs() < 1e-6, "{name}, {shift}: {area}");
            }
        }
    }
}
