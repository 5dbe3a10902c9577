//! What a caller may set.

/// Which filler to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillerChoice {
    /// What the contour allows, in this order: plan, best-fit plane, minimum area.
    #[default]
    Auto,
    /// Constrained Delaunay in plan or in the best-fit plane, nothing else.
    Delaunay,
    /// Liepa's minimum-area triangulation of the 3D ring, refined and faired (Wang et al. 2021, sec. 2.1).
    MinArea,
}

/// How the heights of new vertices are found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum HeightRule {
    /// Bi-Laplacian: continues the slopes behind the rim (Wang et al. 2021, eq. 2-4).
    #[default]
    Biharmonic,
    /// Laplacian: a soap film over the rim, never above or below it.
    Harmonic,
}

/// Settings of one fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillParams {
    /// Filler.
    pub filler: FillerChoice,
    /// Largest edge length of the patch, metres; `None`: as the rim says.
    pub spacing_m: Option<f64>,
    /// By how many metres the edge length grows with each metre from the rim. 0 keeps the rim's density (Liepa's
    /// sigma rule, method `layered`); 0.3 is the graded default.
    pub growth: f64,
    /// Upper bound of the graded edge length, metres; `None`: 16 times the contour's median edge.
    pub max_spacing_m: Option<f64>,
    /// Most new vertices a patch may have, on top of the rule `10 n + 1000 + 2.5 area / spacing^2`.
    pub max_vertices: usize,
    /// Most contour vertices for the triangulation in space: its time grows with their cube, its memory with their
    /// square (20 bytes a pair).
    pub largest_ring: usize,
    /// Heights of new vertices.
    pub heights: HeightRule,
    /// How far, as a share of the data's range of heights, a biharmonic surface may leave that range before tension
    /// is added. Infinite: no guard.
    pub overshoot: f64,
}

impl Default for FillParams {
    fn default() -> Self {
        Self {
            filler: FillerChoice::Auto,
            spacing_m: None,
            growth: 0.3,
            max_spacing_m: None,
            max_vertices: 20_000_000,
            largest_ring: 500,
            heights: HeightRule::Biharmonic,
            overshoot: 0.25,
        }
    }
}
