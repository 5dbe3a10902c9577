//! Method `field`: triangulations of all holes in plan, then one height field a cluster.

use super::RunError;
use super::solve::{HoleFiller, fill_params};
use crate::config::{ClosedFiller, FillSettings, MethodName, WaterMode};
use lacuna_close::{
    CellContour, ClusterField, Curves, FieldError, FieldParams, FieldPart, Water, WaterRule, contour, field,
    field_bytes, measuring_bytes, raise_curves,
};
use lacuna_fill::{Triangulation, triangulate_in_plan};
use lacuna_hole::HoleClass;
use lacuna_schedule::{Job, JobResult};
use std::collections::{BTreeMap, BTreeSet};

/// What a cluster's field gives to one hole.
pub(crate) struct RaisedHole {
    pub(crate) triangulation: Triangulation,
    /// Heights of the new vertices, metres.
    pub(crate) new_m: Vec<f64>,
}

/// Fields of all clusters in work.
#[derive(Default)]
pub(crate) struct Fields {
    /// By hole number.
    pub(crate) holes: BTreeMap<u32, RaisedHole>,
    /// Why a cluster has none, by hole number: it is left to `layered`.
    pub(crate) refused: BTreeMap<u32, String>,
    /// The water of a cluster, by the cluster's number.
    pub(crate) water: BTreeMap<u32, Water>,
}

/// Bytes a place in the region takes at most while its field is solved, and what each doubling of their number adds: the
/// factor fills in, the more the wider the hole (measured: up to 3.1 kB at 4e5 places).
const BYTES_A_PLACE: f64 = 1200.0;
const BYTES_A_DOUBLING: f64 = 130.0;
/// From this many places on the need is measured on the matrix instead: rivers need a third of what lakes do.
const MEASURED_PLACES: f64 = 20_000.0;
/// Places behind the rim for each rim vertex: three rings, shared by the two sides of a corner.
const RING_PLACES: f64 = 3.5;

/// Triangulates the holes of all clusters that use `field`, fits the fields, and writes their heights into the curves.
pub(crate) fn solve_fields(
    filler: &HoleFiller<'_>,
    todo: &BTreeSet<u32>,
    curves: &mut Curves,
) -> Result<Fields, RunError> {
    let wanted: BTreeSet<u32> =
        todo.iter().copied().filter(|&h| is_wanted(filler, h, &(filler.settings_of)(h))).collect();
    let mut refused = BTreeMap::new();
    let mut triangulations = BTreeMap::new();
    for (h, result) in triangulate_all(filler, &wanted, curves)? {
        match result {
            Ok(triangulation) => _ = triangulations.insert(h, triangulation),
            Err(reason) => _ = refused.insert(h, reason),
        }
    }
    let mut clusters: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &h in &wanted {
        clusters.entry(filler.plan.holes[h as usize].cluster).or_default().push(h);
    }
    clusters.retain(|_, holes| {
        let reason = holes.iter().find_map(|h| refused.get(h).cloned());
        if let Some(reason) = &reason {
            holes.iter().for_each(|&h| _ = refused.insert(h, reason.clone()));
        }
        reason.is_none()
    });
    let mut fields = Fields { refused, ..Fields::default() };
    for (holes, result) in fit_all(filler, clusters.into_values().collect(), &triangulations, curves)? {
        match result {
            Ok(mut fitted) => {
                raise_curves(filler.plan, &fitted, curves);
                let cluster = filler.plan.holes[holes[0] as usize].cluster;
                fields.water.extend(fitted.water.map(|w| (cluster, w)));
                for (h, new_m) in holes.into_iter().zip(std::mem::take(&mut fitted.new_m)) {
                    if let Some(triangulation) = triangulations.remove(&h) {
                        fields.holes.insert(h, RaisedHole { triangulation, new_m });
                    }
                }
            }
            Err(reason) => fields.refused.extend(holes.into_iter().map(|h| (h, reason.clone()))),
        }
    }
    Ok(fields)
}

/// A closed hole may ask for the least area instead.
fn is_wanted(filler: &HoleFiller<'_>, hole: u32, settings: &FillSettings) -> bool {
    let is_closed = filler.plan.holes[hole as usize].class == HoleClass::Closed;
    settings.method == MethodName::Field && !(is_closed && settings.closed == ClosedFiller::MinArea)
}

type Triangulated = Vec<(u32, Result<Triangulation, String>)>;

fn triangulate_all(
    filler: &HoleFiller<'_>,
    holes: &BTreeSet<u32>,
    curves: &Curves,
) -> Result<Triangulated, RunError> {
    let holes: Vec<u32> = holes.iter().copied().collect();
    let jobs: Vec<Job> = holes.iter().map(|&h| filler.job(h)).collect();
    let triangulate = |k: usize| {
        let contour = filler.contour(holes[k], curves).map_err(|e| e.reason)?;
        let params = fill_params(filler, holes[k]);
        triangulate_in_plan(&contour.contour, &params).map_err(|e| e.to_string())
    };
    let results = filler.run(&jobs, &|k| filler.name(holes[k]), &triangulate)?;
    Ok(holes.iter().copied().zip(results.into_iter().map(flat)).collect())
}

type Fitted = Vec<(Vec<u32>, Result<ClusterField, String>)>;

fn fit_all(
    filler: &HoleFiller<'_>,
    clusters: Vec<Vec<u32>>,
    triangulations: &BTreeMap<u32, Triangulation>,
    curves: &Curves,
) -> Result<Fitted, RunError> {
    let fits: Vec<Fit<'_>> =
        clusters.iter().map(|holes| Fit { filler, holes, triangulations, curves }).collect();
    let name = |k: usize| fits[k].name();
    let bytes = measured_bytes(filler, &fits)?;
    let jobs: Vec<Job> = fits.iter().zip(bytes).map(|(fit, bytes)| fit.job(bytes)).collect();
    let results = filler.run(&jobs, &name, &|k| fits[k].fit())?;
    let results: Vec<_> = results.into_iter().map(flat).collect();
    drop(fits);
    Ok(clusters.into_iter().zip(results).collect())
}

/// What each fit needs: an estimate for small clusters; large ones have their systems set up for it.
fn measured_bytes(filler: &HoleFiller<'_>, fits: &[Fit<'_>]) -> Result<Vec<u64>, RunError> {
    let mut bytes: Vec<u64> = fits.iter().map(Fit::estimated_bytes).collect();
    let large: Vec<usize> = (0..fits.len()).filter(|&k| fits[k].places() >= MEASURED_PLACES).collect();
    let measuring = |fit: &Fit<'_>| fit.job(measuring_bytes(fit.places() as u64, &fit.params()));
    let jobs: Vec<Job> = large.iter().map(|&k| measuring(&fits[k])).collect();
    let results = filler.run(&jobs, &|k| fits[large[k]].name(), &|k| fits[large[k]].measured_bytes())?;
    for (&k, result) in large.iter().zip(results) {
        // What cannot be set up fails again when it is solved, with its reason.
        bytes[k] = flat(result).unwrap_or(bytes[k]);
    }
    Ok(bytes)
}

/// The fit of one cluster.
struct Fit<'a> {
    filler: &'a HoleFiller<'a>,
    /// Numbers of the cluster's holes.
    holes: &'a [u32],
    triangulations: &'a BTreeMap<u32, Triangulation>,
    curves: &'a Curves,
}

impl Fit<'_> {
    fn name(&self) -> String {
        let first = self.filler.name(self.holes[0]);
        match self.holes.len() {
            1 => first,
            count => format!("the surface of {count} holes, from {first} on,"),
        }
    }

    fn job(&self, bytes: u64) -> Job {
        Job { key: u64::from(self.holes[0]), bytes: bytes + (1 << 20) }
    }

    fn params(&self) -> FieldParams {
        let max_unknowns = (self.filler.settings_of)(self.holes[0]).max_unknowns;
        FieldParams { max_unknowns, ..FieldParams::default() }
    }

    fn rule(&self) -> WaterRule {
        water_rule((self.filler.settings_of)(self.holes[0]).water)
    }

    /// Places in the region, about.
    fn places(&self) -> f64 {
        let of_hole = |&h: &u32| {
            let behind = RING_PLACES * f64::from(self.filler.plan.holes[h as usize].rim_vertices);
            self.triangulations.get(&h).map_or(0, |t| t.vertices.len() + t.contour_vertices) as f64 + behind
        };
        self.holes.iter().map(of_hole).sum::<f64>().max(2.0)
    }

    fn estimated_bytes(&self) -> u64 {
        (self.places() * (BYTES_A_PLACE + BYTES_A_DOUBLING * self.places().log2())) as u64
    }

    fn measured_bytes(&self) -> Result<u64, String> {
        let filler = self.filler;
        self.with_parts(|parts| {
            field_bytes(filler.surveys, filler.plan, parts, &self.params(), self.rule(), filler.solver)
        })
    }

    fn fit(&self) -> Result<ClusterField, String> {
        let filler = self.filler;
        self.with_parts(|parts| {
            field(filler.surveys, filler.plan, parts, &self.params(), self.rule(), filler.solver)
        })
    }

    /// Calls `work` with the cluster's parts, contours with closing points as the curves have them, not as each tile
    /// rounds them: neighbours must find theirs again.
    fn with_parts<T>(
        &self,
        work: impl FnOnce(&[FieldPart<'_>]) -> Result<T, FieldError>,
    ) -> Result<T, String> {
        let Self { filler, holes, triangulations, curves } = self;
        let exact = |h: u32| {
            let hole = &filler.plan.holes[h as usize];
            contour(filler.surveys, filler.plan, hole, curves, &|p| p).map_err(|e| e.to_string())
        };
        let contours: Vec<CellContour> = holes.iter().map(|&h| exact(h)).collect::<Result<_, _>>()?;
        let parts: Vec<FieldPart<'_>> = holes
            .iter()
            .zip(&contours)
            .filter_map(|(&h, contour)| {
                let hole = &filler.plan.holes[h as usize];
                Some(FieldPart { hole, contour, triangulation: triangulations.get(&h)? })
            })
            .collect();
        work(&parts).map_err(|e| e.to_string())
    }
}

/// What a mode in scene heights says of a cluster.
pub(crate) fn water_rule(mode: WaterMode) -> WaterRule {
    match mode {
        WaterMode::Auto => WaterRule::Auto,
        WaterMode::Off => WaterRule::Off,
        WaterMode::Force => WaterRule::Force,
        WaterMode::Level(z) => WaterRule::Level(z),
        WaterMode::Sloped { from_m, to_m } => WaterRule::Sloped { from_m, to_m },
    }
}

fn flat<T>(result: JobResult<Result<T, String>>) -> Result<T, String> {
    match result {
        JobResult::Done(outcome) => outcome,
        JobResult::Panicked(message) => Err(format!("a fault of the program: {message}")),
        JobResult::Stopped => Err("stopped".to_owned()),
    }
}
