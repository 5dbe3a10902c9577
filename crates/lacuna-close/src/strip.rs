//! Overlap strips of tiles that overrun their cell: both cells take the same triangles between their two lines, so that
//! the surfaces agree there (decisions 8).

use crate::Curves;
use glam::{DVec2, DVec3};
use lacuna_grid::{CornerId, Side};
use lacuna_hole::{Anchor, BorderMode, Curve, CurveKind, Plan, Surveys};
use std::collections::BTreeMap;

/// Marks, in every shared curve, the steps between neighbouring points whose whole rectangle between the two cells' lines
/// is free of rims, and the grid corners whose square is free in all four cells.
pub(crate) fn mark_strips(surveys: &Surveys, plan: &Plan, curves: &mut Curves) {
    if plan.fit.mode != BorderMode::Overrun {
        return;
    }
    let mut free_ends: BTreeMap<CornerId, u32> = BTreeMap::new();
    for (k, curve) in plan.curves.iter().enumerate() {
        if curve.kind != CurveKind::Shared {
            continue;
        }
        let blocked = blocked_intervals(surveys, plan, curve);
        let side = curve.border.side;
        let along: Vec<f64> = curves.curves[k].inner.iter().map(|p| side.along(p.truncate())).collect();
        let slack = 0.5 * plan.fit.margin_m;
        let is_free = |a: f64, b: f64| !blocked.iter().any(|i| i.0 <= b + slack && i.1 >= a - slack);
        let free: Vec<bool> = along.windows(2).map(|w| is_free(w[0], w[1])).collect();
        for (anchor, step) in [(curve.low, free.first()), (curve.high, free.last())] {
            if let (Anchor::Corner(corner), Some(true)) = (anchor, step) {
                *free_ends.entry(corner).or_default() += 1;
            }
        }
        curves.curves[k].free_steps = free;
    }
    curves.free_corners = free_ends.into_iter().filter(|e| e.1 == 4).map(|e| e.0).collect();
}

/// Stretches along a curve where a rim of one of its holes reaches into the strip.
fn blocked_intervals(surveys: &Surveys, plan: &Plan, curve: &Curve) -> Vec<(f64, f64)> {
    let side = curve.border.side;
    let margin = plan.fit.margin_m;
    // The curve's line is that of one of the two cells; both lie within two margins of it.
    let reach = 2.5 * margin;
    let mut blocked = Vec::new();
    for &h in &curve.holes {
        let hole = &plan.holes[h as usize];
        let Some(survey) = surveys.get(&hole.cell) else { continue };
        for edge in hole.rim_edges(survey) {
            let ends: [DVec2; 2] = [survey.from(edge).truncate(), survey.to(edge).truncate()];
            let across = ends.map(|p| side.across(p) - curve.line);
            let beyond = across.iter().all(|a| *a > reach) || across.iter().all(|a| *a < -reach);
            if !beyond {
                let along = ends.map(|p| side.along(p));
                blocked.push((along[0].min(along[1]), along[0].max(along[1])));
            }
        }
    }
    blocked
}

/// The lines of the four cells round a grid corner: (lower, upper) x and (lower, upper) y. `None` unless all four cells
/// belong to the area.
pub(crate) fn square_lines(plan: &Plan, corner: CornerId) -> Option<[[f64; 2]; 2]> {
    let [south_west, south_east, north_west, north_east] = corner.cells().map(|c| plan.domains.get(&c));
    let (south_west, south_east, north_west) = (south_west?, south_east?, north_west?);
    north_east?;
    let x = [south_east.side(Side::West).line, south_west.side(Side::East).line];
    let y = [north_west.side(Side::South).line, south_west.side(Side::North).line];
    Some([x, y])
}

/// The square of four cells round a grid corner as two triangles at one height.
pub(crate) fn square_triangles([x, y]: [[f64; 2]; 2], height_m: f64) -> [[DVec3; 3]; 2] {
    let at = |i: usize, j: usize| DVec3::new(x[i], y[j], height_m);
    [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
}

/// The two triangles of a step of a strip, counter-clockwise from above, in terms of its corners: lower and upper line
/// (by the coordinate across), first and second point (by the coordinate along).
pub(crate) fn step_triangles<T: Copy>(side: Side, low: [T; 2], high: [T; 2]) -> [[T; 3]; 2] {
    let [a, b] = low;
    let [d, c] = high;
    if side.is_horizontal() { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_face_up_on_both_kinds_of_border() {
        for side in [Side::South, Side::West] {
            let at = |along: f64, across: f64| side.point(along, across);
            for [a, b, c] in
                step_triangles(side, [at(0.0, -1.0), at(2.0, -1.0)], [at(0.0, 1.0), at(2.0, 1.0)])
            {
                assert!((b - a).perp_dot(c - a) > 0.0, "{side:?}");
            }
        }
    }
}
