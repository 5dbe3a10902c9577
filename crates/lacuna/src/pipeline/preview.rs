//! Small height rasters of the tiles, made while they are in memory, for the hillshades of the report.

use super::solve::Fills;
use crate::report::HeightRaster;
use glam::DVec3;
use lacuna_mesh::{Bounds, TriMesh};
use std::collections::BTreeSet;

/// Pixels of all previews together.
const PIXELS: f64 = 1.5e6;

/// A raster over one tile, its share of the pixels of a scene of `tiles` tiles.
pub(crate) fn tile_preview(mesh: &TriMesh, bounds: &Bounds, tiles: usize) -> HeightRaster {
    let size = bounds.max - bounds.min;
    let area = if bounds.is_empty() { 1.0 } else { size.x * size.y };
    let pixel_m = (area * tiles as f64 / PIXELS).sqrt();
    let mut raster = HeightRaster::new(bounds, pixel_m);
    raster.add_triangles(&mesh.positions, &mesh.triangles);
    raster
}

/// Rasters of the scene before and after the repair, on the same pixels.
pub(crate) fn scene_rasters(
    previews: &[HeightRaster],
    bounds: &Bounds,
    fills: &Fills,
    written: &BTreeSet<u32>,
) -> (HeightRaster, HeightRaster) {
    let mut before = HeightRaster::new(bounds, 0.0);
    for preview in previews {
        for row in 0..preview.size().1 {
            let (positions, triangles) = surface_of(preview, row);
            before.add_triangles(&positions, &triangles);
        }
    }
    let mut after = before.clone();
    for hole in written {
        let Some(Ok(fill)) = fills.get(hole) else { continue };
        let mut positions = fill.rim.clone();
        positions.extend(&fill.patch.vertices);
        after.add_triangles(&positions, &fill.patch.triangles);
    }
    (before, after)
}

/// A row of a preview as squares round its pixels' centres: squares of one height, so that nothing is lost at steps and
/// nothing bridges a hole.
fn surface_of(preview: &HeightRaster, row: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (width, height) = preview.size();
    let [west, south, east, north] = preview.rect();
    let (step_x, step_y) = ((east - west) / width as f64, (north - south) / height as f64);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for column in 0..width {
        let Some(z) = preview.height_at(column, row) else { continue };
        let (x, y) = (west + column as f64 * step_x, north - row as f64 * step_y);
        let first = positions.len() as u32;
        positions.extend([
            DVec3::new(x, y, z),
            DVec3::new(x, y - step_y, z),
            DVec3::new(x + step_x, y - step_y, z),
            DVec3::new(x + step_x, y, z),
        ]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    (positions, triangles)
}
