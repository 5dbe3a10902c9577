//! The surface of water whose plane is known: flat up to the rim, and a bank or a wall down to it.

use crate::height_field::Region;
use lacuna_mesh::PlaneFit;

/// Wanted places this near to a vertex of the rim, in rim edges seen from above, stand on the bank; all others lie on the
/// water. The first row of a patch is one edge off its vertices, so that the bank is one row of triangles wide.
const BANK_EDGES: f64 = 0.75;

/// Heights of all places of a region, metres: data as they are, wanted places on `plane`, except that those nearer to a rim
/// vertex than three quarters of the median rim edge (seen from above) stand between its height and the plane, in
/// proportion to their distance.
///
/// The rim's slopes are not continued: between quay walls they say nothing of the water, and a wall on a part of the shore
/// must not lift the lake. Nothing is solved, and no height depends on another one.
#[must_use]
pub(crate) fn flat_water(region: &Region, plane: &PlaneFit) -> Vec<f64> {
    let Shore { nearest, median_edge_m } = Shore::new(region);
    let bank_m = BANK_EDGES * median_edge_m;
    let wanted = |v: usize| {
        let water_m = plane.at(region.places[v]);
        match nearest[v] {
            Some(rim) if rim.distance_m < bank_m => {
                water_m + (rim.height_m - water_m) * (1.0 - rim.distance_m / bank_m)
            }
            _ => water_m,
        }
    };
    (0..region.places.len()).map(|v| region.data[v].map_or_else(|| wanted(v), |d| d.height_m)).collect()
}

/// A vertex of the rim, seen from a place beside it.
#[derive(Clone, Copy)]
struct RimVertex {
    distance_m: f64,
    height_m: f64,
}

/// Where the rim is, seen from the wanted places next to it.
struct Shore {
    /// For each wanted place that is joined to the rim its nearest vertex.
    nearest: Vec<Option<RimVertex>>,
    /// Of the edges between rim vertices that wanted places see; 0 without any.
    median_edge_m: f64,
}

impl Shore {
    /// Looks at the triangles of each wanted place: in a Delaunay triangulation what is nearer than an edge is joined to it.
    fn new(region: &Region) -> Self {
        let rim = |v: u32| {
            let datum = region.data[v as usize].filter(|d| d.is_exact)?;
            Some((region.places[v as usize], datum.height_m))
        };
        let mut nearest: Vec<Option<RimVertex>> = vec![None; region.places.len()];
        let mut edges_m = Vec::new();
        for &[a, b, c] in &region.triangles {
            for [v, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
                if region.data[v as usize].is_some() {
                    continue;
                }
                let ends = [rim(from), rim(to)];
                if let [Some(from), Some(to)] = ends {
                    edges_m.push(from.0.distance(to.0));
                }
                for (p, height_m) in ends.into_iter().flatten() {
                    let end = RimVertex { distance_m: region.places[v as usize].distance(p), height_m };
                    let known = &mut nearest[v as usize];
                    if known.is_none_or(|k| end.is_before(&k)) {
                        *known = Some(end);
                    }
                }
            }
        }
        edges_m.sort_by(f64::total_cmp);
        Self { nearest, median_edge_m: edges_m.get(edges_m.len() / 2).copied().unwrap_or(0.0) }
    }
}

impl RimVertex {
    /// Nearer, or lower at the same distance: no order of triangles decides.
    fn is_before(&self, other: &Self) -> bool {
        (self.distance_m, self.height_m) < (other.distance_m, other.height_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::Datum;
    use glam::DVec2;

    /// A square pond of `n` by `n` even quads whose outermost places are its rim, at the heights that `z` gives; the place
    /// next to the first corner moves by `shift`.
    fn pond(n: u32, shift: DVec2, z: impl Fn(DVec2) -> f64) -> Region {
        let side = n + 1;
        let place = |k: u32| DVec2::new(f64::from(k % side), f64::from(k / side));
        let is_rim = |k: u32| [k % side, k / side].iter().any(|&i| i == 0 || i == n);
        let mut places: Vec<DVec2> = (0..side * side).map(place).collect();
        let datum = |k: u32| Datum { height_m: z(place(k)), weight: 0.1, is_exact: true };
        let data = (0..side * side).map(|k| is_rim(k).then(|| datum(k))).collect();
        places[side as usize + 1] += shift;
        let quads = (0..n).flat_map(|j| (0..n).map(move |i| j * side + i));
        let triangles = quads.flat_map(|k| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]]).collect();
        Region { places, triangles, data, edge_m: 1.0, radius_m: f64::from(n) / 2.0 }
    }

    #[test]
    fn water_is_flat_from_the_first_row_on_between_walls() {
        let region = pond(8, DVec2::ZERO, |p| 3.0 + p.x);
        let plane = PlaneFit { level_m: -0.45, ..PlaneFit::default() };
        for (v, z) in flat_water(&region, &plane).into_iter().enumerate() {
            let expected = region.data[v].map_or(-0.45, |d| d.height_m);
            assert_eq!(z.to_bits(), expected.to_bits(), "{}", region.places[v]);
        }
    }

    #[test]
    fn places_beside_the_rim_stand_on_the_bank() {
        // Half of the bank's width off the vertex (0, 1) of the western wall, which rises northwards.
        let region = pond(8, DVec2::new(0.375 - 1.0, 0.0), |p| 2.0 + p.y);
        let z = flat_water(&region, &PlaneFit { level_m: 1.0, ..PlaneFit::default() })[10];
        assert!((z - (1.0 + 0.5 * (3.0 - 1.0))).abs() < 1e-12, "{z}");
    }

    #[test]
    fn a_sloped_plane_is_kept_as_it_is() {
        let plane = PlaneFit { centre: DVec2::new(1.0, 2.0), level_m: 5.0, slope: DVec2::new(0.004, -0.001) };
        let region = pond(6, DVec2::ZERO, |_| 9.0);
        let z = flat_water(&region, &plane);
        let wanted = (0..z.len()).filter(|&v| region.data[v].is_none());
        wanted.for_each(|v| assert_eq!(z[v].to_bits(), plane.at(region.places[v]).to_bits()));
        assert!(flat_water(&Region::default(), &plane).is_empty());
    }
}
