//! Promise 3: repairs the scene again with another number of threads and compares what comes out.

use super::digest::digest;
use super::verdict::Findings;
use crate::config::{
    AreaLimit, AreaSettings, FillSettings, FindSettings, RunSettings, SceneSettings, Selection, Settings,
};
use crate::progress::Progress;
use crate::report::Report;
use crate::{ExitCode, Interrupt, RunError, repair};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;

/// Repairs `scene` into a temporary folder with the settings of the report and compares the digests. `Ok(None)` if the
/// settings cannot be made again from the report: they name polygons, of which it holds a hash alone.
pub(super) fn check_again(
    scene: &Path,
    out: &Path,
    report: &Report,
    interrupt: &Interrupt,
) -> Result<Option<Findings>, RunError> {
    let Some(mut settings) = settings_of(&report.configuration) else { return Ok(None) };
    let folder = tempfile::tempdir().map_err(|e| RunError {
        exit: ExitCode::InputOutput,
        message: format!(
            "no temporary folder to repair again in: {e}; free some space, or let TMPDIR name another folder"
        ),
    })?;
    let again = folder.path().join("out");
    settings.scene.input = scene.to_owned();
    settings.scene.output = Some(again.clone());
    settings.run = RunSettings {
        memory_limit_bytes: report.memory_limit_bytes,
        threads: if report.threads == 1 { 2 } else { 1 },
        ..RunSettings::default()
    };
    let mut findings = Findings::default();
    findings.note(format!("repaired again with {} thread(s) and compared", settings.run.threads));
    repair(&settings, interrupt, &Progress::silent())?;
    let (before, after) = (digest(out)?, digest(&again)?);
    findings.count("digests", 2);
    if before != after {
        findings.offend(format!("another digest: {before} in OUT, {after} now"));
    }
    Ok(Some(findings))
}

/// The settings that shape the output, as `Settings::to_json` wrote them.
fn settings_of(configuration: &Value) -> Option<Settings> {
    let limit = match configuration["area"]["limit"].as_str() {
        Some("cells") => AreaLimit::Cells,
        Some("box") => AreaLimit::Box,
        _ => return None,
    };
    if !configuration["regions"].as_array()?.is_empty() || !configuration["water_polygons"].is_null() {
        return None;
    }
    let (scene, find, fill, selection) = (
        &configuration["scene"],
        &configuration["find"],
        &configuration["fill"],
        &configuration["selection"],
    );
    Some(Settings {
        scene: SceneSettings {
            untouched: get(scene, "untouched")?,
            cell_size_m: get(scene, "cell_size_m")?,
            cell_origin_m: get(scene, "cell_origin_m")?,
            up_axis: get(scene, "up_axis")?,
            srs: get(scene, "srs")?,
            srs_origin: get(scene, "srs_origin")?,
            ..SceneSettings::default()
        },
        area: AreaSettings { limit, external: get(&configuration["area"], "external")? },
        find: FindSettings {
            min_area_m2: get(find, "min_area_m2")?,
            max_area_m2: get(find, "max_area_m2")?,
            max_perimeter_m: get(find, "max_perimeter_m")?,
            max_edges_around_hole: get(find, "max_edges_around_hole")?,
            class: get(find, "class")?,
            shape: get(find, "shape")?,
        },
        fill: FillSettings {
            method: get(fill, "method")?,
            closed: get(fill, "closed")?,
            open: get(fill, "open")?,
            spacing_m: get(fill, "spacing_m")?,
            water: get(fill, "water")?,
            max_unknowns: get(fill, "max_unknowns")?,
            islands: get(fill, "islands")?,
        },
        selection: Selection {
            regions: get(selection, "regions")?,
            cells: get(selection, "cells")?,
            at: get(selection, "at")?,
            holes: get(selection, "holes")?,
        },
        ..Settings::default()
    })
}

fn get<T: DeserializeOwned>(object: &Value, key: &str) -> Option<T> {
    serde_json::from_value(object[key].clone()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{WaterIslands, WaterMode};

    #[test]
    fn settings_come_back_from_the_report() {
        let mut settings = Settings::default();
        settings.scene.cell_size_m = Some(50.0);
        settings.find.max_area_m2 = Some(12.5);
        settings.area.limit = AreaLimit::Box;
        settings.selection.at = vec![[1.0, 2.0]];
        settings.fill.spacing_m = Some(0.75);
        settings.fill.max_unknowns = 5000;
        settings.fill.water = WaterMode::Sloped { from_m: 1.5, to_m: -0.45 };
        settings.fill.islands = WaterIslands::Under { max_area_m2: 400.0 };
        assert_eq!(settings_of(&settings.to_json()), Some(settings));
        assert_eq!(settings_of(&serde_json::json!({})), None);
    }
}
