//! Known heights at places of a triangulation.

use lacuna_solve::Triplet;

/// A place in a triangle: its corners and their shares, which sum to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    pub(crate) corners: [u32; 3],
    pub(crate) shares: [f64; 3],
}

impl Spot {
    /// A vertex.
    pub(crate) fn vertex(v: u32) -> Self {
        Self { corners: [v; 3], shares: [1.0, 0.0, 0.0] }
    }

    /// The piecewise linear surface with heights `z` there.
    pub(crate) fn height(&self, z: &[f64]) -> f64 {
        (0..3).map(|k| self.shares[k] * z[self.corners[k] as usize]).sum()
    }
}

/// A known height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) spot: Spot,
    /// Metres.
    pub(crate) height_m: f64,
    /// What a squared residual counts before robust weights: weight times area, square metres.
    pub(crate) mass_m2: f64,
}

impl Sample {
    /// Signed distance of a surface from the datum, metres.
    pub(crate) fn residual_m(&self, z: &[f64]) -> f64 {
        self.spot.height(z) - self.height_m
    }

    /// The entries of `weight * (surface at the spot)^2`, each pair once.
    pub(crate) fn entries(&self, weight: f64) -> impl Iterator<Item = Triplet> + use<> {
        let Spot { corners, shares } = self.spot;
        let pairs = [(0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1)];
        pairs.into_iter().map(move |(a, b)| (a, b, weight * shares[a] * shares[b])).filter_map(
            move |(a, b, value)| {
                let is_there = shares[a] != 0.0 && shares[b] != 0.0;
                is_there.then_some(Triplet { row: corners[a], column: corners[b], value })
            },
        )
    }
}
