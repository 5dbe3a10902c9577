//! What a run left in OUT.

use lacuna::report::Report;
use std::collections::BTreeMap;
use std::path::Path;

/// Files that are about one run and may differ between equal ones.
const RUN_FILES: [&str; 5] =
    ["lacuna/.lock", "lacuna/manifest.json", "lacuna/report.html", "lacuna/run.log", "lacuna/journal"];

/// Keys of report.json that are about one run.
const RUN_FACTS: [&str; 6] =
    ["lacuna", "threads", "memory_limit_bytes", "peak_rss_bytes", "stages", "execution"];

/// Every file below a folder by its relative path. Links are not followed.
pub(crate) fn files_in(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).expect("a folder") {
            let entry = entry.expect("an entry");
            let path = entry.path();
            let kind = entry.file_type().expect("a kind");
            if kind.is_dir() {
                folders.push(path);
            } else if kind.is_file() {
                let relative = path.strip_prefix(folder).expect("inside").to_string_lossy().into_owned();
                let bytes = std::fs::read(&path).unwrap_or_default();
                files.insert(relative, bytes);
            }
        }
    }
    files
}

/// What must be the same in every run of the same scene and settings: all files but those about the run.
pub(crate) fn digest(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files_in(out);
    RUN_FILES.iter().for_each(|name| drop(files.remove(*name)));
    if let Some(bytes) = files.get_mut("lacuna/report.json") {
        let mut value: serde_json::Value = serde_json::from_slice(bytes).expect("a report");
        let object = value.as_object_mut().expect("an object");
        RUN_FACTS.iter().for_each(|key| drop(object.remove(*key)));
        *bytes = serde_json::to_vec(&value).expect("JSON");
    }
    files
}

/// Compares two digests file by file, so that the message names the file and not its bytes.
#[track_caller]
pub(crate) fn same_bytes(left: &BTreeMap<String, Vec<u8>>, right: &BTreeMap<String, Vec<u8>>, what: &str) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(left), names(right), "{what}: other files");
    for (name, bytes) in left {
        assert!(*bytes == right[name], "{what}: {name} differs");
    }
}

/// The report of a run, from OUT or from the folder of `inspect --report`.
pub(crate) fn report(folder: &Path) -> Report {
    let own = folder.join("lacuna/report.json");
    let path = if own.exists() { own } else { folder.join("report.json") };
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Report::from_json(&text).expect("a report")
}
