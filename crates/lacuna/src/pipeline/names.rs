//! Ids of clusters and holes, made from places and tile names, so that tiles elsewhere rename nothing.

use super::scan::CellTile;
use glam::DVec2;
use lacuna_grid::CellId;
use lacuna_hole::Plan;
use std::collections::BTreeMap;

/// Id and tile of a hole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct HoleName {
    pub(crate) id: String,
    pub(crate) tile: String,
}

/// Ids of all clusters and holes of a plan, by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    pub(crate) clusters: Vec<String>,
    pub(crate) holes: Vec<HoleName>,
}

impl Names {
    /// Names clusters by their rounded centre in SRS coordinates (file coordinates plus `srs_origin`), holes by cluster
    /// and tile. `hollow` names the tiles that will be made.
    pub(crate) fn new(
        plan: &Plan,
        tiles: &BTreeMap<CellId, CellTile>,
        hollow: &BTreeMap<CellId, String>,
        srs_origin: DVec2,
    ) -> Self {
        let mut taken: BTreeMap<String, u32> = BTreeMap::new();
        let mut unique = |name: String| {
            let count = taken.entry(name.clone()).or_default();
            *count += 1;
            if *count == 1 { name } else { format!("{name}_{count}") }
        };
        let clusters: Vec<String> = plan
            .clusters
            .iter()
            .map(|c| {
                let p = (c.centre + srs_origin).round();
                unique(format!("{}_{}", p.x as i64, p.y as i64))
            })
            .collect();
        let tile_of = |cell: &CellId| {
            let named = tiles.get(cell).map(|t| t.name.clone()).or_else(|| hollow.get(cell).cloned());
            named.unwrap_or_else(|| cell.to_string())
        };
        let holes = plan
            .holes
            .iter()
            .map(|h| {
                let tile = tile_of(&h.cell);
                let id = unique(format!("{}/{tile}", clusters[h.cluster as usize]));
                HoleName { id, tile }
            })
            .collect();
        Self { clusters, holes }
    }
}
