//! Makes the plan: holes cell by cell, then what joins them.

use crate::bridge::bridges;
use crate::classify::classify;
use crate::closed::{
    HolePolygon, HolePolygons, LoopKind, highest, hovers, is_debris, judge_loop, loop_polygon,
};
use crate::corner::corner_vertices;
use crate::coverage::{Coverage, coverage};
use crate::cut::mark_cuts;
use crate::group::group;
use crate::label::label_edges;
use crate::loose::{facing_edges, share_borders};
use crate::open_edges::closed_edges;
use crate::outline::{outline, side_stretches};
use crate::place::{AreaOutline, PlaceInArea};
use crate::plan::{Anchor, Hole, Leave, Piece, Plan, PlanOptions};
use crate::shared::{CellView, SidePiece, share};
use crate::stitch::{Stitch, stitch};
use crate::survey::survey_loop;
use crate::walk::{RawPiece, Walked, walk};
use crate::{BorderMode, CellSurvey, HoleClass, NotHole, Surveys};
use lacuna_grid::{AreaLimit, CellId, Domain, Side};
use lacuna_mesh::{PointId, signed_area};
use std::collections::BTreeMap;

/// What is known of one cell while the plan is made.
struct CellWork {
    domain: Domain,
    coverage: Coverage,
    walked: Walked,
}

/// Makes the plan from all surveys of a scene.
///
/// Steps: label, cover and walk every cell of the area (missing cells are hollow); closed loops and islands; classes;
/// borders from both sides; clusters; layers.
#[must_use]
pub fn plan(surveys: &Surveys, options: &PlanOptions) -> Plan {
    let is_hollow = |c: &&CellId| !surveys.contains_key(c) && !options.unreadable.contains(c);
    let hollow: Surveys = options
        .area
        .cells
        .iter()
        .filter(is_hollow)
        .map(|&c| (c, crate::survey(c, &lacuna_mesh::TriMesh::default())))
        .collect();
    let by_cell: BTreeMap<CellId, &CellSurvey> =
        surveys.iter().chain(&hollow).map(|(c, s)| (*c, s)).collect();

    let mut builder = Builder::new(options);
    // Where tiles are cut along a line, that line tells what lies on the border.
    let closed = if options.fit.mode == BorderMode::Ragged { closed_edges(&by_cell) } else { Vec::new() };
    let works: BTreeMap<CellId, CellWork> =
        by_cell.iter().map(|(&c, s)| (c, cell_work(s, options, &closed))).collect();
    for (cell, work) in &works {
        builder.add_cell(by_cell[cell], work);
    }
    let views: BTreeMap<CellId, CellView<'_>> =
        works.iter().map(|(&c, w)| (c, CellView::new(by_cell[&c], &w.domain, &w.coverage))).collect();
    let is_ragged = options.fit.mode == BorderMode::Ragged;
    let is_loose = is_ragged && !share_borders(surveys, &options.grid, &options.area, &options.fit);
    builder.finish(&views, &closed, is_loose)
}

fn cell_work(survey: &CellSurvey, options: &PlanOptions, closed: &[(CellId, u32)]) -> CellWork {
    let fit = &options.fit;
    let domain = fit.domain(&options.grid, &options.area, survey.cell);
    let mut labels = label_edges(survey, &domain, fit, closed);
    let facing = mark_cuts(survey, fit, &mut labels);
    let coverage = coverage(survey, &domain, fit, &labels);
    let bridges = bridges(survey, &coverage, &facing, fit);
    let walked = walk(survey, &coverage, domain.perimeter_m(), fit.gap_m, &bridges);
    CellWork { domain, coverage, walked }
}

/// Collects holes cell by cell, then joins them.
struct Builder<'a> {
    options: &'a PlanOptions,
    /// The area's outline, if it is given by polygons.
    area_outline: Option<AreaOutline<'a>>,
    holes: Vec<Hole>,
    pieces: Vec<SidePiece>,
    /// For each side piece: (hole, index in its outer ring).
    places: Vec<(usize, usize)>,
    not_holes: BTreeMap<NotHole, u32>,
    unclear: u32,
}

impl<'a> Builder<'a> {
    fn new(options: &'a PlanOptions) -> Self {
        let area_outline = match &options.area.limit {
            AreaLimit::Polygon(rings) => Some(AreaOutline::new(rings)),
            _ => None,
        };
        Self {
            options,
            area_outline,
            holes: Vec::new(),
            pieces: Vec::new(),
            places: Vec::new(),
            not_holes: BTreeMap::new(),
            unclear: 0,
        }
    }

    fn count(&mut self, what: NotHole, number: usize) {
        if number > 0 {
            *self.not_holes.entry(what).or_default() += number as u32;
        }
    }

    fn add_cell(&mut self, survey: &CellSurvey, work: &CellWork) {
        self.count(NotHole::Overhang, work.walked.stray_chains);
        self.unclear += work.walked.broken.len() as u32;
        let open = self.real_holes(survey, work);
        let mut polygons: Vec<HolePolygon> = open
            .iter()
            .map(|pieces| HolePolygon::new(outline(survey, &work.domain, &work.coverage, pieces)))
            .collect();
        let (mut closed, mut outlines) = (Vec::new(), Vec::new());
        for &index in &work.coverage.closed {
            let l = &survey.loops[index as usize];
            match judge_loop(l) {
                LoopKind::Hole => {
                    closed.push(index);
                    polygons.push(HolePolygon::new(loop_polygon(survey, l)));
                }
                LoopKind::Outline => outlines.push(index),
                LoopKind::Not(what) => self.count(what, 1),
            }
        }
        let open_rims = open.iter().map(|pieces| highest(survey, chain_edges(&work.coverage, pieces)));
        let closed_rims =
            closed.iter().map(|&l| highest(survey, survey.loops[l as usize].edges.iter().copied()));
        let rims_highest_m: Vec<Option<f64>> = open_rims.chain(closed_rims).collect();
        let polygons = HolePolygons::new(polygons);
        let islands = self.assign_islands(survey, &polygons, &rims_highest_m, &outlines);
        let mut shapes = polygons.list.into_iter().zip(islands);
        for (pieces, (polygon, islands)) in open.into_iter().zip(shapes.by_ref()) {
            self.add_open(survey, work, pieces, polygon, islands);
        }
        for (&index, (polygon, islands)) in closed.iter().zip(shapes) {
            self.add_closed(survey, index, polygon, islands);
        }
    }

    /// The walks that run round missing surface. One without a border piece (its rim is in parts because a cut inside the
    /// tile runs through it) is judged as a closed loop is.
    fn real_holes<'w>(&mut self, survey: &CellSurvey, work: &'w CellWork) -> Vec<&'w [RawPiece]> {
        let mut real: Vec<&[RawPiece]> = Vec::new();
        for pieces in &work.walked.holes {
            let is_open = pieces.iter().any(|p| matches!(p, RawPiece::Border(..)));
            let judged = if is_open {
                let polygon = outline(survey, &work.domain, &work.coverage, pieces);
                if signed_area(&polygon) > 0.0 { LoopKind::Hole } else { LoopKind::Not(NotHole::Overhang) }
            } else {
                let edges: Vec<u32> = chain_edges(&work.coverage, pieces).collect();
                judge_loop(&survey_loop(survey, edges, u32::MAX))
            };
            match judged {
                LoopKind::Hole => real.push(pieces),
                LoopKind::Outline => self.count(NotHole::InnerCut, 1),
                LoopKind::Not(what) => self.count(what, 1),
            }
        }
        real
    }

    /// Outlines of pieces inside a hole are its islands, unless they are debris or hover above its rim.
    fn assign_islands(
        &mut self,
        survey: &CellSurvey,
        polygons: &HolePolygons,
        rims_highest_m: &[Option<f64>],
        outlines: &[u32],
    ) -> Vec<Vec<u32>> {
        let mut islands = vec![Vec::new(); polygons.list.len()];
        for &index in outlines {
            let l = &survey.loops[index as usize];
            let around = polygons.smallest_around(&loop_polygon(survey, l));
            match around {
                Some(k) if !is_debris(survey, l.component) && !hovers(survey, l, rims_highest_m[k]) => {
                    islands[k].push(index);
                }
                _ => self.count(NotHole::Floater, 1),
            }
        }
        islands
    }

    fn add_open(
        &mut self,
        survey: &CellSurvey,
        work: &CellWork,
        raw: &[RawPiece],
        polygon: HolePolygon,
        islands: Vec<u32>,
    ) {
        let fit = &self.options.fit;
        let class_of = |islands| classify(&work.domain, &work.coverage, raw, islands, fit.gap_m);
        let (class, external_share) = class_of(islands.len());
        let hole = self.holes.len();
        let mut outer = Vec::new();
        for (k, piece) in raw.iter().enumerate() {
            match *piece {
                RawPiece::Chain(c) => outer.push(Piece::Rim(work.coverage.chains[c].edges.clone())),
                RawPiece::Bridge => outer.push(Piece::Bridge),
                RawPiece::Border(from, to) => {
                    let ends = [neighbour_chain(raw, k, true), neighbour_chain(raw, k, false)];
                    self.add_side_pieces(survey, work, hole, &mut outer, (from, to), ends);
                }
            }
        }
        let record = Hole {
            cell: survey.cell,
            class,
            cluster: 0,
            layer: 1,
            outer,
            islands,
            passed_under: Vec::new(),
            class_without_islands: Some(class_of(0).0),
            external_share,
            is_external: external_share > 0.0,
            area_m2: polygon.area_m2,
            perimeter_m: 0.0,
            rim_vertices: 0,
            outline: polygon.outline,
            upright: false,
            leave: None,
        };
        self.push_hole(survey, record);
    }

    /// Side pieces of one stretch of the perimeter, cut at the corners.
    fn add_side_pieces(
        &mut self,
        survey: &CellSurvey,
        work: &CellWork,
        hole: usize,
        outer: &mut Vec<Piece>,
        (from, to): (f64, f64),
        [before, after]: [Option<usize>; 2],
    ) {
        let chain_end = |chain: Option<usize>, is_start: bool| {
            let c = &work.coverage.chains[chain?];
            let edge = if is_start { *c.edges.last()? } else { *c.edges.first()? };
            let e = &survey.boundary.edges[edge as usize];
            Some(if is_start { e.to } else { e.from })
        };
        let ends = [chain_end(before, true), chain_end(after, false)];
        let stretches = side_stretches(&work.domain, from, to);
        let count = stretches.len();
        for (k, (side, a, b)) in stretches.into_iter().enumerate() {
            let point = |p: Option<PointId>| p.map(|p| (Anchor::Point(survey.cell, p), survey.position(p)));
            let corner_before = Anchor::Corner(survey.cell.corner_after(previous_side(side)));
            let start = if k == 0 { point(ends[0]) } else { None };
            let end = if k + 1 == count { point(ends[1]) } else { None };
            let start_anchor = start.map_or(corner_before, |s| s.0);
            let end_anchor = end.map_or(Anchor::Corner(survey.cell.corner_after(side)), |e| e.0);
            let [x, y] = [a, b].map(|s| side.along(work.domain.point(side, s)));
            let upward = side.runs_upward();
            self.pieces.push(SidePiece {
                hole,
                cell: survey.cell,
                side,
                low_m: x.min(y),
                high_m: x.max(y),
                low: if upward { start_anchor } else { end_anchor },
                high: if upward { end_anchor } else { start_anchor },
                end_positions: [start, end].into_iter().flatten().map(|p| p.1).collect(),
            });
            self.places.push((hole, outer.len()));
            let corner_after = end.is_none();
            outer.push(Piece::Side { side, spans: Vec::new(), corner_after });
        }
    }

    fn add_closed(&mut self, survey: &CellSurvey, index: u32, polygon: HolePolygon, islands: Vec<u32>) {
        let l = &survey.loops[index as usize];
        let space_area = l.vector_area.length();
        let upright = l.vector_area.z.abs() < 0.15 * space_area;
        let record = Hole {
            cell: survey.cell,
            class: HoleClass::Closed,
            cluster: 0,
            layer: 1,
            outer: vec![Piece::Rim(l.edges.clone())],
            islands,
            passed_under: Vec::new(),
            class_without_islands: Some(HoleClass::Closed),
            external_share: 0.0,
            is_external: false,
            area_m2: if upright { space_area } else { polygon.area_m2 },
            perimeter_m: 0.0,
            rim_vertices: 0,
            outline: polygon.outline,
            upright,
            leave: None,
        };
        self.push_hole(survey, record);
    }

    /// Adds the figures that follow from the pieces, and judges the hole against a polygon area.
    fn push_hole(&mut self, survey: &CellSurvey, mut hole: Hole) {
        match self.area_outline.as_ref().map(|area| area.place(&hole.outline)) {
            None | Some(PlaceInArea::Inside) => {}
            Some(PlaceInArea::Outside) => leave_external(&mut hole, Leave::OutsideArea),
            Some(PlaceInArea::Crosses) => leave_external(&mut hole, Leave::CrossesArea),
        }
        let length =
            |edges: &[u32]| -> f64 { edges.iter().map(|&e| survey.from(e).distance(survey.to(e))).sum() };
        // Places are in the order of holes, so this hole's come last.
        let first_piece = self.places.partition_point(|p| p.0 < self.holes.len());
        hole.perimeter_m = self.pieces[first_piece..].iter().map(|p| p.high_m - p.low_m).sum();
        for piece in &hole.outer {
            if let Piece::Rim(edges) = piece {
                hole.perimeter_m += length(edges);
                hole.rim_vertices += edges.len() as u32 + u32::from(hole.class != HoleClass::Closed);
            }
        }
        for &island in &hole.islands {
            let l = &survey.loops[island as usize];
            hole.perimeter_m += l.length_m;
            hole.rim_vertices += l.edges.len() as u32;
            hole.area_m2 -= l.vector_area.z.abs();
        }
        self.holes.push(hole);
    }

    fn finish(
        mut self,
        views: &BTreeMap<CellId, CellView<'_>>,
        closed: &[(CellId, u32)],
        is_loose: bool,
    ) -> Plan {
        let mut shared = share(&self.pieces, views, &self.options.fit);
        for (k, &(hole, at)) in self.places.iter().enumerate() {
            if let Piece::Side { spans, .. } = &mut self.holes[hole].outer[at] {
                spans.clone_from(&shared.spans[k]);
            }
            let record = &mut self.holes[hole];
            record.leave = record.leave.max(shared.leaves[k]);
        }
        let mut corners = corner_vertices(views, &self.options.fit);
        let facing = if is_loose { facing_edges(views) } else { Vec::new() };
        let closed = if is_loose { &facing } else { closed };
        let all = Stitch { views, pieces: &self.pieces, fit: &self.options.fit, closed, is_loose };
        let stitched = stitch(&all, &mut self.holes, &mut shared, &mut corners);
        let tiles_meet = self.options.fit.mode == BorderMode::Exact || stitched.is_some() && !is_loose;
        for gone in stitched.into_iter().flatten() {
            self.pieces.retain(|p| p.hole != gone);
            self.pieces.iter_mut().filter(|p| p.hole > gone).for_each(|p| p.hole -= 1);
        }
        let rule = self.options.rule;
        let clusters = group(&mut self.holes, &self.pieces, &shared.joined, &shared.curves, rule);
        Plan {
            fit: self.options.fit,
            curves: shared.curves,
            clusters,
            holes: self.holes,
            corners,
            domains: views.iter().map(|(&c, v)| (c, *v.domain)).collect(),
            not_holes: self.not_holes,
            unclear_stretches: self.unclear,
            tiles_meet,
        }
    }
}

/// A hole that the area's outline cuts, or beyond it, counts as external, and stays: where it should end inside the area
/// no tile says.
fn leave_external(hole: &mut Hole, why: Leave) {
    hole.is_external = true;
    hole.leave = Some(why);
    if let HoleClass::Internal(shape) = hole.class {
        hole.class = HoleClass::External(shape);
    }
}

/// Boundary edges of a walk's rim chains, in walking order.
fn chain_edges<'w>(coverage: &'w Coverage, pieces: &'w [RawPiece]) -> impl Iterator<Item = u32> + 'w {
    let chains = pieces.iter().filter_map(|p| match p {
        RawPiece::Chain(c) => Some(&coverage.chains[*c].edges),
        _ => None,
    });
    chains.flatten().copied()
}

/// The chain next to piece `k` of a walk, before or after it.
fn neighbour_chain(raw: &[RawPiece], k: usize, before: bool) -> Option<usize> {
    let n = raw.len();
    let at = if before { (k + n - 1) % n } else { (k + 1) % n };
    match raw[at] {
        RawPiece::Chain(c) => Some(c),
        _ => None,
    }
}

fn previous_side(side: Side) -> Side {
    Side::ALL[(side.index() + 3) % 4]
}
