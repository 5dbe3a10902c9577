//! Promise 4 where tiles are cut on the border line: across a repaired hole both cells have the same border vertices and
//! edges, bit for bit.

use super::patches::place;
use super::verdict::Findings;
use glam::DVec3;
use lacuna_grid::{CellId, Grid, Side};
use lacuna_mesh::position_bits;
use std::collections::{BTreeMap, BTreeSet};

/// A boundary edge of a cell's final mesh on or near one of its borders, in the boundary's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BorderEdge {
    pub(super) from: DVec3,
    pub(super) to: DVec3,
    /// True if its triangle belongs to a patch.
    pub(super) is_patch: bool,
}

/// What the check of a shared border needs to know of one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct CellBorder {
    /// The tile's name.
    pub(super) tile: String,
    /// Its boundary near its borders.
    pub(super) edges: Vec<BorderEdge>,
    /// One unit in the last place of stored positions, metres, where the tile has an offset or is turned; else 0.
    pub(super) last_place_m: f64,
}

/// Checks every shared border on which a patch ends. `area` = cells that belong to the reconstruction area, `unreadable`
/// those that nothing is known of.
pub(super) fn check_seams(
    cells: &BTreeMap<CellId, CellBorder>,
    grid: &Grid,
    tolerance_m: f64,
    area: &BTreeSet<CellId>,
    unreadable: &BTreeSet<CellId>,
) -> Findings {
    let mut findings = Findings::default();
    let nothing = CellBorder::default();
    let borders: BTreeSet<(CellId, Side)> = cells
        .keys()
        .flat_map(|&c| {
            [
                (c, Side::East),
                (c, Side::North),
                (c.neighbour(Side::West), Side::East),
                (c.neighbour(Side::South), Side::North),
            ]
        })
        .collect();
    for (cell, side) in borders {
        let other = cell.neighbour(side);
        let both = [cell, other];
        // At the area's edge a patch ends without a partner.
        if both.iter().any(|c| !area.contains(c) || unreadable.contains(c)) {
            continue;
        }
        let line = side.across(grid.corner(cell.corner_after(side)));
        let sides = both.map(|c| Line::new(cells.get(&c).unwrap_or(&nothing), side, line, tolerance_m));
        if sides.iter().any(|s| s.edges.iter().any(|e| e.is_patch)) {
            findings.count("borders", 1);
            check_border(&sides, &mut findings);
        }
    }
    findings
}

/// One cell's edges on a border line.
struct Line<'a> {
    cell: &'a CellBorder,
    side: Side,
    edges: Vec<BorderEdge>,
    /// Directed edges, as bits of their ends.
    directed: BTreeSet<([u64; 3], [u64; 3])>,
    points: BTreeMap<[u64; 3], DVec3>,
}

impl<'a> Line<'a> {
    fn new(cell: &'a CellBorder, side: Side, line: f64, tolerance_m: f64) -> Self {
        let is_on = |e: &&BorderEdge| {
            let [a, b] = [e.from, e.to].map(|p| p.truncate());
            let near = |p| (side.across(p) - line).abs() <= tolerance_m;
            near(a)
                && near(b)
                && (side.along(a) - side.along(b)).abs() >= (side.across(a) - side.across(b)).abs()
        };
        let edges: Vec<BorderEdge> = cell.edges.iter().filter(is_on).copied().collect();
        let directed = edges.iter().map(|e| (position_bits(e.from), position_bits(e.to))).collect();
        let points = edges.iter().flat_map(|e| [e.from, e.to]).map(|p| (position_bits(p), p)).collect();
        Self { cell, side, edges, directed, points }
    }

    fn along(&self, point: DVec3) -> f64 {
        self.side.along(point.truncate())
    }

    /// Edges over a stretch of the line; touching it in a point counts only for a stretch of no length.
    fn covering(&self, low: f64, high: f64) -> impl Iterator<Item = &BorderEdge> {
        self.edges.iter().filter(move |e| {
            let (a, b) = (self.along(e.from), self.along(e.to));
            let (start, end) = (a.min(b), a.max(b));
            if low < high { start < high && end > low } else { start <= low && end >= low }
        })
    }

    /// The vertex of this side nearest to a point.
    fn nearest(&self, point: DVec3) -> f64 {
        self.points.values().map(|p| p.distance(point)).fold(f64::INFINITY, f64::min)
    }
}

fn check_border(sides: &[Line<'_>; 2], findings: &mut Findings) {
    for (own, other) in [(&sides[0], &sides[1]), (&sides[1], &sides[0])] {
        check_vertices(own, other, findings);
        check_edges(own, other, findings);
    }
}

/// Every vertex that takes part in a patch's border needs a partner where the other cell has surface.
fn check_vertices(own: &Line<'_>, other: &Line<'_>, findings: &mut Findings) {
    for (bits, &point) in &own.points {
        let along = own.along(point);
        let is_involved = own.edges.iter().any(|e| e.is_patch && [e.from, e.to].contains(&point))
            || other.covering(along, along).any(|e| e.is_patch);
        if !is_involved {
            continue;
        }
        findings.count("border vertices", 1);
        if other.points.contains_key(bits) || other.covering(along, along).next().is_none() {
            continue;
        }
        let near_m = other.nearest(point);
        let last_place_m = own.cell.last_place_m.max(other.cell.last_place_m);
        if near_m <= last_place_m {
            findings.count("border vertices apart in the last place", 1);
            continue;
        }
        let longest = own.edges.iter().filter(|e| [e.from, e.to].contains(&point));
        let longest = longest.map(|e| e.from.distance(e.to)).fold(0.0, f64::max);
        let what = if near_m > 0.25 * longest {
            "a T-junction: the other tile has no vertex there".to_owned()
        } else {
            format!("the other tile's vertex is {:.6} m away", near_m)
        };
        findings.offend(format!(
            "{} | {}: {what} {}",
            own.cell.tile,
            other.cell.tile,
            place(point.truncate())
        ));
    }
}

/// Every patch edge on the border is an edge of the other cell, in the other direction.
fn check_edges(own: &Line<'_>, other: &Line<'_>, findings: &mut Findings) {
    for edge in own.edges.iter().filter(|e| e.is_patch) {
        let (from, to) = (position_bits(edge.from), position_bits(edge.to));
        if other.directed.contains(&(to, from)) {
            continue;
        }
        let (a, b) = (own.along(edge.from), own.along(edge.to));
        let middle = edge.from.midpoint(edge.to).truncate();
        let pair = format!("{} | {}", own.cell.tile, other.cell.tile);
        if other.directed.contains(&(from, to)) {
            findings.offend(format!("{pair}: both tiles face opposite ways {}", place(middle)));
        } else if other.covering(a.min(b), a.max(b)).next().is_none() {
            let whose =
                if other.cell.tile.is_empty() { "there is no tile" } else { "the other tile is open" };
            findings.offend(format!("{pair}: a patch edge where {whose} {}", place(middle)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn chain(points: &[(f64, f64)], east: bool, patch: impl Fn(usize) -> bool) -> Vec<BorderEdge> {
        let at = |&(y, z): &(f64, f64)| DVec3::new(10.0, y, z);
        let edges = points.windows(2).enumerate().map(|(k, w)| {
            let (a, b) = (at(&w[0]), at(&w[1]));
            let (from, to) = if east { (b, a) } else { (a, b) };
            BorderEdge { from, to, is_patch: patch(k) }
        });
        edges.collect()
    }

    fn check(west: Vec<BorderEdge>, east: Vec<BorderEdge>, area: &[i32]) -> Findings {
        let grid = Grid { origin: DVec2::ZERO, cell_size_m: 10.0 };
        let border = |tile: &str, edges| CellBorder { tile: tile.to_owned(), edges, last_place_m: 0.0 };
        let cells =
            [(CellId::new(0, 0), border("west", west)), (CellId::new(1, 0), border("east", east))].into();
        let area = area.iter().map(|&i| CellId::new(i, 0)).collect();
        check_seams(&cells, &grid, 0.002, &area, &BTreeSet::new())
    }

    #[test]
    fn borders_by_case() {
        let line = [(1.0, 0.0), (3.0, 0.5), (5.0, 0.0), (8.0, 1.0)];
        let all = |_| true;
        let up = [(1.0, 0.0), (3.0, 0.501), (5.0, 0.0), (8.0, 1.0)];
        let split = [(1.0, 0.0), (3.0, 0.5), (5.0, 0.0), (6.5, 0.5), (8.0, 1.0)];
        let cases = [
            ("the same", chain(&line, true, all), 0),
            ("a vertex 1 mm up", chain(&up, true, all), 2),
            ("a T-junction", chain(&split, true, all), 1),
            ("a T-junction in delivered surface", chain(&split, true, |_| false), 1),
            ("one edge missing", chain(&line[..3], true, all), 1),
            ("nothing there", Vec::new(), 3),
            ("flipped", chain(&line, false, all), 6),
        ];
        for (name, east, expected) in cases {
            let result = check(chain(&line, false, all), east, &[0, 1]).into_result(4, "", true);
            assert_eq!(result.offenders, expected, "{name}: {:?}", result.details);
        }
        let outside = check(chain(&line, false, all), Vec::new(), &[0]);
        assert_eq!(outside.into_result(4, "", true).offenders, 0, "at the area's edge");
        let delivered = check(chain(&line, false, |_| false), chain(&up, true, |_| false), &[0, 1]);
        assert_eq!(delivered.counted("borders"), 0, "no patch takes part");
    }
}
