//! Is a contour a set of simple, nested rings in the plane? Pockets are cut until it is.

use crate::FillError;
use crate::error::Crossing;
use crate::pocket::{Cutter, RingEdge};
use crate::weld::Welded;
use glam::{DVec2, DVec3};
use lacuna_mesh::{EdgePair, Location, Meeting, contains, find_meetings, signed_area};

/// Rings that are simple in the plane but for vertices in which they touch, and the pockets that were cut off to make
/// them so. All vertices are the first ones of their places.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanRings {
    /// Contour vertices, outer ring first; without the vertices that lie behind pockets.
    pub(crate) rings: Vec<Vec<u32>>,
    /// Pocket triangles: vertical or overhanging.
    pub(crate) pockets: Vec<[u32; 3]>,
}

/// Whether pockets may be cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pockets {
    /// They are cut where rings are not simple.
    Cut,
    /// Rings that are not simple are refused.
    Refused,
}

/// Most rounds of cutting; each round cuts every pocket that stands alone.
const ROUNDS: usize = 40;

/// Makes rings simple in the plane (algorithms E.3): cuts one vertical triangle for each edge without length in the
/// plane, then a pocket for each piece of rim that crosses its own ring or touches it other than in a common
/// vertex; then checks orientation and nesting. With [`Pockets::Refused`] nothing is cut.
///
/// `points` are the contour's vertices in the plane, `heights` in the frame.
///
/// # Errors
/// [`FillError::CrossingRim`] if rings cross each other or no pocket helps, [`FillError::BadRings`] for orientation and
/// nesting, [`FillError::NoTriangulation`] if a pocket can't be filled.
pub(crate) fn plan_rings(
    rim: &Welded<'_>,
    points: &[DVec2],
    positions: &[DVec3],
    allowed: Pockets,
) -> Result<PlanRings, FillError> {
    let mut cutter = Cutter::new(rim, points, positions);
    if allowed == Pockets::Cut {
        cutter.cut_vertical_edges()?;
    }
    for _ in 0..ROUNDS {
        let found = contacts(rim, points, &cutter.rings);
        let Some(&(first, _)) = found.first() else {
            check_nesting(points, &cutter.rings)?;
            return Ok(named_by_place(rim, cutter));
        };
        let start = |edge: RingEdge| cutter.rings[edge.ring as usize][edge.at as usize];
        if let Some(&(edge, _)) = found.iter().find(|(a, b)| a.ring != b.ring) {
            return Err(FillError::crossing(start(edge), Crossing::OtherRing));
        }
        let vertex = start(first);
        if allowed == Pockets::Refused {
            return Err(FillError::crossing(vertex, Crossing::ItSelf));
        }
        if cutter.cut_pockets(&found)? == 0 {
            return Err(FillError::crossing(vertex, Crossing::NoPocket));
        }
        cutter.cut_vertical_edges()?;
    }
    Err(FillError::crossing(cutter.rings[0][0], Crossing::NoPocket))
}

fn named_by_place(rim: &Welded<'_>, cutter: Cutter<'_>) -> PlanRings {
    let Cutter { mut rings, mut pockets, .. } = cutter;
    rings.iter_mut().flatten().for_each(|v| *v = rim.first(*v));
    pockets.iter_mut().flatten().for_each(|v| *v = rim.first(*v));
    PlanRings { rings, pockets }
}

/// Pairs of ring edges that meet where they should not: anywhere but in a common end.
fn contacts(rim: &Welded<'_>, points: &[DVec2], rings: &[Vec<u32>]) -> Vec<(RingEdge, RingEdge)> {
    let places = places_of(points, rings);
    let slices: Vec<&[DVec2]> = places.iter().map(Vec::as_slice).collect();
    let edges: Vec<RingEdge> = rings
        .iter()
        .zip(0u32..)
        .flat_map(|(ring, r)| (0..ring.len() as u32).map(move |at| RingEdge { ring: r, at }))
        .collect();
    let ends = |edge: RingEdge| {
        let ring = &rings[edge.ring as usize];
        let at = edge.at as usize;
        [ring[at], ring[(at + 1) % ring.len()]].map(|v| rim.first(v))
    };
    let is_contact = |pair: &EdgePair| {
        let [first, second] = [pair.first, pair.second].map(|e| ends(edges[e]));
        pair.meeting != Meeting::Touching || !first.iter().any(|v| second.contains(v))
    };
    let found = find_meetings(&slices);
    found.iter().filter(|pair| is_contact(pair)).map(|pair| (edges[pair.first], edges[pair.second])).collect()
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
        let inside = |other: &Vec<DVec2>| is_inside(ring, other);
        let holders = places.iter().enumerate().filter(|&(o, other)| o != r && inside(other)).count();
        if !inside(&places[0]) || holders != 1 {
            return Err(bad(format!("island {r} lies outside the outer ring or in another island")));
        }
    }
    Ok(())
}

/// True if a ring lies inside another one that it meets in vertices at most.
fn is_inside(ring: &[DVec2], other: &[DVec2]) -> bool {
    let middles = (0..ring.len()).map(|i| ring[i].midpoint(ring[(i + 1) % ring.len()]));
    let probes = ring.iter().copied().chain(middles);
    let clear = probes.map(|p| contains(other, p)).find(|&location| location != Location::OnEdge);
    clear == Some(Location::Inside)
}

fn bad(what: String) -> FillError {
    FillError::BadRings { what }
}
