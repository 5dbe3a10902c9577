//! Heights of a scene seen from above, and their hillshade as a PNG.

use lacuna_mesh::Bounds;

/// Most pixels a raster may have.
const MAX_PIXELS: f64 = 1.5e6;

/// Highest z per pixel over a scene's box; row 0 is the north.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightRaster {
    /// Pixels from west to east.
    pub width: usize,
    /// Pixels from north to south.
    pub height: usize,
    /// West edge, metres.
    pub west_m: f64,
    /// North edge, metres.
    pub north_m: f64,
    /// Side of a pixel, metres.
    pub pixel_m: f64,
    /// Row by row; NaN where there is no surface. Metres above `base_m`.
    heights: Vec<f32>,
    /// Height that is subtracted before rounding to f32, metres.
    base_m: f64,
}

impl HeightRaster {
    /// An empty raster over a box, with pixels no smaller than `smallest_pixel_m`, and at most 1.5 million of them.
    /// The same box always gives the same pixels, so that rasters made apart can be merged.
    #[must_use]
    pub fn new(bounds: &Bounds, smallest_pixel_m: f64) -> Self {
        let (x, y) = if bounds.is_empty() {
            (0.0, 0.0)
        } else {
            (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y)
        };
        let pixel_m = smallest_pixel_m.max((x * y / MAX_PIXELS).sqrt()).max(x.max(y) / 16_384.0).max(1e-6);
        let width = ((x / pixel_m).ceil() as usize).max(1);
        let height = ((y / pixel_m).ceil() as usize).max(1);
        let base_m = if bounds.min.z.is_finite() { bounds.min.z } else { 0.0 };
        let (west_m, north_m) = if bounds.is_empty() { (0.0, 0.0) } else { (bounds.min.x, bounds.max.y) };
        Self { width, height, west_m, north_m, pixel_m, heights: vec![f32::NAN; width * height], base_m }
    }
}
