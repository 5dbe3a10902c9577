//! What a run says about itself: manifest, report and maps of OUT/lacuna.

use crate::report::Report;
use crate::{ExitCode, PolygonSet, RunError};
use glam::DVec2;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The folder of OUT that is lacuna's own.
pub(super) const OWN_FOLDER: &str = "lacuna";

/// A file as the manifest lists it.
#[derive(Debug, Deserialize)]
pub(super) struct ListedFile {
    pub(super) path: String,
    pub(super) bytes: u64,
    pub(super) blake3: String,
}

/// The manifest, as far as `verify` reads it.
#[derive(Debug, Deserialize)]
pub(super) struct Manifest {
    pub(super) finished: bool,
    pub(super) untouched: String,
    pub(super) inputs: Vec<ListedFile>,
    pub(super) outputs: Vec<ListedFile>,
}

/// The records of a finished run.
#[derive(Debug)]
pub(super) struct Records {
    pub(super) manifest: Manifest,
    pub(super) report: Report,
    /// Outlines of the holes in scene coordinates, islands as further rings, by id.
    pub(super) outlines: BTreeMap<String, PolygonSet>,
    /// Outlines of their islands, by id.
    pub(super) islands: BTreeMap<String, IslandOutlines>,
}

/// The islands of a hole.
#[derive(Debug, Default)]
pub(super) struct IslandOutlines {
    /// Those that the patch joins.
    pub(super) joined: Vec<Vec<DVec2>>,
    /// Those that it passes beneath.
    pub(super) passed_under: Vec<Vec<DVec2>>,
}

impl Records {
    /// Reads the records of OUT.
    ///
    /// # Errors
    /// A folder without them, with records that are none, or of a run that did not finish.
    pub(super) fn read(out: &Path) -> Result<Self, RunError> {
        let own = out.join(OWN_FOLDER);
        let manifest: Manifest = read_json(&own.join("manifest.json"))?;
        if !manifest.finished {
            return Err(RunError {
                exit: ExitCode::Failed,
                message: format!("the run that wrote {} did not finish; run it again first", out.display()),
            });
        }
        let report: Report = read_json(&own.join("report.json"))?;
        let map: serde_json::Value = read_json(&own.join("holes.geojson"))?;
        let shift = shift(&report);
        let outlines = outlines(&map, shift);
        let islands = islands(&map, &outlines, shift);
        Ok(Self { manifest, report, outlines, islands })
    }

    /// True if untouched tiles were left out of OUT on purpose.
    pub(super) fn is_omitting(&self) -> bool {
        self.manifest.untouched == "omit"
    }
}

fn read_json<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, RunError> {
    let input_output = |what: String| RunError { exit: ExitCode::InputOutput, message: what };
    let text = std::fs::read_to_string(path).map_err(|e| {
        input_output(format!(
            "cannot read {}: {e}; give the folder that `lacuna repair` wrote",
            path.display()
        ))
    })?;
    serde_json::from_str(&text)
        .map_err(|e| input_output(format!("{}: not a record of lacuna: {e}; repair again", path.display())))
}

/// What the map adds to scene coordinates: the SRS origin, if the SRS has an EPSG code (decisions 5).
fn shift(report: &Report) -> DVec2 {
    let is_epsg = report.scene.srs.as_deref().is_some_and(|srs| srs.trim().starts_with("EPSG:"));
    let origin = report.scene.srs_origin.filter(|_| is_epsg).unwrap_or_default();
    DVec2::new(origin[0], origin[1])
}

fn outlines(map: &serde_json::Value, shift: DVec2) -> BTreeMap<String, PolygonSet> {
    let empty = Vec::new();
    let features = map["features"].as_array().unwrap_or(&empty);
    let outline = |feature: &serde_json::Value| {
        let id = feature["id"].as_str()?.to_owned();
        let rings = feature["geometry"]["coordinates"].as_array()?;
        let rings = rings.iter().map(|ring| ring_of(ring, shift)).collect::<Option<_>>()?;
        Some((id, PolygonSet { rings }))
    };
    features.iter().filter_map(outline).collect()
}

fn islands(
    map: &serde_json::Value,
    outlines: &BTreeMap<String, PolygonSet>,
    shift: DVec2,
) -> BTreeMap<String, IslandOutlines> {
    let features = map["features"].as_array().into_iter().flatten();
    let of_hole = |feature: &serde_json::Value| {
        let id = feature["id"].as_str()?.to_owned();
        let passed = feature["properties"]["passed_under"].as_array().into_iter().flatten();
        let passed_under = passed.map(|ring| ring_of(ring, shift)).collect::<Option<_>>()?;
        let joined =
            outlines.get(&id).map_or_else(Vec::new, |set| set.rings.iter().skip(1).cloned().collect());
        Some((id, IslandOutlines { joined, passed_under }))
    };
    features.filter_map(of_hole).collect()
}

/// A ring without its repeated last point.
fn ring_of(ring: &serde_json::Value, shift: DVec2) -> Option<Vec<DVec2>> {
    let point = |p: &serde_json::Value| Some(DVec2::new(p[0].as_f64()?, p[1].as_f64()?) - shift);
    let mut points: Vec<DVec2> = ring.as_array()?.iter().map(point).collect::<Option<_>>()?;
    points.pop();
    Some(points)
}
