//! The hole of a whole cluster as one triangulation: the parts of all cells, joined along their closing curves, and the
//! original surface round them.

use crate::contour::{CellContour, ClosingPoint, Source};
use crate::height_field::{Datum, Region};
use crate::square::SquarePoint;
use crate::water::RimPoint;
use glam::{DVec2, DVec3};
use lacuna_fill::Triangulation;
use lacuna_grid::{CellId, CornerId};
use lacuna_hole::{CurveKind, Hole, Plan, Surveys};
use lacuna_mesh::{EdgeKind, position_bits, side_of_line};
use std::collections::{BTreeMap, BTreeSet};

/// One cell's part of a cluster's hole.
#[derive(Clone, Copy, Debug)]
pub struct FieldPart<'a> {
    /// The hole.
    pub hole: &'a Hole,
    /// Its contour.
    pub contour: &'a CellContour,
    /// The contour, triangulated in plan.
    pub triangulation: &'a Triangulation,
}

/// A region, and where the vertices of its parts are in it.
#[derive(Clone, Debug, Default)]
pub struct ClusterRegion {
    /// What the field is fitted to.
    pub region: Region,
    /// Place in the region of each part's new vertices.
    pub(crate) new: Vec<Vec<u32>>,
    /// Place of each closing point and grid corner.
    pub(crate) joints: BTreeMap<Joint, u32>,
}

/// A vertex that cells share and no tile has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Joint {
    Closing(ClosingPoint),
    Corner(CornerId),
    Square(SquarePoint),
}

/// Rings of data round the hole, the rim being the first.
const RINGS: u8 = 4;
/// Weight of a rim vertex: rims of photogrammetry curl and fray.
const RIM_WEIGHT: f64 = 0.1;
/// Weight of a vertex beside a wall or a spike: next to nothing.
const DOUBTFUL_WEIGHT: f64 = 1e-4;
/// Triangles steeper than this (z of the unit normal), or with an edge longer than so many rim edges, tell nothing of the
/// ground.
const STEEP: f64 = 0.15;
const SPIKE: f64 = 8.0;

/// Joins the parts of a cluster: closing points of neighbours become one vertex, vertices of tiles at one position too.
/// Pockets stay out, as do triangles of the surroundings that are walls, spikes or turned over.
#[must_use]
pub fn cluster_region(surveys: &Surveys, plan: &Plan, parts: &[FieldPart<'_>]) -> ClusterRegion {
    let mut builder = Builder { surveys, plan, edge_m: rim_edge(parts), ..Builder::empty(surveys, plan) };
    for part in parts {
        builder.add_part(part);
    }
    for (cell, seeds) in std::mem::take(&mut builder.seeds) {
        builder.add_rings(cell, seeds);
    }
    builder.finish(radius(parts))
}

struct Builder<'a> {
    surveys: &'a Surveys,
    plan: &'a Plan,
    edge_m: f64,
    /// Sum of the places given for each vertex, and how many they were: points of two lines that count as one lie
    /// between them.
    places: Vec<(DVec2, u32)>,
    data: Vec<Option<Datum>>,
    triangles: Vec<[u32; 3]>,
    /// Strip triangles that are in already: both cells bring them.
    strips: BTreeSet<[u32; 3]>,
    /// Vertices of tiles by position.
    originals: BTreeMap<[u64; 3], u32>,
    joints: BTreeMap<Joint, u32>,
    new: Vec<Vec<u32>>,
    /// Band vertices on the rims, by cell.
    seeds: BTreeMap<CellId, BTreeSet<u32>>,
}

impl<'a> Builder<'a> {
    fn empty(surveys: &'a Surveys, plan: &'a Plan) -> Self {
        Self {
            surveys,
            plan,
            edge_m: 0.0,
            places: vec![],
            data: vec![],
            triangles: vec![],
            strips: BTreeSet::new(),
            originals: BTreeMap::new(),
            joints: BTreeMap::new(),
            new: vec![],
            seeds: BTreeMap::new(),
        }
    }

    fn add_part(&mut self, part: &FieldPart<'_>) {
        let contour = part.contour;
        let positions = contour.contour.positions();
        let mut ids: Vec<u32> = positions
            .iter()
            .zip(&contour.sources)
            .map(|(&p, &source)| self.contour_vertex(part.hole.cell, p, source))
            .collect();
        let strip = contour.strip.vertices.iter().zip(&contour.strip_sources);
        let in_strip: Vec<u32> =
            strip.map(|(&p, &source)| self.contour_vertex(part.hole.cell, p, source)).collect();
        let new: Vec<u32> = part.triangulation.vertices.iter().map(|&p| self.vertex(p, None)).collect();
        let count = ids.len();
        ids.extend(&new);
        self.triangles.extend(part.triangulation.in_plan().iter().map(|t| t.map(|v| ids[v as usize])));
        ids.truncate(count);
        ids.extend(in_strip);
        // Of two versions of a square the one without points on its edges.
        let is_middle = |v: u32| {
            let in_strip = (v as usize).checked_sub(count).and_then(|k| contour.strip_sources.get(k));
            matches!(in_strip, Some(Source::Square(p)) if p.is_middle())
        };
        for triangle in contour.strip.triangles.iter().filter(|t| !t.iter().any(|&v| is_middle(v))) {
            let corners = triangle.map(|v| ids[v as usize]);
            let mut key = corners;
            key.sort_unstable();
            if self.strips.insert(key) {
                self.triangles.push(corners);
            }
        }
        self.new.push(new);
    }

    fn vertex(&mut self, place: DVec2, datum: Option<Datum>) -> u32 {
        self.places.push((place, 1));
        self.data.push(datum);
        self.places.len() as u32 - 1
    }

    fn contour_vertex(&mut self, own: CellId, p: DVec3, source: Source) -> u32 {
        let surveys = self.surveys;
        match source {
            Source::Original(vertex) => {
                let band = surveys.get(&own).and_then(|s| s.band.find(vertex));
                self.seeds.entry(own).or_default().extend(band);
                self.rim_vertex(p)
            }
            Source::Adopted(cell, point) => {
                let survey = surveys.get(&cell);
                let band = survey.and_then(|s| s.band.find(s.boundary.points[point.index()].vertex));
                self.seeds.entry(cell).or_default().extend(band);
                self.rim_vertex(p)
            }
            Source::Corner(corner) => self.joint(Joint::Corner(corner), p, None),
            Source::Square(point) => self.joint(Joint::Square(point), p, None),
            Source::Closing(point) => {
                // Over a neighbour's surface heights are known.
                let curve = &self.plan.curves[point.curve as usize];
                let is_known = matches!(curve.kind, CurveKind::OverNeighbour(_));
                let datum = is_known.then_some(Datum { height_m: p.z, weight: 1.0, is_exact: true });
                self.joint(Joint::Closing(point), p, datum)
            }
        }
    }

    fn rim_vertex(&mut self, p: DVec3) -> u32 {
        if let Some(&v) = self.originals.get(&position_bits(p)) {
            return v;
        }
        let v = self.vertex(p.truncate(), Some(Datum { height_m: p.z, weight: RIM_WEIGHT, is_exact: true }));
        self.originals.insert(position_bits(p), v);
        v
    }

    fn joint(&mut self, joint: Joint, p: DVec3, datum: Option<Datum>) -> u32 {
        if let Some(&v) = self.joints.get(&joint) {
            let (sum, count) = &mut self.places[v as usize];
            *sum += p.truncate();
            *count += 1;
            return v;
        }
        let v = self.vertex(p.truncate(), datum);
        self.joints.insert(joint, v);
        v
    }

    /// Adds the triangles of a cell within some rings of its rims.
    fn add_rings(&mut self, cell: CellId, seeds: BTreeSet<u32>) {
        let Some(survey) = self.surveys.get(&cell) else { return };
        let (mut found, mut front, mut seen) = (BTreeSet::new(), seeds.clone(), seeds);
        for _ in 1..RINGS {
            let triangles = front.iter().flat_map(|&v| survey.fans.of(v).iter().copied());
            let fresh: Vec<u32> = triangles.filter(|&t| found.insert(t)).collect();
            let corners = fresh.iter().flat_map(|&t| survey.band.triangles[t as usize]);
            front = corners.filter(|&v| seen.insert(v)).collect();
        }
        for t in found {
            let corners =
                survey.band.triangles[t as usize].map(|v| survey.band.vertices[v as usize].position);
            let ids = corners.map(|p| self.ring_vertex(p));
            if is_calm(corners, self.edge_m) {
                self.triangles.push(ids);
            } else {
                for v in ids {
                    if let Some(datum) = &mut self.data[v as usize] {
                        datum.weight = DOUBTFUL_WEIGHT;
                    }
                }
            }
        }
    }

    fn ring_vertex(&mut self, p: DVec3) -> u32 {
        if let Some(&v) = self.originals.get(&position_bits(p)) {
            return v;
        }
        let v = self.vertex(p.truncate(), Some(Datum { height_m: p.z, weight: 1.0, is_exact: false }));
        self.originals.insert(position_bits(p), v);
        v
    }

    /// Drops triangles without area and vertices without triangles.
    fn finish(mut self, radius_m: f64) -> ClusterRegion {
        let places: Vec<DVec2> = self.places.iter().map(|&(sum, count)| sum / f64::from(count)).collect();
        let mut triangles = std::mem::take(&mut self.triangles);
        triangles.retain(|t| {
            let [a, b, c] = t.map(|v| places[v as usize]);
            side_of_line(a, b, c) > 0.0
        });
        let mut number = vec![u32::MAX; places.len()];
        let mut region = Region { edge_m: self.edge_m, radius_m, ..Region::default() };
        for &v in triangles.iter().flatten() {
            number[v as usize] = 0;
        }
        for v in 0..places.len() {
            if number[v] == 0 {
                number[v] = region.places.len() as u32;
                region.places.push(places[v]);
                region.data.push(self.data[v]);
            }
        }
        region.triangles = triangles.iter().map(|t| t.map(|v| number[v as usize])).collect();
        let new = self.new.iter().map(|ids| ids.iter().map(|&v| number[v as usize]).collect()).collect();
        let joints = self.joints.iter().map(|(&joint, &v)| (joint, number[v as usize])).collect();
        ClusterRegion { region, new, joints }
    }
}

/// True if a triangle of the surroundings tells of the ground: neither a wall, nor turned over, nor a spike.
fn is_calm([a, b, c]: [DVec3; 3], edge_m: f64) -> bool {
    let normal = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    normal.z > STEEP * normal.length() && longest <= SPIKE * edge_m
}

/// The middles of all rim edges.
pub(crate) fn rim_points(parts: &[FieldPart<'_>]) -> Vec<RimPoint> {
    rim_edges(parts).map(|[a, b]| RimPoint { position: (a + b) / 2.0, length_m: a.distance(b) }).collect()
}

/// Ends of all rim edges.
fn rim_edges<'a>(parts: &'a [FieldPart<'_>]) -> impl Iterator<Item = [DVec3; 2]> + 'a {
    parts.iter().flat_map(|part| part.contour.contour.rings()).flat_map(|ring| {
        let n = ring.vertices.len();
        let is_rim = move |&k: &usize| ring.edges[k].kind == EdgeKind::Rim;
        (0..n).filter(is_rim).map(move |k| [k, (k + 1) % n].map(|k| ring.vertices[k].position))
    })
}

/// Median length of the rim edges.
fn rim_edge(parts: &[FieldPart<'_>]) -> f64 {
    let mut lengths: Vec<f64> = rim_edges(parts).map(|[a, b]| a.distance(b)).collect();
    if lengths.is_empty() {
        return 1.0;
    }
    let middle = lengths.len() / 2;
    lengths.select_nth_unstable_by(middle, f64::total_cmp).1.max(1e-6)
}

/// Radius of a disk with the hole's ratio of area to rim: half the width of a river, the radius of a round lake.
fn radius(parts: &[FieldPart<'_>]) -> f64 {
    let area: f64 = parts.iter().map(|p| p.hole.area_m2).sum();
    let rim: f64 = rim_edges(parts).map(|[a, b]| a.distance(b)).sum();
    let by_rim = 2.0 * area / rim.max(1e-9);
    by_rim.min((area / std::f64::consts::PI).sqrt()).max(1e-6)
}
