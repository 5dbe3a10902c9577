//! Helpers that several test files share.
#![allow(dead_code, clippy::print_stderr)] // not every file needs every helper; a skipped test says so

use glam::DVec3;
use lacuna_mesh::VertexId;
use lacuna_tile::{Corner, HolePatch};
use std::fs;
use std::path::{Path, PathBuf};

/// A temporary folder.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("write");
        path
    }

    /// Names in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// A path in the shared data, `None` (said aloud) where they are absent.
pub(crate) fn shared_data(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    if !found.exists() {
        eprintln!("skipped: ../shared/data/{path} is absent");
        return None;
    }
    Some(found)
}

/// All files below a folder with this extension, sorted.
pub(crate) fn files_below(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("folder") {
        let path = entry.expect("entry").path();
        if path.is_dir() {
            files.extend(files_below(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// A corner of the tile.
pub(crate) fn old(id: u32) -> Corner {
    Corner::Original(VertexId(id))
}

/// A corner of the patch.
pub(crate) fn new(id: u32) -> Corner {
    Corner::New(id)
}

/// A patch with this id.
pub(crate) fn patch(hole: &str, vertices: &[[f64; 3]], triangles: &[[Corner; 3]]) -> HolePatch {
    HolePatch {
        hole: hole.to_owned(),
        cluster: "84512_447233".to_owned(),
        class: "closed".to_owned(),
        shape: None,
        method: "layered".to_owned(),
        filler: "delaunay".to_owned(),
        area_m2: 2.5,
        vertices: vertices.iter().map(|&v| DVec3::from(v)).collect(),
        triangles: triangles.to_vec(),
    }
}

/// Replaces the temporary folder's path, so that messages can be compared.
pub(crate) fn without_folder(message: &str, folder: &Folder) -> String {
    let path = folder.path("");
    message.replace(&*path.to_string_lossy(), "")
}
