//! Files of a scene.

use super::DigError;
use std::path::{Path, PathBuf};

/// Files this tool writes itself: a dug scene has its own.
const OWN_FILES: [&str; 2] = ["scene.json", "truth.csv"];

/// Makes the folder; refuses one with files, or one inside the scene.
pub(super) fn claim_out(scene: &Path, out: &Path) -> Result<(), DigError> {
    std::fs::create_dir_all(out).map_err(|e| io_error(out, e))?;
    let real = |path: &Path| path.canonicalize().map_err(|e| io_error(path, e));
    let has_files = std::fs::read_dir(out).map_err(|e| io_error(out, e))?.next().is_some();
    if has_files || real(out)?.starts_with(real(scene)?) { Err(DigError::BadOut(out.into())) } else { Ok(()) }
}

/// Tiles, and all other files, as paths relative to the scene, sorted.
pub(super) fn list(scene: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>), DigError> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        let full = scene.join(&folder);
        for entry in std::fs::read_dir(&full).map_err(|e| io_error(&full, e))? {
            let entry = entry.map_err(|e| io_error(&full, e))?;
            let kind = entry.file_type().map_err(|e| io_error(&entry.path(), e))?;
            let path = folder.join(entry.file_name());
            if kind.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.retain(|f| !OWN_FILES.iter().any(|own| f.as_os_str() == *own));
    files.sort();
    let is_tile = |path: &PathBuf| {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply") || e.eq_ignore_ascii_case("obj"))
    };
    Ok(files.into_iter().partition(is_tile))
}

/// A whole file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, DigError> {
    std::fs::read(path).map_err(|e| io_error(path, e))
}

/// Writes a file and the folders above it.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), DigError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| io_error(folder, e))?;
    }
    std::fs::write(path, bytes).map_err(|e| io_error(path, e))
}

/// An input/output error with its path.
pub(super) fn io_error(path: &Path, source: std::io::Error) -> DigError {
    DigError::Io { path: path.into(), source }
}
