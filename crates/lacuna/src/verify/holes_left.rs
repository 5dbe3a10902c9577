//! Promise 7 from the tiles: a hole that the report calls filled is open nowhere.

use super::patch_mesh::{CellMesh, ORIGINAL};
use super::patches::place;
use super::plan_index::PlanIndex;
use super::verdict::Findings;
use crate::PolygonSet;
use glam::{DVec2, DVec3};
use lacuna_mesh::{Boundary, BoundaryLoop, loops, perimeter, signed_area};

/// Loops that are narrower are slits, metres (promise 5 judges them).
const SLIT_M: f64 = 0.005;
/// Lines on which places inside a loop are looked for.
const LINES: usize = 7;
/// Places looked at in each hole, across its longer extent.
const SAMPLES_ACROSS: f64 = 48.0;
/// Places nearer to an outline are never looked at: outlines are rounded to millimetres.
const INSET_M: f64 = 0.01;

/// A hole that the report calls filled.
pub(super) struct FilledHole<'a> {
    pub(super) id: &'a str,
    pub(super) outline: &'a PolygonSet,
}

/// Looks for the filled holes of a cell in its final mesh: (1) no boundary loop round missing surface lies inside one;
/// (2) places spread over each are covered by a triangle, seen from above. Also returns, for every boundary edge, whether it
/// belongs to such a loop. Places nearer than `inset_m` to an outline are not looked at: outlines are rounded, and those of
/// ragged tiles are drawn roughly along the border.
pub(super) fn check_filled(
    tile: &str,
    holes: &[FilledHole<'_>],
    cell: &CellMesh,
    boundary: &Boundary,
    inset_m: f64,
) -> (Findings, Vec<bool>) {
    let mut findings = Findings::default();
    findings.count("filled holes looked for", holes.len() as u64);
    let patches = surface(cell, |owner| owner != ORIGINAL);
    let mut is_open = vec![false; boundary.edges.len()];
    // Loops of triangles that face the other way are closed: promise 5 judges them.
    for open in loops(boundary).loops.into_iter().filter(|l| !l.has_conflict(boundary)) {
        if let Some(what) = open_loop(holes, &open, boundary, &patches) {
            open.edges.iter().for_each(|&e| is_open[e as usize] = true);
            findings.offend(format!("{tile} {what}"));
        }
    }
    check_cover(tile, holes, cell, &patches, inset_m.max(INSET_M), &mut findings);
    (findings, is_open)
}

/// What is open, if a loop runs round missing surface inside a filled hole that no patch covers.
fn open_loop(
    holes: &[FilledHole<'_>],
    open: &BoundaryLoop,
    boundary: &Boundary,
    patches: &PlanIndex,
) -> Option<String> {
    let ring: Vec<DVec2> = open.positions(boundary).iter().map(|p| p.truncate()).collect();
    let (area, length) = (signed_area(&ring), perimeter(&ring));
    if area <= 0.0 || 2.0 * area < SLIT_M * length {
        return None;
    }
    let bare: Vec<DVec2> =
        places_inside(&ring).into_iter().filter(|p| patches.over(*p).next().is_none()).collect();
    let in_hole = |p: &DVec2| holes.iter().find(|h| h.outline.contains(*p));
    let (at, hole) = bare.iter().find_map(|p| Some((*p, in_hole(p)?)))?;
    Some(format!("({}): {area:.3} m2 are still open {}", hole.id, place(at)))
}

/// Places inside a ring: the middles of the stretches that it cuts from some lines in east-west direction.
fn places_inside(ring: &[DVec2]) -> Vec<DVec2> {
    let south = ring.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let north = ring.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    let mut places = Vec::new();
    for line in 0..LINES {
        let y = south + (north - south) * (line as f64 + 0.5) / LINES as f64;
        let crossings = cut(ring, y);
        places.extend(crossings.chunks_exact(2).map(|x| DVec2::new(x[0].midpoint(x[1]), y)));
    }
    places
}

/// Where a ring crosses a line of constant y, ascending.
fn cut(ring: &[DVec2], y: f64) -> Vec<f64> {
    let edges = (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]));
    let crossing = edges.filter(|(a, b)| (a.y > y) != (b.y > y));
    let mut x: Vec<f64> = crossing.map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)).collect();
    x.sort_by(f64::total_cmp);
    x
}

fn check_cover(
    tile: &str,
    holes: &[FilledHole<'_>],
    cell: &CellMesh,
    patches: &PlanIndex,
    inset_m: f64,
    findings: &mut Findings,
) {
    let mut open: Vec<(usize, DVec2)> = Vec::new();
    for (number, hole) in holes.iter().enumerate() {
        let samples = samples(hole.outline, inset_m);
        findings.count("places looked at", samples.len() as u64);
        open.extend(samples.into_iter().filter(|p| patches.over(*p).next().is_none()).map(|p| (number, p)));
    }
    if open.is_empty() {
        return;
    }
    // Delivered surface over a hole covers it too: what hovers there, a bridge.
    let delivered = surface(cell, |owner| owner == ORIGINAL);
    open.retain(|(_, p)| delivered.over(*p).next().is_none());
    for (number, hole) in holes.iter().enumerate() {
        let mut own = open.iter().filter(|(n, _)| *n == number);
        if let Some((_, first)) = own.next() {
            let more = own.count();
            findings.offend(format!(
                "{tile} ({}): no surface {} and {more} other places",
                hole.id,
                place(*first)
            ));
        }
    }
}

fn surface(cell: &CellMesh, wanted: impl Fn(u32) -> bool) -> PlanIndex {
    let triangles = (0..cell.owner.len()).filter(|&t| wanted(cell.owner[t])).map(|t| cell.mesh.corners(t));
    let finite = |t: &[DVec3; 3]| t.iter().all(|p| p.is_finite());
    PlanIndex::new(triangles.filter(finite).collect())
}

/// Places of a square grid inside an outline, not too near to it.
fn samples(outline: &PolygonSet, inset_m: f64) -> Vec<DVec2> {
    let points = || outline.rings.iter().flatten();
    let low = points().fold(DVec2::INFINITY, |m, p| m.min(*p));
    let high = points().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p));
    let step = (high - low).max_element() / SAMPLES_ACROSS;
    if !(step.is_finite() && step > 0.0) {
        return Vec::new();
    }
    let mut places = Vec::new();
    let rows = ((high.y - low.y) / step) as usize + 1;
    for row in 0..rows {
        let y = low.y + (row as f64 + 0.5) * step;
        let mut crossings: Vec<f64> = outline.rings.iter().flat_map(|ring| cut(ring, y)).collect();
        crossings.sort_by(f64::total_cmp);
        for stretch in crossings.chunks_exact(2) {
            let first = ((stretch[0] - low.x) / step).ceil() as usize;
            let last = ((stretch[1] - low.x) / step).floor() as usize;
            places.extend((first..=last).map(|k| DVec2::new(low.x + k as f64 * step, y)));
        }
    }
    places.retain(|p| !is_near_outline(outline, *p, inset_m));
    places
}

fn is_near_outline(outline: &PolygonSet, point: DVec2, inset_m: f64) -> bool {
    let near = |a: DVec2, b: DVec2| {
        let along = b - a;
        let length = along.length_squared();
        let t = if length > 0.0 { ((point - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        point.distance_squared(a + along * t) < inset_m * inset_m
    };
    outline.rings.iter().any(|ring| (0..ring.len()).any(|i| near(ring[i], ring[(i + 1) % ring.len()])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<DVec2> {
        points.iter().map(|&p| DVec2::from(p)).collect()
    }

    #[test]
    fn samples_lie_inside_and_leave_islands_out() {
        let square = |a: f64, b: f64| ring(&[(a, a), (b, a), (b, b), (a, b)]);
        let outline = PolygonSet { rings: vec![square(0.0, 10.0), square(4.0, 6.0)] };
        let places = samples(&outline, INSET_M);
        assert!(places.len() > 1500, "{}", places.len());
        assert!(places.iter().all(|p| outline.contains(*p)));
        assert!(samples(&PolygonSet::default(), INSET_M).is_empty());
        assert!(samples(&PolygonSet { rings: vec![ring(&[(1.0, 1.0)])] }, INSET_M).is_empty());
    }

    #[test]
    fn places_inside_a_ring_lie_inside() {
        let horseshoe = ring(&[
            (0.0, 0.0),
            (9.0, 0.0),
            (9.0, 9.0),
            (6.0, 9.0),
            (6.0, 2.0),
            (3.0, 2.0),
            (3.0, 9.0),
            (0.0, 9.0),
        ]);
        let outline = PolygonSet { rings: vec![horseshoe.clone()] };
        let places = places_inside(&horseshoe);
        assert!(places.len() > LINES && places.iter().all(|p| outline.contains(*p)), "{places:?}");
    }
}
