//! Tiles in and out: PLY, OBJ and GLB; append-only writing; atomic files.
//!
//! Positions leave this crate as f64, metres, z up, in the frame of the scene's files. Writing never changes a byte that
//! was there but counts, comments and JSON lengths: patches stand after the originals.

mod error;
mod glb;
mod obj;
mod ply;
mod source;
mod tile;
mod types;

pub use error::{Place, TileError};
pub use tile::{append_patches, new_tile, read_header, read_tile};
pub use types::{
    AppendRequest, Corner, HolePatch, NewTileRequest, NumberType, ReadOptions, ReadTile, TileFormat,
    TileHeader, UpAxis, VertexFrame, Written,
};
