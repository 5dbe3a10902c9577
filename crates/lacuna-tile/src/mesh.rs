//! What every text and row format does to a mesh after reading.

use crate::types::UpAxis;
use glam::DVec3;
use lacuna_mesh::TriMesh;

/// Turns positions of a file with this up axis into scene positions (z up). Bits are only moved, never computed.
pub(crate) fn turn_to_scene(positions: &mut [DVec3], up_axis: UpAxis) {
    if up_axis == UpAxis::Y {
        for p in positions {
            *p = DVec3::new(p.x, -p.z, p.y);
        }
    }
}

/// Takes out the triangles that touch a non-finite position (the positions stay, so that indices hold), and says so.
pub(crate) fn drop_non_finite(mesh: &mut TriMesh) -> Vec<String> {
    let TriMesh { positions, triangles } = mesh;
    let broken = positions.iter().filter(|p| !p.is_finite()).count();
    if broken == 0 {
        return Vec::new();
    }
    let before = triangles.len();
    triangles.retain(|t| t.iter().all(|&v| positions[v as usize].is_finite()));
    let dropped = before - triangles.len();
    vec![format!("{broken} vertices are not finite; {dropped} triangles that touch them are left out")]
}
