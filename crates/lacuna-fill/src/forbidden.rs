//! Keeps patch edges off edges that the mesh already has.

use crate::FillError;
use crate::plan_mesh::PlanMesh;
use lacuna_mesh::side_of_line;

/// Splits every inner edge that is one of the `forbidden` pairs (smaller vertex first, sorted) at a new vertex in its
/// middle (algorithms E.8), or near it where rounding would turn a triangle over. Nothing is flipped, so no such edge
/// can come back. Returns the number of new vertices.
///
/// # Errors
/// [`FillError::NoTriangulation`] if the two triangles at an edge are too thin to hold a vertex.
pub(crate) fn split_forbidden(mesh: &mut PlanMesh, forbidden: &[[u32; 2]]) -> Result<usize, FillError> {
    let before = mesh.points.len();
    if forbidden.is_empty() {
        return Ok(0);
    }
    for h in 0..mesh.topology.origin.len() as u32 {
        let (a, b) = (mesh.topology.start(h), mesh.topology.end(h));
        let is_forbidden = a < b && forbidden.binary_search(&[a, b]).is_ok();
        if is_forbidden && mesh.topology.twin(h).is_some() {
            split(mesh, h)?;
        }
    }
    Ok(mesh.points.len() - before)
}

fn split(mesh: &mut PlanMesh, h: u32) -> Result<(), FillError> {
    let topology = &mesh.topology;
    let twin = topology.twin[h as usize];
    let ends = [topology.start(h), topology.end(h)];
    let [a, b] = ends.map(|v| mesh.at(v));
    let [c, d] = [h, twin].map(|e| mesh.at(topology.apex(e)));
    for share in [0.0, 0.1, -0.1, 0.3, -0.3] {
        let toward = if share > 0.0 { c } else { d };
        let p = mesh.frame.snap(a.midpoint(b).lerp(toward, f64::abs(share)));
        let is_sound = [(a, p, c), (p, b, c), (b, p, d), (p, a, d)]
            .into_iter()
            .all(|(x, y, z)| side_of_line(x, y, z) > 0.0);
        if is_sound {
            let v = mesh.points.len() as u32;
            mesh.topology.split_edge(h, v);
            mesh.points.push(p);
            mesh.sizes.push(0.5 * (mesh.sizes[ends[0] as usize] + mesh.sizes[ends[1] as usize]));
            return Ok(());
        }
    }
    Err(FillError::NoTriangulation {
        what: format!("edge v{} v{} of the mesh can't be avoided", ends[0], ends[1]),
    })
}
