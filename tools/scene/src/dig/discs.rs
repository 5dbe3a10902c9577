//! Where to dig.

use super::faces::TileFaces;
use super::{DigError, DigOptions};
use crate::random::Rng;
use crate::shape::Place;

/// A disc in plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre, metres, in the files' frame.
    pub centre: Place,
    /// Its radius, metres.
    pub radius_m: f64,
}

impl Disc {
    /// True if the place lies in the disc.
    #[must_use]
    pub fn contains(&self, place: Place) -> bool {
        distance(self.centre, place) < self.radius_m
    }
}

fn distance(a: Place, b: Place) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    (dx * dx + dy * dy).sqrt()
}

/// Places looked at on every tile.
const SAMPLES: usize = 64;
/// Tries for each disc.
const TRIES: usize = 400;

/// A tile's box and some places on its surface.
#[derive(Clone, Debug)]
pub(super) struct TileSketch {
    low: Place,
    high: Place,
    places: Vec<Place>,
}

impl TileSketch {
    /// The sketch of a tile; `key` chooses the places.
    pub(super) fn of(faces: &TileFaces, key: &[i64]) -> Self {
        let mut rng = Rng::new(key);
        let place = |face: usize| faces.centroid(face).map(|[x, y, _]| [x, y]);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [x, y, _] in faces.positions.iter().filter(|p| p.iter().all(|k| k.is_finite())) {
            low = [low[0].min(*x), low[1].min(*y)];
            high = [high[0].max(*x), high[1].max(*y)];
        }
        let places = (0..SAMPLES)
            .filter_map(|_| place(rng.below(faces.len().max(1)).min(faces.len().checked_sub(1)?)));
        Self { low, high, places: places.collect() }
    }

    fn contains(&self, place: Place) -> bool {
        (0..2).all(|k| self.low[k] <= place[k] && place[k] <= self.high[k])
    }
}

/// Chooses discs that keep half a largest radius between them.
///
/// Centres lie on random places of random tiles: for `across_borders` moved to the middle of the nearest side beyond
/// which another tile lies, else so far inside that the disc stays in the tile.
pub(super) fn choose(tiles: &[TileSketch], options: &DigOptions) -> Result<Vec<Disc>, DigError> {
    let mut rng = Rng::new(&[options.seed as i64, 0x6469_6773]);
    let mut discs: Vec<Disc> = Vec::new();
    for _ in 0..TRIES * options.discs {
        if discs.len() == options.discs {
            break;
        }
        let radius_m = rng.within(options.radius_m[0], options.radius_m[1].next_up());
        let tile = rng.below(tiles.len());
        let Some(&place) = tiles[tile].places.get(rng.below(SAMPLES)) else { continue };
        let centre = if options.across_borders {
            on_border(tiles, tile, place)
        } else {
            inside(&tiles[tile], place, radius_m)
        };
        let Some(centre) = centre else { continue };
        let gap_m = options.radius_m[1] / 2.0;
        if discs.iter().all(|d| distance(d.centre, centre) > d.radius_m + radius_m + gap_m) {
            discs.push(Disc { centre, radius_m });
        }
    }
    let found = discs.len();
    if found < options.discs { Err(DigError::NoRoom { found, wanted: options.discs }) } else { Ok(discs) }
}

fn inside(tile: &TileSketch, place: Place, radius_m: f64) -> Option<Place> {
    let fits = (0..2).all(|k| tile.low[k] + radius_m < place[k] && place[k] + radius_m < tile.high[k]);
    fits.then_some(place)
}

/// The place moved to the nearest side of its tile with another tile beyond: to the middle of the strip that both
/// cover, if they overlap.
fn on_border(tiles: &[TileSketch], tile: usize, place: Place) -> Option<Place> {
    let home = &tiles[tile];
    let mut nearest: Option<(f64, Place)> = None;
    for axis in 0..2 {
        let step = 0.05 * (home.high[axis] - home.low[axis]);
        for (side, outward) in [(home.low[axis], -step), (home.high[axis], step)] {
            let mut beyond = place;
            beyond[axis] = side + outward;
            let Some(other) = (0..tiles.len()).find(|&k| k != tile && tiles[k].contains(beyond)) else {
                continue;
            };
            let opposite = if outward < 0.0 { tiles[other].high[axis] } else { tiles[other].low[axis] };
            let mut on_border = place;
            on_border[axis] = (side + opposite) / 2.0;
            let away = (place[axis] - side).abs();
            if nearest.is_none_or(|(least, _)| away < least) {
                nearest = Some((away, on_border));
            }
        }
    }
    nearest.map(|(_, on_border)| on_border)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sketch(low: Place, high: Place) -> TileSketch {
        TileSketch { low, high, places: vec![[(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0 + 1.0]] }
    }

    #[test]
    fn border_discs_lie_in_the_middle_of_the_overlap() {
        let tiles = [sketch([-0.1, -0.1], [100.1, 100.1]), sketch([99.9, -0.1], [200.1, 100.1])];
        assert_eq!(on_border(&tiles, 0, [60.0, 30.0]), Some([100.0, 30.0]));
        assert_eq!(on_border(&tiles, 1, [180.0, 70.0]), Some([100.0, 70.0]));
        assert_eq!(on_border(&tiles[..1], 0, [60.0, 30.0]), None);
    }

    #[test]
    fn discs_that_find_no_room_are_an_error() {
        let tiles = [sketch([0.0, 0.0], [100.0, 100.0])];
        let options = DigOptions { discs: 2, radius_m: [10.0, 10.0], across_borders: false, seed: 1 };
        assert!(matches!(choose(&tiles, &options), Err(DigError::NoRoom { found: 1, wanted: 2 })));
    }
}
