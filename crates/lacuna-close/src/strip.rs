//! Overlap strips of tiles that overrun their cell: both cells take the same triangles between their two lines, so that
//! the surfaces agree there (decisions 8).

use crate::Curves;
use crate::square::mark_squares;
use glam::DVec2;
use lacuna_grid::Side;
use lacuna_hole::{BorderMode, Curve, CurveKind, Plan, Surveys};

/// Marks, in every shared curve, the steps between neighbouring points whose whole rectangle between the two cells' lines
/// is free of rims, and then the squares at grid corners.
pub(crate) fn mark_strips(surveys: &Surveys, plan: &Plan, curves: &mut Curves) {
    if plan.fit.mode != BorderMode::Overrun {
        return;
    }
    for (k, curve) in plan.curves.iter().enumerate() {
        if curve.kind != CurveKind::Shared {
            continue;
        }
        let blocked = blocked_intervals(surveys, plan, curve);
        let side = curve.border.side;
        let along: Vec<f64> = curves.curves[k].inner.iter().map(|p| side.along(p.truncate())).collect();
        let slack = 0.5 * plan.fit.margin_m;
        let is_free = |a: f64, b: f64| !blocked.iter().any(|i| i.0 <= b + slack && i.1 >= a - slack);
        curves.curves[k].free_steps = along.windows(2).map(|w| is_free(w[0], w[1])).collect();
    }
    mark_squares(surveys, plan, curves);
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
