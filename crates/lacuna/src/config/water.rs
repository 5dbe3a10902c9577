//! What the user says about water: modes, islands, and polygons with levels.

use super::error::ConfigError;
use super::polygon::{Frame, collect, foreign_members, frame, read_text};
use crate::PolygonSet;
use geojson::{Feature, GeoJson};
use glam::DVec2;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// How water is filled (method `field`). Heights are SRS heights, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WaterMode {
    /// A level where the rim shows one.
    #[default]
    Auto,
    /// As any other ground.
    Off,
    /// It is water: at the level that the rim comes nearest to.
    Force,
    /// At this height.
    Level(f64),
    /// Falling along the hole: one of these heights at each end.
    Sloped {
        /// At one end of the hole's longer axis.
        from_m: f64,
        /// At the other.
        to_m: f64,
    },
}

impl WaterMode {
    /// The same water with heights counted from a zero that lies `by_m` higher.
    #[must_use]
    pub fn lowered(self, by_m: f64) -> Self {
        match self {
            Self::Level(z) => Self::Level(z - by_m),
            Self::Sloped { from_m, to_m } => Self::Sloped { from_m: from_m - by_m, to_m: to_m - by_m },
            Self::Auto | Self::Off | Self::Force => self,
        }
    }

    /// True if no height is infinite or no number.
    #[must_use]
    pub fn is_finite(self) -> bool {
        match self {
            Self::Level(z) => z.is_finite(),
            Self::Sloped { from_m, to_m } => from_m.is_finite() && to_m.is_finite(),
            Self::Auto | Self::Off | Self::Force => true,
        }
    }
}

/// What becomes of surface that hangs in a hole that is water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WaterIslands {
    /// The water meets its rim.
    #[default]
    Join,
    /// The water passes beneath it, if it is small and its rim is clear of the water: boats, buoys.
    Under {
        /// Largest plan area, square metres.
        max_area_m2: f64,
    },
}

/// One feature of a file of water polygons.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterPolygon {
    /// Its number in the file, from 0.
    pub feature: usize,
    /// All rings; a point is inside if an odd number of them holds it.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Height of the water in the frame of the file, metres; `None` = what the rim shows.
    pub level_m: Option<f64>,
}

/// Polygons that are water, from one GeoJSON file. In the report it is a hash over coordinates and levels.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterFile {
    /// Where it was read.
    pub path: PathBuf,
    /// What its coordinates and levels mean.
    pub frame: Frame,
    /// At least one.
    pub polygons: Vec<WaterPolygon>,
}

/// Names of the property that holds a level; the first one that a feature has counts.
const LEVEL_NAMES: [&str; 3] = ["level_m", "level", "height"];

impl WaterFile {
    /// Reads a file. Features without polygons are somebody's notes.
    ///
    /// # Errors
    /// A file that cannot be read, is larger than 64 MiB, is no GeoJSON, holds no polygon, has a ring or a level that is
    /// none (the message names the feature, counted from 0), or a `crs` in degrees.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text = read_text(path)?;
        Self::parse(&text, path).map_err(|what| ConfigError::Polygon { path: path.to_owned(), what })
    }

    fn parse(text: &str, path: &Path) -> Result<Self, String> {
        let document: GeoJson = text.parse().map_err(|e| format!("no GeoJSON: {e}"))?;
        let frame = frame(foreign_members(&document))?;
        let mut polygons = Vec::new();
        match &document {
            GeoJson::Geometry(geometry) => {
                let mut rings = Vec::new();
                collect(geometry, &mut rings)?;
                polygons.push(WaterPolygon { feature: 0, rings, level_m: None });
            }
            GeoJson::Feature(feature) => polygons.push(water_polygon(0, feature)?),
            GeoJson::FeatureCollection(all) => {
                for (number, feature) in all.features.iter().enumerate() {
                    polygons.push(water_polygon(number, feature)?);
                }
            }
        }
        polygons.retain(|p| !p.rings.is_empty());
        if polygons.is_empty() {
            return Err("holds no polygon; draw at least one round the water".to_owned());
        }
        Ok(Self { path: path.to_owned(), frame, polygons })
    }

    /// The rings of a polygon in scene coordinates. `srs_origin` is what is added to scene coordinates to get SRS
    /// coordinates.
    #[must_use]
    pub fn in_scene(&self, polygon: &WaterPolygon, srs_origin: DVec2) -> PolygonSet {
        let shift = if self.frame == Frame::Scene { DVec2::ZERO } else { srs_origin };
        let move_ring = |ring: &Vec<[f64; 2]>| ring.iter().map(|&p| DVec2::from(p) - shift).collect();
        PolygonSet { rings: polygon.rings.iter().map(move_ring).collect() }
    }

    /// What a polygon says of the water in it, in SRS heights. `srs_height_m` is what is added to scene heights to get
    /// them.
    #[must_use]
    pub fn mode(&self, polygon: &WaterPolygon, srs_height_m: f64) -> WaterMode {
        let lift_m = if self.frame == Frame::Scene { srs_height_m } else { 0.0 };
        polygon.level_m.map_or(WaterMode::Force, |z| WaterMode::Level(z + lift_m))
    }

    fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for polygon in &self.polygons {
            hasher.update(&polygon.level_m.unwrap_or(f64::NAN).to_le_bytes());
            for ring in &polygon.rings {
                hasher.update(&(ring.len() as u64).to_le_bytes());
                ring.iter().flatten().for_each(|c| _ = hasher.update(&c.to_le_bytes()));
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

impl Serialize for WaterFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("polygons", &self.polygons.len())?;
        map.serialize_entry("coordinates", self.frame.word())?;
        map.serialize_entry("blake3", &self.hash())?;
        map.end()
    }
}

fn water_polygon(number: usize, feature: &Feature) -> Result<WaterPolygon, String> {
    let of_feature = |what: String| format!("feature {number}: {what}");
    let mut rings = Vec::new();
    if let Some(geometry) = &feature.geometry {
        collect(geometry, &mut rings).map_err(of_feature)?;
    }
    let level_m = level(feature).map_err(of_feature)?;
    Ok(WaterPolygon { feature: number, rings, level_m })
}

/// The level of a feature, if it has one that is not null.
fn level(feature: &Feature) -> Result<Option<f64>, String> {
    let property = |name: &'static str| Some((name, feature.property(name)?));
    let Some((name, value)) = LEVEL_NAMES.into_iter().filter_map(property).find(|(_, v)| !v.is_null()) else {
        return Ok(None);
    };
    match value.as_f64().filter(|z| z.is_finite()) {
        Some(z) => Ok(Some(z)),
        None => Err(format!("{name} is {value}; give a height in metres as a number, or leave it out")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: &str = "[[0,0],[10,0],[10,10],[0,0]]";

    fn parse(text: &str) -> Result<WaterFile, String> {
        WaterFile::parse(text, Path::new("water.geojson"))
    }

    fn feature(properties: &str, rings: &str) -> String {
        format!(
            r#"{{"type":"Feature","properties":{properties},"geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#
        )
    }

    fn collection(features: &[String]) -> String {
        format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
    }

    #[test]
    fn levels_come_from_the_first_property_that_has_one() {
        for (properties, expected) in [
            ("null", None),
            ("{}", None),
            (r#"{"level_m":-0.45}"#, Some(-0.45)),
            (r#"{"level":3}"#, Some(3.0)),
            (r#"{"height":2.5,"name":"moat"}"#, Some(2.5)),
            (r#"{"height":9,"level_m":1}"#, Some(1.0)),
            (r#"{"level_m":null,"level":4}"#, Some(4.0)),
        ] {
            let file = parse(&feature(properties, RING)).unwrap_or_else(|e| panic!("{properties}: {e}"));
            assert_eq!(file.polygons[0].level_m, expected, "{properties}");
            let mode = expected.map_or(WaterMode::Force, |z| WaterMode::Level(z + 7.0));
            assert_eq!(file.mode(&file.polygons[0], 7.0), mode, "the file counts as the scene does");
        }
        assert_eq!(
            parse(&format!(r#"{{"type":"Polygon","coordinates":[{RING}]}}"#)).map(|f| f.polygons.len()),
            Ok(1)
        );
    }

    #[test]
    fn features_keep_their_numbers() {
        let note = r#"{"type":"Feature","properties":null,"geometry":{"type":"Point","coordinates":[1,2]}}"#;
        let file = parse(&collection(&[note.to_owned(), feature("null", RING)])).expect("a good file");
        assert_eq!(file.polygons.iter().map(|p| p.feature).collect::<Vec<_>>(), [1]);
    }

    #[test]
    fn bad_features_are_named() {
        let good = feature("{}", RING);
        for (bad, part) in [
            (feature(r#"{"level_m":"low"}"#, RING), r#"feature 1: level_m is "low"; give a height"#),
            (feature(r#"{"level":true}"#, RING), "feature 1: level is true"),
            (feature("{}", "[[0,0],[1,1],[0,0]]"), "feature 1: a ring of 2 points"),
        ] {
            let error = parse(&collection(&[good.clone(), bad.clone()])).expect_err(&bad);
            assert!(error.contains(part), "{error}");
        }
        assert!(parse(&collection(&[])).expect_err("empty").contains("holds no polygon"));
        assert!(parse("{}").expect_err("nothing").contains("no GeoJSON"));
    }

    #[test]
    fn the_hash_sees_levels_and_rings() {
        let hash = |properties| parse(&feature(properties, RING)).expect("a good file").hash();
        assert_ne!(hash(r#"{"level_m":1}"#), hash(r#"{"level_m":2}"#));
        assert_ne!(hash(r#"{"level_m":1}"#), hash("{}"));
        assert_eq!(hash(r#"{"level_m":1}"#), hash(r#"{"level":1}"#));
    }
}
