//! A folder of tiles: what is in it, which files belong to one cell, what is copied along.

mod error;
mod group;
mod hollow;
mod output;
mod walk;

pub use error::SceneError;
pub use hollow::hollow_tile_path;
pub use output::output_path;

use crate::error::TileError;
use crate::metadata::{SceneMetadata, find_metadata};
use crate::names::{TileName, is_adaptive};
use crate::tile::read_header;
use crate::types::{TileFormat, TileHeader};
use std::path::{Path, PathBuf};

/// How a scene's folder is walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneOptions {
    /// Follow symbolic links that stay inside the scene. Links that leave it are never followed.
    pub follow_symlinks: bool,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self { follow_symlinks: true }
    }
}

/// A folder of tiles. Nothing in it is opened but the tiles' headers and the metadata file.
#[derive(Debug)]
pub struct Scene {
    /// The folder, as given.
    pub root: PathBuf,
    /// Every tile file, sorted by `relative`.
    pub tiles: Vec<TileEntry>,
    /// Tiles by cell, in the order of their first files.
    pub groups: Vec<TileGroup>,
    /// Every other file, relative to the root, sorted: textures, materials, XML, hidden files.
    pub side_files: Vec<String>,
    /// Spatial reference, if a metadata file was found.
    pub metadata: Option<SceneMetadata>,
    /// Metadata files that were looked for, relative to the root, up to the one found.
    pub metadata_tried: Vec<String>,
    /// What was odd or left out, one line each.
    pub warnings: Vec<String>,
}

/// One tile file.
#[derive(Debug)]
pub struct TileEntry {
    /// Path relative to the root, with forward slashes. It comes from the folder walk, never from a file's content.
    pub relative: String,
    /// What messages and reports call it: the name of its group.
    pub name: String,
    /// Format, from the extension.
    pub format: TileFormat,
    /// Size of the tile, or why its header is unreadable. A bad header does not fail the scene.
    pub header: Result<TileHeader, TileError>,
    /// Cell and level, if the name speaks of them.
    pub parsed: Option<TileName>,
}

/// The tile of one cell: usually one file, sometimes several parts of one level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileGroup {
    /// The stem without level and part, unique in the scene; where stems repeat, the relative path without extension.
    pub name: String,
    /// Column (east) and row (north) by name; `None` if the name has no pair, or its pair is no cell.
    pub index: Option<(i32, i32)>,
    /// True if the index is certain (signed pair). Otherwise the caller checks it against the tiles' boxes.
    pub index_is_signed: bool,
    /// Indices into `Scene::tiles`, ascending.
    pub parts: Vec<usize>,
}

impl Scene {
    /// Where a tile's file lies.
    #[must_use]
    pub fn path(&self, tile: &TileEntry) -> PathBuf {
        self.root.join(&tile.relative)
    }
}

/// Opens a folder of tiles.
///
/// 1. Walks it in sorted order. Files with a tile's extension are tiles, all others side files.
/// 2. Reads each tile's header; a bad one stays with its tile as an error.
/// 3. Groups the tiles by cell. Files of one folder with the same index and level, whose names differ in the digits of
///    the level-of-detail node alone, are parts of one tile.
/// 4. Looks for the spatial reference.
///
/// Unsigned pairs (`cell_00_01`) that occur more than once in the scene are no cells: their indices are dropped with a
/// warning. Symbolic links that leave the folder, special files, and the records of an earlier run (`lacuna/` with a
/// manifest) are left out with a warning.
///
/// # Errors
/// No folder; an unreadable folder in it; a name that is not UTF-8; no tile at all; names of a tiling without a flat
/// grid; two files for one cell; an unusable metadata file.
pub fn open_scene(root: &Path, options: &SceneOptions) -> Result<Scene, SceneError> {
    let mut walked = walk::walk(root, options)?;
    let (tile_files, side_files) = split_tiles(std::mem::take(&mut walked.files));
    if tile_files.is_empty() {
        return Err(SceneError::no_tiles(root, &side_files));
    }
    let mut tiles = tile_files
        .into_iter()
        .map(|(relative, format)| read_entry(root, relative, format))
        .collect::<Result<Vec<_>, _>>()?;
    let mut warnings = walked.warnings;
    warnings.extend(error::foreign_tiles_warning(&side_files));
    let groups = group::group_tiles(root, &mut tiles, &mut warnings)?;
    let search = find_metadata(root)?;
    warnings.extend(search.warnings);
    Ok(Scene {
        root: root.to_owned(),
        tiles,
        groups,
        side_files,
        metadata: search.found,
        metadata_tried: search.tried,
        warnings,
    })
}

fn split_tiles(files: Vec<String>) -> (Vec<(String, TileFormat)>, Vec<String>) {
    let (mut tiles, mut side_files) = (Vec::new(), Vec::new());
    for relative in files {
        let hidden = file_name(&relative).starts_with('.');
        match TileFormat::from_path(Path::new(&relative)).filter(|_| !hidden) {
            Some(format) => tiles.push((relative, format)),
            None => side_files.push(relative),
        }
    }
    (tiles, side_files)
}

fn read_entry(root: &Path, relative: String, format: TileFormat) -> Result<TileEntry, SceneError> {
    let path = root.join(&relative);
    let stem = stem_of(&relative);
    if is_adaptive(stem) {
        return Err(SceneError::AdaptiveName { path });
    }
    let parsed = TileName::parse(stem);
    if parsed.as_ref().is_some_and(|name| name.z.is_some()) {
        return Err(SceneError::VolumetricName { path });
    }
    let header = read_header(&path, format);
    Ok(TileEntry { name: stem.to_owned(), relative, format, header, parsed })
}

fn file_name(relative: &str) -> &str {
    relative.rsplit('/').next().unwrap_or(relative)
}

/// The folder of a relative path; empty for the root.
fn folder_of(relative: &str) -> &str {
    relative.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// The file name without its extension.
fn stem_of(relative: &str) -> &str {
    let name = file_name(relative);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// The relative path without its extension.
fn without_extension(relative: &str) -> &str {
    &relative[..relative.len() - file_name(relative).len() + stem_of(relative).len()]
}
