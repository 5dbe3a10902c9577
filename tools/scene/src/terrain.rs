//! Heights: a sum of seeded waves, and buildings that keep away from holes.

use crate::area::Cell;
use crate::hole::Hole;
use crate::lattice::UNITS_PER_M;
use crate::plan::Plan;
use crate::random::Rng;

/// Number of waves.
const WAVES: usize = 10;
/// Longest and shortest wave, in cell sides.
const WAVELENGTHS: [f64; 2] = [4.0, 0.4];
/// Mean height, metres.
const GROUND_M: f64 = 20.0;

/// The terrain of a scene; a pure function of the place.
#[derive(Clone, Debug)]
pub struct Terrain {
    waves: Vec<Wave>,
}

#[derive(Clone, Debug)]
struct Wave {
    turns_per_m: [f64; 2],
    start_turns: f64,
    amplitude_m: f64,
}

impl Terrain {
    /// The terrain for a plan and a seed: amplitudes grow with the wavelength (equal slopes) and add up to 0.7 of the
    /// relief, so that heights usually span the relief.
    #[must_use]
    pub fn new(plan: &Plan, seed: i64) -> Self {
        let mut rng = Rng::new(&[seed, 0x7465_7272]);
        let ratio = libm::pow(WAVELENGTHS[1] / WAVELENGTHS[0], 1.0 / (WAVES - 1) as f64);
        let lengths: Vec<f64> = (0..WAVES).map(|k| WAVELENGTHS[0] * libm::pow(ratio, k as f64)).collect();
        let total: f64 = lengths.iter().sum();
        let waves = lengths
            .iter()
            .map(|length| {
                let heading = rng.within(0.0, std::f64::consts::TAU);
                let length_m = length * plan.cell_size_m;
                Wave {
                    turns_per_m: [libm::cos(heading) / length_m, libm::sin(heading) / length_m],
                    start_turns: rng.unit(),
                    amplitude_m: 0.7 * plan.relief_m * length / total,
                }
            })
            .collect();
        Self { waves }
    }

    /// Height at a place, metres; `x` and `y` in metres.
    #[must_use]
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        let wave = |w: &Wave| {
            w.amplitude_m * sine_of_turns(w.turns_per_m[0] * x + w.turns_per_m[1] * y + w.start_turns)
        };
        GROUND_M + self.waves.iter().map(wave).sum::<f64>()
    }
}

/// sin(2 pi t) to 1e-7, from products and sums alone: the same bits everywhere, and several times faster than a general
/// sine, which would take most of a scene's time. |t| must stay below 2^50.
fn sine_of_turns(t: f64) -> f64 {
    /// Adding and taking away 1.5 * 2^52 rounds to the nearest integer.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let t = t - ((t + ROUNDER) - ROUNDER);
    let folded = if t.abs() > 0.25 { 0.5_f64.copysign(t) - t } else { t };
    let x = folded * std::f64::consts::TAU;
    let q = x * x;
    let tail = q * (1.0 / 110.0 - q / (110.0 * 156.0));
    x * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - tail)))))
}

/// A flat-roofed block: every vertex on its ground plan stands at roof height, so walls are one lattice step wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Building {
    low: [f64; 2],
    high: [f64; 2],
    roof_m: f64,
}

impl Building {
    /// Roof height above sea if the place is on the ground plan.
    #[must_use]
    pub fn roof_at(&self, x: f64, y: f64) -> Option<f64> {
        let inside = self.low[0] <= x && x <= self.high[0] && self.low[1] <= y && y <= self.high[1];
        inside.then_some(self.roof_m)
    }
}

/// The buildings of a cell: away from its border, and from all holes by `clearance_m`.
#[must_use]
pub fn buildings(
    plan: &Plan,
    terrain: &Terrain,
    cell: Cell,
    wanted: u32,
    clearance_m: f64,
    seed: i64,
) -> Vec<Building> {
    let mut rng = Rng::new(&[seed, 0x686f_7573, cell[0], cell[1]]);
    (0..wanted)
        .map(|_| {
            let size = plan.cell_size_m;
            let middle = [0, 1].map(|k| (cell[k] as f64 + rng.within(0.2, 0.8)) * size);
            let half = [0, 1].map(|_| rng.within(0.04, 0.1) * size);
            let storeys = 2 + rng.below(8);
            let roof_m = terrain.height_m(middle[0], middle[1]).round() + 3.0 * storeys as f64;
            Building {
                low: [0, 1].map(|k| middle[k] - half[k]),
                high: [0, 1].map(|k| middle[k] + half[k]),
                roof_m,
            }
        })
        .filter(|b| plan.holes.iter().all(|h| !touches(h, b, clearance_m, plan.cell_size_m)))
        .collect()
}

/// True if the hole may come nearer to the building than `clearance_m` (its parts' boxes are looked at).
fn touches(hole: &Hole, building: &Building, clearance_m: f64, cell_size_m: f64) -> bool {
    let low = building.low.map(|k| k - clearance_m);
    let high = building.high.map(|k| k + clearance_m);
    hole.may_touch(low, high, cell_size_m)
}

/// Height in lattice units: roofs over terrain.
#[must_use]
pub fn height_units(terrain: &Terrain, buildings: &[Building], node: [i64; 2]) -> i64 {
    let [x, y] = node.map(|k| k as f64 / UNITS_PER_M);
    let roof = buildings
        .iter()
        .filter_map(|b| b.roof_at(x, y))
        .fold(None, |a: Option<f64>, b| Some(a.map_or(b, |a| a.max(b))));
    (roof.unwrap_or_else(|| terrain.height_m(x, y)) * UNITS_PER_M).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_sine_is_a_sine() {
        for k in -4000..4000 {
            let t = f64::from(k) * 0.01237;
            let error = sine_of_turns(t) - libm::sin(t * std::f64::consts::TAU);
            assert!(error.abs() < 1e-7, "{t}: {error}");
        }
    }
}
