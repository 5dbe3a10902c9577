//! `holes.geojson` and `cells.geojson`: the map for a GIS.

use super::drawing::{CellDrawing, Drawing, HoleDrawing};
use super::model::{Report, SceneRecord};
use super::round::round_to;
use geojson::feature::Id;
use geojson::{Feature, Geometry, GeometryValue, JsonObject, Position};
use serde_json::json;
use std::collections::BTreeMap;

/// The holes as polygons, in the report's order; properties are the report's record of each. A hole without an
/// outline has no geometry. `passed_under` holds the outlines of the islands that the patch passes beneath, if there are any.
///
/// Coordinates are scene coordinates. If the scene's SRS is an EPSG code they are SRS coordinates (scene + SRS origin),
/// and a `crs` member names it (decisions 5). Rounded to millimetres.
///
/// # Errors
/// The serialiser's.
pub fn holes_geojson(report: &Report, drawing: &Drawing) -> Result<String, serde_json::Error> {
    let frame = Frame::of(&report.scene);
    let drawings: BTreeMap<&str, &HoleDrawing> = drawing.holes.iter().map(|h| (h.id.as_str(), h)).collect();
    let features = report.holes.iter().map(|hole| {
        let mut properties = match serde_json::to_value(hole)? {
            serde_json::Value::Object(properties) => properties,
            _ => JsonObject::new(),
        };
        let drawing = drawings.get(hole.id.as_str());
        let geometry = drawing.and_then(|drawing| frame.polygon(&drawing.rings));
        if let Some(drawing) = drawing.filter(|d| !d.passed_under.is_empty()) {
            let rings: Vec<_> = drawing.passed_under.iter().filter_map(|ring| frame.ring(ring)).collect();
            properties.insert("passed_under".to_owned(), json!(rings));
        }
        Ok(feature(&hole.id, geometry, properties))
    });
    collection(&frame, features)
}

/// The cells as squares, by row and column, with the name of their tile and what became of it.
///
/// # Errors
/// The serialiser's.
pub fn cells_geojson(report: &Report, drawing: &Drawing) -> Result<String, serde_json::Error> {
    let frame = Frame::of(&report.scene);
    let mut cells: Vec<&CellDrawing> = drawing.cells.iter().collect();
    cells.sort_by_key(|cell| (cell.index[1], cell.index[0]));
    let features = cells.into_iter().map(|cell| {
        let [west, south, east, north] = cell.rect;
        let ring = vec![[west, south], [east, south], [east, north], [west, north]];
        let mut properties = JsonObject::new();
        properties.insert("cell".to_owned(), json!(cell.index));
        properties.insert("tile".to_owned(), json!((!cell.tile.is_empty()).then_some(&cell.tile)));
        properties.insert("status".to_owned(), json!(cell.status.word()));
        Ok(feature(&format!("{}_{}", cell.index[0], cell.index[1]), frame.polygon(&[ring]), properties))
    });
    collection(&frame, features)
}

/// How scene coordinates become those of the file.
struct Frame {
    shift: [f64; 2],
    /// EPSG code, if the SRS has one.
    code: Option<String>,
}

impl Frame {
    fn of(scene: &SceneRecord) -> Self {
        let code = scene.srs.as_deref().and_then(epsg_code).map(str::to_owned);
        let origin = scene.srs_origin.filter(|_| code.is_some()).unwrap_or_default();
        Self { shift: [origin[0], origin[1]], code }
    }

    fn polygon(&self, rings: &[Vec<[f64; 2]>]) -> Option<Geometry> {
        let coordinates: Vec<Vec<Position>> = rings.iter().filter_map(|ring| self.ring(ring)).collect();
        // Without its outer ring an outline is none.
        let is_whole = rings.first().is_some_and(|outer| self.ring(outer).is_some());
        is_whole.then(|| Geometry::new(GeometryValue::Polygon { coordinates }))
    }

    /// The ring with its first point repeated at the end; `None` if fewer than three points are left.
    fn ring(&self, ring: &[[f64; 2]]) -> Option<Vec<Position>> {
        let mut points: Vec<[f64; 2]> = ring
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite())
            .map(|p| [round_to(p[0] + self.shift[0], 3), round_to(p[1] + self.shift[1], 3)])
            .collect();
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let first = *points.first().filter(|_| points.len() >= 3)?;
        points.push(first);
        Some(points.into_iter().map(Position::from).collect())
    }
}

/// The digits of `EPSG:28992`.
fn epsg_code(srs: &str) -> Option<&str> {
    let code = srs.trim().strip_prefix("EPSG:")?;
    (!code.is_empty() && code.len() <= 9 && code.bytes().all(|b| b.is_ascii_digit())).then_some(code)
}

fn feature(id: &str, geometry: Option<Geometry>, properties: JsonObject) -> Feature {
    Feature {
        bbox: None,
        geometry,
        id: Some(Id::String(id.to_owned())),
        properties: Some(properties),
        foreign_members: None,
    }
}

/// One feature a line, so that two runs can be compared line by line.
fn collection(
    frame: &Frame,
    features: impl Iterator<Item = Result<Feature, serde_json::Error>>,
) -> Result<String, serde_json::Error> {
    let lines = features.map(|f| serde_json::to_string(&f?)).collect::<Result<Vec<_>, _>>()?;
    let crs = frame.code.as_ref().map_or_else(String::new, |code| {
        let crs = json!({"type": "name", "properties": {"name": format!("urn:ogc:def:crs:EPSG::{code}")}});
        format!("\"crs\":{crs},\n")
    });
    Ok(format!("{{\"type\":\"FeatureCollection\",\n{crs}\"features\":[\n{}\n]}}\n", lines.join(",\n")))
}
