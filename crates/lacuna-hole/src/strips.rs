//! Narrow strips along ragged borders where both tiles fall short (algorithms note G): holes of the cell that comes first.

use crate::faces::{Faces, Step, faces};
use crate::open_edges::OpenEdges;
use crate::plan::{Hole, Piece};
use crate::stitch::{Stitch, outline_pieces};
use crate::{BorderFit, HoleClass};
use glam::DVec2;
use lacuna_grid::CellId;
use lacuna_mesh::perimeter;
use std::collections::BTreeSet;

/// Strips are at most so many median edges wide.
const WIDEST_EDGES: f64 = 3.0;

/// Adds a hole for every loop of open edges that no hole has and that is narrow. It takes the edges of the other tile as
/// they are; nothing is moved.
pub(crate) fn add_strips(stitch: &Stitch<'_>, open: &OpenEdges, walked: &Faces, holes: &mut Vec<Hole>) {
    let rest = (0..open.list.len()).filter(|&e| !walked.of.contains_key(&Step::Edge(e)));
    for face in faces(open, &[], rest).list {
        let edges: Vec<usize> = face
            .steps
            .iter()
            .filter_map(|s| match s {
                Step::Edge(e) => Some(*e),
                Step::Cut(..) => None,
            })
            .collect();
        let outline: Vec<DVec2> = edges.iter().map(|&e| open.list[e].ends[0].truncate()).collect();
        let cells: BTreeSet<CellId> = edges.iter().filter_map(|&e| open.list[e].cell()).collect();
        let taken = edges.iter().any(|&e| walked.of.contains_key(&Step::Edge(e)));
        let Some(&cell) = cells.first() else { continue };
        if taken || face.area_m2 <= 0.0 || !is_narrow(&outline, face.area_m2, stitch.fit) {
            continue;
        }
        let n = face.steps.len();
        let is_own = |k: usize| open.list[edges[k % n]].cell() == Some(cell);
        let first = (0..n).find(|&k| is_own(k)).unwrap_or(0);
        let starts_own = |k: usize| is_own(k) && !is_own(k + n - 1);
        let first = (0..n).find(|&k| starts_own(k)).unwrap_or(first);
        let steps = (0..n).map(|k| face.steps[(first + k) % n]);
        let outer = outline_pieces(open, &[], cell, steps);
        let rim = outer.iter().map(|p| if let Piece::Rim(edges) = p { edges.len() } else { 0 });
        holes.push(Hole {
            cell,
            class: HoleClass::Closed,
            cluster: 0,
            layer: 1,
            rim_vertices: rim.sum::<usize>() as u32,
            outer,
            islands: Vec::new(),
            passed_under: Vec::new(),
            class_without_islands: Some(HoleClass::Closed),
            external_share: 0.0,
            is_external: false,
            area_m2: face.area_m2,
            perimeter_m: perimeter(&outline),
            outline,
            upright: false,
            leave: None,
        });
    }
}

/// Half the outline is about the strip's length.
fn is_narrow(outline: &[DVec2], area_m2: f64, fit: &BorderFit) -> bool {
    area_m2 <= WIDEST_EDGES * fit.edge_m * perimeter(outline) / 2.0
}
