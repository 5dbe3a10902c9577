//! The contour of one hole: rim, adopted vertices and closing points in order, and the surface behind them.

use crate::Curves;
use crate::ring::RingBuilder;
use crate::square::{Square, SquarePoint, square_vertex, strip_end};
use crate::strip::{Node, lines};
use glam::DVec3;
use lacuna_grid::{CellId, CornerId, Side};
use lacuna_hole::{Anchor, BorderMode, CellSurvey, CurveKind, Hole, Piece, Plan, Span, Surveys};
use lacuna_mesh::{Contour, ContourRing, Patch, PointId, Support, VertexId, position_bits};
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// Where a contour vertex comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A vertex of the hole's own tile: the patch refers to it.
    Original(VertexId),
    /// A vertex of another tile: the patch brings a copy.
    Adopted(CellId, PointId),
    /// A point of a closing curve: the patch brings it.
    Closing(ClosingPoint),
    /// A corner of the grid inside the hole: the patch brings it.
    Corner(CornerId),
    /// A corner of the square in which tiles that overrun their cell overlap at a corner of the grid: the patch brings it.
    Square(SquarePoint),
}

impl Source {
    /// True if the patch brings the vertex.
    #[must_use]
    pub fn is_new(&self) -> bool {
        !matches!(self, Self::Original(_))
    }
}

/// A point of a closing curve on one of the two lines of its border.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClosingPoint {
    /// Index of the curve.
    pub curve: u32,
    /// Index of the point in the curve.
    pub point: u32,
    /// Which line between the lanes of the strip, from the lower one on, where tiles overrun their cell and share the strip
    /// at this point. Where they share none both cells' lines have one height and count as the lower one.
    pub lane: u32,
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
    /// Where each new vertex of the strip comes from.
    pub strip_sources: Vec<Source>,
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
    let mut builder =
        Builder { surveys, plan, hole, curves, round, strip: Vec::new(), squares: BTreeSet::new() };
    let mut rings = vec![builder.outer()?];
    let own = surveys.get(&hole.cell);
    for &island in &hole.islands {
        let survey = own.ok_or(CloseError::NoSurvey(hole.cell))?;
        let mut ring = RingBuilder::default();
        ring.add_edges(survey, &survey.loops[island as usize].edges, None);
        rings.push(ring.finish()?);
    }
    let sources = rings.iter().flat_map(|r| r.1.iter().copied()).collect();
    let mut rings = rings.into_iter().map(|r| r.0);
    let outer = rings.next().unwrap_or_default();
    let mut contour = Contour { outer, inner: rings.collect(), ..Contour::default() };
    builder.add_support(&mut contour);
    let (strip, strip_sources) = number_strip(&contour, &builder.strip);
    Ok(CellContour { contour, sources, strip, strip_sources })
}

struct Builder<'a> {
    surveys: &'a Surveys,
    plan: &'a Plan,
    hole: &'a Hole,
    curves: &'a Curves,
    round: &'a dyn Fn(DVec3) -> DVec3,
    /// Triangles of the overlap strips, by position.
    strip: Vec<[Placed; 3]>,
    /// Corners whose squares are in it.
    squares: BTreeSet<CornerId>,
}

/// A position and where it comes from.
pub(crate) type Placed = (DVec3, Source);

impl Builder<'_> {
    fn outer(&mut self) -> Result<(ContourRing, Vec<Source>), CloseError> {
        let mut ring = RingBuilder::default();
        for piece in &self.hole.outer {
            match piece {
                Piece::Rim(edges) => {
                    let survey = self.survey(self.hole.cell)?;
                    ring.add_edges(survey, edges, None);
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
        if self.plan.fit.mode == BorderMode::Overlap {
            ring.untangle();
        }
        ring.finish()
    }

    fn survey(&self, cell: CellId) -> Result<&CellSurvey, CloseError> {
        self.surveys.get(&cell).ok_or(CloseError::NoSurvey(cell))
    }

    fn add_span(&mut self, ring: &mut RingBuilder, side: Side, span: &Span) -> Result<(), CloseError> {
        match span {
            Span::Adopted { neighbour, edges } => {
                ring.add_edges(self.survey(*neighbour)?, edges, Some(*neighbour));
            }
            Span::Curve(c) => self.add_curve(ring, side, *c)?,
        }
        Ok(())
    }

    /// The points of a curve in the hole's direction.
    fn add_curve(&mut self, ring: &mut RingBuilder, side: Side, c: u32) -> Result<(), CloseError> {
        if self.plan.curves[c as usize].kind == CurveKind::Shared {
            self.add_shared_curve(ring, side, c)
        } else {
            self.add_lone_curve(ring, side, c)
        }
    }

    /// On the hole's own line, and beside a strip that both cells take alike on the strip's outline.
    fn add_shared_curve(&mut self, ring: &mut RingBuilder, side: Side, c: u32) -> Result<(), CloseError> {
        let (curve, points) = (&self.plan.curves[c as usize], &self.curves.curves[c as usize]);
        let strip = &points.strip;
        let own_is_upper = self.own_line(side, curve.line) > lines(self.plan, curve)[0];
        let mut ends = [curve.low, curve.high].map(|a| (a, self.shared_square(a)));
        let mut nodes = strip.outline(points.inner.len(), own_is_upper, ends.map(|e| e.1.is_some()));
        if !side.runs_upward() {
            nodes.reverse();
            ends.reverse();
        }
        let [(first, from_square), (last, to_square)] = ends;
        if from_square.is_none() {
            self.add_anchor(ring, first)?;
        }
        nodes.into_iter().for_each(|node| ring.add_border(self.node(side, c, node)));
        for k in 0..strip.shared.len() {
            let triangles = strip.triangles(k, side).into_iter();
            let placed: Vec<_> = triangles.map(|t| t.map(|node| self.node(side, c, node))).collect();
            self.strip.extend(placed);
        }
        [from_square, to_square].into_iter().flatten().for_each(|corner| self.add_square(corner));
        if to_square.is_none() { self.add_anchor(ring, last) } else { Ok(()) }
    }

    /// On the hole's own line, up to the squares at its ends.
    fn add_lone_curve(&self, ring: &mut RingBuilder, side: Side, c: u32) -> Result<(), CloseError> {
        let curve = &self.plan.curves[c as usize];
        let count = self.curves.curves[c as usize].inner.len();
        let mut points: Vec<Placed> = (0..count).map(|k| self.node(side, c, (k, 0))).collect();
        let mut anchors = [curve.low, curve.high];
        if !side.runs_upward() {
            points.reverse();
            anchors.reverse();
        }
        let direction = if side.runs_upward() { 1.0 } else { -1.0 };
        let along = |p: DVec3| direction * side.along(p.truncate());
        let [low, high] = anchors.map(|a| self.lone_end(side, a));
        match low {
            Some(end) => ring.add_border(end),
            None => self.add_anchor(ring, anchors[0])?,
        }
        let from = low.map_or(f64::NEG_INFINITY, |e| along(e.0));
        let to = high.map_or(f64::INFINITY, |e| along(e.0));
        let is_between = |p: &Placed| along(p.0) > from && along(p.0) < to;
        points.into_iter().filter(is_between).for_each(|p| ring.add_border(p));
        match high {
            Some(end) => ring.add_border(end),
            None => self.add_anchor(ring, anchors[1])?,
        }
        Ok(())
    }

    /// The line on which the hole's own cell ends; where that is not known that of the curve.
    fn own_line(&self, side: Side, of_curve: f64) -> f64 {
        self.plan.domains.get(&self.hole.cell).map_or(of_curve, |d| d.side(side).line)
    }

    /// A point of a curve on one of the lines of its strip; without a strip on the hole's own line.
    fn node(&self, side: Side, c: u32, (k, lane): Node) -> Placed {
        let (curve, points) = (&self.plan.curves[c as usize], &self.curves.curves[c as usize]);
        let source = closing_source(self.plan, self.curves, c, (k, lane));
        if let Source::Square(point) = source
            && let Some(placed) = self.square_point(point)
        {
            return placed;
        }
        let line = match points.strip.lanes {
            0 => self.own_line(side, curve.line),
            lanes => points.strip.line(lines(self.plan, curve), lane.min(lanes)),
        };
        let p = points.inner[k];
        let known = points.between_m.get(&(k as u32, lane)).copied();
        let z = known.unwrap_or_else(|| p.z + points.slope[k] * (line - curve.line));
        ((self.round)(side.point(side.along(p.truncate()), line).extend(z)), source)
    }

    /// The corner of an anchor whose square is shared.
    fn shared_square(&self, anchor: Anchor) -> Option<CornerId> {
        match anchor {
            Anchor::Corner(corner) => self.curves.squares.contains_key(&corner).then_some(corner),
            _ => None,
        }
    }

    /// Where the hole's own line meets the shared square at an anchor.
    fn lone_end(&self, side: Side, anchor: Anchor) -> Option<Placed> {
        let corner = self.shared_square(anchor)?;
        let point = Square::of(self.plan, corner)?.lone_end(self.hole.cell, side)?;
        self.square_point(point)
    }

    fn square_point(&self, point: SquarePoint) -> Option<Placed> {
        let vertex = square_vertex(self.plan, self.curves, point)?;
        Some(((self.round)(vertex), Source::Square(point)))
    }

    /// The square at a corner, once.
    fn add_square(&mut self, corner: CornerId) {
        let Some(square) = Square::of(self.plan, corner).filter(|_| self.squares.insert(corner)) else {
            return;
        };
        for triangle in square.triangles(self.hole.cell) {
            if let [Some(a), Some(b), Some(c)] = triangle.map(|p| self.square_point(p)) {
                self.strip.push([a, b, c]);
            }
        }
    }

    /// An anchor's vertex, unless it belongs to another tile that shares no vertices with this one.
    fn add_anchor(&self, ring: &mut RingBuilder, anchor: Anchor) -> Result<(), CloseError> {
        match anchor {
            Anchor::Point(cell, point) => {
                if cell == self.hole.cell || self.plan.fit.mode != BorderMode::Overrun {
                    ring.add_border((self.survey(cell)?.position(point), Source::Adopted(cell, point)));
                }
            }
            Anchor::Corner(corner) => ring.add_border(self.corner(corner)?),
            Anchor::Free => {}
        }
        Ok(())
    }

    fn add_corner(&self, ring: &mut RingBuilder, side: Side) -> Result<(), CloseError> {
        let corner = self.hole.cell.corner_after(side);
        if self.curves.squares.contains_key(&corner) {
            // The square that the cells share turns the corner.
            return Ok(());
        }
        // Between two adopted stretches the neighbours' own vertices turn the corner.
        if let Ok(placed) = self.corner(corner) {
            ring.add_border(placed);
        }
        Ok(())
    }

    fn corner(&self, corner: CornerId) -> Result<Placed, CloseError> {
        if let Some(Anchor::Point(cell, point)) = self.plan.corner_vertex(corner) {
            return Ok((self.survey(cell)?.position(point), Source::Adopted(cell, point)));
        }
        let height =
            self.curves.corners.get(&corner).ok_or(CloseError::NoCornerHeight(corner.i, corner.j))?;
        let side = Side::ALL.into_iter().find(|&s| self.hole.cell.corner_after(s) == corner);
        let own = side.and_then(|s| self.plan.domains.get(&self.hole.cell).map(|d| d.corner_after(s)));
        Ok((own.map_or(*height, |p| p.extend(height.z)), Source::Corner(corner)))
    }

    /// The triangles behind the contour's vertices, of all cells that it touches, and pairs of contour vertices that they
    /// already join.
    fn add_support(&self, contour: &mut Contour) {
        let positions = contour.positions();
        let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        for (k, &p) in positions.iter().enumerate() {
            numbers.entry(position_bits(p)).or_insert(k as u32);
        }
        let count = contour.len() as u32;
        let mut support = Support::default();
        let mut forbidden = Vec::new();
        for cell in self.cells_touched() {
            let Some(survey) = self.surveys.get(&cell) else { continue };
            let own = cell == self.hole.cell;
            for triangle in self.triangles_behind(survey) {
                let places = survey.band.triangles[triangle as usize]
                    .map(|v| survey.band.vertices[v as usize].position);
                if !places.iter().any(|&p| numbers.get(&position_bits(p)).is_some_and(|&n| n < count)) {
                    continue;
                }
                let corners = places.map(|place| {
                    *numbers.entry(position_bits(place)).or_insert_with(|| {
                        support.vertices.push(place);
                        count + support.vertices.len() as u32 - 1
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

    /// Band triangles of a cell at the boundary points that the hole's ring uses, ascending.
    fn triangles_behind(&self, survey: &CellSurvey) -> Vec<u32> {
        let boundary = &survey.boundary;
        let mut edges: Vec<u32> = Vec::new();
        for piece in &self.hole.outer {
            match piece {
                Piece::Rim(rim) if survey.cell == self.hole.cell => edges.extend(rim),
                Piece::Side { spans, .. } => edges.extend(spans.iter().flat_map(|s| match s {
                    Span::Adopted { neighbour, edges } if *neighbour == survey.cell => edges.as_slice(),
                    _ => &[],
                })),
                _ => {}
            }
        }
        if survey.cell == self.hole.cell {
            let islands = self.hole.islands.iter();
            edges.extend(islands.flat_map(|&l| &survey.loops[l as usize].edges));
        }
        let points = edges.iter().flat_map(|&e| {
            let edge = &boundary.edges[e as usize];
            [edge.from, edge.to]
        });
        let mut triangles: Vec<u32> = points
            .filter_map(|p| survey.band.find(boundary.points[p.index()].vertex))
            .flat_map(|v| survey.fans.of(v).iter().copied())
            .collect();
        triangles.sort_unstable();
        triangles.dedup();
        triangles
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

/// What a point of a curve is on one of its lines: a corner of the square where the strip ends, else a closing point.
pub(crate) fn closing_source(plan: &Plan, curves: &Curves, c: u32, (k, lane): Node) -> Source {
    let (curve, points) = (&plan.curves[c as usize], &curves.curves[c as usize]);
    let last = points.inner.len().saturating_sub(1);
    let square = |anchor| match anchor {
        Anchor::Corner(corner) => curves.squares.contains_key(&corner).then_some(corner),
        _ => None,
    };
    let ends = [(curve.low, 0, true), (curve.high, last, false)];
    for (corner, at, is_low) in ends.into_iter().filter_map(|(a, at, low)| Some((square(a)?, at, low))) {
        if curve.kind == CurveKind::Shared && k == at {
            return Source::Square(strip_end(corner, curve.border.side, is_low, lane > 0));
        }
    }
    let lane = if points.strip.touches(k) { lane } else { 0 };
    Source::Closing(ClosingPoint { curve: c, point: k as u32, lane })
}

/// Numbers the triangles of the strips: contour vertices by position, all others as new vertices behind them. Also returns
/// where the new ones come from.
fn number_strip(contour: &Contour, triangles: &[[Placed; 3]]) -> (Patch, Vec<Source>) {
    let mut numbers: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    for (k, p) in contour.positions().into_iter().enumerate() {
        numbers.entry(position_bits(p)).or_insert(k as u32);
    }
    let count = contour.len() as u32;
    let (mut strip, mut sources) = (Patch::default(), Vec::new());
    for triangle in triangles {
        let corners = triangle.map(|(p, source)| {
            *numbers.entry(position_bits(p)).or_insert_with(|| {
                strip.vertices.push(p);
                sources.push(source);
                count + strip.vertices.len() as u32 - 1
            })
        });
        strip.triangles.push(corners);
    }
    (strip, sources)
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
