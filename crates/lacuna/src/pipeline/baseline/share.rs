//! A merged patch as patches of cells: every triangle goes, uncut, to the cell that holds its centroid.

use super::AggregateInput;
use super::failure;
use super::merge::Merged;
use crate::config::MethodName;
use crate::pipeline::solve::{FilledHole, NotFilled};
use glam::{DVec2, DVec3};
use lacuna_close::{CellContour, Source};
use lacuna_fill::{Filled, Filler};
use lacuna_grid::CellId;
use lacuna_hole::Hole;
use lacuna_mesh::{Location, Patch, QualityStats, VertexId, contains, position_bits};
use std::collections::BTreeMap;

/// Patches of a cluster's holes in the making.
pub(super) struct Shared<'a> {
    input: &'a AggregateInput<'a>,
    holes: Vec<u32>,
    /// Vertices on the boundary of each cell's tile, by position.
    own_vertices: BTreeMap<CellId, BTreeMap<[u64; 3], VertexId>>,
    patches: BTreeMap<u32, Growing>,
    filler: Option<Filler>,
}

/// The patch of one hole in the making.
#[derive(Default)]
struct Growing {
    rim: Vec<DVec3>,
    sources: Vec<Source>,
    vertices: Vec<DVec3>,
    /// Corners.
    triangles: Vec<[Place; 3]>,
}

/// A corner of a triangle: on the rim or new.
#[derive(Clone, Copy)]
enum Place {
    Rim(u32),
    New(u32),
}

impl<'a> Shared<'a> {
    /// Nothing yet, for the holes of one cluster.
    pub(super) fn new(input: &'a AggregateInput<'a>, holes: &[u32]) -> Self {
        let mut own_vertices: BTreeMap<CellId, BTreeMap<[u64; 3], VertexId>> = BTreeMap::new();
        for &h in holes {
            let cell = input.plan.holes[h as usize].cell;
            let survey = input.scanned.surveys.get(&cell);
            let points = survey.into_iter().flat_map(|s| &s.boundary.points);
            own_vertices
                .entry(cell)
                .or_insert_with(|| points.map(|p| (position_bits(p.position), p.vertex)).collect());
        }
        let patches = holes.iter().map(|&h| (h, Growing::default())).collect();
        Self { input, holes: holes.to_vec(), own_vertices, patches, filler: None }
    }

    /// The hole that takes a triangle with this centroid: one in its cell, of several the one round it; else the one
    /// whose cell is nearest. Ties: the lowest number.
    fn hole_at(&self, centroid: DVec2) -> Option<u32> {
        let grid = &self.input.scanned.grid.grid;
        let hole = |h: u32| -> &Hole { &self.input.plan.holes[h as usize] };
        let away = |h: u32| {
            let (low, high) = grid.rectangle(hole(h).cell);
            let outside_m = centroid.distance(centroid.clamp(low, high));
            let is_round = contains(&hole(h).outline, centroid) != Location::Outside;
            (outside_m, !is_round)
        };
        let order = |a: &u32, b: &u32| {
            let (x, y) = (away(*a), away(*b));
            x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(a.cmp(b))
        };
        self.holes.iter().copied().min_by(order)
    }

    /// The finished patches.
    pub(super) fn finish(self) -> Result<BTreeMap<u32, FilledHole>, String> {
        let filler = self.filler.ok_or("the merged hole has no triangle")?;
        Ok(self.patches.into_iter().map(|(h, growing)| (h, growing.finish(filler))).collect())
    }
}

/// Adds a merged patch.
pub(super) fn share(
    shared: &mut Shared<'_>,
    merged: &Merged,
    contour: &CellContour,
    filled: &Filled,
) -> Result<(), NotFilled> {
    shared.filler = Some(filled.filler);
    let mut positions = contour.contour.positions();
    let rim = positions.len();
    positions.extend(&filled.patch.vertices);
    // Numbers in each hole's patch, by the numbers of the merged one.
    let mut numbers: BTreeMap<(u32, u32), Place> = BTreeMap::new();
    for triangle in &filled.patch.triangles {
        let corners = triangle.map(|v| positions[v as usize]);
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let Some(hole) = shared.hole_at(centroid.truncate()) else { continue };
        let mut places = [Place::New(0); 3];
        for (place, &v) in places.iter_mut().zip(triangle) {
            let position = positions[v as usize];
            *place = match numbers.get(&(hole, v)) {
                Some(known) => *known,
                None if (v as usize) < rim => {
                    shared.add_rim(merged, hole, position, contour.sources[v as usize])?
                }
                None => shared.patch(hole).add_new(position),
            };
            numbers.insert((hole, v), *place);
        }
        shared.patch(hole).triangles.push(places);
    }
    Ok(())
}

impl Shared<'_> {
    fn patch(&mut self, hole: u32) -> &mut Growing {
        self.patches.entry(hole).or_default()
    }

    /// A rim vertex: the hole's own tile's if that has one there, else a copy of another tile's.
    fn add_rim(
        &mut self,
        merged: &Merged,
        hole: u32,
        position: DVec3,
        source: Source,
    ) -> Result<Place, NotFilled> {
        let cell = self.input.plan.holes[hole as usize].cell;
        let own = self.own_vertices.get(&cell).and_then(|o| o.get(&position_bits(position)));
        let source = match (own, source) {
            (Some(&vertex), _) => Source::Original(vertex),
            (None, Source::Original(vertex)) => {
                let (home, vertex) = merged.home(vertex)?;
                let point = self.input.scanned.surveys.get(&home).and_then(|s| s.boundary.point_of(vertex));
                let point = point
                    .ok_or_else(|| failure("a merged rim vertex is on no tile's boundary".to_owned()))?;
                Source::Adopted(home, point)
            }
            (None, other) => other,
        };
        let growing = self.patch(hole);
        growing.rim.push(position);
        growing.sources.push(source);
        Ok(Place::Rim(growing.rim.len() as u32 - 1))
    }
}

impl Growing {
    fn add_new(&mut self, position: DVec3) -> Place {
        self.vertices.push(position);
        Place::New(self.vertices.len() as u32 - 1)
    }

    fn finish(self, filler: Filler) -> FilledHole {
        let rim = self.rim.len() as u32;
        let number = |place: Place| match place {
            Place::Rim(v) => v,
            Place::New(v) => rim + v,
        };
        let at = |place: Place| match place {
            Place::Rim(v) => self.rim[v as usize],
            Place::New(v) => self.vertices[v as usize],
        };
        let quality = QualityStats::of(self.triangles.iter().map(|t| t.map(at)));
        let triangles = self.triangles.iter().map(|t| t.map(number)).collect();
        FilledHole {
            rim: self.rim,
            sources: self.sources,
            // Its triangles run over the borders: no cell has an outline of its own.
            ring_lengths: Vec::new(),
            patch: Patch { vertices: self.vertices, triangles },
            filler,
            quality,
            method: MethodName::Aggregate,
            instead_of_field: None,
        }
    }
}
