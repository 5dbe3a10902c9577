//! Damages done to what a run wrote, each of which breaks a certain promise.

pub(crate) mod ply_tile;
pub(crate) mod records;
pub(crate) mod surface;

pub(crate) use ply_tile::PlyTile;
pub(crate) use records::{edit_json, relist};
