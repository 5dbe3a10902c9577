//! The name of a tile for a cell that has none.

use super::{Scene, TileGroup};
use crate::names::{TileName, format_like};

/// The relative path of the tile that will fill the cell at `index`, in the manner of an existing neighbour: same folder
/// pattern, name pattern, zero padding and extension.
///
/// Every component of the neighbour's path that speaks of the neighbour's cell speaks of `index` instead. A neighbour
/// without an index gets a sibling `<its stem>_hollow_x<column>_y<row>`. The path is never that of a file of the scene:
/// where it is taken, `_lacuna` is added to the stem.
#[must_use]
pub fn hollow_tile_path(scene: &Scene, index: (i32, i32), neighbour: &TileGroup) -> String {
    let relative = neighbour.parts.first().map_or("", |&part| scene.tiles[part].relative.as_str());
    let (path, extension) = match relative.rsplit_once('.') {
        Some((path, extension)) if !extension.contains('/') => (path, extension),
        _ => (relative, ""),
    };
    let mut made = renamed(path, index, neighbour.index)
        .unwrap_or_else(|| format!("{path}_hollow_x{}_y{}", index.0, index.1));
    while is_taken(scene, &format!("{made}.{extension}")) {
        made.push_str("_lacuna");
    }
    format!("{made}.{extension}")
}

/// The path with the neighbour's index replaced in every component; `None` if the file name does not hold it.
fn renamed(path: &str, index: (i32, i32), old: Option<(i32, i32)>) -> Option<String> {
    let old = old?;
    let speaks = |component: &str| TileName::parse(component).filter(|name| name.index == old);
    speaks(path.rsplit('/').next()?)?;
    let components: Vec<String> = path
        .split('/')
        .map(|component| {
            speaks(component).map_or_else(|| component.to_owned(), |name| format_like(&name, index))
        })
        .collect();
    Some(components.join("/"))
}

/// Compared without regard to case: the output may lie on a file system that has none.
fn is_taken(scene: &Scene, relative: &str) -> bool {
    let same = |other: &str| other.to_lowercase() == relative.to_lowercase();
    scene.tiles.iter().any(|tile| same(&tile.relative)) || scene.side_files.iter().any(|file| same(file))
}
