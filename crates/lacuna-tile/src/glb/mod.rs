//! Binary glTF 2.0.

use crate::error::{Place, TileError};
use crate::types::{AppendRequest, NewTileRequest, ReadOptions, ReadTile, TileHeader, Written};
use std::path::Path;

pub(crate) fn read(path: &Path, _options: &ReadOptions) -> Result<ReadTile, TileError> {
    Err(unsupported(path))
}

pub(crate) fn read_header(path: &Path) -> Result<TileHeader, TileError> {
    Err(unsupported(path))
}

pub(crate) fn append(request: &AppendRequest<'_>) -> Result<Written, TileError> {
    Err(unsupported(request.input))
}

pub(crate) fn new_tile(request: &NewTileRequest<'_>) -> Result<Written, TileError> {
    Err(unsupported(request.template))
}

fn unsupported(path: &Path) -> TileError {
    TileError::unsupported(path, Place::File, "GLB", "convert the tile to OBJ or PLY")
}
