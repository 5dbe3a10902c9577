//! The energy of a thin plate with tension over a plane triangulation.

use glam::DVec2;
use lacuna_mesh::{Fans, closed_fans};
use lacuna_solve::{SolveError, SparseSymmetric};

/// A triangulation with what its plate energy is made of: gradients of the hat functions, areas, complete vertices.
pub(crate) struct Plate<'a> {
    pub(crate) places: &'a [DVec2],
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) fans: Fans,
    /// Vertices whose triangles close round them: they have a Hessian; others take part as neighbours only, which is the
    /// natural condition of a free edge.
    has_hessian: Vec<bool>,
    /// A third of the areas of each vertex's triangles, square metres.
    pub(crate) mass_m2: Vec<f64>,
}

impl<'a> Plate<'a> {
    /// All triangles must be counter-clockwise with an area above zero.
    pub(crate) fn new(places: &'a [DVec2], triangles: &'a [[u32; 3]]) -> Self {
        let mut plate = Self {
            places,
            triangles,
            fans: Fans::new(places.len(), triangles),
            has_hessian: closed_fans(places.len(), triangles),
            mass_m2: vec![0.0; places.len()],
        };
        for &corners in triangles {
            let third = plate.area(corners) / 3.0;
            corners.iter().for_each(|&v| plate.mass_m2[v as usize] += third);
        }
        plate
    }

    /// The matrix of `sum over complete vertices of M |H z|^2 + tension * integral of |grad z|^2`; its pattern does not
    /// depend on `tension` (1 / m2, above zero). H is the Hessian of the piecewise linear surface in the mean over a
    /// vertex's triangles, `H_ab = -(1/M) sum of A (d_a hat)(d_b z)`, M the lumped area.
    ///
    /// Affine surfaces alone have no bending energy, so that free edges are well-posed where the squared Laplacian, which
    /// any harmonic surface makes zero, is not.
    ///
    /// Source: Stein, Grinspun, Wardetzky, Jacobson 2018 (natural boundary conditions for smoothing in geometry
    /// processing, sec. 4.3); for inner vertices the same surface as algorithms D.3.
    pub(crate) fn matrix(&self, tension: f64) -> Result<SparseSymmetric, SolveError> {
        let count = self.places.len();
        let stencils = self.stencils();
        let (mut starts, mut rows, mut values) = (vec![0u32], vec![], vec![]);
        rows.reserve(ENTRIES_A_PLACE * count);
        values.reserve(ENTRIES_A_PLACE * count);
        let mut column = Column::new(count);
        for j in 0..count as u32 {
            column.start(j);
            self.add_bending(j, &stencils, &mut column);
            self.add_stretching(j, tension, &mut column);
            column.found.sort_unstable();
            rows.extend_from_slice(&column.found);
            values.extend(column.found.iter().map(|&row| column.sum[row as usize]));
            let end = u32::try_from(rows.len());
            let what = || "more than 2^32 matrix entries".to_owned();
            starts.push(end.map_err(|_| SolveError::TooLarge { order: count, what: what() })?);
        }
        SparseSymmetric::from_sorted_columns(starts, rows, values)
    }

    /// Adds `M |H z|^2` of a vertex and its neighbours to column `j`.
    fn add_bending(&self, j: u32, stencils: &Stencils, column: &mut Column) {
        let fan = self.fans.of(j).iter().flat_map(|&t| self.triangles[t as usize]);
        let mut around: Vec<u32> = fan.filter(|&v| self.has_hessian[v as usize]).collect();
        around.sort_unstable();
        around.dedup();
        for v in around {
            let stencil = stencils.of(v);
            let Some(own) = stencil.iter().find(|e| e.0 == j) else { continue };
            let mass = self.mass_m2[v as usize];
            for (k, weight) in [(0, mass), (1, 2.0 * mass), (2, mass)] {
                let scale = weight * own.1[k];
                stencil.iter().for_each(|(u, h)| column.add(*u, scale * h[k]));
            }
        }
    }

    /// Adds `tension * integral of |grad z|^2` to column `j`.
    fn add_stretching(&self, j: u32, tension: f64, column: &mut Column) {
        for &t in self.fans.of(j) {
            let corners = self.triangles[t as usize];
            let Some(own) = corners.iter().position(|&c| c == j) else { continue };
            let gradients = self.gradients(corners);
            let weight = tension * self.area(corners);
            for axis in 0..2 {
                let scale = weight * gradients[own][axis];
                (0..3).for_each(|k| column.add(corners[k], scale * gradients[k][axis]));
            }
        }
    }

    fn stencils(&self) -> Stencils {
        let mut stencils = Stencils { starts: vec![0], entries: Vec::with_capacity(7 * self.places.len()) };
        for v in 0..self.places.len() as u32 {
            if self.has_hessian[v as usize] {
                self.push_hessian(v, &mut stencils.entries);
            }
            stencils.starts.push(stencils.entries.len() as u32);
        }
        stencils
    }

    /// Appends the Hessian at a vertex: for it and each neighbour xx, xy and yy.
    fn push_hessian(&self, v: u32, entries: &mut Vec<(u32, [f64; 3])>) {
        let mass = self.mass_m2[v as usize];
        let first = entries.len();
        for &t in self.fans.of(v) {
            let corners = self.triangles[t as usize];
            let gradients = self.gradients(corners);
            let Some(own) = corners.iter().position(|&c| c == v) else { continue };
            let scale = -self.area(corners) / mass;
            for (&corner, g) in corners.iter().zip(gradients) {
                let a = gradients[own] * scale;
                let addend = [a.x * g.x, 0.5 * (a.x * g.y + a.y * g.x), a.y * g.y];
                match entries[first..].iter_mut().find(|e| e.0 == corner) {
                    Some((_, sum)) => (0..3).for_each(|k| sum[k] += addend[k]),
                    None => entries.push((corner, addend)),
                }
            }
        }
    }

    fn area(&self, corners: [u32; 3]) -> f64 {
        let [a, b, c] = corners.map(|v| self.places[v as usize]);
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Gradients of the three hat functions of a triangle.
    fn gradients(&self, corners: [u32; 3]) -> [DVec2; 3] {
        let [a, b, c] = corners.map(|v| self.places[v as usize]);
        let twice = (b - a).perp_dot(c - a);
        [(c - b).perp() / twice, (a - c).perp() / twice, (b - a).perp() / twice]
    }
}

/// Entries of the lower triangle a place has, about: half of a place's two rings.
const ENTRIES_A_PLACE: usize = 11;

/// The Hessians of all vertices that have one.
struct Stencils {
    starts: Vec<u32>,
    entries: Vec<(u32, [f64; 3])>,
}

impl Stencils {
    fn of(&self, v: u32) -> &[(u32, [f64; 3])] {
        &self.entries[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}

/// A column of the lower triangle in work.
struct Column {
    index: u32,
    seen: Vec<u32>,
    sum: Vec<f64>,
    found: Vec<u32>,
}

impl Column {
    fn new(count: usize) -> Self {
        Self { index: 0, seen: vec![u32::MAX; count], sum: vec![0.0; count], found: vec![] }
    }

    fn start(&mut self, index: u32) {
        self.index = index;
        self.found.clear();
        self.add(index, 0.0);
    }

    fn add(&mut self, row: u32, value: f64) {
        if row < self.index {
            return;
        }
        if self.seen[row as usize] != self.index {
            self.seen[row as usize] = self.index;
            self.sum[row as usize] = 0.0;
            self.found.push(row);
        }
        self.sum[row as usize] += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An uneven grid of `n` by `n` places and its triangles.
    fn grid(n: u32) -> (Vec<DVec2>, Vec<[u32; 3]>) {
        let shake = |k: u32| 0.2 * libm::sin(f64::from(k) * 12.9898);
        let place = |k: u32| DVec2::new(f64::from(k % n) + shake(k), f64::from(k / n) + shake(k + 77));
        let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
        let triangles = quads.flat_map(|k| [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]).collect();
        ((0..n * n).map(place).collect(), triangles)
    }

    fn energy(matrix: &SparseSymmetric, z: &[f64]) -> f64 {
        let product = matrix.multiply(z).expect("as many heights as places");
        z.iter().zip(product).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn planes_do_not_bend_and_parabolas_do() {
        let (places, triangles) = grid(12);
        let matrix = Plate::new(&places, &triangles).matrix(1e-300).expect("small");
        let of =
            |z: &dyn Fn(DVec2) -> f64| energy(&matrix, &places.iter().map(|&p| z(p)).collect::<Vec<_>>());
        assert!(of(&|p| 3.0 + 2.0 * p.x - p.y).abs() < 1e-9);
        // The Hessian of x y is harmonic, of x^2 is not: both bend, |H|^2 = 2 and 4 over the inner 10 x 10 squares.
        for (z, density) in [(&(|p: DVec2| p.x * p.y) as &dyn Fn(DVec2) -> f64, 2.0), (&|p| p.x * p.x, 4.0)] {
            let share = of(z) / (density * 100.0);
            assert!((0.9..1.3).contains(&share), "{share}");
        }
    }

    #[test]
    fn tension_is_the_area_of_slopes() {
        let (places, triangles) = grid(8);
        let plate = Plate::new(&places, &triangles);
        let z: Vec<f64> = places.iter().map(|p| 2.0 * p.x + p.y).collect();
        let area: f64 = triangles.iter().map(|&t| plate.area(t)).sum();
        assert!((plate.mass_m2.iter().sum::<f64>() - area).abs() < 1e-9);
        let matrix = plate.matrix(0.5).expect("small");
        assert!((energy(&matrix, &z) - 0.5 * 5.0 * area).abs() < 1e-9);
    }
}
