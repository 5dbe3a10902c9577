//! Writes a scene: one cell in memory at a time.

use crate::class::Class;
use crate::maker::{Maker, OptionError, PinchedError};
use crate::plan::Counts;
use crate::record::Record;
use crate::tile::CellScene;
use std::path::{Path, PathBuf};

/// What was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Tiles written.
    pub tiles: usize,
    /// Cells of the area.
    pub cells: usize,
    /// Triangles written.
    pub triangles: u64,
    /// Bytes of all tiles.
    pub bytes: u64,
    /// Holes of each class, one a cell, counted on the triangles that are left.
    pub counts: Counts,
}

/// Why no scene was made, or not the promised one.
#[derive(Debug, thiserror::Error)]
pub enum MakeError {
    /// Contradictory options.
    #[error(transparent)]
    Options(#[from] OptionError),
    /// Rims that can't be cleaned.
    #[error(transparent)]
    Pinched(#[from] PinchedError),
    /// The folder isn't empty.
    #[error("{}: the folder is not empty; name a new one", .0.display())]
    NotEmpty(PathBuf),
    /// A file can't be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A cell shows other holes than planned.
    #[error(
        "{tile}: the triangles show {found}, planned were {planned}; take more --triangles or another --seed"
    )]
    Classes {
        /// The tile's name.
        tile: String,
        /// Holes and classes found.
        found: String,
        /// Holes and classes planned.
        planned: String,
    },
}

/// Makes all cells, writes tiles, `scene.json` and `truth.csv`, and checks that every cell shows the planned classes.
///
/// # Errors
/// See [`MakeError`]; files written so far stay.
pub fn make(maker: &Maker, out: &Path) -> Result<Summary, MakeError> {
    claim_folder(out)?;
    let mut record = Record::start(maker, out)?;
    let summary = write_cells(maker, out, |scene, bytes| record.add(maker, scene, bytes))?;
    record.finish(maker, &summary, out)?;
    Ok(summary)
}

/// Makes the tiles alone, for scenes on which time and memory are measured: what judges a repair would be copied with
/// them, and of large holes it is as large as a tile.
///
/// # Errors
/// See [`MakeError`]; files written so far stay.
pub fn make_tiles(maker: &Maker, out: &Path) -> Result<Summary, MakeError> {
    claim_folder(out)?;
    write_cells(maker, out, |_, _| Ok(()))
}

/// Writes every cell's tile and hands the cell with the tile's bytes (0: no file) to `record`.
fn write_cells(
    maker: &Maker,
    out: &Path,
    mut record: impl FnMut(&CellScene, u64) -> Result<(), MakeError>,
) -> Result<Summary, MakeError> {
    let mut summary = Summary::default();
    for cell in maker.plan().area.cells() {
        let scene = maker.cell(cell)?;
        check_classes(maker, &scene)?;
        let bytes = if scene.tile.triangles.is_empty() { 0 } else { write_tile(maker, &scene, out)? };
        summary.add(&scene, bytes);
        record(&scene, bytes)?;
    }
    Ok(summary)
}

impl Summary {
    fn add(&mut self, scene: &CellScene, bytes: u64) {
        self.tiles += usize::from(bytes > 0);
        self.cells += 1;
        self.triangles += scene.tile.triangles.len() as u64;
        self.bytes += bytes;
        for piece in &scene.pieces {
            *self.counts.entry(piece.class).or_default() += 1;
        }
    }
}

fn claim_folder(out: &Path) -> Result<(), MakeError> {
    std::fs::create_dir_all(out).map_err(|e| io_error(out, e))?;
    let mut entries = std::fs::read_dir(out).map_err(|e| io_error(out, e))?;
    if entries.next().is_some() { Err(MakeError::NotEmpty(out.into())) } else { Ok(()) }
}

/// An input/output error with its path.
pub(crate) fn io_error(path: &Path, source: std::io::Error) -> MakeError {
    MakeError::Io { path: path.into(), source }
}

fn write_tile(maker: &Maker, scene: &CellScene, out: &Path) -> Result<u64, MakeError> {
    let name = maker.tile_name(scene.cell);
    let folder = out.join(&name);
    std::fs::create_dir_all(&folder).map_err(|e| io_error(&folder, e))?;
    let path = folder.join(&name).with_extension(maker.options().format.extension());
    let bytes = maker.encode(scene);
    std::fs::write(&path, &bytes).map_err(|e| io_error(&path, e))?;
    Ok(bytes.len() as u64)
}

/// Compares the holes a cell shows with the planned ones.
fn check_classes(maker: &Maker, scene: &CellScene) -> Result<(), MakeError> {
    let mut found: Vec<(u32, Class)> = scene.pieces.iter().map(|p| (p.hole, p.class)).collect();
    let holes = maker.plan().holes.iter().enumerate();
    let mut planned: Vec<(u32, Class)> = holes
        .flat_map(|(k, h)| h.expected.iter().filter(|e| e.0 == scene.cell).map(move |e| (k as u32, e.1)))
        .collect();
    found.sort_unstable();
    planned.sort_unstable();
    if found == planned {
        return Ok(());
    }
    let named = |list: &[(u32, Class)]| {
        let names: Vec<String> =
            list.iter().map(|(k, class)| format!("{} {class}", maker.plan().holes[*k as usize].id)).collect();
        if names.is_empty() { "no hole".to_owned() } else { names.join(", ") }
    };
    Err(MakeError::Classes {
        tile: maker.tile_name(scene.cell),
        found: named(&found),
        planned: named(&planned),
    })
}
