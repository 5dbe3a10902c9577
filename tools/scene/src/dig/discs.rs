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
        let all = (0..faces.len()).filter_map(place);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in all {
            low = [low[0].min(p[0]), low[1].min(p[1])];
            high = [high[0].max(p[0]), high[1].max(p[1])];
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

/// The place moved to the nearest side of its tile with another tile beyond.
fn on_border(tiles: &[TileSketch], tile: usize, place: Place) -> Option<Place> {
    let home = &tiles[tile];
    let mut nearest: Option<(f64, Place)> = None;
    for axis in 0..2 {
        let step = 0.05 * (home.high[axis] - home.low[axis]);
        for (side, outward) in [(home.low[axis], -step), (home.high[axis], step)] {
            let (mut on_side, mut beyond) = (place, place);
            on_side[axis] = side;
            beyond[axis] = side + outward;
            let away = (place[axis] - side).abs();
            let has_other = tiles.iter().enumerate().any(|(k, t)| k != tile && t.contains(beyond));
            if has_other && nearest.is_none_or(|(d, _)| away < d) {
                nearest = Some((away, on_side));
            }
        }
    }
    nearest.map(|(_, on_side)| on_side)
}
