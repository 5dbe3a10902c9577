//! A ring of a contour in the making.

use crate::contour::{CloseError, Placed, Source};
use crate::untangle::untangle;
use glam::{DVec2, DVec3};
use lacuna_grid::CellId;
use lacuna_hole::CellSurvey;
use lacuna_mesh::{ContourEdge, ContourRing, ContourVertex, EdgeKind};

/// A ring in the making: vertices, and the kind of the edge that leaves each.
#[derive(Default)]
pub(crate) struct RingBuilder {
    vertices: Vec<ContourVertex>,
    sources: Vec<Source>,
    /// The edge from the vertex of the same index to the next one; a border edge until a rim edge is added.
    edges: Vec<ContourEdge>,
}

const BORDER_EDGE: ContourEdge = ContourEdge { kind: EdgeKind::Border, apex: None };

impl RingBuilder {
    /// Boundary edges of a cell in a row, ends included; of the hole's own cell or of a neighbour.
    pub(crate) fn add_edges(&mut self, survey: &CellSurvey, edges: &[u32], neighbour: Option<CellId>) {
        for &e in edges {
            let edge = &survey.boundary.edges[e as usize];
            for (point, is_start) in [(edge.from, true), (edge.to, false)] {
                let source = match neighbour {
                    None => Source::Original(survey.boundary.points[point.index()].vertex),
                    Some(cell) => Source::Adopted(cell, point),
                };
                self.push(survey.position(point), survey.spacing_m[point.index()], source);
                if is_start && let Some(last) = self.edges.last_mut() {
                    *last = ContourEdge { kind: EdgeKind::Rim, apex: Some(edge.apex) };
                }
            }
        }
    }

    /// A vertex on the border; its spacing is that of its edges.
    pub(crate) fn add_border(&mut self, (position, source): Placed) {
        self.push(position, 0.0, source);
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

    /// Takes out vertices of others where the ring crosses itself.
    pub(crate) fn untangle(&mut self) {
        let places: Vec<DVec2> = self.vertices.iter().map(|v| v.position.truncate()).collect();
        let left = untangle(&places, |v| self.sources[v].is_new());
        if left.len() == places.len() {
            return;
        }
        let n = places.len();
        let follows = |k: usize| left[(k + 1) % left.len()] == (left[k] + 1) % n;
        self.edges =
            (0..left.len()).map(|k| if follows(k) { self.edges[left[k]] } else { BORDER_EDGE }).collect();
        self.vertices = left.iter().map(|&v| self.vertices[v]).collect();
        self.sources = left.iter().map(|&v| self.sources[v]).collect();
    }

    pub(crate) fn finish(mut self) -> Result<(ContourRing, Vec<Source>), CloseError> {
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
