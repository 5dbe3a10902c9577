//! The irregular triangulated lattice of one cell (and of a halo round it).
//!
//! Plan coordinates are integers in units of 2^-10 m, so that f32 and decimal files hold them exactly. Every cell has
//! n x n quads; a quad is cut along its shorter diagonal that lies inside. Triangle `2q` of quad `q` is the one on its
//! south side, `2q + 1` the one on its north side.

use crate::area::{Cell, Side};
use crate::random::{hash, unit};

/// Lattice units a metre.
pub const UNITS_PER_M: f64 = 1024.0;

/// How far a node may stand from its even place, as a share of the step (below 1/4 all quads are convex).
const JITTER: f64 = 0.24;

/// No second triangle in this quadrant of a fan.
const NONE: usize = usize::MAX;

/// How tiles meet at cell borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Neighbours share their border vertices.
    Exact,
    /// Every tile ends `margin` units outside its cell and is triangulated apart.
    Overrun {
        /// Lattice units.
        margin: i64,
    },
    /// Border vertices stand up to `reach` units inside or outside the border, in every tile apart.
    Ragged {
        /// Lattice units.
        reach: i64,
    },
}

/// What all lattices of a scene have in common.
#[derive(Clone, Copy, Debug)]
pub struct LatticeRule {
    /// Quads along a cell's side.
    pub quads: i64,
    /// Side of a cell, lattice units.
    pub cell_size: i64,
    /// Border rule.
    pub cut: Cut,
    /// Key of the jitter.
    pub seed: i64,
}

/// Nodes and cuts of a rectangle of quads.
#[derive(Clone, Debug)]
pub struct Lattice {
    cell: Cell,
    quads: i64,
    halo: i64,
    own: bool,
    /// Plan coordinates of the nodes, row by row from the south-west, lattice units.
    pub nodes: Vec<[i64; 2]>,
    rising: Vec<bool>,
}

impl Lattice {
    /// The lattice of a cell with `halo` more quads on all sides (0 unless the cut is exact).
    #[must_use]
    pub fn new(rule: &LatticeRule, cell: Cell, halo: i64) -> Self {
        let across = rule.quads + 2 * halo;
        let nodes = (0..=across)
            .flat_map(|b| (0..=across).map(move |a| [a - halo, b - halo]))
            .map(|steps| rule.node(cell, steps))
            .collect();
        let own = rule.cut != Cut::Exact;
        let mut lattice = Self { cell, quads: rule.quads, halo, own, nodes, rising: Vec::new() };
        lattice.rising = (0..across * across).map(|q| lattice.cuts_rising(q as usize)).collect();
        lattice
    }

    /// Quads along a side, halo included.
    #[must_use]
    pub fn across(&self) -> usize {
        (self.quads + 2 * self.halo) as usize
    }

    /// Quads along a side of the cell.
    #[must_use]
    pub fn quads(&self) -> usize {
        self.quads as usize
    }

    /// Quads between the lattice's outline and the cell.
    #[must_use]
    pub fn halo(&self) -> usize {
        self.halo as usize
    }

    /// The cell in the middle.
    #[must_use]
    pub fn cell(&self) -> Cell {
        self.cell
    }

    /// True if the tile is triangulated apart from its neighbours.
    #[must_use]
    pub fn is_own(&self) -> bool {
        self.own
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        2 * self.rising.len()
    }

    /// The node in column `a`, row `b`.
    #[must_use]
    pub fn node_index(&self, a: usize, b: usize) -> usize {
        b * (self.across() + 1) + a
    }

    /// The quad in column `a`, row `b`.
    #[must_use]
    pub fn quad_index(&self, a: usize, b: usize) -> usize {
        b * self.across() + a
    }

    /// Column and row of a quad.
    #[must_use]
    pub fn quad_place(&self, quad: usize) -> [usize; 2] {
        [quad % self.across(), quad / self.across()]
    }

    /// True if the quad is cut from its south-west to its north-east corner.
    #[must_use]
    pub fn is_rising(&self, quad: usize) -> bool {
        self.rising[quad]
    }

    /// The cell a quad belongs to.
    #[must_use]
    pub fn cell_of(&self, quad: usize) -> Cell {
        let [a, b] = self.quad_place(quad);
        let cell = |k: usize, start: i64| start + (k as i64 - self.halo).div_euclid(self.quads);
        [cell(a, self.cell[0]), cell(b, self.cell[1])]
    }

    /// True if the quad belongs to the cell in the middle.
    #[must_use]
    pub fn is_inner(&self, quad: usize) -> bool {
        let [a, b] = self.quad_place(quad);
        let inner = self.halo()..self.halo() + self.quads();
        inner.contains(&a) && inner.contains(&b)
    }

    /// True if the line of nodes number `k` (column or row) is a border between cells.
    #[must_use]
    pub fn is_cell_line(&self, k: usize) -> bool {
        (k as i64 - self.halo).rem_euclid(self.quads) == 0
    }

    /// The triangle's corners as node indices, counter-clockwise.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [usize; 3] {
        let quad = triangle / 2;
        let [a, b] = self.quad_place(quad);
        let sw = self.node_index(a, b);
        let (se, nw) = (sw + 1, sw + self.across() + 1);
        let ne = nw + 1;
        match (self.rising[quad], triangle % 2) {
            (true, 0) => [sw, se, ne],
            (true, _) => [sw, ne, nw],
            (false, 0) => [sw, se, nw],
            (false, _) => [se, ne, nw],
        }
    }

    /// The quad's triangle that has its side `side`.
    #[must_use]
    pub fn triangle_at(&self, quad: usize, side: Side) -> usize {
        let rising = usize::from(self.rising[quad]);
        2 * quad
            + match side {
                Side::South => 0,
                Side::North => 1,
                Side::East => 1 - rising,
                Side::West => rising,
            }
    }

    /// The triangles beyond the three edges; `None` beyond the lattice's outline.
    #[must_use]
    pub fn neighbours(&self, triangle: usize) -> [Option<usize>; 3] {
        let quad = triangle / 2;
        let south_east = [Side::South, Side::East];
        let south_west = [Side::South, Side::West];
        let sides = match (self.rising[quad], triangle % 2) {
            (true, 0) => south_east,
            (true, _) => [Side::North, Side::West],
            (false, 0) => south_west,
            (false, _) => [Side::North, Side::East],
        };
        [Some(triangle ^ 1), self.across_side(quad, sides[0]), self.across_side(quad, sides[1])]
    }

    fn across_side(&self, quad: usize, side: Side) -> Option<usize> {
        let [a, b] = self.quad_place(quad);
        let last = self.across() - 1;
        match side {
            Side::South => (b > 0).then(|| self.triangle_at(quad - self.across(), Side::North)),
            Side::North => (b < last).then(|| self.triangle_at(quad + self.across(), Side::South)),
            Side::East => (a < last).then(|| self.triangle_at(quad + 1, Side::West)),
            Side::West => (a > 0).then(|| self.triangle_at(quad - 1, Side::East)),
        }
    }

    /// The triangles round a node counter-clockwise from the east, by quadrant (north-east, north-west, south-west,
    /// south-east): one or two a quadrant, none where the lattice ends.
    #[must_use]
    pub fn fan(&self, a: usize, b: usize) -> [[Option<usize>; 2]; 4] {
        let last = self.across();
        let (east, west, north, south) = (a < last, a > 0, b < last, b > 0);
        let quad = |left: usize, down: usize| self.quad_index(a - left, b - down);
        let quadrant = |exists: bool, left: usize, down: usize, order: [[usize; 2]; 2]| {
            if !exists {
                return [None, None];
            }
            let q = quad(left, down);
            order[usize::from(self.rising[q])].map(|half| (half != NONE).then(|| 2 * q + half))
        };
        [
            quadrant(north && east, 0, 0, [[0, NONE], [0, 1]]),
            quadrant(north && west, 1, 0, [[1, 0], [0, NONE]]),
            quadrant(south && west, 1, 1, [[1, NONE], [1, 0]]),
            quadrant(south && east, 0, 1, [[0, 1], [1, NONE]]),
        ]
    }

    fn cuts_rising(&self, quad: usize) -> bool {
        let [a, b] = self.quad_place(quad);
        let at = |a: usize, b: usize| self.nodes[self.node_index(a, b)];
        let [sw, se, ne, nw] = [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)];
        let rising_fits = is_left_turn(sw, se, ne) && is_left_turn(sw, ne, nw);
        let falling_fits = is_left_turn(sw, se, nw) && is_left_turn(se, ne, nw);
        match (rising_fits, falling_fits) {
            (true, true) => squared_distance(sw, ne) <= squared_distance(se, nw),
            (rising, _) => rising,
        }
    }
}

fn is_left_turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> bool {
    (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
}

fn squared_distance(a: [i64; 2], b: [i64; 2]) -> i64 {
    (a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2)
}

impl LatticeRule {
    /// Place of the node `steps` quads from the cell's south-west corner, lattice units.
    fn node(&self, cell: Cell, steps: [i64; 2]) -> [i64; 2] {
        let bits = match self.cut {
            Cut::Exact => {
                let [i, j] = [0, 1].map(|k| cell[k] * self.quads + steps[k]);
                hash(&[self.seed, i, j])
            }
            _ => hash(&[self.seed, cell[0], cell[1], steps[0], steps[1]]),
        };
        [0, 1].map(|axis| self.coordinate(cell[axis], steps[axis], hash(&[bits as i64, axis as i64])))
    }

    fn coordinate(&self, cell: i64, step: i64, bits: u64) -> i64 {
        let (margin, reach) = match self.cut {
            Cut::Exact => (0, 0.0),
            Cut::Overrun { margin } => (margin, 0.0),
            Cut::Ragged { reach } => (0, reach as f64),
        };
        let span = self.cell_size + 2 * margin;
        let even = cell * self.cell_size - margin + (step * span).div_euclid(self.quads);
        let on_border = step.rem_euclid(self.quads) == 0;
        let amplitude = if on_border { reach } else { JITTER * span as f64 / self.quads as f64 };
        even + ((unit(bits) * 2.0 - 1.0) * amplitude).round() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(cut: Cut) -> LatticeRule {
        LatticeRule { quads: 13, cell_size: 100 * 1024, cut, seed: 5 }
    }

    const CUTS: [Cut; 3] = [Cut::Exact, Cut::Overrun { margin: 102 }, Cut::Ragged { reach: 3000 }];

    #[test]
    fn every_triangle_faces_up_and_the_neighbours_share_two_corners() {
        for cut in CUTS {
            let lattice = Lattice::new(&rule(cut), [3, -2], 0);
            for t in 0..lattice.triangle_count() {
                let corners = lattice.corners(t);
                let [a, b, c] = corners.map(|v| lattice.nodes[v]);
                assert!(is_left_turn(a, b, c), "{cut:?} {t}");
                for other in lattice.neighbours(t).into_iter().flatten() {
                    let shared = lattice.corners(other).iter().filter(|v| corners.contains(v)).count();
                    assert_eq!(shared, 2);
                    assert!(lattice.neighbours(other).contains(&Some(t)));
                }
            }
        }
    }

    #[test]
    fn a_fan_holds_the_nodes_triangles_in_turning_order() {
        let lattice = Lattice::new(&rule(Cut::Exact), [0, 0], 2);
        let n = lattice.across();
        for (a, b) in (0..=n).flat_map(|b| (0..=n).map(move |a| (a, b))) {
            let node = lattice.node_index(a, b);
            let fan: Vec<usize> = lattice.fan(a, b).into_iter().flatten().flatten().collect();
            let mut all: Vec<usize> =
                (0..lattice.triangle_count()).filter(|&t| lattice.corners(t).contains(&node)).collect();
            let mut sorted = fan.clone();
            sorted.sort_unstable();
            all.sort_unstable();
            assert_eq!(sorted, all, "node {a},{b}");
            if a > 0 && a < n && b > 0 && b < n {
                for k in 0..fan.len() {
                    assert!(
                        lattice.neighbours(fan[k]).contains(&Some(fan[(k + 1) % fan.len()])),
                        "node {a},{b}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_halo_is_the_neighbours_own_lattice() {
        let (west, east) =
            (Lattice::new(&rule(Cut::Exact), [0, 0], 3), Lattice::new(&rule(Cut::Exact), [1, 0], 0));
        for b in 0..=13 {
            for a in 0..=3 {
                assert_eq!(
                    west.nodes[west.node_index(13 + 3 + a, b + 3)],
                    east.nodes[east.node_index(a, b)],
                    "column {a}, row {b}"
                );
            }
        }
    }
}
