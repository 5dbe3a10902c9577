//! Promise 2 for tiles that got a patch: what was delivered stands in them byte for byte. Judged on bytes alone, by format,
//! without the code that writes tiles.

mod glb;
mod obj;
mod ply;

use lacuna_tile::TileFormat;

/// The mark of one patch in a tile (formats.md sections 7 to 9).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mark {
    /// Id of the hole as the mark names it.
    pub(super) hole: String,
    /// Triangles under the mark.
    pub(super) triangles: u64,
}

/// What a comparison of two files of one tile finds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Comparison {
    /// What of the original is not as it was.
    pub(super) problems: Vec<String>,
    /// Marks that the original does not have, in the order in which a reader meets their triangles.
    pub(super) marks: Vec<Mark>,
}

/// Compares a written tile with the delivered one; without a delivered one (a new tile) only the marks are read.
pub(super) fn compare(format: TileFormat, original: Option<&[u8]>, now: &[u8]) -> Comparison {
    match format {
        TileFormat::Ply => ply::compare(original, now),
        TileFormat::Obj => obj::compare(original, now),
        TileFormat::Glb => glb::compare(original, now),
    }
}
