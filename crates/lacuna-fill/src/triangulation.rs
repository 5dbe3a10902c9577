//! A patch in two steps: its triangles in plan first, its heights when somebody knows them.

use crate::fill::{check_direction, check_input, finish, pockets_from_above};
use crate::frame::Frame;
use crate::lift::{Lifted, mesh_in_frame, with_pockets};
use crate::weld::weld;
use crate::{FillError, FillParams, Filled, Filler};
use glam::DVec2;
use lacuna_mesh::{Contour, Patch};

/// A patch without heights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangulation {
    /// Number of the contour's vertices.
    pub contour_vertices: usize,
    /// Places of the new vertices, metres.
    pub vertices: Vec<DVec2>,
    /// Triangles numbered as in a [`Patch`], counter-clockwise from above but for the pockets.
    pub triangles: Vec<[u32; 3]>,
    /// Indices of pocket triangles: vertical or overhanging pieces of the rim. Ascending, the last ones.
    pub vertical: Vec<u32>,
}

impl Triangulation {
    /// The triangles that are judged from above: all but the pockets.
    #[must_use]
    pub fn in_plan(&self) -> &[[u32; 3]] {
        &self.triangles[..self.triangles.len() - self.vertical.len()]
    }
}

/// Triangulates a contour seen from above (algorithms E.2, E.3): pockets cut where the view is trusted, constrained Delaunay,
/// refined to the wanted density, smoothed in plan. The filler in `params` is not asked.
///
/// # Errors
/// [`FillError`], above all if the contour can't be seen from above; [`crate::fill`] may still take it.
pub fn triangulate_in_plan(contour: &Contour, params: &FillParams) -> Result<Triangulation, FillError> {
    let triangulate = || {
        check_input(contour, params)?;
        check_direction(contour)?;
        let pockets = pockets_from_above(contour).ok_or(FillError::UprightRim)?;
        let rim = weld(contour)?;
        let frame = Frame::plan(&contour.positions());
        let (mesh, plan) = mesh_in_frame(&rim, frame, pockets, params)?;
        let world = |p: &DVec2| frame.world(p.extend(0.0)).truncate();
        let vertices = mesh.points[mesh.fixed..].iter().map(world).collect();
        let (triangles, vertical) = with_pockets(mesh.topology.triangles(), &plan.pockets);
        Ok(Triangulation { contour_vertices: contour.len(), vertices, triangles, vertical })
    };
    triangulate().map_err(|e: FillError| e.with_place(contour))
}

/// Gives a triangulation of `contour` the heights of its new vertices, metres, and checks the patch.
///
/// # Errors
/// [`FillError::Malformed`] if the contour has more or fewer vertices than the triangulated one, or there are more or fewer
/// heights than new vertices; [`FillError::CheckFailed`].
pub fn raise(
    contour: &Contour,
    triangulation: &Triangulation,
    heights_m: &[f64],
) -> Result<Filled, FillError> {
    if contour.len() != triangulation.contour_vertices {
        return Err(FillError::Malformed {
            what: "the contour is not the one that was triangulated".to_owned(),
        });
    }
    if heights_m.len() != triangulation.vertices.len() {
        return Err(FillError::Malformed {
            what: "heights and new vertices are not the same number".to_owned(),
        });
    }
    let rim = weld(contour)?;
    let vertices = triangulation.vertices.iter().zip(heights_m).map(|(p, &z)| p.extend(z)).collect();
    let patch = Patch { vertices, triangles: triangulation.triangles.clone() };
    finish(&rim.contour, Lifted { patch, vertical: triangulation.vertical.clone() }, Filler::Delaunay)
}
