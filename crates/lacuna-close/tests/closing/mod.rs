//! Closes the holes of a tiny scene, and checks what comes out.
#![allow(dead_code)] // each test file uses its own part

use crate::kit::{Planned, Scene};
use glam::{DVec2, DVec3};
use lacuna_close::{CellContour, Curves, LayeredOptions, Source, contour, project};
use lacuna_grid::CellId;
use lacuna_hole::{Anchor, BorderMode, CellSurvey, Hole, Piece, Span};
use lacuna_mesh::{Contour, ContourRing, EdgeKind, find_crossings, position_bits, signed_area};
use std::collections::BTreeMap;

/// Position bits of a directed edge's ends.
pub(crate) type Edge = [[u64; 3]; 2];

/// A scene with all its curves and contours.
pub(crate) struct Closing<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) planned: Planned,
    pub(crate) curves: Curves,
    /// One for each hole of the plan.
    pub(crate) contours: Vec<CellContour>,
}

/// Plans, projects, and builds every contour.
pub(crate) fn close(scene: &Scene, growth: f64) -> Closing<'_> {
    let planned = scene.plan();
    let options = LayeredOptions { growth, spacing_m: None };
    let curves = project(&planned.surveys, &planned.plan, &|_| options);
    let build = |hole: &Hole| {
        contour(&planned.surveys, &planned.plan, hole, &curves, &|p| p)
            .unwrap_or_else(|e| panic!("{e}: {} {}", hole.cell, hole.class))
    };
    let contours = planned.plan.holes.iter().map(build).collect();
    Closing { scene, planned, curves, contours }
}

/// The directed edges of a ring.
pub(crate) fn edges(ring: &ContourRing) -> Vec<(Edge, EdgeKind)> {
    let n = ring.vertices.len();
    let bits = |k: usize| position_bits(ring.vertices[k % n].position);
    (0..n).map(|k| ([bits(k), bits(k + 1)], ring.edges[k].kind)).collect()
}

/// Rings in plan.
pub(crate) fn plan_rings(contour: &Contour) -> Vec<Vec<DVec2>> {
    contour.rings().map(|r| r.vertices.iter().map(|v| v.position.truncate()).collect()).collect()
}

fn edge_of(survey: &CellSurvey, e: u32) -> Edge {
    [survey.from(e), survey.to(e)].map(position_bits)
}

impl Closing<'_> {
    /// Everything that must hold of any exact scene.
    pub(crate) fn check(&self, what: &str) {
        for (hole, made) in self.planned.plan.holes.iter().zip(&self.contours) {
            let what = format!("{what}, {} {}", hole.cell, hole.class);
            check_rings(hole, &made.contour, &what);
            self.check_rims(hole, &made.contour, &what);
            self.check_sources(hole, made, &what);
            check_support(&made.contour, &what);
        }
        self.check_curves(what);
        self.check_watertight(what);
    }

    /// Each rim edge of the plan, and each adopted one, is once in the contour, and no other.
    fn check_rims(&self, hole: &Hole, contour: &Contour, what: &str) {
        let mut expected: Vec<Edge> = Vec::new();
        let own = self.planned.surveys.get(&hole.cell);
        let mut add = |survey: &CellSurvey, list: &[u32]| {
            expected.extend(list.iter().map(|&e| edge_of(survey, e)));
        };
        for piece in &hole.outer {
            match piece {
                Piece::Rim(list) => add(own.expect("a rim has a tile"), list),
                Piece::Side { spans, .. } => {
                    for span in spans {
                        if let Span::Adopted { neighbour, edges } = span {
                            add(&self.planned.surveys[neighbour], edges);
                        }
                    }
                }
                Piece::Bridge => {}
            }
        }
        for &island in &hole.islands {
            let survey = own.expect("an island has a tile");
            add(survey, &survey.loops[island as usize].edges);
        }
        let mut found: Vec<Edge> = contour
            .rings()
            .flat_map(edges)
            .filter(|(_, kind)| *kind == EdgeKind::Rim)
            .map(|(edge, _)| edge)
            .collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected, "{what}: rim edges");
    }

    /// Vertices said to be original are so, bit for bit, and all of the hole's own rim are.
    fn check_sources(&self, hole: &Hole, made: &CellContour, what: &str) {
        let positions = made.contour.positions();
        assert_eq!(positions.len(), made.sources.len(), "{what}");
        let tile = self.scene.tiles.get(&hole.cell);
        for (p, source) in positions.iter().zip(&made.sources) {
            if let Source::Original(v) = source {
                let original = tile.expect("a tile").positions[v.index()];
                assert_eq!(position_bits(*p), position_bits(original), "{what}: {v}");
            }
        }
        let originals = made.sources.iter().filter(|s| matches!(s, Source::Original(_))).count();
        let mut own: Vec<[u64; 3]> = Vec::new();
        for piece in &hole.outer {
            if let Piece::Rim(list) = piece {
                let survey = &self.planned.surveys[&hole.cell];
                own.extend(list.iter().flat_map(|&e| edge_of(survey, e)));
            }
        }
        for &island in &hole.islands {
            let survey = &self.planned.surveys[&hole.cell];
            own.extend(survey.loops[island as usize].edges.iter().map(|&e| edge_of(survey, e)[0]));
        }
        own.sort_unstable();
        own.dedup();
        assert!(originals >= own.len(), "{what}: {originals} of {} rim vertices", own.len());
    }

    /// Curves end on their anchors, ascend, and lie on their line.
    fn check_curves(&self, what: &str) {
        for (k, (curve, made)) in self.planned.plan.curves.iter().zip(&self.curves.curves).enumerate() {
            let side = curve.border.side;
            let along: Vec<f64> = made.inner.iter().map(|p| side.along(p.truncate())).collect();
            assert!(along.windows(2).all(|w| w[0] < w[1]), "{what}, curve {k}: {along:?}");
            assert!(along.iter().all(|a| *a > curve.low_m && *a < curve.high_m), "{what}, curve {k}");
            assert!(made.inner.iter().all(|p| p.is_finite()), "{what}, curve {k}");
            assert!(made.inner.iter().all(|p| side.across(p.truncate()) == curve.line), "{what}, curve {k}");
            for (anchor, at) in [(curve.low, curve.low_m), (curve.high, curve.high_m)] {
                if let Anchor::Point(cell, point) = anchor {
                    let p = self.planned.surveys[&cell].position(point);
                    assert!((side.along(p.truncate()) - at).abs() < 1e-9, "{what}, curve {k}: {anchor:?}");
                    for &h in &curve.holes {
                        let positions = self.contours[h as usize].contour.positions();
                        assert!(positions.contains(&p), "{what}, curve {k}: {anchor:?} not in hole {h}");
                    }
                }
            }
            if let [a, b] = curve.holes[..] {
                self.check_shared(curve.line, side.is_horizontal(), [a, b], &format!("{what}, curve {k}"));
            }
        }
    }

    /// Both holes have the same border edges on their common line, in opposite directions.
    fn check_shared(&self, line: f64, is_horizontal: bool, holes: [u32; 2], what: &str) {
        let on_line = |bits: [u64; 3]| {
            let p = bits.map(f64::from_bits);
            (if is_horizontal { p[1] } else { p[0] }) == line
        };
        let of = |h: u32| -> Vec<Edge> {
            let all = edges(&self.contours[h as usize].contour.outer);
            let border = all.into_iter().filter(|(_, kind)| *kind == EdgeKind::Border);
            border.map(|(edge, _)| edge).filter(|e| e.iter().all(|p| on_line(*p))).collect()
        };
        let (a, b) = (of(holes[0]), of(holes[1]));
        let common = a.iter().filter(|e| b.contains(&[e[1], e[0]])).count();
        assert!(common > 0, "{what}: no common border edge");
    }

    /// Tiles and patches together have every edge as often in one direction as in the other, but on the area's edge and
    /// round what is no hole.
    fn check_watertight(&self, what: &str) {
        let open = self.open_edges();
        assert!(open.is_empty(), "{what}: {} open edges, such as {:?}", open.len(), open.first());
    }

    /// Edges that run more often in one direction than in the other, without those on the area's edge.
    pub(crate) fn open_edges(&self) -> Vec<[DVec3; 2]> {
        let mut balance: BTreeMap<Edge, i64> = BTreeMap::new();
        let mut add = |[a, b]: Edge, by: i64| {
            let (key, sign) = if a < b { ([a, b], by) } else { ([b, a], -by) };
            *balance.entry(key).or_default() += sign;
        };
        for mesh in self.scene.tiles.values() {
            for t in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(t).map(position_bits);
                [[a, b], [b, c], [c, a]].into_iter().for_each(|e| add(e, 1));
            }
        }
        for made in &self.contours {
            made.contour.rings().flat_map(edges).for_each(|(e, _)| add(e, 1));
        }
        for e in self.left_alone() {
            add(e, 1);
        }
        balance
            .into_iter()
            .filter(|(_, n)| *n != 0)
            .map(|(e, _)| e.map(|p| DVec3::from_array(p.map(f64::from_bits))))
            .filter(|[a, b]| !self.is_outside_edge(a.truncate(), b.truncate()))
            .collect()
    }

    /// Edges of loops that no hole names and that run round a small loose piece.
    fn left_alone(&self) -> Vec<Edge> {
        let plan = &self.planned.plan;
        let is_island =
            |cell: CellId, l: u32| plan.holes.iter().any(|h| h.cell == cell && h.islands.contains(&l));
        let mut found = Vec::new();
        for (&cell, survey) in &self.planned.surveys {
            for (k, l) in survey.loops.iter().enumerate() {
                let is_loose = plan.holes.iter().all(|h| {
                    h.cell != cell
                        || h.outer
                            .iter()
                            .all(|p| !matches!(p, Piece::Rim(r) if l.edges.iter().any(|e| r.contains(e))))
                });
                let small = survey.components.get(l.component as usize).is_some_and(|c| c.triangles < 50);
                if is_loose && small && l.vector_area.z < 0.0 && !is_island(cell, k as u32) {
                    let is_inside = |e: u32| {
                        let [low, high] = self.frame(cell);
                        let p = survey.from(e).truncate();
                        p.cmpgt(low).all() && p.cmplt(high).all()
                    };
                    if l.edges.iter().any(|&e| is_inside(e))
                        && l.edges.iter().all(|&e| self.is_rim(cell, survey, e))
                    {
                        found.extend(l.edges.iter().map(|&e| edge_of(survey, e)));
                    }
                }
            }
        }
        found
    }

    fn frame(&self, cell: CellId) -> [DVec2; 2] {
        let domain = &self.planned.plan.domains[&cell];
        [domain.low, domain.high]
    }

    /// True unless both ends of an edge lie on one side of its cell.
    fn is_rim(&self, cell: CellId, survey: &CellSurvey, e: u32) -> bool {
        let domain = &self.planned.plan.domains[&cell];
        !lacuna_grid::Side::ALL.into_iter().any(|s| {
            [survey.from(e), survey.to(e)].iter().all(|p| domain.outside_m(s, p.truncate()).abs() < 1e-9)
        })
    }

    fn is_outside_edge(&self, a: DVec2, b: DVec2) -> bool {
        let fit = &self.planned.plan.fit;
        let slack_m = if fit.mode == BorderMode::Ragged { fit.absorb_m } else { 1e-9 };
        let domains = self.planned.plan.domains.values();
        domains.into_iter().any(|d| {
            d.sides.iter().any(|s| {
                s.label == lacuna_grid::SideLabel::External
                    && [a, b].iter().all(|p| d.outside_m(s.side, *p).abs() < slack_m)
            })
        })
    }
}

/// The outer ring runs counter-clockwise, islands clockwise; nothing crosses; the area is the plan's.
fn check_rings(hole: &Hole, contour: &Contour, what: &str) {
    let rings = plan_rings(contour);
    for (k, ring) in rings.iter().enumerate() {
        let area = signed_area(ring);
        assert!(if k == 0 { area > 0.0 } else { area < 0.0 }, "{what}: ring {k} has area {area}");
        let same = (0..ring.len()).filter(|&i| ring[i] == ring[(i + 1) % ring.len()]).count();
        assert_eq!(same, 0, "{what}: a place twice in a row");
    }
    let slices: Vec<&[DVec2]> = rings.iter().map(Vec::as_slice).collect();
    assert_eq!(find_crossings(&slices), [], "{what}: crossings");
    let area: f64 = rings.iter().map(|r| signed_area(r)).sum();
    assert!((area - hole.area_m2).abs() <= 1e-6 * hole.area_m2, "{what}: {area} and {}", hole.area_m2);
    assert_eq!(rings.len(), 1 + hole.islands.len(), "{what}");
}

/// Indices are in range, triangles face up, forbidden edges are sorted pairs of the contour.
fn check_support(contour: &Contour, what: &str) {
    let mut places = contour.positions();
    let count = places.len() as u32;
    places.extend(&contour.support.vertices);
    for t in &contour.support.triangles {
        let [a, b, c] = t.map(|v| places[v as usize].truncate());
        assert!((b - a).perp_dot(c - a) > 0.0, "{what}: support faces down");
        assert!(t.iter().any(|&v| v < count), "{what}: support away from the rim");
    }
    assert!(contour.forbidden_edges.is_sorted(), "{what}");
    assert!(contour.forbidden_edges.iter().all(|[a, b]| a < b && *b < count), "{what}");
}
