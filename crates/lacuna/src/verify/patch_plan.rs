//! Patches seen from above: no triangle turned over, no patch over itself or another.

use super::patch_mesh::{CellMesh, PatchEdges};
use super::patches::{PatchCheck, place};
use super::plan_index::PlanIndex;
use super::verdict::Findings;
use glam::{DVec2, DVec3};
use lacuna_mesh::{TriMesh, boundary, find_crossings, loops};
use std::collections::HashSet;

/// Triangles whose normal has a smaller upward share have no side in plan.
const STEEP: f64 = 0.02;
/// A patch whose mean normal has a smaller upward share stands in a wall.
const WALL: f64 = 0.15;
/// Two sheets nearer than this one above the other are one patch over another, metres.
const SHEETS_M: f64 = 2.0;

/// One patch as it lies in plan.
struct Lying {
    triangles: Vec<usize>,
    normal: DVec3,
    /// Its boundary; each edge with true if delivered surface joins there.
    rings: Vec<Vec<DVec2>>,
    is_rim: Vec<bool>,
}

/// Checks the patches that have a side in plan: those that do not stand in a wall and whose rim does not cross itself seen
/// from above. A patch without a rim must face up.
pub(super) fn check_in_plan(check: &PatchCheck<'_>, findings: &mut Findings) {
    let rims: HashSet<(u32, u32)> = check.edges.rims().map(|uses| (uses[0].low, uses[0].high)).collect();
    let mut judged = Vec::new();
    for patch in 0..check.cell.holes.len() as u32 {
        let lying = Lying::of(check.cell, check.edges, &rims, patch);
        if lying.triangles.is_empty() {
            continue;
        }
        if !judge(check, &lying, findings) {
            findings.count("patches not judged in plan", 1);
            continue;
        }
        judged.extend(lying.triangles.into_iter().filter(|&t| !is_steep(&check.cell.mesh, t)));
    }
    check_sheets(check, &judged, findings);
}

impl Lying {
    fn of(cell: &CellMesh, edges: &PatchEdges, rims: &HashSet<(u32, u32)>, patch: u32) -> Self {
        let triangles: Vec<usize> = cell.patch_triangles().filter(|&t| cell.owner[t] == patch).collect();
        let normal = triangles.iter().map(|&t| normal(&cell.mesh, t)).sum();
        let places = |&t: &usize| cell.mesh.corners(t).map(|p| edges.find(p).unwrap_or(0)); // all places are known
        let own =
            TriMesh { positions: edges.positions.clone(), triangles: triangles.iter().map(places).collect() };
        let outline = boundary(&own);
        let (mut rings, mut is_rim) = (Vec::new(), Vec::new());
        for ring in loops(&outline).loops {
            for &edge in &ring.edges {
                let edge = &outline.edges[edge as usize];
                let [a, b] = [edge.from, edge.to].map(|p| outline.points[p.index()].vertex.0);
                is_rim.push(rims.contains(&(a.min(b), a.max(b))));
            }
            rings.push(ring.positions(&outline).iter().map(|p| p.truncate()).collect());
        }
        Self { triangles, normal, rings, is_rim }
    }

    fn edges(&self) -> Vec<[DVec2; 2]> {
        let of = |ring: &Vec<DVec2>| {
            (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]).collect::<Vec<_>>()
        };
        self.rings.iter().flat_map(of).collect()
    }
}

/// Returns false if the patch has no side in plan.
fn judge(check: &PatchCheck<'_>, lying: &Lying, findings: &mut Findings) -> bool {
    let edges = lying.edges();
    let rings: Vec<&[DVec2]> = lying.rings.iter().map(Vec::as_slice).collect();
    let crossings = find_crossings(&rings);
    let is_upright = lying.normal.z.abs() <= WALL * lying.normal.length();
    let rim_crosses = crossings.iter().any(|&(a, b)| lying.is_rim[a] && lying.is_rim[b]);
    let rim_climbs = edges.iter().zip(&lying.is_rim).any(|(e, rim)| *rim && e[0] == e[1]);
    if is_upright || rim_crosses || rim_climbs {
        return false;
    }
    let side = if lying.is_rim.contains(&true) { lying.normal.z.signum() } else { 1.0 };
    for &t in &lying.triangles {
        let normal = normal(&check.cell.mesh, t).normalize_or_zero();
        if normal.z * side < -STEEP {
            findings.offend(check.say(t, "a flipped triangle"));
        }
    }
    if let Some(&(first, _)) = crossings.first() {
        let [a, b] = edges[first];
        let what = format!("the patch's boundary crosses itself {}", place(a.midpoint(b)));
        findings.offend(format!("{} ({}): {what}", check.tile, name_of(check, lying)));
    }
    true
}

fn name_of<'a>(check: &'a PatchCheck<'_>, lying: &Lying) -> &'a str {
    lying.triangles.first().map_or("", |&t| check.cell.patch_name(check.cell.owner[t]))
}

/// No triangle's centre lies in another patch triangle less than 2 m above or below.
fn check_sheets(check: &PatchCheck<'_>, triangles: &[usize], findings: &mut Findings) {
    let corners: Vec<[DVec3; 3]> = triangles.iter().map(|&t| check.cell.mesh.corners(t)).collect();
    let centres: Vec<DVec3> = corners.iter().map(|c| c.iter().sum::<DVec3>() / 3.0).collect();
    let index = PlanIndex::new(corners);
    for (own, centre) in centres.iter().enumerate() {
        let mut others = index.over(centre.truncate()).filter(|(t, _)| *t != own);
        if others.any(|(_, z)| (z - centre.z).abs() < SHEETS_M) {
            findings.offend(check.say(triangles[own], "a triangle over another one of a patch"));
        }
    }
}

fn normal(mesh: &TriMesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a)
}

fn is_steep(mesh: &TriMesh, triangle: usize) -> bool {
    normal(mesh, triangle).normalize_or_zero().z.abs() <= STEEP
}
