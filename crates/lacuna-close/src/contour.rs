//! The contour of one hole: rim, adopted vertices and closing points in order, and the surface behind them.

use crate::Curves;
use crate::strip::{square_lines, square_triangles, step_triangles};
use glam::DVec3;
use lacuna_grid::{CellId, CornerId, Side};
use lacuna_hole::{Anchor, BorderMode, CellSurvey, Hole, Piece, Plan, Span, Surveys};
use lacuna_mesh::{
    Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind, Patch, Support, VertexId, position_bits,
};
use std::collections::BTreeMap;
use thiserror::Error;

/// Where a contour vertex comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A vertex of the hole's own tile: the patch refers to it.
    Original(VertexId),
    /// A neighbour's vertex or a closing point: the patch brings a copy.
    New,
}

/// A contour and the source of each of its vertices, in the contour's numbering.
#[derive(Clone, Debug, Default)]
pub struct CellContour {
    /// What the filler sees.
    pub contour: Contour,
    /// Where each contour vertex comes from.
    pub sources: Vec<Source>,
    /// Surface beside the contour that the cells of an overlap share, to be added to the patch as it is: new vertices, and
    /// triangles numbered as in a patch.
    pub strip: Patch,
}

/// Why a hole has no contour.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CloseError {
    /// Fewer than three vertices.
    #[error("the hole's outline has fewer than three vertices")]
    TooFewVertices,
    /// A corner of the grid lies in the hole and nothing says how high it is.
    #[error("no height is known for the grid corner {0},{1} inside the hole")]
    NoCornerHeight(i32, i32),
    /// A cell of the plan has no survey.
    #[error("no survey of {0}")]
    NoSurvey(CellId),
}

/// Builds the contour of a hole from the surveys, the plan and the closing curves.
///
/// Positions of original vertices are exact copies; `round` gives closing points the positions that the hole's tile stores.
/// Vertices that follow each other at one place are one.
///
/// # Errors
/// Too few vertices, or a corner without height.
pub fn contour(
    surveys: &Surveys,
    plan: &Plan,
    hole: &Hole,
    curves: &Curves,
    round: &dyn Fn(DVec3) -> DVec3,
) -> Result<CellContour, CloseError> {
    let mut builder = Builder { surveys, plan, hole, curves, round, strip: Vec::new() };
    let mut rings = vec![builder.outer()?];
    let own = surveys.get(&hole.cell);
    for &island in &hole.islands {
        let survey = own.ok_or(CloseError::NoSurvey(hole.cell))?;
        let mut ring = RingBuilder::default();
        ring.add_edges(survey, &survey.loops[island as usize].edges, true);
        rings.push(ring.finish()?);
    }
    let sources = rings.iter().flat_map(|r| r.1.iter().copied()).collect();
    let mut rings = rings.into_iter().map(|r| r.0);
    let outer = rings.next().unwrap_or_default();
    let mut contour = Contour { outer, inner: rings.collect(), ..Contour::default() };
    builder.add_support(&mut contour);
    let strip = number_strip(&contour, &builder.strip);
    Ok(CellContour { contour, sources, strip })
}

struct Builder<'a> {
    surveys: &'a Surveys,
    plan: &'a Plan,
    hole: &'a Hole,
    curves: &'a Curves,
    round: &'a dyn Fn(DVec3) -> DVec3,
    /// Triangles of the overlap strips, by position.
    strip: Vec<[DVec3; 3]>,
}

impl Builder<'_> {
    fn outer(&mut self) -> Result<(ContourRing, Vec<Source>), CloseError> {
        let mut ring = RingBuilder::default();
        for piece in &self.hole.outer {
            match piece {
                Piece::Rim(edges) => {
                    let survey = self.survey(self.hole.cell)?;
                    ring.add_edges(survey, edges, true);
                }
                Piece::Bridge => {}
                Piece::Side { side, spans, corner_after } => {
                    for span in spans {
                        self.add_span(&mut ring, *side, span)?;
                    }
                    if *corner_after {
                        self.add_corner(&mut ring, *side)?;
                    }
                }
            }
        }
        ring.finish()
    }

    fn survey(&self, cell: CellId) -> Result<&CellSurvey, CloseError> {
        self.surveys.get(&cell).ok_or(CloseError::NoSurvey(cell))
    }

    fn add_span(&mut self, ring: &mut RingBuilder, side: Side, span: &Span) -> Result<(), CloseError> {
        match span {
            Span::Adopted { neighbour, edges } => {
                ring.add_edges(self.survey(*neighbour)?, edges, false);
            }
            Span::Curve(c) => self.add_curve(ring, side, *c)?,
        }
        Ok(())
    }

    /// The points of a curve in the hole's direction: on the hole's own line, and along a strip that both cells take alike on
    /// the neighbour's.
    fn add_curve(&mut self, ring: &mut RingBuilder, side: Side, c: u32) -> Result<(), CloseError> {
        let walk = self.curve_walk(side, c);
        let spacing_m = walk.spacing_m;
        let [first, last] = walk.anchors;
        let [from_square, to_square] = walk.anchors.map(|a| walk.is_strip_end(a, self.curves));
        let count = walk.columns.len();
        let is_free = |k: usize| walk.free.get(k).copied().unwrap_or(false);
        let from_square = from_square && is_free(0);
        let to_square = to_square && count > 1 && is_free(count - 2);
        if !from_square {
            self.add_anchor(ring, first, spacing_m)?;
        }
        for (k, &[own, other]) in walk.columns.iter().enumerate() {
            let before = if k == 0 { from_square } else { is_free(k - 1) };
            let after = if k + 1 == count { to_square } else { is_free(k) };
            match (before, after) {
                (false, false) => ring.add_border(own, spacing_m),
                (true, true) => ring.add_border(other, spacing_m),
                (false, true) => [own, other].iter().for_each(|&p| ring.add_border(p, spacing_m)),
                (true, false) => [other, own].iter().for_each(|&p| ring.add_border(p, spacing_m)),
            }
            if k + 1 < count && is_free(k) {
                self.strip.extend(walk.step(side, k));
            }
        }
        if to_square {
            self.add_square(last);
            return Ok(());
        }
        self.add_anchor(ring, last, spacing_m)
    }

    /// A curve as the hole walks it.
    fn curve_walk(&self, side: Side, c: u32) -> CurveWalk {
        let curve = &self.plan.curves[c as usize];
        let points = &self.curves.curves[c as usize];
        let own_line = self.plan.domains.get(&self.hole.cell).map_or(curve.line, |d| d.side(side).line);
        let beyond = self.plan.domains.get(&self.hole.cell.neighbour(side));
        let other_line = beyond.map_or(own_line, |d| d.side(side.opposite()).line);
        let place = |k: usize, line: f64| {
            let p = points.inner[k];
            let z = p.z + points.slope[k] * (line - curve.line);
            (self.round)(side.point(side.along(p.truncate()), line).extend(z))
        };
        let mut columns: Vec<[DVec3; 2]> =
            (0..points.inner.len()).map(|k| [own_line, other_line].map(|line| place(k, line))).collect();
        let mut free = points.free_steps.clone();
        let mut anchors = [curve.low, curve.high];
        if !side.runs_upward() {
            columns.reverse();
            free.reverse();
            anchors.reverse();
        }
        CurveWalk { columns, free, anchors, spacing_m: points.spacing_m }
    }

    /// The square at a corner that four cells share.
    fn add_square(&mut self, anchor: Anchor) {
        let Anchor::Corner(corner) = anchor else { return };
        if let (Some(lines), Some(height)) =
            (square_lines(self.plan, corner), self.curves.corners.get(&corner))
        {
            let triangles = square_triangles(lines, height.z);
            self.strip.extend(triangles.map(|t| t.map(|p| (self.round)(p))));
        }
    }

    /// An anchor's vertex, unless it belongs to another tile that shares no vertices with this one.
    fn add_anchor(&self, ring: &mut RingBuilder, anchor: Anchor, spacing_m: f64) -> Result<(), CloseError> {
        match anchor {
            Anchor::Point(cell, point) => {
                if cell == self.hole.cell || self.plan.fit.mode != BorderMode::Overrun {
                    ring.add_border(self.survey(cell)?.position(point), spacing_m);
                }
            }
            Anchor::Corner(corner) => {
                let place = self.corner_position(corner)?;
                ring.add_border(place, spacing_m);
            }
            Anchor::Free => {}
        }
        Ok(())
    }

    fn add_corner(&self, ring: &mut RingBuilder, side: Side) -> Result<(), CloseError> {
        let corner = self.hole.cell.corner_after(side);
        if self.curves.free_corners.contains(&corner) {
            // The square that four cells share turns the corner.
            return Ok(());
        }
        // Between two adopted stretches the neighbours' own vertices turn the corner.
        if let Ok(place) = self.corner_position(corner) {
            ring.add_border(place, self.plan.fit.edge_m);
        }
        Ok(())
    }

    fn corner_position(&self, corner: CornerId) -> Result<DVec3, CloseError> {
        if let Some(Anchor::Point(cell, point)) = self.plan.corner_vertex(corner) {
            return Ok(self.survey(cell)?.position(point));
        }
        let height =
            self.curves.corners.get(&corner).ok_or(CloseError::NoCornerHeight(corner.i, corner.j))?;
        let side = Side::ALL.into_iter().find(|&s| self.hole.cell.corner_after(s) == corner);
        let own = side.and_then(|s| self.plan.domains.get(&self.hole.cell).map(|d| d.corner_after(s)));
        Ok(own.map_or(*height, |p| p.extend(height.z)))
    }

    /// Ring triangles of all cells that the contour touches, and pairs of contour vertices that they already join.
    fn add_support(&self, contour: &mut Contour) {
        let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        for (k, p) in contour.positions().into_iter().enumerate() {
            numbers.entry(position_bits(p)).or_insert(k as u32);
        }
        let count = contour.len() as u32;
        let mut support = Support::default();
        let mut forbidden = Vec::new();
        for cell in self.cells_touched() {
            let Some(survey) = self.surveys.get(&cell) else { continue };
            let own = cell == self.hole.cell;
            let mut number_of: BTreeMap<u32, u32> = BTreeMap::new();
            for (k, v) in survey.band.vertices.iter().enumerate() {
                if v.ring == 0
                    && let Some(&n) = numbers.get(&position_bits(v.position))
                {
                    number_of.insert(k as u32, n);
                }
            }
            for triangle in &survey.band.triangles {
                if !triangle.iter().any(|v| number_of.get(v).is_some_and(|&n| n < count)) {
                    continue;
                }
                let corners = triangle.map(|v| {
                    *number_of.entry(v).or_insert_with(|| {
                        let place = survey.band.vertices[v as usize].position;
                        *numbers.entry(position_bits(place)).or_insert_with(|| {
                            support.vertices.push(place);
                            support.ring.push(1);
                            count + support.vertices.len() as u32 - 1
                        })
                    })
                });
                support.triangles.push(corners);
                if own {
                    let pairs = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| [corners[a], corners[b]]);
                    forbidden.extend(pairs.into_iter().filter(|p| p.iter().all(|&n| n < count)));
                }
            }
        }
        contour.support = support;
        contour.forbidden_edges = without_contour_edges(contour, forbidden);
    }

    fn cells_touched(&self) -> Vec<CellId> {
        let mut cells = vec![self.hole.cell];
        for piece in &self.hole.outer {
            let Piece::Side { spans, .. } = piece else { continue };
            for span in spans {
                if let Span::Adopted { neighbour, .. } = span {
                    cells.push(*neighbour);
                }
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// A curve in the direction of a hole's walk.
struct CurveWalk {
    /// Each point on the hole's own line and on the neighbour's.
    columns: Vec<[DVec3; 2]>,
    /// For each step between points, true if both cells take the strip between the lines.
    free: Vec<bool>,
    /// What stands at the ends.
    anchors: [Anchor; 2],
    spacing_m: f64,
}

impl CurveWalk {
    /// True if the strip goes on in a corner's square.
    fn is_strip_end(&self, anchor: Anchor, curves: &Curves) -> bool {
        matches!(anchor, Anchor::Corner(corner) if curves.free_corners.contains(&corner))
    }

    /// The two triangles of a step, the same in both cells whichever way they walk.
    fn step(&self, side: Side, k: usize) -> [[DVec3; 3]; 2] {
        let mut ends = [self.columns[k], self.columns[k + 1]];
        if side.along(ends[0][0].truncate()) > side.along(ends[1][0].truncate()) {
            ends.reverse();
        }
        let lower = usize::from(side.across(ends[0][0].truncate()) > side.across(ends[0][1].truncate()));
        let line = |which: usize| [ends[0][which], ends[1][which]];
        step_triangles(side, line(lower), line(1 - lower))
    }
}

/// Numbers the triangles of the strips: contour vertices by position, all others as new vertices behind them.
fn number_strip(contour: &Contour, triangles: &[[DVec3; 3]]) -> Patch {
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    for (k, p) in contour.positions().into_iter().enumerate() {
        numbers.entry(position_bits(p)).or_insert(k as u32);
    }
    let count = contour.len() as u32;
    let mut strip = Patch::default();
    for triangle in triangles {
        let corners = triangle.map(|p| {
            *numbers.entry(position_bits(p)).or_insert_with(|| {
                strip.vertices.push(p);
                count + strip.vertices.len() as u32 - 1
            })
        });
        strip.triangles.push(corners);
    }
    strip
}

/// Sorted pairs (smaller first) that are no edges of the contour itself.
fn without_contour_edges(contour: &Contour, pairs: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut own = Vec::new();
    let mut first = 0u32;
    for ring in contour.rings() {
        let n = ring.vertices.len() as u32;
        own.extend((0..n).map(|k| {
            let (a, b) = (first + k, first + (k + 1) % n);
            [a.min(b), a.max(b)]
        }));
        first += n;
    }
    own.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = pairs.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs.retain(|p| own.binary_search(p).is_err());
    pairs
}

/// A ring in the making: vertices, and the kind of the edge that leaves each.
#[derive(Default)]
struct RingBuilder {
    vertices: Vec<ContourVertex>,
    sources: Vec<Source>,
    /// The edge from the vertex of the same index to the next one; a border edge until a rim edge is added.
    edges: Vec<ContourEdge>,
}

const BORDER_EDGE: ContourEdge = ContourEdge { kind: EdgeKind::Border, apex: None };

impl RingBuilder {
    /// Boundary edges of a cell in a row, ends included.
    fn add_edges(&mut self, survey: &CellSurvey, edges: &[u32], own: bool) {
        for &e in edges {
            let edge = &survey.boundary.edges[e as usize];
            for (point, is_start) in [(edge.from, true), (edge.to, false)] {
                let source = if own {
                    Source::Original(survey.boundary.points[point.index()].vertex)
                } else {
                    Source::New
                };
                self.push(survey.position(point), survey.spacing_m[point.index()], source);
                if is_start && let Some(last) = self.edges.last_mut() {
                    *last = ContourEdge { kind: EdgeKind::Rim, apex: Some(edge.apex) };
                }
            }
        }
    }

    fn add_border(&mut self, position: DVec3, spacing_m: f64) {
        self.push(position, spacing_m, Source::New);
    }

    fn push(&mut self, position: DVec3, spacing_m: f64, source: Source) {
        if let (Some(last), Some(known)) = (self.vertices.last(), self.sources.last_mut())
            && last.position == position
        {
            if matches!(source, Source::Original(_)) {
                *known = source;
            }
            return;
        }
        self.vertices.push(ContourVertex { position, spacing_m });
        self.sources.push(source);
        self.edges.push(BORDER_EDGE);
    }

    fn finish(mut self) -> Result<(ContourRing, Vec<Source>), CloseError> {
        if self.vertices.len() > 1
            && self.vertices.first().map(|v| v.position) == self.vertices.last().map(|v| v.position)
        {
            // The last vertex is the first one again: its edge, if any, leaves the first.
            self.vertices.pop();
            self.edges.pop();
            if let (Some(Source::Original(v)), Some(first)) = (self.sources.pop(), self.sources.first_mut()) {
                *first = Source::Original(v);
            }
        }
        if self.vertices.len() < 3 {
            return Err(CloseError::TooFewVertices);
        }
        Ok((ContourRing { vertices: self.vertices, edges: self.edges }, self.sources))
    }
}
