//! What every patch must be.

mod surface;

use crate::polygon::side_of_line;
use crate::{Contour, Patch};
use glam::DVec3;
use thiserror::Error;

/// A triangle whose height is below this share of its longest side has no usable shape.
const LEAST_HEIGHT_SHARE: f64 = 1e-7;

/// Whether a patch is judged in plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanView {
    /// Every triangle must run counter-clockwise seen from above.
    Judged,
    /// Vertical and overhanging triangles are allowed.
    NotJudged,
}

/// Counts of a sound patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchFacts {
    /// Vertices: the contour's and the new ones.
    pub vertices: usize,
    /// Undirected edges.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Sum of the triangles' areas in space, square metres.
    pub area_m2: f64,
}

/// Why a patch may not be used. Vertices are numbered as in [`Patch::triangles`], triangles by place in it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PatchDefect {
    /// A position with NaN or infinity.
    #[error("vertex {vertex} is not finite: leave the hole open")]
    NotFinite {
        /// Which vertex.
        vertex: u32,
    },
    /// A corner that is neither on the contour nor new.
    #[error(
        "triangle {triangle} names vertex {vertex}, but there are only {count}: the filler's numbering is wrong"
    )]
    OutOfRange {
        /// Which triangle.
        triangle: usize,
        /// The index found there.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex that no triangle uses.
    #[error(
        "vertex {vertex} is in no triangle: the filler must use every contour vertex and drop spare ones of its own"
    )]
    Unused {
        /// Which vertex.
        vertex: u32,
    },
    /// A triangle without usable area.
    #[error("triangle {triangle} is flat: its height is under 1e-7 of its longest side")]
    Degenerate {
        /// Which triangle.
        triangle: usize,
    },
    /// A triangle that runs clockwise, or has no area, seen from above.
    #[error("triangle {triangle} is turned over seen from above")]
    TurnedOver {
        /// Which triangle.
        triangle: usize,
    },
    /// Two triangles with the same corners, in whatever direction.
    #[error("triangles {first} and {second} have the same corners")]
    Duplicate {
        /// The earlier triangle.
        first: usize,
        /// The later triangle.
        second: usize,
    },
    /// A contour edge that not exactly one triangle runs along, in the contour's direction.
    #[error(
        "contour edge {from}-{to} has {along} triangles along it and {against} against it: the patch must join the rim once"
    )]
    ContourEdge {
        /// Start of the edge.
        from: u32,
        /// End of the edge.
        to: u32,
        /// Triangles that run in the contour's direction (should be 1).
        along: usize,
        /// Triangles that run against it (should be 0).
        against: usize,
    },
    /// An inner edge that has not exactly two triangles in opposite directions.
    #[error(
        "inner edge {from}-{to} has {along} triangles along it and {against} against it: it must have one each way"
    )]
    InnerEdge {
        /// Smaller vertex.
        from: u32,
        /// Larger vertex.
        to: u32,
        /// Triangles that run from the smaller to the larger vertex.
        along: usize,
        /// Triangles that run the other way.
        against: usize,
    },
    /// A patch edge that the original mesh already has.
    #[error("inner edge {from}-{to} is an edge of the original mesh: insert a vertex on it")]
    ForbiddenEdge {
        /// Smaller vertex.
        from: u32,
        /// Larger vertex.
        to: u32,
    },
    /// Triangles that meet in a vertex without sharing edges there.
    #[error("the triangles at vertex {vertex} form {fans} fans, but the contour passes it {expected} times")]
    Pinched {
        /// Which vertex; the first one of its place.
        vertex: u32,
        /// Groups of triangles that share edges at the vertex.
        fans: usize,
        /// Contour vertices at the place; 1 for a new vertex.
        expected: usize,
    },
    /// A part of the patch that shares no vertex with the rest.
    #[error("triangle {triangle} belongs to a part of the patch that shares no vertex with the rest")]
    Separate {
        /// The part's first triangle.
        triangle: usize,
    },
    /// A patch with a handle: no disk, or disks that hang together at touching vertices, with one hole for each island.
    #[error(
        "the patch has Euler number {found}, but a surface without handles over these rings has {expected}"
    )]
    EulerNumber {
        /// V - E + F, a place counted once for each fan of triangles there.
        found: i64,
        /// 1 + parts of the patch - parts of the contour.
        expected: i64,
    },
}

/// Checks that `patch` closes `contour`: in this order, (1) all positions finite, indices in range, every vertex used;
/// (2) no flat triangle, none turned over in plan (if judged, exact), no two with the same corners; (3) each contour
/// edge used once in the contour's direction, each other edge once in either direction, none of them forbidden;
/// (4) as many fans of triangles at a place as contour vertices, one part, no handle.
///
/// Contour vertices at one place are one vertex: where rings touch, or a ring touches itself, triangles may name any of
/// them, and an edge between two places is one edge whatever names its ends have. The patch may there fall into parts
/// that hang together by such vertices only. Cut open at them, a patch without handles has
/// `V - E + F = 1 + parts of the patch - parts of the contour`, where rings that touch are one part of the contour;
/// without touching rings this is 1 - number of islands.
///
/// # Errors
/// The first defect found, in the order above and by lowest number within each.
///
/// Source: algorithm note, section E.8.
pub fn check_patch(contour: &Contour, patch: &Patch, plan: PlanView) -> Result<PatchFacts, PatchDefect> {
    let mut positions = contour.positions();
    positions.extend_from_slice(&patch.vertices);
    let mut first_at_place = contour.first_at_place();
    first_at_place.extend(first_at_place.len() as u32..positions.len() as u32);
    check_indices(&positions, &first_at_place, &patch.triangles)?;
    for (t, triangle) in patch.triangles.iter().enumerate() {
        check_shape(t, triangle.map(|v| positions[v as usize]), plan)?;
    }
    let triangles: Vec<[u32; 3]> =
        patch.triangles.iter().map(|t| t.map(|v| first_at_place[v as usize])).collect();
    check_duplicates(&triangles)?;
    let edges = check_edges(contour, &first_at_place, &triangles)?;
    surface::check_surface(contour, &first_at_place, &triangles, &edges)?;
    let area_m2 = patch.triangles.iter().map(|t| area(t.map(|v| positions[v as usize]))).sum();
    Ok(PatchFacts { vertices: positions.len(), edges: edges.count, triangles: triangles.len(), area_m2 })
}

fn check_indices(
    positions: &[DVec3],
    first_at_place: &[u32],
    triangles: &[[u32; 3]],
) -> Result<(), PatchDefect> {
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        return Err(PatchDefect::NotFinite { vertex: vertex as u32 });
    }
    let count = positions.len();
    let mut is_used = vec![false; count];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            let place = *first_at_place.get(vertex as usize).ok_or(PatchDefect::OutOfRange {
                triangle,
                vertex,
                count,
            })?;
            is_used[place as usize] = true;
        }
    }
    match first_at_place.iter().position(|&place| !is_used[place as usize]) {
        Some(vertex) => Err(PatchDefect::Unused { vertex: vertex as u32 }),
        None => Ok(()),
    }
}

fn check_shape(triangle: usize, corners: [DVec3; 3], plan: PlanView) -> Result<(), PatchDefect> {
    let [a, b, c] = corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    // Height over the longest side = 2 area / side; a NaN fails the comparison as it should.
    let is_shaped = longest > 0.0 && 2.0 * area(corners) / longest >= LEAST_HEIGHT_SHARE * longest;
    if !is_shaped {
        return Err(PatchDefect::Degenerate { triangle });
    }
    if plan == PlanView::Judged && side_of_line(a.truncate(), b.truncate(), c.truncate()) <= 0.0 {
        return Err(PatchDefect::TurnedOver { triangle });
    }
    Ok(())
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / 2.0
}

fn check_duplicates(triangles: &[[u32; 3]]) -> Result<(), PatchDefect> {
    let mut sorted: Vec<([u32; 3], usize)> = triangles.iter().copied().zip(0..).collect();
    sorted.iter_mut().for_each(|(corners, _)| corners.sort_unstable());
    sorted.sort_unstable();
    let repeated =
        sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| (pair[0].1, pair[1].1)).min();
    match repeated {
        Some((first, second)) => Err(PatchDefect::Duplicate { first, second }),
        None => Ok(()),
    }
}

/// Who runs along an undirected edge; sorted by edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeUse {
    low: u32,
    high: u32,
    user: User,
    /// `3 t + k` for the edge from corner `k` of triangle `t`; the place on the contour for a contour edge.
    half_edge: u32,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum User {
    ContourUp,
    ContourDown,
    TriangleUp,
    TriangleDown,
}

impl EdgeUse {
    fn new(from: u32, to: u32, [up, down]: [User; 2], half_edge: u32) -> Self {
        let user = if from < to { up } else { down };
        Self { low: from.min(to), high: from.max(to), user, half_edge }
    }
}

/// The edges of a patch whose edges are sound.
struct Edges {
    /// Undirected edges.
    count: usize,
    /// The two half-edges (`3 t + k`) of each inner edge.
    joined: Vec<[u32; 2]>,
}

/// Checks every edge.
fn check_edges(
    contour: &Contour,
    first_at_place: &[u32],
    triangles: &[[u32; 3]],
) -> Result<Edges, PatchDefect> {
    let mut uses: Vec<EdgeUse> = contour_edges(contour, first_at_place)
        .zip(0..)
        .map(|([from, to], k)| EdgeUse::new(from, to, [User::ContourUp, User::ContourDown], k))
        .collect();
    for (&[a, b, c], t) in triangles.iter().zip(0u32..) {
        let users = [User::TriangleUp, User::TriangleDown];
        let sides = [(a, b, 3 * t), (b, c, 3 * t + 1), (c, a, 3 * t + 2)];
        uses.extend(sides.map(|(from, to, half_edge)| EdgeUse::new(from, to, users, half_edge)));
    }
    sort_by_edge(&mut uses, first_at_place.len());
    let forbidden = forbidden_places(contour, first_at_place);
    let mut edges = Edges { count: 0, joined: vec![] };
    for edge in uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
        check_edge(&forbidden, edge)?;
        edges.count += 1;
        if let [EdgeUse { user: User::TriangleUp, half_edge: up, .. }, down] = edge {
            edges.joined.push([*up, down.half_edge]);
        }
    }
    Ok(edges)
}

/// Sorts by edge: counted by smaller vertex, then each vertex's few uses sorted.
fn sort_by_edge(uses: &mut Vec<EdgeUse>, vertices: usize) {
    let mut next = vec![0usize; vertices + 1];
    uses.iter().for_each(|u| next[u.low as usize + 1] += 1);
    for v in 0..vertices {
        next[v + 1] += next[v];
    }
    let mut sorted = uses.clone();
    for u in uses.iter() {
        sorted[next[u.low as usize]] = *u;
        next[u.low as usize] += 1;
    }
    sorted.chunk_by_mut(|a, b| a.low == b.low).for_each(<[EdgeUse]>::sort_unstable);
    *uses = sorted;
}

/// Contour edges in numbering order, from place to place.
fn contour_edges<'a>(contour: &'a Contour, first_at_place: &'a [u32]) -> impl Iterator<Item = [u32; 2]> + 'a {
    let mut first = 0;
    contour.rings().flat_map(move |ring| {
        let (start, count) = (first, ring.vertices.len() as u32);
        first += count;
        (0..count).map(move |i| [start + i, start + (i + 1) % count].map(|v| first_at_place[v as usize]))
    })
}

/// The forbidden edges between places, smaller first, sorted.
fn forbidden_places(contour: &Contour, first_at_place: &[u32]) -> Vec<[u32; 2]> {
    let place = |v: u32| first_at_place.get(v as usize).copied().unwrap_or(v);
    let mut pairs: Vec<[u32; 2]> = contour
        .forbidden_edges
        .iter()
        .map(|&[a, b]| [place(a).min(place(b)), place(a).max(place(b))])
        .collect();
    pairs.sort_unstable();
    pairs
}

/// Checks one undirected edge, given all its uses.
fn check_edge(forbidden: &[[u32; 2]], edge: &[EdgeUse]) -> Result<(), PatchDefect> {
    let count = |user: User| edge.iter().filter(|u| u.user == user).count();
    let (low, high) = (edge[0].low, edge[0].high);
    let (up, down) = (count(User::TriangleUp), count(User::TriangleDown));
    match (count(User::ContourUp), count(User::ContourDown)) {
        (0, 0) if (up, down) != (1, 1) => {
            Err(PatchDefect::InnerEdge { from: low, to: high, along: up, against: down })
        }
        (0, 0) if forbidden.binary_search(&[low, high]).is_ok() => {
            Err(PatchDefect::ForbiddenEdge { from: low, to: high })
        }
        (0, 0) => Ok(()),
        (1, 0) if (up, down) == (1, 0) => Ok(()),
        (0, 1) if (up, down) == (0, 1) => Ok(()),
        (0, _) => Err(PatchDefect::ContourEdge { from: high, to: low, along: down, against: up }),
        _ => Err(PatchDefect::ContourEdge { from: low, to: high, along: up, against: down }),
    }
}
