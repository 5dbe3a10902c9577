//! What is kept of a cell after the scan: its boundary, the loops on it, and the triangles behind.

use glam::DVec3;
use lacuna_grid::CellId;
use lacuna_mesh::{
    Band, Boundary, Bounds, Component, Fans, PointId, TriMesh, band, boundary, components, loops,
};
use std::collections::BTreeMap;

/// One closed loop of the boundary, walking with the missing surface on the left.
#[derive(Clone, Debug)]
pub struct LoopSurvey {
    /// Indices into the boundary's edges, in walking order.
    pub edges: Vec<u32>,
    /// The component of the mesh that it bounds (that of its first edge's triangle).
    pub component: u32,
    /// Vector area, square metres: z > 0 for a hole in level ground, z < 0 for the outline of a piece of ground.
    pub vector_area: DVec3,
    /// Length, metres.
    pub length_m: f64,
    /// Mean over the length of (unit normal of the triangle behind) . (unit vector area), in [-1, 1]: near 1 for a hole
    /// in a sheet, near -1 for a sheet's outline, near 0 for the mouth of a tube.
    pub sheetness: f64,
}

/// Everything of one cell that later stages need. Its mesh can be dropped.
#[derive(Clone, Debug)]
pub struct CellSurvey {
    /// The cell.
    pub cell: CellId,
    /// Box of all finite vertices.
    pub bounds: Bounds,
    /// Number of vertices in the tile.
    pub vertices: u64,
    /// Number of triangles in the tile.
    pub triangles: u64,
    /// Points and directed edges with one triangle.
    pub boundary: Boundary,
    /// The edges as loops.
    pub loops: Vec<LoopSurvey>,
    /// Mean length of the boundary edges at each boundary point, metres.
    pub spacing_m: Vec<f64>,
    /// Components of the mesh.
    pub components: Vec<Component>,
    /// The triangles round the boundary: three rings, along the sides of the cell one.
    pub band: Band,
    /// The band's triangles at each of its vertices.
    pub fans: Fans,
    /// Median length of the boundary edges, metres; 0 without boundary.
    pub median_edge_m: f64,
}

/// The surveys of a scene.
pub type Surveys = BTreeMap<CellId, CellSurvey>;

impl CellSurvey {
    /// Position of a boundary point.
    #[must_use]
    pub fn position(&self, point: PointId) -> DVec3 {
        self.boundary.points[point.index()].position
    }

    /// Start of a boundary edge.
    #[must_use]
    pub fn from(&self, edge: u32) -> DVec3 {
        self.position(self.boundary.edges[edge as usize].from)
    }

    /// End of a boundary edge.
    #[must_use]
    pub fn to(&self, edge: u32) -> DVec3 {
        self.position(self.boundary.edges[edge as usize].to)
    }

    /// Unit normal of the triangle behind a boundary edge; zero for a triangle without area.
    #[must_use]
    pub fn normal_behind(&self, edge: u32) -> DVec3 {
        let apex = self.boundary.edges[edge as usize].apex;
        let (a, b) = (self.from(edge), self.to(edge));
        // The triangle runs the other way than the boundary edge.
        (a - b).cross(apex - b).normalize_or_zero()
    }
}

/// Rings of triangles kept behind a rim, so that the rim is the first of four rings of vertices: what a height field reads
/// slopes and noise from (algorithms D.3).
const RINGS: u8 = 3;
/// Boundary points within this many median edges of the mesh's box are taken for its sides, where one ring is enough.
const SIDE_EDGES: f64 = 3.0;

/// Surveys one cell: boundary, loops, components, and the triangles behind the boundary.
#[must_use]
pub fn survey(cell: CellId, mesh: &TriMesh) -> CellSurvey {
    let boundary = boundary(mesh);
    let components = components(mesh, &boundary);
    let mut bounds = Bounds::EMPTY;
    mesh.positions.iter().filter(|p| p.is_finite()).for_each(|p| bounds.add(*p));
    let median_edge_m = median_edge(&boundary);
    let band = band(mesh, &boundary, &rings(&boundary, &bounds, SIDE_EDGES * median_edge_m));
    let mut survey = CellSurvey {
        cell,
        bounds,
        vertices: mesh.positions.len() as u64,
        triangles: mesh.triangles.len() as u64,
        loops: Vec::new(),
        spacing_m: spacing(&boundary),
        median_edge_m,
        fans: Fans::new(band.vertices.len(), &band.triangles),
        band,
        boundary,
        components: Vec::new(),
    };
    survey.loops = loops(&survey.boundary)
        .loops
        .into_iter()
        .map(|l| {
            let face = survey.boundary.edges[l.edges[0] as usize].face;
            let component = components.of_face(mesh, face).map_or(u32::MAX, |c| c as u32);
            survey_loop(&survey, l.edges, component)
        })
        .collect();
    survey.components = components.list;
    survey
}

/// Rings to keep round each boundary point.
fn rings(boundary: &Boundary, bounds: &Bounds, side_m: f64) -> Vec<u8> {
    let is_inside = |p: DVec3| {
        let from_sides = (p - bounds.min).min(bounds.max - p).truncate();
        from_sides.min_element() > side_m
    };
    boundary.points.iter().map(|p| if is_inside(p.position) { RINGS } else { 1 }).collect()
}

/// Area, length and sheetness of edges in walking order; short gaps between them (over cuts) count as straight.
pub(crate) fn survey_loop(survey: &CellSurvey, edges: Vec<u32>, component: u32) -> LoopSurvey {
    let centre = survey.from(edges[0]);
    let mut vector_area = DVec3::ZERO;
    let mut length_m = 0.0;
    for &e in &edges {
        let (a, b) = (survey.from(e), survey.to(e));
        vector_area += (a - centre).cross(b - centre) / 2.0;
        length_m += a.distance(b);
    }
    let axis = vector_area.normalize_or_zero();
    let along: f64 = edges
        .iter()
        .map(|&e| survey.from(e).distance(survey.to(e)) * survey.normal_behind(e).dot(axis))
        .sum();
    let sheetness = if length_m > 0.0 { along / length_m } else { 0.0 };
    LoopSurvey { edges, component, vector_area, length_m, sheetness }
}

fn spacing(boundary: &Boundary) -> Vec<f64> {
    let mut sum = vec![(0.0, 0u32); boundary.points.len()];
    for edge in &boundary.edges {
        let ends = [edge.from, edge.to].map(|p| boundary.points[p.index()].position);
        for p in [edge.from, edge.to] {
            sum[p.index()].0 += ends[0].distance(ends[1]);
            sum[p.index()].1 += 1;
        }
    }
    sum.into_iter().map(|(length, count)| if count > 0 { length / f64::from(count) } else { 0.0 }).collect()
}

fn median_edge(boundary: &Boundary) -> f64 {
    let mut lengths: Vec<f64> = boundary
        .edges
        .iter()
        .map(|e| boundary.points[e.from.index()].position.distance(boundary.points[e.to.index()].position))
        .collect();
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    *lengths.select_nth_unstable_by(middle, f64::total_cmp).1
}
