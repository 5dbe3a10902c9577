//! What several tests look at.

use scene::maker::{MakeOptions, Maker};
use scene::tile::Tile;
use std::collections::BTreeMap;

/// A place, lattice units.
pub(crate) type Place = [i64; 3];

/// A maker, or the reason why not as a panic (tests only).
pub(crate) fn maker(options: MakeOptions) -> Maker {
    Maker::new(options).unwrap()
}

/// All tiles of a scene that have triangles, as they go into files.
pub(crate) fn tiles(maker: &Maker) -> Vec<Tile> {
    let cells = maker.plan().area.cells();
    cells.map(|c| maker.finished_tile(&maker.cell(c).unwrap())).filter(|t| !t.triangles.is_empty()).collect()
}

/// Triangles as places.
pub(crate) fn triangles(tile: &Tile) -> impl Iterator<Item = [Place; 3]> + '_ {
    tile.triangles.iter().map(|t| t.map(|v| tile.vertices[v as usize]))
}

/// Checks that directed edges are unique, triangles face up, and no boundary vertex is passed twice.
pub(crate) fn check_surface(surface: impl Iterator<Item = [Place; 3]>, what: &str) {
    let mut edges: BTreeMap<(Place, Place), u32> = BTreeMap::new();
    for [a, b, c] in surface {
        let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(cross > 0, "{what}: a triangle does not face up");
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    assert!(edges.values().all(|&n| n == 1), "{what}: an edge has two triangles on one side");
    let mut leaving: BTreeMap<Place, u32> = BTreeMap::new();
    for &(a, b) in edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))) {
        assert_ne!(a, b);
        *leaving.entry(a).or_default() += 1;
    }
    let pinched = leaving.iter().find(|(_, n)| **n > 1);
    assert!(pinched.is_none(), "{what}: pinched at {pinched:?}");
}
