//! Triangles that are there more often than they should be.

use super::balance::Balance;
use super::flagged::Candidate;
use crate::TriMesh;
use crate::places::{position_bits, triple_hash};

/// Which candidates repeat an earlier one; ascending.
pub(super) fn duplicates_among(mesh: &TriMesh, balance: &Balance, candidates: &[Candidate]) -> Vec<usize> {
    let keyed = candidates.iter().enumerate().filter_map(|(c, candidate)| {
        let hashes = balance.corner_hashes(mesh.triangles[candidate.face as usize])?;
        Some((triple_hash(hashes), c as u32))
    });
    let found = repeated(keyed.collect(), |c| Corners::of(mesh, candidates[c as usize].face));
    found.into_iter().map(|c| c as usize).collect()
}

/// Which triangles of the whole mesh repeat an earlier one; ascending. Takes a sort of all triangles.
pub(super) fn all_duplicates(mesh: &TriMesh, balance: &Balance) -> Vec<u32> {
    let keyed = mesh.triangles.iter().enumerate().filter_map(|(face, &triangle)| {
        let hashes = balance.corner_hashes(triangle)?;
        Some((triple_hash(hashes), face as u32))
    });
    repeated(keyed.collect(), |face| Corners::of(mesh, face))
}

/// Of the items with equal keys, those beyond one more than run the other way round; ascending. The first ones stay.
fn repeated(mut keyed: Vec<(u64, u32)>, corners: impl Fn(u32) -> Corners) -> Vec<u32> {
    keyed.sort_unstable();
    let mut found = Vec::new();
    for run in keyed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let mut same: Vec<(Corners, u32)> = run.iter().map(|&(_, item)| (corners(item), item)).collect();
        same.sort_unstable();
        for same in same.chunk_by(|a, b| a.0.places == b.0.places) {
            let (one_way, other_way) = same.split_at(same.partition_point(|item| !item.0.is_reversed));
            found.extend(superfluous(one_way, other_way.len()));
            found.extend(superfluous(other_way, one_way.len()));
        }
    }
    found.sort_unstable();
    found
}

/// A pair that runs both ways is balanced and stays (a sheet of no thickness); of what is more, one stays.
fn superfluous(items: &[(Corners, u32)], reversed: usize) -> impl Iterator<Item = u32> + '_ {
    items.iter().skip(reversed + 1).map(|item| item.1)
}

/// The places of a triangle, whatever its first corner and its direction, and that direction.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Corners {
    /// Position bits, ascending.
    places: [[u64; 3]; 3],
    /// The triangle runs through them downward.
    is_reversed: bool,
}

impl Corners {
    fn of(mesh: &TriMesh, face: u32) -> Self {
        let mut places = mesh.corners(face as usize).map(position_bits);
        let first = (0..3).min_by_key(|&i| places[i]).unwrap_or(0);
        places.rotate_left(first);
        let is_reversed = places[1] > places[2];
        places.sort_unstable();
        Self { places, is_reversed }
    }
}
