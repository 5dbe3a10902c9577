//! The decision list: which filler takes a contour.

use crate::frame::Frame;
use crate::lift::{Lifted, fill_in_frame, vector_area};
use crate::min_area::min_area_patch;
use crate::plan::Pockets;
use crate::plane::best_fit_frame;
use crate::weld::{Welded, weld};
use crate::{FillError, FillParams, FillerChoice};
use glam::DVec3;
use lacuna_mesh::{Contour, Patch, PlanView, QualityStats, check_patch, side_of_line};
use lacuna_solve::Solver;
use std::fmt;

/// The filler that made a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filler {
    /// Constrained Delaunay triangulation seen from above.
    Delaunay,
    /// Liepa's minimum-area triangulation.
    MinArea,
    /// Constrained Delaunay triangulation in the contour's best-fit plane.
    Plane,
}

impl fmt::Display for Filler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Delaunay => "delaunay",
            Self::MinArea => "min_area",
            Self::Plane => "plane",
        })
    }
}

/// A patch and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// The patch.
    pub patch: Patch,
    /// Who made it.
    pub filler: Filler,
    /// Indices of pocket triangles: vertical or overhanging pieces of the rim, not judged from above. Ascending.
    pub vertical: Vec<u32>,
    /// True if every other triangle is counter-clockwise seen from above.
    pub in_plan: bool,
    /// Shape of the triangles in space, pocket triangles left out.
    pub quality: QualityStats,
}

/// Share of the rim's length whose triangles must look up for the plan view to be trusted, and the z of a unit normal
/// that counts as looking up.
const UPRIGHT_SHARE: f64 = 0.95;
const UPRIGHT: f64 = 0.15;
/// The plan view is trusted whatever the rim's triangles do if the contour itself is at most this steep (z of the unit
/// normal): a lake between quay walls is one.
const LEVEL: f64 = 0.5;

/// Fills a contour (algorithms E.1): constrained Delaunay from above where the rim is simple after pockets are cut,
/// else in the best-fit plane, else from above where steep triangles stand round a rim that looks up and needs no
/// pocket, else the minimum-area triangulation in 3D. Contour vertices keep their positions bit for bit; a patch that
/// fails its check is never returned.
///
/// Rings may touch each other and themselves in vertices (equal positions): those are one vertex, and triangles name the
/// first contour vertex at the place.
///
/// # Errors
/// [`FillError`]: its `is_refusal` tells a reason to skip from a failure.
pub fn fill(contour: &Contour, params: &FillParams, solver: &dyn Solver) -> Result<Filled, FillError> {
    fill_by_list(contour, params, solver).map_err(|e| e.with_place(contour))
}

fn fill_by_list(contour: &Contour, params: &FillParams, solver: &dyn Solver) -> Result<Filled, FillError> {
    check_input(contour, params)?;
    check_direction(contour)?;
    let rim = weld(contour)?;
    if params.filler == FillerChoice::MinArea {
        return fill_in_space(&rim, params, solver);
    }
    let is_trusted = is_plan_trusted(contour);
    let mut reason = None;
    if is_trusted {
        match fill_from_above(&rim, Pockets::Cut, params, solver) {
            Err(e) if is_about_plan(&e) => reason = Some(e),
            done => return done,
        }
    }
    match best_fit_frame(contour).map(|frame| fill_in_plane(&rim, frame, params, solver)) {
        Some(Err(e)) if is_about_plan(&e) => {}
        Some(done) => return done,
        None => {}
    }
    // Steps of a raster or a quay: steep, but simple from above as it is, where no triangle can turn over.
    if !is_trusted && level(contour) > UPRIGHT {
        match fill_from_above(&rim, Pockets::Refused, params, solver) {
            Err(e) if is_about_plan(&e) => reason = Some(e),
            done => return done,
        }
    }
    match space_refusal(&rim, params) {
        None if params.filler == FillerChoice::Auto => fill_in_space(&rim, params, solver),
        refusal => Err(reason.or(refusal).unwrap_or(FillError::UprightRim)),
    }
}

/// z of the unit vector along the outer ring's vector area: 1 for a level contour, 0 for a facade.
fn level(contour: &Contour) -> f64 {
    let outer: Vec<DVec3> = contour.outer.vertices.iter().map(|v| v.position).collect();
    vector_area(&outer).normalize_or_zero().z
}

fn fill_from_above(
    rim: &Welded<'_>,
    pockets: Pockets,
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Filled, FillError> {
    let frame = Frame::plan(&rim.contour.positions());
    let lifted = fill_in_frame(rim, frame, pockets, params, solver)?;
    finish(&rim.contour, lifted, Filler::Delaunay)
}

fn fill_in_plane(
    rim: &Welded<'_>,
    frame: Frame,
    params: &FillParams,
    solver: &dyn Solver,
) -> Result<Filled, FillError> {
    let lifted = fill_in_frame(rim, frame, Pockets::Refused, params, solver)?;
    finish(&rim.contour, lifted, Filler::Plane)
}

fn fill_in_space(rim: &Welded<'_>, params: &FillParams, solver: &dyn Solver) -> Result<Filled, FillError> {
    if let Some(refusal) = space_refusal(rim, params) {
        return Err(refusal);
    }
    let patch = min_area_patch(&rim.contour, params, solver)?;
    finish(&rim.contour, Lifted { patch, vertical: vec![] }, Filler::MinArea)
}

/// Why the 3D triangulation does not take a contour.
fn space_refusal(rim: &Welded<'_>, params: &FillParams) -> Option<FillError> {
    let vertices = rim.contour.len();
    if vertices > params.largest_ring {
        Some(FillError::TooManyVertices { vertices, limit: params.largest_ring })
    } else if !rim.contour.inner.is_empty() {
        Some(FillError::IslandsIn3d)
    } else {
        rim.touches.then_some(FillError::TouchingIn3d)
    }
}

/// True for reasons that another view of the contour may not have.
fn is_about_plan(reason: &FillError) -> bool {
    matches!(
        reason,
        FillError::CrossingRim { .. } | FillError::BadRings { .. } | FillError::NoTriangulation { .. }
    )
}

pub(crate) fn check_input(contour: &Contour, params: &FillParams) -> Result<(), FillError> {
    let malformed = |what: String| Err(FillError::Malformed { what });
    for ring in contour.rings() {
        if ring.vertices.len() < 3 || ring.edges.len() != ring.vertices.len() {
            return malformed(format!(
                "a ring has {} vertices and {} edges",
                ring.vertices.len(),
                ring.edges.len()
            ));
        }
    }
    let support = &contour.support;
    let count = contour.len() + support.vertices.len();
    if u32::try_from(count).is_err() || support.triangles.iter().flatten().any(|&v| v as usize >= count) {
        return malformed("a triangle behind the rim names a vertex that does not exist".to_owned());
    }
    let finite = |p: &DVec3| p.is_finite() && p.abs().max_element() < LARGEST_COORDINATE_M;
    if !contour.positions().iter().chain(&support.vertices).all(finite) {
        return malformed("a coordinate is not finite or beyond 1e12 m".to_owned());
    }
    if params.spacing_m.is_some_and(|s| s.is_nan() || s <= 0.0)
        || params.growth.is_nan()
        || params.overshoot.is_nan()
    {
        return malformed("spacing, growth or overshoot is not a sensible number".to_owned());
    }
    Ok(())
}

/// Refuses a contour that clearly looks down: the outer rim of a floating layer, not a hole.
pub(crate) fn check_direction(contour: &Contour) -> Result<(), FillError> {
    if level(contour) < -LEVEL {
        return Err(FillError::BadRings { what: "the outer ring runs the wrong way round".to_owned() });
    }
    Ok(())
}

/// Coordinates beyond this leave no digits for a patch.
const LARGEST_COORDINATE_M: f64 = 1e12;

/// True if the rim's triangles look up over nearly all of its length, or the contour itself is level (algorithms B.7).
fn is_plan_trusted(contour: &Contour) -> bool {
    if level(contour) >= LEVEL {
        return true;
    }
    let (mut upright, mut total) = (0.0, 0.0);
    for ring in contour.rings() {
        let n = ring.vertices.len();
        for (i, edge) in ring.edges.iter().enumerate() {
            let Some(apex) = edge.apex else { continue };
            let (a, b) = (ring.vertices[i].position, ring.vertices[(i + 1) % n].position);
            let normal = (a - b).cross(apex - b);
            let length = a.distance(b);
            total += length;
            if normal.z > UPRIGHT * normal.length() {
                upright += length;
            }
        }
    }
    total > 0.0 && upright >= UPRIGHT_SHARE * total
}

/// Whether a contour is taken from above, and with pockets or without: the decision list of [`fill`] without its other
/// views. Steep contours that a tilted plane shows are left to it.
pub(crate) fn pockets_from_above(contour: &Contour) -> Option<Pockets> {
    if is_plan_trusted(contour) {
        return Some(Pockets::Cut);
    }
    (level(contour) > UPRIGHT && best_fit_frame(contour).is_none()).then_some(Pockets::Refused)
}

/// Checks the patch and gathers its facts; nothing leaves this crate unchecked.
pub(crate) fn finish(contour: &Contour, lifted: Lifted, filler: Filler) -> Result<Filled, FillError> {
    let Lifted { patch, vertical } = lifted;
    let in_plan = filler == Filler::Delaunay;
    let view = if in_plan && vertical.is_empty() { PlanView::Judged } else { PlanView::NotJudged };
    check_patch(contour, &patch, view).map_err(|e| FillError::CheckFailed { what: e.to_string() })?;
    let mut positions = contour.positions();
    positions.extend_from_slice(&patch.vertices);
    let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
    let is_vertical = |t: usize| vertical.binary_search(&(t as u32)).is_ok();
    let judged =
        || (0..patch.triangles.len()).filter(|&t| !is_vertical(t)).map(|t| corners(&patch.triangles[t]));
    let is_judged_later = in_plan && view == PlanView::NotJudged;
    if is_judged_later && let Some([a, ..]) = judged().find(|c| !is_counter_clockwise(c)) {
        return Err(FillError::CheckFailed { what: format!("a triangle is turned over at {a}") });
    }
    let quality = QualityStats::of(judged());
    Ok(Filled { patch, filler, vertical, in_plan, quality })
}

fn is_counter_clockwise([a, b, c]: &[DVec3; 3]) -> bool {
    side_of_line(a.truncate(), b.truncate(), c.truncate()) > 0.0
}
