//! Bytes of one tile in each format.

mod glb;
mod obj;
mod ply;

use crate::lattice::UNITS_PER_M;
use crate::tile::Tile;
use serde::{Deserialize, Serialize};

/// A tile format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Binary PLY, little endian, f32.
    Ply,
    /// Binary PLY, little endian, f64.
    PlyDouble,
    /// ASCII PLY.
    PlyAscii,
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF: y up, the cell's corner as node translation.
    Glb,
}

/// Where a tile's coordinates start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// The cell's south-west corner, lattice units.
    pub corner: [i64; 2],
    /// Added to x and y, metres.
    pub shift_m: [f64; 2],
}

impl Format {
    /// File extension.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Ply | Self::PlyDouble | Self::PlyAscii => "ply",
            Self::Obj => "obj",
            Self::Glb => "glb",
        }
    }

    /// True if coordinates far from 0 keep their millimetres.
    #[must_use]
    pub fn holds_large_coordinates(self) -> bool {
        matches!(self, Self::PlyDouble | Self::Obj)
    }

    /// True if all coordinates are f32 counted from the scene's origin.
    #[must_use]
    pub fn is_single_precision(self) -> bool {
        matches!(self, Self::Ply | Self::PlyAscii)
    }

    /// The tile's file.
    #[must_use]
    pub fn encode(self, tile: &Tile, origin: &Origin) -> Vec<u8> {
        match self {
            Self::Ply => ply::single(tile),
            Self::PlyDouble => ply::double(tile, origin),
            Self::PlyAscii => ply::ascii(tile),
            Self::Obj => obj::text(tile, origin),
            Self::Glb => glb::binary(tile, origin),
        }
    }
}

/// Metres in f64, shifted.
fn metres(position: [i64; 3], shift_m: [f64; 2]) -> [f64; 3] {
    let [x, y, z] = position.map(|k| k as f64 / UNITS_PER_M);
    [x + shift_m[0], y + shift_m[1], z]
}
