//! The manifest of a run: what was read, with size, time and hash, and what was written.

use super::RunError;
use super::out_dir::io_error;
use lacuna_tile::{AtomicFile, output_path};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::Write;
use std::path::Path;

/// Name of the file in OUT/lacuna.
pub(crate) const MANIFEST: &str = "manifest.json";

/// Version of the manifest's form.
const VERSION: u32 = 1;

/// One file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct InputFile {
    pub(crate) path: String,
    pub(crate) bytes: u64,
    /// Time of the last change, nanoseconds since 1970.
    pub(crate) modified_ns: u64,
    pub(crate) blake3: String,
}

/// One file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct OutputFile {
    pub(crate) path: String,
    pub(crate) bytes: u64,
    pub(crate) blake3: String,
    /// True if the file differs from the input's file of the same name, or has none.
    pub(crate) changed: bool,
}

impl OutputFile {
    /// A file that the run is going to write.
    pub(crate) fn coming(path: &str) -> Self {
        Self { path: path.to_owned(), bytes: 0, blake3: String::new(), changed: true }
    }
}

/// Written first with no outputs and `finished: false`, and again at the end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    pub(crate) version: u32,
    pub(crate) lacuna: String,
    /// The solver and the kind of processor: their last bits may differ from others'.
    pub(crate) solver: String,
    pub(crate) finished: bool,
    pub(crate) untouched: String,
    pub(crate) inputs: Vec<InputFile>,
    pub(crate) outputs: Vec<OutputFile>,
}

impl Manifest {
    pub(crate) fn new(untouched: String) -> Self {
        Self {
            version: VERSION,
            lacuna: env!("CARGO_PKG_VERSION").to_owned(),
            solver: format!("faer {}", std::env::consts::ARCH),
            finished: false,
            untouched,
            inputs: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// The manifest at a path; `None` if there is none.
    pub(crate) fn read(path: &Path) -> Result<Option<Self>, RunError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(io_error("read", path, &e)),
        };
        let manifest: Self = serde_json::from_str(&text).map_err(|e| {
            RunError::input_output(format!(
                "{}: not a manifest of lacuna ({e}); give another output folder",
                path.display()
            ))
        })?;
        if manifest.version != VERSION {
            return Err(RunError::input_output(format!(
                "{}: written by another version of lacuna ({}); use that one or give another output folder",
                path.display(),
                manifest.lacuna
            )));
        }
        Ok(Some(manifest))
    }

    /// Writes the manifest whole or not at all.
    pub(crate) fn write(&self, path: &Path) -> Result<(), RunError> {
        let text = serde_json::to_string_pretty(self).map_err(|e| RunError::failed(e.to_string()))?;
        write_whole(path, text.as_bytes())
    }

    /// Deletes the files that the manifest lists, and nothing else.
    pub(crate) fn delete_listed(&self, out: &Path) -> Result<(), RunError> {
        for file in &self.outputs {
            let path = output_path(out, &file.path).map_err(|e| RunError::failed(e.to_string()))?;
            match fs::remove_file(&path) {
                Ok(()) => {}
                Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
                Err(e) => return Err(io_error("delete", &path, &e)),
            }
        }
        Ok(())
    }
}

/// Writes a file under its final name, whole or not at all.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RunError> {
    let problem = |e: lacuna_tile::TileError| RunError::input_output(e.to_string());
    let mut file = AtomicFile::create(path).map_err(problem)?;
    file.write_all(bytes).map_err(|e| io_error("write", path, &e))?;
    file.commit().map_err(problem)?;
    Ok(())
}
