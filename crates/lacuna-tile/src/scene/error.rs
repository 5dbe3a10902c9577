//! Why a folder is no scene.

use crate::metadata::MetadataError;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A folder that cannot be repaired as a whole. Every message names the folder or file and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A folder or file could not be read.
    #[error("{}: cannot {operation}: {source}; check the path and its permissions", shown(path))]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// What was tried.
        operation: &'static str,
        /// The system's answer, with its errno.
        source: std::io::Error,
    },
    /// The scene is a file.
    #[error("{}: not a folder; give the folder that holds the tiles", shown(path))]
    NotAFolder {
        /// The path given.
        path: PathBuf,
    },
    /// A name that cannot be written into reports.
    #[error("{}: the name is not UTF-8; rename it", shown(path))]
    NameNotUtf8 {
        /// The file or folder.
        path: PathBuf,
    },
    /// Folders nested beyond reason.
    #[error("{}: more than {limit} folders deep; give the folder that holds the tiles", shown(path))]
    TooDeep {
        /// The folder.
        path: PathBuf,
        /// The limit.
        limit: usize,
    },
    /// No tile in the folder.
    #[error("{}: no tile found; looked for .ply, .obj and .glb in it and its folders{hint}", shown(path))]
    NoTiles {
        /// The folder.
        path: PathBuf,
        /// Other tile formats that are there, and how to convert them.
        hint: String,
    },
    /// A name of a volumetric tiling.
    #[error(
        "{}: the name has three indices, so cells are stacked and there is no flat grid; \
         produce the scene again with a regular planar grid",
        shown(path)
    )]
    VolumetricName {
        /// The tile.
        path: PathBuf,
    },
    /// A name of an adaptive tiling.
    #[error(
        "{}: the name has one signed number, so cells differ in size and there is no grid; \
         produce the scene again with a regular planar grid, or rename the tile if the number means something else",
        shown(path)
    )]
    AdaptiveName {
        /// The tile.
        path: PathBuf,
    },
    /// Two files for one cell.
    #[error("{} and {} are both the tile of {cell}; {}", shown(first), shown(second), ONE_CELL_ADVICE)]
    TwoFilesForOneCell {
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
        /// The cell or stem they share.
        cell: String,
    },
    /// A relative path that must not be created.
    #[error("{:?}: not a path inside a scene: {problem}; rename the file", relative)]
    UnsafePath {
        /// The path.
        relative: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// The metadata file is there and cannot be used.
    #[error(transparent)]
    Metadata(#[from] MetadataError),
}

const ONE_CELL_ADVICE: &str =
    "give a folder that holds each cell once: one level of detail, one format (move the other file away)";

/// Formats that are tiles for other programs, and how to make ours of them.
const FOREIGN: [(&str, &str); 10] = [
    (
        "osgb",
        "convert each with OpenSceneGraph: osgconv in.osgb out.obj -O \"OutputTextureFiles precision=9\"",
    ),
    ("3mx", "export the production again as OBJ"),
    ("3mxb", "export the production again as OBJ"),
    ("3sm", "a closed format: export the production again as OBJ or 3D Tiles"),
    ("s3c", "a closed format: export the production again as OBJ or 3D Tiles"),
    ("b3dm", "unpack each: npx 3d-tiles-tools b3dmToGlb -i in.b3dm -o out.glb"),
    ("gltf", "pack each: npx gltf-pipeline -i in.gltf -o out.glb"),
    ("las", "a point cloud: mesh it first"),
    ("laz", "a point cloud: mesh it first"),
    ("slpk", "export the production again as OBJ"),
];

impl SceneError {
    /// No tile, with a hint for each foreign format among the files.
    pub(super) fn no_tiles(root: &Path, side_files: &[String]) -> Self {
        let mut hint = String::new();
        for (extension, count) in foreign_tiles(side_files) {
            let advice = FOREIGN.iter().find(|(e, _)| *e == extension).map_or("", |(_, advice)| advice);
            // Writing to a String cannot fail.
            let _ = write!(hint, "; found {count} .{extension}: {advice}");
        }
        if hint.is_empty() {
            hint.push_str("; give the folder that holds the tiles");
        }
        Self::NoTiles { path: root.to_owned(), hint }
    }
}

/// A line that says which foreign tiles lie among ours and are only copied.
pub(super) fn foreign_tiles_warning(side_files: &[String]) -> Option<String> {
    let found = foreign_tiles(side_files);
    let list: Vec<String> = found.iter().map(|(extension, count)| format!("{count} .{extension}")).collect();
    (!list.is_empty())
        .then(|| format!("{} copied, not repaired: not a format of this version", list.join(", ")))
}

fn foreign_tiles(side_files: &[String]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for file in side_files {
        let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
        if let Some((known, _)) = FOREIGN.iter().find(|(known, _)| extension.eq_ignore_ascii_case(known)) {
            *counts.entry(*known).or_insert(0) += 1;
        }
    }
    counts
}

/// A path for a message: control characters of hostile names do not reach the terminal.
fn shown(path: &Path) -> String {
    path.display().to_string().escape_debug().to_string()
}
