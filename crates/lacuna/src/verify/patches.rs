//! Promise 5: patches are manifold, join the rim, and have no flipped, flat, repeated or overlapping triangle.

use super::patch_mesh::{CellMesh, ORIGINAL, PatchEdges};
use super::patch_plan::check_in_plan;
use super::verdict::Findings;
use glam::{DVec2, DVec3};
use lacuna_grid::{Domain, Side};
use lacuna_mesh::{Boundary, BoundaryEdge, BoundaryKind, BoundaryPoint};
use std::collections::HashSet;

/// A triangle whose height is below this share of its longest side is flat.
const LEAST_HEIGHT_SHARE: f64 = 1e-7;
/// Slits are narrower than this, metres.
const SLIT_M: f64 = 0.005;

/// What is known of a cell when its patches are checked.
pub(super) struct PatchCheck<'a> {
    /// The tile's name.
    pub(super) tile: &'a str,
    pub(super) cell: &'a CellMesh,
    pub(super) edges: &'a PatchEdges,
    /// Boundary of the final mesh.
    pub(super) boundary: &'a Boundary,
    /// For each of its edges, whether it borders a part of a filled hole that is still open.
    pub(super) is_open: &'a [bool],
    /// The cell's rectangle.
    pub(super) domain: &'a Domain,
    /// What lies this near to a side's line lies on it, metres.
    pub(super) tolerance_m: f64,
    /// True if tiles meet anywhere near their borders: then promise 4 judges what joins them.
    pub(super) is_ragged: bool,
}

/// Checks all patches of a cell.
pub(super) fn check_patches(check: &PatchCheck<'_>) -> Findings {
    let mut findings = Findings::default();
    findings.count("patches", check.cell.holes.len() as u64);
    findings.count("patch triangles", check.cell.patch_triangles().count() as u64);
    check_shapes(check, &mut findings);
    check_duplicates(check, &mut findings);
    check_edges(check, &mut findings);
    check_joints(check, &mut findings);
    check_in_plan(check, &mut findings);
    findings
}

/// `x, y` of a place for a message.
pub(super) fn place(point: DVec2) -> String {
    format!("at {:.3}, {:.3}", point.x, point.y)
}

impl PatchCheck<'_> {
    /// `Tile (hole): what at x, y`.
    pub(super) fn say(&self, triangle: usize, what: &str) -> String {
        let centre = self.cell.mesh.corners(triangle).iter().sum::<DVec3>() / 3.0;
        let owner = self.cell.owner[triangle];
        let hole = if owner == ORIGINAL { "delivered" } else { self.cell.patch_name(owner) };
        format!("{} ({hole}): {what} {}", self.tile, place(centre.truncate()))
    }

    /// True if both points lie on the line of one side of the cell.
    fn is_on_border(&self, a: DVec3, b: DVec3) -> bool {
        let near = |side: Side, p: DVec3| self.domain.outside_m(side, p.truncate()).abs() <= self.tolerance_m;
        Side::ALL.into_iter().any(|side| near(side, a) && near(side, b))
    }
}

fn check_shapes(check: &PatchCheck<'_>, findings: &mut Findings) {
    for t in check.cell.patch_triangles() {
        let [a, b, c] = check.cell.mesh.corners(t);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let doubled_area = (b - a).cross(c - a).length();
        let has_area = longest > 0.0 && doubled_area >= LEAST_HEIGHT_SHARE * longest;
        if !has_area {
            findings.offend(check.say(t, "a triangle without area"));
        }
    }
}

/// Triangles with the same three places, at least one of them in a patch.
fn check_duplicates(check: &PatchCheck<'_>, findings: &mut Findings) {
    let places = |t: usize| {
        let corners = check.cell.mesh.corners(t).map(|p| check.edges.find(p));
        let mut corners = [corners[0]?, corners[1]?, corners[2]?];
        corners.sort_unstable();
        Some((corners, t))
    };
    let mut all: Vec<([u32; 3], usize)> = (0..check.cell.owner.len()).filter_map(places).collect();
    all.sort_unstable();
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        let patch = same.iter().rev().find(|(_, t)| check.cell.owner[*t] != ORIGINAL);
        if same.len() > 1
            && let Some((_, t)) = patch
        {
            findings.offend(check.say(*t, "a triangle stands there twice"));
        }
    }
}

/// No edge of a patch has more than two triangles, and its two run along it in opposite directions.
fn check_edges(check: &PatchCheck<'_>, findings: &mut Findings) {
    for uses in check.edges.of_patches() {
        let originals = uses.iter().filter(|u| !u.is_patch).count();
        let Some(patch) = uses.iter().find(|u| u.is_patch) else { continue };
        let triangle = patch.triangle as usize;
        if uses.len() > 2 && originals <= 2 {
            findings.offend(check.say(triangle, &format!("an edge with {} triangles", uses.len())));
        } else if uses.len() == 2 && uses[0].is_upward == uses[1].is_upward {
            findings.offend(check.say(triangle, "two triangles that face opposite ways along an edge"));
        }
    }
}

/// Inside the cell every patch edge is joined. One that is not and has another such edge within 5 mm makes a crack along the
/// rim. Only bridges may be free: edges between two delivered vertices, over a cut inside the tile. What borders an open
/// part of the hole is left to promise 7.
fn check_joints(check: &PatchCheck<'_>, findings: &mut Findings) {
    let boundary = check.boundary;
    let delivered = delivered_points(check);
    for (number, edge) in boundary.edges.iter().enumerate() {
        let face = edge.face.index();
        let (a, b) = (boundary.position(edge.from), boundary.position(edge.to));
        let is_free = check.cell.owner[face] != ORIGINAL && edge.kind == BoundaryKind::Simple;
        if !is_free || check.is_open[number] || check.is_on_border(a, b) {
            continue;
        }
        if is_slit(boundary, number) {
            findings.offend(check.say(face, "a slit between patch and rim"));
        } else if delivered[edge.from.index()] && delivered[edge.to.index()] {
            findings.count("bridges over cuts", 1);
        } else if !check.is_ragged {
            findings.offend(check.say(face, "an edge of the patch that joins nothing"));
        }
    }
}

/// For each boundary point, whether a delivered triangle has a corner there.
fn delivered_points(check: &PatchCheck<'_>) -> Vec<bool> {
    let originals = check.edges.uses.iter().filter(|u| !u.is_patch);
    let places: HashSet<u32> = originals.flat_map(|u| [u.low, u.high]).collect();
    let is_delivered = |p: &BoundaryPoint| check.edges.find(p.position).is_some_and(|v| places.contains(&v));
    check.boundary.points.iter().map(is_delivered).collect()
}

/// True if another boundary edge runs within 5 mm of an edge's middle.
fn is_slit(boundary: &Boundary, number: usize) -> bool {
    let ends = |e: &BoundaryEdge| (boundary.position(e.from), boundary.position(e.to));
    let (a, b) = ends(&boundary.edges[number]);
    let reach = SLIT_M.min(0.1 * a.distance(b));
    let mut others = boundary.edges.iter().enumerate().filter(|(k, _)| *k != number);
    others.any(|(_, other)| distance_to_segment(a.midpoint(b), ends(other)) <= reach)
}

fn distance_to_segment(point: DVec3, (a, b): (DVec3, DVec3)) -> f64 {
    let along = b - a;
    let length = along.length_squared();
    let t = if length > 0.0 { ((point - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    point.distance(a + along * t)
}
