//! The triangles of one cell, its holes, and the vertices that went with them.

use crate::area::{Area, Cell, SIDES, Side, beyond};
use crate::classify::{Piece, classify};
use crate::lattice::Lattice;
use crate::removal::State;

/// Triangles of one tile; coordinates in lattice units.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tile {
    /// Vertices; each is used by a triangle.
    pub vertices: Vec<[i64; 3]>,
    /// Corners, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
}

/// A vertex that no triangle uses any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// Where it stood, lattice units.
    pub position: [i64; 3],
    /// Index into the plan's holes.
    pub hole: u32,
    /// True on the area's outer border.
    pub on_edge: bool,
}

/// Everything about one cell.
#[derive(Clone, Debug)]
pub struct CellScene {
    /// The cell, as planned.
    pub cell: Cell,
    /// Its triangles; none if hollow.
    pub tile: Tile,
    /// Its holes.
    pub pieces: Vec<Piece>,
    /// The vertices its holes took; one on a border is listed by one of its cells only.
    pub lost: Vec<Lost>,
}

/// Gathers a cell from its lattice and states; `height` gives a node's height in lattice units.
#[must_use]
pub fn gather(
    lattice: &Lattice,
    states: &[State],
    area: &Area,
    height: impl Fn([i64; 2]) -> i64,
) -> CellScene {
    let pieces = classify(lattice, states, area);
    let at = |node: usize| {
        let [x, y] = lattice.nodes[node];
        [x, y, height([x, y])]
    };
    let lost = if pieces.is_empty() {
        Vec::new()
    } else {
        lost_nodes(lattice, states, area)
            .into_iter()
            .map(|(node, hole, on_edge)| Lost { position: at(node), hole, on_edge })
            .collect()
    };
    CellScene { cell: lattice.cell(), tile: tile_of(lattice, states, at), pieces, lost }
}

fn tile_of(lattice: &Lattice, states: &[State], at: impl Fn(usize) -> [i64; 3]) -> Tile {
    const UNUSED: u32 = u32::MAX;
    const USED: u32 = 0;
    let inner_and_kept = |t: &usize| states[*t] == State::Kept && lattice.is_inner(t / 2);
    let corners: Vec<[usize; 3]> =
        (0..states.len()).filter(inner_and_kept).map(|t| lattice.corners(t)).collect();
    let mut number = vec![UNUSED; lattice.nodes.len()];
    corners.iter().flatten().for_each(|&node| number[node] = USED);
    let mut vertices = Vec::new();
    for node in 0..number.len() {
        if number[node] == USED {
            number[node] = vertices.len() as u32;
            vertices.push(at(node));
        }
    }
    Tile { vertices, triangles: corners.iter().map(|c| c.map(|node| number[node])).collect() }
}

/// Nodes of the cell without kept triangles: index, hole, whether on the area's edge.
fn lost_nodes(lattice: &Lattice, states: &[State], area: &Area) -> Vec<(usize, u32, bool)> {
    let (first, last) = (lattice.halo(), lattice.halo() + lattice.quads());
    let mut lost = Vec::new();
    for b in first..=last {
        for a in first..=last {
            let fan = lattice.fan(a, b);
            let mut states = fan.iter().flatten().flatten().map(|&t| states[t]);
            if states.clone().any(|s| s == State::Kept) || !is_listed_here(lattice, area, &fan) {
                continue;
            }
            if let Some(hole) = states.find_map(State::hole) {
                lost.push((lattice.node_index(a, b), hole, is_on_edge(lattice, area, a, b)));
            }
        }
    }
    lost
}

/// True if this cell lists the node: the first cell round it, from the north-east on, that is in the area.
fn is_listed_here(lattice: &Lattice, area: &Area, fan: &[[Option<usize>; 2]; 4]) -> bool {
    let quads = fan.iter().filter_map(|quadrant| quadrant[0]);
    let first = quads.map(|t| lattice.cell_of(t / 2)).find(|&cell| area.contains(cell));
    lattice.is_own() || first == Some(lattice.cell())
}

fn is_on_edge(lattice: &Lattice, area: &Area, a: usize, b: usize) -> bool {
    let (first, last) = (lattice.halo(), lattice.halo() + lattice.quads());
    let touches = |side: Side| match side {
        Side::South => b == first,
        Side::East => a == last,
        Side::North => b == last,
        Side::West => a == first,
    };
    SIDES.iter().any(|&side| touches(side) && !area.contains(beyond(lattice.cell(), side)))
}
