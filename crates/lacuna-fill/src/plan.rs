//! Is a contour a set of simple, nested rings in the plane? Pockets are cut until it is.

use crate::FillError;
use crate::pocket::{Cutter, RingEdge};
use glam::{DVec2, DVec3};
use lacuna_mesh::{Contour, Location, contains, find_meetings, signed_area};

/// Rings that are simple in the plane, and the pockets that were cut off to make them so.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanRings {
    /// Contour vertices, outer ring first; without the vertices that lie behind pockets.
    pub(crate) rings: Vec<Vec<u32>>,
    /// Pocket triangles: vertical or overhanging.
    pub(crate) pockets: Vec<[u32; 3]>,
}

/// Most rounds of cutting; each round cuts every pocket that stands alone.
const ROUNDS: usize = 40;

/// Makes rings simple in the plane (algorithms E.3): cuts one vertical triangle for each edge without length in the
/// plane, then a pocket for each piece of rim that crosses or touches its own ring; then checks orientation and
/// nesting. With `with_pockets` false nothing is cut.
///
/// `points` are the contour's vertices in the plane, `heights` in the frame.
///
/// # Errors
/// [`FillError::CrossingRim`] if rings cross each other or no pocket helps, [`FillError::BadRings`] for orientation and
/// nesting, [`FillError::NoTriangulation`] if a pocket can't be filled.
pub(crate) fn plan_rings(
    contour: &Contour,
    points: &[DVec2],
    positions: &[DVec3],
    with_pockets: bool,
) -> Result<PlanRings, FillError> {
    let mut cutter = Cutter::new(contour, points, positions);
    if with_pockets {
        cutter.cut_vertical_edges()?;
    }
    for _ in 0..ROUNDS {
        let found = contacts(points, &cutter.rings);
        let Some(&(first, _)) = found.first() else {
            check_nesting(points, &cutter.rings)?;
            return Ok(PlanRings { rings: cutter.rings, pockets: cutter.pockets });
        };
        let vertex = cutter.rings[first.ring as usize][first.at as usize];
        let across: Option<&(RingEdge, RingEdge)> = found.iter().find(|(a, b)| a.ring != b.ring);
        if !with_pockets || across.is_some() || cutter.cut_pockets(&found)? == 0 {
            return Err(FillError::CrossingRim { vertex });
        }
        cutter.cut_vertical_edges()?;
    }
    Err(FillError::CrossingRim { vertex: 0 })
}

/// Pairs of ring edges that meet where they should not.
fn contacts(points: &[DVec2], rings: &[Vec<u32>]) -> Vec<(RingEdge, RingEdge)> {
    let places = places_of(points, rings);
    let slices: Vec<&[DVec2]> = places.iter().map(Vec::as_slice).collect();
    let edges: Vec<RingEdge> = rings
        .iter()
        .zip(0u32..)
        .flat_map(|(ring, r)| (0..ring.len() as u32).map(move |at| RingEdge { ring: r, at }))
        .collect();
    find_meetings(&slices).iter().map(|pair| (edges[pair.first], edges[pair.second])).collect()
}

fn places_of(points: &[DVec2], rings: &[Vec<u32>]) -> Vec<Vec<DVec2>> {
    rings.iter().map(|ring| ring.iter().map(|&v| points[v as usize]).collect()).collect()
}

fn check_nesting(points: &[DVec2], rings: &[Vec<u32>]) -> Result<(), FillError> {
    let places = places_of(points, rings);
    for (r, ring) in places.iter().enumerate() {
        let area = signed_area(ring);
        if ring.len() < 3 || area == 0.0 || (area > 0.0) != (r == 0) {
            let name = if r == 0 { "the outer ring".to_owned() } else { format!("island {r}") };
            return Err(bad(format!("{name} runs the wrong way round or encloses nothing")));
        }
    }
    for (r, ring) in places.iter().enumerate().skip(1) {
        let inside = |other: &Vec<DVec2>| contains(other, ring[0]) == Location::Inside;
        let holders = places.iter().enumerate().filter(|&(o, other)| o != r && inside(other)).count();
        if !inside(&places[0]) || holders != 1 {
            return Err(bad(format!("island {r} lies outside the outer ring or in another island")));
        }
    }
    Ok(())
}

fn bad(what: String) -> FillError {
    FillError::BadRings { what }
}
