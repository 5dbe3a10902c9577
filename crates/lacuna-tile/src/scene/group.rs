//! Which files are one cell's tile.

use super::error::SceneError;
use super::{TileEntry, TileGroup, folder_of, stem_of, without_extension};
use crate::names::TileName;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What files of one group have in common.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum GroupKey {
    /// A cell of a signed name, wherever its files lie.
    Cell((i32, i32)),
    /// Parts of an unsigned name: folder, prefix, pair, level.
    Parts(String, String, (i32, i32), Option<u32>),
    /// A file on its own: folder and stem.
    Single(String, String),
}

/// Groups the tiles by cell and gives every tile its group's name.
///
/// # Errors
/// Two files that cannot be parts of one tile but claim the same cell, or the same folder and stem.
pub(super) fn group_tiles(
    root: &Path,
    tiles: &mut [TileEntry],
    warnings: &mut Vec<String>,
) -> Result<Vec<TileGroup>, SceneError> {
    let mut by_key: BTreeMap<GroupKey, Vec<usize>> = BTreeMap::new();
    for (at, tile) in tiles.iter().enumerate() {
        by_key.entry(key_of(tile)).or_default().push(at);
    }
    let mut groups = Vec::with_capacity(by_key.len());
    for parts in by_key.into_values() {
        check_parts(root, tiles, &parts)?;
        groups.push(group_of(tiles, parts));
    }
    groups.sort_by_key(|group| group.parts[0]);
    drop_doubtful_indices(&mut groups, warnings);
    make_names_unique(tiles, &mut groups);
    for group in &groups {
        for &part in &group.parts {
            tiles[part].name.clone_from(&group.name);
        }
    }
    Ok(groups)
}

fn key_of(tile: &TileEntry) -> GroupKey {
    let folder = folder_of(&tile.relative).to_owned();
    match &tile.parsed {
        Some(name) if name.signed => GroupKey::Cell(name.index),
        Some(name) if name.node().is_some() => {
            GroupKey::Parts(folder, name.prefix.clone(), name.index, name.level())
        }
        _ => GroupKey::Single(folder, stem_of(&tile.relative).to_owned()),
    }
}

fn group_of(tiles: &[TileEntry], parts: Vec<usize>) -> TileGroup {
    let first = &tiles[parts[0]];
    let parsed = first.parsed.as_ref();
    TileGroup {
        name: parsed.map_or_else(|| first.name.clone(), TileName::cell_name),
        index: parsed.map(|name| name.index),
        index_is_signed: parsed.is_some_and(|name| name.signed),
        parts,
    }
}

/// Every file of a group must be a part like the first one, with a place of its own in the level-of-detail tree.
fn check_parts(root: &Path, tiles: &[TileEntry], parts: &[usize]) -> Result<(), SceneError> {
    let first = &tiles[parts[0]];
    let mut nodes = BTreeSet::from([node_of(first)]);
    let mut others = parts[1..].iter().map(|&part| &tiles[part]);
    match others.find(|other| !(are_alike(first, other) && nodes.insert(node_of(other)))) {
        None => Ok(()),
        Some(second) => Err(SceneError::TwoFilesForOneCell {
            first: root.join(&first.relative),
            second: root.join(&second.relative),
            cell: first.parsed.as_ref().map_or_else(
                || format!("\"{}\"", stem_of(&first.relative).escape_debug()),
                |name| format!("cell {:+},{:+}", name.index.0, name.index.1),
            ),
        }),
    }
}

fn node_of(tile: &TileEntry) -> Option<&str> {
    tile.parsed.as_ref()?.node()
}

/// Both are parts of a level-of-detail tree in the same folder, of the same format, prefix and level.
fn are_alike(a: &TileEntry, b: &TileEntry) -> bool {
    let (Some(x), Some(y)) = (&a.parsed, &b.parsed) else { return false };
    x.node().is_some()
        && y.node().is_some()
        && a.format == b.format
        && folder_of(&a.relative) == folder_of(&b.relative)
        && (&x.prefix, x.level()) == (&y.prefix, y.level())
}

/// Unsigned pairs may be dates or counters: if one stands for two tiles, none of them is a cell.
fn drop_doubtful_indices(groups: &mut [TileGroup], warnings: &mut Vec<String>) {
    let mut seen = BTreeSet::new();
    let repeated =
        groups.iter().filter_map(|g| g.index.map(|i| (i, g))).find(|(index, _)| !seen.insert(*index));
    let Some((index, group)) = repeated else { return };
    warnings.push(format!(
        "{}: another tile has the pair {},{} too, so unsigned numbers in names are not taken for cells",
        group.name.escape_debug(),
        index.0,
        index.1
    ));
    for group in groups.iter_mut().filter(|group| !group.index_is_signed) {
        group.index = None;
    }
}

/// Groups whose names repeat are called by their path.
fn make_names_unique(tiles: &[TileEntry], groups: &mut [TileGroup]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for group in groups.iter() {
        *counts.entry(group.name.clone()).or_default() += 1;
    }
    for group in groups.iter_mut().filter(|group| counts[&group.name] > 1) {
        group.name = without_extension(&tiles[group.parts[0]].relative).to_owned();
    }
}
