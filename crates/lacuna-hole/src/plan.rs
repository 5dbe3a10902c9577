//! The plan as data: every hole of the scene with its class, cluster, layer, and what closes it on the borders.

use crate::cluster::ClusterRule;
use crate::fit::BorderFit;
use crate::{CellSurvey, HoleClass, NotHole};
use glam::DVec2;
use lacuna_grid::{Area, BorderId, CellId, CornerId, Domain, Grid, Side};
use lacuna_mesh::PointId;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Why a hole is left as it is by the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Leave {
    /// Neither cell has surface over a stretch of their border, but no rim of the neighbour matches.
    UnmatchedBorder,
    /// A neighbouring tile could not be read.
    BadNeighbour,
    /// The hole crosses the outline of a polygon area: where it should end is not known to the tiles.
    CrossesArea,
    /// The hole lies outside the area's polygon.
    OutsideArea,
    /// No hole of the cluster has any surface on its rim: its height is unknown.
    NoSurface,
}

impl fmt::Display for Leave {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::UnmatchedBorder => "no rim of the neighbouring tile matches the hole on their border",
            Self::BadNeighbour => "a neighbouring tile could not be read",
            Self::CrossesArea => "the hole crosses the outline of the area's polygon",
            Self::OutsideArea => "the hole lies outside the area's polygon",
            Self::NoSurface => "no tile of the cluster has surface to take heights from",
        })
    }
}

/// What stands at the end of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Anchor {
    /// A boundary vertex of a cell.
    Point(CellId, PointId),
    /// A corner of the grid without a vertex.
    Corner(CornerId),
    /// Nothing: the curve is not tied to a vertex.
    Free,
}

/// What a closing curve runs over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveKind {
    /// Both cells are open.
    Shared,
    /// Nothing lies beyond: the edge of the reconstruction area.
    External,
    /// The neighbour has surface there, but shares no vertices (tiles that overrun their cell).
    OverNeighbour(CellId),
}

/// A stretch of a border that a closing polyline must cross. Both cells of a shared stretch name the same curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// The grid edge.
    pub border: BorderId,
    /// What lies beyond.
    pub kind: CurveKind,
    /// Constant coordinate of the line, metres (that of the first hole's domain; with overrun each cell has its own).
    pub line: f64,
    /// Lower end, coordinate along the border, metres.
    pub low_m: f64,
    /// Upper end.
    pub high_m: f64,
    /// What stands at the lower end.
    pub low: Anchor,
    /// What stands at the upper end.
    pub high: Anchor,
    /// The holes that it closes, by index: one, or two of a shared stretch.
    pub holes: Vec<u32>,
    /// The neighbour's boundary edges under an `OverNeighbour` curve.
    pub over: Vec<u32>,
}

/// A part of a border piece, in the hole's walking direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Span {
    /// The neighbour's boundary edges, by index into its survey's boundary, in order.
    Adopted {
        /// Whose edges they are.
        neighbour: CellId,
        /// Consecutive boundary edges; may be empty where the tiles' surfaces meet in a point.
        edges: Vec<u32>,
    },
    /// A closing curve, by index.
    Curve(u32),
}

/// A piece of a hole's outer ring, counter-clockwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Piece {
    /// Boundary edges of the hole's own cell.
    Rim(Vec<u32>),
    /// A stretch of one side of the domain.
    Side {
        /// Which side.
        side: Side,
        /// What closes it, in walking order.
        spans: Vec<Span>,
        /// True if the next piece continues round the grid corner at the end of this side.
        corner_after: bool,
    },
    /// A straight edge over a cut inside the tile; of no length where the rim touches the border in a vertex.
    Bridge,
}

/// One hole of one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hole {
    /// Its cell.
    pub cell: CellId,
    /// Class and shape.
    pub class: HoleClass,
    /// Index of its cluster.
    pub cluster: u32,
    /// Distance from the cluster's outside; 1 for closed holes.
    pub layer: u32,
    /// Outer ring.
    pub outer: Vec<Piece>,
    /// Loops (by index into the survey's loops) of the islands inside.
    pub islands: Vec<u32>,
    /// Loops of islands that the patch passes beneath: no part of the hole's outline. Found after planning, and not part of
    /// the plan that is written.
    #[serde(skip)]
    pub passed_under: Vec<u32>,
    /// Class of the hole without its islands, while the run lasts.
    #[serde(skip)]
    pub class_without_islands: Option<HoleClass>,
    /// Share of its border that lies on the area's edge.
    pub external_share: f64,
    /// True if it reaches the area's edge, or the area's polygon leaves it out.
    pub is_external: bool,
    /// Plan area without islands, square metres (of a hole in a wall: its area in space).
    pub area_m2: f64,
    /// Length of rim and border, metres.
    pub perimeter_m: f64,
    /// Number of original vertices on its rims.
    pub rim_vertices: u32,
    /// Outer ring in plan.
    pub outline: Vec<DVec2>,
    /// True if the hole stands in a wall: it has no side in plan.
    pub upright: bool,
    /// Why the plan leaves it, if so.
    pub leave: Option<Leave>,
}

impl Hole {
    /// Boundary edges of its own cell round the hole: of its rims in walking order, then of its islands.
    pub fn rim_edges<'a>(&'a self, survey: &'a CellSurvey) -> impl Iterator<Item = u32> + 'a {
        let rims = self.outer.iter().filter_map(|piece| match piece {
            Piece::Rim(edges) => Some(edges),
            _ => None,
        });
        let islands = self.islands.iter().map(|&l| &survey.loops[l as usize].edges);
        rims.chain(islands).flatten().copied()
    }

    /// Takes islands out of the hole: the patch passes beneath them. Class, area, perimeter and rim change with them.
    pub fn pass_under(&mut self, survey: &CellSurvey, islands: &[u32]) {
        let is_passed = |l: &u32| islands.contains(l);
        for island in self.islands.iter().filter(|l| is_passed(l)).map(|&l| &survey.loops[l as usize]) {
            self.area_m2 += island.vector_area.z.abs();
            self.perimeter_m -= island.length_m;
            self.rim_vertices -= island.edges.len() as u32;
        }
        self.passed_under.extend(self.islands.iter().copied().filter(is_passed));
        self.islands.retain(|l| !is_passed(l));
        if self.islands.is_empty()
            && let Some(class) = self.class_without_islands
        {
            self.class = class;
        }
    }
}

/// A lake as a person sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HoleCluster {
    /// Its holes, ascending.
    pub holes: Vec<u32>,
    /// A point inside its largest hole.
    pub centre: DVec2,
    /// Plan area, square metres.
    pub area_m2: f64,
    /// Highest layer.
    pub layers: u32,
    /// True if any of its holes is external.
    pub is_external: bool,
    /// Why the plan leaves it, if so.
    pub leave: Option<Leave>,
}

/// Holes, clusters and curves of a scene. Small, and printable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// How tiles meet their borders.
    pub fit: BorderFit,
    /// All holes, by cell, open ones first.
    pub holes: Vec<Hole>,
    /// All clusters, by their first hole.
    pub clusters: Vec<HoleCluster>,
    /// Closing curves.
    pub curves: Vec<Curve>,
    /// Grid corners inside holes that some cell has a vertex at.
    pub corners: BTreeMap<String, Anchor>,
    /// Domain of every cell of the area.
    #[serde(skip)]
    pub domains: BTreeMap<CellId, Domain>,
    /// What only looked like a hole, by kind.
    pub not_holes: BTreeMap<NotHole, u32>,
    /// Uncovered stretches of borders without rims to tell what they are.
    pub unclear_stretches: u32,
    /// True unless tiles are ragged or overlap and share no vertices along their borders: then what was delivered is open
    /// there, and patches end between two tiles in stubs.
    #[serde(skip)]
    pub tiles_meet: bool,
}

impl Plan {
    /// The vertex at a grid corner, if a cell has one.
    #[must_use]
    pub fn corner_vertex(&self, corner: CornerId) -> Option<Anchor> {
        self.corners.get(&corner_key(corner)).copied()
    }
}

pub(crate) fn corner_key(corner: CornerId) -> String {
    format!("{},{}", corner.i, corner.j)
}

/// What the plan needs to know beside the surveys.
#[derive(Clone, Debug)]
pub struct PlanOptions {
    /// The grid.
    pub grid: Grid,
    /// The reconstruction area.
    pub area: Area,
    /// How tiles meet their borders.
    pub fit: BorderFit,
    /// When holes of neighbouring cells belong together.
    pub rule: ClusterRule,
    /// Cells whose tile could not be read.
    pub unreadable: BTreeSet<CellId>,
}
