//! What of a plan must come out the same, however the scene is written down.

use super::Planned;
use lacuna_grid::CellId;
use lacuna_hole::{Hole, Plan};

/// One hole as the tables write it: `column,row class Llayer #cluster area`, and `+n` for n islands.
pub(crate) fn lines(plan: &Plan) -> Vec<String> {
    let line = |h: &Hole| {
        let islands = if h.islands.is_empty() { String::new() } else { format!(" +{}", h.islands.len()) };
        let area = (h.area_m2 * 1e6).round() / 1e6;
        format!("{},{} {} L{} #{} {area}{islands}", h.cell.i, h.cell.j, h.class, h.layer, h.cluster)
    };
    plan.holes.iter().map(line).collect()
}

/// What must not change of one hole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) cell: CellId,
    pub(crate) class: String,
    pub(crate) layer: u32,
    pub(crate) islands: usize,
    pub(crate) rim_vertices: u32,
    pub(crate) leave: Option<String>,
    /// Cells and classes of its cluster.
    pub(crate) cluster: Vec<(CellId, String)>,
    pub(crate) area_m2: f64,
    pub(crate) perimeter_m: f64,
    pub(crate) cluster_area_m2: f64,
}

/// All holes, their cells renamed by `name`, in an order that does not depend on the plan's.
pub(crate) fn signature(planned: &Planned, name: impl Fn(CellId) -> CellId) -> Vec<Line> {
    let plan = &planned.plan;
    let of = |h: &Hole| {
        let cluster = &plan.clusters[h.cluster as usize];
        let mut members: Vec<(CellId, String)> = cluster
            .holes
            .iter()
            .map(|&m| &plan.holes[m as usize])
            .map(|m| (name(m.cell), m.class.to_string()))
            .collect();
        members.sort();
        Line {
            cell: name(h.cell),
            class: h.class.to_string(),
            layer: h.layer,
            islands: h.islands.len(),
            rim_vertices: h.rim_vertices,
            leave: h.leave.map(|l| l.to_string()),
            cluster: members,
            area_m2: h.area_m2,
            perimeter_m: h.perimeter_m,
            cluster_area_m2: cluster.area_m2,
        }
    };
    let mut all: Vec<Line> = plan.holes.iter().map(of).collect();
    all.sort_by(|a, b| {
        let key = |l: &Line| (l.cell, l.class.clone(), l.rim_vertices, l.islands);
        key(a).cmp(&key(b)).then(a.area_m2.total_cmp(&b.area_m2))
    });
    all
}

/// Compares two signatures: figures to one part in a million, the rest exactly.
pub(crate) fn assert_same(a: &[Line], b: &[Line], what: &str) {
    let without_figures = |all: &[Line]| -> Vec<Line> {
        let plain = |l: &Line| Line { area_m2: 0.0, perimeter_m: 0.0, cluster_area_m2: 0.0, ..l.clone() };
        all.iter().map(plain).collect()
    };
    assert_eq!(without_figures(a), without_figures(b), "{what}");
    for (x, y) in a.iter().zip(b) {
        let figures = |l: &Line| [l.area_m2, l.perimeter_m, l.cluster_area_m2];
        for (p, q) in figures(x).into_iter().zip(figures(y)) {
            assert!((p - q).abs() <= 1e-6 * p.abs().max(q.abs()), "{what}: {x:?} and {y:?}");
        }
    }
}
