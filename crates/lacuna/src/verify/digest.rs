//! One hash over all that two runs promise to have in common.

use super::files::list_files;
use super::records::OWN_FOLDER;
use crate::{ExitCode, RunError};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Keys of report.json that two equal runs may differ in.
const RUN_FACTS: [&str; 6] =
    ["lacuna", "threads", "memory_limit_bytes", "peak_rss_bytes", "stages", "execution"];
/// Files of OUT/lacuna that are the same in every run, beside the report.
const SAME_RECORDS: [&str; 3] = ["cells.geojson", "holes.geojson", "plan.json"];

/// SHA-256 of what a run promises to write the same way under any thread count, memory limit or interruption: the
/// relative paths and bytes of all tiles and side files in sorted order, then plan.json, holes.geojson, cells.geojson and
/// report.json without its run facts. Lower-case hexadecimal.
///
/// Each file enters as its path, a zero byte, its length as 8 bytes (little endian) and its content.
///
/// # Errors
/// Unreadable files; a report that is no JSON object.
pub fn digest(out: &Path) -> Result<String, RunError> {
    let mut hash = Sha256::new();
    for relative in list_files(out, Some(OWN_FOLDER))? {
        add_file(&mut hash, &relative, &out.join(&relative))?;
    }
    let own = out.join(OWN_FOLDER);
    for name in SAME_RECORDS {
        add_file(&mut hash, &format!("{OWN_FOLDER}/{name}"), &own.join(name))?;
    }
    let report = report_without_run_facts(&own.join("report.json"))?;
    add_header(&mut hash, &format!("{OWN_FOLDER}/report.json"), report.len() as u64);
    hash.update(&report);
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

fn add_header(hash: &mut Sha256, name: &str, bytes: u64) {
    hash.update(name.as_bytes());
    hash.update([0]);
    hash.update(bytes.to_le_bytes());
}

fn add_file(hash: &mut Sha256, name: &str, path: &Path) -> Result<(), RunError> {
    let unreadable = |e: std::io::Error| RunError {
        exit: ExitCode::InputOutput,
        message: format!("cannot read {}: {e}; give the folder that `lacuna repair` wrote", path.display()),
    };
    let mut file = File::open(path).map_err(unreadable)?;
    let bytes = file.metadata().map_err(unreadable)?.len();
    add_header(hash, name, bytes);
    let mut buffer = vec![0; 256 << 10];
    loop {
        match file.read(&mut buffer).map_err(unreadable)? {
            0 => return Ok(()),
            read => hash.update(&buffer[..read]),
        }
    }
}

fn report_without_run_facts(path: &Path) -> Result<Vec<u8>, RunError> {
    let problem = |exit: ExitCode, what: String| RunError { exit, message: what };
    let text = std::fs::read(path)
        .map_err(|e| problem(ExitCode::InputOutput, format!("cannot read {}: {e}", path.display())))?;
    let not_ours =
        |e: String| problem(ExitCode::InputOutput, format!("{}: not a report: {e}", path.display()));
    let mut report: Value = serde_json::from_slice(&text).map_err(|e| not_ours(e.to_string()))?;
    let Some(members) = report.as_object_mut() else { return Err(not_ours("no object".to_owned())) };
    members.retain(|key, _| !RUN_FACTS.contains(&key.as_str()));
    serde_json::to_vec(&report).map_err(|e| not_ours(e.to_string()))
}
