//! Ragged borders: no straight lines, with common vertices or without. The rims of all tiles are taken together and cut
//! along the border lines, so that every open edge belongs to one hole.

use crate::cuts::{CutEnd, border_cuts, new_cut};
use crate::faces::{Cut, Face, Faces, Node, Step, faces};
use crate::fit::BorderMode;
use crate::open_edges::OpenEdges;
use crate::plan::{Anchor, Curve, CurveKind, Hole, Leave, Piece, Span, corner_key};
use crate::rims::{Rims, cell_of, edge_of};
use crate::shared::{CellView, Shared, SidePiece};
use crate::strips::add_strips;
use crate::{BorderFit, HoleClass, HoleShape};
use glam::DVec2;
use lacuna_grid::{CellId, Side};
use lacuna_mesh::{perimeter, position_bits, signed_area};
use std::collections::{BTreeMap, BTreeSet};

/// Outlines beside a hole's own that are smaller than this many squares of a median edge go to the neighbour's hole.
const POCKET_EDGES: f64 = 8.0;

/// Most rounds in which pockets are given to their neighbours.
const MOST_ROUNDS: usize = 16;

/// What the tiles' views and the scene's fit tell.
pub(crate) struct Stitch<'a> {
    pub(crate) views: &'a BTreeMap<CellId, CellView<'a>>,
    pub(crate) pieces: &'a [SidePiece],
    pub(crate) fit: &'a BorderFit,
    /// Boundary edges that another tile's meet, sorted; where tiles share no vertices those that face its border.
    pub(crate) closed: &'a [(CellId, u32)],
    /// True if the tiles share no vertices along their borders.
    pub(crate) is_loose: bool,
}

/// Outlines all holes anew from the open edges of all tiles together, where tiles are ragged.
///
/// Steps: (1) open edges: boundary edges that no other tile's edge meets, or (of tiles that share no vertices) faces;
/// (2) cuts: where the border lines run between them; (3) faces of both, each in one cell; (4) an outline that is small, or
/// has no rim of its cell, goes to the hole beyond its cut, and the cut goes; (5) each hole takes its face: own edges as
/// rim, those of others as adopted, cuts as curves. A hole without a face is left, or goes if others took up its rims.
/// (6) Faces without cuts between two tiles are strips where both fall short. Returns the numbers of the holes that went,
/// descending; `None` where tiles are not ragged.
pub(crate) fn stitch(
    stitch: &Stitch<'_>,
    holes: &mut Vec<Hole>,
    shared: &mut Shared,
    corners: &mut BTreeMap<String, Anchor>,
) -> Option<Vec<usize>> {
    if stitch.fit.mode != BorderMode::Ragged {
        return None;
    }
    let open = OpenEdges::new(holes, stitch.views, stitch.closed, stitch.fit, stitch.is_loose);
    let mut cuts = border_cuts(&open, stitch.pieces, stitch.views, stitch.fit);
    for corner in cuts.iter().flat_map(|c| c.nodes) {
        if let Node::Corner(corner) = corner {
            corners.remove(&corner_key(corner));
        }
    }
    cuts.extend(external_cuts(stitch, holes, &shared.curves, corners));
    let rims = Rims::new(&open, holes, stitch.views);
    let mut walked = faces(&open, &cuts, rims.starts());
    for _ in 0..MOST_ROUNDS {
        let needless = needless_cuts(stitch.fit, &open, &cuts, &walked, &rims);
        if needless.is_empty() {
            break;
        }
        cuts = (0..cuts.len()).filter(|c| !needless.contains(c)).map(|c| cuts[c].clone()).collect();
        walked = faces(&open, &cuts, rims.starts());
    }
    let owners = owners(&open, &cuts, &walked, &rims, holes);
    let taken_up = taken_up(&open, &walked, &owners, holes, stitch.views);
    give_faces(stitch, &open, cuts, &walked, &owners, holes, shared);
    add_strips(stitch, &open, &walked, holes);
    let gone: Vec<usize> = taken_up.into_iter().rev().collect();
    gone.iter().for_each(|&h| remove(h, holes, shared));
    Some(gone)
}

/// Takes a hole out of the plan, and renumbers those behind it.
fn remove(hole: usize, holes: &mut Vec<Hole>, shared: &mut Shared) {
    holes.remove(hole);
    let renumbered = |h: usize| if h > hole { h - 1 } else { h };
    shared.joined.retain(|&(a, b)| a != hole && b != hole);
    shared.joined.iter_mut().for_each(|(a, b)| (*a, *b) = (renumbered(*a), renumbered(*b)));
    for h in shared.curves.iter_mut().flat_map(|c| &mut c.holes) {
        *h = renumbered(*h as usize) as u32;
    }
}

/// Cuts that only part a pocket from its neighbour: all that the pocket shares with the face beyond its longest cut.
fn needless_cuts(
    fit: &BorderFit,
    open: &OpenEdges,
    cuts: &[Cut],
    walked: &Faces,
    rims: &Rims,
) -> BTreeSet<usize> {
    let pocket_m2 = POCKET_EDGES * fit.edge_m * fit.edge_m;
    let has_own =
        |face: &Face| cell_of(open, cuts, rims, face).is_some_and(|cell| rims.has_own(open, cell, face));
    let is_pocket: Vec<bool> =
        walked.list.iter().map(|f| f.area_m2.abs() <= pocket_m2 || !has_own(f)).collect();
    let beyond = |c: usize, way: usize| walked.of.get(&Step::Cut(c, 1 - way)).copied();
    let mut needless = BTreeSet::new();
    // Small ones first; what was given to another face takes none, and what took one is not given away.
    let (mut given, mut takers) = (BTreeSet::new(), BTreeSet::new());
    let mut order: Vec<usize> = (0..walked.list.len()).filter(|&f| is_pocket[f]).collect();
    order.sort_by(|&a, &b| {
        walked.list[a].area_m2.abs().total_cmp(&walked.list[b].area_m2.abs()).then(a.cmp(&b))
    });
    for f in order {
        let own: Vec<(usize, usize)> = walked.list[f]
            .steps
            .iter()
            .filter_map(|s| match s {
                Step::Cut(c, way) if cuts[*c].curve.kind == CurveKind::Shared => Some((*c, *way)),
                _ => None,
            })
            .collect();
        let length = |c: usize| cuts[c].ends[0].distance(cuts[c].ends[1]);
        let Some(&longest) = own.iter().max_by(|a, b| length(a.0).total_cmp(&length(b.0)).then(b.cmp(a)))
        else {
            continue;
        };
        let other = beyond(longest.0, longest.1);
        // Beyond a walk that failed: only what is nothing is given away.
        if other.is_none() && walked.list[f].area_m2.abs() > 1e-3 * pocket_m2 {
            continue;
        }
        let is_bound = other.is_some_and(|o| o == f || given.contains(&o));
        // Round a corner a small outline has other neighbours, too: it stays.
        let is_between = own.iter().any(|o| other.is_some() && beyond(o.0, o.1) != other);
        if is_bound || is_between || takers.contains(&f) {
            continue;
        }
        given.insert(f);
        takers.extend(other);
        let between = |o: &&(usize, usize)| *o == &longest || other.is_some() && beyond(o.0, o.1) == other;
        needless.extend(own.iter().filter(between).map(|o| o.0));
    }
    needless
}

/// Curves along the area's edge as cuts with one side.
fn external_cuts(
    stitch: &Stitch<'_>,
    holes: &[Hole],
    curves: &[Curve],
    corners: &BTreeMap<String, Anchor>,
) -> Vec<Cut> {
    let mut cuts = Vec::new();
    for hole in holes {
        for piece in &hole.outer {
            let Piece::Side { side, spans, .. } = piece else { continue };
            for span in spans {
                let Span::Curve(c) = span else { continue };
                let curve = &curves[*c as usize];
                if curve.kind != CurveKind::External {
                    continue;
                }
                let ends = [(curve.low, curve.low_m), (curve.high, curve.high_m)].map(|(anchor, along_m)| {
                    external_end(stitch, corners, anchor, *side, along_m, curve.line)
                });
                if let [Some(low), Some(high)] = ends {
                    let mut cells = [None; 2];
                    cells[usize::from(!side.runs_upward())] = Some((hole.cell, *side));
                    cuts.push(new_cut(curve.clone(), [low, high], cells, *side, stitch.fit.edge_m));
                }
            }
        }
    }
    cuts
}

fn external_end(
    stitch: &Stitch<'_>,
    corners: &BTreeMap<String, Anchor>,
    anchor: Anchor,
    side: Side,
    along_m: f64,
    line: f64,
) -> Option<CutEnd> {
    let vertex = match anchor {
        Anchor::Corner(corner) => corners.get(&corner_key(corner)).copied(),
        _ => Some(anchor),
    };
    let place: DVec2 = side.point(along_m, line);
    match (anchor, vertex) {
        (_, Some(Anchor::Point(cell, point))) => {
            let position = stitch.views.get(&cell)?.survey.position(point);
            let node = Node::Vertex(position_bits(position));
            Some(CutEnd { anchor: Anchor::Point(cell, point), node, place: position.truncate() })
        }
        (Anchor::Corner(corner), _) => Some(CutEnd { anchor, node: Node::Corner(corner), place }),
        _ => None,
    }
}

/// The hole of each face. Larger faces choose first among the holes whose rims they have; a face that finds none is a new
/// hole.
fn owners(
    open: &OpenEdges,
    cuts: &[Cut],
    walked: &Faces,
    rims: &Rims,
    holes: &mut Vec<Hole>,
) -> BTreeMap<usize, usize> {
    let mut order: Vec<usize> = (0..walked.list.len()).filter(|&f| walked.list[f].area_m2 > 0.0).collect();
    order.sort_by(|&a, &b| walked.list[b].area_m2.total_cmp(&walked.list[a].area_m2).then(a.cmp(&b)));
    let mut owners = BTreeMap::new();
    let mut taken: BTreeSet<usize> = BTreeSet::new();
    for f in order {
        let face = &walked.list[f];
        let Some(cell) = cell_of(open, cuts, rims, face).filter(|&c| rims.has_own(open, c, face)) else {
            continue;
        };
        let known = rims.holes(open, cell, face);
        let free = known.iter().copied().find(|h| !taken.contains(h));
        let hole = free.unwrap_or(holes.len());
        if free.is_none() {
            let is_external = face
                .steps
                .iter()
                .any(|s| matches!(s, Step::Cut(c, _) if cuts[*c].curve.kind == CurveKind::External));
            holes.push(new_hole(cell, face, is_external));
        }
        taken.insert(hole);
        owners.insert(f, hole);
    }
    owners
}

fn outline_of(open: &OpenEdges, cuts: &[Cut], face: &Face) -> Vec<DVec2> {
    let mut outline = Vec::new();
    for step in &face.steps {
        match *step {
            Step::Edge(e) => outline.push(open.list[e].ends[0].truncate()),
            // A long cut soon comes to the line and leaves it late.
            Step::Cut(c, way) => {
                let (ends, toward) = (cuts[c].ends, cuts[c].toward);
                outline.push(ends[way]);
                if toward[way] != ends[1 - way] {
                    outline.extend([toward[way], toward[1 - way]]);
                }
            }
        }
    }
    outline.dedup();
    outline
}

/// A hole that only the open edges of all tiles together show; it gets its outline with its face.
fn new_hole(cell: CellId, face: &Face, is_external: bool) -> Hole {
    let shape = HoleShape::SemiEnclosed;
    let has_cut = face.steps.iter().any(|s| matches!(s, Step::Cut(..)));
    let class = match (is_external, has_cut) {
        (true, _) => HoleClass::External(shape),
        (false, true) => HoleClass::Internal(shape),
        (false, false) => HoleClass::Closed,
    };
    Hole {
        cell,
        class,
        cluster: 0,
        layer: 1,
        outer: Vec::new(),
        islands: Vec::new(),
        passed_under: Vec::new(),
        class_without_islands: Some(class),
        external_share: if is_external { 1.0 } else { 0.0 },
        is_external,
        area_m2: face.area_m2,
        perimeter_m: 0.0,
        rim_vertices: face.steps.iter().filter_map(edge_of).count() as u32,
        outline: Vec::new(),
        upright: false,
        leave: None,
    }
}

/// Holes that are none, or that others took up: every open edge of their rims is in the face of some hole.
fn taken_up(
    open: &OpenEdges,
    walked: &Faces,
    owners: &BTreeMap<usize, usize>,
    holes: &[Hole],
    views: &BTreeMap<CellId, CellView<'_>>,
) -> BTreeSet<usize> {
    let with_face: BTreeSet<usize> = owners.values().copied().collect();
    let in_hole = |e: usize| walked.of.get(&Step::Edge(e)).is_some_and(|f| owners.contains_key(f));
    let is_taken = |h: &usize| {
        let hole = &holes[*h];
        let Some(view) = views.get(&hole.cell) else { return false };
        let mut rim = hole.rim_edges(view.survey).peekable();
        rim.peek().is_some() && rim.filter_map(|e| open.find(hole.cell, e)).all(in_hole)
    };
    (0..holes.len()).filter(|h| !with_face.contains(h)).filter(is_taken).collect()
}

/// Gives every hole the outline of its face, and the plan the cuts as curves.
fn give_faces(
    stitch: &Stitch<'_>,
    open: &OpenEdges,
    cuts: Vec<Cut>,
    walked: &Faces,
    owners: &BTreeMap<usize, usize>,
    holes: &mut [Hole],
    shared: &mut Shared,
) {
    let with_face: BTreeSet<usize> = owners.values().copied().collect();
    for (_, hole) in holes.iter_mut().enumerate().filter(|(h, _)| !with_face.contains(h)) {
        for piece in &mut hole.outer {
            if let Piece::Side { spans, .. } = piece {
                spans.clear();
            }
        }
        hole.leave = hole.leave.max(Some(Leave::UnmatchedBorder));
    }
    shared.joined.retain(|(a, b)| !with_face.contains(a) || !with_face.contains(b));
    for (&f, &h) in owners {
        outline(stitch, open, &cuts, &walked.list[f], &mut holes[h]);
        // Whatever one border alone told of it: now it has an outline.
        holes[h].leave = holes[h].leave.filter(|l| *l != Leave::UnmatchedBorder);
    }
    let owner = |c: usize, way: usize| Some(*owners.get(walked.of.get(&Step::Cut(c, way))?)?);
    shared.curves = Vec::with_capacity(cuts.len());
    for (c, cut) in cuts.into_iter().enumerate() {
        let sides: Vec<usize> = [0, 1].into_iter().filter_map(|way| owner(c, way)).collect();
        if let [a, b] = sides[..] {
            shared.joined.push((a.min(b), a.max(b)));
        } else if cut.curve.kind == CurveKind::Shared {
            // The other hole is left: so is this one.
            sides.iter().for_each(|&h| holes[h].leave = holes[h].leave.max(Some(Leave::UnmatchedBorder)));
        }
        shared.curves.push(Curve { holes: sides.iter().map(|&h| h as u32).collect(), ..cut.curve });
    }
    shared.joined.sort_unstable();
    shared.joined.dedup();
}

/// Writes a face into a hole, from the first step on its own rim.
fn outline(stitch: &Stitch<'_>, open: &OpenEdges, cuts: &[Cut], face: &Face, hole: &mut Hole) {
    let n = face.steps.len();
    let of_cell = |of: (CellId, u32)| (of.0 == hole.cell).then_some(of.1);
    let own = |step: Step| open.list[edge_of(&step)?].of.and_then(of_cell);
    let is_own = |k: usize| own(face.steps[k % n]).is_some();
    let used: BTreeSet<u32> = face.steps.iter().filter_map(|s| own(*s)).collect();
    if let [Piece::Rim(rim)] = &hole.outer[..]
        && rim.len() == n
        && used.len() == n
    {
        return;
    }
    hole.outline = outline_of(open, cuts, face);
    hole.area_m2 = signed_area(&hole.outline);
    hole.perimeter_m = perimeter(&hole.outline);
    if let Some(view) = stitch.views.get(&hole.cell) {
        let loops = &view.survey.loops;
        hole.islands.retain(|&l| !loops[l as usize].edges.iter().any(|e| used.contains(e)));
        for island in hole.islands.iter().map(|&l| &loops[l as usize]) {
            hole.area_m2 -= island.vector_area.z.abs();
            hole.perimeter_m += island.length_m;
        }
    }
    let first = (0..n).find(|&k| is_own(k) && !is_own(k + n - 1)).unwrap_or(0);
    let steps = (0..n).map(|k| face.steps[(first + k) % n]);
    hole.outer = outline_pieces(open, cuts, hole.cell, steps);
    hole.rim_vertices = rim_vertices(stitch, hole);
}

/// Vertices on the rims of a hole; one that two of its rims have counts for each.
fn rim_vertices(stitch: &Stitch<'_>, hole: &Hole) -> u32 {
    let rims = hole.outer.iter().filter(|p| matches!(p, Piece::Rim(_))).count();
    let edges = stitch.views.get(&hole.cell).map_or(0, |v| hole.rim_edges(v.survey).count());
    (edges + if hole.class == HoleClass::Closed { 0 } else { rims }) as u32
}

/// The pieces of a walk as a cell sees them: its own edges, those of others, and curves.
pub(crate) fn outline_pieces(
    open: &OpenEdges,
    cuts: &[Cut],
    cell: CellId,
    steps: impl Iterator<Item = Step>,
) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    for step in steps {
        let (side, span) = match step {
            Step::Edge(e) => match open.list[e].of {
                // A stub runs straight from the vertex before it to the one behind.
                None => continue,
                Some((own, edge)) if own == cell => {
                    match pieces.last_mut() {
                        Some(Piece::Rim(edges)) => edges.push(edge),
                        _ => pieces.push(Piece::Rim(vec![edge])),
                    }
                    continue;
                }
                Some((neighbour, edge)) => {
                    (side_towards(cell, neighbour), Span::Adopted { neighbour, edges: vec![edge] })
                }
            },
            Step::Cut(c, way) => (cuts[c].cells[way].map_or(Side::South, |s| s.1), Span::Curve(c as u32)),
        };
        if let (Some(Piece::Side { spans, .. }), Span::Adopted { neighbour, edges }) =
            (pieces.last_mut(), &span)
            && let Some(Span::Adopted { neighbour: before, edges: taken }) = spans.last_mut()
            && before == neighbour
        {
            taken.extend(edges);
            continue;
        }
        pieces.push(Piece::Side { side, spans: vec![span], corner_after: false });
    }
    pieces
}

/// The side on which another cell lies.
fn side_towards(cell: CellId, other: CellId) -> Side {
    if other.i > cell.i {
        Side::East
    } else if other.i < cell.i {
        Side::West
    } else if other.j > cell.j {
        Side::North
    } else {
        Side::South
    }
}
