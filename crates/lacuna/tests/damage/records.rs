//! Changes to the records in OUT/lacuna.

use serde_json::Value;
use std::path::Path;

/// Changes a JSON file of OUT/lacuna.
pub(crate) fn edit_json(out: &Path, name: &str, change: impl FnOnce(&mut Value)) {
    let path = out.join("lacuna").join(name);
    let mut value: Value = serde_json::from_slice(&std::fs::read(&path).expect("a record")).expect("JSON");
    change(&mut value);
    std::fs::write(&path, serde_json::to_vec_pretty(&value).expect("JSON")).expect("written");
}

/// Lists every output in the manifest as it is now, so that a damage does not show by the hash of its file alone.
pub(crate) fn relist(out: &Path) {
    edit_json(out, "manifest.json", |manifest| {
        for file in manifest["outputs"].as_array_mut().expect("outputs") {
            let Ok(bytes) = std::fs::read(out.join(file["path"].as_str().expect("a path"))) else { continue };
            file["bytes"] = bytes.len().into();
            file["blake3"] = blake3::hash(&bytes).to_hex().to_string().into();
        }
    });
}
