//! The points of closing curves, and of the grid corners between them.

use crate::strip::Strip;
use glam::DVec3;
use lacuna_grid::CornerId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The closing polyline of one stretch of a border.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BorderCurve {
    /// Points strictly between the ends, by growing coordinate along the border, metres. On the border line (with
    /// overrun: on the line of the first cell; each cell moves them to its own line).
    pub inner: Vec<DVec3>,
    /// Height's slope across the border, per inner point, growing with x or y.
    pub slope: Vec<f64>,
    /// Mean distance between neighbouring points, metres.
    pub spacing_m: f64,
    /// What both cells share of their overlap, where tiles overrun their cell.
    pub strip: Strip,
    /// Heights of the strip's points between its two lines, metres, by inner point and line between lanes; a point that is
    /// not here lies on the straight line across.
    pub between_m: BTreeMap<(u32, u32), f64>,
}

/// All curves of a plan, by its curve numbers, and heights of the bare grid corners.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// One for each curve of the plan.
    pub curves: Vec<BorderCurve>,
    /// Position of every grid corner inside a hole where no cell has a vertex.
    pub corners: BTreeMap<CornerId, DVec3>,
    /// Where tiles overrun their cell: the overlap squares that all open cells round a corner share, with the heights of
    /// their corners (south-west, south-east, north-west, north-east), metres.
    pub squares: BTreeMap<CornerId, [f64; 4]>,
}
