//! Polygons from GeoJSON files: reconstruction area and regions.

use super::error::ConfigError;
use crate::PolygonSet;
use geojson::{Feature, GeoJson, Geometry, GeometryValue, JsonObject, Position};
use glam::DVec2;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest polygon file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The coordinates that a polygon file is written in (decisions 5).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Those of the scene's files: the file has no `crs` member.
    Scene,
    /// Those of a spatial reference system, named by the `crs` member: scene coordinates + SRS origin.
    Srs(String),
}

impl Frame {
    /// What the report calls it.
    pub(super) fn word(&self) -> &str {
        match self {
            Self::Scene => "scene",
            Self::Srs(name) => name,
        }
    }
}

/// The polygons of one GeoJSON file. In the report it is a hash over its coordinates: no path stands there.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonFile {
    /// Where it was read.
    pub path: PathBuf,
    /// What its coordinates mean.
    pub frame: Frame,
    /// All rings, without a repeated last point; a point is inside if an odd number of them holds it.
    pub rings: Vec<Vec<[f64; 2]>>,
}

impl PolygonFile {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, is larger than 64 MiB, is no GeoJSON, holds no polygon, or has a `crs` in degrees.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text = read_text(path)?;
        Self::parse(&text, path).map_err(|what| ConfigError::Polygon { path: path.to_owned(), what })
    }

    fn parse(text: &str, path: &Path) -> Result<Self, String> {
        let document: GeoJson = text.parse().map_err(|e| format!("no GeoJSON: {e}"))?;
        let mut rings = Vec::new();
        match &document {
            GeoJson::Geometry(geometry) => collect(geometry, &mut rings)?,
            GeoJson::Feature(feature) => collect_feature(feature, &mut rings)?,
            GeoJson::FeatureCollection(all) => {
                all.features.iter().try_for_each(|feature| collect_feature(feature, &mut rings))?;
            }
        }
        if rings.is_empty() {
            return Err("holds no polygon; draw at least one".to_owned());
        }
        Ok(Self { path: path.to_owned(), frame: frame(foreign_members(&document))?, rings })
    }

    /// The polygons in scene coordinates. `srs_origin` is what is added to scene coordinates to get SRS coordinates.
    #[must_use]
    pub fn in_scene(&self, srs_origin: DVec2) -> PolygonSet {
        let shift = match self.frame {
            Frame::Scene => DVec2::ZERO,
            Frame::Srs(_) => srs_origin,
        };
        let move_ring = |ring: &Vec<[f64; 2]>| ring.iter().map(|&p| DVec2::from(p) - shift).collect();
        PolygonSet { rings: self.rings.iter().map(move_ring).collect() }
    }

    fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for ring in &self.rings {
            hasher.update(&(ring.len() as u64).to_le_bytes());
            ring.iter().flatten().for_each(|c| {
                hasher.update(&c.to_le_bytes());
            });
        }
        hasher.finalize().to_hex().to_string()
    }
}

impl Serialize for PolygonFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("rings", &self.rings.len())?;
        map.serialize_entry("coordinates", self.frame.word())?;
        map.serialize_entry("blake3", &self.hash())?;
        map.end()
    }
}

/// The text of a polygon file.
pub(super) fn read_text(path: &Path) -> Result<String, ConfigError> {
    let fail = |source| ConfigError::Read { path: path.to_owned(), source };
    let mut text = String::new();
    File::open(path).map_err(fail)?.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(fail)?;
    if text.len() as u64 > MAX_BYTES {
        let what = "larger than 64 MiB; simplify it".to_owned();
        return Err(ConfigError::Polygon { path: path.to_owned(), what });
    }
    Ok(text)
}

fn collect_feature(feature: &Feature, rings: &mut Vec<Vec<[f64; 2]>>) -> Result<(), String> {
    feature.geometry.as_ref().map_or(Ok(()), |geometry| collect(geometry, rings))
}

/// Adds the rings of all polygons of a geometry.
pub(super) fn collect(geometry: &Geometry, rings: &mut Vec<Vec<[f64; 2]>>) -> Result<(), String> {
    match &geometry.value {
        GeometryValue::Polygon { coordinates } => add_rings(coordinates, rings),
        GeometryValue::MultiPolygon { coordinates } => {
            coordinates.iter().try_for_each(|polygon| add_rings(polygon, rings))
        }
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|part| collect(part, rings))
        }
        // Points and lines beside the polygons are somebody's notes.
        _ => Ok(()),
    }
}

fn add_rings(polygon: &[Vec<Position>], rings: &mut Vec<Vec<[f64; 2]>>) -> Result<(), String> {
    for ring in polygon {
        let mut points = ring.iter().map(point).collect::<Result<Vec<_>, _>>()?;
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            return Err(format!("a ring of {} points is no polygon", points.len()));
        }
        rings.push(points);
    }
    Ok(())
}

fn point(position: &Position) -> Result<[f64; 2], String> {
    match *position.as_slice() {
        [x, y, ..] if x.is_finite() && y.is_finite() => Ok([x, y]),
        _ => Err("a point without two finite coordinates".to_owned()),
    }
}

/// The members of a document that GeoJSON does not know.
pub(super) fn foreign_members(document: &GeoJson) -> Option<&JsonObject> {
    match document {
        GeoJson::Geometry(geometry) => geometry.foreign_members.as_ref(),
        GeoJson::Feature(feature) => feature.foreign_members.as_ref(),
        GeoJson::FeatureCollection(all) => all.foreign_members.as_ref(),
    }
}

/// Reads the `crs` member of old GeoJSON, such as `{"type": "name", "properties": {"name": "EPSG:28992"}}`.
pub(super) fn frame(members: Option<&JsonObject>) -> Result<Frame, String> {
    let Some(crs) = members.and_then(|m| m.get("crs")).filter(|crs| !crs.is_null()) else {
        return Ok(Frame::Scene);
    };
    let Some(name) = crs["properties"]["name"].as_str() else {
        return Err(
            "its crs has no properties.name; write one such as EPSG:28992, or leave crs out".to_owned()
        );
    };
    let code = name.rsplit(':').next().unwrap_or(name);
    if name.contains("CRS84") || code == "4326" {
        return Err("its coordinates are degrees; save it in the scene's spatial reference system".to_owned());
    }
    Ok(Frame::Srs(if name.contains("EPSG") { format!("EPSG:{code}") } else { name.to_owned() }))
}

#[cfg(test)]
mod tests {
    use super::{Frame, PolygonFile};
    use glam::DVec2;
    use std::path::Path;

    const RING: &str = "[[0,0],[10,0],[10,10],[0,0]]";

    fn parse(text: &str) -> Result<PolygonFile, String> {
        PolygonFile::parse(text, Path::new("a.geojson"))
    }

    #[test]
    fn reads_every_kind_of_document() {
        let polygon = format!(r#"{{"type":"Polygon","coordinates":[{RING}]}}"#);
        let several = format!(r#"{{"type":"MultiPolygon","coordinates":[[{RING}],[{RING}]]}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":null,"geometry":{polygon}}}"#);
        let all = format!(r#"{{"type":"FeatureCollection","features":[{feature},{feature}]}}"#);
        for (text, rings) in [(polygon, 1), (several, 2), (feature, 1), (all, 2)] {
            let file = parse(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(file.rings, vec![vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]; rings], "{text}");
            assert_eq!(file.frame, Frame::Scene);
        }
    }

    #[test]
    fn a_crs_member_moves_the_polygon_into_the_scene() {
        let text = |name: &str| {
            format!(
                r#"{{"type":"FeatureCollection","crs":{{"type":"name","properties":{{"name":"{name}"}}}},"features":
                [{{"type":"Feature","properties":null,"geometry":{{"type":"Polygon","coordinates":[{RING}]}}}}]}}"#
            )
        };
        let file = parse(&text("urn:ogc:def:crs:EPSG::28992")).expect("a good file");
        assert_eq!(file.frame, Frame::Srs("EPSG:28992".to_owned()));
        assert_eq!(file.in_scene(DVec2::new(4.0, 1.0)).rings[0][1], DVec2::new(6.0, -1.0));
        assert!(parse(&text("urn:ogc:def:crs:OGC:1.3:CRS84")).expect_err("degrees").contains("degrees"));
    }

    #[test]
    fn refuses_what_holds_no_polygon() {
        for (text, part) in [
            ("[1,2]", "no GeoJSON"),
            (r#"{"type":"Point","coordinates":[1,2]}"#, "holds no polygon"),
            (r#"{"type":"Polygon","coordinates":[[[0,0],[1,1],[0,0]]]}"#, "a ring of 2 points"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
