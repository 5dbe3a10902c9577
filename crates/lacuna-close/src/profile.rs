//! Heights along a border as a function of one coordinate: binned candidates, linear in between.

/// A candidate height: coordinate along the border, height, distance of the vertex it comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) along_m: f64,
    pub(crate) height_m: f64,
    pub(crate) distance_m: f64,
}

/// Piecewise linear heights over one coordinate, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Profile {
    knots: Vec<(f64, f64)>,
}

impl Profile {
    /// Keeps in every bin of `bin_m` the candidate from the nearest vertex (ties: the first by coordinate, then height),
    /// so that a ragged rim gives one height a place.
    pub(crate) fn from_candidates(mut candidates: Vec<Candidate>, low_m: f64, bin_m: f64) -> Self {
        let bin = |c: &Candidate| ((c.along_m - low_m) / bin_m.max(1e-9)).floor() as i64;
        candidates.sort_by(|a, b| {
            bin(a)
                .cmp(&bin(b))
                .then(a.distance_m.total_cmp(&b.distance_m))
                .then(a.along_m.total_cmp(&b.along_m))
                .then(a.height_m.total_cmp(&b.height_m))
        });
        candidates.dedup_by_key(|c| bin(c));
        let mut knots: Vec<(f64, f64)> = candidates.iter().map(|c| (c.along_m, c.height_m)).collect();
        knots.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { knots }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.knots.is_empty()
    }

    /// Adds a height that is known exactly, in place of what lies within `reach_m` of it.
    pub(crate) fn pin(&mut self, along_m: f64, height_m: f64, reach_m: f64) {
        self.knots.retain(|k| (k.0 - along_m).abs() > reach_m);
        let at = self.knots.partition_point(|k| k.0 < along_m);
        self.knots.insert(at, (along_m, height_m));
    }

    /// Height at a coordinate; constant beyond the ends. `None` without any knot.
    pub(crate) fn at(&self, along_m: f64) -> Option<f64> {
        let after = self.knots.partition_point(|k| k.0 < along_m);
        let (first, last) = (self.knots.first()?, self.knots.last()?);
        if after == 0 {
            return Some(first.1);
        }
        let Some(high) = self.knots.get(after) else { return Some(last.1) };
        let low = self.knots[after - 1];
        let t = (along_m - low.0) / (high.0 - low.0);
        Some(low.1 + t * (high.1 - low.1))
    }

    /// Union of the knots of both, heights the mean of both profiles there.
    pub(crate) fn mean(&self, other: &Self) -> Self {
        if self.is_empty() {
            return other.clone();
        }
        if other.is_empty() {
            return self.clone();
        }
        let mut along: Vec<f64> = self.knots.iter().chain(&other.knots).map(|k| k.0).collect();
        along.sort_by(f64::total_cmp);
        along.dedup();
        let height = |t: f64| Some((self.at(t)? + other.at(t)?) / 2.0);
        Self { knots: along.into_iter().filter_map(|t| Some((t, height(t)?))).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(along_m: f64, height_m: f64, distance_m: f64) -> Candidate {
        Candidate { along_m, height_m, distance_m }
    }

    #[test]
    fn the_nearest_vertex_of_a_bin_wins() {
        let all = vec![candidate(0.2, 5.0, 3.0), candidate(0.7, 1.0, 2.0), candidate(1.5, 2.0, 9.0)];
        let profile = Profile::from_candidates(all, 0.0, 1.0);
        assert_eq!(profile.knots, [(0.7, 1.0), (1.5, 2.0)]);
    }

    #[test]
    fn heights_are_linear_between_and_constant_beyond() {
        let mut p = Profile::default();
        p.pin(0.0, 0.0, 0.0);
        p.pin(10.0, 20.0, 0.0);
        assert_eq!([-5.0, 2.5, 99.0].map(|t| p.at(t)), [Some(0.0), Some(5.0), Some(20.0)]);
        assert_eq!(Profile::default().at(0.0), None);
    }

    #[test]
    fn the_mean_is_symmetric() {
        let mut a = Profile::default();
        a.pin(0.0, 0.0, 0.0);
        a.pin(4.0, 4.0, 0.0);
        let mut b = Profile::default();
        b.pin(1.0, 3.0, 0.0);
        assert_eq!(a.mean(&b), b.mean(&a));
        assert_eq!(a.mean(&b).at(1.0), Some(2.0));
    }
}
