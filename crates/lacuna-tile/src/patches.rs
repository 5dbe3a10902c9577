//! What all writers need to know about the patches of one tile.

use crate::error::TileError;
use crate::types::{Corner, HolePatch, VertexFrame};
use glam::DVec3;
use std::collections::BTreeSet;
use std::path::Path;

/// Checks every patch against a tile of `original_vertices` vertices: corners exist, no triangle names one twice,
/// positions are finite.
///
/// # Errors
/// `BadPatch`.
pub(crate) fn check_patches(
    path: &Path,
    patches: &[HolePatch],
    original_vertices: u64,
) -> Result<(), TileError> {
    patches.iter().try_for_each(|patch| {
        check_patch(patch, original_vertices).map_err(|problem| TileError::BadPatch {
            path: path.to_owned(),
            hole: patch.hole.clone(),
            problem,
        })
    })
}

fn check_patch(patch: &HolePatch, original_vertices: u64) -> Result<(), String> {
    if let Some(k) = patch.vertices.iter().position(|p| !p.is_finite()) {
        return Err(format!("new vertex {k} is not finite"));
    }
    for (k, triangle) in patch.triangles.iter().enumerate() {
        let [a, b, c] = triangle;
        if a == b || b == c || c == a {
            return Err(format!("triangle {k} names a corner twice"));
        }
        for corner in triangle {
            let (index, count) = match corner {
                Corner::Original(v) => (u64::from(v.0), original_vertices),
                Corner::New(k) => (u64::from(*k), patch.vertices.len() as u64),
            };
            if index >= count {
                return Err(format!("triangle {k} has the corner {corner:?}, but there are {count}"));
            }
        }
    }
    Ok(())
}

/// New vertices of all patches.
pub(crate) fn count_vertices(patches: &[HolePatch]) -> u64 {
    patches.iter().map(|p| p.vertices.len() as u64).sum()
}

/// Triangles of all patches.
pub(crate) fn count_triangles(patches: &[HolePatch]) -> u64 {
    patches.iter().map(|p| p.triangles.len() as u64).sum()
}

/// The tile's own vertices that a patch joins, ascending.
pub(crate) fn original_corners(patch: &HolePatch) -> Vec<u32> {
    let corners = patch.triangles.iter().flatten();
    let originals = corners.filter_map(|c| match c {
        Corner::Original(v) => Some(v.0),
        Corner::New(_) => None,
    });
    originals.collect::<BTreeSet<u32>>().into_iter().collect()
}

/// A patch in the file's frame, with unit normals from its own triangles.
pub(crate) struct FilePatch {
    /// Normals of `originals`, in their order.
    pub(crate) original_normals: Vec<DVec3>,
    /// Coordinates of the new vertices as the file stores them.
    pub(crate) vertices: Vec<DVec3>,
    /// Normals of the new vertices.
    pub(crate) normals: Vec<DVec3>,
}

/// Turns a patch into the file's frame and computes its vertex normals: the sum of the normals of the triangles round a
/// vertex, weighted by their areas; up where that sum is nothing. `originals` are the ids of `original_corners`,
/// `original_positions` their coordinates in the file's frame.
pub(crate) fn to_file_frame(
    patch: &HolePatch,
    frame: &VertexFrame,
    originals: &[u32],
    original_positions: &[DVec3],
) -> FilePatch {
    let vertices: Vec<DVec3> = patch.vertices.iter().map(|&p| frame.to_file(p)).collect();
    let slot = |corner: &Corner| match corner {
        Corner::Original(v) => originals.binary_search(&v.0).unwrap_or(0), // found: the ids come from these triangles
        Corner::New(k) => originals.len() + *k as usize,
    };
    let all: Vec<DVec3> = original_positions.iter().chain(&vertices).copied().collect();
    let mut sums = vec![DVec3::ZERO; all.len()];
    for triangle in &patch.triangles {
        let [a, b, c] = [slot(&triangle[0]), slot(&triangle[1]), slot(&triangle[2])];
        let weighted = (all[b] - all[a]).cross(all[c] - all[a]);
        for corner in [a, b, c] {
            sums[corner] += weighted;
        }
    }
    let up = frame.to_scene.matrix3.inverse() * DVec3::Z;
    let mut normals: Vec<DVec3> = sums.iter().map(|n| n.normalize_or(up)).collect();
    let new_normals = normals.split_off(originals.len());
    FilePatch { original_normals: normals, vertices, normals: new_normals }
}

/// Text that can stand in a comment: control characters (line ends first of all) become `_`.
pub(crate) fn comment_text(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '_' } else { c }).collect()
}
