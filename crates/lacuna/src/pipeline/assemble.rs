//! From plan, decisions and patches to the report's records.

use super::frames::SeamFacts;
use super::names::Names;
use super::outlines::cluster_outline;
use super::scan::Scanned;
use super::select::Decision;
use super::solve::{FilledHole, Fills};
use crate::config::Settings;
use crate::report::{
    CellDrawing, CellStatus, ClusterDrawing, ClusterRecord, Drawing, HoleClass, HoleDrawing, HoleRecord,
    HoleShape, Outcome, SceneRecord, SeamRecord,
};
use glam::{DVec2, DVec3};
use lacuna_close::Water;
use lacuna_grid::CellId;
use lacuna_hole::{BorderMode, CellSurvey, Plan};
use lacuna_tile::Scene;
use std::collections::{BTreeMap, BTreeSet};

/// What became of one hole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct HoleOutcome {
    pub(crate) outcome: Outcome,
    pub(crate) reason: Option<String>,
}

impl HoleOutcome {
    fn new(outcome: Outcome, reason: impl Into<Option<String>>) -> Self {
        Self { outcome, reason: reason.into() }
    }
}

/// Outcome of every hole: a cluster is filled in all its holes or in none.
pub(crate) fn outcomes(
    plan: &Plan,
    names: &Names,
    decisions: &[Decision],
    fills: &Fills,
    refused: &BTreeMap<CellId, String>,
) -> Vec<HoleOutcome> {
    let mut outcomes: Vec<Option<HoleOutcome>> = vec![None; plan.holes.len()];
    for (cluster, decision) in plan.clusters.iter().zip(decisions) {
        if let Decision::Skip(reason) = decision {
            for &h in &cluster.holes {
                outcomes[h as usize] = Some(HoleOutcome::new(Outcome::Skipped, reason.clone()));
            }
            continue;
        }
        let own = |h: u32| own_outcome(plan, h, fills, refused);
        let worst = cluster.holes.iter().map(|&h| (h, own(h))).find(|(_, o)| o.outcome != Outcome::Filled);
        for &h in &cluster.holes {
            let mut result = own(h);
            if let Some((culprit, problem)) = &worst
                && result.outcome == Outcome::Filled
            {
                let why = problem.reason.as_deref().unwrap_or("not filled");
                let name = &names.holes[*culprit as usize].id;
                result = HoleOutcome::new(problem.outcome, format!("left with its cluster: {name}: {why}"));
            }
            outcomes[h as usize] = Some(result);
        }
    }
    outcomes.into_iter().map(|o| o.unwrap_or(HoleOutcome::new(Outcome::Failed, None))).collect()
}

fn own_outcome(plan: &Plan, hole: u32, fills: &Fills, refused: &BTreeMap<CellId, String>) -> HoleOutcome {
    if let Some(reason) = refused.get(&plan.holes[hole as usize].cell) {
        return HoleOutcome::new(Outcome::Failed, reason.clone());
    }
    match fills.get(&hole) {
        Some(Ok(_)) => HoleOutcome::new(Outcome::Filled, None),
        Some(Err(e)) if e.is_refusal => HoleOutcome::new(Outcome::Skipped, e.reason.clone()),
        Some(Err(e)) => HoleOutcome::new(Outcome::Failed, e.reason.clone()),
        None => HoleOutcome::new(Outcome::Failed, "not reached".to_owned()),
    }
}

/// The report's record of every hole.
pub(crate) fn hole_records(
    plan: &Plan,
    names: &Names,
    outcomes: &[HoleOutcome],
    fills: &Fills,
) -> Vec<HoleRecord> {
    plan.holes
        .iter()
        .enumerate()
        .map(|(h, hole)| {
            let outcome = &outcomes[h];
            let is_filled = outcome.outcome == Outcome::Filled;
            let fill = fills.get(&(h as u32)).and_then(|f| f.as_ref().ok()).filter(|_| is_filled);
            let new_vertices = |f: &FilledHole| {
                let copies = f.sources.iter().filter(|s| s.is_new()).count();
                (copies + f.patch.vertices.len()) as u64
            };
            HoleRecord {
                id: names.holes[h].id.clone(),
                cluster: names.clusters[hole.cluster as usize].clone(),
                tile: names.holes[h].tile.clone(),
                cell: [hole.cell.i, hole.cell.j],
                class: class(hole.class),
                shape: shape(hole.class),
                layer: hole.layer,
                area_m2: hole.area_m2,
                perimeter_m: hole.perimeter_m,
                rim_vertices: u64::from(hole.rim_vertices),
                islands_passed_under: if is_filled { hole.passed_under.len() as u64 } else { 0 },
                outcome: outcome.outcome,
                reason: outcome.reason.clone().or_else(|| fill.and_then(instead_of_field)),
                method: fill.map(|f| f.method.word().to_owned()),
                filler: fill.map(|f| f.filler.to_string()),
                patch_vertices: fill.map_or(0, new_vertices),
                patch_triangles: fill.map_or(0, |f| f.patch.triangles.len() as u64),
                quality_mean: fill.map(|f| f.quality.mean),
                quality_share_good: fill.map(|f| f.quality.share_good),
            }
        })
        .collect()
}

fn instead_of_field(fill: &FilledHole) -> Option<String> {
    fill.instead_of_field.as_ref().map(|why| format!("{} instead of field: {why}", fill.method.word()))
}

fn class(class: lacuna_hole::HoleClass) -> HoleClass {
    match class {
        lacuna_hole::HoleClass::Closed => HoleClass::Closed,
        lacuna_hole::HoleClass::Internal(_) => HoleClass::Internal,
        lacuna_hole::HoleClass::External(_) => HoleClass::External,
    }
}

fn shape(class: lacuna_hole::HoleClass) -> Option<HoleShape> {
    class.shape().map(|s| match s {
        lacuna_hole::HoleShape::Hollow => HoleShape::A,
        lacuna_hole::HoleShape::SemiEnclosed => HoleShape::B,
        lacuna_hole::HoleShape::Crossing => HoleShape::C,
        lacuna_hole::HoleShape::Island => HoleShape::D,
    })
}

/// The report's record of every cluster. `srs_origin` turns file coordinates into SRS coordinates.
pub(crate) fn cluster_records(
    plan: &Plan,
    names: &Names,
    outcomes: &[HoleOutcome],
    water: &BTreeMap<u32, Water>,
    srs_origin: DVec3,
) -> Vec<ClusterRecord> {
    plan.clusters
        .iter()
        .enumerate()
        .map(|(c, cluster)| {
            let tiles: BTreeSet<String> =
                cluster.holes.iter().map(|&h| names.holes[h as usize].tile.clone()).collect();
            let outcome = cluster
                .holes
                .iter()
                .map(|&h| &outcomes[h as usize])
                .find(|o| o.outcome != Outcome::Filled)
                .cloned()
                .unwrap_or(HoleOutcome::new(Outcome::Filled, None));
            let place = cluster.centre + srs_origin.truncate();
            let water = water.get(&(c as u32)).filter(|_| outcome.outcome == Outcome::Filled);
            ClusterRecord {
                id: names.clusters[c].clone(),
                x: place.x,
                y: place.y,
                tiles: tiles.into_iter().collect(),
                area_m2: cluster.area_m2,
                layers: cluster.layers,
                level_m: water.map(|w| w.plane.at(cluster.centre) + srs_origin.z),
                level_support: water.map(|w| w.support),
                level_residual_m: water.map(|w| w.residual_m),
                outcome: outcome.outcome,
                reason: outcome.reason,
            }
        })
        .collect()
}

/// The report's record of the scene.
pub(crate) fn scene_record(
    scene: &Scene,
    scanned: &Scanned,
    plan: &Plan,
    settings: &Settings,
) -> SceneRecord {
    let formats: BTreeSet<String> =
        scene.tiles.iter().map(|t| format!("{:?}", t.format).to_uppercase()).collect();
    let metadata = scene.metadata.as_ref();
    SceneRecord {
        cells: plan.domains.len() as u64 + scanned.unreadable.len() as u64,
        triangles: scanned.surveys.values().map(|s| s.triangles).sum(),
        bytes: scanned.tiles.values().flat_map(|t| &t.parts).map(|p| p.bytes).sum(),
        cell_size_m: scanned.grid.grid.cell_size_m,
        origin_m: scanned.grid.grid.origin.to_array(),
        border_mode: border_mode(plan.fit.mode).to_owned(),
        overrun_m: (plan.fit.mode == BorderMode::Overrun).then_some(plan.fit.margin_m),
        format: formats.into_iter().collect::<Vec<_>>().join("+"),
        srs: settings.scene.srs.clone().or_else(|| metadata.and_then(|m| m.srs.clone())),
        srs_origin: settings.scene.srs_origin.or_else(|| metadata.map(|m| m.srs_origin)),
    }
}

/// The word of a border mode.
pub(crate) fn border_mode(mode: BorderMode) -> &'static str {
    match mode {
        BorderMode::Exact => "exact",
        BorderMode::Overrun => "overrun",
        BorderMode::Ragged => "ragged",
        BorderMode::Overlap => "overlap",
    }
}

/// The report's record of the seams.
pub(crate) fn seam_record(facts: &SeamFacts) -> SeamRecord {
    SeamRecord {
        borders: facts.borders,
        shared_vertices: facts.shared_vertices,
        differing_vertices: facts.differing_vertices,
        max_gap_m: facts.max_gap_m,
    }
}

/// Shapes for the map: cells with what became of their tile, holes with their outlines.
pub(crate) fn drawing(plan: &Plan, scanned: &Scanned, names: &Names, outcomes: &[HoleOutcome]) -> Drawing {
    let repaired: BTreeSet<CellId> = plan
        .holes
        .iter()
        .zip(outcomes)
        .filter(|(_, o)| o.outcome == Outcome::Filled)
        .map(|(h, _)| h.cell)
        .collect();
    let status = |cell: &CellId| match (repaired.contains(cell), scanned.tiles.contains_key(cell)) {
        (true, _) => CellStatus::Repaired,
        (false, true) => CellStatus::Untouched,
        (false, false) => CellStatus::Missing,
    };
    let rect = |cell: CellId| {
        let (low, high) = scanned.grid.grid.rectangle(cell);
        [low.x, low.y, high.x, high.y]
    };
    let good = plan.domains.keys().map(|&cell| CellDrawing {
        index: [cell.i, cell.j],
        rect: rect(cell),
        tile: scanned.tiles.get(&cell).map_or_else(String::new, |t| t.name.clone()),
        status: status(&cell),
    });
    let bad = scanned.unreadable.iter().map(|(&cell, name)| CellDrawing {
        index: [cell.i, cell.j],
        rect: rect(cell),
        tile: name.clone(),
        status: CellStatus::Failed,
    });
    let mut cells: Vec<CellDrawing> = good.chain(bad).collect();
    cells.sort_by_key(|c| (c.index[1], c.index[0]));
    let holes = plan.holes.iter().enumerate().map(|(h, hole)| {
        let points = |ring: &[DVec2]| ring.iter().map(|p| p.to_array()).collect::<Vec<_>>();
        let survey = scanned.surveys.get(&hole.cell);
        let outlines = |islands: &[u32]| -> Vec<Vec<[f64; 2]>> {
            let of_survey = |s: &CellSurvey, l: u32| {
                s.loops[l as usize].edges.iter().map(|&e| s.from(e).truncate().to_array()).collect()
            };
            survey.map_or_else(Vec::new, |s| islands.iter().map(|&l| of_survey(s, l)).collect())
        };
        let mut rings = vec![points(&hole.outline)];
        rings.extend(outlines(&hole.islands));
        HoleDrawing {
            id: names.holes[h].id.clone(),
            class: class(hole.class),
            shape: shape(hole.class),
            layer: hole.layer,
            rings,
            passed_under: outlines(&hole.passed_under),
            outcome: outcomes[h].outcome,
        }
    });
    let clusters = plan.clusters.iter().enumerate().filter(|(_, c)| c.holes.len() > 1).map(|(k, cluster)| {
        ClusterDrawing { id: names.clusters[k].clone(), rings: cluster_outline(plan, scanned, cluster) }
    });
    Drawing { cells, holes: holes.collect(), clusters: clusters.collect(), ..Drawing::default() }
}
