//! Method `layered`: border heights projected from the rims, from the outside in (Wang et al. 2021, sec. 3.3; algorithms
//! note D.1).

use crate::curve::{BorderCurve, Curves};
use crate::profile::{Candidate, Profile};
use crate::square::square_ends;
use crate::strip::mark_strips;
use glam::{DVec2, DVec3};
use lacuna_grid::{CellId, CornerId, Side};
use lacuna_hole::{Anchor, BorderMode, CellSurvey, Curve, CurveKind, Hole, Piece, Plan, Span, Surveys};
use std::collections::BTreeMap;

/// What the projection may vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredOptions {
    /// How much the distance of points may grow per metre from the ends of a stretch; 0 keeps the rim's density.
    pub growth: f64,
    /// Largest distance of points along the border, metres; `None`: the rim's, or 16 times it where distances grow.
    pub spacing_m: Option<f64>,
}

/// Growing distances end at this many times the rim's (decisions 18).
const LARGEST_EDGES: f64 = 16.0;

/// A vertex whose height is known: of a rim, of a neighbour's border, or of a curve of a lower layer.
struct Target {
    place: DVec2,
    height_m: f64,
}

/// Heights known so far, and the geometry they come from.
struct Projection<'a> {
    surveys: &'a Surveys,
    plan: &'a Plan,
    options: &'a dyn Fn(u32) -> LayeredOptions,
    profiles: Vec<Option<Profile>>,
    curves: Curves,
}

/// Computes all closing curves of a plan.
///
/// Steps, layer by layer: every hole of the layer projects its target vertices (rim and adopted vertices, then points of
/// curves of lower layers) orthogonally on its open stretches; a new point takes the mean height of the centroids of the
/// boundary triangles at the vertex; where two holes of one layer meet, the mean of both profiles holds. Then the grid
/// corners: mean of the heights nearest to them on each side. Then points are spaced along every stretch, as `options` say
/// for its holes (all of one cluster).
#[must_use]
pub fn project(surveys: &Surveys, plan: &Plan, options: &dyn Fn(u32) -> LayeredOptions) -> Curves {
    let count = plan.curves.len();
    let mut projection = Projection {
        surveys,
        plan,
        options,
        profiles: vec![None; count],
        curves: Curves { curves: vec![BorderCurve::default(); count], ..Curves::default() },
    };
    let last = plan.holes.iter().map(|h| h.layer).max().unwrap_or(0);
    for layer in 1..=last {
        projection.add_layer(layer);
    }
    mark_strips(surveys, plan, &mut projection.curves);
    projection.curves
}

impl Projection<'_> {
    /// Closes all stretches that the holes of a layer bring, from these holes together.
    fn add_layer(&mut self, layer: u32) {
        let mut parts: BTreeMap<u32, Vec<Profile>> = BTreeMap::new();
        for hole in self.plan.holes.iter().filter(|h| h.layer == layer) {
            let targets = self.targets(hole);
            for (_, span) in spans(hole) {
                if let Span::Curve(c) = *span
                    && self.profiles[c as usize].is_none()
                {
                    let profile = self.projected(&targets, &self.plan.curves[c as usize]);
                    parts.entry(c).or_default().push(profile);
                }
            }
        }
        let fresh: Vec<u32> = parts.keys().copied().collect();
        for (c, profiles) in parts {
            let merged = profiles.iter().skip(1).fold(profiles[0].clone(), |all, p| all.mean(p));
            let pinned = self.pin_known_ends(&self.plan.curves[c as usize], merged);
            self.profiles[c as usize] = Some(pinned);
        }
        self.add_corners(&fresh);
        for c in fresh {
            self.place_points(c);
        }
    }

    /// Target vertices of a hole.
    fn targets(&self, hole: &Hole) -> Vec<Target> {
        let mut targets = Vec::new();
        for piece in &hole.outer {
            match piece {
                Piece::Rim(edges) => self.add_rim_targets(hole.cell, edges, &mut targets),
                Piece::Side { spans, .. } => {
                    for span in spans {
                        match span {
                            Span::Adopted { neighbour, edges } => {
                                self.add_rim_targets(*neighbour, edges, &mut targets);
                            }
                            Span::Curve(c) => self.add_curve_targets(*c, &mut targets),
                        }
                    }
                }
                Piece::Bridge => {}
            }
        }
        for &island in &hole.islands {
            if let Some(survey) = self.surveys.get(&hole.cell) {
                self.add_rim_targets(hole.cell, &survey.loops[island as usize].edges, &mut targets);
            }
        }
        targets
    }

    fn add_rim_targets(&self, cell: CellId, edges: &[u32], targets: &mut Vec<Target>) {
        let Some(survey) = self.surveys.get(&cell) else { return };
        let centroid =
            |e: u32| (survey.from(e).z + survey.to(e).z + survey.boundary.edges[e as usize].apex.z) / 3.0;
        for (k, &e) in edges.iter().enumerate() {
            // The boundary triangles at the start of this edge: this one's, and that of the edge before it.
            let mut height_m = centroid(e);
            if let Some(&before) = k.checked_sub(1).and_then(|b| edges.get(b)) {
                height_m = (height_m + centroid(before)) / 2.0;
            }
            targets.push(Target { place: survey.from(e).truncate(), height_m });
        }
        if let Some(&last) = edges.last() {
            targets.push(Target { place: survey.to(last).truncate(), height_m: centroid(last) });
        }
    }

    fn add_curve_targets(&self, c: u32, targets: &mut Vec<Target>) {
        let curve = &self.plan.curves[c as usize];
        if let CurveKind::OverNeighbour(neighbour) = curve.kind {
            self.add_rim_targets(neighbour, &curve.over, targets);
        } else if self.profiles[c as usize].is_some() {
            let points = &self.curves.curves[c as usize].inner;
            targets.extend(points.iter().map(|p| Target { place: p.truncate(), height_m: p.z }));
        }
    }

    /// The heights that a hole's targets (or, over a neighbour's surface, that surface) give to a stretch.
    fn projected(&self, targets: &[Target], curve: &Curve) -> Profile {
        let side = curve.border.side;
        if let CurveKind::OverNeighbour(neighbour) = curve.kind
            && let Some(survey) = self.surveys.get(&neighbour)
        {
            return over_surface(survey, curve, side);
        }
        let inside = |t: &&Target| {
            let along = side.along(t.place);
            along > curve.low_m && along < curve.high_m
        };
        let candidates = targets
            .iter()
            .filter(inside)
            .map(|t| Candidate {
                along_m: side.along(t.place),
                height_m: t.height_m,
                distance_m: (side.across(t.place) - curve.line).abs(),
            })
            .collect();
        Profile::from_candidates(candidates, curve.low_m, self.spacing(curve))
    }

    /// Ends that stand on original vertices have exact heights.
    fn pin_known_ends(&self, curve: &Curve, mut profile: Profile) -> Profile {
        for (along_m, anchor) in [(curve.low_m, curve.low), (curve.high_m, curve.high)] {
            if let Some(p) = self.anchor_position(anchor) {
                profile.pin(along_m, p.z, 0.5 * self.spacing(curve));
            }
        }
        profile
    }

    /// Position of an anchor that is an original vertex or a known corner.
    fn anchor_position(&self, anchor: Anchor) -> Option<DVec3> {
        match anchor {
            Anchor::Point(cell, point) => Some(self.surveys.get(&cell)?.position(point)),
            Anchor::Corner(corner) => match self.plan.corner_vertex(corner) {
                Some(Anchor::Point(cell, point)) => Some(self.surveys.get(&cell)?.position(point)),
                _ => self.curves.corners.get(&corner).copied(),
            },
            Anchor::Free => None,
        }
    }

    /// Heights of the bare corners at the ends of new stretches: the mean of what each of these stretches says there.
    fn add_corners(&mut self, fresh: &[u32]) {
        let mut heights: BTreeMap<CornerId, Vec<f64>> = BTreeMap::new();
        for &c in fresh {
            let curve = &self.plan.curves[c as usize];
            for (along_m, anchor) in [(curve.low_m, curve.low), (curve.high_m, curve.high)] {
                let Anchor::Corner(corner) = anchor else { continue };
                if self.anchor_position(anchor).is_none()
                    && let Some(z) = self.profiles[c as usize].as_ref().and_then(|p| p.at(along_m))
                {
                    heights.entry(corner).or_default().push(z);
                }
            }
        }
        for (corner, z) in heights {
            let mean = z.iter().sum::<f64>() / z.len() as f64;
            let place = self.corner_place(corner);
            self.curves.corners.insert(corner, place.extend(mean));
        }
        for &c in fresh {
            let curve = &self.plan.curves[c as usize];
            if let Some(profile) = self.profiles[c as usize].take() {
                self.profiles[c as usize] = Some(self.pin_known_ends(curve, profile));
            }
        }
    }

    fn corner_place(&self, corner: CornerId) -> DVec2 {
        for cell in corner.cells() {
            if let Some(domain) = self.plan.domains.get(&cell) {
                let side = Side::ALL.into_iter().find(|&s| cell.corner_after(s) == corner);
                if let Some(side) = side {
                    return domain.corner_after(side);
                }
            }
        }
        DVec2::ZERO
    }

    fn options_of(&self, curve: &Curve) -> LayeredOptions {
        (self.options)(curve.holes[0])
    }

    /// Distance of points at the ends of a stretch, metres: the mean rim edge there; the scene's median edge where an end
    /// is bare.
    fn spacing(&self, curve: &Curve) -> f64 {
        let options = self.options_of(curve);
        let largest_m = options.spacing_m.unwrap_or(f64::INFINITY);
        if options.growth <= 0.0 && largest_m.is_finite() {
            return largest_m;
        }
        let at = |anchor| match anchor {
            Anchor::Point(cell, point) => {
                self.surveys.get(&cell).and_then(|s| s.spacing_m.get(point.index()).copied())
            }
            _ => None,
        };
        let known: Vec<f64> =
            [at(curve.low), at(curve.high)].into_iter().flatten().filter(|s| *s > 0.0).collect();
        let of_rim = if known.is_empty() {
            self.plan.fit.edge_m.max(1e-3)
        } else {
            known.iter().sum::<f64>() / known.len() as f64
        };
        // Overlapping patches must agree from two rim edges on: long edges at its end must not reach so far.
        let is_overlap = self.plan.fit.mode == BorderMode::Overrun;
        let overlap_m = if is_overlap { 1.5 * self.plan.fit.edge_m } else { f64::INFINITY };
        of_rim.min(largest_m).min(overlap_m)
    }

    /// Spaces points along a stretch and gives them the profile's heights.
    fn place_points(&mut self, c: u32) {
        let curve = &self.plan.curves[c as usize];
        let spacing_m = self.spacing(curve);
        let side = curve.border.side;
        let options = self.options_of(curve);
        let largest_m = options.spacing_m.unwrap_or(LARGEST_EDGES * spacing_m);
        let rule = Spacing { first_m: spacing_m, growth: options.growth, largest_m };
        let Some(profile) = &self.profiles[c as usize] else { return };
        let [low, high] = self.fixed_points(curve);
        let mut along = rule.points(low.unwrap_or(curve.low_m), high.unwrap_or(curve.high_m));
        if let Some(t) = low {
            along.insert(0, t);
        }
        along.extend(high);
        along.dedup();
        let mut inner: Vec<DVec3> =
            along.iter().filter_map(|&t| Some(side.point(t, curve.line).extend(profile.at(t)?))).collect();
        // The corners of the square that four cells share have the height of the grid corner.
        let corner_height = |anchor| self.anchor_position(anchor).map(|p| p.z);
        if let (Some(_), Some(z), Some(first)) = (low, corner_height(curve.low), inner.first_mut()) {
            first.z = z;
        }
        if let (Some(_), Some(z), Some(last)) = (high, corner_height(curve.high), inner.last_mut()) {
            last.z = z;
        }
        let slope = vec![0.0; inner.len()];
        self.curves.curves[c as usize] = BorderCurve { inner, slope, spacing_m, ..BorderCurve::default() };
    }

    /// Points that a curve must have at its low and at its high end. Where tiles are ragged an end is where the line
    /// is seen from the vertex that the curve is tied to; where they overrun their cell, at a corner's square.
    fn fixed_points(&self, curve: &Curve) -> [Option<f64>; 2] {
        if self.plan.fit.mode != BorderMode::Ragged || curve.kind != CurveKind::Shared {
            return square_ends(self.plan, curve);
        }
        let is_tied = |anchor| matches!(anchor, Anchor::Point(..));
        [(curve.low, curve.low_m), (curve.high, curve.high_m)].map(|(a, m)| is_tied(a).then_some(m))
    }
}

/// The spans of a hole with their sides.
fn spans(hole: &Hole) -> impl Iterator<Item = (Side, &Span)> {
    hole.outer.iter().flat_map(|p| match p {
        Piece::Side { side, spans, .. } => spans.iter().map(|s| (*side, s)).collect::<Vec<_>>(),
        _ => Vec::new(),
    })
}

/// Heights of a neighbour's boundary triangles where a curve on the hole's own line crosses them.
fn over_surface(survey: &CellSurvey, curve: &Curve, side: Side) -> Profile {
    let mut candidates = Vec::new();
    for &e in &curve.over {
        let (a, b) = (survey.from(e), survey.to(e));
        let normal = survey.normal_behind(e);
        for (place, weight) in [(a, 0.0), ((a + b) / 2.0, 1.0), (b, 0.0)] {
            let along = side.along(place.truncate());
            let on_line = side.point(along, curve.line);
            // The plane of the triangle behind, from its edge to the hole's own line; walls have no height there.
            let step = on_line - place.truncate();
            let rise =
                if normal.z.abs() > 0.15 { -(normal.x * step.x + normal.y * step.y) / normal.z } else { 0.0 };
            candidates.push(Candidate { along_m: along, height_m: place.z + rise, distance_m: weight });
        }
    }
    let bin = survey.median_edge_m / 4.0;
    Profile::from_candidates(candidates, curve.low_m, bin)
}

/// Distances of points along a stretch.
struct Spacing {
    /// At the ends, metres.
    first_m: f64,
    /// By how much they grow per metre from the nearer end.
    growth: f64,
    /// At the most, metres.
    largest_m: f64,
}

impl Spacing {
    /// Points strictly between two ends; the same whichever end the walk starts from.
    fn points(&self, low_m: f64, high_m: f64) -> Vec<f64> {
        let length = high_m - low_m;
        let half = self.steps_to(length / 2.0);
        let steps = (2.0 * half).round().clamp(1.0, 1e7) as usize;
        let at = |k: usize| {
            let s = 2.0 * half * (k as f64 / steps as f64);
            if s <= half { low_m + self.distance_of(s) } else { high_m - self.distance_of(2.0 * half - s) }
        };
        (1..steps).map(at).collect()
    }

    /// Distance from the end where the largest spacing is reached, metres.
    fn grown_m(&self) -> f64 {
        if self.growth > 0.0 {
            ((self.largest_m - self.first_m) / self.growth).max(0.0)
        } else {
            f64::INFINITY
        }
    }

    /// Number of steps up to a distance from an end: the integral of 1 / spacing.
    fn steps_to(&self, distance_m: f64) -> f64 {
        if self.growth <= 0.0 {
            return distance_m / self.first_m.max(1e-9);
        }
        let growing = distance_m.min(self.grown_m());
        (1.0 + self.growth * growing / self.first_m).ln() / self.growth
            + (distance_m - growing) / self.largest_m
    }

    /// The reverse of `steps_to`.
    fn distance_of(&self, steps: f64) -> f64 {
        if self.growth <= 0.0 {
            return steps * self.first_m.max(1e-9);
        }
        let growing = steps.min(self.steps_to(self.grown_m()));
        ((self.growth * growing).exp() - 1.0) * self.first_m / self.growth
            + (steps - growing) * self.largest_m
    }
}

#[cfg(test)]
mod tests {
    use super::Spacing;

    fn spaced(length_m: f64, first_m: f64, growth: f64, largest_m: f64) -> Vec<f64> {
        Spacing { first_m, growth, largest_m }.points(0.0, length_m)
    }

    #[test]
    fn points_are_even_without_growth() {
        assert_eq!(spaced(10.0, 2.4, 0.0, 99.0), [2.5, 5.0, 7.5]);
        assert!(spaced(1.0, 5.0, 0.0, 99.0).is_empty());
    }

    #[test]
    fn growing_points_are_symmetric_and_ascend_up_to_the_largest_distance() {
        for largest_m in [1.0, 3.0, 99.0] {
            let points = spaced(100.0, 1.0, 0.3, largest_m);
            let mirrored: Vec<f64> = points.iter().rev().map(|p| 100.0 - p).collect();
            assert!(points.iter().zip(&mirrored).all(|(a, b)| (a - b).abs() < 1e-9));
            assert!((points[0] - 1.0).abs() < 0.3, "{}", points[0]);
            let steps: Vec<f64> = points.windows(2).map(|w| w[1] - w[0]).collect();
            let most = steps.iter().copied().fold(0.0, f64::max);
            assert!(steps.iter().all(|s| *s > 0.0) && most < 1.05 * largest_m.min(15.0), "{most}");
            assert!(most > 0.9 * largest_m.min(8.0), "{most}");
        }
    }
}
