//! Which clusters a run fills, and why it leaves the others. Every rule looks at the whole cluster (decisions 4).

use super::RunError;
use super::names::Names;
use super::water_places::WaterPlaces;
use crate::config::nearest;
use crate::config::{
    External, FillSettings, HoleClassFilter, HoleShapeFilter, Region, RegionPlace, Settings, WaterFile,
};
use crate::geometry::PolygonSet;
use glam::{DVec2, DVec3};
use lacuna_hole::{Hole, HoleClass, HoleCluster, HoleShape, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// What becomes of a cluster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Decision {
    Fill,
    Skip(String),
}

/// What users' places mean in scene coordinates.
pub(crate) struct Places {
    /// For each region, by number: its polygons, if it is given by a file.
    regions: BTreeMap<usize, PolygonSet>,
    /// The water polygons.
    water: WaterPlaces,
    /// Added to scene coordinates to get SRS coordinates.
    srs_origin: DVec2,
    /// Added to scene heights to get SRS heights.
    srs_height_m: f64,
}

impl Places {
    /// Moves the polygons of the regions, and those of water, into the scene.
    pub(crate) fn new(settings: &Settings, origin: DVec3) -> Self {
        let (srs_origin, srs_height_m) = (origin.truncate(), origin.z);
        let polygons = settings.regions.iter().enumerate().filter_map(|(k, r)| match &r.at {
            RegionPlace::Polygon(file) => Some((k, file.in_scene(srs_origin))),
            _ => None,
        });
        let water = WaterPlaces::new(settings.water_polygons.as_ref(), srs_origin, srs_height_m);
        Self { regions: polygons.collect(), water, srs_origin, srs_height_m }
    }

    /// A place that a user names is in SRS coordinates, as reports print it; scene coordinates are understood too.
    fn readings(&self, place: DVec2) -> [DVec2; 2] {
        [place - self.srs_origin, place]
    }
}

/// Decides every cluster of a plan.
pub(crate) fn select(plan: &Plan, names: &Names, settings: &Settings, places: &Places) -> Vec<Decision> {
    let selector = Selector { plan, names, settings, places };
    (0..plan.clusters.len())
        .map(|c| selector.reason_to_skip(c).map_or(Decision::Fill, Decision::Skip))
        .collect()
}

/// An error if the run is limited to a place, hole or tile that the scene has not. `tiles` are the names of all tiles
/// that are there, and of those that hollow cells would get.
pub(crate) fn refuse_unmatched(
    plan: &Plan,
    names: &Names,
    tiles: &BTreeSet<&str>,
    settings: &Settings,
    places: &Places,
) -> Result<(), RunError> {
    let selection = &settings.selection;
    let problem = |what: String| {
        Err(RunError::usage(format!("{what}; `lacuna inspect SCENE --report DIR` lists what there is")))
    };
    let unknown = |name: &&String| !tiles.contains(name.as_str());
    if let Some(name) = selection.cells.iter().flatten().find(unknown) {
        return problem(unknown_tile(name, tiles));
    }
    for id in &selection.holes {
        if !names.clusters.contains(id) && !names.holes.iter().any(|h| h.id == *id) {
            return problem(format!("--hole: there is no hole or cluster {}", id.escape_debug()));
        }
    }
    for &[x, y] in &selection.at {
        let pins = places.readings(DVec2::new(x, y));
        if !plan.clusters.iter().any(|c| pins.iter().any(|&p| holds(plan, c, p))) {
            return problem(format!("--at: there is no hole at {x},{y}"));
        }
    }
    Ok(())
}

fn unknown_tile(name: &str, tiles: &BTreeSet<&str>) -> String {
    let known: Vec<&str> = tiles.iter().copied().collect();
    let guess =
        nearest(name, &known).map_or_else(String::new, |n| format!(" (did you mean {}?)", n.escape_debug()));
    format!("--cells: the scene has no tile {}{guess}", name.escape_debug())
}

/// Says which limits of the run hold no cluster of the plan: the run fills less than its user may think.
pub(crate) fn warn_unmatched(plan: &Plan, names: &Names, settings: &Settings, places: &Places) {
    let selection = &settings.selection;
    for (k, region) in settings.regions.iter().enumerate() {
        if !(0..plan.clusters.len()).any(|c| lies_in(plan, c, region, k, places)) {
            tracing::warn!("region {}: no hole lies in it", region.name.escape_debug());
        }
    }
    if let Some(file) = &settings.water_polygons {
        warn_unused_water(plan, file, &places.water);
    }
    let touched = |listed: &BTreeSet<String>| names.holes.iter().any(|h| listed.contains(&h.tile));
    if selection.cells.as_ref().is_some_and(|listed| !touched(listed)) {
        tracing::warn!("--cells: no hole touches the tiles that are listed");
    }
}

/// Most features that a warning names.
const NAMED_FEATURES: usize = 5;

fn warn_unused_water(plan: &Plan, file: &WaterFile, water: &WaterPlaces) {
    let unused = water.unused(plan);
    if unused.is_empty() {
        return;
    }
    let path = file.path.display();
    if unused.len() == water.len() {
        tracing::warn!(
            "{path}: no hole lies in its water polygons; check that its coordinates are the scene's, or give it a `crs`"
        );
        return;
    }
    let named: Vec<String> = unused.iter().take(NAMED_FEATURES).map(usize::to_string).collect();
    let more = if unused.len() > NAMED_FEATURES { " ..." } else { "" };
    tracing::warn!(
        "{path}: {} of {} water polygons hold no hole (features {}{more}, counted from 0)",
        unused.len(),
        water.len(),
        named.join(", ")
    );
}

/// Fill settings of a cluster: those of the last region that it lies in, else the scene's. What is said of water: by that
/// region, else by the water polygon that holds most of the cluster, else for the scene; in scene heights.
pub(crate) fn fill_settings(
    plan: &Plan,
    cluster: usize,
    settings: &Settings,
    places: &Places,
) -> FillSettings {
    let region = last_region(plan, cluster, settings, places);
    let of_polygon = || places.water.mode(plan, &plan.clusters[cluster]);
    let said = region.and_then(|r| r.water).or_else(of_polygon).unwrap_or(settings.fill.water);
    let fill = region.map_or(settings.fill, |r| r.fill);
    FillSettings { water: said.lowered(places.srs_height_m), ..fill }
}

fn last_region<'a>(
    plan: &Plan,
    cluster: usize,
    settings: &'a Settings,
    places: &Places,
) -> Option<&'a Region> {
    let at = |k: &usize| lies_in(plan, cluster, &settings.regions[*k], *k, places);
    (0..settings.regions.len()).rev().find(at).map(|k| &settings.regions[k])
}

/// True if a cluster lies in a region: for a point, if one of its holes holds it; else if its centre lies inside.
fn lies_in(plan: &Plan, cluster: usize, region: &Region, number: usize, places: &Places) -> bool {
    let record = &plan.clusters[cluster];
    match &region.at {
        RegionPlace::Point(p) => places.readings(DVec2::from(*p)).into_iter().any(|p| holds(plan, record, p)),
        RegionPlace::Box([west, south, east, north]) => {
            let inside = |p: DVec2| (*west..=*east).contains(&p.x) && (*south..=*north).contains(&p.y);
            inside(record.centre + places.srs_origin) || inside(record.centre)
        }
        RegionPlace::Polygon(_) => places.regions.get(&number).is_some_and(|set| set.contains(record.centre)),
    }
}

/// How far a pin may lie beside a hole, metres: printed places are rounded.
const PIN_M: f64 = 0.1;

/// True if a point lies in a hole of the cluster, or beside its outline by no more than rounding.
fn holds(plan: &Plan, cluster: &HoleCluster, point: DVec2) -> bool {
    cluster.holes.iter().any(|&h| {
        let outline = &plan.holes[h as usize].outline;
        let ends = |k: usize| [outline[k], outline[(k + 1) % outline.len()]];
        lacuna_mesh::contains(outline, point) != lacuna_mesh::Location::Outside
            || (0..outline.len()).any(|k| distance_m(point, ends(k)) <= PIN_M)
    })
}

fn distance_m(point: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
    point.distance(a + (b - a) * along)
}

struct Selector<'a> {
    plan: &'a Plan,
    names: &'a Names,
    settings: &'a Settings,
    places: &'a Places,
}

impl Selector<'_> {
    fn reason_to_skip(&self, c: usize) -> Option<String> {
        let cluster = &self.plan.clusters[c];
        if let Some(leave) = cluster.leave {
            return Some(leave.to_string());
        }
        if cluster.is_external && self.settings.area.external == External::Skip {
            return Some("at the edge of the reconstruction area; --external fill fills it".to_owned());
        }
        if !self.is_selected(c, cluster) {
            return Some("outside the part of the scene that the run is limited to".to_owned());
        }
        if let Some(reason) = self.filtered(cluster) {
            return Some(reason);
        }
        let region = last_region(self.plan, c, self.settings, self.places)?;
        region.skip.as_ref().map(|why| format!("region {}: {why}", region.name))
    }

    fn holes(&self, cluster: &HoleCluster) -> impl Iterator<Item = &Hole> {
        cluster.holes.iter().map(|&h| &self.plan.holes[h as usize])
    }

    fn is_selected(&self, c: usize, cluster: &HoleCluster) -> bool {
        let selection = &self.settings.selection;
        if selection.is_whole_scene() {
            return true;
        }
        let by_region = selection.regions.iter().any(|name| {
            let number = self.settings.regions.iter().position(|r| r.name == *name);
            number.is_some_and(|k| lies_in(self.plan, c, &self.settings.regions[k], k, self.places))
        });
        let by_cell = selection.cells.as_ref().is_some_and(|names| {
            cluster.holes.iter().any(|&h| names.contains(&self.names.holes[h as usize].tile))
        });
        let pins = selection.at.iter().flat_map(|&p| self.places.readings(DVec2::from(p)));
        let by_place = pins.into_iter().any(|p| holds(self.plan, cluster, p));
        let by_id = selection.holes.iter().any(|id| {
            *id == self.names.clusters[c]
                || cluster.holes.iter().any(|&h| *id == self.names.holes[h as usize].id)
        });
        by_region || by_cell || by_place || by_id
    }

    fn filtered(&self, cluster: &HoleCluster) -> Option<String> {
        let find = &self.settings.find;
        let area = cluster.area_m2;
        if find.min_area_m2.is_some_and(|least| area < least) {
            return Some(format!("smaller than the least area, {} m2", find.min_area_m2.unwrap_or(0.0)));
        }
        if find.max_area_m2.is_some_and(|most| area > most) {
            return Some(format!("larger than the largest area, {} m2", find.max_area_m2.unwrap_or(0.0)));
        }
        let perimeter: f64 = self.holes(cluster).map(|h| h.perimeter_m).sum();
        if find.max_perimeter_m.is_some_and(|most| perimeter > most) {
            return Some(format!("its perimeter is longer than {} m", find.max_perimeter_m.unwrap_or(0.0)));
        }
        let edges: u64 = self.holes(cluster).map(|h| u64::from(h.rim_vertices)).sum();
        if find.max_edges_around_hole.is_some_and(|most| edges > most) {
            return Some(format!("its rim has more than {} edges", find.max_edges_around_hole.unwrap_or(0)));
        }
        let class = |h: &Hole| find.class.is_empty() || find.class.contains(&class_filter(h.class));
        if !self.holes(cluster).any(class) {
            return Some("not of the classes asked for".to_owned());
        }
        let shape = |h: &Hole| {
            find.shape.is_empty() || h.class.shape().is_some_and(|s| find.shape.contains(&shape_filter(s)))
        };
        (!self.holes(cluster).any(shape)).then(|| "not of the shapes asked for".to_owned())
    }
}

fn class_filter(class: HoleClass) -> HoleClassFilter {
    match class {
        HoleClass::Closed => HoleClassFilter::Closed,
        HoleClass::Internal(_) => HoleClassFilter::Internal,
        HoleClass::External(_) => HoleClassFilter::External,
    }
}

fn shape_filter(shape: HoleShape) -> HoleShapeFilter {
    match shape {
        HoleShape::Hollow => HoleShapeFilter::A,
        HoleShape::SemiEnclosed => HoleShapeFilter::B,
        HoleShape::Crossing => HoleShapeFilter::C,
        HoleShape::Island => HoleShapeFilter::D,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_have_a_distance_to_an_edge() {
        let edge = [DVec2::ZERO, DVec2::new(4.0, 0.0)];
        for (pin, expected) in [([2.0, 1.5], 1.5), ([-3.0, 4.0], 5.0), ([4.0, 0.0], 0.0), ([7.0, 0.0], 3.0)] {
            assert!((distance_m(DVec2::from(pin), edge) - expected).abs() < 1e-12, "{pin:?}");
        }
        assert_eq!(distance_m(DVec2::new(3.0, 4.0), [DVec2::ZERO; 2]), 5.0);
    }
}
