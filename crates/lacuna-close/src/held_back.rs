//! Which data a fit does not see, to be judged by them.

use crate::plate::Plate;
use crate::sample::{Sample, Spot};

/// One datum in so many is held back alone.
const SCATTERED: usize = 5;
/// Held-back arcs reach this many rim edges from their middles; the next middle is farther than so many times that.
const ARC_EDGES: f64 = 6.0;
const APART: f64 = 3.0;

/// Samples held back one by one among others: they tell noise from shape.
pub(crate) fn scattered(count: usize) -> Vec<usize> {
    (SCATTERED / 2..count).step_by(SCATTERED).collect()
}

/// Samples held back in arcs of the rim and the rings behind it: as far from other data as the inside of a hole is, they
/// tell how far the ground's shape can be continued. `is_wanted` says which places have no datum: arcs do not reach over
/// the hole. `edge_m` is a typical rim edge.
pub(crate) fn arcs(plate: &Plate<'_>, samples: &[Sample], is_wanted: &[bool], edge_m: f64) -> Vec<usize> {
    let mut arcs = Arcs {
        plate,
        is_wanted,
        reach_m: ARC_EDGES * edge_m,
        distance_m: vec![f64::INFINITY; is_wanted.len()],
        seen_by: vec![u32::MAX; is_wanted.len()],
    };
    for sample in samples {
        if let Some(middle) =
            seat(sample, is_wanted).filter(|&v| arcs.distance_m[v as usize] == f64::INFINITY)
        {
            arcs.spread(middle);
        }
    }
    let is_held = |k: &usize| {
        seat(&samples[*k], is_wanted).is_some_and(|v| arcs.distance_m[v as usize] <= arcs.reach_m)
    };
    (0..samples.len()).filter(is_held).collect()
}

/// The place that stands for a sample: of the corners of its triangle that have data the one with the largest share.
fn seat(sample: &Sample, is_wanted: &[bool]) -> Option<u32> {
    let Spot { corners, shares } = sample.spot;
    let with_data = (0..3).filter(|&k| !is_wanted[corners[k] as usize]);
    // `max_by` takes the last of equals; reversed, that is the first.
    with_data.rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b])).map(|k| corners[k])
}

struct Arcs<'a> {
    plate: &'a Plate<'a>,
    is_wanted: &'a [bool],
    reach_m: f64,
    /// Of each place from the nearest middle that reaches it over places with data.
    distance_m: Vec<f64>,
    /// The last middle that came by.
    seen_by: Vec<u32>,
}

impl Arcs<'_> {
    fn spread(&mut self, middle: u32) {
        let Self { plate, is_wanted, reach_m, .. } = *self;
        let mut front = vec![middle];
        self.seen_by[middle as usize] = middle;
        self.distance_m[middle as usize] = 0.0;
        while let Some(v) = front.pop() {
            for &u in plate.fans.of(v).iter().flat_map(|&t| &plate.triangles[t as usize]) {
                let far_m = plate.places[u as usize].distance(plate.places[middle as usize]);
                let is_new = self.seen_by[u as usize] != middle;
                if is_new && !is_wanted[u as usize] && far_m <= APART * reach_m {
                    self.seen_by[u as usize] = middle;
                    self.distance_m[u as usize] = self.distance_m[u as usize].min(far_m);
                    front.push(u);
                }
            }
        }
    }
}
