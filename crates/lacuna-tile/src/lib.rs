//! Tiles in and out: PLY, OBJ and GLB; append-only writing; atomic files.
//!
//! Positions leave this crate as f64, metres, z up, in the frame of the scene's files. Writing never changes a byte that
//! was there but counts, comments and JSON lengths: patches stand after the originals.

mod atomic;
mod error;
mod fault;
mod glb;
mod mesh;
mod metadata;
mod names;
mod obj;
mod patches;
mod ply;
mod polygon;
mod scene;
mod source;
mod tile;
mod types;

pub use atomic::{
    AtomicFile, Committed, Copied, CopyMode, Hashing, TEMPORARY_PREFIX, TEMPORARY_SUFFIX, copy_file,
    is_temporary, sync_directory,
};
pub use error::{Place, TileError};
pub use metadata::{MetadataError, MetadataKind, MetadataSearch, SceneMetadata, find_metadata};
pub use names::{TileName, format_like};
pub use scene::{
    Scene, SceneError, SceneOptions, TileEntry, TileGroup, hollow_tile_path, open_scene, output_path,
};
pub use tile::{append_patches, new_tile, read_header, read_tile};
pub use types::{
    AppendRequest, Corner, HolePatch, NewTileRequest, NumberType, ReadOptions, ReadTile, TileFormat,
    TileHeader, UpAxis, VertexFrame, Written,
};
