//! One surface over the whole hole of a cluster: a robust thin plate with tension (algorithms D.3).

use crate::plate::Plate;
use crate::water::Water;
use glam::DVec2;
use lacuna_mesh::{Clamp, Fans, PlaneFit, stiffness};
use lacuna_solve::{Factor, SolveError, Solver, SparseSymmetric, Triplet};
use thiserror::Error;

/// A triangulated region in plan, and what is known of its heights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Places, metres.
    pub places: Vec<DVec2>,
    /// Triangles, counter-clockwise, of area above zero.
    pub triangles: Vec<[u32; 3]>,
    /// The original surface: rims and the rings behind them; `None` where heights are wanted.
    pub data: Vec<Option<Datum>>,
    /// Typical length of a rim edge, metres.
    pub edge_m: f64,
    /// Radius of the largest disk that fits into the hole, about, metres.
    pub radius_m: f64,
    /// The surface that the hole settles on, if it is water.
    pub water: Option<Water>,
}

/// A known height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Datum {
    /// Metres.
    pub height_m: f64,
    /// How much it counts, 1 for a vertex of the undisturbed surface.
    pub weight: f64,
    /// True for a vertex of the contour: the surface must end there exactly.
    pub is_exact: bool,
}

/// What the fit may vary. Lengths are in rim edges: scenes differ in scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldParams {
    /// Length over which data are smoothed, rim edges; `None`: what predicts held-back data best.
    pub smoothing_edges: Option<f64>,
    /// Tension, times 1 / radius^2.
    pub tension: f64,
    /// Residuals below this are noise at the least, rim edges.
    pub noise_floor_edges: f64,
    /// How far, as a share of the data's range, the surface may leave that range before tension is raised.
    pub overshoot: f64,
}

impl Default for FieldParams {
    fn default() -> Self {
        Self { smoothing_edges: None, tension: 1.0, noise_floor_edges: 0.05, overshoot: 0.25 }
    }
}

/// Heights over a region, and how they came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeightField {
    /// One for each place, metres; data that are exact come back unchanged.
    pub heights_m: Vec<f64>,
    /// Share of the data that the fit took for outliers.
    pub outlier_share: f64,
    /// How often tension was raised fourfold against overshoot.
    pub tension_steps: u32,
    /// The smoothing length that was used, rim edges.
    pub smoothing_edges: f64,
}

/// Why a cluster has no field.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FieldError {
    /// The linear system could not be solved.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Rounded to its tile's numbers a contour has other vertices than with exact ones.
    #[error("the tile's number type is too coarse for the contour")]
    OtherContour,
    /// A part of the region hangs on no height.
    #[error("a part of the hole has no surface round it")]
    NoData,
    /// A vertex of a part has no triangle that counts.
    #[error("a vertex of the patch has no triangle in plan")]
    LooseVertex,
}

/// Smoothing lengths to choose from, rim edges.
const SMOOTHING_EDGES: [f64; 4] = [0.1, 0.35, 0.7, 1.4];
/// One datum in so many is held back to choose.
const HELD_BACK: usize = 5;
/// Share of the held-back residuals that count: the largest may be outliers.
const COUNTED_SHARE: f64 = 0.8;
/// A longer smoothing length must predict better by this share: the shorter one keeps more of the ground.
const BETTER: f64 = 0.98;
/// Rounds of Huber and then of Tukey weights; their widths in standard deviations.
const HUBER_ROUNDS: usize = 3;
const TUKEY_ROUNDS: usize = 4;
const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
/// What is left of an outlier's weight: the system stays definite.
const REJECTED: f64 = 1e-6;
/// Standard deviation over median absolute deviation.
const DEVIATION: f64 = 1.4826;
/// How often tension is raised fourfold.
const TENSION_STEPS: u32 = 6;
/// Reach of the correction that joins the rim, rim edges.
const REACH_EDGES: f64 = 3.0;

/// Distance in which the surface settles on water, at least, rim edges.
const SETTLING_EDGES: f64 = 3.0;
/// Slope of banks that rise to the rim's spread within that distance.
const BANK_SLOPE: f64 = 0.2;

/// Fits the surface and joins it to the exact data.
///
/// Minimises `sum of w m (z - d)^2 + l^4 (bending + tension * stretching)` over all places: m the lumped area, d the data,
/// l the smoothing length; w starts as given and is reweighted by the residuals (Huber, then Tukey; scale from their
/// median, never below the noise floor). Where data leave a residual on exact places, a correction that dies out within a
/// few rim edges carries it: `(K + M / reach^2) c = 0` inside, c = residual on the rim. If the surface leaves the range of
/// the data, tension is raised. Over water every wanted place is drawn to its plane, `m (z - plane)^2 l^4 / d^4`: the
/// surface leaves the rim with its slope and settles within d, about.
///
/// # Errors
/// [`FieldError::NoData`] if a part of the region hangs on no datum, [`FieldError::Solve`].
pub fn height_field(
    region: &Region,
    params: &FieldParams,
    solver: &dyn Solver,
) -> Result<HeightField, FieldError> {
    check_data(region)?;
    let known = region.places.iter().zip(&region.data);
    let trend = PlaneFit::weighted(known.filter_map(|(p, d)| d.map(|d| (p.extend(d.height_m), d.weight))));
    let plate = Plate::new(&region.places, &region.triangles);
    let data: Vec<Option<Datum>> = region
        .data
        .iter()
        .zip(&region.places)
        .map(|(datum, &p)| datum.map(|d| Datum { height_m: d.height_m - trend.at(p), ..d }))
        .collect();
    let pull = region.water.map(|w| {
        let settling_m = (SETTLING_EDGES * region.edge_m).max(w.spread_m / BANK_SLOPE);
        Pull {
            weight: settling_m.powi(-4),
            heights: region.places.iter().map(|&p| w.plane.at(p) - trend.at(p)).collect(),
        }
    });
    let mut fit = Fit::new(region, &plate, &data, pull, params, solver)?;
    let smoothing_edges = match params.smoothing_edges {
        Some(given) => given,
        None => fit.best_smoothing(region.edge_m)?,
    };
    fit.set_smoothing(smoothing_edges * region.edge_m);
    fit.refactor()?;
    let (z, tension_steps) = fit.solve_guarded()?;
    let z = joined(region, &data, z, solver)?;
    let heights_m = (0..z.len())
        .map(|v| match region.data[v] {
            Some(datum) if datum.is_exact => datum.height_m,
            _ => z[v] + trend.at(region.places[v]),
        })
        .collect();
    Ok(HeightField { heights_m, outlier_share: fit.outlier_share(), tension_steps, smoothing_edges })
}

/// Every vertex must be joined by triangles to a datum that counts.
fn check_data(region: &Region) -> Result<(), FieldError> {
    let fans = Fans::new(region.places.len(), &region.triangles);
    let mut reached: Vec<bool> = region.data.iter().map(|d| d.is_some_and(|d| d.weight > 0.0)).collect();
    let mut front: Vec<u32> = (0..reached.len() as u32).filter(|&v| reached[v as usize]).collect();
    while let Some(v) = front.pop() {
        for &corner in fans.of(v).iter().flat_map(|&t| &region.triangles[t as usize]) {
            if !std::mem::replace(&mut reached[corner as usize], true) {
                front.push(corner);
            }
        }
    }
    if reached.iter().all(|&r| r) { Ok(()) } else { Err(FieldError::NoData) }
}

/// What draws the wanted places to a water surface.
struct Pull {
    /// 1 / m4.
    weight: f64,
    /// Height of the water at each place, metres.
    heights: Vec<f64>,
}

/// A fit in work.
struct Fit<'a> {
    plate: &'a Plate<'a>,
    data: &'a [Option<Datum>],
    pull: Option<Pull>,
    params: &'a FieldParams,
    /// Tension before it is raised, 1 / m2.
    tension: f64,
    /// Smoothing length to the fourth.
    length4: f64,
    /// Least standard deviation of the data, metres.
    floor_m: f64,
    energy: SparseSymmetric,
    factor: Box<dyn Factor>,
    /// Robust weight of each datum.
    robust: Vec<f64>,
}

impl<'a> Fit<'a> {
    fn new(
        region: &Region,
        plate: &'a Plate<'a>,
        data: &'a [Option<Datum>],
        pull: Option<Pull>,
        params: &'a FieldParams,
        solver: &dyn Solver,
    ) -> Result<Self, SolveError> {
        let tension = params.tension / (region.radius_m * region.radius_m);
        let energy = plate.matrix(tension)?;
        let length4 = region.edge_m.powi(4);
        let robust = vec![1.0; data.len()];
        let diagonal = diagonal(plate, data, pull.as_ref(), &robust, length4);
        let factor = solver.factor(&energy.plus_diagonal(&diagonal)?)?;
        let floor_m = params.noise_floor_edges * region.edge_m;
        Ok(Self { plate, data, pull, params, tension, length4, floor_m, energy, factor, robust })
    }

    fn set_smoothing(&mut self, length_m: f64) {
        self.length4 = length_m.powi(4);
    }

    /// The smoothing length, in edges, whose surface comes nearest to data that it has not seen: the noise of the rim
    /// asks for a long one, the shape of the ground for a short one.
    fn best_smoothing(&mut self, edge_m: f64) -> Result<f64, SolveError> {
        let mut best = (SMOOTHING_EDGES[0], f64::INFINITY);
        for edges in SMOOTHING_EDGES {
            self.set_smoothing(edges * edge_m);
            let error = self.held_back_error()?;
            if error < BETTER * best.1 {
                best = (edges, error);
            }
        }
        self.robust.fill(1.0);
        Ok(best.0)
    }

    /// Mean residual of held-back data, the largest left out.
    fn held_back_error(&mut self) -> Result<f64, SolveError> {
        let data: Vec<usize> = (0..self.data.len()).filter(|&v| self.data[v].is_some()).collect();
        let held: Vec<usize> = data.iter().copied().skip(HELD_BACK / 2).step_by(HELD_BACK).collect();
        let hold_back = |fit: &mut Self| held.iter().for_each(|&v| fit.robust[v] = 0.0);
        self.robust.fill(1.0);
        hold_back(self);
        self.refactor()?;
        let z = self.solve()?;
        self.reweight(&z, true);
        hold_back(self);
        self.refactor()?;
        let z = self.solve()?;
        let residual = |&v: &usize| self.data[v].map_or(0.0, |d| (z[v] - d.height_m).abs());
        let mut residuals: Vec<f64> = held.iter().map(residual).collect();
        residuals.sort_by(f64::total_cmp);
        residuals.truncate(((residuals.len() as f64 * COUNTED_SHARE).ceil() as usize).max(1));
        Ok(residuals.iter().sum::<f64>() / residuals.len().max(1) as f64)
    }

    /// Solves with more and more tension until the surface keeps to the range of its data; the last one stands.
    fn solve_guarded(&mut self) -> Result<(Vec<f64>, u32), SolveError> {
        let mut z = self.solve_robust()?;
        let mut step = 0;
        // Water may lie below all its banks.
        while step < TENSION_STEPS && self.pull.is_none() && !self.is_in_range(&z) {
            step += 1;
            self.energy = self.plate.matrix(self.tension * 4f64.powi(step as i32))?;
            self.robust.fill(1.0);
            self.refactor()?;
            z = self.solve_robust()?;
        }
        Ok((z, step))
    }

    fn solve_robust(&mut self) -> Result<Vec<f64>, SolveError> {
        let mut z = self.solve()?;
        for round in 0..HUBER_ROUNDS + TUKEY_ROUNDS {
            self.reweight(&z, round < HUBER_ROUNDS);
            self.refactor()?;
            z = self.solve()?;
        }
        Ok(z)
    }

    fn solve(&self) -> Result<Vec<f64>, SolveError> {
        let diagonal = diagonal(self.plate, self.data, self.pull.as_ref(), &self.robust, self.length4);
        let of_water = |v: usize| self.pull.as_ref().map_or(0.0, |p| p.heights[v]);
        let height = |v: usize| self.data[v].map_or_else(|| of_water(v), |d| d.height_m);
        let mut z: Vec<f64> = diagonal.iter().enumerate().map(|(v, w)| w * height(v)).collect();
        self.factor.solve(&mut z)?;
        Ok(z)
    }

    fn refactor(&mut self) -> Result<(), SolveError> {
        let diagonal = diagonal(self.plate, self.data, self.pull.as_ref(), &self.robust, self.length4);
        self.factor.refactor(&self.energy.plus_diagonal(&diagonal)?)
    }

    fn reweight(&mut self, z: &[f64], is_huber: bool) {
        let residual = |v: usize| self.data[v].map(|d| (z[v] - d.height_m).abs());
        let mut sizes: Vec<f64> = (0..z.len()).filter_map(residual).collect();
        if sizes.is_empty() {
            return;
        }
        let middle = sizes.len() / 2;
        let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let scale = (DEVIATION * median).max(self.floor_m);
        for v in 0..z.len() {
            let Some(r) = residual(v) else { continue };
            self.robust[v] = if is_huber {
                (HUBER * scale / r.max(1e-300)).min(1.0)
            } else {
                let t = r / (TUKEY * scale);
                if t < 1.0 { ((1.0 - t * t) * (1.0 - t * t)).max(REJECTED) } else { REJECTED }
            };
        }
    }

    /// True if no height leaves the range of the data that count by more than the share allowed.
    fn is_in_range(&self, z: &[f64]) -> bool {
        let counted = (0..z.len()).filter(|&v| self.robust[v] > 0.5);
        let heights = counted.filter_map(|v| self.data[v].map(|d| d.height_m));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let slack = self.params.overshoot * (high - low) + self.floor_m;
        let is_wanted = |v: usize| self.data[v].is_none();
        (0..z.len()).filter(|&v| is_wanted(v)).all(|v| z[v] >= low - slack && z[v] <= high + slack)
    }

    fn outlier_share(&self) -> f64 {
        let data = self.data.iter().flatten().count();
        let rejected = (0..self.data.len()).filter(|&v| self.data[v].is_some() && self.robust[v] <= REJECTED);
        rejected.count() as f64 / data.max(1) as f64
    }
}

/// Weights of data and water on the matrix's diagonal.
fn diagonal(
    plate: &Plate<'_>,
    data: &[Option<Datum>],
    pull: Option<&Pull>,
    robust: &[f64],
    length4: f64,
) -> Vec<f64> {
    let pulled = pull.map_or(0.0, |p| p.weight);
    let weight = |v: usize| data[v].map_or(pulled, |d| d.weight * robust[v] / length4);
    (0..data.len()).map(|v| weight(v) * plate.mass_m2[v]).collect()
}

/// Adds to the fitted surface what it misses on the exact data, fading out over a few rim edges.
fn joined(
    region: &Region,
    data: &[Option<Datum>],
    mut z: Vec<f64>,
    solver: &dyn Solver,
) -> Result<Vec<f64>, SolveError> {
    let reach_m = REACH_EDGES * region.edge_m;
    let stiffness = stiffness(&region.places, &region.triangles, Clamp::Off);
    let mut number = vec![u32::MAX; data.len()];
    let free: Vec<u32> = (0..data.len() as u32).filter(|&v| data[v as usize].is_none()).collect();
    free.iter().zip(0u32..).for_each(|(&v, k)| number[v as usize] = k);
    if free.is_empty() {
        return Ok(z);
    }
    let residual = |v: u32| match data[v as usize] {
        Some(d) if d.is_exact => d.height_m - z[v as usize],
        _ => 0.0,
    };
    let mut triplets = Vec::with_capacity(stiffness.entries.len());
    let mut rhs = vec![0.0; free.len()];
    for &(row, column, value) in &stiffness.entries {
        match (number[row as usize], number[column as usize]) {
            (u32::MAX, u32::MAX) => {}
            (k, u32::MAX) => rhs[k as usize] -= value * residual(column),
            (u32::MAX, k) => rhs[k as usize] -= value * residual(row),
            (row, column) => triplets.push(Triplet { row, column, value }),
        }
    }
    let screen = free.iter().zip(0u32..).map(|(&v, k)| {
        let value = stiffness.mass[v as usize] / (reach_m * reach_m);
        Triplet { row: k, column: k, value }
    });
    triplets.extend(screen);
    let matrix = SparseSymmetric::from_triplets(free.len(), &triplets)?;
    solver.factor(&matrix)?.solve(&mut rhs)?;
    free.iter().zip(rhs).for_each(|(&v, c)| z[v as usize] += c);
    Ok(z)
}
