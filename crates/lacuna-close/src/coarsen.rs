//! A coarser triangulation of the same region, for clusters with more places than one solve may have (algorithms D.4).

use crate::sample::Spot;
use glam::DVec2;
use lacuna_mesh::side_of_line;

/// A triangulation on some of the places of a finer one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coarse {
    pub(crate) places: Vec<DVec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The finer one's place at each of `places`.
    pub(crate) fine: Vec<u32>,
    /// Where each place of the finer one lies.
    pub(crate) spots: Vec<Spot>,
}

/// Edges up to this length are collapsed first, in typical edges; each pass that finds few goes on with longer ones.
const FIRST_EDGES: f64 = 1.2;
const LONGER: f64 = 1.25;
/// A pass that removes less than this share found few.
const FEW: f64 = 0.02;
/// Passes at the most: 1.25^60 is a factor of 6e5.
const PASSES: usize = 90;
/// Worst shape that a collapse may leave: twice the inradius over the circumradius.
const WORST_SHAPE: f64 = 0.15;

/// Takes places out until at most `limit` are left, or none can go: the shortest edges first, so that the finely
/// triangulated rims and rings lose most and the wide triangles inside stay as they are.
///
/// Each removal moves a place onto a neighbour (half-edge collapse) and is done only if the triangulation stays one: no
/// triangle turned over, none much worse in shape, the link of the edge as it must be. In one pass no two removals touch.
/// Deterministic: places in their order, ties by number.
pub(crate) fn coarsen(places: &[DVec2], triangles: &[[u32; 3]], edge_m: f64, limit: usize) -> Coarse {
    let mut work = Work::new(places, triangles);
    let mut longest_m = FIRST_EDGES * edge_m;
    for _ in 0..PASSES {
        let before = work.left;
        work.pass(longest_m, limit);
        if work.left <= limit {
            break;
        }
        if ((before - work.left) as f64) < FEW * before as f64 {
            longest_m *= LONGER;
        }
    }
    work.finish()
}

const GONE: u32 = u32::MAX;

struct Work<'a> {
    places: &'a [DVec2],
    /// Corners; `GONE` thrice for a removed one.
    triangles: Vec<[u32; 3]>,
    /// Triangles at each place.
    fans: Vec<Vec<u32>>,
    /// The place that each was moved onto, itself while it stands.
    onto: Vec<u32>,
    left: usize,
    /// The pass in which a place was last touched.
    touched: Vec<u32>,
    pass: u32,
}

impl<'a> Work<'a> {
    fn new(places: &'a [DVec2], triangles: &[[u32; 3]]) -> Self {
        let mut fans = vec![vec![]; places.len()];
        for (t, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| fans[v as usize].push(t as u32));
        }
        Self {
            places,
            triangles: triangles.to_vec(),
            fans,
            onto: (0..places.len() as u32).collect(),
            left: places.len(),
            touched: vec![0; places.len()],
            pass: 0,
        }
    }

    fn pass(&mut self, longest_m: f64, limit: usize) {
        self.pass += 1;
        for v in 0..self.places.len() as u32 {
            if self.left <= limit {
                return;
            }
            if self.onto[v as usize] != v || self.touched[v as usize] == self.pass {
                continue;
            }
            if let Some(u) = self.best_neighbour(v, longest_m) {
                self.collapse(v, u);
            }
        }
    }

    /// The neighbour within reach that a place goes onto with the best worst triangle.
    fn best_neighbour(&self, v: u32, longest_m: f64) -> Option<u32> {
        let links = self.links(v)?;
        let is_border = links.iter().any(|l| l.1 == 1);
        let mut best: Option<(f64, u32)> = None;
        for &(u, triangles) in &links {
            // A place on the region's edge stays on it.
            let is_along = !is_border || triangles == 1;
            if !is_along || self.places[v as usize].distance(self.places[u as usize]) > longest_m {
                continue;
            }
            if let Some(shape) = self.shape_after(v, u, triangles)
                && best.is_none_or(|b| shape > b.0)
            {
                best = Some((shape, u));
            }
        }
        best.filter(|b| b.0 >= WORST_SHAPE.min(self.worst_shape(v))).map(|b| b.1)
    }

    /// Neighbours of a place with the number of triangles at the edge, ascending; `None` if the place cannot go: its
    /// triangles are no single fan.
    fn links(&self, v: u32) -> Option<Vec<(u32, u32)>> {
        let fan = &self.fans[v as usize];
        let mut ends: Vec<u32> =
            fan.iter().flat_map(|&t| self.triangles[t as usize]).filter(|&c| c != v).collect();
        ends.sort_unstable();
        let links: Vec<(u32, u32)> =
            ends.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect();
        let at_border = links.iter().filter(|l| l.1 == 1).count();
        let is_fan = links.iter().all(|l| l.1 <= 2)
            && (at_border == 0 && links.len() == fan.len() || at_border == 2 && links.len() == fan.len() + 1);
        (is_fan && fan.len() >= 2).then_some(links)
    }

    /// The worst shape among the triangles that `v` leaves on `u`; `None` if it may not go there.
    fn shape_after(&self, v: u32, u: u32, at_edge: u32) -> Option<f64> {
        // Only the triangles at the edge may close over it, else two sheets would meet.
        let around_u = self.links(u)?;
        let around_v = self.links(v)?;
        let is_common = |l: &&(u32, u32)| around_u.binary_search_by_key(&l.0, |m| m.0).is_ok();
        if around_v.iter().filter(is_common).count() != at_edge as usize {
            return None;
        }
        let mut worst = f64::INFINITY;
        for &t in &self.fans[v as usize] {
            let corners = self.triangles[t as usize];
            if corners.contains(&u) {
                continue;
            }
            worst = worst.min(self.shape(corners.map(|c| if c == v { u } else { c }))?);
        }
        worst.is_finite().then_some(worst)
    }

    fn worst_shape(&self, v: u32) -> f64 {
        let shapes = self.fans[v as usize].iter().map(|&t| self.shape(self.triangles[t as usize]));
        shapes.fold(f64::INFINITY, |worst, shape| worst.min(shape.unwrap_or(0.0)))
    }

    /// Twice the inradius over the circumradius; `None` for a triangle that is turned over or has no area.
    fn shape(&self, corners: [u32; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|v| self.places[v as usize]);
        if side_of_line(a, b, c) <= 0.0 {
            return None;
        }
        let (la, lb, lc) = (b.distance(c), c.distance(a), a.distance(b));
        Some((lb + lc - la) * (lc + la - lb) * (la + lb - lc) / (la * lb * lc))
    }

    fn collapse(&mut self, v: u32, u: u32) {
        let fan = std::mem::take(&mut self.fans[v as usize]);
        for t in fan {
            let corners = self.triangles[t as usize];
            corners.iter().for_each(|&c| self.touched[c as usize] = self.pass);
            if corners.contains(&u) {
                for c in corners.into_iter().filter(|&c| c != v) {
                    self.fans[c as usize].retain(|&other| other != t);
                }
                self.triangles[t as usize] = [GONE; 3];
            } else {
                self.triangles[t as usize] = corners.map(|c| if c == v { u } else { c });
                self.fans[u as usize].push(t);
            }
        }
        self.onto[v as usize] = u;
        self.left -= 1;
    }

    fn finish(self) -> Coarse {
        let mut coarse = Coarse::default();
        let mut number = vec![GONE; self.places.len()];
        for v in 0..self.places.len() {
            if self.onto[v] as usize == v {
                number[v] = coarse.places.len() as u32;
                coarse.places.push(self.places[v]);
                coarse.fine.push(v as u32);
            }
        }
        coarse.spots = (0..self.places.len() as u32).map(|v| self.spot(v, &number)).collect();
        let standing = self.triangles.iter().filter(|t| t[0] != GONE);
        coarse.triangles = standing.map(|t| t.map(|v| number[v as usize])).collect();
        coarse
    }

    /// Where a place lies in what is left: in a triangle near the place that it was moved onto.
    fn spot(&self, v: u32, number: &[u32]) -> Spot {
        let mut root = v;
        while self.onto[root as usize] != root {
            root = self.onto[root as usize];
        }
        if root == v {
            return Spot::vertex(number[v as usize]);
        }
        let near = self.fans[root as usize].iter().flat_map(|&t| self.triangles[t as usize]);
        let mut around: Vec<u32> = near.flat_map(|c| self.fans[c as usize].iter().copied()).collect();
        around.sort_unstable();
        around.dedup();
        let mut best = (f64::NEG_INFINITY, Spot::vertex(root));
        for t in around {
            let corners = self.triangles[t as usize];
            let shares = self.shares(self.places[v as usize], corners);
            let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
            if least > best.0 {
                best = (least, Spot { corners, shares });
            }
        }
        let Spot { corners, shares } = best.1;
        Spot { corners: corners.map(|c| number[c as usize]), shares }
    }

    /// Barycentric coordinates; outside of the triangle they continue its plane.
    fn shares(&self, p: DVec2, corners: [u32; 3]) -> [f64; 3] {
        let [a, b, c] = corners.map(|v| self.places[v as usize]);
        let twice = (b - a).perp_dot(c - a);
        let [beta, gamma] = [(p - a).perp_dot(c - a) / twice, (b - a).perp_dot(p - a) / twice];
        [1.0 - beta - gamma, beta, gamma]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_mesh::closed_fans;

    /// A square of `n` by `n` places, the middle third four times as coarse.
    fn square(n: u32) -> (Vec<DVec2>, Vec<[u32; 3]>) {
        let shake = |k: u32| 0.2 * libm::sin(f64::from(k) * 12.9898);
        let inner = |k: u32| [k % n, k / n].iter().all(|i| (1..n - 1).contains(i));
        let place = |k: u32| {
            let even = DVec2::new(f64::from(k % n), f64::from(k / n));
            if inner(k) { even + DVec2::new(shake(k), shake(k + 77)) } else { even }
        };
        let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
        let triangles = quads.flat_map(|k| [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]).collect();
        ((0..n * n).map(place).collect(), triangles)
    }

    fn area(places: &[DVec2], triangles: &[[u32; 3]]) -> f64 {
        let doubled = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| places[v as usize]);
            (b - a).perp_dot(c - a)
        };
        triangles.iter().map(doubled).inspect(|a| assert!(*a > 0.0)).sum::<f64>() / 2.0
    }

    #[test]
    fn what_is_left_covers_the_same_square() {
        let (places, triangles) = square(40);
        for limit in [1600, 1000, 400, 150] {
            let coarse = coarsen(&places, &triangles, 1.0, limit);
            assert!(coarse.places.len() <= limit, "{} of {limit}", coarse.places.len());
            // Corners of the edge may be cut.
            let share = area(&coarse.places, &coarse.triangles) / (39.0 * 39.0);
            assert!((0.95..1.0 + 1e-9).contains(&share), "{share}");
            let closed = closed_fans(coarse.places.len(), &coarse.triangles);
            let inner = |p: &DVec2| p.min_element() > 0.0 && p.max_element() < 39.0;
            assert!(coarse.places.iter().zip(closed).all(|(p, closed)| !inner(p) || closed));
            for (&fine, &p) in coarse.fine.iter().zip(&coarse.places) {
                assert_eq!(places[fine as usize], p);
            }
        }
    }

    #[test]
    fn every_place_is_found_in_its_triangle() {
        let (places, triangles) = square(40);
        let coarse = coarsen(&places, &triangles, 1.0, 300);
        for (p, spot) in places.iter().zip(&coarse.spots) {
            let back: DVec2 = (0..3).map(|k| coarse.places[spot.corners[k] as usize] * spot.shares[k]).sum();
            assert!(back.distance(*p) < 1e-9);
            let is_inner = p.min_element() > 6.0 && p.max_element() < 33.0;
            assert!(!is_inner || spot.shares.iter().all(|s| *s > -1e-9), "{spot:?}");
        }
    }

    #[test]
    fn a_pinched_place_stays() {
        // Two squares that touch in place 2.
        let places: Vec<DVec2> =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)]
                .map(DVec2::from)
                .to_vec();
        let triangles = [[0, 1, 2], [0, 2, 3], [2, 4, 5], [2, 5, 6]];
        let coarse = coarsen(&places, &triangles, 10.0, 1);
        assert!(coarse.fine.contains(&2));
        assert!(!coarse.triangles.is_empty());
    }
}
