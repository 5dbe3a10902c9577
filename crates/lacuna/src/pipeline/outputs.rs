//! The files of OUT/lacuna that people read: report, page, maps.

use super::RunError;
use super::context::Stopwatch;
use super::manifest::write_whole;
use super::run::RunResult;
use crate::report::{cells_geojson, holes_geojson, page};
use std::path::Path;

/// Writes report.json, report.html, holes.geojson and cells.geojson into a folder; report.json last, with the time that
/// the others took since `clock`.
pub(crate) fn write_report(result: &mut RunResult, folder: &Path, clock: Stopwatch) -> Result<(), RunError> {
    let failed = |e: &dyn std::fmt::Display| RunError::failed(format!("the report could not be made: {e}"));
    let holes = holes_geojson(&result.report, &result.drawing).map_err(|e| failed(&e))?;
    write_whole(&folder.join("holes.geojson"), holes.as_bytes())?;
    let cells = cells_geojson(&result.report, &result.drawing).map_err(|e| failed(&e))?;
    write_whole(&folder.join("cells.geojson"), cells.as_bytes())?;
    let html = page(&result.report, &result.drawing).map_err(|e| failed(&e))?;
    write_whole(&folder.join("report.html"), html.as_bytes())?;
    let stage = clock.stop("report");
    result.report.execution.seconds += stage.seconds;
    result.report.peak_rss_bytes = result.report.peak_rss_bytes.max(stage.peak_rss_bytes);
    result.report.stages.push(stage);
    let json = result.report.to_json().map_err(|e| failed(&e))?;
    write_whole(&folder.join("report.json"), json.as_bytes())
}
