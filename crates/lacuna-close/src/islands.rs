//! Islands that hover over water: the patch passes beneath them.

use crate::field::WaterRule;
use crate::water::{RimPoint, Water};
use lacuna_hole::{CellSurvey, Hole, HoleCluster, LoopSurvey, Piece, Plan, Span, Surveys};
use lacuna_mesh::PointId;
use std::collections::{BTreeMap, BTreeSet};

/// A rim whose lowest vertex is higher than this over the water is clear of it, metres: what lies nearer is on the water.
const CLEAR_M: f64 = 0.15;

/// The islands of a cluster that the water passes beneath, by hole: loops of the cell's survey, ascending. None if the
/// cluster is no water by `rule`.
///
/// Steps: the water's plane from the rims without islands (those of boats tell nothing of it, and are what is asked);
/// then each island whose plan area is at most `max_area_m2` and all of whose rim is higher than 0.15 m over the plane, but
/// for those that touch the shore, or an island that stays, in a vertex: the patch joins it there.
#[must_use]
pub fn hovering_islands(
    surveys: &Surveys,
    plan: &Plan,
    cluster: &HoleCluster,
    rule: WaterRule,
    max_area_m2: f64,
) -> BTreeMap<u32, Vec<u32>> {
    let holes = || cluster.holes.iter().map(|&h| (h, &plan.holes[h as usize]));
    if holes().all(|(_, hole)| hole.islands.is_empty()) {
        return BTreeMap::new();
    }
    let rim: Vec<RimPoint> = holes().flat_map(|(_, hole)| shore(surveys, hole)).collect();
    let Some(water) = shore_water(&rim, cluster.area_m2, rule) else { return BTreeMap::new() };
    let hovering = holes().filter_map(|(h, hole)| {
        let survey = surveys.get(&hole.cell)?;
        let is_clear = |&l: &u32| {
            let island = &survey.loops[l as usize];
            island.vector_area.z.abs() <= max_area_m2 && hovers_over(survey, island, &water)
        };
        let clear: BTreeSet<u32> = hole.islands.iter().copied().filter(is_clear).collect();
        let list = apart(survey, hole, clear);
        (!list.is_empty()).then_some((h, list))
    });
    hovering.collect()
}

/// Those of some islands of a hole that touch nothing which the patch joins, ascending.
fn apart(survey: &CellSurvey, hole: &Hole, mut islands: BTreeSet<u32>) -> Vec<u32> {
    let vertices = |edges: &[u32]| -> Vec<PointId> {
        let ends = |&e: &u32| [survey.boundary.edges[e as usize].from, survey.boundary.edges[e as usize].to];
        edges.iter().flat_map(ends).collect()
    };
    let of_island = |l: u32| vertices(&survey.loops[l as usize].edges);
    let rims = hole.outer.iter().filter_map(|piece| match piece {
        Piece::Rim(edges) => Some(vertices(edges)),
        Piece::Side { .. } | Piece::Bridge => None,
    });
    let mut joined: BTreeSet<PointId> = rims.flatten().collect();
    joined.extend(hole.islands.iter().filter(|l| !islands.contains(l)).flat_map(|&l| of_island(l)));
    while let Some(touching) =
        islands.iter().copied().find(|&l| of_island(l).iter().any(|p| joined.contains(p)))
    {
        islands.remove(&touching);
        joined.extend(of_island(touching));
    }
    islands.into_iter().collect()
}

/// The middles of the rim edges round a hole, its own and its neighbours', islands left out.
fn shore(surveys: &Surveys, hole: &Hole) -> Vec<RimPoint> {
    let mut points = Vec::new();
    let mut add = |survey: Option<&CellSurvey>, edges: &[u32]| {
        let Some(survey) = survey else { return };
        points.extend(edges.iter().map(|&e| {
            let (a, b) = (survey.from(e), survey.to(e));
            RimPoint { position: a.midpoint(b), length_m: a.distance(b) }
        }));
    };
    for piece in &hole.outer {
        match piece {
            Piece::Rim(edges) => add(surveys.get(&hole.cell), edges),
            Piece::Side { spans, .. } => spans.iter().for_each(|span| {
                if let Span::Adopted { neighbour, edges } = span {
                    add(surveys.get(neighbour), edges);
                }
            }),
            Piece::Bridge => {}
        }
    }
    points
}

fn shore_water(rim: &[RimPoint], area_m2: f64, rule: WaterRule) -> Option<Water> {
    let length_m: f64 = rim.iter().map(|p| p.length_m).sum();
    let mut edges_m: Vec<f64> = rim.iter().map(|p| p.length_m).collect();
    edges_m.sort_by(f64::total_cmp);
    let edge_m = *edges_m.get(edges_m.len() / 2)?;
    // Twice the radius of a disk with this area and rim, as for the field.
    let width_m = 2.0 * (2.0 * area_m2 / length_m.max(1e-9)).min((area_m2 / std::f64::consts::PI).sqrt());
    rule.water(rim, width_m, edge_m)
}

fn hovers_over(survey: &CellSurvey, island: &LoopSurvey, water: &Water) -> bool {
    let clearance = |&e: &u32| {
        let p = survey.from(e);
        p.z - water.plane.at(p.truncate())
    };
    island.edges.iter().map(clearance).fold(f64::INFINITY, f64::min) > CLEAR_M
}
