//! Triangles that are there twice, with the same corners in the same direction.

use super::balance::Balance;
use super::flagged::Candidate;
use crate::TriMesh;
use crate::places::{cycle_hash, position_bits};

/// Which candidates repeat an earlier one; ascending.
pub(super) fn duplicates_among(mesh: &TriMesh, balance: &Balance, candidates: &[Candidate]) -> Vec<usize> {
    let keyed = candidates.iter().enumerate().filter_map(|(c, candidate)| {
        let hashes = balance.corner_hashes(mesh.triangles[candidate.face as usize])?;
        Some((cycle_hash(hashes), c as u32))
    });
    let found = repeated(keyed.collect(), |c| corner_cycle(mesh, candidates[c as usize].face));
    found.into_iter().map(|c| c as usize).collect()
}

/// Which triangles of the whole mesh repeat an earlier one; ascending. Takes a sort of all triangles.
pub(super) fn all_duplicates(mesh: &TriMesh, balance: &Balance) -> Vec<u32> {
    let keyed = mesh.triangles.iter().enumerate().filter_map(|(face, &triangle)| {
        let hashes = balance.corner_hashes(triangle)?;
        Some((cycle_hash(hashes), face as u32))
    });
    repeated(keyed.collect(), |face| corner_cycle(mesh, face))
}

/// Of the items with equal keys, those whose cycle an item with a lower number has too; ascending.
fn repeated(mut keyed: Vec<(u64, u32)>, cycle: impl Fn(u32) -> [[u64; 3]; 3]) -> Vec<u32> {
    keyed.sort_unstable();
    let mut found = Vec::new();
    for run in keyed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let mut distinct: Vec<[[u64; 3]; 3]> = Vec::new();
        for &(_, item) in run {
            let own = cycle(item);
            if distinct.contains(&own) {
                found.push(item);
            } else {
                distinct.push(own);
            }
        }
    }
    found.sort_unstable();
    found
}

/// The corners' position bits, rotated so that the smallest comes first.
fn corner_cycle(mesh: &TriMesh, face: u32) -> [[u64; 3]; 3] {
    let mut corners = mesh.corners(face as usize).map(position_bits);
    let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners.rotate_left(first);
    corners
}
