//! Angles between neighbouring triangles: across rims, across seams, and inside patches.

use glam::DVec3;
use lacuna_mesh::position_bits;
use serde::Serialize;
use std::collections::HashSet;

/// A triangle of a repaired scene.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Corners, metres.
    pub corners: [DVec3; 3],
    /// Number of its tile.
    pub tile: u32,
    /// True if a patch brought it.
    pub is_patch: bool,
}

/// Median and 95th percentile of angles, degrees; `None` without edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Angles {
    /// Edges.
    pub edges: usize,
    /// Median.
    pub median_deg: Option<f64>,
    /// 95th percentile.
    pub p95_deg: Option<f64>,
}

/// Slope jumps of a repaired scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Slopes {
    /// Between a patch and the original surface.
    pub rim: Angles,
    /// Between original triangles round the rims: what the rim would show if nothing were wrong.
    pub around: Angles,
    /// Between patches of two tiles.
    pub seam: Angles,
    /// Inside the patches of one tile.
    pub inside: Angles,
}

/// An edge of a triangle: its ends' position bits in order, and the triangle.
type EdgeUse = ([u64; 3], [u64; 3], u32);

/// Measures the angles over all edges that exactly two triangles have; places with equal position bits are one.
#[must_use]
pub fn slopes(facets: &[Facet]) -> Slopes {
    let bits = |f: &Facet| f.corners.map(position_bits);
    let touched: HashSet<[u64; 3]> = facets.iter().filter(|f| f.is_patch).flat_map(bits).collect();
    let mut edges: Vec<EdgeUse> = Vec::new();
    for (number, facet) in (0u32..).zip(facets) {
        let places = bits(facet);
        if facet.is_patch || places.iter().any(|p| touched.contains(p)) {
            for k in 0..3 {
                let (a, b) = (places[k], places[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), number));
            }
        }
    }
    edges.sort_unstable();
    let mut angles: [Vec<f64>; 4] = Default::default();
    for edge in edges.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1) {
        let [first, second] = edge else { continue };
        let pair = [first.2, second.2].map(|f| &facets[f as usize]);
        let is_near = touched.contains(&first.0) || touched.contains(&first.1);
        let kind = match (pair[0].is_patch, pair[1].is_patch) {
            (false, false) if is_near => 1,
            (false, false) => continue,
            (true, true) if pair[0].tile == pair[1].tile => 3,
            (true, true) => 2,
            _ => 0,
        };
        angles[kind].push(angle_deg(pair[0], pair[1]));
    }
    let [rim, around, seam, inside] = angles.map(statistics);
    Slopes { rim, around, seam, inside }
}

fn angle_deg(a: &Facet, b: &Facet) -> f64 {
    let normal = |f: &Facet| (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]);
    let (m, n) = (normal(a), normal(b));
    libm::atan2(m.cross(n).length(), m.dot(n)).to_degrees()
}

fn statistics(mut angles: Vec<f64>) -> Angles {
    angles.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let last = angles.len().checked_sub(1)?;
        Some(angles[(share * last as f64).round() as usize])
    };
    Angles { edges: angles.len(), median_deg: at(0.5), p95_deg: at(0.95) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_over_a_seam_shows_its_angle_there_alone() {
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let facet = |corners: [DVec3; 3], tile: u32, is_patch: bool| Facet { corners, tile, is_patch };
        let facets = [
            facet([p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.)], 0, true),
            facet([p(1., 0., 0.), p(1., 1., 0.), p(0., 1., 0.)], 0, true),
            facet([p(1., 0., 0.), p(2., 0., 1.), p(1., 1., 0.)], 1, true),
            facet([p(0., 0., 0.), p(0., -1., 0.), p(1., 0., 0.)], 0, false),
        ];
        let slopes = slopes(&facets);
        assert_eq!((slopes.inside.edges, slopes.inside.median_deg), (1, Some(0.0)));
        assert_eq!((slopes.rim.edges, slopes.rim.median_deg), (1, Some(0.0)));
        assert_eq!(slopes.seam.edges, 1);
        assert!(slopes.seam.median_deg.is_some_and(|a| (a - 45.0).abs() < 1e-9));
        assert_eq!(slopes.around, Angles::default());
    }
}
