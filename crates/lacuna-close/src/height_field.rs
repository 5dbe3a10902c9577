//! One surface over the whole hole of a cluster: a robust thin plate with tension (algorithms D.3).

use crate::blocks::{Block, block, split};
use crate::coarsen::coarsen;
use crate::fit::{Chosen, Problem, choose, fit, outlier_share};
use crate::plate::Plate;
use crate::refine::{Refinement, core_limit, refine};
use crate::rim_join::join_rim;
use crate::sample::{Sample, Spot};
use glam::DVec2;
use lacuna_mesh::{Fans, PlaneFit};
use lacuna_solve::{SolveError, Solver};
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
    /// Tension, times 1 / radius^2; `None`: what predicts held-back arcs of the rim best.
    pub tension: Option<f64>,
    /// Residuals below this are noise at the least, rim edges.
    pub noise_floor_edges: f64,
    /// How far, as a share of the data's range, the surface may leave that range before tension is raised.
    pub overshoot: f64,
    /// Places that one solve may have; a region with more is fitted on a coarser triangulation first.
    pub max_unknowns: usize,
}

impl Default for FieldParams {
    fn default() -> Self {
        Self {
            smoothing_edges: None,
            tension: None,
            noise_floor_edges: 0.05,
            overshoot: 0.25,
            max_unknowns: usize::MAX,
        }
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
    /// Places of the largest system that was solved.
    pub unknowns: usize,
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
    /// Islands hover, but with them the rim shows no water.
    #[error("with all islands that stay the rim shows no water")]
    DryIslands,
    /// A vertex of a part has no triangle that counts.
    #[error("a vertex of the patch has no triangle in plan")]
    LooseVertex,
}

/// Fits the surface and joins it to the exact data.
///
/// Minimises `sum of w m (z - d)^2 + l^4 (bending + tension * stretching)` over all places: m the lumped area, d the data,
/// l the smoothing length; w starts as given and is reweighted by the residuals (Huber, then Tukey; scale from their
/// median, never below the noise floor). Where data leave a residual on exact places, a correction that dies out within a
/// few rim edges carries it. If the surface leaves the range of the data, tension is raised.
///
/// A region of more than `max_unknowns` places is fitted on a coarser triangulation of that many, to all its data; from
/// there the same energy is minimised on all places, block by block.
///
/// # Errors
/// [`FieldError::NoData`] if a part of the region hangs on no datum, [`FieldError::Solve`].
pub fn height_field(
    region: &Region,
    params: &FieldParams,
    solver: &dyn Solver,
) -> Result<HeightField, FieldError> {
    check_data(region)?;
    let ground = Ground::new(region);
    let (mut field, plane_field) = if region.places.len() <= params.max_unknowns {
        ground.fitted(region, params, solver)?
    } else {
        ground.fitted_coarsely(region, params, solver)?
    };
    let mut z = plane_field;
    join_rim(region, |v| ground.height_m(region, v), &mut z)?;
    field.heights_m = (0..z.len())
        .map(|v| match region.data[v] {
            Some(datum) if datum.is_exact => datum.height_m,
            _ => z[v] + ground.trend.at(region.places[v]),
        })
        .collect();
    Ok(field)
}

/// What a place takes while its region is fitted, beside the system: samples, fans, areas, heights.
const FIT_BYTES: u64 = 240;
/// The same for the places of the whole region where a coarser one is fitted.
const REFINE_BYTES: u64 = 180;
/// What a wanted place takes while the surface is joined to the rim: its Laplacian as triplets and as columns.
const JOIN_BYTES: u64 = 500;
/// Copies of the matrix at the peak: energy, with data, and the factor's.
const MATRIX_COPIES: u64 = 3;

/// Memory that [`height_field`] takes at its peak beside `region` itself, bytes: measured on the system's own matrix.
///
/// # Errors
/// As [`height_field`].
pub(crate) fn height_field_bytes(
    region: &Region,
    params: &FieldParams,
    solver: &dyn Solver,
) -> Result<u64, FieldError> {
    let system = |places: &[DVec2], triangles: &[[u32; 3]]| -> Result<u64, FieldError> {
        let matrix = Plate::new(places, triangles).matrix(tension(region))?;
        let copies = MATRIX_COPIES * matrix.bytes();
        Ok(copies + solver.factor_bytes(&matrix)? + FIT_BYTES * places.len() as u64)
    };
    let joining = JOIN_BYTES * region.data.iter().filter(|d| d.is_none()).count() as u64;
    if region.places.len() <= params.max_unknowns {
        return Ok(system(&region.places, &region.triangles)?.max(joining));
    }
    let coarse = coarsen(&region.places, &region.triangles, region.edge_m, params.max_unknowns);
    let refining = REFINE_BYTES * region.places.len() as u64;
    Ok((system(&coarse.places, &coarse.triangles)? + refining).max(joining))
}

/// A region's heights without their trend, which no energy sees: numbers stay small however high the ground is.
struct Ground {
    trend: PlaneFit,
    is_wanted: Vec<bool>,
}

impl Ground {
    fn new(region: &Region) -> Self {
        let known = region.places.iter().zip(&region.data);
        let trend =
            PlaneFit::weighted(known.filter_map(|(p, d)| d.map(|d| (p.extend(d.height_m), d.weight))));
        Self { trend, is_wanted: region.data.iter().map(Option::is_none).collect() }
    }

    /// Height of a datum over the trend, metres.
    fn height_m(&self, region: &Region, v: usize) -> Option<f64> {
        region.data[v].map(|d| d.height_m - self.trend.at(region.places[v]))
    }

    fn samples(&self, region: &Region, mass_m2: &[f64], spot: impl Fn(usize) -> Spot) -> Vec<Sample> {
        let sample = |v: usize| {
            let height_m = self.height_m(region, v)?;
            Some(Sample { spot: spot(v), height_m, mass_m2: region.data[v]?.weight * mass_m2[v] })
        };
        (0..region.places.len()).filter_map(sample).collect()
    }

    fn fitted(&self, region: &Region, params: &FieldParams, solver: &dyn Solver) -> Fitted {
        let plate = Plate::new(&region.places, &region.triangles);
        let samples = self.samples(region, &plate.mass_m2, |v| Spot::vertex(v as u32));
        let problem = Problem {
            plate: &plate,
            samples: &samples,
            is_wanted: &self.is_wanted,
            params,
            edge_m: region.edge_m,
            tension: tension(region),
        };
        let fitted = fit(&problem, solver)?;
        let field = HeightField {
            outlier_share: outlier_share(&fitted.robust),
            tension_steps: fitted.tension_steps,
            smoothing_edges: fitted.smoothing_edges,
            unknowns: region.places.len(),
            ..HeightField::default()
        };
        Ok((field, fitted.heights_m))
    }

    fn fitted_coarsely(&self, region: &Region, params: &FieldParams, solver: &dyn Solver) -> Fitted {
        let whole = Plate::new(&region.places, &region.triangles);
        let chosen = self.chosen_on_part(region, &whole, params, solver)?;
        let given = FieldParams {
            smoothing_edges: Some(chosen.smoothing_edges),
            tension: Some(chosen.tension),
            ..*params
        };
        let coarse = coarsen(&region.places, &region.triangles, region.edge_m, params.max_unknowns);
        let plate = Plate::new(&coarse.places, &coarse.triangles);
        let mut samples = self.samples(region, &whole.mass_m2, |v| coarse.spots[v]);
        let wanted: Vec<bool> = coarse.fine.iter().map(|&v| self.is_wanted[v as usize]).collect();
        let problem = Problem {
            plate: &plate,
            samples: &samples,
            is_wanted: &wanted,
            params: &given,
            edge_m: region.edge_m,
            tension: tension(region),
        };
        let fitted = fit(&problem, solver)?;
        let mut z: Vec<f64> = coarse.spots.iter().map(|spot| spot.height(&fitted.heights_m)).collect();
        let unknowns = coarse.places.len();
        drop(coarse);
        let data = (0..region.places.len() as u32).filter(|&v| region.data[v as usize].is_some());
        samples.iter_mut().zip(data).for_each(|(sample, v)| sample.spot = Spot::vertex(v));
        let refinement = Refinement {
            plate: &whole,
            samples: &samples,
            params,
            edge_m: region.edge_m,
            tension: fitted.tension,
            length_m: fitted.smoothing_edges * region.edge_m,
        };
        let robust = refine(&refinement, fitted.robust, &mut z, solver)?;
        let field = HeightField {
            outlier_share: outlier_share(&robust),
            tension_steps: fitted.tension_steps,
            smoothing_edges: fitted.smoothing_edges,
            unknowns,
            ..HeightField::default()
        };
        Ok((field, z))
    }

    /// Smoothing and tension by the part of a large region that has most data: coarse triangles see neither.
    fn chosen_on_part(
        &self,
        region: &Region,
        whole: &Plate<'_>,
        params: &FieldParams,
        solver: &dyn Solver,
    ) -> Result<Chosen, FieldError> {
        let parts = split(&region.places, core_limit(params));
        let data = |part: &&Vec<u32>| part.iter().filter(|&&v| !self.is_wanted[v as usize]).count();
        // `max_by_key` takes the last of equals; reversed, that is the first.
        let core = parts.iter().rev().max_by_key(data).map_or(&[][..], Vec::as_slice);
        let Block { members, triangles, .. } = block(core, 0, &region.triangles, &whole.fans);
        let places: Vec<DVec2> = members.iter().map(|&v| region.places[v as usize]).collect();
        let sample = |(k, &v): (u32, &u32)| {
            let v = v as usize;
            let mass_m2 = region.data[v]?.weight * whole.mass_m2[v];
            Some(Sample { spot: Spot::vertex(k), height_m: self.height_m(region, v)?, mass_m2 })
        };
        let samples: Vec<Sample> = (0..).zip(&members).filter_map(sample).collect();
        let is_wanted: Vec<bool> = members.iter().map(|&v| self.is_wanted[v as usize]).collect();
        let problem = Problem {
            plate: &Plate::new(&places, &triangles),
            samples: &samples,
            is_wanted: &is_wanted,
            params,
            edge_m: region.edge_m,
            tension: tension(region),
        };
        Ok(choose(&problem, solver)?)
    }
}

/// A field without its heights, and the fitted surface over the trend.
type Fitted = Result<(HeightField, Vec<f64>), FieldError>;

/// The tension by which others are measured, 1 / m2: it shows at the hole's own size alone.
fn tension(region: &Region) -> f64 {
    1.0 / (region.radius_m * region.radius_m)
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
