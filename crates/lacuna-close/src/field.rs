//! Method `field`: one height field a cluster gives every cell its part (algorithms D.3).

use crate::Curves;
use crate::contour::{Source, closing_source};
use crate::flat_water::flat_water;
use crate::height_field::{FieldError, FieldParams, HeightField, height_field, height_field_bytes};
use crate::region::{ClusterRegion, FieldPart, Joint, cluster_region, rim_points};
use crate::sloped_water::sloped_water;
use crate::strip::lines;
use crate::water::{RimPoint, Water, forced_water, given_water, water};
use lacuna_hole::{Plan, Surveys};
use lacuna_mesh::PlaneFit;
use lacuna_solve::Solver;
use std::collections::{BTreeMap, BTreeSet};

/// The heights that a cluster's field gives to what its cells bring.
#[derive(Clone, Debug, Default)]
pub struct ClusterField {
    /// Heights of the new vertices of each part's triangulation, metres.
    pub new_m: Vec<Vec<f64>>,
    joints: BTreeMap<Joint, f64>,
    /// Places in the region.
    pub places: usize,
    /// Places of the largest system that was solved for them: fewer if the region was coarsened.
    pub unknowns: usize,
    /// Share of the surrounding vertices that were taken for outliers.
    pub outlier_share: f64,
    /// How often tension was raised against overshoot.
    pub tension_steps: u32,
    /// Smoothing length, rim edges.
    pub smoothing_edges: f64,
    /// The water that the surface settles on.
    pub water: Option<Water>,
}

/// Whether a cluster is water.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WaterRule {
    /// If its rim shows a level.
    #[default]
    Auto,
    /// No.
    Off,
    /// Yes, at the level that its rim comes nearest to.
    Force,
    /// Yes, at this height, metres.
    Level(f64),
    /// Yes, and it falls along the hole between these heights, metres: see [`sloped_water`].
    Sloped {
        /// At one end.
        from_m: f64,
        /// At the other.
        to_m: f64,
    },
}

impl WaterRule {
    /// The water of a hole with this rim; `width_m` is the hole's width, `edge_m` the length of its rim edges.
    #[must_use]
    pub fn water(self, rim: &[RimPoint], width_m: f64, edge_m: f64) -> Option<Water> {
        match self {
            Self::Off => None,
            Self::Auto => water(rim, width_m, edge_m),
            Self::Force => forced_water(rim),
            Self::Level(level_m) => Some(given_water(rim, PlaneFit { level_m, ..PlaneFit::default() })),
            Self::Sloped { from_m, to_m } => Some(given_water(rim, sloped_water(rim, from_m, to_m))),
        }
    }
}

/// Fits one surface over all parts of a cluster. Where that is water, by `rule`, it is the water's plane up to the rim.
///
/// # Errors
/// [`FieldError`]; the cluster can still be filled by `layered`.
pub fn field(
    surveys: &Surveys,
    plan: &Plan,
    parts: &[FieldPart<'_>],
    params: &FieldParams,
    rule: WaterRule,
    solver: &dyn Solver,
) -> Result<ClusterField, FieldError> {
    if parts.iter().any(|p| p.contour.contour.len() != p.triangulation.contour_vertices) {
        return Err(FieldError::OtherContour);
    }
    let ClusterRegion { region, new, joints } = cluster_region(surveys, plan, parts);
    let water = rule.water(&rim_points(parts), 2.0 * region.radius_m, region.edge_m);
    if water.is_none() && parts.iter().any(|p| !p.hole.passed_under.is_empty()) {
        return Err(FieldError::DryIslands);
    }
    let HeightField { heights_m, outlier_share, tension_steps, smoothing_edges, unknowns } = match &water {
        Some(water) => HeightField { heights_m: flat_water(&region, &water.plane), ..HeightField::default() },
        None => height_field(&region, params, solver)?,
    };
    let height = |v: u32| heights_m.get(v as usize).copied();
    let heights = |ids: &Vec<u32>| ids.iter().map(|&v| height(v).ok_or(FieldError::LooseVertex)).collect();
    Ok(ClusterField {
        new_m: new.iter().map(heights).collect::<Result<_, _>>()?,
        joints: joints.into_iter().filter_map(|(joint, v)| Some((joint, height(v)?))).collect(),
        places: region.places.len(),
        unknowns,
        outlier_share,
        tension_steps,
        smoothing_edges,
        water,
    })
}

/// What a place of a region takes, and what building the region takes for it, bytes.
const REGION_BYTES: u64 = 100;
/// The nearest rim vertex and the height of a place.
const WATER_BYTES: u64 = 40;

/// Memory that [`field`] takes at its peak, bytes, measured on the cluster's own system. Measuring takes
/// [`measuring_bytes`] itself.
///
/// # Errors
/// As [`field`].
pub fn field_bytes(
    surveys: &Surveys,
    plan: &Plan,
    parts: &[FieldPart<'_>],
    params: &FieldParams,
    rule: WaterRule,
    solver: &dyn Solver,
) -> Result<u64, FieldError> {
    let region = cluster_region(surveys, plan, parts).region;
    let of_region = (REGION_BYTES + WATER_BYTES) * region.places.len() as u64;
    // Known water is no system.
    match rule.water(&rim_points(parts), 2.0 * region.radius_m, region.edge_m) {
        Some(_) => Ok(of_region),
        None => Ok(height_field_bytes(&region, params, solver)? + of_region),
    }
}

/// What [`field_bytes`] takes for a region of so many places, bytes: the region, the matrix and its order, no factor.
#[must_use]
pub fn measuring_bytes(places: u64, params: &FieldParams) -> u64 {
    let solved = places.min(params.max_unknowns as u64);
    (REGION_BYTES + COARSENING_BYTES) * places + SYSTEM_BYTES * solved
}

/// Fans and triangles of a region while places are taken out.
const COARSENING_BYTES: u64 = 150;
/// Hessians, matrix, and the order of elimination, a place.
const SYSTEM_BYTES: u64 = 700;

/// Writes a field's heights, and where the lines of two cells differ its slope across the border, into the curves.
pub fn raise_curves(plan: &Plan, field: &ClusterField, curves: &mut Curves) {
    let closing: BTreeSet<u32> = field
        .joints
        .keys()
        .filter_map(|joint| match joint {
            Joint::Closing(point) => Some(point.curve),
            Joint::Corner(_) | Joint::Square(_) => None,
        })
        .collect();
    for (joint, &z) in &field.joints {
        let height = match joint {
            Joint::Corner(corner) => curves.corners.get_mut(corner).map(|p| &mut p.z),
            Joint::Square(p) => curves.squares.get_mut(&p.corner).and_then(|h| h.get_mut(usize::from(p.at))),
            Joint::Closing(_) => None,
        };
        if let Some(height) = height {
            *height = z;
        }
        if let Joint::Closing(p) = joint {
            let points = &mut curves.curves[p.curve as usize];
            if (1..points.strip.lanes).contains(&p.lane) {
                points.between_m.insert((p.point, p.lane), z);
            }
        }
    }
    for c in closing {
        raise_curve(plan, field, c, curves);
    }
}

fn raise_curve(plan: &Plan, field: &ClusterField, c: u32, curves: &mut Curves) {
    let curve = &plan.curves[c as usize];
    let [low, high] = lines(plan, curve);
    let lanes = curves.curves[c as usize].strip.lanes;
    let joint = |source| match source {
        Source::Closing(point) => field.joints.get(&Joint::Closing(point)),
        Source::Square(point) => field.joints.get(&Joint::Square(point)),
        _ => None,
    };
    for k in 0..curves.curves[c as usize].inner.len() {
        let height = |lane| joint(closing_source(plan, curves, c, (k, lane))).copied();
        let Some(at_low) = height(0) else { continue };
        let at_high = height(lanes).unwrap_or(at_low);
        let slope = if high > low { (at_high - at_low) / (high - low) } else { 0.0 };
        let points = &mut curves.curves[c as usize];
        points.inner[k].z = at_low + slope * (curve.line - low);
        points.slope[k] = slope;
    }
}
