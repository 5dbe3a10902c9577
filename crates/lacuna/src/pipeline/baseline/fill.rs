//! One hole of the merged mesh, filled.

use super::merge::Merged;
use super::share::{Shared, share};
use super::{AggregateInput, Work, failure};
use crate::config::{ClosedFiller, FillSettings};
use crate::pipeline::solve::{FilledHole, NotFilled};
use lacuna_close::{CellContour, Curves, contour};
use lacuna_fill::{FillError, FillParams, Filled, FillerChoice, HeightRule, fill};
use lacuna_grid::CellId;
use lacuna_mesh::{PlanView, check_patch};
use lacuna_solve::FaerSolver;
use std::collections::{BTreeMap, BTreeSet};

/// Largest rim for the minimum-area triangulation (80 MB, some seconds); larger ones are triangulated in plan, as
/// existing fillers do.
pub(super) const LARGEST_RING: usize = 2000;

/// Fills all merged holes of a cluster and gives their triangles to the cluster's holes in the plan.
pub(super) fn fill_cluster(
    input: &AggregateInput<'_>,
    merged: &Merged,
    work: &Work,
) -> Result<BTreeMap<u32, FilledHole>, NotFilled> {
    if work.merged_holes.is_empty() {
        return Err(NotFilled {
            is_refusal: true,
            reason: "no closed hole of the merged mesh shares its rim; aggregate leaves what is open to the outside or looks \
                     like a passage"
                .to_owned(),
        });
    }
    let settings = (input.settings_of)(work.holes[0]);
    let cells: BTreeSet<CellId> = work.holes.iter().map(|&h| input.plan.holes[h as usize].cell).collect();
    let mut shared = Shared::new(input, &work.holes);
    for &hole in &work.merged_holes {
        let record = &merged.plan.holes[hole as usize];
        let contour = contour(&merged.surveys, &merged.plan, record, &Curves::default(), &|p| p)
            .map_err(|e| NotFilled { is_refusal: true, reason: e.to_string() })?;
        let mut filled = fill_merged(&contour, &settings)
            .map_err(|e| NotFilled { is_refusal: e.is_refusal(), reason: e.to_string() })?;
        for vertex in &mut filled.patch.vertices {
            *vertex = input.frames.round_for(cells.iter(), *vertex);
        }
        check_patch(&contour.contour, &filled.patch, PlanView::NotJudged).map_err(|e| NotFilled {
            is_refusal: true,
            reason: format!("the tiles' number type is too coarse for the patch: {e}"),
        })?;
        share(&mut shared, merged, &contour, &filled)?;
    }
    shared.finish().map_err(failure)
}

/// Minimum area, refined to the rim's density and faired; Delaunay in plan for rims that it does not take (islands, too
/// many vertices), unless the settings name one filler.
fn fill_merged(contour: &CellContour, settings: &FillSettings) -> Result<Filled, FillError> {
    let with = |filler: FillerChoice| {
        let params = FillParams {
            filler,
            spacing_m: settings.spacing_m,
            growth: 0.0,
            heights: HeightRule::Biharmonic,
            overshoot: f64::INFINITY,
            largest_ring: LARGEST_RING,
            ..FillParams::default()
        };
        fill(&contour.contour, &params, &FaerSolver)
    };
    match settings.closed {
        ClosedFiller::MinArea => with(FillerChoice::MinArea),
        ClosedFiller::Delaunay => with(FillerChoice::Delaunay),
        ClosedFiller::Auto => {
            with(FillerChoice::MinArea).or_else(|first| with(FillerChoice::Delaunay).map_err(|_| first))
        }
    }
}
