//! Pockets: pieces of rim that stand or hang over others are triangulated in 3D and replaced by their chord.

use crate::FillError;
use crate::ring_dp::{Ring3d, RingWeight, triangulate_ring};
use crate::weld::Welded;
use glam::{DVec2, DVec3};
use lacuna_mesh::{Meeting, segments_cross, signed_area};
use std::collections::BTreeMap;

/// Most vertices of a pocket's chain when it is first tried, and after widening.
const CHAIN: usize = 64;
const WIDEST: usize = 128;
/// Largest share of the hole's area in plan that one pocket may have: a bow-tie's lobe is no pocket.
const SHARE: f64 = 0.2;
/// Places closer than this are one place in plan, metres.
const SAME_PLACE_M: f64 = 1e-6;

/// An edge of a ring: from place `at` to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RingEdge {
    pub(crate) ring: u32,
    pub(crate) at: u32,
}

/// Cuts pockets off rings. Rings and pockets name contour vertices as they come, so that no ring names one twice.
pub(crate) struct Cutter<'a> {
    pub(crate) rings: Vec<Vec<u32>>,
    pub(crate) pockets: Vec<[u32; 3]>,
    points: &'a [DVec2],
    positions: &'a [DVec3],
    rim: &'a Welded<'a>,
    /// Third corner of the triangle behind each edge that is on a ring now.
    apexes: BTreeMap<[u32; 2], DVec3>,
    area: f64,
}

impl<'a> Cutter<'a> {
    pub(crate) fn new(rim: &'a Welded<'a>, points: &'a [DVec2], positions: &'a [DVec3]) -> Self {
        let (mut rings, mut apexes, mut first) = (vec![], BTreeMap::new(), 0u32);
        for ring in rim.contour.rings() {
            let n = ring.vertices.len() as u32;
            rings.push((first..first + n).collect::<Vec<u32>>());
            for (i, edge) in ring.edges.iter().enumerate() {
                let ends = [first + i as u32, first + (i as u32 + 1) % n];
                apexes.extend(edge.apex.map(|apex| (ends, apex)));
            }
            first += n;
        }
        let area = signed_area(&rings[0].iter().map(|&v: &u32| points[v as usize]).collect::<Vec<_>>()).abs();
        Self { rings, pockets: vec![], points, positions, rim, apexes, area }
    }

    /// Cuts one triangle for every edge whose ends share a place in plan, on the side where it bends less (E.3.1).
    pub(crate) fn cut_vertical_edges(&mut self) -> Result<(), FillError> {
        for r in 0..self.rings.len() {
            let mut i = 0;
            while i < self.rings[r].len() && self.rings[r].len() > 3 {
                let n = self.rings[r].len();
                let [before, a, b, after] =
                    [(i + n - 1) % n, i, (i + 1) % n, (i + 2) % n].map(|k| self.rings[r][k]);
                if self.points[a as usize].distance(self.points[b as usize]) >= SAME_PLACE_M {
                    i += 1;
                    continue;
                }
                let ears = [[before, a, b], [a, b, after]];
                let free: Vec<[u32; 3]> =
                    ears.into_iter().filter(|ear| self.is_allowed(ear[0], ear[2])).collect();
                let ear = free.into_iter().min_by(|x, y| self.ear_bend(*x).total_cmp(&self.ear_bend(*y)));
                let Some(ear) = ear else {
                    return Err(no_way("both chords of a vertical rim edge already exist"));
                };
                self.pockets.push(ear);
                self.inherit_apex(&[ear]);
                self.rings[r].retain(|&v| v != ear[1]);
                i = i.saturating_sub(2);
            }
        }
        Ok(())
    }

    /// Cuts a pocket for every contact that no other pocket of this round overlaps; returns how many (E.3.2).
    pub(crate) fn cut_pockets(&mut self, contacts: &[(RingEdge, RingEdge)]) -> Result<usize, FillError> {
        let mut ranges: Vec<(u32, usize, usize)> = vec![];
        for &(a, b) in contacts {
            let n = self.rings[a.ring as usize].len();
            let (i, j) = (a.at as usize, b.at as usize);
            // Places from the start of one edge to the end of the other, the shorter way round.
            let inner = (i, j + 2 - i);
            let outer = (j, i + n + 2 - j);
            let (start, count) = if inner.1 <= outer.1 { inner } else { outer };
            let Some((start, count)) = self.widen(a.ring as usize, start, count) else { continue };
            let overlaps = |&(r, s, c): &(u32, usize, usize)| {
                r == a.ring && ((start + n - s) % n < c || (s + n - start) % n < count)
            };
            if !ranges.iter().any(overlaps) {
                ranges.push((a.ring, start, count));
            }
        }
        let mut behind: Vec<u32> = vec![];
        for &(ring, start, count) in &ranges {
            self.fill_pocket(ring as usize, start, count)?;
            behind.extend(&self.chain(ring as usize, start, count)[1..count - 1]);
        }
        behind.sort_unstable();
        for ring in &mut self.rings {
            ring.retain(|v| behind.binary_search(v).is_err());
        }
        Ok(ranges.len())
    }

    /// The smallest chain round the given one whose chord crosses nothing and is not in the mesh yet.
    fn widen(&self, r: usize, start: usize, count: usize) -> Option<(usize, usize)> {
        let n = self.rings[r].len();
        if count > CHAIN {
            return None;
        }
        for more in 0..=(WIDEST - count) / 2 {
            let (start, count) = ((start + n - more % n) % n, count + 2 * more);
            if count + 1 > n {
                return None;
            }
            let (a, b) = (self.rings[r][start], self.rings[r][(start + count - 1) % n]);
            if self.is_allowed(a, b) && self.is_small(r, start, count) && self.chord_is_clear(r, start, count)
            {
                return Some((start, count));
            }
        }
        None
    }

    fn is_allowed(&self, a: u32, b: u32) -> bool {
        !self.rim.is_joined(a, b)
    }

    fn chain(&self, r: usize, start: usize, count: usize) -> Vec<u32> {
        let ring = &self.rings[r];
        (0..count).map(|k| ring[(start + k) % ring.len()]).collect()
    }

    fn is_small(&self, r: usize, start: usize, count: usize) -> bool {
        let chain: Vec<DVec2> =
            self.chain(r, start, count).into_iter().map(|v| self.points[v as usize]).collect();
        signed_area(&chain).abs() <= SHARE * self.area
    }

    /// True if the chord meets no edge of any ring but its neighbours and the chain it replaces.
    fn chord_is_clear(&self, r: usize, start: usize, count: usize) -> bool {
        let at = |v: u32| self.points[v as usize];
        let chain = self.chain(r, start, count);
        let (a, b) = (chain[0], chain[count - 1]);
        if at(a).distance(at(b)) < SAME_PLACE_M {
            return false;
        }
        self.rings.iter().enumerate().all(|(other, ring)| {
            let n = ring.len();
            (0..n).all(|i| {
                let (c, d) = (ring[i], ring[(i + 1) % n]);
                let replaced = other == r && (i + n - start % n) % n < count - 1;
                let joins = [c, d].iter().any(|v| *v == a || *v == b);
                replaced || joins || {
                    let meeting = segments_cross(at(a), at(b), at(c), at(d));
                    let touches = [c, d].map(|v| self.rim.first(v));
                    let in_vertex = [a, b].iter().any(|&v| touches.contains(&self.rim.first(v)));
                    meeting == Meeting::Apart || (meeting == Meeting::Touching && in_vertex)
                }
            })
        })
    }

    fn fill_pocket(&mut self, r: usize, start: usize, count: usize) -> Result<(), FillError> {
        let chain = self.chain(r, start, count);
        let positions: Vec<DVec3> = chain.iter().map(|&v| self.positions[v as usize]).collect();
        let mut apexes: Vec<Option<DVec3>> =
            chain.windows(2).map(|w| self.apexes.get(&[w[0], w[1]]).copied()).collect();
        apexes.push(None);
        let forbidden = self.rim.forbidden_in(&chain);
        let ring = Ring3d { points: &positions, apexes: &apexes, forbidden: &forbidden };
        let Some(triangles) = triangulate_ring(&ring, RingWeight::AngleThenArea) else {
            return Err(no_way("a pocket of the rim has no triangulation without existing edges"));
        };
        let triangles: Vec<[u32; 3]> =
            triangles.into_iter().map(|t| t.map(|place| chain[place as usize])).collect();
        self.inherit_apex(&triangles);
        self.pockets.extend(triangles);
        Ok(())
    }

    /// Gives each chord of new pocket triangles the corner behind it.
    fn inherit_apex(&mut self, triangles: &[[u32; 3]]) {
        for &[a, b, c] in triangles {
            for (ends, apex) in [([b, a], c), ([c, b], a), ([a, c], b)] {
                self.apexes.entry(ends).or_insert(self.positions[apex as usize]);
            }
        }
    }

    fn ear_bend(&self, [a, b, c]: [u32; 3]) -> f64 {
        let ends = [a, b, c].map(|v| self.positions[v as usize]);
        let apexes = [[a, b], [b, c]].map(|e| self.apexes.get(&e).copied());
        let normal = (ends[1] - ends[0]).cross(ends[2] - ends[0]);
        if normal == DVec3::ZERO {
            return f64::INFINITY;
        }
        let bend = |from: DVec3, to: DVec3, apex: Option<DVec3>| {
            let other = apex.map_or(DVec3::ZERO, |apex| (from - to).cross(apex - to));
            let product = normal.length() * other.length();
            if product > 0.0 { 1.0 - normal.dot(other) / product } else { 1.0 }
        };
        bend(ends[0], ends[1], apexes[0]).max(bend(ends[1], ends[2], apexes[1]))
    }
}

fn no_way(what: &str) -> FillError {
    FillError::NoTriangulation { what: what.to_owned() }
}
