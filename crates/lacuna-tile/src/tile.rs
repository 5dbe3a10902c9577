//! The four operations on a tile, by format.

use crate::error::TileError;
use crate::types::{AppendRequest, NewTileRequest, ReadOptions, ReadTile, TileFormat, TileHeader, Written};
use crate::{glb, obj, ply};
use std::path::Path;

/// Reads a whole tile into memory.
///
/// # Errors
/// `Io`, `TooLarge`, `InputChanged`, `Malformed`, `Unsupported`.
pub fn read_tile(path: &Path, format: TileFormat, options: &ReadOptions) -> Result<ReadTile, TileError> {
    match format {
        TileFormat::Ply => ply::read(path, options),
        TileFormat::Obj => obj::read(path, options),
        TileFormat::Glb => glb::read(path, options),
    }
}

/// Reads how large a tile is, without reading the tile.
///
/// # Errors
/// `Io`, `Malformed`, `Unsupported`.
pub fn read_header(path: &Path, format: TileFormat) -> Result<TileHeader, TileError> {
    match format {
        TileFormat::Ply => ply::read_header(path),
        TileFormat::Obj => obj::read_header(path),
        TileFormat::Glb => glb::read_header(path),
    }
}

/// Writes a tile again with patches appended: every original byte that isn't a count, a comment or a JSON length comes
/// out as it was, in the same order. The output appears whole or not at all.
///
/// # Errors
/// As `read_tile`; `InputChanged` if the input's hash is not the expected one; `IndexTypeTooSmall`; `BadPatch`.
pub fn append_patches(request: &AppendRequest<'_>) -> Result<Written, TileError> {
    match request.format {
        TileFormat::Ply => ply::append(request),
        TileFormat::Obj => obj::append(request),
        TileFormat::Glb => glb::append(request),
    }
}

/// Writes a tile that holds patches alone, for a cell that has no tile, in the manner of an existing one.
///
/// # Errors
/// As `append_patches`; `BadPatch` if a corner is an original one.
pub fn new_tile(request: &NewTileRequest<'_>) -> Result<Written, TileError> {
    match request.format {
        TileFormat::Ply => ply::new_tile(request),
        TileFormat::Obj => obj::new_tile(request),
        TileFormat::Glb => glb::new_tile(request),
    }
}
