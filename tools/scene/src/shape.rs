//! Planar shapes, metres, in the frame of the scene before it is turned or shifted.

use crate::random::Rng;

/// A place in plan, metres.
pub type Place = [f64; 2];

/// A shape in plan.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A disc with a wavy rim.
    Blob(Blob),
    /// Everything within half a width of a polyline.
    Band {
        /// The middle line.
        line: Vec<Place>,
        /// Half the width, metres.
        half_width_m: f64,
    },
}

/// A disc whose radius wavers with the direction: `r(t) = radius * (1 + sum of amplitude * cos(order * t + phase))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Blob {
    centre: Place,
    radius_m: f64,
    waves: Vec<Wave>,
}

#[derive(Clone, Debug, PartialEq)]
struct Wave {
    order: u32,
    cosine: f64,
    sine: f64,
}

/// Orders of a blob's waves: not 1, which would move the centre.
const ORDERS: [u32; 3] = [2, 3, 5];

impl Blob {
    /// A blob whose area is that of the disc of the given radius.
    ///
    /// `waviness` is the largest relative change of the radius; the waves share it.
    #[must_use]
    pub fn new(centre: Place, radius_m: f64, waviness: f64, rng: &mut Rng) -> Self {
        let waves: Vec<Wave> = ORDERS
            .map(|order| {
                let phase = rng.within(0.0, std::f64::consts::TAU);
                let amplitude = waviness / ORDERS.len() as f64;
                Wave { order, cosine: amplitude * libm::cos(phase), sine: amplitude * libm::sin(phase) }
            })
            .into();
        let swelling: f64 = waves.iter().map(|w| (w.cosine * w.cosine + w.sine * w.sine) / 2.0).sum();
        Self { centre, radius_m: radius_m / (1.0 + swelling).sqrt(), waves }
    }

    /// Radius in a direction given by its cosine and sine.
    fn radius_towards_m(&self, cosine: f64, sine: f64) -> f64 {
        let mut power = (1.0, 0.0);
        let mut order = 0;
        let mut factor = 1.0;
        for wave in &self.waves {
            while order < wave.order {
                power = (power.0 * cosine - power.1 * sine, power.0 * sine + power.1 * cosine);
                order += 1;
            }
            factor += wave.cosine * power.0 - wave.sine * power.1;
        }
        self.radius_m * factor
    }

    fn largest_radius_m(&self) -> f64 {
        self.radius_m * (1.0 + self.waves.iter().map(|w| w.cosine.abs() + w.sine.abs()).sum::<f64>())
    }

    fn contains(&self, place: Place) -> bool {
        let (dx, dy) = (place[0] - self.centre[0], place[1] - self.centre[1]);
        let distance = (dx * dx + dy * dy).sqrt();
        if distance > self.largest_radius_m() {
            return false;
        }
        distance == 0.0 || distance < self.radius_towards_m(dx / distance, dy / distance)
    }

    fn outline(&self) -> Vec<Place> {
        const CORNERS: u32 = 96;
        (0..CORNERS)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
                let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
                let r = self.radius_towards_m(cosine, sine);
                [self.centre[0] + r * cosine, self.centre[1] + r * sine]
            })
            .collect()
    }
}

impl Shape {
    /// True if the place lies in the shape.
    #[must_use]
    pub fn contains(&self, place: Place) -> bool {
        match self {
            Self::Blob(blob) => blob.contains(place),
            Self::Band { line, half_width_m } => line
                .windows(2)
                .any(|w| squared_distance_to_segment(place, w[0], w[1]) < half_width_m * half_width_m),
        }
    }

    /// Corners of the lowest and highest place the shape may reach.
    #[must_use]
    pub fn bounds(&self) -> [Place; 2] {
        match self {
            Self::Blob(b) => {
                let reach = b.largest_radius_m();
                [[b.centre[0] - reach, b.centre[1] - reach], [b.centre[0] + reach, b.centre[1] + reach]]
            }
            Self::Band { line, half_width_m } => {
                let lowest =
                    |axis: usize| line.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - half_width_m;
                let highest = |axis: usize| {
                    line.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + half_width_m
                };
                [[lowest(0), lowest(1)], [highest(0), highest(1)]]
            }
        }
    }

    /// The shape's outline as a polygon, counter-clockwise, close to the shape itself.
    #[must_use]
    pub fn outline(&self) -> Vec<Place> {
        match self {
            Self::Blob(blob) => blob.outline(),
            Self::Band { line, half_width_m } => {
                let back: Vec<Place> = line.iter().rev().copied().collect();
                let mut outline = right_bank(line, *half_width_m);
                outline.extend(right_bank(&back, *half_width_m));
                outline
            }
        }
    }
}

fn squared_distance_to_segment(p: Place, a: Place, b: Place) -> f64 {
    let (ux, uy) = (b[0] - a[0], b[1] - a[1]);
    let (vx, vy) = (p[0] - a[0], p[1] - a[1]);
    let length = ux * ux + uy * uy;
    let share = if length > 0.0 { ((ux * vx + uy * vy) / length).clamp(0.0, 1.0) } else { 0.0 };
    let (dx, dy) = (vx - share * ux, vy - share * uy);
    dx * dx + dy * dy
}

/// The bank to the right of a line from its first to its last point, with a half-round cap at the end.
fn right_bank(line: &[Place], half_width_m: f64) -> Vec<Place> {
    const CAP: u32 = 8;
    let mut bank = Vec::new();
    let mut last = [1.0, 0.0];
    for k in 0..line.len() {
        let (before, after) = (line[k.saturating_sub(1)], line[(k + 1).min(line.len() - 1)]);
        let (dx, dy) = (after[0] - before[0], after[1] - before[1]);
        let length = (dx * dx + dy * dy).sqrt().max(f64::MIN_POSITIVE);
        last = [dx / length, dy / length];
        bank.push([line[k][0] + last[1] * half_width_m, line[k][1] - last[0] * half_width_m]);
    }
    let end = line[line.len() - 1];
    for step in 1..CAP {
        let angle = std::f64::consts::PI * f64::from(step) / f64::from(CAP);
        let (c, s) = (libm::cos(angle) * half_width_m, libm::sin(angle) * half_width_m);
        bank.push([end[0] + last[1] * c + last[0] * s, end[1] - last[0] * c + last[1] * s]);
    }
    bank
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon_area(ring: &[Place]) -> f64 {
        let n = ring.len();
        (0..n).map(|k| ring[k][0] * ring[(k + 1) % n][1] - ring[(k + 1) % n][0] * ring[k][1]).sum::<f64>()
            / 2.0
    }

    fn sampled_area(shape: &Shape) -> f64 {
        let [low, high] = shape.bounds();
        let step = 0.25;
        let (w, h) = (((high[0] - low[0]) / step) as i64, ((high[1] - low[1]) / step) as i64);
        let hits = (0..w * h)
            .filter(|k| shape.contains([low[0] + (k % w) as f64 * step, low[1] + (k / w) as f64 * step]))
            .count();
        hits as f64 * step * step
    }

    #[test]
    fn a_blob_has_its_discs_area_and_its_outline_encloses_the_same() {
        for seed in 1..=5 {
            let shape = Shape::Blob(Blob::new([10.0, -20.0], 30.0, 0.2, &mut Rng::new(&[seed])));
            let disc = std::f64::consts::PI * 900.0;
            assert!((sampled_area(&shape) / disc - 1.0).abs() < 0.01, "{}", sampled_area(&shape));
            assert!((polygon_area(&shape.outline()) / disc - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_band_has_round_ends_and_an_outline_of_the_same_area() {
        let shape = Shape::Band { line: vec![[0.0, 0.0], [40.0, 5.0], [80.0, 0.0]], half_width_m: 6.0 };
        assert!(shape.contains([-5.9, 0.0]) && !shape.contains([-6.1, 0.0]) && !shape.contains([-5.0, 5.0]));
        let area = sampled_area(&shape);
        assert!((polygon_area(&shape.outline()) / area - 1.0).abs() < 0.02, "{area}");
    }
}
